//! A torus around its object's y axis, hit from outside and inside.
//!
//! A ray crosses it where a polynomial of degree four is zero, here over the distance from the ray's nearest point to
//! the centre (which removes the cubic term) in units of the torus' size, all in double precision.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2};
use serde::{Deserialize, Serialize};

use super::roots::roots_in;
use super::rounding::{outward_box, rounded_point};
use super::sampled_area::sampled_area_inside;
use super::slabs::Span;
use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A torus around its object's y axis. Where the tube is wider than the ring, it crosses itself on the axis. One
/// whose tube's radius is not above zero is never hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Torus {
    pub world_from_object: Rigid,
    /// From the centre to the middle of the tube.
    pub major_radius: f32,
    /// Of the tube.
    pub minor_radius: f32,
}

impl Torus {
    /// Major and minor radius.
    fn radii(&self) -> (f64, f64) {
        (f64::from(self.major_radius), f64::from(self.minor_radius))
    }

    pub fn bounds(&self) -> Aabb {
        let world = self.world_from_object.exact();
        let (major, minor) = self.radii();
        let axis = world.y_axis();
        // How far a circle around `axis` reaches along each world axis.
        let ring = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
        let reach = ring * major + DVec3::splat(minor);
        outward_box(world.translation - reach, world.translation + reach)
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Torus::intersect`] with another interval.
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        self.intersect_in(ray, &Span::new(ray, &self.bounds(), t_min, t_max)?)
    }

    /// The hit in a span of the ray that was made for the torus's own box.
    pub fn intersect_in(&self, ray: &PreparedRay, span: &Span) -> Option<ShapeHit> {
        let (major, minor) = self.radii();
        let world = self.world_from_object.exact();
        let size = major + minor;
        let origin = world.inverse_point(ray.ray.origin.as_dvec3()) / size;
        let direction = world.inverse_vector(ray.ray.direction.as_dvec3()) / size;
        let speed = direction.length();
        if !(minor > 0.0 && major >= 0.0 && speed > 0.0) {
            return None;
        }
        let direction = direction / speed;
        let nearest_at = -origin.dot(direction);
        let nearest = origin + direction * nearest_at;
        // The line's part in the sphere of radius 1 around the torus.
        let half_chord_squared = 1.0 - nearest.length_squared();
        if half_chord_squared.is_nan() || half_chord_squared < 0.0 {
            return None;
        }
        // A little longer, so that a root on the outer equator is not cut off by rounding.
        let half_chord = half_chord_squared.sqrt() + 1e-6;
        let quartic = quartic(nearest, direction, major / size, minor / size);
        let roots = roots_in(&quartic, -half_chord, half_chord);
        let t = roots.as_slice().iter().find_map(|s| span.place((s + nearest_at) / speed))?;
        Some(ShapeHit { t, u: 0.0, v: 0.0 })
    }

    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let world = self.world_from_object.exact();
        let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        let point = world.inverse_point(point);
        let (major, _) = self.radii();
        let around = point.z.atan2(point.x);
        // Signed, so that the points of a self-crossing torus beyond the axis keep their circle of the tube.
        let from_axis = point.x.hypot(point.z);
        let across = point.y.atan2(from_axis - major);
        let beyond = point.y.atan2(-from_axis - major);
        let tube_error = |distance: f64| (distance.hypot(point.y) - self.radii().1).abs();
        let (around, across) = if tube_error(-from_axis - major) < tube_error(from_axis - major) {
            (around + PI, beyond)
        } else {
            (around, across)
        };
        let SurfaceSample { position, error, normal, uv } = self.point(around, across);
        SurfacePoint { position, error, normal, uv }
    }

    /// The point at the angle `around` the axis (from +x to +z) and `across` the tube (from outside to up); uv are
    /// these angles in turns.
    fn point(&self, around: f64, across: f64) -> SurfaceSample {
        let world = self.world_from_object.exact();
        let (major, minor) = self.radii();
        let (point, normal) = object_point(major, minor, around, across);
        let magnitude = world.translation.abs().max_element() + major + minor;
        let (position, error) = rounded_point(world.point(point), magnitude);
        let turns = |angle: f64| (angle / TAU).rem_euclid(1.0) as f32;
        let uv = Vec2::new(turns(around), turns(across));
        SurfaceSample { position, error, normal: world.vector(normal).as_vec3(), uv }
    }

    pub fn area(&self) -> f32 {
        let (major, minor) = self.radii();
        (TAU * minor * 2.0 * ring_integral(major, minor, PI)) as f32
    }

    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        let (major, minor) = self.radii();
        // Both halves of the tube are alike: the sign takes one half of the range, the angle is found in the other.
        let folded = 2.0 * f64::from(u.y);
        let (share, sign) = if folded < 1.0 { (folded, 1.0) } else { (folded - 1.0, -1.0) };
        let target = share * ring_integral(major, minor, PI);
        let (mut lo, mut hi) = (0.0, PI);
        for _ in 0..52 {
            let middle = 0.5 * (lo + hi);
            if ring_integral(major, minor, middle) < target {
                lo = middle;
            } else {
                hi = middle;
            }
        }
        self.point(TAU * f64::from(u.x), sign * 0.5 * (lo + hi))
    }

    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        let part = clip.intersection(self.bounds());
        if part.is_empty() { Aabb::EMPTY } else { part }
    }

    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        let world = self.world_from_object.exact();
        let (major, minor) = self.radii();
        sampled_area_inside(&self.bounds(), self.area(), clip, |u, v| {
            let (point, _) = object_point(major, minor, TAU * u, TAU * v);
            (world.point(point), (major + minor * (TAU * v).cos()).abs())
        })
    }
}

/// The polynomial whose roots s put `nearest + s * direction` onto the torus. `direction` is of unit length and at a
/// right angle to `nearest`.
fn quartic(nearest: DVec3, direction: DVec3, major: f64, minor: f64) -> [f64; 5] {
    let from_axis = nearest.x.hypot(nearest.z);
    let k = nearest.length_squared() + (major - minor) * (major + minor);
    let along = nearest.x * direction.x + nearest.z * direction.z;
    let flat = direction.x * direction.x + direction.z * direction.z;
    // k^2 - 4 major^2 from_axis^2 as a product, which a thin tube does not cancel.
    let tube = (from_axis - major).hypot(nearest.y);
    let constant = (tube - minor) * (tube + minor) * (k + 2.0 * major * from_axis);
    [constant, -8.0 * major * major * along, 2.0 * k - 4.0 * major * major * flat, 0.0, 1.0]
}

/// A point of the torus and its outside normal, in object space.
fn object_point(major: f64, minor: f64, around: f64, across: f64) -> (DVec3, DVec3) {
    let (sin_around, cos_around) = around.sin_cos();
    let (sin_across, cos_across) = across.sin_cos();
    let normal = DVec3::new(cos_across * cos_around, sin_across, cos_across * sin_around);
    let ring = DVec3::new(major * cos_around, 0.0, major * sin_around);
    (ring + normal * minor, normal)
}

/// The integral of the distance to the axis, `|major + minor cos(x)|`, from 0 to `across`: the share of the area.
fn ring_integral(major: f64, minor: f64, across: f64) -> f64 {
    let integral = |x: f64| major * x + minor * x.sin();
    // Where a tube wider than the ring reaches the axis.
    let axis_at = if minor > major { (-major / minor).acos() } else { PI };
    if across <= axis_at { integral(across) } else { 2.0 * integral(axis_at) - integral(across) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::Shape;
    use super::super::checks::{check_shape, hit, random_direction, random_placement, random_vec, rng};
    use super::*;

    fn torus(major_radius: f32, minor_radius: f32) -> Torus {
        Torus { world_from_object: Rigid::IDENTITY, major_radius, minor_radius }
    }

    #[test]
    fn what_holds_for_every_shape() {
        check_shape(&Shape::Torus(torus(1.0, 0.25)), true);
        let rng = &mut rng(8);
        for (major_radius, minor_radius) in [(2.0, 0.5), (1.0, 0.9), (3.0, 0.05)] {
            let world_from_object = random_placement(rng);
            check_shape(&Shape::Torus(Torus { world_from_object, major_radius, minor_radius }), true);
        }
    }

    #[test]
    fn a_ray_through_the_middle_meets_it_four_times() {
        let torus = Shape::Torus(torus(2.0, 0.5));
        let ray = PreparedRay::new(Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X));
        let (mut found, mut t_min) = (Vec::new(), 0.0);
        while let Some(hit) = torus.intersect_within(&ray, t_min, f32::MAX) {
            found.push(hit.t);
            t_min = hit.t.next_up();
        }
        assert_eq!(found, [2.5, 3.5, 6.5, 7.5]);
    }

    #[test]
    fn hits_from_inside_the_tube_and_misses_through_the_hole() {
        let torus = Shape::Torus(torus(2.0, 0.5));
        assert_eq!(hit(&torus, Vec3::new(2.0, 0.0, 0.0), Vec3::Y).unwrap().t, 0.5);
        assert_eq!(hit(&torus, Vec3::new(0.0, 5.0, 0.0), Vec3::NEG_Y), None);
        assert_eq!(hit(&torus, Vec3::new(1.4, 5.0, 0.0), Vec3::NEG_Y), None);
        assert_eq!(hit(&torus, Vec3::new(2.0, 5.0, 0.0), Vec3::NEG_Y * 2.0).unwrap().t, 2.25);
    }

    /// The implicit form of the surface, walked in small steps, finds the same first hit.
    #[test]
    fn agrees_with_walking_along_the_ray() {
        let shape = torus(1.0, 0.3);
        let outside = |p: DVec3| (p.x.hypot(p.z) - 1.0).hypot(p.y) - f64::from(shape.minor_radius);
        let rng = &mut rng(9);
        for _ in 0..400 {
            let ray = Ray::new(random_direction(rng) * 3.0, random_direction(rng));
            let ray = Ray { direction: (random_vec(rng, 1.0) - ray.origin).normalize(), ..ray };
            let at = |t: f64| outside(ray.origin.as_dvec3() + ray.direction.as_dvec3() * t);
            let step = 1e-3;
            let walked = (0..6000).map(|i| f64::from(i) * step).find(|&t| at(t) > 0.0 && at(t + step) <= 0.0);
            let found = shape.intersect(&PreparedRay::new(ray)).map(|hit| f64::from(hit.t));
            match (walked, found) {
                (Some(t), Some(f)) => assert!(f <= t + step + 1e-6, "{ray:?} {t} {f}"),
                // The walk may step over a grazing hit.
                (None, Some(f)) => assert!(at(f).abs() < 1e-5, "{ray:?} {f}"),
                (Some(t), None) => panic!("{ray:?} misses the hit at {t}"),
                (None, None) => {}
            }
        }
    }

    #[test]
    fn area_of_a_ring_and_of_one_that_crosses_itself() {
        assert!((torus(2.0, 0.5).area() - (TAU * TAU) as f32).abs() < 1e-4);
        // Without a ring it is a sphere, covered twice.
        assert!((torus(0.0, 1.0).area() - 2.0 * (2.0 * TAU) as f32).abs() < 1e-4);
    }

    #[test]
    fn one_without_a_tube_is_never_hit() {
        for minor in [0.0, -0.5, f32::NAN] {
            assert_eq!(hit(&Shape::Torus(torus(1.0, minor)), Vec3::new(1.0, 3.0, 0.0), Vec3::NEG_Y), None);
        }
    }
}
