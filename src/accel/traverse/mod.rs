//! The walk of a ray through a tree: one loop per layout, generic over the instructions, the query, the probe and the
//! leaves.
//!
//! Everything on the way down to a leaf is inlined into the functions of [`at_level!`], so that it is compiled for their
//! instructions.

mod boxes;
pub mod packet;
mod probe;

use fearless_simd::{Fallback, Simd};

use crate::geometry::{PreparedRay, Ray};
use crate::{at_level, each_width};

use super::simd::{Instructions, SimdToken};
use super::tree::{ChildRef, Tree, Walked};

use boxes::{BoxLanes, Entered, TreeRay};

pub use probe::{Probe, RayCounters, Step, Watch};

/// What lies in the leaves, in leaf order. Asked with a leaf's index.
pub trait LeafIntersector {
    /// What is known of the nearest hit while a ray walks.
    type Best<'a>
    where
        Self: 'a;

    /// Asks for what the leaf's test will read ([`Instructions::prefetch`]).
    #[inline(always)]
    fn prefetch<S: Instructions>(&self, _simd: S, _leaf_idx: u32) {}

    /// Nothing behind this can be the nearest hit.
    fn t_max(best: &Self::Best<'_>) -> f32;

    /// Tests every shape of the leaf and keeps the nearest in `best` ([`Hit::is_beaten_by`](crate::geometry::Hit)).
    fn intersect<'a, S: Simd, P: Probe>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        best: &mut Self::Best<'a>,
        probe: &mut P,
    );

    /// The first shape found in the leaf (not the nearest) that the ray hits and that `blocks` says stops it.
    fn occluded<S: Simd, P: Probe>(
        &self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32>;
}

/// What a walk is after.
trait Query<'l, L: LeafIntersector> {
    /// Boxes that begin behind this are of no interest.
    fn t_max(&self) -> f32;

    /// Tests a leaf; answers whether the walk is over.
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool;
}

struct Nearest<'b, 'l, L: LeafIntersector + 'l> {
    best: &'b mut L::Best<'l>,
}

impl<'l, L: LeafIntersector> Query<'l, L> for Nearest<'_, 'l, L> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        L::t_max(self.best)
    }

    #[inline(always)]
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool {
        leaves.intersect(simd, leaf_idx, ray, self.best, probe);
        false
    }
}

struct Any<'a, F> {
    t_max: f32,
    blocks: &'a F,
    found: Option<u32>,
}

impl<'l, L: LeafIntersector, F: Fn(u32) -> bool> Query<'l, L> for Any<'_, F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool {
        self.found = leaves.occluded(simd, leaf_idx, ray, self.blocks, probe);
        self.found.is_some()
    }
}

/// The nearest hit that comes before what is in `best`, which is replaced if one is found.
///
/// Boxes are tested with the arithmetic of [`Slabs`](crate::geometry::Slabs), prepared once a ray for the tree's bounds:
/// shapes confine their hits by the same arithmetic, so no order of boxes can lose one.
#[inline]
pub fn intersect<'l, L: LeafIntersector, P: Probe>(
    simd: SimdToken,
    tree: &Tree,
    leaves: &'l L,
    ray: &Ray,
    best: &mut L::Best<'l>,
    probe: &mut P,
) {
    let mut full = Vec::new();
    let mut query = Nearest::<L> { best };
    each_width!(tree, t => at_level!(simd, simd => walk(simd, t.walked(), leaves, ray, &mut query, probe, &mut full)));
}

/// Any shape between `t_min` and `t_max` that `blocks` says stops the ray: its index, or `None` for a free way.
/// Same child order as [`intersect`].
#[inline]
pub fn occluded<L: LeafIntersector, P: Probe>(
    simd: SimdToken,
    tree: &Tree,
    leaves: &L,
    ray: &Ray,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut P,
) -> Option<u32> {
    let mut full = Vec::new();
    let mut query = Any { t_max: ray.last(), blocks, found: None };
    each_width!(tree, t => at_level!(simd, simd => walk(simd, t.walked(), leaves, ray, &mut query, probe, &mut full)));
    query.found
}

/// As [`intersect`], with somebody who is told of every step. By the instructions that every processor has, which make the
/// same steps as all others.
pub fn watch_nearest<'l, L: LeafIntersector>(
    tree: &Tree,
    leaves: &'l L,
    ray: &Ray,
    best: &mut L::Best<'l>,
    watch: &mut Watch,
) {
    let (simd, mut full) = (Fallback::new(), Vec::new());
    let mut query = Nearest::<L> { best };
    each_width!(tree, t => walk(simd, t.walked(), leaves, ray, &mut query, watch, &mut full));
}

