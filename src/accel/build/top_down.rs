//! The loop that all top-down builders share: stop, ask the builder for a split, open children until the wide node is
//! full, go on with each of them.
//!
//! Nodes of any width are made at once, without a binary tree in between. A child is examined (its split is found)
//! when it appears, so that it is known which child is worth opening next ([`Widen`]):
//!
//! - `split` opens the child whose split lowers `sum N_i * A_i` most: direct multi-way splitting.
//! - `collapse` opens the child with the largest area (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008).

use std::marker::PhantomData;

use rayon::prelude::*;

use crate::accel::config::{BuildConfig, StopRule, Widen};
use crate::accel::tree::{ChildRef, LeafRange, WideBvh, WideNode};
use crate::task::{Cancelled, Task};

use super::PhaseClock;
use super::bound::Bound;
use super::order::Order;
use super::segment::{Segment, assemble};

/// Below this many references the children of a node are never shared among threads.
const FORK_MIN: usize = 1024;
/// Nodes shared among threads are at least this share of the references, a thread: more of them would only make more
/// pieces to put together.
const FORKS_A_THREAD: usize = 8;
/// Below this many references a subtree neither looks at the cancel flag nor reports progress (well under 1 ms).
pub(super) const CHECK_MIN: usize = 512;

/// A split that a builder found, with what it makes.
#[derive(Clone, Copy, Debug)]
pub struct Split<P> {
    /// `N_left * A_left + N_right * A_right`, A = half areas.
    pub cost: f32,
    pub left_count: usize,
    pub left: Bound,
    pub right: Bound,
    /// What [`Splitter::apply`] needs; `None` once the references are in order.
    pub plan: Option<P>,
}

/// A builder's own step.
pub trait Splitter<O: Order>: Sync {
    /// Whether [`Split::cost`] means something, so that the stop rule `cost` can weigh it.
    const WEIGHS_COST: bool;

    /// How the references are told apart.
    type Plan: Send;

    /// The split that this builder prefers, or `None` if nothing separates the references: then they are split at the
    /// object median.
    fn find(&self, order: &mut O, bounds: &Bound) -> Option<Split<Self::Plan>>;

    /// Orders the references so that those on the left come first.
    fn apply(&self, order: &mut O, plan: &Self::Plan);
}

/// What stays the same over a build.
struct Context<'a, O, S> {
    splitter: &'a S,
    config: &'a BuildConfig,
    task: &'a Task,
    fork_min: usize,
    order: PhantomData<fn(O)>,
}

/// A node of the binary tree that was examined: its references, and how they split.
struct Member<'a, O, P> {
    order: O,
    /// Its share of the output order, and the index of its first element.
    shapes: &'a mut [u32],
    first: u32,
    /// In the binary tree.
    depth: usize,
    bounds: Bound,
    /// `None` for a leaf.
    split: Option<Split<P>>,
}

/// Builds the tree over all references of `order`.
pub fn build<const N: usize, O: Order, S: Splitter<O>>(
    order: O,
    splitter: &S,
    config: &BuildConfig,
    task: &Task,
    clock: &mut PhaseClock,
) -> Result<WideBvh<N>, Cancelled> {
    let count = order.len();
    let mut tree = WideBvh::empty();
    if count == 0 {
        return Ok(tree);
    }
    let mut shapes = vec![0; count];
    let threads = rayon::current_num_threads();
    let fork_min = if threads == 1 { usize::MAX } else { FORK_MIN.max(count / (FORKS_A_THREAD * threads)) };
    let context = Context { splitter, config, task, fork_min, order: PhantomData };
    let bounds = order.bounds(0..count);
    let mut root = Member { order, shapes: &mut shapes, first: 0, depth: 0, bounds, split: None };
    context.examine(&mut root)?;
    tree.bounds = bounds.aabb();
    let segments = if root.split.is_some() {
        tree.root = ChildRef::inner(0);
        context.grown(root, 0)?
    } else {
        tree.root = ChildRef::leaf(0);
        let mut segment = Segment::default();
        segment.push_leaf(root.leaf(), 0);
        vec![segment]
    };
    if count < CHECK_MIN {
        task.advance(count as u64);
    }
    // What a splitter finds once the task is cancelled means nothing.
    task.check()?;
    clock.finish("split");
    assemble(segments, &mut tree);
    tree.refs = shapes;
    clock.finish("layout");
    Ok(tree)
}

