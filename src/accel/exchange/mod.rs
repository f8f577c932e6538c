//! Trees from and to other programs: [`RawTree`], plain arrays of any width, perhaps broken, which become a [`Tree`] by
//! validation alone.

use glam::Vec3;

use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::tree::{ChildRef, LeafRange, Nodes, Tree, WideBvh, WideNode};
use super::validate::{At, Checked, Findings, Link, Reached, check};

/// A tree as plain arrays: those of the files (`docs/tree-format.md`). Any of its numbers may be wrong.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawTree {
    /// Slots a node, in [`RawTree::WIDTHS`].
    pub width: usize,
    /// Corners of the slots' boxes, `width` a node. Those of empty slots mean nothing.
    pub child_min: Vec<[f32; 3]>,
    pub child_max: Vec<[f32; 3]>,
    /// What the slots point at: see [`RawTree::link`].
    pub child_index: Vec<i32>,
    /// Of each leaf, the range of `shape_index` that it holds.
    pub leaf_first: Vec<i32>,
    pub leaf_count: Vec<i32>,
    pub shape_index: Vec<i32>,
}

/// A node's or leaf's box, and its parent with that one's. The first parent, of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub bounds: Option<Aabb>,
    pub parent: Option<(At, Option<Aabb>)>,
}

