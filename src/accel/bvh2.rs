//! The binary tree in the form that is easiest to change: what improvers work on, and what is widened.

use crate::geometry::Aabb;

use super::tree::{ChildRef, WideBvh};

/// A binary tree: node 0 is the root, siblings lie side by side, the first of them at an odd index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh2 {
    pub nodes: Vec<Bvh2Node>,
    /// Shape indices in leaf order.
    pub refs: Vec<u32>,
}

/// An inner node (`count == 0`, children at `first` and `first + 1`) or a leaf (references `first..first + count`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bvh2Node {
    pub bounds: Aabb,
    pub first: u32,
    pub count: u32,
}

impl Bvh2Node {
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// The references of a leaf.
    #[inline]
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }

    /// The two children of an inner node.
    #[inline]
    pub fn children(&self) -> [u32; 2] {
        [self.first, self.first + 1]
    }
}

/// A child of the binary tree, still to be written: a node of the tree that is copied, and its place in the copy.
struct Open<T> {
    from: T,
    to: usize,
}

impl Bvh2 {
    /// Nodes that are not there yet.
    pub(super) const PLACE: Bvh2Node = Bvh2Node { bounds: Aabb::EMPTY, first: 0, count: 0 };

    /// The same tree in depth-first order.
    pub fn from_wide(tree: &WideBvh<2>) -> Self {
        let mut copy = Self { nodes: Vec::with_capacity(2 * tree.leaves.len()), refs: tree.refs.clone() };
        if tree.root.is_empty() {
            return copy;
        }
        copy.nodes.push(Bvh2Node { bounds: tree.bounds, ..Self::PLACE });
        let mut open = vec![Open { from: tree.root, to: 0 }];
        while let Some(Open { from, to }) = open.pop() {
            if let Some(leaf_idx) = from.as_leaf() {
                let leaf = tree.leaves[leaf_idx as usize];
                (copy.nodes[to].first, copy.nodes[to].count) = (leaf.first, leaf.count);
            } else if let Some(node_idx) = from.as_inner() {
                let node = &tree.nodes[node_idx as usize];
                let first = copy.nodes.len();
                copy.nodes[to].first = first as u32;
                for slot in 0..2 {
                    copy.nodes.push(Bvh2Node { bounds: node.child_bounds(slot), ..Self::PLACE });
                }
                let child = |slot: usize| Open::<ChildRef> { from: node.children[slot], to: first + slot };
                open.extend([child(1), child(0)]);
            }
        }
        copy
    }

    /// The same tree with nodes and references in depth-first order: children behind their parents, and the references
    /// below any node in one range.
    pub fn in_depth_first_order(&self) -> Self {
        let mut copy =
            Self { nodes: Vec::with_capacity(self.nodes.len()), refs: Vec::with_capacity(self.refs.len()) };
        if self.nodes.is_empty() {
            return copy;
        }
        copy.nodes.push(Self::PLACE);
        let mut open = vec![Open { from: 0_u32, to: 0 }];
        while let Some(Open { from, to }) = open.pop() {
            let node = self.nodes[from as usize];
            let first;
            if node.is_leaf() {
                first = copy.refs.len();
                copy.refs.extend_from_slice(&self.refs[node.range()]);
            } else {
                first = copy.nodes.len();
                copy.nodes.extend([Self::PLACE; 2]);
                let [left, right] = node.children();
                open.extend([Open { from: right, to: first + 1 }, Open { from: left, to: first }]);
            }
            copy.nodes[to] = Bvh2Node { first: first as u32, ..node };
        }
        copy
    }

