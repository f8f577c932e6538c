//! The unbounded plane. It has no box, stays outside every tree, and is tested for each ray.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::rounding::rounded_point;
use super::{PreparedRay, Ray, ShapeHit, SurfacePoint};

/// Points p with `normal . p = offset`; the normal is of unit length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    pub normal: Vec3,
    pub offset: f32,
}

impl Plane {
    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Plane::intersect`] with another interval.
    #[inline]
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        let t = self.crossing(&ray.ray) as f32;
        // A ray along the plane makes t infinite or NaN.
        (t >= t_min && t <= t_max && t.is_finite()).then_some(ShapeHit { t, u: 0.0, v: 0.0 })
    }

    #[inline]
    fn crossing(&self, ray: &Ray) -> f64 {
        let normal = self.normal.as_dvec3();
        (f64::from(self.offset) - normal.dot(ray.origin.as_dvec3())) / normal.dot(ray.direction.as_dvec3())
    }

    /// uv are world coordinates along two fixed tangents, in scene units (for axis-aligned planes: the two other axes
    /// in order).
    pub fn surface(&self, ray: &Ray, _hit: &ShapeHit) -> SurfacePoint {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let point = origin + direction * self.crossing(ray);
        // Back onto the plane, which a distant point has left by the rounding of its distance.
        let normal = self.normal.as_dvec3();
        let point = point - normal * ((normal.dot(point) - f64::from(self.offset)) / normal.length_squared());
        let magnitude = point.abs().max_element() + f64::from(self.offset.abs());
        let (position, error) = rounded_point(point, magnitude);
        let (tangent_u, tangent_v) = self.tangents();
        let uv = Vec2::new(tangent_u.dot(point) as f32, tangent_v.dot(point) as f32);
        SurfacePoint { position, error, normal: self.normal, uv }
    }

    /// The two axes that are not nearest to the normal, in order, laid into the plane.
    fn tangents(&self) -> (DVec3, DVec3) {
        let normal = self.normal.as_dvec3().normalize();
        let a = normal.abs();
        let (first, second) = if a.x >= a.y && a.x >= a.z {
            (DVec3::Y, DVec3::Z)
        } else if a.y >= a.z {
            (DVec3::X, DVec3::Z)
        } else {
            (DVec3::X, DVec3::Y)
        };
        let tangent_u = (first - normal * normal.dot(first)).normalize();
        let second = second - normal * normal.dot(second);
        (tangent_u, (second - tangent_u * tangent_u.dot(second)).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{random_direction, random_vec, rng};
    use super::*;

    #[test]
    fn hits_from_both_sides_and_never_along() {
        let plane = Plane { normal: Vec3::Y, offset: -1.0 };
        let hit = |origin, direction| plane.intersect(&PreparedRay::new(Ray::new(origin, direction)));
        assert_eq!(hit(Vec3::ZERO, Vec3::new(1.0, -0.5, 0.0)).unwrap().t, 2.0);
        assert_eq!(hit(Vec3::new(0.0, -3.0, 0.0), Vec3::Y).unwrap().t, 2.0);
        assert_eq!(hit(Vec3::ZERO, Vec3::Y), None);
        assert_eq!(hit(Vec3::ZERO, Vec3::X), None);
        assert_eq!(hit(Vec3::new(0.0, -1.0, 0.0), Vec3::X), None);
    }

    #[test]
    fn rays_that_leave_never_hit_it_again() {
        let rng = &mut rng(4);
        for _ in 0..5000 {
            let plane = Plane { normal: random_direction(rng), offset: random_vec(rng, 9.0).x };
            let ray = Ray::new(random_vec(rng, 50.0), random_direction(rng));
            let Some(hit) = plane.intersect(&PreparedRay::new(ray)) else { continue };
            let surface = plane.surface(&ray, &hit);
            let distance = f64::from(plane.offset) - plane.normal.as_dvec3().dot(surface.position.as_dvec3());
            assert!(distance.abs() <= f64::from(surface.error.dot(plane.normal.abs())), "{plane:?} {ray:?}");
            let direction = random_direction(rng);
            let leaving = Ray::new(surface.leave(direction), direction);
            assert_eq!(plane.intersect(&PreparedRay::new(leaving)), None, "{plane:?} {leaving:?}");
        }
    }

    #[test]
    fn uv_of_an_axis_aligned_plane_are_the_other_two_coordinates() {
        for (normal, uv) in [
            (Vec3::X, Vec2::new(2.0, 3.0)),
            (Vec3::NEG_Y, Vec2::new(1.0, 3.0)),
            (Vec3::Z, Vec2::new(1.0, 2.0)),
        ] {
            let at = Vec3::new(1.0, 2.0, 3.0);
            let plane = Plane { normal, offset: normal.dot(at) };
            let ray = Ray::new(at + normal, -normal);
            let hit = plane.intersect(&PreparedRay::new(ray)).unwrap();
            assert_eq!(plane.surface(&ray, &hit).uv, uv);
        }
    }
}
