//! The binned search for a handful of references: sorted by bin along all axes at once, then swept one by one.

use std::array;

use glam::{Vec3A, Vec4};

use super::binned::{BinPlane, Grid, WHOLE, cheapest_axis, floor_above_whole};
use super::bound::{Bound, half_areas};
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
#[inline(never)]
pub fn find<const COUNT: usize>(refs: &[BuildRef; COUNT], bins: usize) -> Option<Split<BinPlane>> {
    const { assert!(COUNT >= 2 && COUNT <= MOST) };
    let centers = refs.each_ref().map(BuildRef::center);
    let grid = Grid::new(centers.into_iter().fold(Bound::EMPTY, Bound::grown), bins)?;
    // The bin along each axis, with the reference in the fraction.
    let mut keys: [Vec4; COUNT] =
        array::from_fn(|i| grid.bins_above_whole(centers[i]) - WHOLE + i as f32 / MOST as f32);
    for [i, j] in NETWORK {
        if j < COUNT {
            (keys[i], keys[j]) = (keys[i].min(keys[j]), keys[i].max(keys[j]));
        }
    }
    let bins = keys.map(|key| floor_above_whole(key) - WHOLE);
    let sorted: [[Bound; 3]; COUNT] = array::from_fn(|i| {
        let [x, y, z, _] = ((keys[i] - bins[i]) * MOST as f32 + WHOLE).to_array();
        [x, y, z].map(|at| refs[at.to_bits() as usize & (MOST - 1)].bound)
    });
    let (axis, left_count, cost) = sweep(&sorted, &bins.map(Vec3A::from_vec4))?;
    let union = |part: &[[Bound; 3]]| part.iter().fold(Bound::EMPTY, |b, at| b.union(at[axis]));
    let (left, right) = sorted.split_at(left_count);
    let position = bins[left_count - 1][axis] + 1.0;
    Some(Split {
        cost,
        left_count,
        left: union(left),
        right: union(right),
        plan: Some(grid.plane(axis, position)),
    })
}

/// The axis, how many references lie on the left, and the cost.
#[inline(always)]
fn sweep<const COUNT: usize>(
    sorted: &[[Bound; 3]; COUNT],
    bins: &[Vec3A; COUNT],
) -> Option<(usize, usize, f32)> {
    // At `i` the cost of the first `i` going to the left; first only what the others make of it.
    let mut costs = [Vec3A::INFINITY; COUNT];
    let mut right = sorted[COUNT - 1];
    for i in (1..COUNT).rev() {
        costs[i] = half_areas(&right) * (COUNT - i) as f32;
        right = array::from_fn(|axis| right[axis].union(sorted[i - 1][axis]));
    }
    let mut left = sorted[0];
    let mut least = Vec3A::INFINITY;
    for i in 1..COUNT {
        let cost = half_areas(&left) * i as f32 + costs[i];
        // Only between two bins.
        costs[i] = Vec3A::select(bins[i - 1].cmplt(bins[i]), cost, Vec3A::INFINITY);
        least = costs[i].min(least);
        left = array::from_fn(|axis| left[axis].union(sorted[i][axis]));
    }
    let (axis, cost) = cheapest_axis(least);
    // A bit for each place that is as cheap.
    let cheapest = (1..COUNT).fold(0, |set, i| set | (costs[i].cmpeq(least).bitmask() >> axis & 1) << i);
    (cost < f32::INFINITY).then_some((axis, cheapest.trailing_zeros() as usize, cost))
}
