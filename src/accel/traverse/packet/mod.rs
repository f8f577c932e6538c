//! The walk of a packet of rays through a tree (Wald, Slusallek, Benthin, Wagner, "Interactive Rendering with Coherent Ray
//! Tracing", 2001): a node is fetched once for up to 64 rays, and its children that no ray of the packet can meet are
//! dropped by interval arithmetic (Boulos, Wald, Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets",
//! 2006).
//!
//! Every box that is left is tested against each ray with the arithmetic of the walk alone, so a ray of a packet visits the
//! nodes that it would visit alone. If visits are counted, it does so in the same order: rays that disagree about the order
//! part ways.

mod counters;
mod lanes;
mod query;
mod rays;

use fearless_simd::prelude::*;

use crate::accel::simd::{Instructions, SimdToken};
use crate::accel::tree::{ChildRef, Tree, Walked};
use crate::geometry::Ray;
use crate::{at_level, each_width};

use super::boxes::BoxLanes;
use super::{RayCounters, Start};

pub use counters::{PacketCounters, PacketProbe};
pub(super) use lanes::Interval;
pub use lanes::PacketLanes;
pub use query::PacketLeaves;
pub use rays::{GROUP, Lanes, PACKET, Rays};

use lanes::Classes;
use query::{Alone, Any, Nearest, Query};

/// With fewer rays of one class a packet gains nothing.
const FEWEST: u32 = 4;

/// So few rays go on below a node one by one.
const LONELY: u32 = 6;

/// Children of a node, at most.
const MAX_WIDTH: usize = 16;

/// Enough for all children of a node at each depth of the tree; packets that part ways may leave more behind.
fn usual_stack<const N: usize>(depth_max: u32) -> usize {
    N * (depth_max as usize + 2)
}

/// A node that waits for some rays.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    child: ChildRef,
    /// Where its box is.
    parent: u32,
    slot: u32,
    /// No ray of the packet enters it before.
    near: f32,
    /// Those that may.
    rays: Rays,
}

impl Waiting {
    const NONE: Self =
        Self { child: ChildRef::EMPTY, parent: 0, slot: 0, near: f32::INFINITY, rays: Rays::NONE };
}

/// Nodes that wait, the next on top, and what else a walk needs.
#[derive(Clone, Debug)]
struct Stack {
    waiting: Vec<Waiting>,
    /// Of each child of a node.
    entries: [Lanes; MAX_WIDTH],
    alone: Alone,
    /// Nodes that the packet has met, and by how many of its rays each.
    met: u64,
    met_by: u64,
}

impl Default for Stack {
    fn default() -> Self {
        let entries = [Lanes::ZERO; MAX_WIDTH];
        Self { waiting: Vec::new(), entries, alone: Alone::default(), met: 0, met_by: 0 }
    }
}

/// Rays that walk a tree together, and what they need on the way. Kept by a thread from packet to packet.
#[derive(Clone, Debug, Default)]
pub struct RayPacket {
    lanes: Box<PacketLanes>,
    classes: Classes,
    stack: Box<Stack>,
}

impl RayPacket {
    /// Takes up to [`PACKET`] rays that will walk `tree`.
    pub fn take(&mut self, simd: SimdToken, tree: &Tree, rays: &[Ray]) {
        let bounds = tree.bounds();
        (self.stack.met, self.stack.met_by) = (0, 0);
        self.classes = at_level!(simd, simd => self.lanes.take(simd, rays, &bounds));
    }

    pub fn lanes(&self) -> &PacketLanes {
        &self.lanes
    }

    /// How many rays met a node together, on average; `None` if no node was met.
    pub fn company(&self) -> Option<f32> {
        let Stack { met, met_by, .. } = *self.stack;
        (met > 0).then(|| met_by as f32 / met as f32)
    }
}

/// The nearest hits of the packet's rays that come before what is in `bests`, which is replaced where one is found.
///
/// Answers the rays that must walk alone ([`super::intersect`]), being without company. For them nothing was done.
pub fn intersect<'l, L: PacketLeaves>(
    simd: SimdToken,
    tree: &Tree,
    leaves: &'l L,
    packet: &mut RayPacket,
    bests: &mut L::Bests<'l>,
    probe: &mut PacketProbe,
) -> Rays {
    let mut query = Nearest::<L> { bests };
    let asked = Rays::ALL;
    each_width!(tree, t => at_level!(simd, simd => together(simd, t.walked(), leaves, asked, packet, &mut query, probe)))
}