/// Arrays whose lengths do not fit together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormError {
    #[error("nodes have {width} slots; allowed are 2 to 16")]
    Width { width: usize },
    #[error("{name} has {len} entries where {expected} are needed")]
    Length { name: &'static str, len: usize, expected: usize },
    #[error("{name} has {len} entries; most are 2,147,483,645")]
    TooMany { name: &'static str, len: usize },
}

impl RawTree {
    pub const WIDTHS: std::ops::RangeInclusive<usize> = 2..=16;
    /// An empty slot.
    pub const EMPTY: i32 = -1;
    /// Leaf `i` is written as `LEAVES - i`.
    pub const LEAVES: i32 = -2;

    pub fn node_count(&self) -> usize {
        self.child_index.len() / self.width.max(1)
    }

    pub fn leaf_count(&self) -> usize {
        self.leaf_first.len()
    }

    /// Checks that the arrays' lengths fit together: all that the other functions take for granted.
    ///
    /// # Errors
    /// [`FormError`]
    pub fn check_form(&self) -> Result<(), FormError> {
        const MOST: usize = i32::MAX as usize - 2;
        if !Self::WIDTHS.contains(&self.width) {
            return Err(FormError::Width { width: self.width });
        }
        let slots = self.child_index.len();
        let whole = slots.next_multiple_of(self.width);
        for (name, len, expected) in [
            ("child_index", slots, whole),
            ("child_min", self.child_min.len(), slots),
            ("child_max", self.child_max.len(), slots),
            ("leaf_count", self.leaf_count.len(), self.leaf_first.len()),
        ] {
            if len != expected {
                return Err(FormError::Length { name, len, expected });
            }
        }
        for (name, len) in [
            ("child_index", slots),
            ("leaf_first", self.leaf_first.len()),
            ("shape_index", self.shape_index.len()),
        ] {
            if len > MOST {
                return Err(FormError::TooMany { name, len });
            }
        }
        Ok(())
    }

    /// What a number of `child_index` stands for: a node from 0 up, -1 nothing, leaf i as -2 - i.
    fn link(&self, value: i32) -> Link {
        let at = match value {
            Self::EMPTY => return Link::Empty,
            0.. => At::Node(value as u32),
            _ => At::Leaf(Self::LEAVES.wrapping_sub(value) as u32),
        };
        let exists = match at {
            At::Node(node_idx) => (node_idx as usize) < self.node_count(),
            At::Leaf(leaf_idx) => (leaf_idx as usize) < self.leaf_count(),
        };
        if exists { Link::To(at) } else { Link::Bad(value.into()) }
    }

    fn child_bounds(&self, slot: usize) -> Aabb {
        Aabb { min: self.child_min[slot].into(), max: self.child_max[slot].into() }
    }

    /// Where a node or a leaf lies; `None` if there is none of that index.
    pub fn place_of(&self, at: At) -> Option<Place> {
        let slot_of = |at: At| {
            let value = match at {
                At::Node(node_idx) => i32::try_from(node_idx).ok()?,
                At::Leaf(leaf_idx) => Self::LEAVES.checked_sub(i32::try_from(leaf_idx).ok()?)?,
            };
            self.child_index.iter().position(|child| *child == value)
        };
        let bounds_of = |at: At| match (at, slot_of(at)) {
            // The root's is that of its children, also where a cycle comes back to it.
            (At::Node(0), _) | (_, None) => self.union_of_children(at),
            (_, Some(slot)) => Some(self.child_bounds(slot)),
        };
        match at {
            At::Node(node_idx) if node_idx as usize >= self.node_count() => return None,
            At::Leaf(leaf_idx) if leaf_idx as usize >= self.leaf_count() => return None,
            At::Node(_) | At::Leaf(_) => {}
        }
        let parent =
            slot_of(at).filter(|_| at != At::Node(0)).map(|slot| At::Node((slot / self.width) as u32));
        Some(Place { bounds: bounds_of(at), parent: parent.map(|at| (at, bounds_of(at))) })
    }

    fn union_of_children(&self, at: At) -> Option<Aabb> {
        let At::Node(node_idx) = at else { return None };
        let slots = node_idx as usize * self.width..(node_idx as usize + 1) * self.width;
        let children = slots.filter(|slot| self.child_index[*slot] != Self::EMPTY);
        children.map(|slot| self.child_bounds(slot)).filter(Aabb::is_finite).reduce(Aabb::union)
    }

    /// The same tree as arrays, with the numbers that its nodes and leaves have.
    pub fn of(tree: &Tree) -> Self {
        each_width!(tree, t => of_nodes(t))
    }

    /// Checks the tree against the boxes of the shapes that it is over. With it the tree as it is traced, if there is no
    /// fault in it: nodes keep their numbers where parents come before their children and nothing is out of reach, leaves
    /// where nothing is.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    ///
    /// # Panics
    /// If the arrays' lengths do not fit together ([`RawTree::check_form`]).
    pub fn checked(&self, boxes: &[Aabb], task: &Task) -> Result<(Findings, Option<Tree>), Cancelled> {
        self.check_form().expect("a reader of trees checks their form");
        let arrays = Over { raw: self, boxes };
        let (findings, reached) = check(&arrays, boxes, task)?;
        let tree = findings.is_valid().then(|| self.tree_of(&arrays, &reached));
        task.check()?;
        Ok((findings, tree))
    }

    /// What of a perhaps broken tree can be drawn, by the same numbers: boxes that are numbers, and links that lead on. It
    /// is not fit for anything else.
    pub fn drawable(&self, boxes: &[Aabb], task: &Task) -> Result<Tree, Cancelled> {
        let arrays = Over { raw: self, boxes };
        let (_, reached) = check(&arrays, boxes, task)?;
        let mut bvh = WideBvh::<16>::empty();
        bvh.nodes = vec![WideNode::EMPTY; self.node_count()];
        bvh.leaves = vec![LeafRange { first: 0, count: 0 }; self.leaf_count()];
        bvh.refs = self.shape_index.iter().map(|shape| *shape as u32).collect();
        for (leaf_idx, leaf) in bvh.leaves.iter_mut().enumerate() {
            if let Some(shapes) = arrays.shapes(leaf_idx as u32) {
                *leaf = LeafRange { first: self.leaf_first[leaf_idx] as u32, count: shapes.len() as u32 };
            }
        }
        let mut filled = vec![0_usize; self.node_count()];
        for (i, item) in reached.iter().enumerate() {
            bvh.depth_max = bvh.depth_max.max(item.depth);
            let child = child_ref(item.at);
            if i == 0 {
                (bvh.root, bvh.bounds) = (child, item.bounds);
            } else if let At::Node(parent) = reached[item.parent as usize].at {
                let slot = &mut filled[parent as usize];
                let node = &mut bvh.nodes[parent as usize];
                node.children[*slot] = child;
                // A box that is none is drawn as a point in no picture; what lies below it is drawn.
                let bounds = if item.bounds.is_finite() { item.bounds } else { Aabb::EMPTY };
                node.set_bounds(*slot, &bounds);
                *slot += 1;
            }
        }
        Ok(Tree::W16(bvh))
    }

    /// The narrowest of our trees that has room for the nodes.
    fn tree_of(&self, arrays: &Over, reached: &[Reached]) -> Tree {
        match self.width {
            ..=2 => Tree::W2(wide(arrays, reached)),
            3..=4 => Tree::W4(wide(arrays, reached)),
            5..=8 => Tree::W8(wide(arrays, reached)),
            _ => Tree::W16(wide(arrays, reached)),
        }
    }
}

fn child_ref(at: At) -> ChildRef {
    match at {
        At::Node(node_idx) => ChildRef::inner(node_idx),
        At::Leaf(leaf_idx) => ChildRef::leaf(leaf_idx),
    }
}

/// A tree of arrays over shapes with these boxes.
struct Over<'a> {
    raw: &'a RawTree,
    boxes: &'a [Aabb],
}

