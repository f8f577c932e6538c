//! One node and its family: what is said of a selected node.

use crate::accel::quality::siblings;
use crate::accel::{Family, NodeId, NodeKind, Nodes, Tree};
use crate::each_width;
use crate::geometry::Aabb;
use crate::world::World;

/// What the tree tells of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeFacts {
    pub node: NodeId,
    pub bounds: Aabb,
    /// The root is at depth 0.
    pub depth: u32,
    pub parent: Option<NodeId>,
    /// Of an inner node, in slot order, with the references below each.
    pub children: Vec<Child>,
    /// Of a leaf, in the order of its references.
    pub shapes: Vec<u32>,
    /// References in the leaves below it; a leaf's own.
    pub references: u32,
    /// Its area as a share of the root's: how likely a line that hits the root's box hits its own. `None` where the root
    /// has no area.
    pub area_share: Option<f64>,
    /// What it adds itself to the SAH cost: `C * A / A_root`, C = `C_t`, or `C_i * N` for a leaf.
    pub sah_cost: Option<f64>,
    /// Of an inner node, as [`siblings::overlap`] and [`siblings::empty_space`] say.
    pub overlap: Option<f64>,
    pub empty_space: Option<f64>,
}

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Child {
    pub node: NodeId,
    pub bounds: Aabb,
    pub references: u32,
    pub is_leaf: bool,
}

impl NodeFacts {
    /// `None` if the tree has no such node.
    pub fn of(world: &World, family: &Family, node: NodeId) -> Option<Self> {
        let tree = world.shown_tree();
        if node.0 as usize >= family.len() || family.len() != tree.node_count() {
            return None;
        }
        let bounds = family.bounds(tree, node);
        let root_area = f64::from(tree.bounds().area());
        let area_share = (root_area > 0.0).then(|| f64::from(bounds.area()) / root_area);
        let config = &world.report.config;
        let kind = kind_of(tree, node);
        let (children, shapes, weight) = match &kind {
            NodeKind::Inner(children) => {
                let children = children.iter().map(|&(child, bounds)| Child {
                    node: child,
                    bounds,
                    references: family.references(child),
                    is_leaf: tree.leaf_index(child).is_some(),
                });
                (children.collect(), Vec::new(), f64::from(config.traversal_cost))
            }
            NodeKind::Leaf(shapes) => {
                (Vec::new(), shapes.to_vec(), f64::from(config.intersection_cost) * shapes.len() as f64)
            }
        };
        let boxes: Vec<Aabb> = children.iter().map(|child: &Child| child.bounds).collect();
        Some(Self {
            node,
            bounds,
            depth: family.depth(node),
            parent: family.parent(node),
            overlap: (!boxes.is_empty()).then(|| siblings::overlap(&boxes)),
            empty_space: siblings::empty_space(&boxes).filter(|_| !boxes.is_empty()),
            children,
            shapes,
            references: family.references(node),
            area_share,
            sah_cost: area_share.map(|share| weight * share),
        })
    }

    pub fn is_leaf(&self) -> bool {
        self.children.is_empty()
    }
}

/// What lies below a node.
pub fn kind_of(tree: &Tree, node: NodeId) -> NodeKind<'_> {
    match tree.leaf_index(node) {
        Some(leaf_idx) => NodeKind::Leaf(tree.leaf_shapes(leaf_idx)),
        None => NodeKind::Inner(each_width!(tree, t => t.children(node.0).collect())),
    }
}

/// The leaves that refer to a shape, in their order.
pub fn leaves_of_shape(tree: &Tree, shape: u32) -> Vec<NodeId> {
    let refs = tree.refs();
    let leaves = (0..tree.leaf_count() as u32).filter(|&leaf_idx| {
        let leaf = tree.leaf_range(leaf_idx);
        refs[leaf.first as usize..][..leaf.count as usize].contains(&shape)
    });
    leaves.map(|leaf_idx| NodeId(tree.inner_count() as u32 + leaf_idx)).collect()
}

