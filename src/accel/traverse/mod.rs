//! The walk of a ray through a tree: one loop per layout, generic over the instructions, the query, the probe and the
//! leaves.
//!
//! Everything on the way down to a leaf is inlined into the functions of [`at_level!`], so that it is compiled for their
//! instructions.

mod boxes;

use fearless_simd::{Fallback, Simd};

use crate::each_width;
use crate::geometry::{Hit, PreparedRay};

use super::config::BuildConfig;
use super::tree::{ChildRef, Tree, WideBvh, WideNode};

use boxes::{BoxLanes, Entered, TreeRay};

/// Looks on while a ray walks a tree. The empty probe `()` costs nothing.
pub trait Probe {
    /// An inner node whose `box_tests` valid children's boxes are tested.
    fn inner_visited(&mut self, node_idx: u32, box_tests: u32);
    /// A leaf whose shapes are tested.
    fn leaf_visited(&mut self, leaf_idx: u32);
    /// `count` shapes (valid lanes of a block) are tested.
    fn shapes_tested(&mut self, count: u32);
}

impl Probe for () {
    #[inline(always)]
    fn inner_visited(&mut self, _: u32, _: u32) {}
    #[inline(always)]
    fn leaf_visited(&mut self, _: u32) {}
    #[inline(always)]
    fn shapes_tested(&mut self, _: u32) {}
}

/// Counts of one ray, or sums over many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounters {
    pub inner_visits: u64,
    pub leaf_visits: u64,
    pub box_tests: u64,
    pub shape_tests: u64,
}

impl RayCounters {
    /// Inner visits + leaf visits.
    pub fn nodes_visited(&self) -> u64 {
        self.inner_visits + self.leaf_visits
    }

    /// `C_t * inner visits + C_i * shape tests`.
    pub fn ray_cost(&self, traversal_cost: f32, intersection_cost: f32) -> f64 {
        f64::from(traversal_cost) * self.inner_visits as f64
            + f64::from(intersection_cost) * self.shape_tests as f64
    }
}

impl std::ops::AddAssign for RayCounters {
    fn add_assign(&mut self, other: Self) {
        self.inner_visits += other.inner_visits;
        self.leaf_visits += other.leaf_visits;
        self.box_tests += other.box_tests;
        self.shape_tests += other.shape_tests;
    }
}

impl Probe for RayCounters {
    #[inline]
    fn inner_visited(&mut self, _: u32, box_tests: u32) {
        self.inner_visits += 1;
        self.box_tests += u64::from(box_tests);
    }
    #[inline]
    fn leaf_visited(&mut self, _: u32) {
        self.leaf_visits += 1;
    }
    #[inline]
    fn shapes_tested(&mut self, count: u32) {
        self.shape_tests += u64::from(count);
    }
}

/// What lies in the leaves, in leaf order. Asked with a leaf's index.
pub trait LeafIntersector {
    /// Tests every shape of the leaf and keeps the nearest in `hit` ([`Hit::is_beaten_by`]).
    fn intersect<S: Simd, P: Probe>(
        &self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        hit: &mut Hit,
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
trait Query<L: LeafIntersector> {
    /// Boxes that begin behind this are of no interest.
    fn t_max(&self) -> f32;

    /// Tests a leaf; answers whether the walk is over.
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool;
}

struct Nearest<'a> {
    hit: &'a mut Hit,
}

impl<L: LeafIntersector> Query<L> for Nearest<'_> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.hit.t
    }

    #[inline(always)]
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool {
        leaves.intersect(simd, leaf_idx, ray, self.hit, probe);
        false
    }
}

struct Any<'a, F> {
    t_max: f32,
    blocks: &'a F,
    found: Option<u32>,
}

impl<L: LeafIntersector, F: Fn(u32) -> bool> Query<L> for Any<'_, F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn leaf<S: Simd, P: Probe>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &L,
        ray: &PreparedRay,
        probe: &mut P,
    ) -> bool {
        self.found = leaves.occluded(simd, leaf_idx, ray, self.blocks, probe);
        self.found.is_some()
    }
}

/// The nearest hit at or before `hit.t`, which is replaced if one is found.
///
/// Boxes are tested with the arithmetic of [`Slabs`], prepared once a ray for the tree's bounds: shapes confine their
/// hits by the same arithmetic, so no order of boxes can lose one.
#[inline(always)]
pub fn intersect<S: Simd, L: LeafIntersector, P: Probe>(
    simd: S,
    tree: &Tree,
    leaves: &L,
    ray: &PreparedRay,
    hit: &mut Hit,
    probe: &mut P,
) {
    let mut query = Nearest { hit };
    each_width!(tree, t => walk(simd, t, leaves, ray, &mut query, probe));
}

