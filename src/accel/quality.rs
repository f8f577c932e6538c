//! What the boxes alone tell of a tree.

use super::tree::Tree;

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
        let _ = (tree, traversal_cost, intersection_cost);
        todo!()
    }
}
