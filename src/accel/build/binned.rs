//! Binned SAH: the split cost at the planes between a few bins, over the centroids' bounds.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007. All three axes are filled in one pass
//! over the references and swept side by side, an axis a lane.

use fearless_simd::{Simd, f32x4, f32x8, i32x4, prelude::*};
use rayon::prelude::*;

use crate::accel::config::BuildConfig;
use crate::accel::simd::SimdToken;
use crate::at_level;
use crate::task::Task;

use super::bound::{BlockCount, Bound, center, half_areas};
use super::few;
use super::order::{BuildRef, PARALLEL_MIN, RefSlice};
use super::top_down::{Split, Splitter};

const MOST_BINS: usize = *BuildConfig::BINS.end();

/// The binned builder.
pub struct Binned<'a> {
    bins: usize,
    blocks: BlockCount,
    task: &'a Task,
    level: SimdToken,
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
    pub origin: [f32; 4],
    pub scale: [f32; 4],
}

/// The bins of one node along all axes. The fourth lane means nothing.
#[derive(Clone, Copy)]
pub struct Grid<S: Simd> {
    origin: f32x4<S>,
    scale: f32x4<S>,
    /// `bins - 1`.
    last: f32x4<S>,
}

impl Splitter<RefSlice<'_>> for Binned<'_> {
    const WEIGHS_COST: bool = true;
    type Plan = BinPlane;

    #[inline]
    fn find(&self, order: &mut RefSlice<'_>, _bounds: &Bound) -> Option<Split<BinPlane>> {
        at_level!(self.level, simd => find(simd, order.refs, (self.bins, self.blocks), self.task))
    }

    #[inline]
    fn apply(&self, order: &mut RefSlice<'_>, plan: &BinPlane) {
        at_level!(self.level, simd => partition(simd, order.refs, plan, self.task));
    }
}

impl<'a> Binned<'a> {
    /// Once the task is cancelled, what is found means nothing.
    pub fn new(config: &BuildConfig, task: &'a Task) -> Self {
        Self { bins: config.bins, blocks: BlockCount::new(config.block), task, level: SimdToken::of(config) }
    }

    /// The dense search, for comparison.
    #[cfg(test)]
    pub fn find_dense_for_tests(&self, refs: &[BuildRef]) -> Option<Split<BinPlane>> {
        at_level!(self.level, simd => find_dense::<_, MOST_BINS>(simd, refs, (self.bins, self.blocks), self.task))
    }
}

#[inline(always)]
fn find<S: Simd>(
    simd: S,
    refs: &[BuildRef],
    (bins, blocks): (usize, BlockCount),
    task: &Task,
) -> Option<Split<BinPlane>> {
    // Arrays, so that loops over them are unrolled.
    let few = match refs.len() {
        2 => refs.as_array().and_then(|refs| few::find::<S, 2>(simd, refs, bins, blocks)),
        3 => refs.as_array().and_then(|refs| few::find::<S, 3>(simd, refs, bins, blocks)),
        4 => refs.as_array().and_then(|refs| few::find::<S, 4>(simd, refs, bins, blocks)),
        5 => refs.as_array().and_then(|refs| few::find::<S, 5>(simd, refs, bins, blocks)),
        6 => refs.as_array().and_then(|refs| few::find::<S, 6>(simd, refs, bins, blocks)),
        7 => refs.as_array().and_then(|refs| few::find::<S, 7>(simd, refs, bins, blocks)),
        8 => refs.as_array().and_then(|refs| few::find::<S, 8>(simd, refs, bins, blocks)),
        _ => None,
    };
    if few.is_some() {
        return few;
    }
    if refs.len() * 4 < bins {
        return find_sparse(simd, refs, bins, blocks);
    }
    match bins {
        0..=16 => find_dense::<S, 16>(simd, refs, (bins, blocks), task),
        17..=64 => find_dense::<S, 64>(simd, refs, (bins, blocks), task),
        _ => find_dense::<S, MOST_BINS>(simd, refs, (bins, blocks), task),
    }
}

