//! Full sweep: every position on all three axes, the least SAH split cost.
//!
//! References are sorted once an axis; a split keeps the three orders sorted by a stable partition, so that the whole
//! build is O(n log n) (Wald and Havran, "On building fast kd-Trees for Ray Tracing", 2006, for boxes instead of planes).

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::bound::{BlockCount, Bound};
use super::order::{BuildRef, Order, PARALLEL_MIN};
use super::top_down::{Split, Splitter};

/// The arrays that all nodes of a build share in slices.
pub struct SweepArrays {
    /// Numbers of references sorted by centroid, an axis each.
    sorted: [Vec<u32>; 3],
    /// Right sides' half areas while a node is swept, then the far side while it is partitioned.
    areas: Vec<f32>,
    moved: Vec<u32>,
    /// By reference: whether it goes to the left.
    goes_left: Vec<AtomicBool>,
}

impl SweepArrays {
    /// Sorts by centroid along each axis; ties by the number of the reference.
    pub fn sorted(refs: &[BuildRef]) -> Self {
        let sort = |axis: usize| {
            let mut keys: Vec<u64> = refs
                .par_iter()
                .with_min_len(PARALLEL_MIN)
                .enumerate()
                .map(|(i, r)| (u64::from(sortable(r.center_on(axis))) << 32) | i as u64)
                .collect();
            if keys.len() < PARALLEL_MIN {
                keys.sort_unstable();
            } else {
                keys.par_sort_unstable();
            }
            keys.into_iter().map(|key| key as u32).collect()
        };
        Self {
            sorted: [sort(0), sort(1), sort(2)],
            areas: vec![0.0; refs.len()],
            moved: vec![0; refs.len()],
            goes_left: std::iter::repeat_with(|| AtomicBool::new(false)).take(refs.len()).collect(),
        }
    }

    pub fn order<'a>(&'a mut self, refs: &'a [BuildRef]) -> SweepOrder<'a> {
        SweepOrder {
            refs,
            sorted: self.sorted.each_mut().map(|axis| &mut axis[..]),
            areas: &mut self.areas,
            moved: &mut self.moved,
            goes_left: &self.goes_left,
        }
    }
}

/// Bits that sort as the float does.
fn sortable(value: f32) -> u32 {
    // -0.0 and 0.0 are the same position.
    let bits = (value + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// One node's references in three sorted orders.
pub struct SweepOrder<'a> {
    refs: &'a [BuildRef],
    sorted: [&'a mut [u32]; 3],
    areas: &'a mut [f32],
    moved: &'a mut [u32],
    goes_left: &'a [AtomicBool],
}

impl SweepOrder<'_> {
    /// The best split along one axis: `(cost, references on the left)`; the first of equally good ones.
    fn sweep_axis(&mut self, axis: usize, blocks: BlockCount) -> (f32, usize) {
        let sorted = &*self.sorted[axis];
        let count = sorted.len();
        let mut right = Bound::EMPTY;
        for i in (1..count).rev() {
            right = right.union(self.refs[sorted[i] as usize].bound);
            self.areas[i] = right.half_area();
        }
        let mut left = Bound::EMPTY;
        let mut best = (f32::INFINITY, 0);
        for i in 1..count {
            left = left.union(self.refs[sorted[i - 1] as usize].bound);
            let cost = left.half_area() * blocks.of(i as f32) + self.areas[i] * blocks.of((count - i) as f32);
            if cost < best.0 {
                best = (cost, i);
            }
        }
        best
    }

    /// The box around a range of the references sorted along an axis.
    fn bounds_along(&self, axis: usize, range: Range<usize>) -> Bound {
        self.sorted[axis][range].iter().fold(Bound::EMPTY, |b, &i| b.union(self.refs[i as usize].bound))
    }

    /// Puts the first `mid` references along `axis` before the others in all three orders, which stay sorted.
    fn partition(&mut self, axis: usize, mid: usize) {
        for (i, &r) in self.sorted[axis].iter().enumerate() {
            self.goes_left[r as usize].store(i < mid, Ordering::Relaxed);
        }
        for other in (0..3).filter(|&other| other != axis) {
            let sorted = &mut *self.sorted[other];
            let (mut kept, mut moved) = (0, 0);
            for i in 0..sorted.len() {
                let r = sorted[i];
                // Written to both places without a branch; only one of the two counters moves on.
                let left = self.goes_left[r as usize].load(Ordering::Relaxed);
                sorted[kept] = r;
                self.moved[moved] = r;
                kept += usize::from(left);
                moved += usize::from(!left);
            }
            sorted[kept..].copy_from_slice(&self.moved[..moved]);
        }
    }
}

impl Order for SweepOrder<'_> {
    fn len(&self) -> usize {
        self.sorted[0].len()
    }

    fn bounds(&self, range: Range<usize>) -> Bound {
        self.bounds_along(0, range)
    }

    fn shape(&self, i: usize) -> u32 {
        self.refs[self.sorted[0][i] as usize].shape()
    }

    fn split_middle(&mut self, axis: usize) -> usize {
        let mid = self.len() / 2;
        self.partition(axis, mid);
        mid
    }

    fn split_at(self, mid: usize) -> (Self, Self) {
        let [x, y, z] = self.sorted;
        let ((xl, xr), (yl, yr), (zl, zr)) = (x.split_at_mut(mid), y.split_at_mut(mid), z.split_at_mut(mid));
        let (areas_left, areas_right) = self.areas.split_at_mut(mid);
        let (moved_left, moved_right) = self.moved.split_at_mut(mid);
        let (refs, goes_left) = (self.refs, self.goes_left);
        (
            Self { refs, sorted: [xl, yl, zl], areas: areas_left, moved: moved_left, goes_left },
            Self { refs, sorted: [xr, yr, zr], areas: areas_right, moved: moved_right, goes_left },
        )
    }
}

/// The full sweep. An axis along which all centroids are equal is skipped.
pub struct Sweep(pub BlockCount);

/// The first `position` references along `axis` go to the left.
#[derive(Clone, Copy, Debug)]
pub struct SortedSplit {
    axis: usize,
    position: usize,
}

impl Splitter<SweepOrder<'_>> for Sweep {
    const WEIGHS_COST: bool = true;
    type Plan = SortedSplit;

    fn find(&self, order: &mut SweepOrder<'_>, _bounds: &Bound) -> Option<Split<SortedSplit>> {
        let count = order.len();
        let mut best: Option<(f32, SortedSplit)> = None;
        for axis in 0..3 {
            let first = order.refs[order.sorted[axis][0] as usize].center_on(axis);
            let last = order.refs[order.sorted[axis][count - 1] as usize].center_on(axis);
            if first == last {
                continue;
            }
            let (cost, position) = order.sweep_axis(axis, self.0);
            if position > 0 && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, SortedSplit { axis, position }));
            }
        }
        best.map(|(cost, plan)| Split {
            cost,
            left_count: plan.position,
            left: order.bounds_along(plan.axis, 0..plan.position),
            right: order.bounds_along(plan.axis, plan.position..count),
            plan: Some(plan),
        })
    }

    fn apply(&self, order: &mut SweepOrder<'_>, plan: &SortedSplit) {
        order.partition(plan.axis, plan.position);
    }
}
