//! The trees: [`WideBvh`] as builders make it and rays walk it, and [`Tree`], any width and layout behind one face.

use std::borrow::Cow;

use glam::Vec3;

use crate::geometry::Aabb;

use super::compressed::CompressedBvh;
use super::config::Layout;

/// A child slot: nothing, an inner node, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ChildRef(pub u32);

impl ChildRef {
    pub const EMPTY: Self = Self(u32::MAX);
    const LEAF_BIT: u32 = 1 << 31;

    #[inline]
    pub fn inner(node_idx: u32) -> Self {
        debug_assert!(node_idx < Self::LEAF_BIT);
        Self(node_idx)
    }

    #[inline]
    pub fn leaf(leaf_idx: u32) -> Self {
        debug_assert!(leaf_idx < Self::LEAF_BIT - 1);
        Self(leaf_idx | Self::LEAF_BIT)
    }

    #[inline]
    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// The index of the inner node, if it is one.
    #[inline]
    pub fn as_inner(self) -> Option<u32> {
        (self.0 & Self::LEAF_BIT == 0).then_some(self.0)
    }

    /// The index of the leaf, if it is one.
    #[inline]
    pub fn as_leaf(self) -> Option<u32> {
        (self.0 & Self::LEAF_BIT != 0 && !self.is_empty()).then_some(self.0 & !Self::LEAF_BIT)
    }
}

/// An inner node with up to `N` children, boxes as structure of arrays. Filled slots come first; an empty slot has the
/// box [`Aabb::EMPTY`], which no ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct WideNode<const N: usize> {
    /// `sides[axis][slot]` of the minima, `sides[3 + axis][slot]` of the maxima.
    pub sides: [[f32; N]; 6],
    pub children: [ChildRef; N],
}

/// References `first..first + count` of [`WideBvh::refs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafRange {
    pub first: u32,
    pub count: u32,
}

/// A tree whose inner nodes have up to `N` children, ready to be walked. Inner nodes are in depth-first order of
/// creation with the root, if it is an inner node, at index 0.
#[derive(Clone, Debug, PartialEq)]
pub struct WideBvh<const N: usize> {
    pub root: ChildRef,
    pub bounds: Aabb,
    pub nodes: Vec<WideNode<N>>,
    pub leaves: Vec<LeafRange>,
    /// Shape indices in leaf order.
    pub refs: Vec<u32>,
    /// Of the deepest leaf; the root is at depth 0.
    pub depth_max: u32,
}

impl<const N: usize> WideNode<N> {
    /// A node without children.
    pub const EMPTY: Self = Self {
        sides: {
            let (min, max) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
            [min, min, min, max, max, max]
        },
        children: [ChildRef::EMPTY; N],
    };

    pub fn set_bounds(&mut self, slot: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.sides[axis][slot] = bounds.min[axis];
            self.sides[3 + axis][slot] = bounds.max[axis];
        }
    }

    /// The sides of a child's box, minima first.
    #[inline(always)]
    pub fn slot_sides(&self, slot: usize) -> [f32; 6] {
        let [a, b, c, d, e, f] = &self.sides;
        [a[slot], b[slot], c[slot], d[slot], e[slot], f[slot]]
    }

    pub fn child_bounds(&self, slot: usize) -> Aabb {
        let [min_x, min_y, min_z, max_x, max_y, max_z] = self.slot_sides(slot);
        Aabb { min: Vec3::new(min_x, min_y, min_z), max: Vec3::new(max_x, max_y, max_z) }
    }

    /// Children that are there.
    #[inline]
    pub fn child_count(&self) -> usize {
        self.children.iter().filter(|c| !c.is_empty()).count()
    }
}

impl<const N: usize> WideBvh<N> {
    /// A tree over nothing.
    pub fn empty() -> Self {
        Self {
            root: ChildRef::EMPTY,
            bounds: Aabb::EMPTY,
            nodes: Vec::new(),
            leaves: Vec::new(),
            refs: Vec::new(),
            depth_max: 0,
        }
    }

    /// Lets no leaf name a shape twice that was cut in parts. The references of every leaf ascend.
    pub fn merge_parts(&mut self) {
        let mut refs = Vec::with_capacity(self.refs.len());
        for leaf in &mut self.leaves {
            let shapes = &self.refs[leaf.first as usize..][..leaf.count as usize];
            debug_assert!(shapes.is_sorted(), "a leaf's references ascend");
            let first = refs.len();
            refs.extend_from_slice(&shapes[..1]);
            refs.extend(shapes.windows(2).filter(|pair| pair[0] != pair[1]).map(|pair| pair[1]));
            *leaf = LeafRange { first: first as u32, count: (refs.len() - first) as u32 };
        }
        self.refs = refs;
    }

