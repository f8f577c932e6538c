//! The walk of a ray through a tree: one loop per layout, generic over the query, the probe and the leaves.

use crate::each_width;
use crate::geometry::{Aabb, Hit, PreparedRay, Slabs};

use super::config::BuildConfig;
use super::tree::{ChildRef, Tree, WideBvh, WideNode};

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
    fn intersect<P: Probe>(&self, leaf_idx: u32, ray: &PreparedRay, hit: &mut Hit, probe: &mut P);

    /// The first shape found in the leaf (not the nearest) that the ray hits and that `blocks` says stops it.
    fn occluded<P: Probe>(
        &self,
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
    fn leaf<P: Probe>(&mut self, leaf_idx: u32, leaves: &L, ray: &PreparedRay, probe: &mut P) -> bool;
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
    fn leaf<P: Probe>(&mut self, leaf_idx: u32, leaves: &L, ray: &PreparedRay, probe: &mut P) -> bool {
        leaves.intersect(leaf_idx, ray, self.hit, probe);
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
    fn leaf<P: Probe>(&mut self, leaf_idx: u32, leaves: &L, ray: &PreparedRay, probe: &mut P) -> bool {
        self.found = leaves.occluded(leaf_idx, ray, self.blocks, probe);
        self.found.is_some()
    }
}

/// The nearest hit at or before `hit.t`, which is replaced if one is found.
///
/// Boxes are tested with the arithmetic of [`Slabs`], prepared once a ray for the tree's bounds: shapes confine their
/// hits by the same arithmetic, so no order of boxes can lose one.
#[inline]
pub fn intersect<L: LeafIntersector, P: Probe>(
    tree: &Tree,
    leaves: &L,
    ray: &PreparedRay,
    hit: &mut Hit,
    probe: &mut P,
) {
    let mut query = Nearest { hit };
    each_width!(tree, t => walk(t, leaves, ray, &mut query, probe));
}

/// Any shape between `t_min` and `t_max` that `blocks` says stops the ray: its index, or `None` for a free way.
/// Same child order as [`intersect`].
#[inline]
pub fn occluded<L: LeafIntersector, P: Probe>(
    tree: &Tree,
    leaves: &L,
    ray: &PreparedRay,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut P,
) -> Option<u32> {
    let mut query = Any { t_max: ray.ray.t_max, blocks, found: None };
    each_width!(tree, t => walk(t, leaves, ray, &mut query, probe));
    query.found
}

/// Whether a ray meets the root's box. One that does not visits nothing.
#[inline]
pub fn hits_root(tree: &Tree, ray: &PreparedRay) -> bool {
    tree.node_count() > 0 && BoxTest::new(ray, &tree.bounds()).entry(&tree.bounds(), ray.ray.t_max).is_some()
}

fn walk<const N: usize, L: LeafIntersector, Q: Query<L>, P: Probe>(
    bvh: &WideBvh<N>,
    leaves: &L,
    ray: &PreparedRay,
    query: &mut Q,
    probe: &mut P,
) {
    // Each level leaves at most N - 1 nodes behind on the stack. The small stack is cleared faster.
    let needed = (N - 1) * bvh.depth_max as usize + 1;
    if needed <= SMALL_STACK {
        walk_with_stack::<N, SMALL_STACK, L, Q, P>(bvh, leaves, ray, query, probe);
    } else {
        walk_with_stack::<N, FULL_STACK, L, Q, P>(bvh, leaves, ray, query, probe);
    }
}

const SMALL_STACK: usize = 96;
/// Enough for eight children a node at the greatest depth.
const FULL_STACK: usize = 7 * BuildConfig::MAX_DEPTH + 1;

/// The one traversal loop.
fn walk_with_stack<const N: usize, const STACK: usize, L: LeafIntersector, Q: Query<L>, P: Probe>(
    bvh: &WideBvh<N>,
    leaves: &L,
    ray: &PreparedRay,
    query: &mut Q,
    probe: &mut P,
) {
    let boxes = BoxTest::new(ray, &bvh.bounds);
    if bvh.root.is_empty() || boxes.entry(&bvh.bounds, query.t_max()).is_none() {
        return;
    }
    let mut stack = [(ChildRef::EMPTY, 0.0_f32); STACK];
    let mut height = 0;
    let mut next = bvh.root;
    loop {
        if let Some(leaf_idx) = next.as_leaf() {
            probe.leaf_visited(leaf_idx);
            if query.leaf(leaf_idx, leaves, ray, probe) {
                return;
            }
        } else {
            let node_idx = next.0;
            let node = &bvh.nodes[node_idx as usize];
            probe.inner_visited(node_idx, node.child_count() as u32);
            let entries = boxes.entries(node, query.t_max());
            height = push_by_distance(node, &entries, &mut stack, height);
        }
        loop {
            if height == 0 {
                return;
            }
            height -= 1;
            let (child, t_near) = stack[height];
            if t_near <= query.t_max() {
                next = child;
                break;
            }
        }
    }
}

/// Pushes the children that are entered, the nearest on top; of equally near ones the first slot. Answers the new
/// height.
#[inline(always)]
fn push_by_distance<const N: usize, const STACK: usize>(
    node: &WideNode<N>,
    entries: &[f32; N],
    stack: &mut [(ChildRef, f32); STACK],
    height: usize,
) -> usize {
    let mut top = height;
    for (slot, &t_near) in entries.iter().enumerate() {
        if t_near == f32::INFINITY {
            continue;
        }
        let mut at = top;
        while at > height && stack[at - 1].1 <= t_near {
            stack[at] = stack[at - 1];
            at -= 1;
        }
        stack[at] = (node.children[slot], t_near);
        top += 1;
    }
    top
}

/// The slab test of one ray against the boxes of one tree: the arithmetic of [`Slabs`], over all children at once.
struct BoxTest {
    slabs: Slabs,
    /// Whether the ray enters through the maximum along an axis. True for a direction of -0, whose inverse is -infinity.
    flipped: [bool; 3],
    t_min: f32,
}

impl BoxTest {
    #[inline(always)]
    fn new(ray: &PreparedRay, within: &Aabb) -> Self {
        let inv = ray.inv_direction;
        Self {
            slabs: Slabs::new(ray, within),
            flipped: [inv.x < 0.0, inv.y < 0.0, inv.z < 0.0],
            t_min: ray.ray.t_min,
        }
    }

    /// Where the ray enters each child's box; infinity where it does not before `t_max`, and for empty slots.
    ///
    /// The comparisons keep the first operand out when it is NaN (0 * infinity: the ray lies in a side's plane), so such a
    /// side never rejects.
    #[inline(always)]
    fn entries<const N: usize>(&self, node: &WideNode<N>, t_max: f32) -> [f32; N] {
        let mut near = [self.t_min; N];
        let mut far = [t_max; N];
        for axis in 0..3 {
            let (near_side, far_side) = if self.flipped[axis] {
                (&node.child_max[axis], &node.child_min[axis])
            } else {
                (&node.child_min[axis], &node.child_max[axis])
            };
            let inv = self.slabs.inv_direction[axis];
            let (near_origin, far_origin) = (self.slabs.near_origin[axis], self.slabs.far_origin[axis]);
            for (t, side) in near.iter_mut().zip(near_side) {
                let t_side = (side - near_origin) * inv;
                *t = if t_side > *t { t_side } else { *t };
            }
            for (t, side) in far.iter_mut().zip(far_side) {
                let t_side = (side - far_origin) * inv;
                *t = if t_side < *t { t_side } else { *t };
            }
        }
        std::array::from_fn(|slot| if near[slot] <= far[slot] { near[slot] } else { f32::INFINITY })
    }

    /// Where the ray enters one box, if it does before `t_max`.
    #[inline(always)]
    fn entry(&self, bounds: &Aabb, t_max: f32) -> Option<f32> {
        let mut node = WideNode::<1>::EMPTY;
        node.set_bounds(0, bounds);
        let [entry] = self.entries(&node, t_max);
        (entry < f32::INFINITY).then_some(entry)
    }
}

#[cfg(test)]
mod tests;