/// As [`occluded`], with somebody who is told of every step; see [`watch_nearest`].
pub fn watch_any<L: LeafIntersector>(
    tree: &Tree,
    leaves: &L,
    ray: &Ray,
    blocks: &impl Fn(u32) -> bool,
    watch: &mut Watch,
) -> Option<u32> {
    let (simd, mut full) = (Fallback::new(), Vec::new());
    let mut query = Any { t_max: ray.last(), blocks, found: None };
    each_width!(tree, t => walk(simd, t.walked(), leaves, ray, &mut query, watch, &mut full));
    query.found
}

/// Whether a ray meets the root's box. One that does not visits nothing.
#[inline]
pub fn hits_root(tree: &Tree, ray: &Ray) -> bool {
    tree.node_count() > 0 && TreeRay::new(Fallback::new(), ray, &tree.bounds(), ray.last()).is_some()
}

/// A node that waits on the stack: the bits of where the ray enters it, then its reference. The nearer one is the smaller
/// number; of equally near ones that with the smaller reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
    /// Below all others: the walk is over.
    const NONE: Self = Self((f32::NEG_INFINITY.to_bits() as u64) << 32 | ChildRef::EMPTY.0 as u64);

    #[inline(always)]
    fn new(child: ChildRef, entry: f32) -> Self {
        Self(u64::from(entry.to_bits()) << 32 | u64::from(child.0))
    }

    #[inline(always)]
    fn child(self) -> ChildRef {
        ChildRef(self.0 as u32)
    }

    #[inline(always)]
    fn entry(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}

/// Cleared for every ray, so small; the few rays that need more go on with one of [`full_stack`].
const SMALL_STACK: usize = 32;

/// Enough for any ray: each level of the tree leaves at most all children but one behind. So a tree may be of any depth.
fn full_stack<const N: usize>(depth_max: u32) -> usize {
    (N - 1) * depth_max as usize + N + 1
}

/// Bytes of nodes from which on it pays to ask for them before they are needed.
const CACHED: usize = 1 << 21;

/// The one traversal loop.
///
/// Tried and lost, with nodes of 8 and one ray at a time:
/// - children in an order by the ray's octant, kept with the node, pushed by one permutation without a branch: the same
///   visits but for 4 percent, and the same speed;
/// - `side * inverse - origin * inverse` as one fused operation: 3 to 5 percent faster where rays visit many nodes, nothing
///   where they visit few, and all levels would have to fuse;
/// - asking for all that waits also in trees that fit the caches: 3 to 5 percent slower; pages of 2 MB: no difference;
/// - which child comes first by minima, without a branch: 15 to 20 percent slower for coherent rays at width 8, 30 to 50
///   percent slower at width 2 (see the comment below).
///
/// Walking 4 to 32 rays in turns, each a step, is worth half as much again in trees that do not fit the caches, a fifth for
/// coherent rays, and nothing elsewhere.
#[inline(always)]
fn walk<
    'l,
    S: Instructions,
    const N: usize,
    T: BoxLanes<S, N>,
    L: LeafIntersector,
    Q: Query<'l, L>,
    P: Probe,
>(
    simd: S,
    bvh: Walked<T>,
    leaves: &'l L,
    ray: &Ray,
    query: &mut Q,
    probe: &mut P,
    full: &mut Vec<Waiting>,
) {
    if let Some(tree_ray) = TreeRay::new(simd, ray, bvh.bounds, query.t_max()) {
        let start = Start { node: bvh.root, ray, tree_ray: &tree_ray };
        walk_below(simd, bvh, start, leaves, query, probe, full);
    }
}

/// A ray, and the node from which on it walks: one that it enters before its end.
#[derive(Clone, Copy)]
struct Start<'r> {
    node: ChildRef,
    ray: &'r Ray,
    tree_ray: &'r TreeRay,
}

/// The walk from a node on.
#[inline(always)]
fn walk_below<
    'l,
    S: Instructions,
    const N: usize,
    T: BoxLanes<S, N>,
    L: LeafIntersector,
    Q: Query<'l, L>,
    P: Probe,
