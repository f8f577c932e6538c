//! Binned SAH: the split cost at the planes between a few bins, over the centroids' bounds.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. All three axes are filled in one pass
//! over the references and swept side by side, an axis a lane.

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use crate::accel::config::BuildConfig;

use super::bound::{Bound, half_areas};
use super::few;
use super::order::{BuildRef, PARALLEL_MIN, RefSlice};
use super::top_down::{Split, Splitter};

const MOST_BINS: usize = *BuildConfig::BINS.end();

/// The binned builder.
pub struct Binned {
    pub bins: usize,
}

/// The bin of a centroid: `floor(bins * (c - c_min) / (c_max - c_min))` clamped to the last, with
/// `scale = bins / (c_max - c_min)` and `origin = c_min`.
#[inline]
pub fn bin_index(center: f32, origin: f32, scale: f32, bins: usize) -> usize {
    // A float below zero, or NaN, becomes 0.
    (((center - origin) * scale) as usize).min(bins - 1)
}

/// A plane between bins: a reference goes to the left when `(c - origin) * scale < position` along the axis, which is
/// `bin_index(c) < position`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinPlane {
    pub axis: usize,
    /// The first bin on the right.
    pub position: f32,
    pub origin: Vec4,
    pub scale: Vec4,
}

/// The bins of one node along all axes.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    origin: Vec4,
    scale: Vec4,
    /// `bins - 1`.
    last: f32,
}

impl Splitter<RefSlice<'_>> for Binned {
    const WEIGHS_COST: bool = true;
    type Plan = BinPlane;

    #[inline]
    fn find(&self, order: &mut RefSlice<'_>, _bounds: &Bound) -> Option<Split<BinPlane>> {
        let refs = &*order.refs;
        // Arrays, so that loops over them are unrolled.
        let few = match refs.len() {
            2 => refs.as_array().and_then(|refs| few::find::<2>(refs, self.bins)),
            3 => refs.as_array().and_then(|refs| few::find::<3>(refs, self.bins)),
            4 => refs.as_array().and_then(|refs| few::find::<4>(refs, self.bins)),
            5 => refs.as_array().and_then(|refs| few::find::<5>(refs, self.bins)),
            6 => refs.as_array().and_then(|refs| few::find::<6>(refs, self.bins)),
            7 => refs.as_array().and_then(|refs| few::find::<7>(refs, self.bins)),
            8 => refs.as_array().and_then(|refs| few::find::<8>(refs, self.bins)),
            _ => None,
        };
        if few.is_some() { few } else { self.find_among_many(refs) }
    }

    #[inline]
    fn apply(&self, order: &mut RefSlice<'_>, plan: &BinPlane) {
        partition(order.refs, plan);
    }
}

impl Grid {
    /// The bins over the bounds of some centroids. `None` if every axis is skipped: those without extent, or so narrow or
    /// wide that their scale is no number.
    #[inline(always)]
    pub fn new(centers: Bound, bins: usize) -> Option<Self> {
        let extent = centers.max - centers.min;
        let scale = Vec4::splat(bins as f32) / extent;
        let zero = Vec4::ZERO;
        let usable = extent.cmpgt(zero) & scale.cmpgt(zero) & scale.cmplt(Vec4::INFINITY);
        (usable.bitmask() & 7 != 0).then(|| Self {
            // Along an axis that is skipped everything lies in the first bin.
            origin: Vec4::select(usable, centers.min, zero),
            scale: Vec4::select(usable, scale, zero),
            last: (bins - 1) as f32,
        })
    }

    /// 2^23 + [`bin_index`] along all axes. The fourth lane means nothing.
    #[inline(always)]
    pub fn bins_above_whole(&self, center: Vec4) -> Vec4 {
        floor_above_whole(((center - self.origin) * self.scale).min(Vec4::splat(self.last)))
    }

    /// [`bin_index`] along all axes, below `M`, a power of two above the last bin.
    #[inline(always)]
    fn indices<const M: usize>(&self, center: Vec4) -> [usize; 3] {
        let [x, y, z, _] = self.bins_above_whole(center).to_array();
        [x, y, z].map(|bin| bin.to_bits() as usize & (M - 1))
    }

    fn first_usable_axis(&self) -> usize {
        (0..3).find(|&axis| self.scale[axis] > 0.0).unwrap_or(0)
    }

    #[inline]
    pub fn plane(&self, axis: usize, position: f32) -> BinPlane {
        BinPlane { axis, position, origin: self.origin, scale: self.scale }
    }
}

