//! Binary to wide: the children of a wide node are found by opening binary nodes below it until it is full.
//!
//! Which child is opened next makes the difference between the ways of [`Widen`]:
//!
//! - `collapse` opens the child with the largest area (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008).
//! - `split` opens the child whose own split lowers `sum N_i * A_i` most. A builder's split depends on a range of
//!   references alone, so opening the finished binary tree this way gives, node for node, the tree that direct multi-way
//!   splitting gives, without searching any split twice.
//! - `optimal` asks [`Optimum`], which knows the cheapest way, and where a whole subtree had better be a leaf.

use crate::task::{Cancelled, Task};

use super::bvh2::Bvh2;
use super::config::{BuildConfig, Widen};
use super::optimum::Optimum;
use super::tree::{ChildRef, LeafRange, WideBvh, WideNode};

/// Nodes between two looks at the cancel flag.
const CHECK_EVERY: usize = 4096;

/// Who says which binary nodes become children.
enum Plan<const N: usize> {
    /// By binary node: what opening it is worth; larger is sooner.
    Greedy(Vec<f32>),
    Optimal(Optimum<N>),
}

/// The binary nodes that become the children of a wide node, in spatial order.
pub(super) struct Members<const N: usize> {
    nodes: [u32; N],
    count: usize,
}

struct Widener<'a, const N: usize> {
    bvh: &'a Bvh2,
    plan: Plan<N>,
    out: WideBvh<N>,
    /// The shapes of a leaf, while it is made.
    shapes: Vec<u32>,
}

/// A wide tree over the leaves of a binary one, whose children lie behind their parents and whose references are in
/// depth-first order. With `N` = 2 and without `optimal` the same tree.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn widen<const N: usize>(bvh: &Bvh2, config: &BuildConfig, task: &Task) -> Result<WideBvh<N>, Cancelled> {
    let mut out = WideBvh::empty();
    let Some(root) = bvh.nodes.first() else { return Ok(out) };
    out.bounds = root.bounds;
    let plan = match config.widen {
        _ if config.is_optimal() => {
            out.refs.reserve_exact(bvh.refs.len());
            Plan::Optimal(Optimum::new(bvh, config, task)?)
        }
        Widen::Collapse | Widen::Optimal => {
            Plan::Greedy(bvh.nodes.iter().map(|node| node.bounds.half_area()).collect())
        }
        Widen::Split => Plan::Greedy(split_gains(bvh)),
    };
    if matches!(plan, Plan::Greedy(_)) {
        out.refs = bvh.refs.clone();
    }
    let mut widener = Widener { bvh, plan, out, shapes: Vec::new() };
    if widener.is_leaf(0) {
        widener.out.root = widener.push_leaf(0);
    } else {
        widener.run(task)?;
    }
    Ok(widener.out)
}

/// `N * A - (N_left * A_left + N_right * A_right)` of every inner node.
fn split_gains(bvh: &Bvh2) -> Vec<f32> {
    let mut weighted = vec![0.0_f32; bvh.nodes.len()];
    let mut gains = vec![0.0_f32; bvh.nodes.len()];
    let mut counts = vec![0_u32; bvh.nodes.len()];
    // Children lie behind their parent.
    for (i, node) in bvh.nodes.iter().enumerate().rev() {
        let first = node.first as usize;
        counts[i] = if node.is_leaf() { node.count } else { counts[first] + counts[first + 1] };
        weighted[i] = counts[i] as f32 * node.bounds.half_area();
        if !node.is_leaf() {
            gains[i] = weighted[i] - (weighted[first] + weighted[first + 1]);
        }
    }
    gains
}

impl<const N: usize> Members<N> {
    pub fn new() -> Self {
        Self { nodes: [0; N], count: 0 }
    }

    /// Adds a child behind the others.
    pub fn push(&mut self, binary_idx: u32) {
        self.nodes[self.count] = binary_idx;
        self.count += 1;
    }

