//! The wide tree of the least SAH cost that can be made from a binary one by leaving out inner nodes and by making leaves of
//! subtrees: the dynamic programme of Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs" (2017), section 3.1.
//!
//! For every binary node it finds the least cost of having what is below it stand in 1, 2, ... up to `N - 1` slots of an
//! ancestor, from the leaves to the root. In one slot stands a leaf, or a wide node, which shares out its own `N` slots
//! between the two binary children; more slots are shared out in the same way, or left empty.

use crate::task::{Cancelled, Task};

use super::bvh2::Bvh2;
use super::config::{Block, BuildConfig};
use super::widen::Members;

/// Nodes between two looks at the cancel flag.
const CHECK_EVERY: usize = 4096;

/// The cheapest way to make each node.
#[derive(Clone, Copy)]
struct Ways<const N: usize> {
    /// `[slots - 1]`: the least cost in at most so many slots, times the root's area; the last one in a wide node's own.
    cost: [f32; N],
    /// `[slots - 1]`: how many of them the left child gets; 0 to stand in one fewer.
    left: [u8; N],
    /// Whether the one slot holds a leaf.
    is_leaf: bool,
    /// The references below, a range.
    first: u32,
    count: u32,
}

/// The way of least cost.
pub(super) struct Optimum<const N: usize> {
    ways: Vec<Ways<N>>,
}

impl<const N: usize> Optimum<N> {
    /// For a tree whose children lie behind their parents and whose references are in depth-first order. Costs, leaf limit
    /// and blocks are those of the configuration.
    pub fn new(bvh: &Bvh2, config: &BuildConfig, task: &Task) -> Result<Self, Cancelled> {
        const { assert!(N >= 2 && N <= u8::MAX as usize) };
        let nothing = Ways { cost: [0.0; N], left: [0; N], is_leaf: true, first: 0, count: 0 };
        let mut optimum = Self { ways: vec![nothing; bvh.nodes.len()] };
        let leaf_price = |count: u32| match config.block {
            Block::B1 => config.intersection_cost * count as f32,
            block => config.intersection_cost * (block.count(count as usize) * block.get()) as f32,
        };
        for (i, node) in bvh.nodes.iter().enumerate().rev() {
            if i.is_multiple_of(CHECK_EVERY) {
                task.check()?;
            }
            let area = node.bounds.half_area();
            optimum.ways[i] = if node.is_leaf() {
                let cost = [leaf_price(node.count) * area; N];
                Ways { cost, first: node.first, count: node.count, ..nothing }
            } else {
                let [left, right] = node.children().map(|child| &optimum.ways[child as usize]);
                let mut ways = Ways { first: left.first, count: left.count + right.count, ..nothing };
                for slots in (2..=N).rev() {
                    let (cost, of_left) = shared_out(left, right, slots);
                    (ways.cost[slots - 1], ways.left[slots - 1]) = (cost, of_left);
                }
                let inner = config.traversal_cost * area + ways.cost[N - 1];
                let leaf = leaf_price(ways.count) * area;
                ways.is_leaf = ways.count as usize <= config.leaf && leaf <= inner;
                ways.cost[0] = if ways.is_leaf { leaf } else { inner };
                // The last place stays that of the node's own slots: it is never asked for as an ancestor's.
                for slots in 2..N {
                    if ways.cost[slots - 2] <= ways.cost[slots - 1] {
                        (ways.cost[slots - 1], ways.left[slots - 1]) = (ways.cost[slots - 2], 0);
                    }
                }
                ways
            };
        }
        Ok(optimum)
    }

    pub fn is_leaf(&self, binary_idx: u32) -> bool {
        self.ways[binary_idx as usize].is_leaf
    }

    /// The references below a node.
    pub fn range(&self, binary_idx: u32) -> std::ops::Range<usize> {
        let ways = &self.ways[binary_idx as usize];
        ways.first as usize..(ways.first + ways.count) as usize
    }

    /// The children of the wide node at `binary_idx`, an inner one.
    pub fn members(&self, bvh: &Bvh2, binary_idx: u32) -> Members<N> {
        let mut members = Members::new();
        self.share_out(bvh, binary_idx, N, &mut members);
        members
    }

    /// Adds what stands in `slots` slots, 2 or more, shared out between the children of a node.
    fn share_out(&self, bvh: &Bvh2, binary_idx: u32, slots: usize, members: &mut Members<N>) {
        let of_left = usize::from(self.ways[binary_idx as usize].left[slots - 1]);
        let [left, right] = bvh.nodes[binary_idx as usize].children();
        self.add(bvh, left, of_left, members);
        self.add(bvh, right, slots - of_left, members);
    }

    /// Adds what stands in at most `slots` slots of an ancestor.
    fn add(&self, bvh: &Bvh2, binary_idx: u32, mut slots: usize, members: &mut Members<N>) {
        let ways = &self.ways[binary_idx as usize];
        while slots > 1 && ways.left[slots - 1] == 0 {
            slots -= 1;
        }
        if slots == 1 {
            members.push(binary_idx);
        } else {
            self.share_out(bvh, binary_idx, slots, members);
        }
    }
}

/// The least cost of two siblings in so many slots, each in one at least, and how many the left one gets then.
#[inline]
fn shared_out<const N: usize>(left: &Ways<N>, right: &Ways<N>, slots: usize) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for of_left in 1..slots {
        let cost = left.cost[of_left - 1] + right.cost[slots - of_left - 1];
        if cost < best.0 {
            best = (cost, of_left as u8);
        }
    }
    best
}
