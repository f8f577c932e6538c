//! The binned search for a handful of references: sorted by bin along all axes at once, then swept one by one.

use fearless_simd::{Simd, f32x4, f32x8, prelude::*};

use super::binned::{BinPlane, Grid, center_bounds_of, cheapest_axis, to_int};
use super::bound::{BlockCount, Bound, center, half_areas};
use super::order::BuildRef;
use super::top_down::Split;

/// Most references that are searched this way.
const MOST: usize = 8;

/// The shortest sorting network for eight numbers: pairs of places, the lesser number goes to the first. Without the
/// pairs that reach behind the last number it sorts fewer as well.
#[rustfmt::skip]
const NETWORK: [[usize; 2]; 19] = [
    [0, 2], [1, 3], [4, 6], [5, 7],
    [0, 4], [1, 5], [2, 6], [3, 7],
    [0, 1], [2, 3], [4, 5], [6, 7],
    [2, 4], [3, 5],
    [1, 4], [3, 6],
    [1, 2], [3, 4], [5, 6],
];

/// The same answer as filling and sweeping bins. `None` too where no cost is a finite number.
///
/// Tried and lost: pricing every subset once and looking planes up in that table. For four references it took as many
/// instructions as sorting takes on average for two to eight.
#[inline(never)]
pub fn find<S: Simd, const COUNT: usize>(
    simd: S,
    refs: &[BuildRef; COUNT],
    bins: usize,
    blocks: BlockCount,
) -> Option<Split<BinPlane>> {
    const { assert!(COUNT >= 2 && COUNT <= MOST) };
    simd.vectorize(
        #[inline(always)]
        || {
            let grid = Grid::new(center_bounds_of(simd, refs), bins)?;
            let (keys, bins) = sorted_keys(simd, refs, &grid);
            let mut sorted = [[Bound::EMPTY; 3]; COUNT];
            for i in 0..COUNT {
                let which = to_int((keys[i] - bins[i]) * MOST as f32);
                for axis in 0..3 {
                    sorted[i][axis] = refs[which[axis] as usize & (MOST - 1)].bound;
                }
            }
            let (axis, left_count, cost) = sweep(simd, &sorted, &bins, blocks)?;
            let position = bins[left_count - 1][axis] + 1.0;
            let (left, right) = sorted.split_at(left_count);
            Some(Split {
                cost,
                left_count,
                left: union_along(simd, left, axis),
                right: union_along(simd, right, axis),
                plan: Some(grid.plane(axis, position)),
            })
        },
    )
}

/// Ascending along each axis: the bin with the reference in its fraction; and the bin alone.
#[inline(always)]
fn sorted_keys<S: Simd, const COUNT: usize>(
    simd: S,
    refs: &[BuildRef; COUNT],
    grid: &Grid<S>,
) -> ([f32x4<S>; COUNT], [f32x4<S>; COUNT]) {
    let mut keys = [f32x4::splat(simd, 0.0); COUNT];
    for i in 0..COUNT {
        keys[i] = grid.positions(center(refs[i].bound.load(simd))).floor() + i as f32 / MOST as f32;
    }
    for [i, j] in NETWORK {
        if j < COUNT {
            (keys[i], keys[j]) = (keys[i].min(keys[j]), keys[i].max(keys[j]));
        }
    }
    let mut bins = keys;
    for bin in &mut bins {
        *bin = bin.floor();
    }
    (keys, bins)
}

/// The axis, how many references lie on the left, and the cost.
#[inline(always)]
fn sweep<S: Simd, const COUNT: usize>(
    simd: S,
    sorted: &[[Bound; 3]; COUNT],
    bins: &[f32x4<S>; COUNT],
    blocks: BlockCount,
) -> Option<(usize, usize, f32)> {
    let infinite = f32x4::splat(simd, f32::INFINITY);
    // At `i` the cost of the first `i` going to the left; first only what the others make of it.
    let mut costs = [infinite; COUNT];
    let mut right = load(simd, &sorted[COUNT - 1]);
    for i in (1..COUNT).rev() {
        costs[i] = half_areas(&right) * blocks.of((COUNT - i) as f32);
        right = unions(right, load(simd, &sorted[i - 1]));
    }
    let mut left = load(simd, &sorted[0]);
    let mut least = infinite;
    for i in 1..COUNT {
        let cost = half_areas(&left) * blocks.of(i as f32) + costs[i];
        // Only between two bins.
        costs[i] = bins[i - 1].simd_lt(bins[i]).select(cost, infinite);
        least = costs[i].simd_lt(least).select(costs[i], least);
        left = unions(left, load(simd, &sorted[i]));
    }
    let (axis, cost) = cheapest_axis(least);
    // A bit for each place that is as cheap.
    let mut cheapest = 0;
    for (i, costs) in costs.iter().enumerate().skip(1) {
        cheapest |= (costs.simd_eq(least).to_bitmask() >> axis & 1) << i;
    }
    (cost < f32::INFINITY).then_some((axis, cheapest.trailing_zeros() as usize, cost))
}

#[inline(always)]
fn load<S: Simd>(simd: S, [a, b, c]: &[Bound; 3]) -> [f32x8<S>; 3] {
    [a.load(simd), b.load(simd), c.load(simd)]
}

#[inline(always)]
fn unions<S: Simd>([a, b, c]: [f32x8<S>; 3], [d, e, f]: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [a.min(d), b.min(e), c.min(f)]
}

#[inline(always)]
fn union_along<S: Simd>(simd: S, part: &[[Bound; 3]], axis: usize) -> Bound {
    let mut union = Bound::EMPTY.load(simd);
    for at in part {
        union = union.min(at[axis].load(simd));
    }
    Bound::store(union)
}
