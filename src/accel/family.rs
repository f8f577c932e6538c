//! Where every node of a tree stands: its parent, its depth, and how much lies below it. For what goes up from a node or asks
//! for a whole subtree; a ray needs none of it.

use super::tree::{NodeId, Nodes, Tree};
use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// Inner nodes between two looks for a cancel.
const CHUNK: usize = 4096;

const NO_PARENT: u32 = u32::MAX;

/// One entry a node, by [`NodeId`]: 12 bytes each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Family {
    parents: Vec<u32>,
    depths: Vec<u32>,
    references: Vec<u32>,
}

impl Family {
    /// Looks at every node once.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(tree: &Tree, task: &Task) -> Result<Self, Cancelled> {
        let count = tree.node_count();
        let mut family =
            Self { parents: vec![NO_PARENT; count], depths: vec![0; count], references: vec![0; count] };
        each_width!(tree, t => family.climb_down(t, task)?);
        for leaf_idx in 0..tree.leaf_count() as u32 {
            family.references[tree.inner_count() + leaf_idx as usize] = tree.leaf_range(leaf_idx).count;
        }
        // A parent has a smaller number than its children.
        for node_idx in (1..count).rev() {
            if let Some(parent) = family.parent(NodeId(node_idx as u32)) {
                family.references[parent.0 as usize] += family.references[node_idx];
            }
        }
        Ok(family)
    }

    fn climb_down(&mut self, tree: &impl Nodes, task: &Task) -> Result<(), Cancelled> {
        for node_idx in 0..tree.inner_count() {
            if node_idx % CHUNK == 0 {
                task.check()?;
            }
            let depth = self.depths[node_idx] + 1;
            for (child, _) in tree.children(node_idx as u32) {
                self.parents[child.0 as usize] = node_idx as u32;
                self.depths[child.0 as usize] = depth;
            }
        }
        Ok(())
    }

    /// Nodes of the tree.
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    pub fn is_empty(&self) -> bool {
        self.parents.is_empty()
    }

    /// `None` for the root.
    pub fn parent(&self, node: NodeId) -> Option<NodeId> {
        let parent = self.parents[node.0 as usize];
        (parent != NO_PARENT).then_some(NodeId(parent))
    }

    /// The root is at depth 0.
    pub fn depth(&self, node: NodeId) -> u32 {
        self.depths[node.0 as usize]
    }

    /// References in the leaves below a node; a leaf's own.
    pub fn references(&self, node: NodeId) -> u32 {
        self.references[node.0 as usize]
    }

    /// From the root to the node, both included.
    pub fn path(&self, node: NodeId) -> Vec<NodeId> {
        let mut path: Vec<NodeId> = std::iter::successors(Some(node), |&n| self.parent(n)).collect();
        path.reverse();
        path
    }

    /// Whether a node is `ancestor` or lies below it.
    pub fn is_below(&self, node: NodeId, ancestor: NodeId) -> bool {
        std::iter::successors(Some(node), |&n| self.parent(n)).any(|n| n == ancestor)
    }

    /// The box of a node, as its parent keeps it.
    pub fn bounds(&self, tree: &Tree, node: NodeId) -> Aabb {
        let Some(parent) = self.parent(node) else { return tree.bounds() };
        let found = each_width!(tree, t => t.children(parent.0).find(|(child, _)| *child == node));
        found.expect("a parent knows its children").1
    }

    /// For every node the sum of a number over the node and all below it. `own`: a number a node, NaN for none.
    ///
    /// # Panics
    /// If there is not one number a node.
    pub fn sums(&self, own: &[f32]) -> Vec<f64> {
        assert_eq!(own.len(), self.len(), "a number a node");
        let mut sums: Vec<f64> = own.iter().map(|x| if x.is_nan() { 0.0 } else { f64::from(*x) }).collect();
        for node_idx in (1..sums.len()).rev() {
            if let Some(parent) = self.parent(NodeId(node_idx as u32)) {
                sums[parent.0 as usize] += sums[node_idx];
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{BuildConfig, Layout, Width, build};
    use glam::Vec3;

    fn tree(width: Width, layout: Layout, count: usize) -> Tree {
        let at = |i: usize| Vec3::new((i * 7 % 13) as f32, (i * 5 % 17) as f32, i as f32 * 0.1);
        let boxes: Vec<Aabb> = (0..count).map(|i| Aabb::new(at(i), at(i) + Vec3::ONE)).collect();
        let config = BuildConfig { width, layout, ..BuildConfig::default() };
        build(&boxes, &config, &Task::new()).expect("nobody cancels").0
    }

    #[test]
    fn it_says_what_a_walk_from_the_root_finds() {
        for &(width, layout) in &BuildConfig::NODES {
            for count in [1, 2, 3, 50, 300] {
                let tree = tree(width, layout, count);
                let family = Family::of(&tree, &Task::new()).expect("nobody cancels");
                assert_eq!(family.len(), tree.node_count());
                tree.walk_nodes(|visit| {
                    assert_eq!(family.parent(visit.id), visit.parent);
                    assert_eq!(family.depth(visit.id), visit.depth);
                    assert_eq!(family.bounds(&tree, visit.id), visit.bounds);
                    let path = family.path(visit.id);
                    assert_eq!((path.len() as u32, path.last()), (visit.depth + 1, Some(&visit.id)));
                    assert!(path.iter().all(|&above| family.is_below(visit.id, above)));
                    let below = (0..tree.leaf_count() as u32)
                        .filter(|leaf_idx| {
                            family.is_below(NodeId(tree.inner_count() as u32 + leaf_idx), visit.id)
                        })
                        .map(|leaf_idx| tree.leaf_range(leaf_idx).count);
                    assert_eq!(family.references(visit.id), below.sum::<u32>());
                    true
                });
                let sums = family.sums(&vec![1.0; tree.node_count()]);
                assert_eq!(sums[0], tree.node_count() as f64);
            }
        }
    }

    #[test]
    fn an_empty_tree_has_nobody() {
        let family = Family::of(&tree(Width::W4, Layout::Full, 0), &Task::new()).expect("nobody cancels");
        assert!(family.is_empty() && family.sums(&[]).is_empty());
    }

    #[test]
    fn what_has_no_number_adds_nothing() {
        let tree = tree(Width::W2, Layout::Full, 3);
        let family = Family::of(&tree, &Task::new()).expect("nobody cancels");
        let own: Vec<f32> = (0..tree.node_count()).map(|i| if i == 0 { f32::NAN } else { 2.0 }).collect();
        assert_eq!(family.sums(&own)[0], 2.0 * (tree.node_count() - 1) as f64);
    }
}
