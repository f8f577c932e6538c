//! The split costs of the selected node, and how they are looked at.

use std::sync::Arc;

use crate::accel::NodeId;
use crate::geometry::Aabb;
use crate::inspect::split_curve::{BinnedPlanes, SplitCurve};

use super::jobs::TreeKey;

/// What the user has set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitView {
    /// Bins that are held beside those of the build.
    pub bins: usize,
    /// The axis whose planes are drawn, and whose curve stands out.
    pub axis: usize,
    /// Whether the planes between bins are drawn in the viewport.
    pub drawn: bool,
    /// A plane that is pointed at: its axis and position.
    pub hovered: Option<(usize, f32)>,
}

impl Default for SplitView {
    fn default() -> Self {
        Self { bins: 64, axis: 0, drawn: true, hovered: None }
    }
}

/// What was found of one node.
#[derive(Clone, Debug)]
pub struct FoundSplits {
    pub tree: TreeKey,
    pub curve: Arc<SplitCurve>,
    /// Between the bins of the build, and between those that are held beside them.
    pub planes: [BinnedPlanes; 2],
}

/// The split costs at hand.
#[derive(Debug, Default)]
pub struct Splitting {
    pub view: SplitView,
    pub found: Option<FoundSplits>,
    /// The two sides of the plane that is pointed at.
    pub sides: Option<[(usize, Aabb); 2]>,
}

impl Splitting {
    /// Of the node that is selected.
    pub fn of(&self, tree: TreeKey, node: NodeId) -> Option<&FoundSplits> {
        self.found.as_ref().filter(|found| found.tree == tree && found.curve.node == node)
    }

    /// Takes what the user has set, and finds the two sides of the plane that is pointed at.
    pub fn set(&mut self, view: SplitView) {
        if view.hovered != self.view.hovered {
            self.sides = view
                .hovered
                .zip(self.found.as_ref())
                .map(|((axis, position), found)| found.curve.costs.sides(axis, position));
        }
        self.view = view;
    }
}