impl<S: Simd> Grid<S> {
    /// The bins over the bounds of some centroids. `None` if every axis is skipped: those without extent, or so narrow or
    /// wide that their scale is no number.
    #[inline(always)]
    pub fn new((min, max): (f32x4<S>, f32x4<S>), bins: usize) -> Option<Self> {
        let simd = min.simd;
        let zero = f32x4::splat(simd, 0.0);
        let extent = max - min;
        let scale = f32x4::splat(simd, bins as f32) / extent;
        let usable =
            extent.simd_gt(zero) & scale.simd_gt(zero) & scale.simd_lt(f32x4::splat(simd, f32::INFINITY));
        (usable.to_bitmask() & 7 != 0).then(|| Self {
            // Along an axis that is skipped everything lies in the first bin.
            origin: usable.select(min, zero),
            scale: usable.select(scale, zero),
            last: f32x4::splat(simd, (bins - 1) as f32),
        })
    }

    /// [`bin_index`] along all axes, before it is rounded down.
    #[inline(always)]
    pub fn positions(&self, center: f32x4<S>) -> f32x4<S> {
        ((center - self.origin) * self.scale).min(self.last)
    }

    /// [`bin_index`] along all axes, below `M`, a power of two above the last bin.
    #[inline(always)]
    fn indices<const M: usize>(&self, center: f32x4<S>) -> [usize; 3] {
        let [x, y, z, _] = to_int(self.positions(center));
        [x as usize & (M - 1), y as usize & (M - 1), z as usize & (M - 1)]
    }

    #[inline(always)]
    fn first_usable_axis(&self) -> usize {
        if self.scale[0] > 0.0 {
            0
        } else if self.scale[1] > 0.0 {
            1
        } else {
            2
        }
    }

    #[inline(always)]
    pub fn plane(&self, axis: usize, position: f32) -> BinPlane {
        BinPlane { axis, position, origin: self.origin.to_array(), scale: self.scale.to_array() }
    }
}

/// Rounded towards zero.
#[inline(always)]
pub fn to_int<S: Simd>(v: f32x4<S>) -> [i32; 4] {
    v.simd.cvt_i32_f32x4(v).to_array()
}

/// One bin along each axis. Its size is a power of two, so that finding it takes a shift.
#[derive(Clone, Copy)]
#[repr(C, align(128))]
struct Bin {
    bounds: [Bound; 3],
    /// The last number is not used.
    counts: [i32; 4],
}

impl Bin {
    const EMPTY: Self = Self { bounds: [Bound::EMPTY; 3], counts: [0; 4] };
}

/// The union of bins in registers.
#[derive(Clone, Copy)]
struct Bins<S: Simd> {
    bounds: [f32x8<S>; 3],
    counts: i32x4<S>,
}

impl<S: Simd> Bins<S> {
    #[inline(always)]
    fn load(simd: S, bin: &Bin) -> Self {
        let [a, b, c] = &bin.bounds;
        Self {
            bounds: [a.load(simd), b.load(simd), c.load(simd)],
            counts: i32x4::load_array_ref(simd, &bin.counts),
        }
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.bounds, other.bounds);
        Self { bounds: [a.min(d), b.min(e), c.min(f)], counts: self.counts + other.counts }
    }

    /// Half area times count of blocks along each axis: not a number where empty.
    #[inline(always)]
    fn weights(&self, blocks: BlockCount) -> f32x4<S> {
        half_areas(&self.bounds) * blocks.of_lanes(self.counts.simd.cvt_f32_i32x4(self.counts))
    }

    #[inline(always)]
    fn store(self) -> Bin {
        let [a, b, c] = self.bounds;
        Bin { bounds: [Bound::store(a), Bound::store(b), Bound::store(c)], counts: self.counts.to_array() }
    }
}

/// Tried and lost: boxes as two vectors of four, with an exact floor from additions alone for SSE2. A build of 69,451
/// triangles executed 150 million instructions instead of 110 million, and took 5 to 10 percent longer.
#[inline(always)]
fn fill<S: Simd, const M: usize>(bins: &mut [Bin; M], refs: &[BuildRef], grid: &Grid<S>) {
    let simd = grid.origin.simd;
    for r in refs {
        let bound = r.bound.load(simd);
        let indices = grid.indices::<M>(center(bound));
        for axis in 0..3 {
            let bin = &mut bins[indices[axis]];
            bin.bounds[axis] = Bound::store(bin.bounds[axis].load(simd).min(bound));
            bin.counts[axis] += 1;
        }
    }
}