/// Any shape between `t_min` and `t_max` that `blocks` says stops the ray: its index, or `None` for a free way.
/// Same child order as [`intersect`].
#[inline(always)]
pub fn occluded<S: Simd, L: LeafIntersector, P: Probe>(
    simd: S,
    tree: &Tree,
    leaves: &L,
    ray: &PreparedRay,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut P,
) -> Option<u32> {
    let mut query = Any { t_max: ray.ray.t_max, blocks, found: None };
    each_width!(tree, t => walk(simd, t, leaves, ray, &mut query, probe));
    query.found
}

/// Whether a ray meets the root's box. One that does not visits nothing.
#[inline]
pub fn hits_root(tree: &Tree, ray: &PreparedRay) -> bool {
    tree.node_count() > 0 && TreeRay::new(Fallback::new(), ray, &tree.bounds(), ray.ray.t_max).is_some()
}

/// A node that waits on the stack: the bits of where the ray enters it, then its reference. The nearer one is the smaller
/// number; of equally near ones that with the smaller reference.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Waiting(u64);

impl Waiting {
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

/// Cleared for every ray, so small; the few rays that need more go on with [`FULL_STACK`].
const SMALL_STACK: usize = 32;
/// Enough for eight children a node at the greatest depth: each level leaves at most seven behind.
const FULL_STACK: usize = 7 * BuildConfig::MAX_DEPTH + 8;

/// The one traversal loop.
#[inline(always)]
fn walk<S: Simd, const N: usize, L: LeafIntersector, Q: Query<L>, P: Probe>(
    simd: S,
    bvh: &WideBvh<N>,
    leaves: &L,
    ray: &PreparedRay,
    query: &mut Q,
    probe: &mut P,
) where
    WideNode<N>: BoxLanes<S, N>,
{
    if bvh.root.is_empty() {
        return;
    }
    let Some(tree_ray) = TreeRay::new(simd, ray, &bvh.bounds, query.t_max()) else { return };
    let lanes = WideNode::spread(simd, &tree_ray);
    let (mut small, mut full) = ([Waiting(0); SMALL_STACK], Vec::new());
    let mut unused = Some(&mut full);
    // The nodes that wait, the nearest on top.
    let mut stack = &mut small[..];
    let mut height = 0;
    let mut next = bvh.root;
    loop {
        if let Some(leaf_idx) = next.as_leaf() {
            probe.leaf_visited(leaf_idx);
            if query.leaf(simd, leaf_idx, leaves, ray, probe) {
                return;
            }
        } else {
            if height + N > stack.len()
                && let Some(unused) = unused.take()
            {
                stack = enlarged(unused, &stack[..height]);
            }
            let node = &bvh.nodes[next.0 as usize];
            probe.inner_visited(next.0, node.child_count() as u32);
            let Entered { slots, entries } = node.enter(simd, &lanes, query.t_max());
            if slots != 0 {
                let take = |slots: u32| {
                    let slot = slots.trailing_zeros() as usize;
                    (Waiting::new(node.children[slot], entries[slot]), slots & (slots - 1))
                };
                // One, two and three children are the common cases, and sorted without a branch.
                let (first, rest) = take(slots);
                if rest == 0 {
                    next = first.child();
                    continue;
                }
                let (second, rest) = take(rest);
                let (near, far) = (first.min(second), first.max(second));
                if rest == 0 {
                    stack[height] = far;
                    height += 1;
                    next = near.child();
                    continue;
                }
                let (third, mut rest) = take(rest);
                let mut nearest = near.min(third);
                let third = near.max(third);
                stack[height] = far.max(third);
                stack[height + 1] = far.min(third);
                let bottom = height;
                height += 2;
                while rest != 0 {
                    let (other, left) = take(rest);
                    rest = left;
                    let farther = nearest.max(other);
                    nearest = nearest.min(other);
                    let mut at = height;
                    while at > bottom && stack[at - 1] < farther {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = farther;
                    height += 1;
                }
                next = nearest.child();
                continue;
            }
        }
        loop {
            if height == 0 {
                return;
            }
            height -= 1;
            if stack[height].entry() <= query.t_max() {
                next = stack[height].child();
                break;
            }
        }
    }
}

/// A full stack with what waits on the small one.
#[cold]
fn enlarged<'a>(full: &'a mut Vec<Waiting>, waiting: &[Waiting]) -> &'a mut [Waiting] {
    full.resize(FULL_STACK, Waiting(0));
    full[..waiting.len()].copy_from_slice(waiting);
    full
}

#[cfg(test)]
mod tests;