    /// Puts two children in the place of one.
    fn open(&mut self, slot: usize, [left, right]: [u32; 2]) {
        self.nodes.copy_within(slot + 1..self.count, slot + 2);
        (self.nodes[slot], self.nodes[slot + 1]) = (left, right);
        self.count += 1;
    }

    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }
}

impl<const N: usize> Widener<'_, N> {
    fn run(&mut self, task: &Task) -> Result<(), Cancelled> {
        self.out.root = ChildRef::inner(0);
        // Binary node, the wide node and slot that will point at it, and its depth.
        let mut open = vec![(0_u32, None::<(u32, usize)>, 0_u32)];
        while let Some((binary_idx, parent, depth)) = open.pop() {
            if self.out.nodes.len().is_multiple_of(CHECK_EVERY) {
                task.check()?;
            }
            let wide_idx = self.out.nodes.len() as u32;
            if let Some((parent_idx, slot)) = parent {
                self.out.nodes[parent_idx as usize].children[slot] = ChildRef::inner(wide_idx);
            }
            let members = self.members(binary_idx);
            let mut node = WideNode::EMPTY;
            for (slot, &member) in members.nodes().iter().enumerate() {
                node.set_bounds(slot, &self.bvh.nodes[member as usize].bounds);
                if self.is_leaf(member) {
                    node.children[slot] = self.push_leaf(member);
                    self.out.depth_max = self.out.depth_max.max(depth + 1);
                }
            }
            self.out.nodes.push(node);
            for (slot, &member) in members.nodes().iter().enumerate().rev() {
                if !self.is_leaf(member) {
                    open.push((member, Some((wide_idx, slot)), depth + 1));
                }
            }
        }
        Ok(())
    }

    fn is_leaf(&self, binary_idx: u32) -> bool {
        match &self.plan {
            Plan::Greedy(_) => self.bvh.nodes[binary_idx as usize].is_leaf(),
            Plan::Optimal(optimum) => optimum.is_leaf(binary_idx),
        }
    }

    /// Adds the leaf of a binary node: that one itself, or the shapes below it, ascending, parts of one shape only once.
    fn push_leaf(&mut self, binary_idx: u32) -> ChildRef {
        let leaf = match &self.plan {
            Plan::Greedy(_) => {
                let node = &self.bvh.nodes[binary_idx as usize];
                LeafRange { first: node.first, count: node.count }
            }
            Plan::Optimal(optimum) => {
                self.shapes.clear();
                self.shapes.extend_from_slice(&self.bvh.refs[optimum.range(binary_idx)]);
                self.shapes.sort_unstable();
                self.shapes.dedup();
                let first = self.out.refs.len() as u32;
                self.out.refs.extend_from_slice(&self.shapes);
                LeafRange { first, count: self.shapes.len() as u32 }
            }
        };
        self.out.leaves.push(leaf);
        ChildRef::leaf(self.out.leaves.len() as u32 - 1)
    }

    /// The children of the wide node at `binary_idx`.
    fn members(&self, binary_idx: u32) -> Members<N> {
        let priority = match &self.plan {
            Plan::Greedy(priority) => priority,
            Plan::Optimal(optimum) => return optimum.members(self.bvh, binary_idx),
        };
        let mut members = Members::new();
        for child in self.bvh.nodes[binary_idx as usize].children() {
            members.push(child);
        }
        while members.count < N {
            let mut next: Option<usize> = None;
            for (slot, &member) in members.nodes().iter().enumerate() {
                let before = next.map(|n| members.nodes[n] as usize);
                let sooner = before.is_none_or(|before| priority[member as usize] > priority[before]);
                if !self.bvh.nodes[member as usize].is_leaf() && sooner {
                    next = Some(slot);
                }
            }
            let Some(slot) = next else { break };
            members.open(slot, self.bvh.nodes[members.nodes[slot] as usize].children());
        }
        members
    }
}
