//! The rays of a packet as structure of arrays, and the tests of a box against all of them.

use bytemuck::Zeroable;
use fearless_simd::{Simd, f32x4, f32x8, f64x4, mask32x8, prelude::*};

use crate::accel::simd::{greater_or, less_or};
use crate::geometry::{Aabb, PreparedRay, Ray, Slabs};

use super::super::boxes::{SideRows, TreeRay};
use super::rays::{GROUP, GROUPS, Lanes, PACKET, Rays};

/// The rays of a packet as structure of arrays, with what box and triangle tests need of them.
#[derive(Clone, Debug)]
pub struct PacketLanes {
    origin: [Lanes; 3],
    direction: [Lanes; 3],
    near_origin: [Lanes; 3],
    far_origin: [Lanes; 3],
    inv_direction: [Lanes; 3],
    t_min: Lanes,
    /// The end of each ray.
    t_max: Lanes,
    /// Where each ray enters the tree's box.
    entry: Lanes,
    /// Of the rays of one class: [`PreparedRay::shear`].
    shear: [Lanes; 2],
    /// [`PreparedRay::k`] of the class.
    k: [usize; 3],
    near_side: [usize; 3],
    far_side: [usize; 3],
}

impl Default for PacketLanes {
    fn default() -> Self {
        Self {
            origin: [Lanes::ZERO; 3],
            direction: [Lanes::ZERO; 3],
            near_origin: [Lanes::ZERO; 3],
            far_origin: [Lanes::ZERO; 3],
            inv_direction: [Lanes::ZERO; 3],
            t_min: Lanes::ZERO,
            t_max: Lanes::ZERO,
            entry: Lanes::ZERO,
            shear: [Lanes::ZERO; 2],
            k: [0; 3],
            near_side: [0; 3],
            far_side: [0; 3],
        }
    }
}

/// What tells which rays of a packet may walk together: those that agree in all of it. A bit a ray.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Classes {
    /// Rays that meet the root's box.
    pub inside: Rays,
    /// Rays with a finite inverse direction and a start that is not negative.
    pub regular: Rays,
    flipped: [Rays; 3],
    /// Whether x, else y, is the largest component of the direction.
    is_x: Rays,
    is_y: Rays,
}

impl PacketLanes {
    /// A ray of the packet.
    #[inline]
    pub fn ray(&self, ray: usize) -> Ray {
        let vector = |v: &[Lanes; 3]| glam::Vec3::new(v[0].get(ray), v[1].get(ray), v[2].get(ray));
        Ray {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            t_min: self.t_min.get(ray),
            t_max: self.t_max.get(ray),
        }
    }

    /// What it needs to walk alone.
    #[inline(always)]
    pub(super) fn tree_ray(&self, ray: usize) -> TreeRay {
        let all = |v: &[Lanes; 3]| [v[0].get(ray), v[1].get(ray), v[2].get(ray)];
        let flipped = [0, 1, 2].map(|axis| usize::from(self.near_side[axis] != axis) << axis);
        TreeRay::from_parts(
            all(&self.near_origin),
            all(&self.far_origin),
            all(&self.inv_direction),
            self.t_min.get(ray),
            flipped[0] | flipped[1] | flipped[2],
        )
    }

    #[inline]
    pub fn prepared(&self, ray: usize) -> PreparedRay {
        PreparedRay::new(self.ray(ray))
    }

    /// Of four rays from `first`, a multiple of four, on.
    #[inline(always)]
    pub fn origin_in_double<S: Simd>(&self, simd: S, first: usize) -> [f64x4<S>; 3] {
        let [x, y, z] = &self.origin;
        [x.in_double(simd, first), y.in_double(simd, first), z.in_double(simd, first)]
    }

    /// Of four rays from `first`, a multiple of four, on.
    #[inline(always)]
    pub fn direction_in_double<S: Simd>(&self, simd: S, first: usize) -> [f64x4<S>; 3] {
        let [x, y, z] = &self.direction;
        [x.in_double(simd, first), y.in_double(simd, first), z.in_double(simd, first)]
    }