impl Checked for Over<'_> {
    /// Node 0; without nodes leaf 0.
    fn root(&self) -> Option<(At, Aabb)> {
        let finite = |all: Aabb, b: Aabb| if b.is_finite() { all.union(b) } else { all };
        if self.raw.node_count() > 0 {
            let slots = (0..self.raw.width).filter(|slot| self.raw.child_index[*slot] != RawTree::EMPTY);
            let bounds = slots.map(|slot| self.raw.child_bounds(slot)).fold(Aabb::EMPTY, finite);
            return Some((At::Node(0), bounds));
        }
        let shapes = (self.raw.leaf_count() > 0).then(|| self.shapes(0).unwrap_or_default())?;
        let boxes = shapes.iter().filter_map(|shape| self.boxes.get(*shape as usize));
        Some((At::Leaf(0), boxes.copied().fold(Aabb::EMPTY, finite)))
    }

    fn inner_count(&self) -> usize {
        self.raw.node_count()
    }

    fn leaf_count(&self) -> usize {
        self.raw.leaf_count()
    }

    fn width(&self) -> usize {
        self.raw.width
    }

    fn slot(&self, node_idx: u32, slot: usize) -> (Link, Aabb) {
        let slot = node_idx as usize * self.raw.width + slot;
        (self.raw.link(self.raw.child_index[slot]), self.raw.child_bounds(slot))
    }

    fn shapes(&self, leaf_idx: u32) -> Option<&[u32]> {
        let (first, count) = (self.raw.leaf_first[leaf_idx as usize], self.raw.leaf_count[leaf_idx as usize]);
        let (first, count) = (usize::try_from(first).ok()?, usize::try_from(count).ok()?);
        // A negative index is one of a shape that does not exist.
        bytemuck::cast_slice(&self.raw.shape_index).get(first..first.checked_add(count)?)
    }
}

impl Over<'_> {
    /// Whether the leaves share the list of shapes among them without gap or overlap.
    fn leaves_hold_each_entry_once(&self) -> bool {
        let mut held = vec![false; self.raw.shape_index.len()];
        let mut ranges = self.raw.leaf_first.iter().zip(&self.raw.leaf_count);
        let once = ranges.all(|(&first, &count)| {
            let entries = held.get_mut(first as usize..(first as usize).saturating_add(count as usize));
            entries.is_some_and(|entries| entries.iter_mut().all(|held| !std::mem::replace(held, true)))
        });
        once && held.iter().all(|held| *held)
    }
}

/// New numbers of nodes or leaves, in the order in which they are reached, or the old ones if they can stay.
struct Numbers {
    new: Option<Vec<u32>>,
}

impl Numbers {
    fn of(count: usize, reached: impl Iterator<Item = u32> + Clone, may_stay: bool) -> Self {
        if may_stay && reached.clone().count() == count {
            return Self { new: None };
        }
        let mut new = vec![0; count];
        for (number, old) in reached.enumerate() {
            new[old as usize] = number as u32;
        }
        Self { new: Some(new) }
    }

    fn of_old(&self, old: u32) -> u32 {
        self.new.as_ref().map_or(old, |new| new[old as usize])
    }
}