    /// Bytes of nodes, leaves and references.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves[..]) + size_of_val(&self.refs[..])
    }

    pub fn walked(&self) -> Walked<'_, WideNode<N>> {
        Walked { root: self.root, bounds: &self.bounds, nodes: &self.nodes, depth_max: self.depth_max }
    }
}

/// What a ray needs of a tree.
#[derive(Debug)]
pub struct Walked<'a, T> {
    pub root: ChildRef,
    pub bounds: &'a Aabb,
    pub nodes: &'a [T],
    /// Of the deepest leaf.
    pub depth_max: u32,
}

impl<T> Clone for Walked<'_, T> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Walked<'_, T> {}

/// A finished tree in any layout, node by node: what measures, checks and draws it asks. Parents come before their children.
pub trait Nodes: Sync {
    /// Most children of a node.
    const WIDTH: usize;

    fn root(&self) -> ChildRef;

    fn bounds(&self) -> Aabb;

    /// Of the deepest leaf; the root is at depth 0.
    fn depth_max(&self) -> u32;

    fn inner_count(&self) -> usize;

    fn leaf_count(&self) -> usize;

    fn leaf_range(&self, leaf_idx: u32) -> LeafRange;

    /// Shape indices in leaf order.
    fn refs(&self) -> &[u32];

    /// What stands in a slot of an inner node, with its box. Filled slots come first.
    fn slot(&self, node_idx: u32, slot: usize) -> (ChildRef, Aabb);

    /// How much larger than what is below it a child's box may be, an axis each: 0, or what a compressed node's grid makes
    /// of it.
    fn box_slack(&self, node_idx: u32) -> Vec3;

    /// The id of what a slot points at; `None` for an empty slot.
    fn node_id(&self, child: ChildRef) -> Option<NodeId> {
        let inner = child.as_inner().map(NodeId);
        inner.or_else(|| child.as_leaf().map(|leaf_idx| NodeId(self.inner_count() as u32 + leaf_idx)))
    }

    /// The children of an inner node with their boxes, in slot order.
    fn children(&self, node_idx: u32) -> impl Iterator<Item = (NodeId, Aabb)> + '_ {
        (0..Self::WIDTH).filter_map(move |slot| {
            let (child, bounds) = self.slot(node_idx, slot);
            Some((self.node_id(child)?, bounds))
        })
    }

    /// Visits every node once, parents before children, depth first; `visit` answers whether to go on below the node.
    /// The node's children or leaf are looked up by the caller where wanted, so the walk itself allocates nothing a node.
    fn walk_nodes(&self, mut visit: impl FnMut(Visit) -> bool) {
        let Some(root) = self.node_id(self.root()) else { return };
        let mut open = vec![Visit { id: root, parent: None, depth: 0, bounds: self.bounds() }];
        while let Some(at) = open.pop() {
            let inner = (at.id.0 as usize) < self.inner_count();
            if visit(at) && inner {
                let first = open.len();
                open.extend(self.children(at.id.0).map(|(id, bounds)| Visit {
                    id,
                    parent: Some(at.id),
                    depth: at.depth + 1,
                    bounds,
                }));
                open[first..].reverse();
            }
        }
    }
}

impl<const N: usize> Nodes for WideBvh<N> {
    const WIDTH: usize = N;

    fn root(&self) -> ChildRef {
        self.root
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn depth_max(&self) -> u32 {
        self.depth_max
    }

    fn inner_count(&self) -> usize {
        self.nodes.len()
    }

    fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    #[inline]
    fn leaf_range(&self, leaf_idx: u32) -> LeafRange {
        self.leaves[leaf_idx as usize]
    }

    fn refs(&self) -> &[u32] {
        &self.refs
    }

    #[inline]
    fn slot(&self, node_idx: u32, slot: usize) -> (ChildRef, Aabb) {
        let node = &self.nodes[node_idx as usize];
        (node.children[slot], node.child_bounds(slot))
    }

    fn box_slack(&self, _: u32) -> Vec3 {
        Vec3::ZERO
    }
}

/// A node met on a walk, without what lies below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    pub id: NodeId,
    pub parent: Option<NodeId>,
    /// The root is at depth 0.
    pub depth: u32,
    pub bounds: Aabb,
}

/// A finished tree of any width and layout. Immutable once built.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree {
    W2(WideBvh<2>),
    W4(WideBvh<4>),
    W8(WideBvh<8>),
    C8(CompressedBvh),
    /// Only from elsewhere: no builder makes them.
    W16(WideBvh<16>),
}

/// Inner nodes come first (`0..inner_count`), then leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// What lies below a node.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind<'a> {
    /// The children with their boxes, in slot order.
    Inner(Vec<(NodeId, Aabb)>),
    /// The indices of the leaf's shapes.
    Leaf(&'a [u32]),
}

