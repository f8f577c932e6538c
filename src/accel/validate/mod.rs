//! Checks a tree against the boxes it was built over: one list of violations for trees of our own and from elsewhere.

mod violation;

use glam::Vec3;

use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::config::BuildConfig;
use super::tree::{Nodes, Tree};

pub use violation::{At, Content, Findings, Violation, ViolationKind};

/// Most violations that [`validate`] answers.
const MOST: usize = 100;

/// Nodes between two looks at the task.
const STEP: usize = 1 << 12;

/// Every violation found, what is only odd included, at most a hundred; empty for a valid tree of our own over `boxes`.
/// Broken links are met with a visited set, so any tree can be checked.
pub fn validate(tree: &Tree, boxes: &[Aabb]) -> Vec<Violation> {
    let findings = each_width!(tree, t => check(t, boxes, &Task::new()));
    let (mut found, _) = findings.expect("nobody cancels this task");
    found.violations.truncate(MOST);
    found.violations
}

/// What a slot of a node points at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Link {
    Empty,
    To(At),
    /// Nothing that exists: the number that stands there.
    Bad(i64),
}

/// A tree as it is checked: perhaps broken, so that every index is to be looked at before it is used.
pub(super) trait Checked {
    /// What the root is, with its box.
    fn root(&self) -> Option<(At, Aabb)>;
    fn inner_count(&self) -> usize;
    fn leaf_count(&self) -> usize;
    fn width(&self) -> usize;
    /// A slot of a node that exists.
    fn slot(&self, node_idx: u32, slot: usize) -> (Link, Aabb);
    /// The shapes of a leaf that exists; `None` if they lie outside the list.
    fn shapes(&self, leaf_idx: u32) -> Option<&[u32]>;
    /// How much larger than what is below it a child's box may be, an axis each, without a word.
    fn box_slack(&self, _node_idx: u32) -> Vec3 {
        Vec3::ZERO
    }
}

impl<T: Nodes> Checked for T {
    fn root(&self) -> Option<(At, Aabb)> {
        Some((At::of(Nodes::root(self))?, self.bounds()))
    }

    fn inner_count(&self) -> usize {
        Nodes::inner_count(self)
    }

    fn leaf_count(&self) -> usize {
        Nodes::leaf_count(self)
    }

    fn width(&self) -> usize {
        T::WIDTH
    }

    fn slot(&self, node_idx: u32, slot: usize) -> (Link, Aabb) {
        let (child, bounds) = Nodes::slot(self, node_idx, slot);
        let link = match At::of(child) {
            None => Link::Empty,
            Some(At::Node(i)) if i as usize >= Nodes::inner_count(self) => Link::Bad(i.into()),
            Some(At::Leaf(i)) if i as usize >= Nodes::leaf_count(self) => Link::Bad(i.into()),
            Some(at) => Link::To(at),
        };
        (link, bounds)
    }

    fn shapes(&self, leaf_idx: u32) -> Option<&[u32]> {
        let leaf = self.leaf_range(leaf_idx);
        self.refs().get(leaf.first as usize..leaf.first as usize + leaf.count as usize)
    }

    fn box_slack(&self, node_idx: u32) -> Vec3 {
        Nodes::box_slack(self, node_idx)
    }
}

/// A node or leaf that the walk from the root has come to, parents before children.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    pub at: At,
    /// Index of the parent among those reached; its own for the root.
    pub parent: u32,
    pub depth: u32,
    /// As its parent's slot says.
    pub bounds: Aabb,
    /// How much larger than its content the box may be.
    slack: Vec3,
    /// Of the shapes below it: all of a shape that lies in one leaf, of others the part inside each leaf's box.
    content: Aabb,
}

/// Checks any tree against the boxes of its shapes. Answers also what was reached, parents first, each once.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub(super) fn check<T: Checked>(
    tree: &T,
    boxes: &[Aabb],
    task: &Task,
) -> Result<(Findings, Vec<Reached>), Cancelled> {
    let mut found = Findings::default();
    let mut reached = walk(tree, task, &mut found)?;
    let counts = count_shapes(tree, boxes.len(), &reached, &mut found);
    check_leaves(tree, boxes, &counts, &mut reached, &mut found);
    task.check()?;
    check_nodes(tree, &mut reached, &mut found);
    found.sort();
    Ok((found, reached))
}

