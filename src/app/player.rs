//! The player of a tree's construction: which step is shown, and what stands then.

use std::sync::Arc;
use std::time::Instant;

use crate::accel::{NodeId, Tree};
use crate::geometry::Aabb;
use crate::inspect::construction::{Construction, Grown, grown};

use super::jobs::TreeKey;

/// Boxes that are drawn of a moment, the largest.
pub const MOST_DRAWN: usize = 600;

/// Steps a second that can be set.
pub const SPEEDS: std::ops::RangeInclusive<f32> = 0.5..=20_000.0;

/// What the user has set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayerView {
    /// Steps that have been made; more than there are for the finished tree.
    pub step: usize,
    pub playing: bool,
    /// Steps a second.
    pub speed: f32,
}

impl Default for PlayerView {
    fn default() -> Self {
        Self { step: usize::MAX, playing: false, speed: 4.0 }
    }
}

/// What stands at a moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// The largest boxes, the largest first, each with whether it is open: to be split or merged yet.
    pub boxes: Vec<(Aabb, bool)>,
    /// The node that the last step split, with its children.
    pub split: Option<(NodeId, Aabb, Vec<Aabb>)>,
}

/// The construction at hand.
#[derive(Debug, Default)]
pub struct Player {
    pub view: PlayerView,
    pub construction: Option<(TreeKey, Arc<Construction>)>,
    shown: Option<(TreeKey, usize, Arc<Shown>)>,
    played: Option<Instant>,
}

impl Player {
    /// Of the tree at hand.
    pub fn of(&self, tree: TreeKey) -> Option<&Arc<Construction>> {
        self.construction.as_ref().filter(|(key, _)| *key == tree).map(|(_, construction)| construction)
    }

    /// How many steps have been made of how many.
    pub fn step(&self, tree: TreeKey) -> (usize, usize) {
        let count = self.of(tree).map_or(0, |construction| construction.len());
        (self.view.step.min(count), count)
    }

    /// What stands at the step that is shown; found anew when it is another one.
    pub fn show(&mut self, key: TreeKey, tree: &Tree) -> Option<&Shown> {
        let (step, _) = self.step(key);
        let construction = Arc::clone(self.of(key)?);
        if self.shown.as_ref().is_none_or(|(shown, at, _)| (*shown, *at) != (key, step)) {
            self.shown = Some((key, step, Arc::new(Shown::of(&construction, tree, step))));
        }
        self.shown.as_ref().map(|(.., shown)| &**shown)
    }

    /// What [`Player::show`] found last.
    pub fn shown(&self, key: TreeKey) -> Option<&Shown> {
        self.shown.as_ref().filter(|(of, ..)| *of == key).map(|(.., shown)| &**shown)
    }

    /// Makes the steps that are due.
    pub fn play(&mut self, key: TreeKey, now: Instant) {
        let (step, count) = self.step(key);
        if !self.view.playing || step >= count {
            self.view.playing = false;
            self.played = None;
            return;
        }
        let last = *self.played.get_or_insert(now);
        let due = (now.saturating_duration_since(last).as_secs_f32() * self.view.speed) as usize;
        if due > 0 {
            self.view.step = (step + due).min(count);
            self.played = Some(now);
        }
    }

    /// Another scene is open.
    pub fn forget(&mut self) {
        let view = PlayerView { step: usize::MAX, playing: false, ..self.view };
        *self = Self { view, ..Self::default() };
    }
}

impl Shown {
    fn of(construction: &Construction, tree: &Tree, step: usize) -> Self {
        match construction {
            Construction::TopDown { .. } => {
                let standing = grown(tree, step, MOST_DRAWN);
                let boxes = standing.iter().map(|Grown { bounds, open, .. }| (*bounds, *open)).collect();
                let last = step.checked_sub(1).map(|i| NodeId(i as u32));
                Self { boxes, split: last.map(|node| split_of(tree, node)) }
            }
            Construction::Rounds(rounds) => {
                let standing = rounds.get(step.min(rounds.len().saturating_sub(1)));
                let boxes = standing.map_or(&[][..], |standing| &standing.boxes);
                let boxes = boxes.iter().take(MOST_DRAWN).map(|(bounds, leaf)| (*bounds, !leaf));
                Self { boxes: boxes.collect(), split: None }
            }
        }
    }
}

/// A node with its children's boxes.
fn split_of(tree: &Tree, node: NodeId) -> (NodeId, Aabb, Vec<Aabb>) {
    let children = match crate::inspect::node::kind_of(tree, node) {
        crate::accel::NodeKind::Inner(children) => children.into_iter().map(|(_, bounds)| bounds).collect(),
        crate::accel::NodeKind::Leaf(_) => Vec::new(),
    };
    let own = children.iter().fold(Aabb::EMPTY, |all: Aabb, bounds: &Aabb| all.union(*bounds));
    (node, own, children)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::app::jobs::SceneKey;
    use crate::scene::builtin;
    use crate::task::Task;
    use crate::world::World;

    #[test]
    fn a_construction_is_played_to_its_end() {
        let scene = Arc::new(builtin::make("soup:200").expect("a built-in scene"));
        let config = BuildConfig::default();
        let world = World::build(scene, &config, &Task::new()).expect("nobody cancels");
        let key = TreeKey { scene: SceneKey::for_tests(1), config, file: None };
        let construction = Construction::of(&world, &Task::new()).expect("nobody cancels");
        let count = construction.len();
        let mut player = Player { construction: Some((key, Arc::new(construction))), ..Player::default() };
        assert_eq!(player.step(key), (count, count), "at first the finished tree");
        player.view = PlayerView { step: 0, playing: true, speed: 10.0 };
        assert_eq!(player.show(key, &world.tree).expect("there").boxes.len(), 1);
        let start = Instant::now();
        player.play(key, start);
        player.play(key, start + Duration::from_millis(250));
        assert_eq!(player.step(key).0, 2);
        let shown = player.show(key, &world.tree).expect("there").clone();
        let (node, _, children) = shown.split.expect("a split");
        assert_eq!(node, NodeId(1));
        assert!(children.len() > 1 && shown.boxes.len() > 2);
        player.play(key, start + Duration::from_secs(3600));
        player.play(key, start + Duration::from_secs(3601));
        assert!(!player.view.playing && player.step(key).0 == count);
    }
}