/// One node met on a walk.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeView<'a> {
    pub id: NodeId,
    pub parent: Option<NodeId>,
    /// The root is at depth 0.
    pub depth: u32,
    pub bounds: Aabb,
    pub kind: NodeKind<'a>,
}

/// Runs the same expression on the tree of whichever width and layout it is.
#[macro_export]
macro_rules! each_width {
    ($tree:expr, $t:ident => $body:expr) => {
        match $tree {
            $crate::accel::Tree::W2($t) => $body,
            $crate::accel::Tree::W4($t) => $body,
            $crate::accel::Tree::W8($t) => $body,
            $crate::accel::Tree::C8($t) => $body,
            $crate::accel::Tree::W16($t) => $body,
        }
    };
}

impl Tree {
    /// How many children its nodes have room for.
    pub fn width(&self) -> usize {
        match self {
            Self::W2(_) => 2,
            Self::W4(_) => 4,
            Self::W8(_) | Self::C8(_) => 8,
            Self::W16(_) => 16,
        }
    }

    pub fn layout(&self) -> Layout {
        match self {
            Self::W2(_) | Self::W4(_) | Self::W8(_) | Self::W16(_) => Layout::Full,
            Self::C8(_) => Layout::Compressed,
        }
    }

    pub fn bounds(&self) -> Aabb {
        each_width!(self, t => t.bounds)
    }

    pub fn inner_count(&self) -> usize {
        each_width!(self, t => t.inner_count())
    }

    pub fn leaf_count(&self) -> usize {
        each_width!(self, t => t.leaf_count())
    }

    /// Inner nodes + leaves.
    pub fn node_count(&self) -> usize {
        self.inner_count() + self.leaf_count()
    }

    /// Shape indices in leaf order; a shape may stand there more than once.
    pub fn refs(&self) -> &[u32] {
        each_width!(self, t => &t.refs)
    }

    /// The references of a leaf, a range of [`Tree::refs`].
    pub fn leaf_range(&self, leaf_idx: u32) -> LeafRange {
        each_width!(self, t => t.leaf_range(leaf_idx))
    }

    /// Those of all leaves.
    pub fn leaf_ranges(&self) -> Cow<'_, [LeafRange]> {
        match self {
            Self::W2(t) => Cow::Borrowed(&t.leaves),
            Self::W4(t) => Cow::Borrowed(&t.leaves),
            Self::W8(t) => Cow::Borrowed(&t.leaves),
            Self::W16(t) => Cow::Borrowed(&t.leaves),
            Self::C8(t) => (0..t.leaf_count() as u32).map(|leaf_idx| t.leaf_range(leaf_idx)).collect(),
        }
    }

    /// Bytes of nodes, leaves and references (not of the shapes).
    pub fn bytes(&self) -> usize {
        each_width!(self, t => t.bytes())
    }

    /// Of the deepest leaf; `None` for an empty tree.
    pub fn depth_max(&self) -> Option<u32> {
        (self.node_count() > 0).then_some(each_width!(self, t => t.depth_max))
    }

    /// Whether a node is a leaf, and then which.
    pub fn leaf_index(&self, node: NodeId) -> Option<u32> {
        (node.0 as usize).checked_sub(self.inner_count()).map(|leaf_idx| leaf_idx as u32)
    }

    /// The shapes of a leaf.
    pub fn leaf_shapes(&self, leaf_idx: u32) -> &[u32] {
        let leaf = self.leaf_range(leaf_idx);
        &self.refs()[leaf.first as usize..(leaf.first + leaf.count) as usize]
    }

    /// Visits every node once, parents before children, depth first; `visit` answers whether to go on below the node.
    pub fn walk_nodes(&self, visit: impl FnMut(Visit) -> bool) {
        each_width!(self, t => t.walk_nodes(visit));
    }

    /// As [`Tree::walk_nodes`], with each node's children or shapes.
    pub fn walk<'a>(&'a self, mut visit: impl FnMut(NodeView<'a>) -> bool) {
        self.walk_nodes(|Visit { id, parent, depth, bounds }| {
            let kind = match self.leaf_index(id) {
                Some(leaf_idx) => NodeKind::Leaf(self.leaf_shapes(leaf_idx)),
                None => NodeKind::Inner(each_width!(self, t => t.children(id.0).collect())),
            };
            visit(NodeView { id, parent, depth, bounds, kind })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_is_exactly_one_of_empty_inner_and_leaf() {
        for (child, inner, leaf) in [
            (ChildRef::EMPTY, None, None),
            (ChildRef::inner(7), Some(7), None),
            (ChildRef::leaf(0), None, Some(0)),
            (ChildRef::leaf(9), None, Some(9)),
        ] {
            assert_eq!((child.as_inner(), child.as_leaf()), (inner, leaf));
            assert_eq!(child.is_empty(), inner.is_none() && leaf.is_none());
        }
    }
}