impl<O: Order, P> Member<'_, O, P> {
    /// Writes the leaf's shapes, ascending.
    fn leaf(self) -> LeafRange {
        for (i, shape) in self.shapes.iter_mut().enumerate() {
            *shape = self.order.shape(i);
        }
        self.shapes.sort_unstable();
        LeafRange { first: self.first, count: self.shapes.len() as u32 }
    }

    /// What opening this node is worth; larger is sooner. `None` for a leaf.
    fn priority(&self, how: Widen) -> Option<f32> {
        let split = self.split.as_ref()?;
        let weight = |count: usize, bounds: &Bound| count as f32 * bounds.half_area();
        Some(match how {
            Widen::Collapse | Widen::Optimal => self.bounds.half_area(),
            Widen::Split => {
                let left = weight(split.left_count, &split.left);
                let right = weight(self.shapes.len() - split.left_count, &split.right);
                weight(self.shapes.len(), &self.bounds) - (left + right)
            }
        })
    }
}

impl<O: Order, S: Splitter<O>> Context<'_, O, S> {
    /// Finds the node's split, or finds that it is a leaf.
    #[inline]
    fn examine(&self, node: &mut Member<'_, O, S::Plan>) -> Result<(), Cancelled> {
        let config = self.config;
        let count = node.shapes.len();
        let fits_leaf = count <= config.leaf;
        if count == 1 || (fits_leaf && (config.stop == StopRule::Limit || !S::WEIGHS_COST)) {
            return Ok(());
        }
        node.split = self.splitter.find(&mut node.order, &node.bounds);
        if count >= CHECK_MIN {
            self.task.check()?;
        }
        let split = node.split.as_ref();
        if fits_leaf && split.is_none_or(|split| !pays(config, count, &node.bounds, split.cost)) {
            node.split = None;
        } else if split.is_none_or(|split| {
            debug_assert!(split.left_count > 0 && split.left_count < count, "references on both sides");
            !fits_depth(config, split.left_count.max(count - split.left_count), node.depth + 1)
        }) {
            let left_count = node.order.split_middle(node.bounds.aabb().longest_axis());
            let (left, right) = (node.order.bounds(0..left_count), node.order.bounds(left_count..count));
            node.split = Some(Split { cost: 0.0, left_count, left, right, plan: None });
        }
        Ok(())
    }

    /// Puts the two children of an inner node, examined, in the place of `slot` and before what follows it.
    #[inline(always)]
    fn open<'m>(
        &self,
        node: Member<'m, O, S::Plan>,
        members: &mut [Option<Member<'m, O, S::Plan>>],
        slot: usize,
    ) -> Result<(), Cancelled> {
        let Member { mut order, shapes, first, depth, split, .. } = node;
        let Split { left_count: mid, left, right, plan, .. } = split.expect("only inner nodes are opened");
        if let Some(plan) = plan {
            self.splitter.apply(&mut order, &plan);
            if shapes.len() >= CHECK_MIN {
                self.task.check()?;
            }
        }
        let (left_order, right_order) = order.split_at(mid);
        let (left_shapes, right_shapes) = shapes.split_at_mut(mid);
        let depth = depth + 1;
        let child =
            |order, shapes, first, bounds| Member { order, shapes, first, depth, bounds, split: None };
        members[slot + 1..].rotate_right(1);
        self.examine(members[slot].insert(child(left_order, left_shapes, first, left)))?;
        let right_first = first + mid as u32;
        self.examine(members[slot + 1].insert(child(right_order, right_shapes, right_first, right)))
    }

    /// Finds the children of the wide node at `node`, in spatial order.
    #[inline(always)]
    fn find_members<'m, const N: usize>(
        &self,
        node: Member<'m, O, S::Plan>,
        members: &mut [Option<Member<'m, O, S::Plan>>; N],
    ) -> Result<(), Cancelled> {
        self.open(node, &mut members[..2], 0)?;
        for count in 2..N {
            let priorities = members[..count].iter().enumerate().filter_map(|(slot, member)| {
                Some((slot, member.as_ref().and_then(|m| m.priority(self.config.widen))?))
            });
            // The first of the most worthy.
            let Some((slot, _)) = priorities.reduce(|a, b| if b.1 > a.1 { b } else { a }) else { break };
            let Some(member) = members[slot].take() else { break };
            self.open(member, &mut members[..=count], slot)?;
        }
        Ok(())
    }

    /// The subtree below an inner node, `depth` wide nodes below the root, in segments that were grown side by side.
    fn grown<const N: usize>(
        &self,
        node: Member<'_, O, S::Plan>,
        depth: u32,
    ) -> Result<Vec<Segment<N>>, Cancelled> {
        let count = node.shapes.len();
        if count < self.fork_min {
            let mut segment = Segment::with_room_for(count);
            self.grow(&mut Some(node), depth, &mut segment)?;
            return Ok(vec![segment]);
        }
        let mut top = Segment::with_room_for(N);
        let mut members = [const { None }; N];
        self.find_members(node, &mut members)?;
        let (_, small_count) = placed(&mut members, depth, &mut top);
        let inner: Vec<_> =
            members.into_iter().enumerate().filter_map(|(slot, m)| Some((slot, m?))).collect();
        let below = inner
            .into_par_iter()
            .map(|(slot, member)| Ok((slot, self.grown(member, depth + 1)?)))
            .collect::<Result<Vec<_>, Cancelled>>()?;
        self.task.advance(small_count);
        let mut segments = vec![top];
        for (slot, pieces) in below {
            let ahead = segments.len();
            segments[0].below.push((slot, ahead));
            segments.extend(pieces);
        }
        Ok(segments)
    }

    /// Appends the subtree below an inner node, `depth` wide nodes below the root. The node is handed over in its place,
    /// because moving it costs more than the rest of a small node.
    fn grow<const N: usize>(
        &self,
        node: &mut Option<Member<'_, O, S::Plan>>,
        depth: u32,
        segment: &mut Segment<N>,
    ) -> Result<(), Cancelled> {
        let Some(node) = node.take() else { return Ok(()) };
        let count = node.shapes.len();
        let mut members = [const { None }; N];
        self.find_members(node, &mut members)?;
        let (node_idx, small_count) = placed(&mut members, depth, segment);
        for (slot, member) in members.iter_mut().enumerate().filter(|(_, member)| member.is_some()) {
            segment.nodes[node_idx].children[slot] = ChildRef::inner(segment.nodes.len() as u32);
            self.grow(member, depth + 1, segment)?;
        }
        if count >= CHECK_MIN {
            self.task.advance(small_count);
        }
        Ok(())
    }
}