/// Boxes by min and max, and counts, are the same in any order.
#[inline(never)]
fn fill_parallel<S: Simd, const M: usize>(
    bins: &mut [Bin; M],
    refs: &[BuildRef],
    grid: &Grid<S>,
    task: &Task,
) {
    let simd = grid.origin.simd;
    let pieces = refs.par_chunks(PARALLEL_MIN).map(|piece| {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut bins = Box::new([Bin::EMPTY; M]);
                fill(&mut bins, if task.is_cancelled() { &[] } else { piece }, grid);
                bins
            },
        )
    });
    let merged = pieces.reduce_with(|mut a, b| {
        for (a, b) in a.iter_mut().zip(b.iter()) {
            *a = Bins::load(simd, a).union(Bins::load(simd, b)).store();
        }
        a
    });
    if let Some(merged) = merged {
        *bins = *merged;
    }
}

/// With a power of two `M >= bins`, so that few bins clear little memory. Never inlined, nor are the other searches: each
/// node would touch the stack of them all.
#[inline(never)]
fn find_dense<S: Simd, const M: usize>(
    simd: S,
    refs: &[BuildRef],
    (bins, blocks): (usize, BlockCount),
    task: &Task,
) -> Option<Split<BinPlane>> {
    simd.vectorize(
        #[inline(always)]
        || {
            let grid = Grid::new(center_bounds(simd, refs, task), bins)?;
            let mut filled = [Bin::EMPTY; M];
            if refs.len() < PARALLEL_MIN {
                fill(&mut filled, refs, &grid);
            } else {
                fill_parallel(&mut filled, refs, &grid, task);
            }
            Some(sweep::<S, M>(&filled[..bins], &grid, blocks))
        },
    )
}

/// The plane with the least split cost. Of equally cheap planes on an axis the first is taken (so of those with nothing
/// between them), and of equally cheap axes.
#[inline(always)]
fn sweep<S: Simd, const M: usize>(bins: &[Bin], grid: &Grid<S>, blocks: BlockCount) -> Split<BinPlane> {
    let simd = grid.origin.simd;
    let infinite = f32x4::splat(simd, f32::INFINITY);
    // At `i` the cost of the plane before bin `i`; first only its right side's.
    let mut costs = [infinite; M];
    let mut right = Bins::load(simd, &Bin::EMPTY);
    for i in (1..bins.len()).rev() {
        right = right.union(Bins::load(simd, &bins[i]));
        costs[i] = right.weights(blocks);
    }
    let mut left = Bins::load(simd, &Bin::EMPTY);
    let mut least = infinite;
    for i in 1..bins.len() {
        left = left.union(Bins::load(simd, &bins[i - 1]));
        let cost = costs[i] + left.weights(blocks);
        costs[i] = cost;
        // What is not a number is not less.
        least = cost.simd_lt(least).select(cost, least);
    }
    let (mut axis, cost) = cheapest_axis(least);
    if cost == f32::INFINITY {
        // Areas that are too large for a float. The first and the last bin of a usable axis are never empty.
        axis = grid.first_usable_axis();
    }
    let mut position = 1;
    while cost < f32::INFINITY && costs[position][axis] != cost {
        position += 1;
    }
    let (left, right) = bins.split_at(position);
    let (left_count, left) = union_along(simd, left, axis);
    let (_, right) = union_along(simd, right, axis);
    Split { cost, left_count, left, right, plan: Some(grid.plane(axis, position as f32)) }
}

/// How many references some bins hold along an axis, and their box.
#[inline(always)]
fn union_along<S: Simd>(simd: S, bins: &[Bin], axis: usize) -> (usize, Bound) {
    let (mut count, mut bounds) = (0, Bound::EMPTY.load(simd));
    for bin in bins {
        count += bin.counts[axis];
        bounds = bounds.min(bin.bounds[axis].load(simd));
    }
    (count as usize, Bound::store(bounds))
}

/// The first of the cheapest, and its cost.
#[inline(always)]
pub fn cheapest_axis<S: Simd>(costs: f32x4<S>) -> (usize, f32) {
    let [x, y, z, _] = costs.to_array();
    let (axis, least) = if y < x { (1, y) } else { (0, x) };
    if z < least { (2, z) } else { (axis, least) }
}