>(
    simd: S,
    bvh: Walked<T>,
    start: Start,
    leaves: &'l L,
    query: &mut Q,
    probe: &mut P,
    full: &mut Vec<Waiting>,
) {
    let Start { node: mut next, ray, tree_ray } = start;
    let mut t_max = query.t_max();
    let lanes = T::spread(simd, tree_ray);
    let mut prepared = None;
    let mut full = Some(full);
    let mut small = [Waiting::NONE; SMALL_STACK];
    let nodes = bvh.nodes;
    // The nodes that wait, the nearest on top.
    let mut stack = &mut small[..];
    let mut height = 1;
    let large = size_of_val(nodes) > CACHED;
    loop {
        // A loop of its own that calls nothing, so that what a node's test needs stays in registers on the way down.
        while let Some(node_idx) = next.as_inner()
            && height + N <= stack.len()
        {
            let node = &nodes[node_idx as usize];
            probe.inner_visited(node_idx, node.child_count() as u32);
            let Entered { slots, entries } = node.enter(simd, &lanes, t_max);
            probe.boxes_tested(node_idx, t_max, slots, &entries);
            if slots == 0 {
                next = popped(stack, &mut height, t_max, probe);
                continue;
            }
            // Which child comes first is found by branches, not by minima: the processor guesses it, begins with the next
            // node, and checks the guess when the boxes are tested. Minima would make it wait for every node.
            let (mut nearest_slot, mut rest) = lowest::<N>(slots);
            if rest == 0 {
                next = node.child(guessed::<N>(nearest_slot));
                continue;
            }
            let waiting = |slot: usize| Waiting::new(node.child(slot), entries[slot]);
            let mut nearest = waiting(nearest_slot);
            let mut before = |slot: usize, nearest: &mut Waiting| {
                let other = waiting(slot);
                if other < *nearest {
                    unlikely();
                    nearest_slot = slot;
                    std::mem::replace(nearest, other)
                } else {
                    other
                }
            };
            let (slot, left) = lowest::<N>(rest);
            rest = left;
            let second = before(slot, &mut nearest);
            if large {
                fetch(simd, nodes, leaves, second.child());
            }
            if rest == 0 {
                stack[height] = second;
                height += 1;
            } else {
                // The order of what waits is nothing that the next node depends on: two of them without a branch.
                let (slot, left) = lowest::<N>(rest);
                rest = left;
                let third = before(slot, &mut nearest);
                if large {
                    fetch(simd, nodes, leaves, third.child());
                }
                let bottom = height;
                stack[height] = second.max(third);
                stack[height + 1] = second.min(third);
                height += 2;
                while rest != 0 {
                    let (slot, left) = lowest::<N>(rest);
                    rest = left;
                    let farther = before(slot, &mut nearest);
                    let mut at = height;
                    while at > bottom && stack[at - 1] < farther {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = farther;
                    height += 1;
                }
            }
            next = node.child(guessed::<N>(nearest_slot));
        }
        let Some(leaf_idx) = next.as_leaf() else {
            if next.is_empty() {
                return;
            }
            let unused = full.take().expect("the full stack is enough for every tree");
            stack = enlarged(unused, &stack[..height], full_stack::<N>(bvh.depth_max));
            continue;
        };
        probe.leaf_visited(leaf_idx);
        let over = simd.apart(
            #[inline(always)]
            || {
                let ray = prepared.get_or_insert_with(
                    #[inline(always)]
                    || PreparedRay::new(*ray),
                );
                query.leaf(simd, leaf_idx, leaves, ray, probe)
            },
        );
        if over {
            return;
        }
        t_max = query.t_max();
        next = popped(stack, &mut height, t_max, probe);
    }
}

/// Says that a way is taken seldom, so that it stays a branch.
#[cold]
#[inline]
fn unlikely() {}

/// The lowest slot that is set, and the others.
#[inline(always)]
fn lowest<const N: usize>(slots: u32) -> (usize, u32) {
    (slots.trailing_zeros() as usize % N, slots & (slots - 1))
}

/// The same slot, by branches, so that the processor guesses the next node and begins with it.
#[inline(always)]
fn guessed<const N: usize>(slot: usize) -> usize {
    let part = |slot: usize| {
        if slot & 2 == 0 {
            if slot & 1 == 0 {
                0
            } else {
                unlikely();
                1
            }
        } else {
            unlikely();
            if slot & 1 == 0 {
                2
            } else {
                unlikely();
                3
            }
        }
    };
    if N == 2 {
        return if slot == 0 {
            0
        } else {
            unlikely();
            1
        };
    }
    let half = |slot: usize| {
        if slot & 4 == 0 {
            part(slot)
        } else {
            unlikely();
            4 + part(slot)
        }
    };
    if N <= 8 || slot & 8 == 0 {
        half(slot) % N
    } else {
        unlikely();
        (8 + half(slot)) % N
    }
}

/// Asks for a node that waits.
#[inline(always)]
fn fetch<S: Instructions, T, L: LeafIntersector>(simd: S, nodes: &[T], leaves: &L, child: ChildRef) {
    match child.as_leaf() {
        Some(leaf_idx) => leaves.prefetch(simd, leaf_idx),
        None => simd.prefetch(nodes, child.0 as usize),
    }
}

/// The nearest node that waits and begins before `t_max`.
#[inline(always)]
fn popped<P: Probe>(stack: &[Waiting], height: &mut usize, t_max: f32, probe: &mut P) -> ChildRef {
    loop {
        *height -= 1;
        let waiting = stack[*height];
        probe.popped(waiting.child(), waiting.entry(), t_max);
        if waiting.entry() <= t_max {
            return waiting.child();
        }
    }
}

/// A full stack with what waits on the small one.
#[cold]
fn enlarged<'a>(full: &'a mut Vec<Waiting>, waiting: &[Waiting], size: usize) -> &'a mut [Waiting] {
    full.resize(size, Waiting::NONE);
    full[..waiting.len()].copy_from_slice(waiting);
    full
}

#[cfg(test)]
mod tests;
