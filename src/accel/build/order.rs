//! The references of a node while a tree is built: a slice that splits in two.

use std::ops::Range;

use rayon::prelude::*;

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::bound::Bound;

/// Below this many references a loop over them is not worth sharing among threads. One such piece takes well under a
/// millisecond.
pub const PARALLEL_MIN: usize = 16 * 1024;

/// What a top-down builder splits: the references of one node.
pub trait Order: Send + Sized {
    fn len(&self) -> usize;

    /// The box around some of the references.
    fn bounds(&self, range: Range<usize>) -> Bound;

    /// The shape of the `i`-th reference in the current order.
    fn shape(&self, i: usize) -> u32;

    /// Orders the references so that the lower half by centroid along `axis` (ties by shape index) comes first, and
    /// answers the middle, `len / 2`: the object median.
    fn split_middle(&mut self, axis: usize) -> usize;

    /// The references before and from `mid`.
    fn split_at(self, mid: usize) -> (Self, Self);
}

/// A box with its shape, whose index is kept in the box's last lane.
#[derive(Clone, Copy, Debug)]
pub struct BuildRef {
    pub bound: Bound,
}

/// Added to a shape's index, so that the lane holds a number from 1 up, and no passing difference is denormal:
/// arithmetic on denormal numbers is slow even in lanes that mean nothing.
const SHAPE_BIAS: u32 = 0x3f80_0000;
/// Most shapes, so that the lane holds a finite number.
const MOST_SHAPES: usize = 1 << 30;

impl BuildRef {
    #[inline]
    pub fn new(bounds: &Aabb, shape: u32) -> Self {
        Self { bound: Bound::new(bounds, f32::from_bits(shape + SHAPE_BIAS)) }
    }

    #[inline]
    pub fn shape(&self) -> u32 {
        self.bound.spare().to_bits() - SHAPE_BIAS
    }

    #[inline]
    pub fn center_on(&self, axis: usize) -> f32 {
        self.bound.aabb().center()[axis]
    }
}

/// One reference a shape.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// If a box is empty or not finite, or there are more than [`MOST_SHAPES`].
pub fn build_refs(
    count: usize,
    bounds: impl Fn(u32) -> Aabb + Sync,
    task: &Task,
) -> Result<Vec<BuildRef>, Cancelled> {
    assert!(count <= MOST_SHAPES, "{count} shapes are too many for one tree");
    let refs = (0..count as u32).into_par_iter().with_min_len(PARALLEL_MIN).map(|shape| {
        let bounds = bounds(shape);
        check_box(&bounds, shape as usize);
        BuildRef::new(&bounds, shape)
    });
    let refs = refs.collect();
    task.check().map(|()| refs)
}

/// # Panics
/// If the box is empty or not finite: loaders remove such shapes.
#[inline]
fn check_box(bounds: &Aabb, shape: usize) {
    assert!(bounds.is_finite() && !bounds.is_empty(), "shape {shape} has no finite box: {bounds:?}");
}

/// References that lie in memory in the order of the nodes, so that every pass over a node is sequential.
pub struct RefSlice<'a> {
    pub refs: &'a mut [BuildRef],
}

impl<'a> RefSlice<'a> {
    pub fn new(refs: &'a mut [BuildRef]) -> Self {
        Self { refs }
    }
}

impl Order for RefSlice<'_> {
    fn len(&self) -> usize {
        self.refs.len()
    }

    fn bounds(&self, range: Range<usize>) -> Bound {
        let of = |refs: &[BuildRef]| refs.iter().fold(Bound::EMPTY, |b, r| b.union(r.bound));
        let refs = &self.refs[range];
        if refs.len() < PARALLEL_MIN {
            return of(refs);
        }
        refs.par_chunks(PARALLEL_MIN).map(of).reduce(|| Bound::EMPTY, Bound::union)
    }

    fn shape(&self, i: usize) -> u32 {
        self.refs[i].shape()
    }

    fn split_middle(&mut self, axis: usize) -> usize {
        let mid = self.refs.len() / 2;
        self.refs.select_nth_unstable_by(mid, |a, b| {
            let (ca, cb) = (a.center_on(axis), b.center_on(axis));
            ca.total_cmp(&cb).then(a.shape().cmp(&b.shape()))
        });
        mid
    }

    fn split_at(self, mid: usize) -> (Self, Self) {
        let (left, right) = self.refs.split_at_mut(mid);
        (Self { refs: left }, Self { refs: right })
    }
}