/// The same answer as filling and sweeping bins, for a node with far fewer references than bins: only planes next to a
/// filled bin can differ in cost.
#[inline(never)]
fn find_sparse<S: Simd>(
    simd: S,
    refs: &[BuildRef],
    bins: usize,
    blocks: BlockCount,
) -> Option<Split<BinPlane>> {
    simd.vectorize(
        #[inline(always)]
        || {
            let grid = Grid::new(center_bounds_of(simd, refs), bins)?;
            let mut best: Option<Split<BinPlane>> = None;
            for axis in 0..3 {
                let found = sparse_on_axis(refs, &grid, axis, blocks);
                if best.is_none_or(|best| found.is_some_and(|found| found.cost < best.cost)) {
                    best = found;
                }
            }
            best
        },
    )
}

#[inline(always)]
fn sparse_on_axis<S: Simd>(
    refs: &[BuildRef],
    grid: &Grid<S>,
    axis: usize,
    blocks: BlockCount,
) -> Option<Split<BinPlane>> {
    const MOST: usize = MOST_BINS / 4;
    let simd = grid.origin.simd;
    let mut filled = [(0_usize, Bound::EMPTY); MOST];
    let filled = &mut filled[..refs.len()];
    for (slot, r) in filled.iter_mut().zip(refs) {
        *slot = (grid.indices::<MOST_BINS>(center(r.bound.load(simd)))[axis], r.bound);
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
        let cost =
            left.half_area() * blocks.of(i as f32) + rights[i].half_area() * blocks.of(right_count as f32);
        if found.is_none_or(|f| cost < f.cost) {
            let plan = grid.plane(axis, (filled[i - 1].0 + 1) as f32);
            found = Some(Split { cost, left_count: i, left, right: rights[i], plan: Some(plan) });
        }
    }
    found
}

/// Least and largest coordinates of the centroids.
#[inline(always)]
fn center_bounds<S: Simd>(simd: S, refs: &[BuildRef], task: &Task) -> (f32x4<S>, f32x4<S>) {
    if refs.len() < PARALLEL_MIN {
        return center_bounds_of(simd, refs);
    }
    let pieces = refs.par_chunks(PARALLEL_MIN).map(|piece| {
        simd.vectorize(
            #[inline(always)]
            || center_bounds_of(simd, if task.is_cancelled() { &[] } else { piece }),
        )
    });
    let all = pieces.reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    all.unwrap_or_else(|| center_bounds_of(simd, refs))
}

#[inline(always)]
pub fn center_bounds_of<S: Simd>(simd: S, refs: &[BuildRef]) -> (f32x4<S>, f32x4<S>) {
    let (mut min, mut max) = (f32x4::splat(simd, f32::INFINITY), f32x4::splat(simd, f32::NEG_INFINITY));
    for r in refs {
        let center = center(r.bound.load(simd));
        (min, max) = (min.min(center), max.max(center));
    }
    (min, max)
}

/// Puts the references that go left first.
///
/// Every reference is moved whether it has to be or not, which costs less than guessing wrong every other time. All axes
/// are compared and one bit is taken, so that references stay in whole registers: picking one coordinate from memory
/// made the compiler copy them in parts, and took twice as long.
#[inline(always)]
fn partition<S: Simd>(simd: S, refs: &mut [BuildRef], plane: &BinPlane, task: &Task) {
    let position = f32x4::splat(simd, plane.position);
    let origin = f32x4::load_array(simd, plane.origin);
    let scale = f32x4::load_array(simd, plane.scale);
    let mut left_count = 0;
    for start in (0..refs.len()).step_by(PARALLEL_MIN) {
        if task.is_cancelled() {
            return;
        }
        for i in start..refs.len().min(start + PARALLEL_MIN) {
            let bound = refs[i].bound.load(simd);
            let left = ((center(bound) - origin) * scale).simd_lt(position);
            refs[i] = refs[left_count];
            refs[left_count] = BuildRef { bound: Bound::store(bound) };
            left_count += (left.to_bitmask() >> plane.axis & 1) as usize;
        }
    }
}
