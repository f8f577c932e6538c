//! The references of a node while a tree is built: a slice that splits in two.

use rayon::prelude::*;

use crate::geometry::Aabb;

/// Below this many references a loop over them is not worth sharing among threads.
pub const PARALLEL_MIN: usize = 16 * 1024;

/// What a top-down builder splits: the references of one node.
pub trait Order: Send + Sized {
    fn len(&self) -> usize;

    /// The box around all references.
    fn bounds(&self) -> Aabb;

    /// The shape of the `i`-th reference in the current order.
    fn shape(&self, i: usize) -> u32;

    /// Orders the references so that the lower half by centroid along `axis` (ties by shape index) comes first, and
    /// answers the middle, `len / 2`: the object median.
    fn split_middle(&mut self, axis: usize) -> usize;

    /// The references before and from `mid`.
    fn split_at(self, mid: usize) -> (Self, Self);
}

/// A box with its shape.
#[derive(Clone, Copy, Debug)]
pub struct BuildRef {
    pub bounds: Aabb,
    pub shape: u32,
}

impl BuildRef {
    #[inline]
    pub fn center(&self) -> glam::Vec3 {
        self.bounds.center()
    }
}

/// One reference a box.
///
/// # Panics
/// If a box is empty or not finite.
pub fn build_refs(boxes: &[Aabb]) -> Vec<BuildRef> {
    boxes
        .par_iter()
        .with_min_len(PARALLEL_MIN)
        .enumerate()
        .map(|(shape, &bounds)| {
            check_box(&bounds, shape);
            BuildRef { bounds, shape: shape as u32 }
        })
        .collect()
}

/// # Panics
/// If the box is empty or not finite: loaders remove such shapes.
pub fn check_box(bounds: &Aabb, shape: usize) {
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

    fn bounds(&self) -> Aabb {
        if self.refs.len() < PARALLEL_MIN {
            return self.refs.iter().fold(Aabb::EMPTY, |b, r| b.union(r.bounds));
        }
        self.refs
            .par_chunks(PARALLEL_MIN)
            .map(|chunk| chunk.iter().fold(Aabb::EMPTY, |b, r| b.union(r.bounds)))
            .reduce(|| Aabb::EMPTY, Aabb::union)
    }

    fn shape(&self, i: usize) -> u32 {
        self.refs[i].shape
    }

    fn split_middle(&mut self, axis: usize) -> usize {
        let mid = self.refs.len() / 2;
        self.refs.select_nth_unstable_by(mid, |a, b| {
            let (ca, cb) = (a.center()[axis], b.center()[axis]);
            ca.total_cmp(&cb).then(a.shape.cmp(&b.shape))
        });
        mid
    }

    fn split_at(self, mid: usize) -> (Self, Self) {
        let (left, right) = self.refs.split_at_mut(mid);
        (Self { refs: left }, Self { refs: right })
    }
}
