//! How a tree came about: node by node from the root down, or round by round where it was made in rounds.

use crate::accel::build::{Onlooker, RoundKind};
use crate::accel::{Builder, Improver, NodeId, Nodes, Tree};
use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Boxes of a round that are kept, the largest.
const MOST_KEPT: usize = 4000;

/// Memory for the boxes of all rounds, in boxes.
const MOST_KEPT_IN_ALL: usize = 1_000_000;

/// The steps of a construction.
#[derive(Clone, Debug)]
pub enum Construction {
    /// Step i splits inner node i: the order in which a top-down builder makes them, depth first.
    TopDown { inner_count: usize },
    /// What stood before the first round and after each.
    Rounds(Vec<Standing>),
}

/// The boxes that stood at a moment, the largest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    pub kind: RoundKind,
    /// The largest of them, with whether each is a leaf.
    pub boxes: Vec<(Aabb, bool)>,
    /// All that stood.
    pub count: usize,
    /// The sum of their areas over the root's.
    pub area: f64,
}

/// A node at a moment of a construction from the root down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grown {
    pub node: NodeId,
    pub bounds: Aabb,
    /// It will be split later.
    pub open: bool,
}

impl Construction {
    /// Of the world's tree. What was made in rounds is built once more.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(world: &World, task: &Task) -> Result<Self, Cancelled> {
        let config = &world.report.config;
        let in_rounds = config.builder == Builder::Ploc || config.improver != Improver::None;
        if !in_rounds || world.imported.is_some() {
            return Ok(Self::TopDown { inner_count: world.shown_tree().inner_count() });
        }
        let root_area = f64::from(world.build_scene().bounds().area());
        let mut rounds = Vec::new();
        let mut kept = 0;
        let mut look = |round: crate::accel::build::Round| {
            let mut boxes: Vec<(Aabb, bool)> = round.boxes().collect();
            let sum: f64 = boxes.iter().map(|(bounds, _)| f64::from(bounds.area())).sum();
            let most = MOST_KEPT.min(MOST_KEPT_IN_ALL.saturating_sub(kept)).max(64);
            if boxes.len() > most {
                boxes.select_nth_unstable_by(most, |a, b| b.0.area().total_cmp(&a.0.area()));
                boxes.truncate(most);
            }
            boxes.sort_by(|a, b| b.0.area().total_cmp(&a.0.area()));
            kept += boxes.len();
            let area = if root_area > 0.0 { sum / root_area } else { 0.0 };
            rounds.push(Standing { kind: round.kind, boxes, count: round.len(), area });
        };
        world.watch_build(Onlooker::new(&mut look), task)?;
        Ok(Self::Rounds(rounds))
    }

    /// Steps that can be made from nothing to the finished tree.
    pub fn len(&self) -> usize {
        match self {
            Self::TopDown { inner_count } => *inner_count,
            Self::Rounds(rounds) => rounds.len().saturating_sub(1),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The step after which a node is there with its children, for a construction from the root down.
    pub fn step_of(&self, tree: &Tree, node: NodeId) -> Option<usize> {
        let is_inner = (node.0 as usize) < tree.inner_count();
        (matches!(self, Self::TopDown { .. }) && is_inner).then_some(node.0 as usize + 1)
    }
}

/// The nodes that stand after so many splits of a construction from the root down: the `most` with the largest boxes, the
/// largest first.
pub fn grown(tree: &Tree, steps: usize, most: usize) -> Vec<Grown> {
    let mut standing = Vec::new();
    if tree.node_count() == 0 {
        return standing;
    }
    let mut open = vec![(NodeId(0), tree.bounds())];
    while let Some((node, bounds)) = open.pop() {
        let is_inner = (node.0 as usize) < tree.inner_count();
        if is_inner && (node.0 as usize) < steps {
            each_width!(tree, t => open.extend(t.children(node.0)));
        } else {
            standing.push(Grown { node, bounds, open: is_inner });
        }
    }
    let larger = |a: &Grown, b: &Grown| b.bounds.area().total_cmp(&a.bounds.area()).then(a.node.cmp(&b.node));
    if standing.len() > most && most > 0 {
        standing.select_nth_unstable_by(most, larger);
    }
    standing.truncate(most);
    standing.sort_by(larger);
    standing
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Width};
    use crate::scene::builtin;

    fn world(config: BuildConfig) -> World {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        World::build(scene, &config, &Task::new()).expect("nobody cancels")
    }

    #[test]
    fn a_tree_grows_from_its_root_to_its_leaves() {
        for width in [Width::W2, Width::W8] {
            let world = world(BuildConfig { width, ..BuildConfig::default() });
            let construction = Construction::of(&world, &Task::new()).expect("nobody cancels");
            assert_eq!(construction.len(), world.tree.inner_count());
            let first = grown(&world.tree, 0, 99);
            assert_eq!((first.len(), first[0].node), (1, NodeId(0)));
            let mut before = 1;
            for step in 1..=40 {
                let standing = grown(&world.tree, step, usize::MAX);
                assert!(standing.len() > before, "a split adds nodes");
                before = standing.len();
            }
            let last = grown(&world.tree, construction.len(), usize::MAX);
            assert_eq!(last.len(), world.tree.leaf_count());
            assert!(last.iter().all(|grown| !grown.open));
            let few = grown(&world.tree, construction.len(), 10);
            assert_eq!(few[..], last[..10]);
        }
    }

    #[test]
    fn clusters_become_fewer_round_by_round() {
        let config = BuildConfig { builder: Builder::Ploc, ..BuildConfig::default() };
        let construction = Construction::of(&world(config), &Task::new()).expect("nobody cancels");
        let Construction::Rounds(rounds) = construction else { panic!("ploc works in rounds") };
        assert_eq!(rounds[0].count, 4977);
        assert_eq!(rounds.last().map(|round| round.count), Some(1));
        assert!(rounds.windows(2).all(|pair| pair[1].count < pair[0].count));
        assert!(rounds.iter().all(|round| round.boxes.len() <= MOST_KEPT));
    }

    #[test]
    fn an_improver_s_rounds_make_boxes_smaller() {
        for improver in [Improver::Reinsertion, Improver::Rotations] {
            let config = BuildConfig { builder: Builder::Median, improver, ..BuildConfig::default() };
            let world = world(config);
            let construction = Construction::of(&world, &Task::new()).expect("nobody cancels");
            assert_eq!(construction.len() + 1, world.report.rounds.len());
            let Construction::Rounds(rounds) = construction else { panic!("it works in rounds") };
            assert!(rounds.windows(2).all(|pair| pair[1].area < pair[0].area), "{improver:?}");
        }
    }
}