/// Of the leaves that refer to a shape, the one whose box holds a point of it: where several do the smallest, where none
/// does (by rounding) the nearest.
pub fn leaf_at(tree: &Tree, family: &Family, shape: u32, point: glam::Vec3) -> Option<NodeId> {
    let distance = |bounds: &Aabb| point.distance_squared(point.clamp(bounds.min, bounds.max));
    let leaves = leaves_of_shape(tree, shape).into_iter().map(|leaf| (leaf, family.bounds(tree, leaf)));
    let nearest = leaves
        .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)).then(a.area().total_cmp(&b.area())));
    nearest.map(|(leaf, _)| leaf)
}

/// The shapes of all references below a node, in no order, as often as they are referred to.
pub fn references_below(tree: &Tree, node: NodeId) -> Vec<u32> {
    below(tree, vec![node])
}

/// All shapes below some nodes, each once, ascending.
pub fn shapes_below(tree: &Tree, nodes: &[NodeId]) -> Vec<u32> {
    let mut shapes = below(tree, nodes.to_vec());
    shapes.sort_unstable();
    shapes.dedup();
    shapes
}

fn below(tree: &Tree, mut open: Vec<NodeId>) -> Vec<u32> {
    let mut shapes = Vec::new();
    while let Some(node) = open.pop() {
        match tree.leaf_index(node) {
            Some(leaf_idx) => shapes.extend_from_slice(tree.leaf_shapes(leaf_idx)),
            None => each_width!(tree, t => open.extend(t.children(node.0).map(|(child, _)| child))),
        }
    }
    shapes
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::scene::builtin;
    use crate::task::Task;

    fn world(config: &BuildConfig) -> World {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        World::build(scene, config, &Task::new()).expect("nobody cancels")
    }

    #[test]
    fn the_costs_of_all_nodes_are_the_cost_of_the_tree() {
        for &(width, layout) in &BuildConfig::NODES {
            let config = BuildConfig { width, layout, traversal_cost: 1.5, ..BuildConfig::default() };
            let world = world(&config);
            let family = Family::of(&world.tree, &Task::new()).expect("nobody cancels");
            let all = (0..family.len() as u32).map(|i| NodeFacts::of(&world, &family, NodeId(i)));
            let all: Vec<NodeFacts> = all.map(|facts| facts.expect("it is there")).collect();
            let total: f64 = all.iter().filter_map(|facts| facts.sah_cost).sum();
            let expected = world.figures.sah_cost.expect("defined").total();
            assert!((total / expected - 1.0).abs() < 1e-6, "{total} {expected}");
            for facts in &all {
                assert_eq!(facts.is_leaf(), world.tree.leaf_index(facts.node).is_some());
                assert_eq!(facts.shapes.is_empty(), !facts.is_leaf());
                let below: u32 = facts.children.iter().map(|c| c.references).sum();
                assert!(facts.is_leaf() || below == facts.references);
                for child in &facts.children {
                    assert_eq!(all[child.node.0 as usize].parent, Some(facts.node));
                    assert_eq!(all[child.node.0 as usize].bounds, child.bounds);
                }
            }
            assert_eq!(NodeFacts::of(&world, &family, NodeId(family.len() as u32)), None);
        }
    }

    #[test]
    fn a_shape_is_found_in_its_leaves() {
        let spatial = BuildConfig { builder: Builder::Spatial, ..BuildConfig::default() };
        let world = world(&spatial);
        let family = Family::of(&world.tree, &Task::new()).expect("nobody cancels");
        let mut several = 0;
        for shape in (0..world.scene.shape_count() as u32).step_by(37) {
            let leaves = leaves_of_shape(&world.tree, shape);
            several += usize::from(leaves.len() > 1);
            let center = world.scene.shape(shape).bounds().center();
            let leaf = leaf_at(&world.tree, &family, shape, center).expect("every shape is in a leaf");
            assert!(leaves.contains(&leaf));
            assert!(shapes_below(&world.tree, &[leaf]).contains(&shape));
        }
        assert!(several > 0, "spatial splits put some shapes into several leaves");
        let all = shapes_below(&world.tree, &[NodeId(0)]);
        assert!(all.into_iter().eq(0..world.scene.shape_count() as u32));
    }
}