/// Everything that can be reached, each once, depth first.
fn walk<T: Checked>(tree: &T, task: &Task, found: &mut Findings) -> Result<Vec<Reached>, Cancelled> {
    let total = tree.inner_count() + tree.leaf_count();
    let mut reached: Vec<Reached> = Vec::with_capacity(total);
    let mut seen = vec![false; total];
    let (content, mut open) = (Aabb::EMPTY, Vec::new());
    if let Some((at, bounds)) = tree.root() {
        open.push(Reached { at, parent: 0, depth: 0, bounds, slack: Vec3::ZERO, content });
    }
    while let Some(item) = open.pop() {
        if reached.len().is_multiple_of(STEP) {
            task.check()?;
        }
        let Reached { at, parent, depth, .. } = item;
        let seen = &mut seen[at.node_id(tree.inner_count()).0 as usize];
        if std::mem::replace(seen, true) {
            found.add(Violation::ReachedTwice { at, parent: reached[parent as usize].at });
            continue;
        }
        let own = reached.len() as u32;
        reached.push(item);
        if depth as usize > BuildConfig::MAX_DEPTH {
            found.add(Violation::TooDeep { at, depth });
        }
        let At::Node(node_idx) = at else { continue };
        let (first, slack) = (open.len(), tree.box_slack(node_idx));
        let mut is_empty = true;
        for slot in 0..tree.width() {
            let (link, bounds) = tree.slot(node_idx, slot);
            is_empty &= link == Link::Empty;
            match link {
                Link::Empty => {}
                Link::To(at) => {
                    open.push(Reached { at, parent: own, depth: depth + 1, bounds, slack, content })
                }
                Link::Bad(value) => found.add(Violation::BadLink { at, slot: slot as u32, value }),
            }
        }
        open[first..].reverse();
        if is_empty {
            found.add(Violation::Empty { at });
        }
    }
    let items =
        (0..tree.inner_count() as u32).map(At::Node).chain((0..tree.leaf_count() as u32).map(At::Leaf));
    for (at, _) in items.zip(&seen).filter(|(_, seen)| !**seen) {
        found.add(Violation::Unreachable { at });
    }
    Ok(reached)
}

/// How many leaves refer to each shape: spatial splits make several, each with a part of it.
fn count_shapes<T: Checked>(
    tree: &T,
    shape_count: usize,
    reached: &[Reached],
    found: &mut Findings,
) -> Vec<u32> {
    let mut counts = vec![0_u32; shape_count];
    let mut sorted = Vec::new();
    for at in reached.iter().map(|item| item.at) {
        let At::Leaf(leaf_idx) = at else { continue };
        let Some(shapes) = tree.shapes(leaf_idx) else {
            found.add(Violation::BadLeaf { at });
            continue;
        };
        if shapes.is_empty() {
            found.add(Violation::Empty { at });
        }
        sorted.clear();
        sorted.extend_from_slice(shapes);
        sorted.sort_unstable();
        for same in sorted.chunk_by(|a, b| a == b) {
            let (shape, count) = (same[0], same.len());
            match counts.get_mut(shape as usize) {
                None => found.add(Violation::ShapeUnknown { at, shape }),
                Some(counted) => {
                    found.extra_references += count - usize::from(*counted == 0);
                    *counted += 1;
                    if count > 1 {
                        found.add(Violation::ShapeRepeated { at, shape, count });
                    }
                }
            }
        }
    }
    found.shapes_in_several = counts.iter().filter(|count| **count > 1).count();
    for (shape, _) in counts.iter().enumerate().filter(|(_, count)| **count == 0) {
        found.add(Violation::ShapeMissing { shape: shape as u32 });
    }
    counts
}

/// How far `inner` reaches out of `outer`; `None` if it does not.
fn sticks_out(outer: &Aabb, inner: &Aabb) -> Option<f32> {
    (!outer.contains(inner)).then(|| {
        let below = (outer.min - inner.min).max_element();
        let above = (inner.max - outer.max).max_element();
        below.max(above)
    })
}

/// Of a box that contains its content.
fn is_tight(bounds: &Aabb, content: &Aabb, slack: Vec3) -> bool {
    let beyond = (content.min - bounds.min).max(bounds.max - content.max);
    bounds == content || beyond.cmple(slack).all()
}

/// Whether the sides of a box are numbers. What is empty may have [`Aabb::EMPTY`].
fn is_finite(item: &Reached, found: &mut Findings) -> bool {
    let finite = item.bounds.is_finite();
    if !finite && (item.bounds != Aabb::EMPTY || !item.content.is_empty()) {
        found.add(Violation::NotFinite { at: item.at });
    }
    finite
}

