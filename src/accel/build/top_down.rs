//! The loop that all top-down builders share: stop, ask the builder for a split, go on with both sides.

use crate::accel::config::{BuildConfig, StopRule};
use crate::accel::tree::{Bvh2, Bvh2Node};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::PhaseClock;
use super::order::Order;

/// Below this many references both sides are built one after the other.
const JOIN_MIN: usize = 1024;
/// Below this many references a subtree neither looks at the cancel flag nor reports progress (well under 1 ms).
const CHECK_MIN: usize = 512;

/// A split that a builder found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub axis: usize,
    /// References on the left (sweep), or the first bin on the right (binned).
    pub position: usize,
    /// `N_left * A_left + N_right * A_right`, A = half areas.
    pub cost: f32,
    /// Of the bins: `floor(scale * (centroid - origin))`.
    pub scale: f32,
    pub origin: f32,
}

/// A builder's own step.
pub trait Splitter<O: Order>: Sync {
    /// Whether [`Candidate::cost`] means something, so that the stop rule `cost` can weigh it.
    const WEIGHS_COST: bool;

    /// The split that this builder prefers, or `None` if nothing separates the references.
    fn find(&self, order: &mut O, bounds: &Aabb) -> Option<Candidate>;

    /// Orders the references so that those on the left come first; answers how many they are (neither none nor all).
    fn apply(&self, order: &mut O, split: &Candidate) -> usize;
}

/// What stays the same over a build.
struct Context<'a, S> {
    splitter: &'a S,
    config: &'a BuildConfig,
    task: &'a Task,
}

/// Where a subtree is written: its root, and the slots that its descendants may fill (twice its references, less two).
/// Every subtree has its own slots, so subtrees can be built at the same time and come out the same.
struct Slots<'a> {
    root: &'a mut Bvh2Node,
    below: &'a mut [Bvh2Node],
    /// Index of `below[0]` among all slots.
    below_idx: usize,
    /// The node's share of the output order, and the index of its first element.
    shapes: &'a mut [u32],
    first: usize,
    depth: usize,
}

const UNUSED: Bvh2Node = Bvh2Node { bounds: Aabb::EMPTY, first: 0, count: 0 };

/// Builds the binary tree over all references of `order`.
pub fn build<O: Order, S: Splitter<O>>(
    order: O,
    splitter: &S,
    config: &BuildConfig,
    task: &Task,
    clock: &mut PhaseClock,
) -> Result<Bvh2, Cancelled> {
    let count = order.len();
    if count == 0 {
        return Ok(Bvh2::default());
    }
    let mut slots = vec![UNUSED; 2 * count - 1];
    let mut shapes = vec![0; count];
    let (root, below) = slots.split_first_mut().expect("at least one slot");
    let context = Context { splitter, config, task };
    build_node(
        &context,
        order,
        Slots { root, below, below_idx: 1, shapes: &mut shapes, first: 0, depth: 0 },
    )?;
    clock.finish("split");
    let nodes = compact(&slots);
    clock.finish("layout");
    Ok(Bvh2 { nodes, refs: shapes })
}