/// 2^23: numbers from here to 2^24 are whole, and their low bits are the number.
pub const WHOLE: Vec4 = Vec4::splat(8_388_608.0);

/// 2^23 + floor, for numbers from 0 to 2^22. With SSE2 alone this is half the work of a conversion to integers that is
/// defined for all floats.
#[inline(always)]
pub fn floor_above_whole(v: Vec4) -> Vec4 {
    // The sum is rounded to the nearest, which is one too large for about half of the numbers.
    let nearest = v + WHOLE;
    nearest - Vec4::select((nearest - WHOLE).cmpgt(v), Vec4::ONE, Vec4::ZERO)
}

/// One bin along each axis. Its size is a power of two, so that finding it takes a shift.
#[derive(Clone, Copy)]
#[repr(C, align(128))]
struct Bin {
    bounds: [Bound; 3],
    /// The last number is not used.
    counts: [u32; 4],
}

impl Bin {
    const EMPTY: Self = Self { bounds: [Bound::EMPTY; 3], counts: [0; 4] };

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        for axis in 0..3 {
            self.bounds[axis] = self.bounds[axis].union(other.bounds[axis]);
        }
        self.counts = std::array::from_fn(|axis| self.counts[axis] + other.counts[axis]);
    }

    /// Half area times count along each axis: not a number for an empty bin, which is neither less nor more than any.
    #[inline(always)]
    fn weights(&self) -> Vec3A {
        // Counts are below 2^31, so that the signed conversion, which SIMD has, will do.
        let counts = Vec4::from_array(self.counts.map(|count| count as i32 as f32));
        half_areas(&self.bounds) * Vec3A::from_vec4(counts)
    }
}

fn fill<const M: usize>(bins: &mut [Bin; M], refs: &[BuildRef], grid: &Grid) {
    for r in refs {
        for (axis, bin) in grid.indices::<M>(r.center()).into_iter().enumerate() {
            bins[bin].bounds[axis] = bins[bin].bounds[axis].union(r.bound);
            bins[bin].counts[axis] += 1;
        }
    }
}

/// Boxes by min and max, and counts, are the same in any order.
#[inline(never)]
fn fill_parallel<const M: usize>(bins: &mut [Bin; M], refs: &[BuildRef], grid: &Grid) {
    let pieces = refs.par_chunks(PARALLEL_MIN).map(|piece| {
        let mut bins = Box::new([Bin::EMPTY; M]);
        fill(&mut bins, piece, grid);
        bins
    });
    let merged = pieces.reduce_with(|mut a, b| {
        a.iter_mut().zip(b.iter()).for_each(|(a, b)| a.add(b));
        a
    });
    if let Some(merged) = merged {
        *bins = *merged;
    }
}

/// The plane with the least split cost. Of equally cheap planes on an axis the first is taken (so of those with nothing
/// between them), and of equally cheap axes.
#[inline(always)]
fn sweep<const M: usize>(bins: &[Bin], grid: &Grid) -> Split<BinPlane> {
    // At `i` the cost of the plane before bin `i`; first only its right side's.
    let mut costs = [Vec3A::INFINITY; M];
    let mut right = Bin::EMPTY;
    for i in (1..bins.len()).rev() {
        right.add(&bins[i]);
        costs[i] = right.weights();
    }
    let mut left = Bin::EMPTY;
    let mut least = Vec3A::INFINITY;
    for i in 1..bins.len() {
        left.add(&bins[i - 1]);
        costs[i] += left.weights();
        // The order matters where the cost is not a number.
        least = costs[i].min(least);
    }
    let (mut axis, cost) = cheapest_axis(least);
    if cost == f32::INFINITY {
        // Areas that are too large for a float. The first and the last bin of a usable axis are never empty.
        axis = grid.first_usable_axis();
    }
    let first = |i: &usize| costs[*i][axis] == cost;
    let position = if cost < f32::INFINITY { (1..bins.len()).find(first).unwrap_or(1) } else { 1 };
    let (left, right) = bins.split_at(position);
    let union = |part: &[Bin]| part.iter().fold(Bound::EMPTY, |b, bin| b.union(bin.bounds[axis]));
    Split {
        cost,
        left_count: left.iter().map(|bin| bin.counts[axis] as usize).sum(),
        left: union(left),
        right: union(right),
        plan: Some(grid.plane(axis, position as f32)),
    }
}

