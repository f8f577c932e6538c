//! The lines of an outline of a tree: nodes are opened one by one, so that it does not matter how large the tree is.

use std::collections::HashSet;

use crate::accel::{NodeId, Nodes, Tree};
use crate::each_width;

/// Lines of an outline, parents before their children.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    lines: Vec<OutlineLine>,
    open: HashSet<NodeId>,
}

/// A node of the outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutlineLine {
    pub node: NodeId,
    pub depth: u32,
    pub is_leaf: bool,
}

/// Siblings in order: the largest value first, without one as they lie in their node.
pub type SiblingOrder<'a> = Option<&'a dyn Fn(NodeId) -> f64>;

impl Outline {
    /// With the root alone.
    pub fn new(tree: &Tree) -> Self {
        let mut outline = Self::default();
        if tree.node_count() > 0 {
            outline.lines.push(line(tree, NodeId(0), 0));
        }
        outline
    }

    pub fn lines(&self) -> &[OutlineLine] {
        &self.lines
    }

    pub fn is_open(&self, node: NodeId) -> bool {
        self.open.contains(&node)
    }

    /// Opens or closes the node of a line.
    pub fn toggle(&mut self, tree: &Tree, index: usize, order: SiblingOrder) {
        let Some(&OutlineLine { node, is_leaf, .. }) = self.lines.get(index) else { return };
        if self.open.remove(&node) {
            let below = self.below(index);
            for line in self.lines.drain(below) {
                self.open.remove(&line.node);
            }
        } else if !is_leaf {
            self.open_at(tree, index, order);
        }
    }

    /// Opens all nodes above the last one of a path from the root; answers its line.
    pub fn reveal(&mut self, tree: &Tree, path: &[NodeId], order: SiblingOrder) -> Option<usize> {
        let (node, above) = path.split_last()?;
        for ancestor in above {
            if !self.open.contains(ancestor) {
                let index = self.index_of(*ancestor)?;
                self.open_at(tree, index, order);
            }
        }
        self.index_of(*node)
    }

    /// Opens a node and those below it down to `levels` more, as long as there are fewer than `most` lines.
    pub fn open_below(&mut self, tree: &Tree, index: usize, levels: u32, most: usize, order: SiblingOrder) {
        let Some(top) = self.lines.get(index).copied() else { return };
        let mut at = index;
        while at < self.lines.len() && self.lines.len() < most {
            let line = self.lines[at];
            if at > index && line.depth <= top.depth {
                break;
            }
            if !line.is_leaf && line.depth < top.depth + levels && !self.open.contains(&line.node) {
                self.open_at(tree, at, order);
            }
            at += 1;
        }
    }

    /// Puts the siblings of all open nodes into another order.
    pub fn sort(&mut self, tree: &Tree, order: SiblingOrder) {
        let open = std::mem::take(&mut self.open);
        *self = Self::new(tree);
        let mut at = 0;
        while at < self.lines.len() {
            if open.contains(&self.lines[at].node) {
                self.open_at(tree, at, order);
            }
            at += 1;
        }
    }

    /// The line of a node, if it is shown.
    pub fn index_of(&self, node: NodeId) -> Option<usize> {
        self.lines.iter().position(|line| line.node == node)
    }

    fn open_at(&mut self, tree: &Tree, index: usize, order: SiblingOrder) {
        let OutlineLine { node, depth, is_leaf } = self.lines[index];
        if is_leaf || !self.open.insert(node) {
            return;
        }
        let mut children: Vec<OutlineLine> = each_width!(tree, t => t.children(node.0).map(|(child, _)| line(tree, child, depth + 1)).collect());
        if let Some(value) = order {
            // NaN, nothing to say, comes last.
            let key = |line: &OutlineLine| {
                let value = value(line.node);
                if value.is_nan() { f64::NEG_INFINITY } else { value }
            };
            children.sort_by(|a, b| key(b).total_cmp(&key(a)));
        }
        self.lines.splice(index + 1..index + 1, children);
    }

    /// The lines below that of a node.
    fn below(&self, index: usize) -> std::ops::Range<usize> {
        let depth = self.lines[index].depth;
        let count = self.lines[index + 1..].iter().take_while(|line| line.depth > depth).count();
        index + 1..index + 1 + count
    }
}

fn line(tree: &Tree, node: NodeId, depth: u32) -> OutlineLine {
    OutlineLine { node, depth, is_leaf: tree.leaf_index(node).is_some() }
}

/// What is looked for in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    Node(NodeId),
    Shape(u32),
}

