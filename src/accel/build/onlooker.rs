//! Who looks on while a tree is made in rounds: usually nobody.

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::geometry::Aabb;

/// What stands after a round.
#[derive(Clone, Copy, Debug)]
pub struct Round<'a> {
    pub kind: RoundKind,
    boxes: Boxes<'a>,
}

/// What a round does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoundKind {
    /// `ploc` merges pairs of clusters.
    Merge,
    /// An improver changes a finished binary tree; the first one is before its first round.
    Improve,
}

#[derive(Clone, Copy, Debug)]
enum Boxes<'a> {
    Clusters(&'a [Bvh2Node]),
    Tree(&'a Bvh2),
}

impl Round<'_> {
    /// The boxes that stand: of all clusters, or of all nodes of the tree, each with whether it is a leaf.
    pub fn boxes(&self) -> impl Iterator<Item = (Aabb, bool)> + '_ {
        let nodes = match self.boxes {
            Boxes::Clusters(clusters) => clusters,
            Boxes::Tree(tree) => &tree.nodes,
        };
        nodes.iter().map(|node| (node.bounds, node.is_leaf()))
    }

    pub fn len(&self) -> usize {
        match self.boxes {
            Boxes::Clusters(clusters) => clusters.len(),
            Boxes::Tree(tree) => tree.nodes.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Is told of every round, or is nobody.
pub struct Onlooker<'a>(Option<&'a mut dyn FnMut(Round)>);

impl<'a> Onlooker<'a> {
    pub fn nobody() -> Self {
        Self(None)
    }

    pub fn new(look: &'a mut dyn FnMut(Round)) -> Self {
        Self(Some(look))
    }

    pub(in crate::accel) fn merged(&mut self, clusters: &[Bvh2Node]) {
        if let Some(look) = &mut self.0 {
            look(Round { kind: RoundKind::Merge, boxes: Boxes::Clusters(clusters) });
        }
    }

    pub(in crate::accel) fn improved(&mut self, tree: &Bvh2) {
        if let Some(look) = &mut self.0 {
            look(Round { kind: RoundKind::Improve, boxes: Boxes::Tree(tree) });
        }
    }
}
