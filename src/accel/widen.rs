//! Binary to wide: the children of a wide node are found by opening binary nodes below it until it is full.
//!
//! Which child is opened next makes the difference between the two ways of [`Widen`]:
//!
//! - `collapse` opens the child with the largest area (Wald, Benthin, Boulos, "Getting Rid of Packets", 2008).
//! - `split` opens the child whose own split lowers `sum N_i * A_i` most. A builder's split depends on a range of
//!   references alone, so opening the finished binary tree this way gives, node for node, the tree that direct multi-way
//!   splitting gives, without searching any split twice.

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::config::Widen;
use super::tree::{Bvh2, Bvh2Node, ChildRef, LeafRange, WideBvh, WideNode};

/// Nodes between two looks at the cancel flag.
const CHECK_EVERY: usize = 4096;

struct Widener<'a, const N: usize> {
    bvh: &'a Bvh2,
    /// By binary node: what opening it is worth; larger is sooner.
    priority: Vec<f32>,
    out: WideBvh<N>,
}

/// A wide tree over the leaves of a binary one. With `N` = 2 the same tree.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn widen<const N: usize>(bvh: &Bvh2, how: Widen, task: &Task) -> Result<WideBvh<N>, Cancelled> {
    let mut out = WideBvh {
        root: ChildRef::EMPTY,
        bounds: Aabb::EMPTY,
        nodes: Vec::new(),
        leaves: Vec::with_capacity(bvh.nodes.len() / 2 + 1),
        refs: bvh.refs.clone(),
        depth_max: 0,
    };
    let Some(root) = bvh.nodes.first() else { return Ok(out) };
    out.bounds = root.bounds;
    if root.is_leaf() {
        out.root = out.push_leaf(root);
        return Ok(out);
    }
    let priority = if N == 2 { Vec::new() } else { priorities(bvh, how) };
    let mut widener = Widener { bvh, priority, out };
    widener.run(task)?;
    Ok(widener.out)
}

/// What opening each binary node is worth.
fn priorities(bvh: &Bvh2, how: Widen) -> Vec<f32> {
    match how {
        Widen::Collapse => bvh.nodes.iter().map(|node| node.bounds.half_area()).collect(),
        Widen::Split => split_gains(bvh),
    }
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

impl<const N: usize> WideBvh<N> {
    fn push_leaf(&mut self, node: &Bvh2Node) -> ChildRef {
        self.leaves.push(LeafRange { first: node.first, count: node.count });
        ChildRef::leaf(self.leaves.len() as u32 - 1)
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
            let (members, count) = self.members(binary_idx);
            let mut node = WideNode::EMPTY;
            for (slot, &member) in members[..count].iter().enumerate() {
                let child = &self.bvh.nodes[member as usize];
                node.set_bounds(slot, &child.bounds);
                if child.is_leaf() {
                    node.children[slot] = self.out.push_leaf(child);
                    self.out.depth_max = self.out.depth_max.max(depth + 1);
                }
            }
            self.out.nodes.push(node);
            for (slot, &member) in members[..count].iter().enumerate().rev() {
                if !self.bvh.nodes[member as usize].is_leaf() {
                    open.push((member, Some((wide_idx, slot)), depth + 1));
                }
            }
        }
        Ok(())
    }

    /// The binary nodes that become the children of the wide node at `binary_idx`, in spatial order, and how many.
    fn members(&self, binary_idx: u32) -> ([u32; N], usize) {
        let first = self.bvh.nodes[binary_idx as usize].first;
        let mut members = [0; N];
        (members[0], members[1]) = (first, first + 1);
        let mut count = 2;
        while count < N {
            let mut next: Option<usize> = None;
            for slot in 0..count {
                let member = members[slot] as usize;
                let sooner = next.is_none_or(|n| self.priority[member] > self.priority[members[n] as usize]);
                if !self.bvh.nodes[member].is_leaf() && sooner {
                    next = Some(slot);
                }
            }
            let Some(slot) = next else { break };
            let pair = self.bvh.nodes[members[slot] as usize].first;
            members.copy_within(slot + 1..count, slot + 2);
            (members[slot], members[slot + 1]) = (pair, pair + 1);
            count += 1;
        }
        (members, count)
    }
}