/// Which of the packet's rays a shape stops between `t_min` and `t_max` that `blocks` says does, of those `asked`; and
/// which must walk alone ([`super::occluded`]).
pub fn occluded<L: PacketLeaves>(
    simd: SimdToken,
    tree: &Tree,
    leaves: &L,
    asked: Rays,
    packet: &mut RayPacket,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut PacketProbe,
) -> (Rays, Rays) {
    let mut query = Any { t_max: *packet.lanes.t_max(), blocks, stopped: Rays::NONE };
    let alone = each_width!(tree, t => at_level!(simd, simd => together(simd, t.walked(), leaves, asked, packet, &mut query, probe)));
    (query.stopped, alone)
}

/// Walks with the rays of one class after the other.
#[inline(always)]
fn together<'l, S: Instructions, const N: usize, T: BoxLanes<S, N>, L: PacketLeaves, Q: Query<'l, L>>(
    simd: S,
    bvh: Walked<T>,
    leaves: &'l L,
    asked: Rays,
    packet: &mut RayPacket,
    query: &mut Q,
    probe: &mut PacketProbe,
) -> Rays {
    let RayPacket { lanes, stack, classes } = packet;
    if bvh.root.is_empty() {
        return Rays::NONE;
    }
    let inside = lanes.reaching(simd, classes.inside.and(asked), query.t_max());
    let usual = usual_stack::<N>(bvh.depth_max);
    if stack.waiting.len() < usual {
        stack.waiting.resize(usual, Waiting::NONE);
    }
    let mut left = inside.and(classes.regular);
    let mut alone = inside.without(classes.regular);
    while !left.is_empty() {
        let alike = lanes.prepare(simd, classes, left);
        left = left.without(alike);
        if alike.count() < FEWEST {
            alone = alone.or(alike);
        } else {
            walk(simd, bvh, leaves, (lanes, alike), stack, query, probe);
        }
    }
    alone
}

/// The loop of a packet whose rays are of one class.
///
/// Tried and lost:
/// - testing an inner child only until a first group of rays enters it: up to a sixth faster for coherent rays, an eighth
///   slower among small triangles;
/// - each ray's entries kept from the test at the parent, instead of a test when the node is taken: 5 percent slower;
/// - packets of 32 rays: an eighth slower; of 16: a third.
#[inline(always)]
fn walk<'l, S: Instructions, const N: usize, T: BoxLanes<S, N>, L: PacketLeaves, Q: Query<'l, L>>(
    simd: S,
    bvh: Walked<T>,
    leaves: &'l L,
    (lanes, rays): (&PacketLanes, Rays),
    stack: &mut Stack,
    query: &mut Q,
    probe: &mut PacketProbe,
) {
    let Stack { waiting, entries, alone, met, met_by } = stack;
    let interval = lanes.interval(simd, rays);
    let mut t_end = query.t_max().bounds(simd, rays)[1];
    let mut walking = rays;
    let mut height = 0;
    let (mut next, mut rays) = (bvh.root, rays);
    loop {
        *met += 1;
        *met_by += u64::from(rays.count());
        if rays.count() <= LONELY {
            let done = one_by_one(simd, (bvh, next), leaves, (lanes, rays), query, alone, probe);
            walking = walking.without(done);
        } else if let Some(node_idx) = next.as_inner() {
            let node = &bvh.nodes[node_idx as usize];
            probe.inner_visited(rays, node.child_count() as u32);
            let (mut slots, nears) = node.may_enter(simd, &interval, t_end);
            let bottom = height;
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize % N;
                slots &= slots - 1;
                let (child, near) = (node.child(slot), nears[slot]);
                let mut at = height;
                while at > bottom && waiting[at - 1].near < near {
                    waiting[at] = waiting[at - 1];
                    at -= 1;
                }
                waiting[at] = Waiting { child, parent: node_idx, slot: slot as u32, near, rays };
                height += 1;
            }
            if probe.counts() {
                for child in &mut waiting[bottom..height] {
                    let slot = child.slot as usize % N;
                    child.rays =
                        lanes.enter(simd, &node.child_sides(slot), rays, query.t_max(), &mut entries[slot]);
                }
                order::<_, N>(simd, waiting, bottom, &mut height, entries);
            }
        } else if let Some(leaf_idx) = next.as_leaf() {
            probe.leaf_visited(rays);
            walking = walking.without(leaf(simd, leaf_idx, leaves, lanes, rays, query, probe));
            t_end = query.t_max().bounds(simd, walking)[1];
        }
        loop {
            if height == 0 || walking.is_empty() {
                return;
            }
            height -= 1;
            let Waiting { child, parent, slot, near, rays: asked } = waiting[height];
            if near <= t_end {
                let sides = bvh.nodes[parent as usize].child_sides(slot as usize % N);
                let asked = asked.and(walking);
                rays = lanes.enter(simd, &sides, asked, query.t_max(), &mut entries[0]);
                if !rays.is_empty() {
                    next = child;
                    break;
                }
            }
        }
    }
}

