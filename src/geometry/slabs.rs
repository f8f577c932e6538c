//! The part of a ray inside a box, so conservative that no box test rejects what a shape's own test accepts.
//!
//! Sources: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (2013), whose origins moved by an error bound
//! are used here; Ize, "Robust BVH Ray Traversal" (2013).
//!
//! The arithmetic is monotonic: with the same ray, the interval of a box contains the interval of every box inside it,
//! bit by bit, also when the inner one was asked with a smaller [`Slabs::new`] `within`. Each shape confines its hits
//! to the interval of its own box ([`Span`]). So a walk that skips boxes by these intervals finds exactly what testing
//! every shape finds, whatever the tree.

use glam::Vec3A;

use super::{Aabb, PreparedRay};

/// A ray prepared for testing boxes that lie in a known region.
///
/// For each axis, with `near` the side of the box that the ray enters through (`min` where `inv_direction` is not
/// negative, else `max`) and `far` the other one, the ray is inside for
/// `(near - near_origin) * inv_direction <= t <= (far - far_origin) * inv_direction`. A NaN (0 times infinity) says
/// nothing and must be dropped: `if t > t_near { t } else { t_near }`.
#[derive(Clone, Copy, Debug)]
pub struct Slabs {
    /// The origin moved along the direction's signs.
    pub near_origin: Vec3A,
    /// The origin moved against the direction's signs.
    pub far_origin: Vec3A,
    pub inv_direction: Vec3A,
}

impl Slabs {
    /// How far the origin is moved, as a share of the largest distance to the boxes along an axis. The triangle test errs
    /// by 6 units of 2^-24, a slab distance by 3; moving the origin loses at most half of the margin to rounding.
    pub const MARGIN: f32 = 1.0 / (1 << 19) as f32;

    /// Prepares `ray` for boxes inside `within`.
    #[inline]
    pub fn new(ray: &PreparedRay, within: &Aabb) -> Self {
        let (origin, inv_direction) = (Vec3A::from(ray.ray.origin), Vec3A::from(ray.inv_direction));
        let (min, max) = (Vec3A::from(within.min), Vec3A::from(within.max));
        let reach = (min - origin).abs().max((max - origin).abs()).max_element();
        // The second term moves by at least one unit in the last place of the origin.
        let margin = Vec3A::splat(reach * Self::MARGIN) + origin.abs() * f32::EPSILON;
        let outwards = margin.copysign(inv_direction);
        Self { near_origin: origin + outwards, far_origin: origin - outwards, inv_direction }
    }

    /// Where the line enters and leaves the box; it misses the box if `enter > leave`.
    #[inline]
    pub fn interval(&self, bounds: &Aabb) -> (f32, f32) {
        let (min, max) = (Vec3A::from(bounds.min), Vec3A::from(bounds.max));
        let inv = self.inv_direction;
        let flipped = inv.cmplt(Vec3A::ZERO);
        let near = (Vec3A::select(flipped, max, min) - self.near_origin) * inv;
        let far = (Vec3A::select(flipped, min, max) - self.far_origin) * inv;
        // Not by min and max, which treat a NaN otherwise on every processor.
        let (nothing, everything) = (Vec3A::NEG_INFINITY, Vec3A::INFINITY);
        let enter = Vec3A::select(near.cmpgt(nothing), near, nothing);
        let leave = Vec3A::select(far.cmplt(everything), far, everything);
        (enter.max_element(), leave.min_element())
    }
}

/// The part of a ray in which a shape's hits may lie: inside the shape's own box, and asked for.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    enter: f32,
    leave: f32,
    t_min: f32,
    t_max: f32,
}

impl Span {
    /// `None` if the ray misses the box, or is inside it only before `t_min` or behind `t_max`.
    #[inline]
    pub fn new(ray: &PreparedRay, own_bounds: &Aabb, t_min: f32, t_max: f32) -> Option<Self> {
        let (enter, leave) = Slabs::new(ray, own_bounds).interval(own_bounds);
        (enter <= leave && enter <= t_max && leave >= t_min).then_some(Self { enter, leave, t_min, t_max })
    }

    /// The hit at `t` as it is reported: in single precision, confined to the box (which changes nothing unless the
    /// ray all but lies in the surface), if it is one that was asked for.
    #[inline]
    pub fn place(&self, t: f64) -> Option<f32> {
        let t = t as f32;
        let t = if t < self.enter {
            self.enter
        } else if t > self.leave {
            self.leave
        } else {
            t
        };
        (t >= self.t_min && t <= self.t_max).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::geometry::Ray;

    fn random_point(rng: &mut Pcg32) -> Vec3 {
        // A coarse grid, so that faces of different boxes and origins coincide.
        Vec3::from_array(std::array::from_fn(|_| rng.random_range(-4..=4) as f32 * 0.3))
    }

    fn random_box(rng: &mut Pcg32) -> Aabb {
        Aabb::from_points([random_point(rng), random_point(rng)])
    }

    #[test]
    fn the_interval_of_a_box_contains_that_of_every_box_inside() {
        let mut rng = Pcg32::seed_from_u64(1);
        for _ in 0..20_000 {
            let inner = random_box(&mut rng);
            let outer = inner.union(random_box(&mut rng));
            let within = outer.union(random_box(&mut rng));
            let ray = PreparedRay::new(Ray::new(random_point(&mut rng), random_point(&mut rng)));
            let (enter, leave) = Slabs::new(&ray, &inner).interval(&inner);
            let (outer_enter, outer_leave) = Slabs::new(&ray, &within).interval(&outer);
            assert!(outer_enter <= enter && leave <= outer_leave, "{ray:?} {inner:?} {outer:?}");
        }
    }

    #[test]
    fn a_ray_through_a_point_of_the_box_never_misses_it() {
        let mut rng = Pcg32::seed_from_u64(2);
        for _ in 0..20_000 {
            let bounds = random_box(&mut rng);
            let share = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0..=4) as f32 * 0.25));
            let target = bounds.min + bounds.extent() * share;
            let origin = random_point(&mut rng);
            let ray = PreparedRay::new(Ray::new(origin, target - origin));
            if target == origin {
                continue;
            }
            let (enter, leave) = Slabs::new(&ray, &bounds).interval(&bounds);
            assert!(enter <= 1.0 && 1.0 <= leave, "{ray:?} {bounds:?} {enter} {leave}");
        }
    }

    #[test]
    fn a_ray_beside_a_box_misses_it_also_along_an_axis() {
        let bounds = Aabb::new(Vec3::ZERO, Vec3::ONE);
        for (origin, direction) in [
            (Vec3::new(0.5, 2.0, -1.0), Vec3::Z),
            (Vec3::new(0.5, -2.0, -1.0), Vec3::Z),
            (Vec3::new(0.5, 2.0, -1.0), Vec3::new(-0.0, -0.0, 1.0)),
            (Vec3::new(3.0, 0.5, -1.0), Vec3::ONE),
        ] {
            let ray = PreparedRay::new(Ray::new(origin, direction));
            let span = Span::new(&ray, &bounds, ray.ray.t_min, ray.ray.t_max);
            assert!(span.is_none_or(|s| s.place(1.0).is_none()), "{origin} {direction}");
        }
    }
}