/// What a leaf must contain of a shape: all of it if it lies in no other leaf, else the part in its box.
fn part_of(whole: Aabb, count: u32, bounds: &Aabb) -> Aabb {
    if count == 1 { whole } else { whole.intersection(*bounds) }
}

/// Checks the boxes of leaves against their shapes, and fills in what they contain.
fn check_leaves<T: Checked>(
    tree: &T,
    boxes: &[Aabb],
    counts: &[u32],
    reached: &mut [Reached],
    found: &mut Findings,
) {
    // What the leaves hold of the shapes that are in several.
    let mut covered = vec![Aabb::EMPTY; if found.shapes_in_several > 0 { boxes.len() } else { 0 }];
    for item in reached {
        let Reached { at, bounds, .. } = *item;
        let At::Leaf(leaf_idx) = at else { continue };
        let mut in_parts = false;
        let mut outside: Option<(u32, f32)> = None;
        for &shape in tree.shapes(leaf_idx).unwrap_or_default() {
            let Some(&whole) = boxes.get(shape as usize) else { continue };
            let count = counts[shape as usize];
            let part = part_of(whole, count, &bounds);
            if count > 1 && !part.is_empty() {
                covered[shape as usize] = covered[shape as usize].union(part);
            }
            in_parts |= count > 1;
            item.content = if part.is_empty() { item.content } else { item.content.union(part) };
            if let Some(by) = sticks_out(&bounds, &part)
                && outside.is_none_or(|(_, most)| by > most)
            {
                outside = Some((shape, by));
            }
        }
        if !is_finite(item, found) {
            continue;
        }
        if let Some((shape, by)) = outside {
            found.add(Violation::NotContained { at, content: Content::Shape(shape), by });
        } else if !in_parts && !is_tight(&bounds, &item.content, item.slack) {
            // A part of a shape may be smaller than the part of its box.
            found.add(Violation::NotTight { at });
        }
    }
    for (shape, covered) in covered.iter().enumerate() {
        if counts[shape] > 1 && !covered.contains(&boxes[shape]) {
            found.add(Violation::NotCovered { shape: shape as u32 });
        }
    }
}