    /// Where the rays of a group enter and leave a box of their own: the arithmetic of
    /// [`Span`](crate::geometry::Span), before it looks at the interval that is asked for.
    #[inline(always)]
    pub fn span<S: Simd>(&self, simd: S, group: usize, bounds: &Aabb) -> [f32x8<S>; 2] {
        let spread = |value: f32| f32x8::simd_from(simd, value);
        let origin = [0, 1, 2].map(
            #[inline(always)]
            |axis| self.origin[axis].load(simd, group),
        );
        let reach = reach(simd, bounds, &origin);
        let (mut enter, mut leave) = (spread(f32::NEG_INFINITY), spread(f32::INFINITY));
        for (axis, &origin) in origin.iter().enumerate() {
            let inv = self.inv_direction[axis].load(simd, group);
            let margin = reach * spread(Slabs::MARGIN) + origin.abs() * spread(f32::EPSILON);
            let outwards = margin.copysign(inv);
            let sides = [bounds.min[axis], bounds.max[axis]];
            let flipped = usize::from(self.near_side[axis] != axis);
            enter = greater_or(simd, (spread(sides[flipped]) - (origin + outwards)) * inv, enter);
            leave = less_or(simd, (spread(sides[1 - flipped]) - (origin - outwards)) * inv, leave);
        }
        [enter, leave]
    }

    /// Which axes of the world are the x, y and z of [`PacketLanes::permuted_origin`].
    #[inline(always)]
    pub fn axes(&self) -> [usize; 3] {
        self.k
    }

    #[inline(always)]
    pub fn permuted_origin<S: Simd>(&self, simd: S, group: usize) -> [f32x8<S>; 3] {
        let [x, y, z] = self.k;
        [
            self.origin[x % 3].load(simd, group),
            self.origin[y % 3].load(simd, group),
            self.origin[z % 3].load(simd, group),
        ]
    }

    /// [`PreparedRay::shear`].
    #[inline(always)]
    pub fn shear<S: Simd>(&self, simd: S, group: usize) -> [f32x8<S>; 3] {
        let inv_z = &self.inv_direction[self.k[2] % 3];
        [self.shear[0].load(simd, group), self.shear[1].load(simd, group), inv_z.load(simd, group)]
    }

    #[inline(always)]
    pub fn t_min<S: Simd>(&self, simd: S, group: usize) -> f32x8<S> {
        self.t_min.load(simd, group)
    }

    #[inline(always)]
    pub fn t_max(&self) -> &Lanes {
        &self.t_max
    }

    /// Takes up to [`PACKET`] rays that will walk a tree with these bounds. The arithmetic is that of
    /// [`TreeRay`](super::boxes::TreeRay).
    #[inline(always)]
    pub(super) fn take<S: Simd>(&mut self, simd: S, rays: &[Ray], bounds: &Aabb) -> Classes {
        for (group, rays) in rays.chunks(GROUP).enumerate().take(GROUPS) {
            let mut padded = [Ray::zeroed(); GROUP];
            let rays = match <&[Ray; GROUP]>::try_from(rays) {
                Ok(rays) => rays,
                Err(_) => {
                    padded[..rays.len()].copy_from_slice(rays);
                    &padded
                }
            };
            let [x, y, z, dx, dy, dz, t_min, t_max] = transposed(simd, bytemuck::cast_ref(rays));
            for (lanes, values) in self.origin.iter_mut().zip([x, y, z]) {
                lanes.store(group, values);
            }
            for (lanes, values) in self.direction.iter_mut().zip([dx, dy, dz]) {
                lanes.store(group, values);
            }
            self.t_min.store(group, t_min);
            // As in [`Ray::last`].
            self.t_max.store(group, less_or(simd, t_max, f32x8::simd_from(simd, f32::MAX)));
        }
        let spread = |value: f32| f32x8::simd_from(simd, value);
        let (zero, one) = (spread(0.0), spread(1.0));
        let mut classes = Classes::default();
        for group in 0..rays.len().min(PACKET).div_ceil(GROUP) {
            let note = |rays: &mut Rays, mask: mask32x8<S>| {
                *rays = rays.or(Rays::in_group(group, mask.to_bitmask() as u32));
            };
            let origin = [0, 1, 2].map(
                #[inline(always)]
                |axis| self.origin[axis].load(simd, group),
            );
            let direction = [0, 1, 2].map(
                #[inline(always)]
                |axis| self.direction[axis].load(simd, group),
            );
            let reach = reach(simd, bounds, &origin);
            let t_min = self.t_min.load(simd, group);
            let (mut near, mut far) = (t_min, self.t_max.load(simd, group));
            let mut regular = t_min.simd_ge(zero);
            for axis in 0..3 {
                let (min, max) = (spread(bounds.min[axis]), spread(bounds.max[axis]));
                let inv = one / direction[axis];
                let margin = reach * spread(Slabs::MARGIN) + origin[axis].abs() * spread(f32::EPSILON);
                let outwards = margin.copysign(inv);
                let (near_origin, far_origin) = (origin[axis] + outwards, origin[axis] - outwards);
                let flipped = inv.simd_lt(zero);
                near = greater_or(simd, (flipped.select(max, min) - near_origin) * inv, near);
                far = less_or(simd, (flipped.select(min, max) - far_origin) * inv, far);
                regular = regular
                    & inv.abs().simd_gt(zero)
                    & inv.abs().simd_le(spread(f32::MAX))
                    & near_origin.abs().simd_le(spread(f32::MAX));
                note(&mut classes.flipped[axis], flipped);
                self.near_origin[axis].store(group, near_origin);
                self.far_origin[axis].store(group, far_origin);
                self.inv_direction[axis].store(group, inv);
            }
            note(&mut classes.inside, near.simd_le(far));
            self.entry.store(group, near);
            note(&mut classes.regular, regular);
            let [x, y, z] = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
            note(&mut classes.is_x, x.simd_ge(y) & x.simd_ge(z));
            note(&mut classes.is_y, y.simd_ge(z));
        }
        classes.inside = classes.inside.and(Rays::first(rays.len()));
        classes
    }