fn build_node<O: Order, S: Splitter<O>>(
    context: &Context<'_, S>,
    mut order: O,
    slots: Slots<'_>,
) -> Result<(), Cancelled> {
    let count = order.len();
    if count >= CHECK_MIN {
        context.task.check()?;
    }
    let bounds = order.bounds();
    let Some(mid) = split(context, &mut order, &bounds, slots.depth) else {
        write_leaf(&order, bounds, slots);
        return Ok(());
    };
    *slots.root = Bvh2Node { bounds, first: slots.below_idx as u32, count: 0 };
    let (children, below) = slots.below.split_at_mut(2);
    let [left_root, right_root] = children else { unreachable!("two slots were split off") };
    let (left_below, right_below) = below.split_at_mut(2 * mid - 2);
    let (left_shapes, right_shapes) = slots.shapes.split_at_mut(mid);
    let (left_order, right_order) = order.split_at(mid);
    let below_idx = slots.below_idx + 2;
    let depth = slots.depth + 1;
    let right = Slots {
        root: right_root,
        below_idx: below_idx + left_below.len(),
        below: right_below,
        shapes: right_shapes,
        first: slots.first + mid,
        depth,
    };
    let left = Slots {
        root: left_root,
        below: left_below,
        below_idx,
        shapes: left_shapes,
        first: slots.first,
        depth,
    };
    if count >= JOIN_MIN {
        let (a, b) =
            rayon::join(|| build_node(context, left_order, left), || build_node(context, right_order, right));
        a.and(b)?;
    } else {
        build_node(context, left_order, left)?;
        build_node(context, right_order, right)?;
    }
    report_progress(context.task, count, mid);
    Ok(())
}

/// Counts references once: at the topmost node of each subtree that is small.
fn report_progress(task: &Task, count: usize, mid: usize) {
    if count >= CHECK_MIN {
        let small = |n: usize| if n < CHECK_MIN { n as u64 } else { 0 };
        task.advance(small(mid) + small(count - mid));
    }
}

fn write_leaf<O: Order>(order: &O, bounds: Aabb, slots: Slots<'_>) {
    for (i, shape) in slots.shapes.iter_mut().enumerate() {
        *shape = order.shape(i);
    }
    slots.shapes.sort_unstable();
    *slots.root = Bvh2Node { bounds, first: slots.first as u32, count: order.len() as u32 };
}

/// Splits the references, or answers `None` for a leaf.
fn split<O: Order, S: Splitter<O>>(
    context: &Context<'_, S>,
    order: &mut O,
    bounds: &Aabb,
    depth: usize,
) -> Option<usize> {
    let config = context.config;
    let count = order.len();
    let fits_leaf = count <= config.leaf;
    if count == 1 || (fits_leaf && (config.stop == StopRule::Limit || !S::WEIGHS_COST)) {
        return None;
    }
    let found = context.splitter.find(order, bounds);
    if fits_leaf && found.is_none_or(|split| !pays(config, count, bounds, &split)) {
        return None;
    }
    if let Some(split) = found {
        let mid = context.splitter.apply(order, &split);
        debug_assert!(mid > 0 && mid < count, "a split leaves references on both sides");
        if fits_depth(config, mid.max(count - mid), depth + 1) {
            return Some(mid);
        }
    }
    Some(order.split_middle(bounds.longest_axis()))
}

/// Whether a split lowers the SAH cost below that of a leaf; areas as half areas.
fn pays(config: &BuildConfig, count: usize, bounds: &Aabb, split: &Candidate) -> bool {
    let area = bounds.half_area();
    let leaf_cost = config.intersection_cost * count as f32 * area;
    leaf_cost > config.traversal_cost * area + config.intersection_cost * split.cost
}

/// Whether `count` references at `depth` can still be halved down to leaves within the depth limit.
fn fits_depth(config: &BuildConfig, count: usize, depth: usize) -> bool {
    let levels = BuildConfig::MAX_DEPTH - depth.min(BuildConfig::MAX_DEPTH);
    let most = if levels >= 40 { usize::MAX } else { config.leaf << levels };
    count <= most
}

/// The used slots in depth-first order, siblings side by side.
fn compact(slots: &[Bvh2Node]) -> Vec<Bvh2Node> {
    let mut nodes = Vec::with_capacity(slots.len());
    nodes.push(slots[0]);
    let mut open = vec![0_usize];
    while let Some(node_idx) = open.pop() {
        let node = nodes[node_idx];
        if node.is_leaf() {
            continue;
        }
        let pair = nodes.len();
        let first = node.first as usize;
        nodes.extend_from_slice(&slots[first..first + 2]);
        nodes[node_idx].first = pair as u32;
        open.push(pair + 1);
        open.push(pair);
    }
    nodes
}
