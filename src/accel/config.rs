//! Which tree to build: the settings together, their ranges and their defaults.

use serde::{Deserialize, Serialize};

use super::compressed::CompressedBvh;
use super::simd::SimdLevel;

pub use super::choices::{Block, Builder, Improver, Layout, Morton, StopRule, Update, Widen, Width};

/// Everything that decides which tree is built over given boxes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BuildConfig {
    pub builder: Builder,
    pub width: Width,
    pub layout: Layout,
    pub widen: Widen,
    pub stop: StopRule,
    /// Number of bins an axis, in [`BuildConfig::BINS`].
    pub bins: usize,
    /// Of the builders `lbvh` and `ploc`.
    pub morton: Morton,
    /// Neighbours on either side along the Morton curve among which `ploc` looks for the nearest, in
    /// [`BuildConfig::RADIUS`].
    pub radius: usize,
    /// The share of the root's area from which on an overlap of boxes makes `spatial` try to cut shapes, from 0 to 1: the
    /// paper's alpha.
    pub split_alpha: f32,
    /// The most references that cuts of `spatial` may add, as a share of the shapes; from 0 to
    /// [`BuildConfig::MAX_BUDGET`].
    pub split_budget: f32,
    /// The most references that cutting large shapes before the build may add, as a share of the shapes; from 0 (nothing is
    /// cut) to [`BuildConfig::MAX_BUDGET`].
    pub pre_split: f32,
    /// Most references in a leaf, in [`BuildConfig::LEAF`].
    pub leaf: usize,
    pub block: Block,
    pub improver: Improver,
    /// Most rounds of the improver, in [`BuildConfig::ROUNDS`].
    pub rounds: usize,
    /// Which share of all nodes a round of reinsertion moves, those with the largest areas; from
    /// [`BuildConfig::MIN_SHARE`] to 1.
    pub share: f32,
    /// What becomes of the tree when the scene moves. Boxes alone know nothing of time: a world heeds it.
    pub update: Update,
    /// C_t of the SAH cost: the price of visiting a node.
    pub traversal_cost: f32,
    /// C_i of the SAH cost: the price of testing a shape.
    pub intersection_cost: f32,
    /// What the tree is built and its rays are traced with. Changes no tree, no hit and no count.
    pub simd: SimdLevel,
}