    /// Which of `rays` enter the tree's box before these ends.
    #[inline(always)]
    pub(super) fn reaching<S: Simd>(&self, simd: S, rays: Rays, t_max: &Lanes) -> Rays {
        rays.that(
            #[inline(always)]
            |group| self.entry.load(simd, group).simd_le(t_max.load(simd, group)).to_bitmask() as u32,
        )
    }

    /// Makes the rays that are like the first of `rays` ready to walk together; answers which.
    #[inline(always)]
    pub(super) fn prepare<S: Simd>(&mut self, simd: S, classes: &Classes, rays: Rays) -> Rays {
        let Some(first) = rays.lowest() else { return rays };
        let Classes { flipped, is_x, is_y, .. } = *classes;
        let like_first =
            |alike: Rays, of: Rays| if of.has(first) { alike.and(of) } else { alike.without(of) };
        let mut alike = [flipped[0], flipped[1], flipped[2], is_x].into_iter().fold(rays, like_first);
        if !is_x.has(first) {
            alike = like_first(alike, is_y);
        }
        self.k = PreparedRay::new(self.ray(first)).k;
        for (axis, flipped) in flipped.into_iter().enumerate() {
            let side = if flipped.has(first) { 3 } else { 0 };
            (self.near_side[axis], self.far_side[axis]) = (axis + side, axis + 3 - side);
        }
        let [x, y, z] = self.k;
        for (group, _) in alike.groups() {
            let inv_z = self.inv_direction[z].load(simd, group);
            self.shear[0].store(group, self.direction[x].load(simd, group) * inv_z);
            self.shear[1].store(group, self.direction[y].load(simd, group) * inv_z);
        }
        alike
    }

    /// Bounds of the rays, which are all of one class and regular.
    #[inline(always)]
    pub(super) fn interval<S: Simd>(&self, simd: S, rays: Rays) -> Interval {
        let (mut near_origin, mut far_origin, mut inv_direction) = ([0.0; 3], [0.0; 3], [[0.0; 2]; 3]);
        for axis in 0..3 {
            let [near_least, near_most] = self.near_origin[axis].bounds(simd, rays);
            let [far_least, far_most] = self.far_origin[axis].bounds(simd, rays);
            let flipped = self.near_side[axis] != axis;
            near_origin[axis] = if flipped { near_least } else { near_most };
            far_origin[axis] = if flipped { far_most } else { far_least };
            inv_direction[axis] = self.inv_direction[axis].bounds(simd, rays);
        }
        Interval {
            near_origin,
            far_origin,
            inv_direction,
            t_min: self.t_min.bounds(simd, rays)[0],
            near_side: self.near_side,
            far_side: self.far_side,
        }
    }