/// The tree of what was reached in a tree without a fault.
fn wide<const N: usize>(arrays: &Over, reached: &[Reached]) -> WideBvh<N> {
    let Some(root) = reached.first() else { return WideBvh::empty() };
    let nodes = || {
        reached.iter().filter_map(|item| match item.at {
            At::Node(node_idx) => Some(node_idx),
            At::Leaf(_) => None,
        })
    };
    let leaves = || {
        reached.iter().filter_map(|item| match item.at {
            At::Node(_) => None,
            At::Leaf(leaf_idx) => Some(leaf_idx),
        })
    };
    let parents_first = reached[1..].iter().all(|item| match (reached[item.parent as usize].at, item.at) {
        (At::Node(parent), At::Node(child)) => parent < child,
        _ => true,
    });
    let node_numbers = Numbers::of(arrays.inner_count(), nodes(), parents_first);
    let leaf_numbers = Numbers::of(arrays.leaf_count(), leaves(), true);
    let number = |at: At| match at {
        At::Node(node_idx) => At::Node(node_numbers.of_old(node_idx)),
        At::Leaf(leaf_idx) => At::Leaf(leaf_numbers.of_old(leaf_idx)),
    };
    let mut bvh = WideBvh::<N>::empty();
    (bvh.root, bvh.bounds) = (child_ref(number(root.at)), root.bounds);
    bvh.nodes = vec![WideNode::EMPTY; nodes().count()];
    let mut filled = vec![0_u8; bvh.nodes.len()];
    for item in &reached[1..] {
        bvh.depth_max = bvh.depth_max.max(item.depth);
        if let At::Node(parent) = number(reached[item.parent as usize].at) {
            let slot = &mut filled[parent as usize];
            let node = &mut bvh.nodes[parent as usize];
            node.children[usize::from(*slot)] = child_ref(number(item.at));
            node.set_bounds(usize::from(*slot), &item.bounds);
            *slot += 1;
        }
    }
    let mut old_leaves = vec![0; leaves().count()];
    for leaf_idx in leaves() {
        old_leaves[leaf_numbers.of_old(leaf_idx) as usize] = leaf_idx;
    }
    if leaf_numbers.new.is_none() && arrays.leaves_hold_each_entry_once() {
        let RawTree { leaf_first, leaf_count, shape_index, .. } = arrays.raw;
        let ranges = leaf_first.iter().zip(leaf_count);
        bvh.leaves =
            ranges.map(|(&first, &count)| LeafRange { first: first as u32, count: count as u32 }).collect();
        bvh.refs = bytemuck::cast_slice(shape_index).to_vec();
        return bvh;
    }
    for leaf_idx in old_leaves {
        let shapes = arrays.shapes(leaf_idx).unwrap_or_default();
        bvh.leaves.push(LeafRange { first: bvh.refs.len() as u32, count: shapes.len() as u32 });
        bvh.refs.extend_from_slice(shapes);
    }
    bvh
}

fn of_nodes<T: Nodes>(bvh: &T) -> RawTree {
    let mut raw = RawTree { width: T::WIDTH, ..RawTree::default() };
    for node_idx in 0..bvh.inner_count() as u32 {
        for slot in 0..T::WIDTH {
            let (child, bounds) = bvh.slot(node_idx, slot);
            // Readers of any kind take zeros better than infinities.
            let bounds = if child.is_empty() { Aabb::new(Vec3::ZERO, Vec3::ZERO) } else { bounds };
            raw.child_min.push(bounds.min.to_array());
            raw.child_max.push(bounds.max.to_array());
            raw.child_index.push(match At::of(child) {
                None => RawTree::EMPTY,
                Some(At::Node(node_idx)) => node_idx as i32,
                Some(At::Leaf(leaf_idx)) => RawTree::LEAVES - leaf_idx as i32,
            });
        }
    }
    let leaves = (0..bvh.leaf_count() as u32).map(|leaf_idx| bvh.leaf_range(leaf_idx));
    raw.leaf_first = leaves.clone().map(|leaf| leaf.first as i32).collect();
    raw.leaf_count = leaves.map(|leaf| leaf.count as i32).collect();
    raw.shape_index = bvh.refs().iter().map(|shape| *shape as i32).collect();
    raw
}

#[cfg(test)]
mod tests;