impl Default for BuildConfig {
    fn default() -> Self {
        Self {
            builder: Builder::default(),
            width: Width::default(),
            layout: Layout::default(),
            widen: Widen::default(),
            stop: StopRule::default(),
            bins: 16,
            morton: Morton::default(),
            radius: 14,
            split_alpha: 1e-5,
            split_budget: 0.5,
            pre_split: 0.0,
            leaf: 2,
            block: Block::default(),
            improver: Improver::default(),
            rounds: 10,
            share: 0.1,
            update: Update::default(),
            traversal_cost: 1.0,
            intersection_cost: 1.0,
            simd: SimdLevel::default(),
        }
    }
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    #[error(
        "the builder {name} comes with other libraries: build the program with them, \
         cargo run --release --features peers"
    )]
    Peer { name: &'static str },
    #[error("width {width} is not one of 2, 4, 8")]
    Width { width: usize },
    #[error("layout {layout} is made for width 8, not for width {width}")]
    Layout { layout: &'static str, width: usize },
    #[error("block {block} is not one of 1, 2, 4, 8")]
    Block { block: usize },
    #[error("morton {bits} is not one of 30, 63")]
    Morton { bits: usize },
    #[error("radius {radius} is outside 1 to 128")]
    Radius { radius: usize },
    #[error("split-alpha {alpha} is not a number from 0 to 1")]
    Alpha { alpha: f32 },
    #[error("split-budget {budget} is not a number from 0 to 4")]
    Budget { budget: f32 },
    #[error("pre-split {share} is not a number from 0 to 4")]
    PreSplit { share: f32 },
    #[error("bins {bins} is outside 2 to 256")]
    Bins { bins: usize },
    #[error("leaf {leaf} is outside 1 to 64")]
    Leaf { leaf: usize },
    #[error("rounds {rounds} is outside 1 to 1000")]
    Rounds { rounds: usize },
    #[error("share {share} is not a number from 0.000001 to 1")]
    Share { share: f32 },
    #[error("{name} {value} is not a number above 0 and up to 1000")]
    Cost { name: &'static str, value: f32 },
    #[error("this processor has no {name} instructions; it has {has}")]
    Simd { name: &'static str, has: String },
}

impl BuildConfig {
    /// The layouts that nodes of each width can have.
    pub const NODES: [(Width, Layout); 4] = [
        (Width::W2, Layout::Full),
        (Width::W4, Layout::Full),
        (Width::W8, Layout::Full),
        (Width::W8, Layout::Compressed),
    ];
    pub const BINS: std::ops::RangeInclusive<usize> = 2..=256;
    pub const LEAF: std::ops::RangeInclusive<usize> = 1..=64;
    pub const RADIUS: std::ops::RangeInclusive<usize> = 1..=128;
    pub const MAX_BUDGET: f32 = 4.0;
    pub const ROUNDS: std::ops::RangeInclusive<usize> = 1..=1000;
    /// The least share of the nodes that a round may move.
    pub const MIN_SHARE: f32 = 1e-6;
    /// No leaf lies deeper; so traversal has a fixed stack.
    pub const MAX_DEPTH: usize = 64;
    /// Largest settable traversal or intersection cost.
    pub const MAX_COST: f32 = 1000.0;

    /// The five trees of the first table, by name, at this leaf limit, number of bins and these costs.
    pub fn five_trees(&self) -> [(&'static str, Self); 5] {
        let base = Self {
            stop: StopRule::Limit,
            widen: Widen::Split,
            improver: Improver::None,
            pre_split: 0.0,
            layout: Layout::Full,
            ..*self
        };
        [
            ("BVH", Self { builder: Builder::Median, width: Width::W2, ..base }),
            ("BVH_SAH", Self { builder: Builder::Sweep, width: Width::W2, ..base }),
            ("QBVH", Self { builder: Builder::Sweep, width: Width::W4, ..base }),
            ("BVH_BIN", Self { builder: Builder::Binned, width: Width::W2, ..base }),
            ("QBVH_BIN", Self { builder: Builder::Binned, width: Width::W4, ..base }),
        ]
    }

    /// [`BuildConfig::leaf`], or fewer where the layout has no room for them.
    pub fn leaf_limit(&self) -> usize {
        match self.layout {
            Layout::Full => self.leaf,
            Layout::Compressed => self.leaf.min(CompressedBvh::LEAF),
        }
    }

    /// Whether a shape may be in several leaves.
    pub fn duplicates(&self) -> bool {
        self.builder.cuts_shapes() || self.pre_split > 0.0
    }

    /// Whether wide nodes are made from a finished binary tree that is itself built down to single shapes.
    pub fn is_optimal(&self) -> bool {
        self.widen == Widen::Optimal && self.width != Width::W2
    }

    /// Checks every range. Errors name the setting, the value and the range.
    pub fn check(&self) -> Result<(), ConfigError> {
        if !self.builder.is_available() {
            return Err(ConfigError::Peer { name: self.builder.name() });
        }
        if !Self::NODES.contains(&(self.width, self.layout)) {
            return Err(ConfigError::Layout { layout: self.layout.name(), width: self.width.get() });
        }
        if !Self::BINS.contains(&self.bins) {
            return Err(ConfigError::Bins { bins: self.bins });
        }
        if !Self::LEAF.contains(&self.leaf) {
            return Err(ConfigError::Leaf { leaf: self.leaf });
        }
        if !Self::RADIUS.contains(&self.radius) {
            return Err(ConfigError::Radius { radius: self.radius });
        }
        if !(0.0..=1.0).contains(&self.split_alpha) {
            return Err(ConfigError::Alpha { alpha: self.split_alpha });
        }
        if !(0.0..=Self::MAX_BUDGET).contains(&self.split_budget) {
            return Err(ConfigError::Budget { budget: self.split_budget });
        }
        if !(0.0..=Self::MAX_BUDGET).contains(&self.pre_split) {
            return Err(ConfigError::PreSplit { share: self.pre_split });
        }
        if !Self::ROUNDS.contains(&self.rounds) {
            return Err(ConfigError::Rounds { rounds: self.rounds });
        }
        if !(Self::MIN_SHARE..=1.0).contains(&self.share) {
            return Err(ConfigError::Share { share: self.share });
        }
        for (name, value) in
            [("traversal-cost", self.traversal_cost), ("intersection-cost", self.intersection_cost)]
        {
            if !(value > 0.0 && value <= Self::MAX_COST) {
                return Err(ConfigError::Cost { name, value });
            }
        }
        if !self.simd.is_available() {
            let has: Vec<_> =
                SimdLevel::ALL[1..].iter().filter(|s| s.is_available()).map(|s| s.name()).collect();
            return Err(ConfigError::Simd { name: self.simd.name(), has: has.join(", ") });
        }
        Ok(())
    }
}
