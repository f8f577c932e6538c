//! The numbers that every single node has: what boxes are coloured by.

use serde::{Deserialize, Serialize};

use super::World;
use crate::accel::quality::nodes;
use crate::accel::tree::Visit;
use crate::task::{Cancelled, Task};

/// A number of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NodeFigure {
    #[default]
    Depth,
    LeafSize,
    SahShare,
    Epo,
    Overlap,
    EmptySpace,
    Fill,
    Visits,
    Unique,
}

impl NodeFigure {
    pub const ALL: [Self; 9] = [
        Self::Depth,
        Self::LeafSize,
        Self::SahShare,
        Self::Epo,
        Self::Overlap,
        Self::EmptySpace,
        Self::Fill,
        Self::Visits,
        Self::Unique,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::LeafSize => "leaf-size",
            Self::SahShare => "sah-share",
            Self::Epo => "epo",
            Self::Overlap => "overlap",
            Self::EmptySpace => "empty-space",
            Self::Fill => "fill",
            Self::Visits => "visits",
            Self::Unique => "unique",
        }
    }

    /// The name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::LeafSize => "leaf size",
            Self::SahShare => "SAH share",
            Self::Epo => "EPO",
            Self::Overlap => "overlap",
            Self::EmptySpace => "empty space",
            Self::Fill => "fill",
            Self::Visits => "visits",
            Self::Unique => "unique colour",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Depth => "by depth below the root",
            Self::LeafSize => "by the number of shapes in the leaf; inner nodes grey",
            Self::SahShare => "by the node's own share of the tree's SAH cost",
            Self::Epo => {
                "by the node's part of the end-point overlap: surface in its box that belongs elsewhere"
            }
            Self::Overlap => "by how much of a node's area its children share in pairs; leaves grey",
            Self::EmptySpace => "by the share of a node's volume that no child covers; leaves grey",
            Self::Fill => "by the share of a node's slots that are used, of a leaf's lanes",
            Self::Visits => "by how many of the rays of this frame visit the node",
            Self::Unique => "a colour of its own for each node",
        }
    }
}

/// A number for each node, far apart for neighbouring ones, in 0..1.
fn unique(node: u32) -> f32 {
    // Steps of the golden ratio fill the circle evenly (Knuth, "The Art of Computer Programming", volume 3, 6.4).
    (f64::from(node) * 0.618_033_988_749_894_9).fract() as f32
}

impl World {
    /// A figure of every node of the tree that is shown, by [`NodeId`](crate::accel::NodeId); NaN where it is undefined, or was too dear to find out.
    /// The visits depend on rays: here they are all NaN, and `render::visits::node_values` counts them.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn node_values(&self, figure: NodeFigure, task: &Task) -> Result<Vec<f32>, Cancelled> {
        let (tree, config) = (self.shown_tree(), &self.report.config);
        Ok(match figure {
            NodeFigure::Depth => {
                let mut depths = vec![f32::NAN; tree.node_count()];
                tree.walk_nodes(|Visit { id, depth, .. }| {
                    depths[id.0 as usize] = depth as f32;
                    true
                });
                depths
            }
            NodeFigure::LeafSize => nodes::leaf_sizes(tree),
            NodeFigure::SahShare => nodes::sah_shares(tree, config.traversal_cost, config.intersection_cost),
            NodeFigure::Epo => match self.epo(task)? {
                Some(epo) if std::ptr::eq(tree, &self.tree) => epo.nodes.clone(),
                _ => vec![f32::NAN; tree.node_count()],
            },
            NodeFigure::Overlap => nodes::overlaps(tree),
            NodeFigure::EmptySpace => nodes::empty_spaces(tree),
            NodeFigure::Fill => nodes::fills(tree),
            NodeFigure::Visits => vec![f32::NAN; tree.node_count()],
            NodeFigure::Unique => (0..tree.node_count() as u32).map(unique).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::scene::builtin;

    #[test]
    fn every_figure_has_a_number_a_node_and_names_of_its_own() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let world = World::build(scene, &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let mut names = std::collections::HashSet::new();
        for figure in NodeFigure::ALL {
            let values = world.node_values(figure, &Task::new()).expect("nobody cancels");
            assert_eq!(values.len(), world.tree.node_count(), "{figure:?}");
            let tells = figure != NodeFigure::Visits;
            assert_eq!(values.iter().any(|v| *v > 0.0), tells, "{figure:?}");
            assert!(values.iter().all(|v| v.is_nan() || *v >= 0.0), "{figure:?}");
            assert!(names.insert(figure.name()) && names.insert(figure.description()));
        }
    }
}
