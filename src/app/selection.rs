//! What is selected in the tree, what was selected before, and which shapes are hidden.

use std::sync::Arc;

use glam::Vec2;

use crate::accel::{Family, NodeId, Tree};
use crate::geometry::Ray;
use crate::inspect::node::leaves_of_shape;
use crate::inspect::ray_history::{RayHistory, RayStep};
use crate::scene::Camera;
use crate::world::{RayQuery, World};

use super::jobs::TreeKey;

/// Selections that can be gone back to.
const MOST_BACK: usize = 100;

/// Nodes of one tree, and how they were come by.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    pub tree: TreeKey,
    /// At least one; what is said of one node is said of the last.
    pub nodes: Vec<NodeId>,
    /// Below the last node, or it: how far down [`Go::Down`] leads again.
    pub tip: NodeId,
    pub shape: Option<u32>,
    /// The ray that found the shape.
    pub ray: Option<Ray>,
}

impl Selection {
    /// The node of which more is said.
    pub fn node(&self) -> NodeId {
        self.nodes.last().copied().unwrap_or(self.tip)
    }

    fn of_node(tree: TreeKey, node: NodeId) -> Self {
        Self { tree, nodes: vec![node], tip: node, shape: None, ray: None }
    }

    /// The shape that a ray hits, and the leaf in which it was found; `None` for a miss.
    pub fn of_ray(world: &World, tree: TreeKey, ray: &Ray) -> Option<Self> {
        let history = RayHistory::record(world, ray, RayQuery::Intersect);
        let shape = history.answer?;
        let leaf = leaf_that_answered(&history).or_else(|| first_leaf(&world.tree, shape));
        // A plane lies outside the tree.
        let leaf = leaf.filter(|_| (shape as usize) < world.scene.shape_count())?;
        Some(Self { tree, nodes: vec![leaf], tip: leaf, shape: Some(shape), ray: Some(*ray) })
    }

    fn of_shape(world: &World, tree: TreeKey, shape: u32) -> Option<Self> {
        let leaf = first_leaf(world.shown_tree(), shape)?;
        Some(Self { tree, nodes: vec![leaf], tip: leaf, shape: Some(shape), ray: None })
    }

    /// The same shape's leaf in another tree of the scene; as far above it as the node was above its leaf.
    fn in_tree(&self, world: &World, tree: TreeKey) -> Option<Self> {
        let again = self.ray.and_then(|ray| Self::of_ray(world, tree, &ray));
        again.filter(|found| found.shape == self.shape).or_else(|| Self::of_shape(world, tree, self.shape?))
    }
}

/// The leaf whose test found the answer.
fn leaf_that_answered(history: &RayHistory) -> Option<NodeId> {
    let mut leaf = None;
    let mut answered = None;
    for step in &history.steps {
        match step {
            RayStep::Leaf { node } => leaf = Some(*node),
            RayStep::Shape { shape, outcome: crate::inspect::ray_history::Outcome::Nearest { .. } }
                if Some(*shape) == history.answer =>
            {
                answered = leaf;
            }
            _ => {}
        }
    }
    answered
}

fn first_leaf(tree: &Tree, shape: u32) -> Option<NodeId> {
    leaves_of_shape(tree, shape).first().copied()
}

/// A way from what is selected to something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Go {
    /// To the parent, and down again towards where one came from.
    Up,
    Down,
    /// Through what was selected before.
    Back,
    Forward,
}

/// What is asked to be selected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pick {
    /// What a pixel's camera ray hits; nothing for a miss.
    Pixel {
        camera: Camera,
        size: [u32; 2],
        pixel: [u32; 2],
    },
    Node(NodeId),
    Shape(u32),
}

/// The selection, and those before and after it.
#[derive(Debug, Default)]
pub struct Selections {
    current: Option<Selection>,
    back: Vec<Selection>,
    forward: Vec<Selection>,
    /// Counts the changes.
    pub version: u64,
}

impl Selections {
    pub fn current(&self) -> Option<&Selection> {
        self.current.as_ref()
    }

    pub fn can_go_back(&self) -> bool {
        !self.back.is_empty()
    }

    pub fn can_go_forward(&self) -> bool {
        !self.forward.is_empty()
    }

