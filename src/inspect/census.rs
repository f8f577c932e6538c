//! What is known of every node of a tree: found out piece by piece in the background, looked up at once.

use std::sync::OnceLock;

use crate::accel::{Family, NodeId};
use crate::task::{Cancelled, Task};
use crate::world::{NodeFigure, World};

/// How wide a node is in an icicle plot, and in which order siblings come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Weight {
    /// References below the node.
    #[default]
    Shapes,
    /// SAH cost of the node and all below it.
    SahCost,
    /// Visits of the node and all below it by the rays of the frame.
    Visits,
}

impl Weight {
    pub const ALL: [Self; 3] = [Self::Shapes, Self::SahCost, Self::Visits];

    pub fn name(self) -> &'static str {
        match self {
            Self::Shapes => "shapes",
            Self::SahCost => "SAH cost",
            Self::Visits => "visits",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Shapes => "references in the leaves below",
            Self::SahCost => "SAH cost of the node and of all below it",
            Self::Visits => "visits of the node and of all below it, by the rays of this frame",
        }
    }
}

/// Numbers of every node, by [`NodeId`].
#[derive(Debug)]
pub struct Census {
    pub family: Family,
    values: [OnceLock<Values>; NodeFigure::ALL.len()],
    sah_below: OnceLock<Vec<f32>>,
}

/// A figure of every node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// NaN where it is undefined.
    pub of_nodes: Vec<f32>,
    /// What the two ends of its colours mean; `None` if no node has a number.
    pub range: Option<[f32; 2]>,
}

impl Values {
    pub fn new(figure: NodeFigure, of_nodes: Vec<f32>) -> Self {
        let range = figure.range(&of_nodes);
        Self { of_nodes, range }
    }
}

/// How often the rays of a frame visit each node.
#[derive(Clone, Debug, Default)]
pub struct Visits {
    /// Of the node itself, as a figure.
    pub own: Values,
    /// Of the node and all below it.
    pub below: Vec<f32>,
}

impl Visits {
    pub fn new(census: &Census, visits: &[u32]) -> Self {
        let own: Vec<f32> = visits.iter().map(|&n| n as f32).collect();
        let below = census.below(&own);
        Self { own: Values::new(NodeFigure::Visits, own), below }
    }
}

impl Census {
    /// Of the tree that is shown.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(world: &World, task: &Task) -> Result<Self, Cancelled> {
        let family = Family::of(world.shown_tree(), task)?;
        Ok(Self { family, values: std::array::from_fn(|_| OnceLock::new()), sah_below: OnceLock::new() })
    }

    /// A figure of every node, NaN where it is undefined. `world` is the one that this is of.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn values(&self, world: &World, figure: NodeFigure, task: &Task) -> Result<&Values, Cancelled> {
        let cell = &self.values[figure as usize];
        if let Some(known) = cell.get() {
            return Ok(known);
        }
        let found = Values::new(figure, world.node_values(figure, task)?);
        Ok(cell.get_or_init(|| found))
    }

    /// [`Census::values`], if they are known.
    pub fn known_values(&self, figure: NodeFigure) -> Option<&Values> {
        self.values[figure as usize].get()
    }

    /// Finds out the share of the SAH cost of every node and all below it.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn find_sah_below(&self, world: &World, task: &Task) -> Result<(), Cancelled> {
        let own = self.values(world, NodeFigure::SahShare, task)?;
        self.sah_below.get_or_init(|| self.below(&own.of_nodes));
        Ok(())
    }

    /// For every node a number's sum over the node and all below it.
    pub fn below(&self, own: &[f32]) -> Vec<f32> {
        self.family.sums(own).into_iter().map(|sum| sum as f32).collect()
    }

    /// The share of the SAH cost of a node and all below it, if known.
    pub fn known_sah_below(&self, node: NodeId) -> Option<f32> {
        self.sah_below.get()?.get(node.0 as usize).copied()
    }

    pub fn knows_sah_below(&self) -> bool {
        self.sah_below.get().is_some()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::scene::builtin;

    #[test]
    fn what_was_found_out_is_known() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let world = World::build(scene, &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let census = Census::of(&world, &Task::new()).expect("nobody cancels");
        assert!(census.known_values(NodeFigure::Overlap).is_none());
        assert_eq!(census.known_sah_below(NodeId(0)), None);
        let overlaps = census.values(&world, NodeFigure::Overlap, &Task::new()).expect("nobody cancels");
        // NaN is not equal to itself.
        assert!(census.known_values(NodeFigure::Overlap).is_some_and(|known| std::ptr::eq(known, overlaps)));
        census.find_sah_below(&world, &Task::new()).expect("nobody cancels");
        let all = census.known_sah_below(NodeId(0)).expect("known");
        assert!((all - 1.0).abs() < 1e-5, "{all}");
    }

    #[test]
    fn a_cancelled_census_can_be_asked_again() {
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let world = World::build(scene, &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let census = Census::of(&world, &Task::new()).expect("nobody cancels");
        let cancelled = Task::new();
        cancelled.cancel();
        assert!(census.values(&world, NodeFigure::Epo, &cancelled).is_err());
        assert!(census.values(&world, NodeFigure::Epo, &Task::new()).is_ok());
    }
}
