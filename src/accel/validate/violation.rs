//! The ways in which a tree can be wrong, or merely odd.

use std::fmt;

use crate::accel::config::BuildConfig;
use crate::accel::tree::{ChildRef, NodeId};

/// A node or a leaf, by the index that its tree or file gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum At {
    Node(u32),
    Leaf(u32),
}

impl At {
    /// What a child slot points at; `None` for an empty one.
    pub fn of(child: ChildRef) -> Option<Self> {
        child.as_inner().map(Self::Node).or(child.as_leaf().map(Self::Leaf))
    }

    /// The id in a tree with so many inner nodes.
    pub fn node_id(self, inner_count: usize) -> NodeId {
        match self {
            Self::Node(node_idx) => NodeId(node_idx),
            Self::Leaf(leaf_idx) => NodeId(inner_count as u32 + leaf_idx),
        }
    }
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(node_idx) => write!(f, "node {node_idx}"),
            Self::Leaf(leaf_idx) => write!(f, "leaf {leaf_idx}"),
        }
    }
}

/// What lies in a node and reaches out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    Child(At),
    Shape(u32),
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Child(at) => write!(f, "what lies in {at}"),
            Self::Shape(shape) => write!(f, "shape {shape}"),
        }
    }
}

/// One way in which a tree is wrong or odd, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Violation {
    #[error("{at}, slot {slot}: the child {value} is out of range")]
    BadLink { at: At, slot: u32, value: i64 },
    #[error("{at} is reached a second time, from {parent}: a cycle, or a child of two nodes")]
    ReachedTwice { at: At, parent: At },
    #[error("{at}: its shapes lie outside the file's list of them")]
    BadLeaf { at: At },
    #[error("{at}: shape {shape} does not exist")]
    ShapeUnknown { at: At, shape: u32 },
    #[error("shape {shape} is in no leaf that can be reached")]
    ShapeMissing { shape: u32 },
    #[error("{at}: its box has a side that is no finite number")]
    NotFinite { at: At },
    #[error("{at}: {content} reaches out of its box by {by}")]
    NotContained { at: At, content: Content, by: f32 },
    #[error("the leaves with parts of shape {shape} do not reach all sides of its box")]
    NotCovered { shape: u32 },
    #[error("{at}: the box of {child} reaches out of its box by {by}, what lies in it does not")]
    ChildSticksOut { at: At, child: At, by: f32 },
    #[error("{at}: its box is larger than what lies in it")]
    NotTight { at: At },
    #[error("{at}: shape {shape} is there {count} times")]
    ShapeRepeated { at: At, shape: u32, count: usize },
    #[error("{at} holds nothing")]
    Empty { at: At },
    #[error("{at} is at depth {depth}, deeper than {}", BuildConfig::MAX_DEPTH)]
    TooDeep { at: At, depth: u32 },
    #[error("{at} is reached from nowhere")]
    Unreachable { at: At },
}

/// The kinds of [`Violation`]s: first the faults, with which a tree would lose hits or not end, then what is only odd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ViolationKind {
    BadLink,
    ReachedTwice,
    BadLeaf,
    ShapeUnknown,
    ShapeMissing,
    NotFinite,
    NotContained,
    NotCovered,
    ChildSticksOut,
    NotTight,
    ShapeRepeated,
    Empty,
    TooDeep,
    Unreachable,
}

impl ViolationKind {
    pub const ALL: [Self; 14] = [
        Self::BadLink,
        Self::ReachedTwice,
        Self::BadLeaf,
        Self::ShapeUnknown,
        Self::ShapeMissing,
        Self::NotFinite,
        Self::NotContained,
        Self::NotCovered,
        Self::ChildSticksOut,
        Self::NotTight,
        Self::ShapeRepeated,
        Self::Empty,
        Self::TooDeep,
        Self::Unreachable,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::BadLink => "bad-link",
            Self::ReachedTwice => "reached-twice",
            Self::BadLeaf => "bad-leaf",
            Self::ShapeUnknown => "shape-unknown",
            Self::ShapeMissing => "shape-missing",
            Self::NotFinite => "not-finite",
            Self::NotContained => "not-contained",
            Self::NotCovered => "not-covered",
            Self::ChildSticksOut => "child-sticks-out",
            Self::NotTight => "not-tight",
            Self::ShapeRepeated => "shape-repeated",
            Self::Empty => "empty",
            Self::TooDeep => "too-deep",
            Self::Unreachable => "unreachable",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::BadLink => "a child that does not exist",
            Self::ReachedTwice => "a cycle, or a child of two nodes",
            Self::BadLeaf => "a leaf whose shapes lie outside the list",
            Self::ShapeUnknown => "a shape that does not exist",
            Self::ShapeMissing => "a shape in no leaf: no ray finds it",
            Self::NotFinite => "a box with a side that is NaN or infinite",
            Self::NotContained => "shapes that reach out of a box above them: rays miss them",
            Self::NotCovered => "a shape of several leaves whose parts do not make it up",
            Self::ChildSticksOut => {
                "a child's box that is larger than its parent's; its shapes lie inside both"
            }
            Self::NotTight => "a box that is larger than needed: rays enter it in vain",
            Self::ShapeRepeated => "a shape more than once in the same leaf",
            Self::Empty => "a node without children, or a leaf without shapes",
            Self::TooDeep => "deeper than the trees of this program: traced with a larger stack",
            Self::Unreachable => "a node or leaf that nothing leads to: left out",
        }
    }

    /// Whether a tree with it gives wrong answers or none. The others are legal in a tree from elsewhere.
    pub fn is_fault(self) -> bool {
        match self {
            Self::BadLink
            | Self::ReachedTwice
            | Self::BadLeaf
            | Self::ShapeUnknown
            | Self::ShapeMissing
            | Self::NotFinite
            | Self::NotContained
            | Self::NotCovered => true,
            Self::ChildSticksOut
            | Self::NotTight
            | Self::ShapeRepeated
            | Self::Empty
            | Self::TooDeep
            | Self::Unreachable => false,
        }
    }
}