    /// Selects something of the tree that is shown; `add`: beside what is selected, or no longer if it was.
    /// `seen`: the same scene, perhaps without what is hidden.
    pub fn pick(&mut self, world: &World, seen: &World, tree: TreeKey, pick: Pick, add: bool) {
        let found = match pick {
            Pick::Pixel { camera, size: [width, height], pixel: [x, y] } => {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let ray = camera.frame(width, height).ray(at);
                if std::ptr::eq(world, seen) {
                    Selection::of_ray(world, tree, &ray)
                } else {
                    let hit = seen.intersect(&ray, &mut ());
                    hit.and_then(|hit| Selection::of_shape(world, tree, hit.shape))
                }
            }
            Pick::Node(node) => {
                let exists = (node.0 as usize) < world.shown_tree().node_count();
                exists.then(|| Selection::of_node(tree, node))
            }
            Pick::Shape(shape) => Selection::of_shape(world, tree, shape),
        };
        let before = self.current.as_ref().filter(|before| before.tree == tree);
        match (found, before) {
            (Some(found), Some(before)) if add => {
                let mut nodes = before.nodes.clone();
                let node = found.node();
                match nodes.iter().position(|n| *n == node) {
                    Some(at) if nodes.len() > 1 => drop(nodes.remove(at)),
                    Some(_) => {}
                    None => nodes.push(node),
                }
                let tip = nodes.last().copied().unwrap_or(node);
                self.select(Some(Selection { nodes, tip, ..found }));
            }
            (None, _) if add => {}
            (found, _) => self.select(found),
        }
    }

    /// Selects nothing.
    pub fn clear(&mut self) {
        self.select(None);
    }

    /// Forgets everything: another scene is open.
    pub fn forget(&mut self) {
        *self = Self { version: self.version + 1, ..Self::default() };
    }

    pub fn go(&mut self, way: Go, family: Option<&Family>) {
        match way {
            Go::Back => {
                let Some(before) = self.back.pop() else { return };
                self.forward.extend(self.current.replace(before));
            }
            Go::Forward => {
                let Some(after) = self.forward.pop() else { return };
                self.back.extend(self.current.replace(after));
            }
            Go::Up | Go::Down => {
                let (Some(selection), Some(family)) = (&mut self.current, family) else { return };
                let node = selection.node();
                let next = match way {
                    Go::Up => family.parent(node),
                    _ => {
                        let path = family.path(selection.tip);
                        let at = path.iter().position(|n| *n == node);
                        at.and_then(|at| path.get(at + 1).copied())
                    }
                };
                let (Some(next), Some(last)) = (next, selection.nodes.last_mut()) else { return };
                *last = next;
            }
        }
        self.version += 1;
    }

    /// Follows to another tree of the same scene: to the leaf of the selected shape, if one is.
    pub fn follow(&mut self, world: &World, tree: TreeKey) {
        if self.current.as_ref().is_none_or(|selection| selection.tree == tree) {
            return;
        }
        self.current = self.current.take().and_then(|selection| selection.in_tree(world, tree));
        // Numbers of nodes mean something else there.
        let same_shapes = |selections: &mut Vec<Selection>| {
            *selections = selections.iter().filter_map(|s| s.in_tree(world, tree)).collect();
        };
        same_shapes(&mut self.back);
        same_shapes(&mut self.forward);
        self.version += 1;
    }

    fn select(&mut self, selection: Option<Selection>) {
        if self.current == selection {
            return;
        }
        self.forward.clear();
        self.back.extend(self.current.take());
        if self.back.len() > MOST_BACK {
            self.back.remove(0);
        }
        self.current = selection;
        self.version += 1;
    }
}

/// Shapes that are not drawn, and the world without them, once it is there.
#[derive(Clone, Debug, Default)]
pub struct Hidden {
    /// Ascending.
    pub shapes: Arc<Vec<u32>>,
    /// Counts the changes.
    pub version: u64,
}

impl Hidden {
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    pub fn contains(&self, shape: u32) -> bool {
        self.shapes.binary_search(&shape).is_ok()
    }

    /// Hides more shapes, ascending.
    pub fn hide(&mut self, shapes: &[u32]) {
        let mut all = [&self.shapes[..], shapes].concat();
        all.sort_unstable();
        all.dedup();
        self.set(all);
    }

    /// Hides all shapes below `count` but these, ascending.
    pub fn show_only(&mut self, shapes: &[u32], count: usize) {
        let is_hidden = |shape: &u32| shapes.binary_search(shape).is_err();
        self.set((0..count as u32).filter(is_hidden).collect());
    }

    pub fn show_all(&mut self) {
        self.set(Vec::new());
    }

