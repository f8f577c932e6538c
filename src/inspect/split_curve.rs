//! What a node's splits would cost, beside the one that was made.

use std::sync::Arc;

use crate::accel::split_costs::{SplitCandidate, SplitCosts, thinned};
use crate::accel::{Family, NodeId, NodeKind};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};
use crate::world::World;

use super::node::{kind_of, references_below};

/// Points of a curve that is drawn.
const MOST_POINTS: usize = 1200;

/// The split costs of one node, exact along every axis.
#[derive(Clone, Debug)]
pub struct SplitCurve {
    pub node: NodeId,
    pub bounds: Aabb,
    pub costs: Arc<SplitCosts>,
    /// The curve of each axis, thinned for drawing.
    pub curves: [Vec<SplitCandidate>; 3],
    /// The cheapest of all exact splits.
    pub best: Option<SplitCandidate>,
    /// `C_i * N`.
    pub leaf_cost: f32,
    /// What the node's own children cost; `None` for a leaf.
    pub made_cost: Option<f32>,
    /// The split that the node's two children stand for, if a plane between centroids tells them apart.
    pub made: Option<SplitCandidate>,
}

/// The planes between so many bins.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinnedPlanes {
    pub bins: usize,
    pub axes: [Vec<SplitCandidate>; 3],
    pub best: Option<SplitCandidate>,
}

impl SplitCurve {
    /// Of a node of the tree that is shown.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(world: &World, family: &Family, node: NodeId, task: &Task) -> Result<Self, Cancelled> {
        let tree = world.shown_tree();
        let bounds = family.bounds(tree, node);
        let scene = &world.scene;
        // Of a shape that was cut only the part in the node's box was weighed.
        let is_cut = tree.refs().len() > scene.shape_count();
        let box_of = |shape: u32| {
            let whole = scene.shape(shape).bounds();
            if is_cut && !bounds.contains(&whole) {
                scene.shape(shape).clipped_bounds(&bounds)
            } else {
                whole
            }
        };
        let references = references_below(tree, node);
        let boxes: Vec<Aabb> = references.into_iter().map(box_of).filter(|b| !b.is_empty()).collect();
        let costs = SplitCosts::of(boxes, bounds, &world.report.config, task)?;
        let children: Vec<(usize, Aabb)> = match kind_of(tree, node) {
            NodeKind::Inner(children) => {
                children.iter().map(|(child, b)| (family.references(*child) as usize, *b)).collect()
            }
            NodeKind::Leaf(_) => Vec::new(),
        };
        Ok(Self {
            node,
            bounds,
            curves: std::array::from_fn(|axis| thinned(&costs.axes[axis].exact, MOST_POINTS)),
            best: costs.best(),
            leaf_cost: costs.leaf_cost(),
            made_cost: (!children.is_empty()).then(|| costs.of_children(&children)),
            made: made(&costs, &children),
            costs: Arc::new(costs),
        })
    }

    /// The planes between bins, along all axes.
    pub fn binned(&self, bins: usize) -> BinnedPlanes {
        let axes = std::array::from_fn(|axis| self.costs.binned(axis, bins));
        BinnedPlanes { bins, axes, best: self.costs.best_binned(bins) }
    }
}

/// The exact split whose two sides are these two children.
fn made(costs: &SplitCosts, children: &[(usize, Aabb)]) -> Option<SplitCandidate> {
    let [a, b] = children else { return None };
    let is_made = |candidate: &&SplitCandidate| {
        let count = candidate.left_count;
        (count == a.0 || count == b.0) && {
            let sides = costs.sides(candidate.axis, candidate.position);
            sides == [*a, *b] || sides == [*b, *a]
        }
    };
    costs.axes.iter().flat_map(|axis| &axis.exact).find(is_made).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{BuildConfig, Builder, Width};
    use crate::scene::builtin;

    fn curves(config: BuildConfig) -> (World, Vec<SplitCurve>) {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let world = World::build(scene, &config, &Task::new()).expect("nobody cancels");
        let family = Family::of(&world.tree, &Task::new()).expect("nobody cancels");
        let nodes = (0..world.tree.inner_count() as u32).step_by(61);
        let curves = nodes.map(|i| SplitCurve::of(&world, &family, NodeId(i), &Task::new()));
        let curves = curves.map(|curve| curve.expect("nobody cancels")).collect();
        (world, curves)
    }

    #[test]
    fn the_full_sweep_takes_the_least_of_the_curve() {
        let config = BuildConfig { builder: Builder::Sweep, width: Width::W2, ..BuildConfig::default() };
        for curve in curves(config).1 {
            let (best, made) = (curve.best.expect("a split"), curve.made_cost.expect("an inner node"));
            assert!((made / best.cost - 1.0).abs() < 1e-4, "{:?}: {made} {best:?}", curve.node);
            let found = curve.made.expect("a plane tells its children apart");
            assert!((found.cost / best.cost - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn bins_take_the_least_of_their_planes() {
        let config = BuildConfig { bins: 8, width: Width::W2, ..BuildConfig::default() };
        for curve in curves(config).1 {
            let planes = curve.binned(8);
            let (best, made) = (planes.best.expect("a plane"), curve.made_cost.expect("an inner node"));
            assert!((made / best.cost - 1.0).abs() < 1e-4, "{:?}: {made} {best:?}", curve.node);
            assert!(curve.best.expect("a split").cost <= best.cost * 1.0001);
        }
    }

    #[test]
    fn wide_and_cut_nodes_have_curves_too() {
        let wide = BuildConfig::default();
        let cut = BuildConfig { builder: Builder::Spatial, width: Width::W2, ..BuildConfig::default() };
        for config in [wide, cut] {
            for curve in curves(config).1 {
                assert!(curve.made_cost.is_some_and(f32::is_finite));
                assert!(curve.costs.len() > 1 && curve.leaf_cost > 1.0);
                assert!(curve.curves.iter().all(|c| c.len() <= MOST_POINTS + 2));
            }
        }
    }
}