impl Sought {
    /// Reads `12` or `node 12`, `leaf 3` (of the leaves alone), `shape 589`; a word's first letter is enough.
    ///
    /// # Errors
    /// A sentence that says what can be looked for, or what there is.
    pub fn parse(text: &str, tree: &Tree, shape_count: usize) -> Result<Self, String> {
        let text = text.trim().to_lowercase();
        let digits = text.trim_start_matches(|c: char| c.is_alphabetic() || c == '#' || c == ' ');
        let word = text[..text.len() - digits.len()].trim_end_matches([' ', '#']);
        let number = digits.replace(',', "").parse::<u32>();
        let number = number.map_err(|_| format!("'{text}' is not a number: try 12, leaf 3, or shape 589"))?;
        let within = |count: usize, what: &str| {
            if (number as usize) < count {
                Ok(number)
            } else if count == 0 {
                Err(format!("there is no {what}"))
            } else {
                Err(format!("there is no {what} {number}: the last one is {}", count - 1))
            }
        };
        let is = |whole: &str| !word.is_empty() && whole.starts_with(word);
        if word.is_empty() || is("node") {
            within(tree.node_count(), "node").map(|n| Self::Node(NodeId(n)))
        } else if is("leaf") {
            within(tree.leaf_count(), "leaf").map(|n| Self::Node(NodeId(tree.inner_count() as u32 + n)))
        } else if is("shape") || is("triangle") {
            within(shape_count, "shape").map(Self::Shape)
        } else {
            Err(format!("'{word}' is neither node, leaf nor shape"))
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, Family, Width, build};
    use crate::geometry::Aabb;
    use crate::task::Task;

    fn example() -> (Tree, Family) {
        let at = |i: usize| Vec3::new((i * 7 % 13) as f32, (i * 5 % 17) as f32, (i * 3 % 11) as f32);
        let boxes: Vec<Aabb> = (0..200).map(|i| Aabb::new(at(i), at(i) + Vec3::ONE)).collect();
        let config = BuildConfig { width: Width::W4, ..BuildConfig::default() };
        let (tree, _) = build(&boxes, &config, &Task::new()).expect("nobody cancels");
        let family = Family::of(&tree, &Task::new()).expect("nobody cancels");
        (tree, family)
    }

    #[test]
    fn nodes_open_and_close() {
        let (tree, family) = example();
        let mut outline = Outline::new(&tree);
        assert_eq!(outline.lines().len(), 1);
        outline.toggle(&tree, 0, None);
        let children = outline.lines()[1..].to_vec();
        assert!(children.iter().all(|l| l.depth == 1 && family.parent(l.node) == Some(NodeId(0))));
        let inner = (1..outline.lines().len()).find(|&i| !outline.lines()[i].is_leaf).expect("inner nodes");
        outline.toggle(&tree, inner, None);
        assert!(outline.lines().len() > children.len() + 1);
        outline.toggle(&tree, 0, None);
        assert_eq!(outline.lines().len(), 1);
        outline.toggle(&tree, 0, None);
        assert_eq!(outline.lines()[1..], children, "what was open below is closed");
    }

    #[test]
    fn a_node_deep_down_is_revealed() {
        let (tree, family) = example();
        for leaf_idx in [0, tree.leaf_count() as u32 / 2, tree.leaf_count() as u32 - 1] {
            let mut outline = Outline::new(&tree);
            let node = NodeId(tree.inner_count() as u32 + leaf_idx);
            let at = outline.reveal(&tree, &family.path(node), None).expect("it is there");
            assert_eq!(outline.lines()[at].node, node);
            assert_eq!(outline.reveal(&tree, &family.path(node), None), Some(at));
        }
    }

    #[test]
    fn everything_can_be_opened_and_sorted() {
        let (tree, family) = example();
        let mut outline = Outline::new(&tree);
        outline.open_below(&tree, 0, u32::MAX - 1, usize::MAX, None);
        assert_eq!(outline.lines().len(), tree.node_count());
        let references = |node: NodeId| f64::from(family.references(node));
        outline.sort(&tree, Some(&references));
        assert_eq!(outline.lines().len(), tree.node_count());
        let first: Vec<f64> =
            outline.lines().iter().filter(|l| l.depth == 1).map(|l| references(l.node)).collect();
        assert!(first.windows(2).all(|pair| pair[0] >= pair[1]), "{first:?}");
        let mut few = Outline::new(&tree);
        few.open_below(&tree, 0, 1, usize::MAX, None);
        assert!(few.lines().iter().all(|l| l.depth <= 1));
    }

    #[test]
    fn what_is_sought_is_read_and_checked() {
        let (tree, _) = example();
        let leaf = NodeId(tree.inner_count() as u32 + 3);
        for (text, expected) in [
            ("12", Sought::Node(NodeId(12))),
            (" Node 12 ", Sought::Node(NodeId(12))),
            ("n12", Sought::Node(NodeId(12))),
            ("#12", Sought::Node(NodeId(12))),
            ("leaf 3", Sought::Node(leaf)),
            ("shape 199", Sought::Shape(199)),
            ("s 1", Sought::Shape(1)),
            ("triangle 7", Sought::Shape(7)),
        ] {
            assert_eq!(Sought::parse(text, &tree, 200), Ok(expected), "{text}");
        }
        for (text, says) in [
            ("", "not a number"),
            ("shape", "not a number"),
            ("shape 200", "the last one is 199"),
            ("99999", "the last one is"),
            ("ray 3", "neither node"),
            ("-3", "not a number"),
        ] {
            let error = Sought::parse(text, &tree, 200).expect_err(text);
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