/// The first of the cheapest, and its cost.
#[inline(always)]
pub fn cheapest_axis(costs: Vec3A) -> (usize, f32) {
    let [x, y, z] = costs.to_array();
    let (axis, least) = if y < x { (1, y) } else { (0, x) };
    if z < least { (2, z) } else { (axis, least) }
}

impl Binned {
    #[inline(never)]
    fn find_among_many(&self, refs: &[BuildRef]) -> Option<Split<BinPlane>> {
        if refs.len() * 4 < self.bins {
            return self.find_sparse(refs);
        }
        match self.bins {
            0..=16 => self.find_dense::<16>(refs),
            17..=64 => self.find_dense::<64>(refs),
            _ => self.find_dense::<MOST_BINS>(refs),
        }
    }

    /// With a power of two `M >= bins`, so that few bins clear little memory.
    #[inline(never)]
    fn find_dense<const M: usize>(&self, refs: &[BuildRef]) -> Option<Split<BinPlane>> {
        let grid = &Grid::new(center_bounds(refs), self.bins)?;
        let mut bins = [Bin::EMPTY; M];
        if refs.len() < PARALLEL_MIN {
            fill(&mut bins, refs, grid);
        } else {
            fill_parallel(&mut bins, refs, grid);
        }
        Some(sweep::<M>(&bins[..self.bins], grid))
    }

    /// The dense search, for comparison.
    #[cfg(test)]
    pub fn find_dense_for_tests(&self, refs: &[BuildRef]) -> Option<Split<BinPlane>> {
        self.find_dense::<MOST_BINS>(refs)
    }

    /// The same answer as filling and sweeping bins, for a node with far fewer references than bins: only planes next
    /// to a filled bin can differ in cost.
    #[inline(never)]
    fn find_sparse(&self, refs: &[BuildRef]) -> Option<Split<BinPlane>> {
        let grid = Grid::new(center_bounds(refs), self.bins)?;
        let found = (0..3).filter_map(|axis| sparse_on_axis(refs, &grid, axis));
        found.reduce(|a, b| if b.cost < a.cost { b } else { a })
    }
}

fn sparse_on_axis(refs: &[BuildRef], grid: &Grid, axis: usize) -> Option<Split<BinPlane>> {
    const MOST: usize = MOST_BINS / 4;
    let mut filled = [(0_usize, Bound::EMPTY); MOST];
    let filled = &mut filled[..refs.len()];
    for (slot, r) in filled.iter_mut().zip(refs) {
        *slot = (grid.indices::<MOST_BINS>(r.center())[axis], r.bound);
    }
    filled.sort_unstable_by_key(|(bin, _)| *bin);
    let mut rights = [Bound::EMPTY; MOST];
    let mut right = Bound::EMPTY;
    for i in (1..filled.len()).rev() {
        right = right.union(filled[i].1);
        rights[i] = right;
    }
    let mut left = Bound::EMPTY;
    let mut found: Option<Split<BinPlane>> = None;
    for i in 1..filled.len() {
        left = left.union(filled[i - 1].1);
        if filled[i - 1].0 == filled[i].0 {
            continue;
        }
        let right_count = filled.len() - i;
        let cost = left.half_area() * i as f32 + rights[i].half_area() * right_count as f32;
        if found.is_none_or(|f| cost < f.cost) {
            let plan = grid.plane(axis, (filled[i - 1].0 + 1) as f32);
            found = Some(Split { cost, left_count: i, left, right: rights[i], plan: Some(plan) });
        }
    }
    found
}

#[inline]
fn center_bounds(refs: &[BuildRef]) -> Bound {
    let of = |refs: &[BuildRef]| refs.iter().fold(Bound::EMPTY, |b, r| b.grown(r.center()));
    if refs.len() < PARALLEL_MIN {
        return of(refs);
    }
    refs.par_chunks(PARALLEL_MIN).map(of).reduce(|| Bound::EMPTY, Bound::union)
}

/// Puts the references that go left first.
///
/// Every reference is moved whether it has to be or not, which costs less than guessing wrong every other time. All axes
/// are compared and one bit is taken, so that references stay in whole registers.
fn partition(refs: &mut [BuildRef], plane: &BinPlane) {
    let position = Vec4::splat(plane.position);
    let mut left_count = 0;
    for i in 0..refs.len() {
        let r = refs[i];
        let left = ((r.center() - plane.origin) * plane.scale).cmplt(position);
        refs[i] = refs[left_count];
        refs[left_count] = r;
        left_count += (left.bitmask() >> plane.axis & 1) as usize;
    }
}
