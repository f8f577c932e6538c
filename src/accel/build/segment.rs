//! Pieces of a tree that were built side by side, and how they become one.

use rayon::prelude::*;

use crate::accel::tree::{ChildRef, LeafRange, WideBvh, WideNode};

/// Elements that a thread puts in their places at a time.
const GATHER_MIN: usize = 4096;

/// A run of nodes and leaves in depth-first order. Children are numbered within the segment.
#[derive(Default)]
pub struct Segment<const N: usize> {
    pub nodes: Vec<WideNode<N>>,
    pub leaves: Vec<LeafRange>,
    /// Of the deepest leaf in the whole tree.
    pub depth_max: u32,
    /// Children of node 0 that begin a segment of their own: the slot, and how many segments ahead it is.
    pub below: Vec<(usize, usize)>,
}

impl<const N: usize> Segment<N> {
    /// With memory for the nodes of a binary tree that ends in single references; what is not used is never touched.
    pub fn with_room_for(refs: usize) -> Self {
        let (nodes, leaves) = (Vec::with_capacity(2 * refs / N), Vec::with_capacity(refs));
        Self { nodes, leaves, depth_max: 0, below: Vec::new() }
    }

    pub fn push_leaf(&mut self, leaf: LeafRange, depth: u32) -> ChildRef {
        self.depth_max = self.depth_max.max(depth);
        self.leaves.push(leaf);
        ChildRef::leaf(self.leaves.len() as u32 - 1)
    }
}

/// Puts segments, which follow each other in depth-first order, together into the nodes and leaves of `tree`.
pub fn assemble<const N: usize>(mut segments: Vec<Segment<N>>, tree: &mut WideBvh<N>) {
    tree.depth_max = segments.iter().map(|s| s.depth_max).max().unwrap_or(0);
    if segments.len() == 1 {
        // Not shrunk: that would copy the nodes, and room that was never touched costs no memory.
        let segment = segments.remove(0);
        (tree.nodes, tree.leaves) = (segment.nodes, segment.leaves);
        return;
    }
    let node_starts = starts(segments.iter().map(|s| s.nodes.len()));
    let leaf_starts = starts(segments.iter().map(|s| s.leaves.len()));
    for (i, segment) in segments.iter_mut().enumerate() {
        for &(slot, ahead) in &segment.below {
            // Made relative to the segment, like its other children.
            let child = node_starts[i + ahead] - node_starts[i];
            segment.nodes[0].children[slot] = ChildRef::inner(child as u32);
        }
    }
    tree.nodes = gathered(&node_starts, |i, at| {
        let node = segments[i].nodes[at];
        let (first_node, first_leaf) = (node_starts[i] as u32, leaf_starts[i] as u32);
        WideNode { children: node.children.map(|child| moved(child, first_node, first_leaf)), ..node }
    });
    tree.leaves = gathered(&leaf_starts, |i, at| segments[i].leaves[at]);
}

/// A segment's child, numbered within the whole tree.
#[inline]
fn moved(child: ChildRef, first_node: u32, first_leaf: u32) -> ChildRef {
    match (child.as_inner(), child.as_leaf()) {
        (Some(node_idx), _) => ChildRef::inner(node_idx + first_node),
        (_, Some(leaf_idx)) => ChildRef::leaf(leaf_idx + first_leaf),
        (None, None) => child,
    }
}

/// Where each of some runs begins when they are put one after the other; the last entry is where they end.
fn starts(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut starts = vec![0];
    starts.extend(lengths.scan(0, |end, length| {
        *end += length;
        Some(*end)
    }));
    starts
}

/// All elements of some runs: `element(i, at)` is number `at` of run `i`.
fn gathered<T: Send>(starts: &[usize], element: impl Fn(usize, usize) -> T + Sync) -> Vec<T> {
    let total = starts.last().copied().unwrap_or(0);
    // Collected by index, so that threads write (and touch for the first time) the memory of the result themselves.
    (0..total)
        .into_par_iter()
        .with_min_len(GATHER_MIN)
        .map_init(
            || 0,
            |i: &mut usize, at| {
                if at < starts[*i] || at >= starts[*i + 1] {
                    *i = starts.partition_point(|&start| start <= at) - 1;
                }
                element(*i, at - starts[*i])
            },
        )
        .collect()
}
