//! Reinsertion: subtrees are taken out of the tree and put back where the sum of all areas becomes least (Meister and
//! Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018).
//!
//! Every round looks, for those nodes that have the largest areas, for the best place in the whole tree: from the node's
//! parent upwards, each time down into the other side, and not further than the best place so far can be beaten; and beside
//! each ancestor, which the paper leaves out. That changes nothing and is done side by side. The moves found are then made
//! one after the other, the best first, but for those that are no improvement any more after what was moved before them:
//! simpler than the paper's locks, and the tree is the same at any thread count.

use rayon::prelude::*;

use crate::accel::bvh2::Bvh2Node;
use crate::accel::config::BuildConfig;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// Nodes between two looks at the cancel flag.
const CHECK_EVERY: usize = 64;

/// A subtree that changes its place: it becomes the sibling of another one.
#[derive(Clone, Copy, Debug)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the sum of the half areas of all inner nodes falls.
    gain: f32,
}

struct Reinserter {
    nodes: Vec<Bvh2Node>,
    parents: Vec<u32>,
}

/// The nodes after one round, in any order; `None` if nothing moved.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn round(
    nodes: &[Bvh2Node],
    config: &BuildConfig,
    task: &Task,
) -> Result<Option<Vec<Bvh2Node>>, Cancelled> {
    let mut reinserter = Reinserter::new(nodes.to_vec());
    let moves = reinserter.moves(config.share, task)?;
    Ok(reinserter.make(&moves).then_some(reinserter.nodes))
}

/// The other child of the same parent.
#[inline]
fn sibling(node_idx: u32) -> u32 {
    if node_idx % 2 == 1 { node_idx + 1 } else { node_idx - 1 }
}

