//! A box in one SIMD register, for the passes over references and bins.

use fearless_simd::{Simd, f32x4, f32x8, prelude::*};
use glam::{Mat3A, Vec3, Vec3A, Vec4};

use crate::accel::config::Block;
use crate::geometry::Aabb;

/// What references count as in a split cost ([`Block`]). Exact: the sizes of blocks are powers of two.
#[derive(Clone, Copy, Debug)]
pub struct BlockCount {
    share: f32,
    rest: f32,
}

impl BlockCount {
    #[inline]
    pub fn new(block: Block) -> Self {
        let share = 1.0 / block.get() as f32;
        Self { share, rest: 1.0 - share }
    }

    #[inline(always)]
    pub fn of(self, references: f32) -> f32 {
        (references * self.share + self.rest).floor()
    }

    #[inline(always)]
    pub fn of_lanes<S: Simd>(self, references: f32x4<S>) -> f32x4<S> {
        (references * self.share + self.rest).floor()
    }
}

/// A box as its lower corner and, negated, its upper one, so that a union is one minimum. The fourth lane of each corner
/// means nothing here.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bound {
    lanes: [f32; 8],
}

impl Bound {
    pub const EMPTY: Self = Self { lanes: [f32::INFINITY; 8] };

    /// `spare` is kept in the last lane.
    #[inline(always)]
    pub fn new(bounds: &Aabb, spare: f32) -> Self {
        let Aabb { min, max } = bounds;
        Self { lanes: [min.x, min.y, min.z, 0.0, -max.x, -max.y, -max.z, spare] }
    }

    #[inline(always)]
    pub fn spare(&self) -> f32 {
        self.lanes[7]
    }

    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.lanes)
    }

    #[inline(always)]
    pub fn store<S: Simd>(v: f32x8<S>) -> Self {
        Self { lanes: v.to_array() }
    }

    #[inline(always)]
    fn corners(&self) -> [Vec4; 2] {
        let [a, b, c, d, e, f, g, h] = self.lanes;
        [Vec4::new(a, b, c, d), Vec4::new(e, f, g, h)]
    }

    #[inline(always)]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.corners(), other.corners());
        let ([a, b, c, d], [e, f, g, h]) = (a.min(c).to_array(), b.min(d).to_array());
        Self { lanes: [a, b, c, d, e, f, g, h] }
    }

    /// As [`Aabb::half_area`], bit for bit.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [min, neg_max] = self.corners();
        // Negative extents: the signs cancel.
        let e = (min + neg_max).min(Vec4::ZERO);
        e.x * (e.y + e.z) + e.y * e.z
    }

    #[inline]
    pub fn aabb(&self) -> Aabb {
        let [ax, ay, az, _, bx, by, bz, _] = self.lanes;
        Aabb { min: Vec3::new(ax, ay, az), max: -Vec3::new(bx, by, bz) }
    }
}

impl From<Aabb> for Bound {
    #[inline(always)]
    fn from(aabb: Aabb) -> Self {
        Self::new(&aabb, 0.0)
    }
}

/// [`Aabb::center`], bit for bit.
#[inline(always)]
pub fn center<S: Simd>(bound: f32x8<S>) -> f32x4<S> {
    let (min, neg_max) = (bound * 0.5).split();
    min - neg_max
}

/// [`Bound::half_area`] of three boxes, a lane each. Infinite for [`Bound::EMPTY`].
#[inline(always)]
pub fn half_areas<S: Simd>(bounds: &[f32x8<S>; 3]) -> f32x4<S> {
    let simd = bounds[0].simd;
    let [a, b, c] = [neg_extent(bounds[0]), neg_extent(bounds[1]), neg_extent(bounds[2])];
    // The signs cancel.
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = Mat3A::from_cols(a, b, c).transpose();
    let areas = x * (y + z) + y * z;
    f32x4::load_array(simd, areas.extend(0.0).to_array())
}

#[inline(always)]
fn neg_extent<S: Simd>(bound: f32x8<S>) -> Vec3A {
    let (min, neg_max) = bound.split();
    Vec3A::from_vec4(Vec4::from_array((min + neg_max).to_array()))
}