    fn set(&mut self, shapes: Vec<u32>) {
        if *self.shapes != shapes {
            self.shapes = Arc::new(shapes);
            self.version += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::app::jobs::SceneKey;
    use crate::scene::builtin;
    use crate::task::Task;

    fn world(config: BuildConfig) -> (World, TreeKey) {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let world = World::build(scene, &config, &Task::new()).expect("nobody cancels");
        (world, TreeKey { scene: SceneKey::for_tests(1), config, file: None })
    }

    /// The middle of the picture.
    fn middle(world: &World) -> Pick {
        Pick::Pixel { camera: world.scene.camera, size: [64, 48], pixel: [32, 24] }
    }

    #[test]
    fn a_ray_selects_the_leaf_that_answered_it() {
        let (world, key) = world(BuildConfig { builder: Builder::Spatial, ..BuildConfig::default() });
        let mut selections = Selections::default();
        selections.pick(&world, &world, key, middle(&world), false);
        let selection = selections.current().expect("there is something in the middle");
        let shape = selection.shape.expect("a ray finds a shape");
        let ray = selection.ray.expect("a ray found it");
        assert_eq!(world.intersect(&ray, &mut ()).map(|hit| hit.shape), Some(shape));
        let leaf_idx = world.tree.leaf_index(selection.node()).expect("a leaf");
        assert!(world.tree.leaf_shapes(leaf_idx).contains(&shape));
    }

    #[test]
    fn up_and_down_walk_the_path_to_the_root() {
        let (world, key) = world(BuildConfig::default());
        let family = Family::of(&world.tree, &Task::new()).expect("nobody cancels");
        let mut selections = Selections::default();
        selections.pick(&world, &world, key, middle(&world), false);
        let leaf = selections.current().expect("selected").node();
        let path = family.path(leaf);
        for above in path.iter().rev().skip(1) {
            selections.go(Go::Up, Some(&family));
            assert_eq!(selections.current().map(Selection::node), Some(*above));
        }
        selections.go(Go::Up, Some(&family));
        assert_eq!(selections.current().map(Selection::node), Some(NodeId(0)), "above the root is nothing");
        for below in &path[1..] {
            selections.go(Go::Down, Some(&family));
            assert_eq!(selections.current().map(Selection::node), Some(*below));
        }
        selections.go(Go::Down, Some(&family));
        assert_eq!(selections.current().map(Selection::node), Some(leaf));
    }

    #[test]
    fn nodes_are_added_and_taken_away() {
        let (world, key) = world(BuildConfig::default());
        let mut selections = Selections::default();
        for node in [3, 5, 7, 5] {
            selections.pick(&world, &world, key, Pick::Node(NodeId(node)), true);
        }
        let nodes = |s: &Selections| s.current().map(|s| s.nodes.iter().map(|n| n.0).collect::<Vec<_>>());
        assert_eq!(nodes(&selections), Some(vec![3, 7]));
        selections.go(Go::Back, None);
        assert_eq!(nodes(&selections), Some(vec![3, 5, 7]));
        selections.go(Go::Forward, None);
        assert_eq!(nodes(&selections), Some(vec![3, 7]));
        selections.pick(&world, &world, key, Pick::Node(NodeId(u32::MAX - 1)), false);
        assert_eq!(nodes(&selections), None, "there is no such node");
        selections.go(Go::Back, None);
        assert_eq!(nodes(&selections), Some(vec![3, 7]));
    }

    #[test]
    fn a_selection_follows_its_shape_to_another_tree() {
        let (world_a, a) = world(BuildConfig::default());
        let (world_b, b) = world(BuildConfig { leaf: 8, ..BuildConfig::default() });
        let mut selections = Selections::default();
        selections.pick(&world_a, &world_a, a, Pick::Node(NodeId(1)), false);
        selections.pick(&world_a, &world_a, a, Pick::Shape(77), false);
        selections.follow(&world_b, b);
        let selection = selections.current().expect("the shape is there, too");
        assert_eq!((selection.tree, selection.shape), (b, Some(77)));
        let leaf_idx = world_b.tree.leaf_index(selection.node()).expect("a leaf");
        assert!(world_b.tree.leaf_shapes(leaf_idx).contains(&77));
        assert!(!selections.can_go_back(), "a node without a shape is no more");
    }

    #[test]
    fn shapes_are_hidden_and_shown() {
        let mut hidden = Hidden::default();
        hidden.hide(&[2, 5]);
        hidden.hide(&[3, 5]);
        assert_eq!(*hidden.shapes, [2, 3, 5]);
        assert!(hidden.contains(3) && !hidden.contains(4));
        hidden.show_only(&[1, 3], 5);
        assert_eq!(*hidden.shapes, [0, 2, 4]);
        let version = hidden.version;
        hidden.show_only(&[1, 3], 5);
        assert_eq!(hidden.version, version, "nothing changed");
        hidden.show_all();
        assert!(hidden.is_empty());
    }
}