    /// Lets no leaf lie deeper than `most`: what would reach below is halved by count, in the order that the leaves have.
    /// For trees in depth-first order, with less than 2 to the power of `most` leaves.
    pub fn limit_depth(&mut self, most: usize) {
        let mut heights = vec![0_usize; self.nodes.len()];
        let mut leaf_counts = vec![1_usize; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate().rev().filter(|(_, node)| !node.is_leaf()) {
            let [left, right] = node.children().map(|child| child as usize);
            heights[i] = 1 + heights[left].max(heights[right]);
            leaf_counts[i] = leaf_counts[left] + leaf_counts[right];
        }
        let mut open = if self.nodes.is_empty() { Vec::new() } else { vec![(0_u32, 0)] };
        while let Some((node_idx, depth)) = open.pop() {
            let at = node_idx as usize;
            if depth + heights[at] <= most {
                continue;
            }
            let children = self.nodes[at].children();
            let halved = |child: u32| leaf_counts[child as usize].next_power_of_two().ilog2() as usize;
            if children.iter().all(|&child| depth + 1 + halved(child) <= most) {
                open.extend(children.map(|child| (child, depth + 1)));
            } else {
                // All that lies below follows the pair of children.
                let first = self.nodes[at].first as usize;
                let below = &self.nodes[first..first + 2 * (leaf_counts[at] - 1)];
                let mut leaves: Vec<_> = below.iter().filter(|node| node.is_leaf()).copied().collect();
                leaves.sort_unstable_by_key(|leaf| leaf.first);
                self.halve(at, &leaves, first);
            }
        }
    }

    /// Makes a balanced tree of leaves, with its root at `at` and all below from `first` on.
    fn halve(&mut self, at: usize, leaves: &[Bvh2Node], first: usize) {
        if let [leaf] = leaves {
            self.nodes[at] = *leaf;
            return;
        }
        let (left, right) = leaves.split_at(leaves.len() / 2);
        self.halve(first, left, first + 2);
        self.halve(first + 1, right, first + 2 * left.len());
        let bounds = self.nodes[first].bounds.union(self.nodes[first + 1].bounds);
        self.nodes[at] = Bvh2Node { bounds, first: first as u32, count: 0 };
    }

    /// Of the deepest leaf; the root is at depth 0.
    pub fn depth_max(&self) -> usize {
        let mut deepest = 0;
        let mut open = vec![(0_u32, 0)];
        while let Some((node_idx, depth)) = open.pop() {
            deepest = deepest.max(depth);
            match self.nodes.get(node_idx as usize) {
                Some(node) if !node.is_leaf() => open.extend(node.children().map(|child| (child, depth + 1))),
                _ => {}
            }
        }
        deepest
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, Tree, Width, build};
    use crate::task::Task;

    fn row(count: usize) -> Bvh2 {
        let at = |i: usize| Vec3::X * (2.0 * i as f32);
        let boxes: Vec<_> = (0..count).map(|i| Aabb::new(at(i), at(i) + Vec3::ONE)).collect();
        let config = BuildConfig { width: Width::W2, leaf: 1, ..BuildConfig::default() };
        match build(&boxes, &config, &Task::new()) {
            Ok((Tree::W2(tree), _)) => Bvh2::from_wide(&tree),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_copy_is_the_same_tree_and_siblings_lie_side_by_side() {
        for count in [1, 2, 3, 33] {
            let bvh = row(count);
            assert_eq!(bvh.nodes.len(), 2 * count - 1);
            assert_eq!(bvh.in_depth_first_order(), bvh);
            for node in bvh.nodes.iter().filter(|node| !node.is_leaf()) {
                assert_eq!(node.first % 2, 1);
                let [left, right] = node.children().map(|child| bvh.nodes[child as usize].bounds);
                assert_eq!(left.union(right), node.bounds);
            }
        }
        assert_eq!((row(4).depth_max(), row(1).depth_max()), (2, 0));
        assert!(row(0).nodes.is_empty() && row(0).in_depth_first_order().nodes.is_empty());
    }

    #[test]
    fn order_is_made_of_any() {
        let mut bvh = row(6);
        // The pair below the root changes places with the last one.
        let (first, last) = (bvh.nodes[0].first as usize, bvh.nodes.len() - 2);
        for i in 0..2 {
            bvh.nodes.swap(first + i, last + i);
        }
        for node in &mut bvh.nodes {
            if !node.is_leaf() {
                node.first = match node.first as usize {
                    at if at == first => last as u32,
                    at if at == last => first as u32,
                    _ => node.first,
                };
            }
        }
        assert_eq!(bvh.in_depth_first_order(), row(6));
    }
}