/// Appends a node with the boxes of all its members, and takes out those that are leaves. Answers the node's index and
/// how many references lie in members that are too small to report progress.
#[inline]
fn placed<const N: usize, O: Order, P>(
    members: &mut [Option<Member<'_, O, P>>; N],
    depth: u32,
    segment: &mut Segment<N>,
) -> (usize, u64) {
    let mut node = WideNode::EMPTY;
    let mut small_count = 0;
    for (slot, place) in members.iter_mut().enumerate() {
        let Some(member) = place else { break };
        node.set_bounds(slot, &member.bounds.aabb());
        if member.shapes.len() < CHECK_MIN {
            small_count += member.shapes.len() as u64;
        }
        if let Some(leaf) = place.take_if(|m| m.split.is_none()) {
            node.children[slot] = segment.push_leaf(leaf.leaf(), depth + 1);
        }
    }
    segment.nodes.push(node);
    (segment.nodes.len() - 1, small_count)
}

/// Whether a split lowers the SAH cost below that of a leaf; areas as half areas.
pub(super) fn pays(config: &BuildConfig, count: usize, bounds: &Bound, split_cost: f32) -> bool {
    let area = bounds.half_area();
    let leaf_cost = config.intersection_cost * config.block.count(count) as f32 * area;
    leaf_cost > config.traversal_cost * area + config.intersection_cost * split_cost
}

/// Whether `count` references at `depth` can still be halved down to leaves within the depth limit.
pub(super) fn fits_depth(config: &BuildConfig, count: usize, depth: usize) -> bool {
    let levels = BuildConfig::MAX_DEPTH - depth.min(BuildConfig::MAX_DEPTH);
    let most = if levels >= 40 { usize::MAX } else { config.leaf << levels };
    count <= most
}
