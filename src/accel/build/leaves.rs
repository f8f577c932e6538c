//! Leaves for trees that were built down to single references.

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::{BuildConfig, StopRule};

use super::bound::{BlockCount, Bound};
use super::top_down::pays;

/// The tree with a leaf wherever the stop rule asks for one. What was built must be in depth-first order.
pub fn stopped(bvh: Bvh2, config: &BuildConfig) -> Bvh2 {
    if config.leaf == 1 || bvh.nodes.is_empty() {
        return bvh;
    }
    let counts = counts(&bvh);
    let blocks = BlockCount::new(config.block);
    let is_leaf = |node: &Bvh2Node, count: usize| {
        if node.is_leaf() || count > config.leaf {
            return node.is_leaf();
        }
        let side = |child: u32| {
            let area = bvh.nodes[child as usize].bounds.half_area();
            blocks.of(counts[child as usize] as f32) * area
        };
        let [left, right] = node.children().map(side);
        config.stop == StopRule::Limit || !pays(config, count, &Bound::from(node.bounds), left + right)
    };
    let mut copy = Bvh2 { nodes: vec![Bvh2::PLACE], refs: Vec::with_capacity(bvh.refs.len()) };
    let mut open = vec![(0_u32, 0)];
    while let Some((from, to)) = open.pop() {
        let (node, count) = (&bvh.nodes[from as usize], counts[from as usize] as usize);
        copy.nodes[to] = if is_leaf(node, count) {
            // The references of a depth-first tree come in its order, so those below a node follow each other.
            let first = copy.refs.len();
            copy.refs.extend_from_slice(&bvh.refs[first..first + count]);
            copy.refs[first..].sort_unstable();
            Bvh2Node { first: first as u32, count: count as u32, ..*node }
        } else {
            let first = copy.nodes.len();
            copy.nodes.extend([Bvh2::PLACE; 2]);
            let [left, right] = node.children();
            open.extend([(right, first + 1), (left, first)]);
            Bvh2Node { first: first as u32, ..*node }
        };
    }
    copy
}

/// How many references lie below each node.
fn counts(bvh: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; bvh.nodes.len()];
    for (i, node) in bvh.nodes.iter().enumerate().rev() {
        counts[i] = match node.is_leaf() {
            true => node.count,
            false => node.children().into_iter().map(|child| counts[child as usize]).sum(),
        };
    }
    counts
}
