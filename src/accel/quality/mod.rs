//! What the boxes alone tell of a tree.

pub mod nodes;
pub mod siblings;

use crate::each_width;
use crate::geometry::Aabb;

use siblings::{empty_space, overlap};

use super::bvh2::Bvh2;
use super::tree::{ChildRef, Nodes, Tree};

/// Children of the widest node.
const MOST_CHILDREN: usize = 16;

/// Shapes of a leaf that are tested at once.
pub const FILL_LANES: usize = 4;

/// The SAH cost in parts: `cost = (C_t * sum A_inner + C_i * sum N_leaf * A_leaf) / A_root`
/// (Aila, Karras, Laine, "On Quality Metrics of Bounding Volume Hierarchies", 2013, eq. 1).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SahCost {
    /// `C_t * sum A_inner / A_root`.
    pub inner: f64,
    /// `C_i * sum N_leaf * A_leaf / A_root`.
    pub leaf: f64,
}

impl SahCost {
    pub fn total(&self) -> f64 {
        self.inner + self.leaf
    }
}

/// One level of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct DepthLevel {
    pub inner_count: usize,
    pub leaf_count: usize,
    /// References in the leaves of this level.
    pub reference_count: usize,
    /// This level's part of [`SahCost::inner`] and [`SahCost::leaf`].
    pub sah_inner: f64,
    pub sah_leaf: f64,
}

/// Everything that the boxes alone tell.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct TreeFigures {
    pub node_count: usize,
    pub inner_count: usize,
    pub leaf_count: usize,
    pub reference_count: usize,
    /// Deepest leaf; the root is at depth 0. `None` for an empty tree, as is every mean of nothing.
    pub depth_max: Option<u32>,
    /// Mean over leaves.
    pub depth_mean: Option<f64>,
    /// `leaf_sizes[n]`: the number of leaves with n references.
    pub leaf_sizes: Vec<usize>,
    /// `None` where the root's area is zero.
    pub sah_cost: Option<SahCost>,
    /// Index = depth.
    pub levels: Vec<DepthLevel>,
    /// Sum over inner nodes of sibling overlap, `sum over pairs of area(box_i ∩ box_j) / area(parent)`.
    pub overlap: f64,
    /// Sum over inner nodes of empty space, `1 - volume of the union of the children's boxes / own volume`.
    pub empty_space: f64,
    /// The same as a mean over the inner nodes that have a volume; `None` if none has.
    pub empty_space_mean: Option<f64>,
    /// The share of child slots of all inner nodes that are used; `None` without inner nodes.
    pub slot_fill: Option<f64>,
    /// The share of lanes of all leaves with a reference, where [`FILL_LANES`] are tested at once; `None` without leaves.
    pub leaf_fill: Option<f64>,
    pub bytes: usize,
}

impl TreeFigures {
    /// Measures a tree under the two costs of the SAH.
    pub fn measure(tree: &Tree, traversal_cost: f32, intersection_cost: f32) -> Self {
        let costs = Costs {
            traversal: traversal_cost.into(),
            intersection: intersection_cost.into(),
            root_area: tree.bounds().area().into(),
        };
        let sums = each_width!(tree, t => Sums::over(t, &costs));
        let (inner_count, leaf_count) = (tree.inner_count(), tree.leaf_count());
        let sah_cost = (costs.root_area > 0.0).then(|| SahCost {
            inner: sums.levels.iter().map(|l| l.sah_inner).sum(),
            leaf: sums.levels.iter().map(|l| l.sah_leaf).sum(),
        });
        Self {
            node_count: tree.node_count(),
            inner_count,
            leaf_count,
            reference_count: tree.refs().len(),
            depth_max: tree.depth_max(),
            depth_mean: (leaf_count > 0).then(|| sums.depth as f64 / leaf_count as f64),
            sah_cost,
            levels: sums.levels,
            overlap: sums.overlap,
            empty_space: sums.empty_space,
            empty_space_mean: (sums.spacious > 0).then(|| sums.empty_space / sums.spacious as f64),
            slot_fill: (inner_count > 0).then(|| {
                let slots = inner_count * tree.width();
                (tree.node_count() - 1) as f64 / slots as f64
            }),
            leaf_fill: leaf_fill(&sums.leaf_sizes),
            leaf_sizes: sums.leaf_sizes,
            bytes: tree.bytes(),
        }
    }
}