    /// Which of `rays` enter a box with these sides, minima first, before their end, and where.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(
        &self,
        simd: S,
        sides: &[f32; 6],
        rays: Rays,
        t_max: &Lanes,
        entries: &mut Lanes,
    ) -> Rays {
        let side = |row: usize| f32x8::simd_from(simd, sides[row % 6]);
        let near_side = [side(self.near_side[0]), side(self.near_side[1]), side(self.near_side[2])];
        let far_side = [side(self.far_side[0]), side(self.far_side[1]), side(self.far_side[2])];
        rays.that(
            #[inline(always)]
            |group| {
                let mut near = self.t_min.load(simd, group);
                let mut far = t_max.load(simd, group);
                for axis in 0..3 {
                    let inv = self.inv_direction[axis].load(simd, group);
                    let origin = self.near_origin[axis].load(simd, group);
                    near = greater_or(simd, (near_side[axis] - origin) * inv, near);
                    let origin = self.far_origin[axis].load(simd, group);
                    far = less_or(simd, (far_side[axis] - origin) * inv, far);
                }
                entries.store(group, near);
                near.simd_le(far).to_bitmask() as u32
            },
        )
    }
}

/// The largest distance of each origin to the sides of a box, along an axis.
#[inline(always)]
fn reach<S: Simd>(simd: S, bounds: &Aabb, origin: &[f32x8<S>; 3]) -> f32x8<S> {
    let spread = |value: f32| f32x8::simd_from(simd, value);
    let mut reach = spread(0.0);
    for (axis, &origin) in origin.iter().enumerate() {
        let (min, max) = (spread(bounds.min[axis]), spread(bounds.max[axis]));
        reach = reach.max((min - origin).abs().max((max - origin).abs()));
    }
    reach
}

/// Column i of eight rows as vector i.
#[inline(always)]
fn transposed<S: Simd>(simd: S, rows: &[[f32; GROUP]; GROUP]) -> [f32x8<S>; GROUP] {
    let mut v = [f32x8::simd_from(simd, 0.0); GROUP];
    for (v, row) in v.iter_mut().zip(rows) {
        *v = f32x8::load_array_ref(simd, row);
    }
    // Three perfect shuffles of all 64 numbers.
    for _ in 0..3 {
        let [a, b, c, d, e, f, g, h] = v;
        v = [
            a.zip_low(e),
            a.zip_high(e),
            b.zip_low(f),
            b.zip_high(f),
            c.zip_low(g),
            c.zip_high(g),
            d.zip_low(h),
            d.zip_high(h),
        ];
    }
    v
}

/// Bounds of the rays of a packet, for boxes that none of them can meet.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Of the origins those that make a ray enter earliest and leave latest.
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inv_direction: [[f32; 2]; 3],
    t_min: f32,
    near_side: [usize; 3],
    far_side: [usize; 3],
}

impl Interval {
    /// The slots whose boxes a ray may meet before `t_max`. Rounding is monotonic, so no ray's own entry is less than what
    /// is computed here, and no exit greater.
    #[inline(always)]
    pub fn enter<S: Simd, V, const N: usize>(
        &self,
        simd: S,
        sides: &impl SideRows<S, V>,
        t_max: f32,
    ) -> (u32, [f32; N])
    where
        V: SimdFloat<S, Element = f32, Array = [f32; N]>,
    {
        let spread = |value: f32| V::simd_from(simd, value);
        let (mut near, mut far) = (spread(self.t_min), spread(t_max));
        for axis in 0..3 {
            let [low, high] = self.inv_direction[axis];
            let (low, high) = (spread(low), spread(high));
            let side = sides.row(simd, axis, self.near_side[axis] % 6) - spread(self.near_origin[axis]);
            near = near.max((side * low).min(side * high));
            let side = sides.row(simd, axis, self.far_side[axis] % 6) - spread(self.far_origin[axis]);
            far = far.min((side * low).max(side * high));
        }
        (near.simd_le(far).to_bitmask() as u32, near.to_array())
    }

    /// The same for two boxes, which are no vector.
    #[inline(always)]
    pub fn enter_pair<S: Simd>(&self, simd: S, sides: &[[f32; 2]; 6], t_max: f32) -> (u32, [f32; 2]) {
        let four = [0, 1, 2, 3, 4, 5].map(|row: usize| {
            let [a, b] = sides[row];
            [a, b, a, b]
        });
        let (slots, [a, b, _, _]) = self.enter::<S, f32x4<S>, 4>(simd, &four, t_max);
        (slots & 0b11, [a, b])
    }
}