/// Checks the boxes of inner nodes against what lies below them, children before their parents.
fn check_nodes<T: Checked>(tree: &T, reached: &mut [Reached], found: &mut Findings) {
    /// Of a node: the union of its children's boxes, and the child whose content and whose box reach out most.
    #[derive(Clone)]
    struct Below {
        children: Aabb,
        content: Option<(At, f32)>,
        boxed: Option<(At, f32)>,
    }
    let none = Below { children: Aabb::EMPTY, content: None, boxed: None };
    let mut below = vec![none; tree.inner_count()];
    for i in (0..reached.len()).rev() {
        let item = reached[i];
        if let At::Node(node_idx) = item.at
            && is_finite(&item, found)
        {
            let Below { children, content, boxed } = &below[node_idx as usize];
            let at = item.at;
            match (content, boxed) {
                (Some((child, by)), _) => {
                    found.add(Violation::NotContained { at, content: Content::Child(*child), by: *by });
                }
                (None, Some((child, by))) => {
                    found.add(Violation::ChildSticksOut { at, child: *child, by: *by })
                }
                (None, None) if !is_tight(&item.bounds, children, item.slack) => {
                    found.add(Violation::NotTight { at });
                }
                (None, None) => {}
            }
        }
        if i == 0 {
            break;
        }
        let parent = &mut reached[item.parent as usize];
        parent.content = parent.content.union(item.content);
        let parent = *parent;
        let At::Node(parent_idx) = parent.at else { continue };
        let Below { children, content, boxed } = &mut below[parent_idx as usize];
        if !item.bounds.is_empty() {
            *children = children.union(item.bounds);
        }
        let further = |most: &mut Option<(At, f32)>, inner: &Aabb| {
            if let Some(by) = sticks_out(&parent.bounds, inner)
                && most.is_none_or(|(_, most)| by > most)
            {
                *most = Some((item.at, by));
            }
        };
        further(content, &item.content);
        further(boxed, &item.bounds);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, ChildRef, WideBvh, Width, build};

    fn boxes() -> Vec<Aabb> {
        (0..6).map(|i| Vec3::X * i as f32).map(|min| Aabb::new(min, min + Vec3::ONE)).collect()
    }

    /// A valid tree over `boxes`, then broken.
    fn broken(change: impl FnOnce(&mut WideBvh<2>)) -> Vec<Violation> {
        let config = BuildConfig { width: Width::W2, ..BuildConfig::default() };
        let (tree, _) = build(&boxes(), &config, &Task::new()).expect("not cancelled");
        assert_eq!(validate(&tree, &boxes()), []);
        let Tree::W2(mut bvh) = tree else { panic!("a binary tree") };
        change(&mut bvh);
        validate(&Tree::W2(bvh), &boxes())
    }

    fn kinds(found: &[Violation]) -> Vec<ViolationKind> {
        found.iter().map(Violation::kind).collect()
    }

    #[test]
    fn each_kind_of_damage_is_named() {
        let root = At::Node(0);
        let shrunk = broken(|t| t.nodes[0].sides[3][0] -= 0.5);
        assert!(matches!(shrunk[..], [Violation::NotContained { by: 0.5, .. }, ..]), "{shrunk:?}");
        let grown = broken(|t| t.bounds.max.y += 1.0);
        assert_eq!(grown, [Violation::NotTight { at: root }]);
        let not_finite = broken(|t| t.nodes[0].sides[1][1] = f32::NAN);
        assert_eq!(kinds(&not_finite)[0], ViolationKind::NotFinite, "{not_finite:?}");
        let cycle = broken(|t| t.nodes[0].children[1] = ChildRef::inner(0));
        assert!(cycle.contains(&Violation::ReachedTwice { at: root, parent: root }), "{cycle:?}");
        let outside = broken(|t| t.nodes[0].children[1] = ChildRef::inner(1000));
        assert!(outside.contains(&Violation::BadLink { at: root, slot: 1, value: 1000 }), "{outside:?}");
        let lost_shape = broken(|t| t.refs[1] = t.refs[0]);
        assert!(kinds(&lost_shape).contains(&ViolationKind::ShapeMissing), "{lost_shape:?}");
        let unknown = broken(|t| t.refs[1] = 6);
        assert!(kinds(&unknown).contains(&ViolationKind::ShapeUnknown), "{unknown:?}");
        let twice = broken(|t| {
            let leaf = t.leaves.iter().find(|leaf| leaf.count == 2).expect("a leaf of two");
            t.refs[leaf.first as usize + 1] = t.refs[leaf.first as usize];
        });
        assert!(twice.iter().any(|v| matches!(v, Violation::ShapeRepeated { count: 2, .. })), "{twice:?}");
        let uncovered = broken(|t| {
            let shape = t.refs[0];
            t.refs[1] = shape;
            t.refs[2] = shape;
            for node in &mut t.nodes {
                for slot in 0..2 {
                    if node.children[slot] == ChildRef::leaf(0) {
                        node.sides[0][slot] += 0.5;
                    }
                }
            }
        });
        assert!(uncovered.contains(&Violation::NotCovered { shape: 0 }), "{uncovered:?}");
        let no_leaf = broken(|t| t.leaves[0].first = 77);
        assert!(kinds(&no_leaf).contains(&ViolationKind::BadLeaf), "{no_leaf:?}");
        let empty_leaf = broken(|t| t.leaves[0].count = 0);
        assert!(kinds(&empty_leaf).contains(&ViolationKind::Empty), "{empty_leaf:?}");
        let lost = broken(|t| t.nodes[0].children[1] = ChildRef::EMPTY);
        assert!(kinds(&lost).contains(&ViolationKind::Unreachable), "{lost:?}");
    }

    #[test]
    fn a_box_out_of_its_parent_is_no_fault_while_the_shapes_lie_inside_both() {
        let found = broken(|t| t.nodes[0].sides[1][0] -= 0.25);
        let (child, _) = match found[..] {
            [Violation::ChildSticksOut { at: At::Node(0), child, by }, ref rest @ ..] => {
                assert_eq!(by, 0.25);
                (child, rest)
            }
            _ => panic!("{found:?}"),
        };
        assert!(found.contains(&Violation::NotTight { at: child }), "{found:?}");
        assert!(found.iter().all(|violation| !violation.kind().is_fault()));
    }

    #[test]
    fn kinds_have_names_of_their_own_and_faults_come_first() {
        for (i, kind) in ViolationKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, i);
            assert!(ViolationKind::ALL[..i].iter().all(|other| other.name() != kind.name()));
            assert!(!kind.description().is_empty());
        }
        let faults = ViolationKind::ALL.map(ViolationKind::is_fault);
        assert!(faults.is_sorted_by(|a, b| a >= b), "{faults:?}");
    }
}