/// The share of lanes with a reference; `sizes[n]` leaves have n references.
fn leaf_fill(sizes: &[usize]) -> Option<f64> {
    let sum =
        |of: fn(usize) -> usize| sizes.iter().enumerate().map(|(n, count)| of(n) * count).sum::<usize>();
    let lanes = sum(|n| n.div_ceil(FILL_LANES) * FILL_LANES);
    (lanes > 0).then(|| sum(|n| n) as f64 / lanes as f64)
}

struct Costs {
    traversal: f64,
    intersection: f64,
    root_area: f64,
}

/// What is added up over all nodes.
#[derive(Default)]
struct Sums {
    levels: Vec<DepthLevel>,
    leaf_sizes: Vec<usize>,
    /// Over leaves.
    depth: u64,
    overlap: f64,
    empty_space: f64,
    /// Inner nodes with a volume.
    spacious: usize,
}

impl Sums {
    /// One pass over the inner nodes, which lie behind their parents: each adds its children.
    fn over<T: Nodes>(tree: &T, costs: &Costs) -> Self {
        let mut sums = Self::default();
        let mut depths = vec![0_u32; tree.inner_count()];
        sums.add(tree, tree.root(), &tree.bounds(), 0, costs);
        for node_idx in 0..tree.inner_count() {
            let depth = depths[node_idx] + 1;
            let mut boxes = [Aabb::EMPTY; MOST_CHILDREN];
            let mut count = 0;
            for slot in 0..T::WIDTH {
                let (child, bounds) = tree.slot(node_idx as u32, slot);
                if child.is_empty() {
                    break;
                }
                boxes[count] = bounds;
                sums.add(tree, child, &boxes[count], depth, costs);
                if let Some(child_idx) = child.as_inner() {
                    depths[child_idx as usize] = depth;
                }
                count += 1;
            }
            sums.overlap += overlap(&boxes[..count]);
            if let Some(empty) = empty_space(&boxes[..count]) {
                sums.empty_space += empty;
                sums.spacious += 1;
            }
        }
        sums
    }

    #[inline]
    fn add<T: Nodes>(&mut self, tree: &T, node: ChildRef, bounds: &Aabb, depth: u32, costs: &Costs) {
        if node.is_empty() {
            return;
        }
        if self.levels.len() <= depth as usize {
            self.levels.resize(depth as usize + 1, DepthLevel::default());
        }
        let level = &mut self.levels[depth as usize];
        let area = f64::from(bounds.area());
        let per_area = |cost: f64| if costs.root_area > 0.0 { cost / costs.root_area } else { 0.0 };
        if let Some(leaf_idx) = node.as_leaf() {
            let size = tree.leaf_range(leaf_idx).count as usize;
            level.leaf_count += 1;
            level.reference_count += size;
            level.sah_leaf += per_area(costs.intersection * size as f64 * area);
            self.depth += u64::from(depth);
            if self.leaf_sizes.len() <= size {
                self.leaf_sizes.resize(size + 1, 0);
            }
            self.leaf_sizes[size] += 1;
        } else {
            level.inner_count += 1;
            level.sah_inner += per_area(costs.traversal * area);
        }
    }
}

