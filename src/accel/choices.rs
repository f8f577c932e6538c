//! Which tree to build: the closed sets of choices.

use serde::{Deserialize, Serialize};

use super::config::ConfigError;

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
    ObvhsFast,
    ObvhsMedium,
    ObvhsVerySlow,
    Bvh,
    Parry3d,
}

impl Builder {
    /// Those that can be used: this program's own, and with the cargo feature `peers` those of other libraries.
    pub const ALL: [Self; Self::COUNT] = {
        let mut all = [Self::Median; Self::COUNT];
        let mut i = 0;
        while i < Self::COUNT {
            all[i] = Self::EVERY[i];
            i += 1;
        }
        all
    };

    const COUNT: usize = if cfg!(feature = "peers") { 13 } else { 8 };

    /// This program's own first, then the [`Builder::is_peer`] ones.
    const EVERY: [Self; 13] = [
        Self::Median,
        Self::Sweep,
        Self::Binned,
        Self::Spatial,
        Self::Lbvh,
        Self::Ploc,
        Self::Midpoint,
        Self::Random,
        Self::ObvhsFast,
        Self::ObvhsMedium,
        Self::ObvhsVerySlow,
        Self::Bvh,
        Self::Parry3d,
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
            Self::ObvhsFast => "obvhs-fast",
            Self::ObvhsMedium => "obvhs-medium",
            Self::ObvhsVerySlow => "obvhs-very-slow",
            Self::Bvh => "bvh",
            Self::Parry3d => "parry3d",
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
            Self::ObvhsFast => "the crate obvhs, preset fast: ploc and a little reinsertion; its own leaves",
            Self::ObvhsMedium => "the crate obvhs, preset medium: ploc and reinsertion; its own leaves",
            Self::ObvhsVerySlow => {
                "the crate obvhs, preset very slow: triangles split first, ploc, much reinsertion; its own leaves"
            }
            Self::Bvh => "the crate bvh: binned SAH with six bins; a shape a leaf",
            Self::Parry3d => "the crate parry3d: binned SAH; a shape a leaf",
        }
    }

    /// Whether it cuts shapes, so that one may be in several leaves.
    pub fn cuts_shapes(self) -> bool {
        matches!(self, Self::Spatial | Self::ObvhsVerySlow)
    }

    /// Whether another library builds it: leaf limit, stop rule and costs are then that library's own.
    pub fn is_peer(self) -> bool {
        match self {
            Self::ObvhsFast | Self::ObvhsMedium | Self::ObvhsVerySlow | Self::Bvh | Self::Parry3d => true,
            Self::Median
            | Self::Sweep
            | Self::Binned
            | Self::Spatial
            | Self::Lbvh
            | Self::Ploc
            | Self::Midpoint
            | Self::Random => false,
        }
    }

    /// Whether this build of the program has it.
    pub fn is_available(self) -> bool {
        !self.is_peer() || cfg!(feature = "peers")
    }

    /// Whether `--bins` changes the tree.
    pub fn uses_bins(self) -> bool {
        matches!(self, Self::Binned | Self::Spatial)
    }

    /// Whether shapes are sorted along the Morton curve, so that `--morton` changes the tree.
    pub fn uses_morton(self) -> bool {
        matches!(self, Self::Lbvh | Self::Ploc)
    }

    /// Whether splits have a price, so that `--block` and the stop rule `cost` change the tree.
    pub fn weighs_cost(self) -> bool {
        self != Self::Median && !self.is_peer()
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

/// How nodes lie in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    #[default]
    Full,
    /// Of width 8 only, with at most [`CompressedBvh::LEAF`](super::compressed::CompressedBvh::LEAF) shapes a leaf.
    Compressed,
}

impl Layout {
    pub const ALL: [Self; 2] = [Self::Full, Self::Compressed];

    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Compressed => "compressed",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Full => "the sides of boxes are floats: a node of width 8 takes 256 bytes",
            Self::Compressed => {
                "the sides of boxes are bytes on a grid: 80 bytes a node; width 8, at most 3 shapes a leaf"
            }
        }
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

/// What becomes of a tree when the scene moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Update {
    #[default]
    Rebuild,
    Refit,
}

impl Update {
    pub const ALL: [Self; 2] = [Self::Rebuild, Self::Refit];

    pub fn name(self) -> &'static str {
        match self {
            Self::Rebuild => "rebuild",
            Self::Refit => "refit",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Rebuild => "every moment of a moving scene gets a tree of its own",
            Self::Refit => "the tree of t = 0 stays, and its boxes are fitted to where the shapes have moved",
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
