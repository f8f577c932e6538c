//! Sets of the rays of a packet, and a number of each of them.

use fearless_simd::{Simd, f32x8, f64x4, mask32x8, prelude::*};

/// Rays in a packet, at most.
pub const PACKET: usize = 64;
/// Rays tested at once.
pub const GROUP: usize = 8;
pub(super) const GROUPS: usize = PACKET / GROUP;

/// A number of each ray of a packet.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Lanes([[f32; GROUP]; GROUPS]);

impl Lanes {
    pub const ZERO: Self = Self([[0.0; GROUP]; GROUPS]);

    #[inline(always)]
    pub fn get(&self, ray: usize) -> f32 {
        self.0[ray / GROUP % GROUPS][ray % GROUP]
    }

    #[inline(always)]
    pub fn set(&mut self, ray: usize, value: f32) {
        self.0[ray / GROUP % GROUPS][ray % GROUP] = value;
    }

    /// The numbers of four rays from `first`, a multiple of four, on.
    #[inline(always)]
    pub fn in_double<S: Simd>(&self, simd: S, first: usize) -> f64x4<S> {
        let [a, b, c, d, e, f, g, h] = self.0[first / GROUP % GROUPS];
        let four = if first.is_multiple_of(GROUP) { [a, b, c, d] } else { [e, f, g, h] };
        let [a, b, c, d] = four;
        f64x4::load_array(simd, [f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
    }

    /// The numbers of a group.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, group: usize) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.0[group])
    }

    #[inline(always)]
    pub fn store<S: Simd>(&mut self, group: usize, values: f32x8<S>) {
        self.0[group] = values.to_array();
    }

    /// The least and the most, over some rays.
    #[inline(always)]
    pub fn bounds<S: Simd>(&self, simd: S, rays: Rays) -> [f32; 2] {
        let ends = [f32x8::simd_from(simd, f32::INFINITY), f32x8::simd_from(simd, f32::NEG_INFINITY)];
        let [mut least, mut most] = ends;
        for (group, asked) in rays.groups() {
            let asked = mask32x8::from_bitmask(simd, u64::from(asked));
            let values = self.load(simd, group);
            least = asked.select(values, ends[0]).min(least);
            most = asked.select(values, ends[1]).max(most);
        }
        let (least, most) = (least.to_array(), most.to_array());
        [least.into_iter().fold(f32::INFINITY, f32::min), most.into_iter().fold(f32::NEG_INFINITY, f32::max)]
    }

    /// Replaces the numbers of the rays of `mask`, a bit a ray of the group.
    #[inline(always)]
    pub fn blend<S: Simd>(&mut self, group: usize, mask: mask32x8<S>, values: f32x8<S>, simd: S) {
        let old = self.load(simd, group);
        self.store(group, mask.select(values, old));
    }
}

/// A set of rays of a packet, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays(pub u64);

impl Rays {
    pub const NONE: Self = Self(0);
    pub const ALL: Self = Self(u64::MAX);

    /// The first `count`.
    pub fn first(count: usize) -> Self {
        Self(if count < PACKET { (1 << count) - 1 } else { u64::MAX })
    }

    #[inline(always)]
    pub fn one(ray: usize) -> Self {
        Self(1 << ray)
    }

    /// The rays of a group, a bit each.
    #[inline(always)]
    pub fn in_group(group: usize, rays: u32) -> Self {
        Self(u64::from(rays) << (GROUP * group))
    }

    #[inline(always)]
    pub fn without(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    #[inline(always)]
    pub fn and(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    #[inline(always)]
    pub fn or(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    #[inline(always)]
    pub fn has(self, ray: usize) -> bool {
        self.0 >> ray & 1 != 0
    }

    #[inline(always)]
    pub fn count(self) -> u32 {
        self.0.count_ones()
    }

    #[inline(always)]
    pub fn lowest(self) -> Option<usize> {
        self.iter().next()
    }

    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The groups with any of the rays in them, and which.
    #[inline(always)]
    pub fn groups(self) -> impl Iterator<Item = (usize, u32)> {
        Groups(self.0)
    }

    /// Their numbers, ascending.
    #[inline(always)]
    pub fn iter(self) -> impl Iterator<Item = usize> {
        Bits(self.0)
    }

    /// Those of `self` that satisfy a test of whole groups.
    #[inline(always)]
    pub fn that(self, mut test: impl FnMut(usize) -> u32) -> Self {
        let mut found = 0;
        for (group, asked) in Groups(self.0) {
            found |= u64::from(test(group) & asked) << (GROUP * group);
        }
        Self(found)
    }
}

struct Groups(u64);

impl Iterator for Groups {
    type Item = (usize, u32);

    #[inline(always)]
    fn next(&mut self) -> Option<(usize, u32)> {
        if self.0 == 0 {
            return None;
        }
        let group = self.0.trailing_zeros() as usize / GROUP % GROUPS;
        let shift = GROUP * group;
        let rays = (self.0 >> shift) as u32 & ((1 << GROUP) - 1);
        self.0 &= !(((1 << GROUP) - 1) << shift);
        Some((group, rays))
    }
}

struct Bits(u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let bit = self.0.trailing_zeros() as usize % PACKET;
        self.0 &= self.0 - 1;
        Some(bit)
    }
}