/// The SAH cost of a binary tree that is still being made; `None` where the root's area is zero.
pub fn binary_sah_cost(bvh: &Bvh2, traversal_cost: f32, intersection_cost: f32) -> Option<f64> {
    let root_area = f64::from(bvh.nodes.first()?.bounds.area());
    let costs = bvh.nodes.iter().map(|node| {
        let weight = match node.count {
            0 => f64::from(traversal_cost),
            size => f64::from(intersection_cost) * f64::from(size),
        };
        weight * f64::from(node.bounds.area())
    });
    (root_area > 0.0).then(|| costs.sum::<f64>() / root_area)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, Width, build};
    use crate::task::Task;

    /// Unit cubes at x = 0, 2, 4, 6.
    fn row_of_cubes() -> Vec<Aabb> {
        (0..4).map(|i| Vec3::X * 2.0 * i as f32).map(|min| Aabb::new(min, min + Vec3::ONE)).collect()
    }

    fn figures(config: &BuildConfig) -> TreeFigures {
        let (tree, _) = build(&row_of_cubes(), config, &Task::new()).expect("not cancelled");
        TreeFigures::measure(&tree, 1.0, 1.0)
    }

    #[test]
    fn the_sah_cost_of_four_cubes_is_that_done_by_hand() {
        let f = figures(&BuildConfig { leaf: 1, width: Width::W2, ..BuildConfig::default() });
        // Root 7 x 1 x 1: area 30. Two inner nodes 3 x 1 x 1: area 14. Four leaves of area 6.
        let sah = f.sah_cost.expect("the root has an area");
        assert!((sah.inner - (30.0 + 2.0 * 14.0) / 30.0).abs() < 1e-9);
        assert!((sah.leaf - 4.0 * 6.0 / 30.0).abs() < 1e-9);
        assert_eq!((f.node_count, f.leaf_count, f.depth_max, f.depth_mean), (7, 4, Some(2), Some(2.0)));
        assert_eq!(f.leaf_sizes, [0, 4]);
        assert_eq!((f.overlap, f.slot_fill, f.leaf_fill), (0.0, Some(1.0), Some(0.25)));
        // Of the root three of seven units are between the halves, a third of which is empty.
        let empty = 1.0 / 7.0 + 2.0 / 3.0;
        assert!((f.empty_space - empty).abs() < 1e-9 && f.empty_space_mean == Some(f.empty_space / 3.0));
    }

    #[test]
    fn a_wide_node_costs_one_traversal() {
        let f = figures(&BuildConfig { leaf: 1, width: Width::W4, ..BuildConfig::default() });
        let sah = f.sah_cost.expect("the root has an area");
        assert!((sah.inner - 1.0).abs() < 1e-9 && (sah.leaf - 0.8).abs() < 1e-9);
        assert_eq!((f.node_count, f.depth_max), (5, Some(1)));
    }

    #[test]
    fn a_binary_tree_costs_the_same_before_and_after_it_is_finished() {
        let config = BuildConfig { width: Width::W2, leaf: 1, ..BuildConfig::default() };
        let (tree, _) = build(&row_of_cubes(), &config, &Task::new()).expect("not cancelled");
        let finished = TreeFigures::measure(&tree, 1.5, 0.5).sah_cost.expect("the root has an area").total();
        let Tree::W2(tree) = tree else { panic!("a binary tree") };
        let cost = binary_sah_cost(&Bvh2::from_wide(&tree), 1.5, 0.5).expect("the root has an area");
        assert!((cost - finished).abs() < 1e-9, "{cost} {finished}");
        assert_eq!(binary_sah_cost(&Bvh2::default(), 1.0, 1.0), None);
    }

    #[test]
    fn what_is_undefined_is_none() {
        let (tree, _) = build(&[], &BuildConfig::default(), &Task::new()).expect("not cancelled");
        let f = TreeFigures::measure(&tree, 1.0, 1.0);
        assert_eq!((f.node_count, f.sah_cost, f.depth_max, f.depth_mean), (0, None, None, None));
        let point = [Aabb::new(Vec3::ONE, Vec3::ONE)];
        let (tree, _) = build(&point, &BuildConfig::default(), &Task::new()).expect("not cancelled");
        let f = TreeFigures::measure(&tree, 1.0, 1.0);
        assert_eq!((f.node_count, f.sah_cost, f.depth_max), (1, None, Some(0)));
    }
}