impl Reinserter {
    fn new(nodes: Vec<Bvh2Node>) -> Self {
        let mut parents = vec![0; nodes.len()];
        for (i, node) in nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
            for child in node.children() {
                parents[child as usize] = i as u32;
            }
        }
        Self { nodes, parents }
    }

    fn node(&self, node_idx: u32) -> &Bvh2Node {
        &self.nodes[node_idx as usize]
    }

    fn parent(&self, node_idx: u32) -> u32 {
        self.parents[node_idx as usize]
    }

    /// The best moves of the nodes with the largest areas, a `share` of all nodes; the best of them first.
    fn moves(&self, share: f32, task: &Task) -> Result<Vec<Move>, Cancelled> {
        let mut candidates: Vec<(f32, u32)> =
            (1..self.nodes.len() as u32).map(|i| (self.node(i).bounds.half_area(), i)).collect();
        let count = (candidates.len() as f64 * f64::from(share)).ceil() as usize;
        if count < candidates.len() {
            candidates.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            candidates.truncate(count);
        }
        let of_piece = |piece: &[(f32, u32)]| {
            task.check()?;
            let mut stack = Vec::new();
            Ok(piece.iter().filter_map(|&(_, from)| self.best_move(from, &mut stack)).collect::<Vec<_>>())
        };
        let pieces = candidates.par_chunks(CHECK_EVERY).map(of_piece);
        let mut moves = pieces.collect::<Result<Vec<_>, Cancelled>>()?.concat();
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        Ok(moves)
    }

    /// The place for a subtree that lowers the sum of areas most, if any does.
    fn best_move(&self, from: u32, stack: &mut Vec<(f32, u32)>) -> Option<Move> {
        let bounds = self.node(from).bounds;
        let area = bounds.half_area();
        let parent = self.parent(from);
        let mut best = Move { from, to: from, gain: 0.0 };
        // What is saved by taking the subtree out, below the ancestor at which the search turns down again.
        let mut saved = self.node(parent).bounds.half_area();
        // That ancestor's child on this side, and its box without the subtree.
        let mut side = from;
        let mut without = Aabb::EMPTY;
        loop {
            let other = sibling(side);
            stack.push((saved, other));
            while let Some((saved, node_idx)) = stack.pop() {
                // Its new parent will be at least as large as the subtree.
                if saved - area <= best.gain {
                    continue;
                }
                let node = self.node(node_idx);
                let gain = saved - node.bounds.union(bounds).half_area();
                if gain > best.gain {
                    best = Move { from, to: node_idx, gain };
                }
                if !node.is_leaf() {
                    let below = gain + node.bounds.half_area();
                    stack.extend(node.children().map(|child| (below, child)));
                }
            }
            let above = self.parent(side);
            without = without.union(self.node(other).bounds);
            if above != parent {
                // All that is left of this ancestor may become its sibling, too.
                let whole = self.node(above).bounds.half_area();
                saved += whole - without.half_area();
                if saved - whole > best.gain {
                    best = Move { from, to: above, gain: saved - whole };
                }
            }
            if above == 0 {
                break;
            }
            side = above;
        }
        (best.to != from).then_some(best)
    }

    /// Makes the moves that are still an improvement after those before them. `false` if there were none.
    fn make(&mut self, moves: &[Move]) -> bool {
        let mut made = false;
        for &Move { from, to, .. } in moves {
            // An earlier move may have brought the new place into this very subtree, or beside it.
            let is_possible = to != sibling(from) && to != self.parent(from) && !self.is_below(to, from);
            if is_possible && self.gain(from, to) > 0.0 {
                self.put(from, to);
                made = true;
            }
        }
        made
    }

    /// By how much the sum of the half areas of all inner nodes falls if the subtree `from` becomes the sibling of `to`.
    fn gain(&self, from: u32, to: u32) -> f32 {
        let bounds = self.node(from).bounds;
        let area = |node_idx: u32| self.node(node_idx).bounds.half_area();
        let parent = self.parent(from);
        let mut saved = area(parent);
        let (mut side, mut without) = (from, Aabb::EMPTY);
        // Up to the first ancestor of both.
        while !self.is_below(to, self.parent(side)) {
            without = without.union(self.node(sibling(side)).bounds);
            side = self.parent(side);
            if side != parent {
                saved += area(side) - without.half_area();
            }
        }
        let common = self.parent(side);
        if common == to {
            without = without.union(self.node(sibling(side)).bounds);
            return saved - without.half_area();
        }
        let grown = |node_idx: u32| self.node(node_idx).bounds.union(bounds).half_area();
        let mut gain = saved - grown(to);
        let mut at = self.parent(to);
        while at != common {
            gain -= grown(at) - area(at);
            at = self.parent(at);
        }
        gain
    }

    fn is_below(&self, node_idx: u32, ancestor: u32) -> bool {
        let mut at = node_idx;
        while at != 0 && at != ancestor {
            at = self.parent(at);
        }
        at == ancestor
    }

    /// Makes the subtree `from` the sibling of the node at `to`. Its parent is not needed there any more, and its pair of
    /// places moves below `to`.
    fn put(&mut self, from: u32, to: u32) {
        let (beside, parent) = (sibling(from), self.parent(from));
        let (left_behind, displaced) = (*self.node(beside), *self.node(to));
        self.nodes[to as usize] = Bvh2Node { bounds: displaced.bounds, first: from.min(beside), count: 0 };
        self.set(parent, left_behind);
        self.set(beside, displaced);
        self.parents[beside as usize] = to;
        self.parents[from as usize] = to;
        self.refit(to);
        self.refit(self.parent(parent));
    }

    fn set(&mut self, node_idx: u32, node: Bvh2Node) {
        self.nodes[node_idx as usize] = node;
        if !node.is_leaf() {
            for child in node.children() {
                self.parents[child as usize] = node_idx;
            }
        }
    }

    /// Fits the boxes of a node and its ancestors to their children.
    fn refit(&mut self, mut node_idx: u32) {
        loop {
            let node = self.node(node_idx);
            if !node.is_leaf() {
                let [left, right] = node.children().map(|child| self.node(child).bounds);
                let bounds = left.union(right);
                self.nodes[node_idx as usize].bounds = bounds;
            }
            if node_idx == 0 {
                return;
            }
            node_idx = self.parent(node_idx);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::{improve, sum_of_areas};
    use super::*;
    use crate::accel::build::Onlooker;
    use crate::accel::bvh2::Bvh2;
    use crate::accel::{Builder, Improver, Tree, Width, build};

    /// Two clusters far apart, and a tree that was built wrong: each half has boxes of both.
    fn mixed() -> Bvh2 {
        let unit = |x: f32| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE);
        let boxes = [unit(0.0), unit(100.0), unit(2.0), unit(102.0)];
        let leaf = |i: usize| Bvh2Node { bounds: boxes[i], first: i as u32, count: 1 };
        let inner =
            |a: usize, b: usize, first| Bvh2Node { bounds: boxes[a].union(boxes[b]), first, count: 0 };
        let mut nodes = vec![inner(0, 3, 1), inner(0, 1, 3), inner(2, 3, 5)];
        nodes.extend([leaf(0), leaf(1), leaf(2), leaf(3)]);
        Bvh2 { nodes, refs: vec![0, 1, 2, 3] }
    }

    fn config(rounds: usize) -> BuildConfig {
        BuildConfig { improver: Improver::Reinsertion, rounds, share: 1.0, ..BuildConfig::default() }
    }

    #[test]
    fn what_belongs_together_is_brought_together() {
        let mut bvh = mixed();
        let before = sum_of_areas(&bvh.nodes);
        let rounds = improve(&mut bvh, &config(10), &mut Onlooker::nobody(), &Task::new())
            .expect("not cancelled")
            .len()
            - 1;
        let pair = Aabb::new(Vec3::ZERO, Vec3::new(3.0, 1.0, 1.0)).half_area();
        let root = bvh.nodes[0].bounds.half_area();
        let after = sum_of_areas(&bvh.nodes);
        assert!(rounds > 0 && after < before);
        assert!((after - f64::from(root + 2.0 * pair)).abs() < 1e-3, "{after} of {before}");
    }

    #[test]
    fn the_gain_of_a_move_is_what_the_sum_of_areas_falls_by() {
        let boxes: Vec<_> = (0..200_u32)
            .map(|i| {
                let at = |k: u32| (i.wrapping_mul(2_654_435_761).wrapping_mul(k) >> 20) as f32 * 0.01;
                let min = Vec3::new(at(1), at(7), at(31));
                Aabb::new(min, min + Vec3::new(1.0, 3.0, 2.0))
            })
            .collect();
        let config =
            BuildConfig { builder: Builder::Median, width: Width::W2, leaf: 1, ..BuildConfig::default() };
        let (tree, _) = build(&boxes, &config, &Task::new()).expect("not cancelled");
        let Tree::W2(tree) = tree else { panic!("a binary tree") };
        let nodes = Bvh2::from_wide(&tree).nodes;
        let moves = Reinserter::new(nodes.clone()).moves(1.0, &Task::new()).expect("not cancelled");
        assert!(moves.len() > 20);
        for &Move { from, to, gain } in &moves {
            let mut reinserter = Reinserter::new(nodes.clone());
            reinserter.put(from, to);
            let fell = sum_of_areas(&nodes) - sum_of_areas(&reinserter.nodes);
            let again = Reinserter::new(nodes.clone()).gain(from, to);
            assert!((again - gain).abs() <= 1e-3 * gain + 1e-3, "{gain} {again}");
            assert!((fell - f64::from(gain)).abs() < 1e-2 * f64::from(gain) + 1e-2, "{gain} {fell}");
            // No other place would have been better.
            for other in 0..nodes.len() as u32 {
                let mut reinserter = Reinserter::new(nodes.clone());
                let pointless = other == sibling(from) || other == reinserter.parent(from);
                if !pointless && !reinserter.is_below(other, from) && from % 16 == 1 {
                    reinserter.put(from, other);
                    let would_fall = sum_of_areas(&nodes) - sum_of_areas(&reinserter.nodes);
                    assert!(would_fall <= fell + 1e-2, "{from} to {other}: {would_fall}, not {fell}");
                }
            }
        }
    }

    #[test]
    fn a_cancel_stops_it() {
        let task = Task::new();
        task.cancel();
        let mut bvh = mixed();
        assert_eq!(improve(&mut bvh, &config(3), &mut Onlooker::nobody(), &task), Err(Cancelled));
    }
}
