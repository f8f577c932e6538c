//! Binned SAH: the split cost at the planes between a few bins, over the centroids' bounds.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.

use glam::Vec3;
use rayon::prelude::*;

use crate::accel::config::BuildConfig;
use crate::geometry::Aabb;

use super::order::{BuildRef, PARALLEL_MIN, RefSlice};
use super::top_down::{Candidate, Splitter};

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

/// What a bin holds.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: u32,
}

const EMPTY: Bin = Bin { bounds: Aabb::EMPTY, count: 0 };

impl Bin {
    #[inline]
    fn add(&mut self, other: &Self) {
        self.bounds = self.bounds.union(other.bounds);
        self.count += other.count;
    }
}

/// Bins along one axis.
#[derive(Clone, Copy)]
struct Axis {
    axis: usize,
    origin: f32,
    scale: f32,
}

impl Splitter<RefSlice<'_>> for Binned {
    const WEIGHS_COST: bool = true;

    fn find(&self, order: &mut RefSlice<'_>, _bounds: &Aabb) -> Option<Candidate> {
        let refs = &*order.refs;
        let centers = center_bounds(refs);
        let axes = (0..3).filter_map(|axis| self.axis(&centers, axis));
        if refs.len() * 4 < self.bins {
            best(axes.map(|axis| self.find_sparse(refs, axis)))
        } else if refs.len() < PARALLEL_MIN {
            match self.bins {
                0..=16 => best(axes.map(|axis| self.find_dense::<16>(refs, axis))),
                17..=64 => best(axes.map(|axis| self.find_dense::<64>(refs, axis))),
                _ => best(axes.map(|axis| self.find_dense::<MOST_BINS>(refs, axis))),
            }
        } else {
            best(axes.map(|axis| sweep_bins(&self.fill_parallel(refs, axis), axis)))
        }
    }

    fn apply(&self, order: &mut RefSlice<'_>, split: &Candidate) -> usize {
        let goes_left = |r: &BuildRef| {
            bin_index(r.center()[split.axis], split.origin, split.scale, self.bins) < split.position
        };
        partition(order.refs, goes_left)
    }
}

impl Binned {
    /// `None` for an axis without extent, or one so narrow or wide that its scale is no number.
    fn axis(&self, centers: &Aabb, axis: usize) -> Option<Axis> {
        let extent = centers.max[axis] - centers.min[axis];
        let scale = self.bins as f32 / extent;
        (extent > 0.0 && scale.is_finite() && scale > 0.0).then_some(Axis {
            axis,
            origin: centers.min[axis],
            scale,
        })
    }

    fn bin(&self, r: &BuildRef, axis: Axis) -> usize {
        bin_index(r.center()[axis.axis], axis.origin, axis.scale, self.bins)
    }

    fn fill(&self, refs: &[BuildRef], axis: Axis, bins: &mut [Bin]) {
        for r in refs {
            bins[self.bin(r, axis)].add(&Bin { bounds: r.bounds, count: 1 });
        }
    }

    /// With `M >= bins`, so that few bins clear little memory.
    fn find_dense<const M: usize>(&self, refs: &[BuildRef], axis: Axis) -> Option<Candidate> {
        let mut bins = [EMPTY; M];
        self.fill(refs, axis, &mut bins[..self.bins]);
        sweep_bins(&bins[..self.bins], axis)
    }

    /// The dense search on all axes, for comparison.
    #[cfg(test)]
    pub fn find_dense_for_tests(&self, refs: &[BuildRef]) -> Option<Candidate> {
        let centers = center_bounds(refs);
        best(
            (0..3)
                .filter_map(|axis| self.axis(&centers, axis))
                .map(|a| self.find_dense::<MOST_BINS>(refs, a)),
        )
    }