/// Lets the children that wait from `bottom` on, with room for as many above, do so in such an order that every ray visits
/// them by its own entries and then by reference. Rays that have another order than the first one wait apart, below.
#[inline(always)]
fn order<S: Simd, const N: usize>(
    simd: S,
    waiting: &mut Vec<Waiting>,
    bottom: usize,
    height: &mut usize,
    entries: &[Lanes; MAX_WIDTH],
) {
    let mut children = [Waiting::NONE; N];
    let children = &mut children[..*height - bottom];
    children.copy_from_slice(&waiting[bottom..*height]);
    *height = bottom;
    let entry = |child: &Waiting| &entries[child.slot as usize % MAX_WIDTH];
    let mut left = children.iter().fold(Rays::NONE, |all, child| all.or(child.rays));
    while let Some(leader) = left.lowest() {
        let key =
            |child: &Waiting| if child.rays.has(leader) { entry(child).get(leader) } else { child.near };
        children.sort_unstable_by(|a, b| key(b).total_cmp(&key(a)).then(b.child.0.cmp(&a.child.0)));
        let mut agreeing = left;
        for (i, farther) in children.iter().enumerate() {
            for nearer in &children[i + 1..] {
                let both = farther.rays.and(nearer.rays).and(agreeing);
                let first = nearer.child.0 < farther.child.0;
                let agree = both.that(
                    #[inline(always)]
                    |group| {
                        let far = entry(farther).load(simd, group);
                        let near = entry(nearer).load(simd, group);
                        (if first { near.simd_le(far) } else { near.simd_lt(far) }).to_bitmask() as u32
                    },
                );
                agreeing = agreeing.without(both.without(agree));
            }
        }
        left = left.without(agreeing);
        for child in &*children {
            let rays = child.rays.and(agreeing);
            if !rays.is_empty() {
                if *height + N >= waiting.len() {
                    waiting.push(Waiting::NONE);
                }
                waiting[*height] = Waiting { rays, ..*child };
                *height += 1;
            }
        }
    }
}

/// Walks on with each of a few rays from a node on; answers which are done.
#[inline(always)]
fn one_by_one<'l, S: Instructions, const N: usize, T: BoxLanes<S, N>, L: PacketLeaves, Q: Query<'l, L>>(
    simd: S,
    (bvh, node): (Walked<T>, ChildRef),
    leaves: &'l L,
    (lanes, rays): (&PacketLanes, Rays),
    query: &mut Q,
    alone: &mut Alone,
    probe: &mut PacketProbe,
) -> Rays {
    let mut done = Rays::NONE;
    for index in rays.iter() {
        let (ray, tree_ray) = (lanes.ray(index), lanes.tree_ray(index));
        let start = Start { node, ray: &ray, tree_ray: &tree_ray };
        alone.counters = RayCounters::default();
        if query.alone(simd, bvh, start, leaves, index, alone) {
            done = done.or(Rays::one(index));
        }
        probe.counted(Rays::one(index), &alone.counters);
    }
    done
}

/// A leaf's test, in a function of its own that does not depend on the tree's width.
#[inline(never)]
fn leaf<'l, S: Instructions, L: PacketLeaves, Q: Query<'l, L>>(
    simd: S,
    leaf_idx: u32,
    leaves: &'l L,
    lanes: &PacketLanes,
    rays: Rays,
    query: &mut Q,
    probe: &mut PacketProbe,
) -> Rays {
    simd.apart(
        #[inline(always)]
        || query.leaf(simd, leaf_idx, leaves, lanes, rays, probe),
    )
}
