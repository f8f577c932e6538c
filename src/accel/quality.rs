//! What the boxes alone tell of a tree.

use crate::each_width;
use crate::geometry::Aabb;

use super::bvh2::Bvh2;
use super::tree::{ChildRef, Tree, Visit, WideBvh};

/// Children of the widest node.
const MOST_CHILDREN: usize = 16;

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
    /// Sums over inner nodes of sibling overlap, `sum over pairs of area(box_i ∩ box_j) / area(parent)`.
    pub overlap: f64,
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
        let leaf_count = tree.leaf_count();
        let sah_cost = (costs.root_area > 0.0).then(|| SahCost {
            inner: sums.levels.iter().map(|l| l.sah_inner).sum(),
            leaf: sums.levels.iter().map(|l| l.sah_leaf).sum(),
        });
        Self {
            node_count: tree.node_count(),
            inner_count: tree.inner_count(),
            leaf_count,
            reference_count: tree.refs().len(),
            depth_max: tree.depth_max(),
            depth_mean: (leaf_count > 0).then(|| sums.depth as f64 / leaf_count as f64),
            leaf_sizes: sums.leaf_sizes,
            sah_cost,
            levels: sums.levels,
            overlap: sums.overlap,
            bytes: tree.bytes(),
        }
    }
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
}

impl Sums {
    /// One pass over the inner nodes, which lie behind their parents: each adds its children.
    fn over<const N: usize>(tree: &WideBvh<N>, costs: &Costs) -> Self {
        let mut sums = Self::default();
        let mut depths = vec![0_u32; tree.nodes.len()];
        sums.add(tree, tree.root, &tree.bounds, 0, costs);
        for (node_idx, node) in tree.nodes.iter().enumerate() {
            let depth = depths[node_idx] + 1;
            let mut boxes = [Aabb::EMPTY; N];
            let mut count = 0;
            for &child in node.children.iter().filter(|child| !child.is_empty()) {
                boxes[count] = node.child_bounds(count);
                sums.add(tree, child, &boxes[count], depth, costs);
                if let Some(child_idx) = child.as_inner() {
                    depths[child_idx as usize] = depth;
                }
                count += 1;
            }
            sums.overlap += overlap(&boxes[..count]);
        }
        sums
    }

    #[inline]
    fn add<const N: usize>(
        &mut self,
        tree: &WideBvh<N>,
        node: ChildRef,
        bounds: &Aabb,
        depth: u32,
        costs: &Costs,
    ) {
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
            let size = tree.leaves[leaf_idx as usize].count as usize;
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

/// Of an inner node: the sum over pairs of its children of `area(box_i ∩ box_j) / area(its own box)`; 0 where the own
/// area is.
pub fn sibling_overlap(tree: &Tree, node_idx: u32) -> f64 {
    each_width!(tree, t => {
        let mut boxes = [Aabb::EMPTY; MOST_CHILDREN];
        let mut count = 0;
        for (_, bounds) in t.children(node_idx) {
            boxes[count] = bounds;
            count += 1;
        }
        overlap(&boxes[..count])
    })
}

fn overlap(siblings: &[Aabb]) -> f64 {
    let own = siblings.iter().fold(Aabb::EMPTY, |all, b| all.union(*b)).area();
    let mut shared = 0.0;
    for (i, a) in siblings.iter().enumerate() {
        for b in &siblings[i + 1..] {
            let common = a.intersection(*b);
            if !common.is_empty() {
                shared += f64::from(common.area());
            }
        }
    }
    if own > 0.0 { shared / f64::from(own) } else { 0.0 }
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

/// Every node's own share of the SAH cost, by node id: `C * A / A_root / cost`, C = `C_t` for an inner node, `C_i * N`
/// for a leaf. The shares add up to 1; all are 0 where the cost is undefined or 0.
pub fn sah_shares(tree: &Tree, traversal_cost: f32, intersection_cost: f32) -> Vec<f32> {
    let mut costs = vec![0.0_f64; tree.node_count()];
    tree.walk_nodes(|Visit { id, bounds, .. }| {
        let weight = match tree.leaf_index(id) {
            Some(leaf_idx) => {
                f64::from(intersection_cost) * f64::from(tree.leaves()[leaf_idx as usize].count)
            }
            None => f64::from(traversal_cost),
        };
        costs[id.0 as usize] = weight * f64::from(bounds.area());
        true
    });
    let total: f64 = costs.iter().sum();
    costs.into_iter().map(|cost| if total > 0.0 { (cost / total) as f32 } else { 0.0 }).collect()
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
        assert_eq!(f.overlap, 0.0);
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
    fn shares_add_up_to_one() {
        let (tree, _) = build(&row_of_cubes(), &BuildConfig::default(), &Task::new()).expect("not cancelled");
        let shares = sah_shares(&tree, 1.0, 2.0);
        assert_eq!(shares.len(), tree.node_count());
        assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
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