    /// Boxes by min and max and counts are the same in any order, so the bins are those of [`Binned::fill`].
    fn fill_parallel(&self, refs: &[BuildRef], axis: Axis) -> Vec<Bin> {
        let merge = |mut a: Vec<Bin>, b: Vec<Bin>| {
            a.iter_mut().zip(&b).for_each(|(a, b)| a.add(b));
            a
        };
        refs.par_chunks(PARALLEL_MIN)
            .map(|chunk| {
                let mut bins = vec![EMPTY; self.bins];
                self.fill(chunk, axis, &mut bins);
                bins
            })
            .reduce_with(merge)
            .unwrap_or_default()
    }

    /// The same answer as filling and sweeping bins, for a node with far fewer references than bins: only planes next
    /// to a filled bin can differ in cost.
    fn find_sparse(&self, refs: &[BuildRef], axis: Axis) -> Option<Candidate> {
        const MOST: usize = MOST_BINS / 4;
        let mut filled = [(0_usize, EMPTY); MOST];
        let filled = &mut filled[..refs.len()];
        for (slot, r) in filled.iter_mut().zip(refs) {
            *slot = (self.bin(r, axis), Bin { bounds: r.bounds, count: 1 });
        }
        filled.sort_unstable_by_key(|(bin, _)| *bin);
        let mut right_cost = [0.0_f32; MOST];
        let mut right = EMPTY;
        for i in (1..filled.len()).rev() {
            right.add(&filled[i].1);
            right_cost[i] = right.bounds.half_area() * right.count as f32;
        }
        let mut left = EMPTY;
        let mut found: Option<Candidate> = None;
        for i in 1..filled.len() {
            left.add(&filled[i - 1].1);
            if filled[i - 1].0 == filled[i].0 {
                continue;
            }
            let cost = left.bounds.half_area() * left.count as f32 + right_cost[i];
            if found.is_none_or(|f| cost < f.cost) {
                found = Some(axis.candidate(filled[i - 1].0 + 1, cost));
            }
        }
        found
    }
}

impl Axis {
    fn candidate(self, position: usize, cost: f32) -> Candidate {
        Candidate { axis: self.axis, position, cost, scale: self.scale, origin: self.origin }
    }
}

/// The first of the cheapest.
fn best(candidates: impl Iterator<Item = Option<Candidate>>) -> Option<Candidate> {
    candidates.flatten().reduce(|a, b| if b.cost < a.cost { b } else { a })
}

/// The plane with the least split cost; `None` if one bin holds everything. Of planes with nothing between them the
/// first is taken.
fn sweep_bins(bins: &[Bin], axis: Axis) -> Option<Candidate> {
    let mut right_cost = [0.0_f32; MOST_BINS];
    let mut right = EMPTY;
    for i in (1..bins.len()).rev() {
        right.add(&bins[i]);
        right_cost[i] = right.bounds.half_area() * right.count as f32;
    }
    let total = right.count + bins[0].count;
    let mut left = EMPTY;
    let mut found: Option<Candidate> = None;
    for i in 1..bins.len() {
        left.add(&bins[i - 1]);
        if left.count == 0 || left.count == total {
            continue;
        }
        let cost = left.bounds.half_area() * left.count as f32 + right_cost[i];
        if found.is_none_or(|f| cost < f.cost) {
            found = Some(axis.candidate(i, cost));
        }
    }
    found
}

fn center_bounds(refs: &[BuildRef]) -> Aabb {
    let of = |refs: &[BuildRef]| {
        let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for r in refs {
            let center = r.center();
            min = min.min(center);
            max = max.max(center);
        }
        Aabb { min, max }
    };
    if refs.len() < PARALLEL_MIN {
        return of(refs);
    }
    refs.par_chunks(PARALLEL_MIN).map(of).reduce(|| Aabb::EMPTY, Aabb::union)
}

/// Puts the references that go left first; answers how many they are.
fn partition(refs: &mut [BuildRef], goes_left: impl Fn(&BuildRef) -> bool) -> usize {
    let (mut i, mut j) = (0, refs.len());
    while i < j {
        if goes_left(&refs[i]) {
            i += 1;
        } else {
            j -= 1;
            refs.swap(i, j);
        }
    }
    i
}
