//! Which tree to build: the closed sets of choices, their ranges and their defaults.

use serde::{Deserialize, Serialize};

use super::simd::SimdLevel;

/// How splits are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Builder {
    Median,
    Sweep,
    #[default]
    Binned,
    Spatial,
    Lbvh,
    Ploc,
    Midpoint,
    Random,
}

impl Builder {
    pub const ALL: [Self; 8] = [
        Self::Median,
        Self::Sweep,
        Self::Binned,
        Self::Spatial,
        Self::Lbvh,
        Self::Ploc,
        Self::Midpoint,
        Self::Random,
    ];

    /// The stable name, as in `--builder NAME`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Median => "median",
            Self::Sweep => "sweep",
            Self::Binned => "binned",
            Self::Spatial => "spatial",
            Self::Lbvh => "lbvh",
            Self::Ploc => "ploc",
            Self::Midpoint => "midpoint",
            Self::Random => "random",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Median => {
                "object median: sort along the longest axis of the node's box, split at the middle"
            }
            Self::Sweep => "full sweep: every position on all three axes, least SAH split cost",
            Self::Binned => "binned SAH: the same over a few bins instead of every position",
            Self::Spatial => "binned SAH with spatial splits: large shapes are cut where boxes would overlap",
            Self::Lbvh => {
                "linear: sort along the Morton curve, split where the highest bit of the codes changes"
            }
            Self::Ploc => {
                "bottom-up: of neighbours along the Morton curve, pairs with the smallest box are merged"
            }
            Self::Midpoint => {
                "spatial middle: split halfway between the outermost centroids on their longest axis"
            }
            Self::Random => {
                "the worst case: shapes are shuffled, every node is split at the middle of its list"
            }
        }
    }

    /// Whether a shape may be in several leaves.
    pub fn duplicates(self) -> bool {
        self == Self::Spatial
    }

    /// Whether `--bins` changes the tree.
    pub fn uses_bins(self) -> bool {
        match self {
            Self::Binned | Self::Spatial => true,
            Self::Median | Self::Sweep | Self::Lbvh | Self::Ploc | Self::Midpoint | Self::Random => false,
        }
    }

    /// Whether shapes are sorted along the Morton curve, so that `--morton` changes the tree.
    pub fn uses_morton(self) -> bool {
        matches!(self, Self::Lbvh | Self::Ploc)
    }

    /// Whether splits have a price, so that `--block` and the stop rule `cost` change the tree.
    pub fn weighs_cost(self) -> bool {
        self != Self::Median
    }
}

/// How many children a node has at most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "usize", into = "usize")]
pub enum Width {
    W2,
    W4,
    #[default]
    W8,
}

impl Width {
    pub const ALL: [Self; 3] = [Self::W2, Self::W4, Self::W8];

    pub fn get(self) -> usize {
        match self {
            Self::W2 => 2,
            Self::W4 => 4,
            Self::W8 => 8,
        }
    }

    /// `2`, `4` or `8`.
    pub fn name(self) -> &'static str {
        match self {
            Self::W2 => "2",
            Self::W4 => "4",
            Self::W8 => "8",
        }
    }
}

impl From<Width> for usize {
    fn from(width: Width) -> usize {
        width.get()
    }
}

impl TryFrom<usize> for Width {
    type Error = ConfigError;

    fn try_from(width: usize) -> Result<Self, ConfigError> {
        Self::ALL.into_iter().find(|w| w.get() == width).ok_or(ConfigError::Width { width })
    }
}

/// How nodes of width 4 and 8 are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Widen {
    /// Several splits at once, directly.
    #[default]
    Split,
    /// From the finished binary tree, opening the child with the largest area first.
    Collapse,
    /// From a binary tree with one shape a leaf: the inner nodes and the leaves that have the least SAH cost together.
    Optimal,
}

impl Widen {
    pub const ALL: [Self; 3] = [Self::Split, Self::Collapse, Self::Optimal];

    pub fn name(self) -> &'static str {
        match self {
            Self::Split => "split",
            Self::Collapse => "collapse",
            Self::Optimal => "optimal",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Split => "direct: split again and again until the node is full",
            Self::Collapse => "from the binary tree, the child with the largest area opened first",
            Self::Optimal => {
                "from the binary tree, nodes and leaves of the least SAH cost; takes the place of the stop rule"
            }
        }
    }
}

/// How many references count as one in the split cost, rounded up: shapes that a leaf's test takes at once.
///
/// With 1 the split cost is `N_left * A_left + N_right * A_right`; with more each N counts the blocks that are begun, so that
/// splits fall where blocks are full, as in Embree's builders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "usize", into = "usize")]
pub enum Block {
    #[default]
    B1,
    B2,
    B4,
    B8,
}

impl Block {
    pub const ALL: [Self; 4] = [Self::B1, Self::B2, Self::B4, Self::B8];

    pub fn get(self) -> usize {
        match self {
            Self::B1 => 1,
            Self::B2 => 2,
            Self::B4 => 4,
            Self::B8 => 8,
        }
    }

