//! A sphere.
//!
//! The quadratic is solved as in Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection"
//! (Ray Tracing Gems, 2019), in double precision.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::rounding::{outward_box, rounded_point};
use super::sampled_area::sampled_area_inside;
use super::slabs::Span;
use super::{Aabb, PreparedRay, Ray, ShapeHit, SurfacePoint, SurfaceSample};

/// A sphere. One whose radius is not above zero is never hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    pub center: Vec3,
    pub radius: f32,
}

impl Sphere {
    pub fn bounds(&self) -> Aabb {
        let (center, radius) = (self.center.as_dvec3(), DVec3::splat(f64::from(self.radius)));
        outward_box(center - radius, center + radius)
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Sphere::intersect`] with another interval.
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        self.intersect_in(ray, &Span::new(ray, &self.bounds(), t_min, t_max)?)
    }

    /// The hit in a span of the ray that was made for the sphere's own box.
    pub fn intersect_in(&self, ray: &PreparedRay, span: &Span) -> Option<ShapeHit> {
        let [near, far] = self.crossings(&ray.ray)?;
        let t = span.place(near).or_else(|| span.place(far))?;
        Some(ShapeHit { t, u: 0.0, v: 0.0 })
    }

    /// Where the line through the ray enters and leaves.
    #[inline]
    fn crossings(&self, ray: &Ray) -> Option<[f64; 2]> {
        let (direction, radius) = (ray.direction.as_dvec3(), f64::from(self.radius));
        let from_center = ray.origin.as_dvec3() - self.center.as_dvec3();
        let a = direction.length_squared();
        let b = -from_center.dot(direction);
        // The line's nearest point to the centre tells whether it hits without cancellation.
        let nearest = from_center + direction * (b / a);
        let discriminant = radius * radius - nearest.length_squared();
        if !(discriminant >= 0.0 && radius > 0.0) {
            return None;
        }
        let q = b + (a * discriminant).sqrt().copysign(b);
        if q == 0.0 {
            return Some([0.0, 0.0]);
        }
        let distance = from_center.length();
        let c = (distance - radius) * (distance + radius);
        let (t0, t1) = (c / q, q / a);
        Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
    }

    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        let normal = (point - self.center.as_dvec3()).normalize_or(DVec3::Y);
        let (position, error) = self.point(normal);
        SurfacePoint { position, error, normal: normal.as_vec3(), uv: Self::uv(normal) }
    }

    /// The point in the direction `normal` from the centre, and its error bound.
    fn point(&self, normal: DVec3) -> (Vec3, Vec3) {
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius));
        rounded_point(center + normal * radius, center.abs().max_element() + radius)
    }

    /// u goes once around the y axis from +x over +z, v from the south pole to the north pole; both in `0..=1`.
    fn uv(normal: DVec3) -> Vec2 {
        let turn = normal.z.atan2(normal.x) / TAU;
        let u = if turn < 0.0 { turn + 1.0 } else { turn };
        Vec2::new(u as f32, (normal.y.clamp(-1.0, 1.0).asin() / PI + 0.5) as f32)
    }

    /// The unit vector that `u` and `v` in the unit square stand for, uniform over the sphere.
    fn direction(u: f64, v: f64) -> DVec3 {
        let y = 2.0 * v - 1.0;
        let ring = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = (TAU * u).sin_cos();
        DVec3::new(ring * cos, y, ring * sin)
    }

    pub fn area(&self) -> f32 {
        (2.0 * TAU * f64::from(self.radius) * f64::from(self.radius)) as f32
    }

    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        let normal = Self::direction(f64::from(u.x), f64::from(u.y));
        let (position, error) = self.point(normal);
        SurfaceSample { position, error, normal: normal.as_vec3(), uv: Self::uv(normal) }
    }

    /// Tight along each axis where the clip's other two sides leave less of the sphere; empty for a clip that lies
    /// wholly inside or outside of it.
    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        let part = clip.intersection(self.bounds());
        if part.is_empty() {
            return Aabb::EMPTY;
        }
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius));
        let (min, max) = (part.min.as_dvec3() - center, part.max.as_dvec3() - center);
        let nearest = DVec3::ZERO.clamp(min, max);
        let farthest = min.abs().max(max.abs());
        // A little wider than the sphere, so that rounding never loses a touching point.
        let radius_squared = radius * radius * (1.0 + 1e-12);
        if nearest.length_squared() > radius_squared
            || farthest.length_squared() < radius * radius * (1.0 - 1e-12)
        {
            return Aabb::EMPTY;
        }
        let off_axis = DVec3::splat(nearest.length_squared()) - nearest * nearest;
        let half = (DVec3::splat(radius_squared) - off_axis).max(DVec3::ZERO).map(f64::sqrt);
        part.intersection(outward_box(center - half, center + half))
    }

    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius));
        sampled_area_inside(&self.bounds(), self.area(), clip, |u, v| {
            (center + Self::direction(u, v) * radius, 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::super::checks::{check_shape, hit};
    use super::*;

    #[test]
    fn what_holds_for_every_shape() {
        for (center, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(3.0, -2.0, 0.5), 0.3), (Vec3::splat(9.0), 8.0)]
        {
            check_shape(&Shape::Sphere(Sphere { center, radius }), true);
        }
    }

    #[test]
    fn hits_from_outside_inside_and_behind() {
        let sphere = Shape::Sphere(Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 2.0 });
        assert_eq!(hit(&sphere, Vec3::ZERO, Vec3::Z).unwrap().t, 3.0);
        assert_eq!(hit(&sphere, Vec3::new(0.0, 0.0, 5.0), Vec3::Z).unwrap().t, 2.0);
        assert_eq!(hit(&sphere, Vec3::new(0.0, 0.0, 9.0), Vec3::Z), None);
        assert_eq!(hit(&sphere, Vec3::new(2.1, 0.0, 0.0), Vec3::Z), None);
        // Direction of any length: t is in units of it.
        assert_eq!(hit(&sphere, Vec3::ZERO, Vec3::Z * 0.5).unwrap().t, 6.0);
    }

    #[test]
    fn a_small_sphere_far_away_is_hit_where_it_is() {
        let sphere = Shape::Sphere(Sphere { center: Vec3::new(0.0, 0.0, 1e5), radius: 0.01 });
        assert!(hit(&sphere, Vec3::new(0.009, 0.0, 0.0), Vec3::Z).is_some());
        assert!(hit(&sphere, Vec3::new(0.011, 0.0, 0.0), Vec3::Z).is_none());
    }

    #[test]
    fn a_sphere_without_radius_is_never_hit() {
        for radius in [0.0, -1.0, f32::NAN] {
            let sphere = Shape::Sphere(Sphere { center: Vec3::Z, radius });
            assert_eq!(hit(&sphere, Vec3::ZERO, Vec3::Z), None);
        }
    }

    #[test]
    fn uv_runs_around_and_from_pole_to_pole() {
        assert_eq!(Sphere::uv(DVec3::X), Vec2::new(0.0, 0.5));
        assert_eq!(Sphere::uv(DVec3::Z), Vec2::new(0.25, 0.5));
        assert_eq!(Sphere::uv(DVec3::NEG_Z), Vec2::new(0.75, 0.5));
        assert_eq!((Sphere::uv(DVec3::Y).y, Sphere::uv(DVec3::NEG_Y).y), (1.0, 0.0));
    }

    #[test]
    fn a_clip_inside_the_sphere_holds_nothing_and_a_cap_is_tight() {
        let sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };
        assert_eq!(sphere.clipped_bounds(&Aabb::new(Vec3::splat(-0.5), Vec3::splat(0.5))), Aabb::EMPTY);
        assert_eq!(sphere.clipped_bounds(&Aabb::new(Vec3::splat(0.9), Vec3::splat(1.5))), Aabb::EMPTY);
        let cap = sphere.clipped_bounds(&Aabb::new(Vec3::new(-2.0, 0.8, -2.0), Vec3::splat(2.0)));
        assert!((cap.max.x - 0.6).abs() < 1e-6 && (cap.min.z + 0.6).abs() < 1e-6, "{cap:?}");
    }
}