impl Violation {
    pub fn kind(&self) -> ViolationKind {
        match self {
            Self::BadLink { .. } => ViolationKind::BadLink,
            Self::ReachedTwice { .. } => ViolationKind::ReachedTwice,
            Self::BadLeaf { .. } => ViolationKind::BadLeaf,
            Self::ShapeUnknown { .. } => ViolationKind::ShapeUnknown,
            Self::ShapeMissing { .. } => ViolationKind::ShapeMissing,
            Self::NotFinite { .. } => ViolationKind::NotFinite,
            Self::NotContained { .. } => ViolationKind::NotContained,
            Self::NotCovered { .. } => ViolationKind::NotCovered,
            Self::ChildSticksOut { .. } => ViolationKind::ChildSticksOut,
            Self::NotTight { .. } => ViolationKind::NotTight,
            Self::ShapeRepeated { .. } => ViolationKind::ShapeRepeated,
            Self::Empty { .. } => ViolationKind::Empty,
            Self::TooDeep { .. } => ViolationKind::TooDeep,
            Self::Unreachable { .. } => ViolationKind::Unreachable,
        }
    }

    /// Where it is, unless it is a shape's.
    pub fn at(&self) -> Option<At> {
        match self {
            Self::BadLink { at, .. }
            | Self::ReachedTwice { at, .. }
            | Self::BadLeaf { at }
            | Self::ShapeUnknown { at, .. }
            | Self::NotFinite { at }
            | Self::NotContained { at, .. }
            | Self::ChildSticksOut { at, .. }
            | Self::NotTight { at }
            | Self::ShapeRepeated { at, .. }
            | Self::Empty { at }
            | Self::TooDeep { at, .. }
            | Self::Unreachable { at } => Some(*at),
            Self::ShapeMissing { .. } | Self::NotCovered { .. } => None,
        }
    }

    /// The shape that it is about, if it is about one.
    pub fn shape(&self) -> Option<u32> {
        match self {
            Self::ShapeMissing { shape }
            | Self::NotCovered { shape }
            | Self::ShapeUnknown { shape, .. }
            | Self::ShapeRepeated { shape, .. }
            | Self::NotContained { content: Content::Shape(shape), .. } => Some(*shape),
            Self::BadLink { .. }
            | Self::ReachedTwice { .. }
            | Self::BadLeaf { .. }
            | Self::NotFinite { .. }
            | Self::NotContained { .. }
            | Self::ChildSticksOut { .. }
            | Self::NotTight { .. }
            | Self::Empty { .. }
            | Self::TooDeep { .. }
            | Self::Unreachable { .. } => None,
        }
    }
}

/// What was found wrong or odd in a tree: the first of each kind, and how many there are of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// At most [`Findings::MOST_LISTED`] of each kind, by kind.
    pub violations: Vec<Violation>,
    counts: [usize; ViolationKind::ALL.len()],
    /// Shapes that several leaves refer to: a figure, as spatial splits make them.
    pub shapes_in_several: usize,
    /// Entries of the leaves beyond the first of each shape.
    pub extra_references: usize,
}

impl Findings {
    /// Most violations of a kind that are listed.
    pub const MOST_LISTED: usize = 1000;

    pub fn count(&self, kind: ViolationKind) -> usize {
        self.counts[kind as usize]
    }

    /// Whether the tree can be traced: it has no fault.
    pub fn is_valid(&self) -> bool {
        self.fault_count() == 0
    }

    pub fn fault_count(&self) -> usize {
        ViolationKind::ALL.into_iter().filter(|k| k.is_fault()).map(|k| self.count(k)).sum()
    }

    /// What is odd, but no fault.
    pub fn remark_count(&self) -> usize {
        ViolationKind::ALL.into_iter().filter(|k| !k.is_fault()).map(|k| self.count(k)).sum()
    }

    pub(super) fn add(&mut self, violation: Violation) {
        let kind = violation.kind();
        self.counts[kind as usize] += 1;
        if self.count(kind) <= Self::MOST_LISTED {
            self.violations.push(violation);
        }
    }

    /// Puts the list into the order of the kinds; those of a kind stay in the order in which they were found.
    pub(super) fn sort(&mut self) {
        self.violations.sort_by_key(|violation| violation.kind() as usize);
    }
}