    /// `1`, `2`, `4` or `8`.
    pub fn name(self) -> &'static str {
        match self {
            Self::B1 => "1",
            Self::B2 => "2",
            Self::B4 => "4",
            Self::B8 => "8",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::B1 => "the split cost counts shapes",
            Self::B2 => "the split cost counts pairs of shapes, rounded up",
            Self::B4 => "the split cost counts fours of shapes, rounded up: what this program tests at once",
            Self::B8 => "the split cost counts eights of shapes, rounded up",
        }
    }

    /// What so many references count as.
    #[inline]
    pub fn count(self, references: usize) -> usize {
        references.div_ceil(self.get())
    }
}

impl From<Block> for usize {
    fn from(block: Block) -> usize {
        block.get()
    }
}

impl TryFrom<usize> for Block {
    type Error = ConfigError;

    fn try_from(block: usize) -> Result<Self, ConfigError> {
        Self::ALL.into_iter().find(|b| b.get() == block).ok_or(ConfigError::Block { block })
    }
}

/// What makes a better binary tree of the one that was built, before it is widened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Improver {
    #[default]
    None,
    Reinsertion,
    Rotations,
}

impl Improver {
    pub const ALL: [Self; 3] = [Self::None, Self::Reinsertion, Self::Rotations];

    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinsertion => "reinsertion",
            Self::Rotations => "rotations",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::None => "the tree stays as it was built",
            Self::Reinsertion => "subtrees are moved to where the sum of all areas is least",
            Self::Rotations => "children and grandchildren change places where boxes become smaller",
        }
    }
}

/// Bits of a Morton code: a third of them an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "usize", into = "usize")]
pub enum Morton {
    Bits30,
    #[default]
    Bits63,
}

impl Morton {
    pub const ALL: [Self; 2] = [Self::Bits30, Self::Bits63];

    pub fn get(self) -> usize {
        match self {
            Self::Bits30 => 30,
            Self::Bits63 => 63,
        }
    }

    /// `30` or `63`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bits30 => "30",
            Self::Bits63 => "63",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Bits30 => "1,024 cells an axis: shapes of one cell are not told apart",
            Self::Bits63 => "2,097,152 cells an axis",
        }
    }
}

impl From<Morton> for usize {
    fn from(morton: Morton) -> usize {
        morton.get()
    }
}

impl TryFrom<usize> for Morton {
    type Error = ConfigError;

    fn try_from(bits: usize) -> Result<Self, ConfigError> {
        Self::ALL.into_iter().find(|m| m.get() == bits).ok_or(ConfigError::Morton { bits })
    }
}

/// When a node becomes a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopRule {
    /// As soon as it holds no more than `leaf` references.
    #[default]
    Limit,
    /// When it holds no more than `leaf` references and splitting would not lower the SAH cost.
    Cost,
}

impl StopRule {
    pub const ALL: [Self; 2] = [Self::Limit, Self::Cost];

    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit",
            Self::Cost => "cost",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Limit => "a leaf as soon as its shapes fit the leaf limit",
            Self::Cost => "a leaf when its shapes fit the limit and a split would not lower the SAH cost",
        }
    }
}

/// Everything that decides which tree is built over given boxes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BuildConfig {
    pub builder: Builder,
    pub width: Width,
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
    /// Most references in a leaf, in [`BuildConfig::LEAF`].
    pub leaf: usize,
    pub block: Block,
    pub improver: Improver,
    /// Most rounds of the improver, in [`BuildConfig::ROUNDS`].
    pub rounds: usize,
    /// Which share of all nodes a round of reinsertion moves, those with the largest areas; from
    /// [`BuildConfig::MIN_SHARE`] to 1.
    pub share: f32,
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
            widen: Widen::default(),
            stop: StopRule::default(),
            bins: 16,
            morton: Morton::default(),
            radius: 14,
            split_alpha: 1e-5,
            split_budget: 0.5,
            leaf: 2,
            block: Block::default(),
            improver: Improver::default(),
            rounds: 10,
            share: 0.1,
            traversal_cost: 1.0,
            intersection_cost: 1.0,
            simd: SimdLevel::default(),
        }
    }
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    #[error("width {width} is not one of 2, 4, 8")]
    Width { width: usize },
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
        let base = Self { stop: StopRule::Limit, widen: Widen::Split, improver: Improver::None, ..*self };
        [
            ("BVH", Self { builder: Builder::Median, width: Width::W2, ..base }),
            ("BVH_SAH", Self { builder: Builder::Sweep, width: Width::W2, ..base }),
            ("QBVH", Self { builder: Builder::Sweep, width: Width::W4, ..base }),
            ("BVH_BIN", Self { builder: Builder::Binned, width: Width::W2, ..base }),
            ("QBVH_BIN", Self { builder: Builder::Binned, width: Width::W4, ..base }),
        ]
    }

    /// Whether wide nodes are made from a finished binary tree that is itself built down to single shapes.
    pub fn is_optimal(&self) -> bool {
        self.widen == Widen::Optimal && self.width != Width::W2
    }

    /// Checks every range. Errors name the setting, the value and the range.
    pub fn check(&self) -> Result<(), ConfigError> {
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
