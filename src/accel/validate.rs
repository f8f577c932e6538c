//! Checks a tree against the boxes it was built over.

use glam::Vec3;

use crate::each_width;
use crate::geometry::Aabb;

use super::config::BuildConfig;
use super::tree::{ChildRef, NodeId, Nodes, Tree};

/// One way in which a tree is wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Violation {
    #[error("shape {shape} is in no leaf")]
    ShapeMissing { shape: u32 },
    #[error("shape {shape} is referenced {count} times in leaf {node:?}")]
    ShapeRepeated { shape: u32, count: usize, node: NodeId },
    #[error("the leaves with parts of shape {shape} do not reach all sides of its box")]
    NotCovered { shape: u32 },
    #[error("node {node:?} does not contain what is below it")]
    NotContained { node: NodeId },
    #[error("node {node:?} is larger than what is below it")]
    NotTight { node: NodeId },
    #[error("node {node:?} is at depth {depth}, the limit is 64")]
    TooDeep { node: NodeId, depth: u32 },
    #[error("node {node:?} is reached twice, or its index is out of range")]
    BadLink { node: NodeId },
    #[error("leaf {node:?} is empty or out of range")]
    BadLeaf { node: NodeId },
    #[error("node {node:?} is reached from nowhere")]
    Unreachable { node: NodeId },
}

/// Most violations that are listed.
const MOST: usize = 100;

/// Every violation found, at most a hundred; empty for a valid tree over `boxes`. Broken links are met with a visited
/// set, so any tree can be checked.
pub fn validate(tree: &Tree, boxes: &[Aabb]) -> Vec<Violation> {
    let mut found = Vec::new();
    let counts = check_shapes(tree, boxes.len(), &mut found);
    each_width!(tree, t => check_nodes(t, boxes, &counts, &mut found));
    found.truncate(MOST);
    found
}

/// How many leaves refer to each shape: spatial splits make several, each with a part of it.
fn check_shapes(tree: &Tree, shape_count: usize, found: &mut Vec<Violation>) -> Vec<usize> {
    let mut counts = vec![0_usize; shape_count];
    for (leaf_idx, leaf) in tree.leaf_ranges().iter().enumerate() {
        let range = leaf.first as usize..leaf.first as usize + leaf.count as usize;
        let shapes = tree.refs().get(range).filter(|shapes| !shapes.is_empty());
        let known = shapes.filter(|shapes| shapes.iter().all(|&s| (s as usize) < shape_count));
        let node = NodeId((tree.inner_count() + leaf_idx) as u32);
        let Some(shapes) = known else {
            found.push(Violation::BadLeaf { node });
            continue;
        };
        let mut sorted = shapes.to_vec();
        sorted.sort_unstable();
        for same in sorted.chunk_by(|a, b| a == b) {
            counts[same[0] as usize] += 1;
            if same.len() > 1 {
                found.push(Violation::ShapeRepeated { shape: same[0], count: same.len(), node });
            }
        }
    }
    let missing = counts.iter().enumerate().filter(|(_, count)| **count == 0);
    found.extend(missing.map(|(shape, _)| Violation::ShapeMissing { shape: shape as u32 }));
    counts
}

/// A child slot on the way down: what it points at, the box it claims, the depth.
struct Claim {
    child: ChildRef,
    bounds: Aabb,
    depth: u32,
    /// How much larger the box may be than what is below it.
    slack: Vec3,
}

fn check_nodes<T: Nodes>(bvh: &T, boxes: &[Aabb], counts: &[usize], found: &mut Vec<Violation>) {
    // What the leaves hold of the shapes that are in several.
    let mut covered = vec![Aabb::EMPTY; if counts.iter().any(|&c| c > 1) { boxes.len() } else { 0 }];
    let inner_count = bvh.inner_count();
    let mut seen = vec![false; inner_count + bvh.leaf_count()];
    let mut open = vec![Claim { child: bvh.root(), bounds: bvh.bounds(), depth: 0, slack: Vec3::ZERO }];
    while let Some(Claim { child, bounds, depth, slack }) = open.pop() {
        let Some(node) = bvh.node_id(child) else { continue };
        match seen.get_mut(node.0 as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => {
                found.push(Violation::BadLink { node });
                continue;
            }
        }
        if depth as usize > BuildConfig::MAX_DEPTH {
            found.push(Violation::TooDeep { node, depth });
        }
        let content = match child.as_leaf() {
            Some(leaf_idx) => {
                let mut content = Aabb::EMPTY;
                let mut in_parts = false;
                for &shape in leaf_shapes(bvh, leaf_idx) {
                    let Some(&whole) = boxes.get(shape as usize) else { continue };
                    if counts[shape as usize] == 1 {
                        content = content.union(whole);
                        continue;
                    }
                    in_parts = true;
                    let part = whole.intersection(bounds);
                    covered[shape as usize] = covered[shape as usize].union(part);
                    content = content.union(part);
                }
                // A part of a shape may be smaller than the part of its box.
                if in_parts && bounds.contains(&content) { bounds } else { content }
            }
            None => {
                let slack = bvh.box_slack(node.0);
                open.extend((0..T::WIDTH).map(|slot| {
                    let (child, bounds) = bvh.slot(node.0, slot);
                    Claim { child, bounds, depth: depth + 1, slack }
                }));
                bvh.children(node.0).fold(Aabb::EMPTY, |all, (_, b)| all.union(b))
            }
        };
        if !bounds.contains(&content) {
            found.push(Violation::NotContained { node });
        } else if !is_tight(&bounds, &content, slack) {
            found.push(Violation::NotTight { node });
        }
    }
    let in_parts = covered.iter().enumerate().filter(|(shape, _)| counts[*shape] > 1);
    let uncovered = in_parts.filter(|(shape, covered)| !covered.contains(&boxes[*shape]));
    found.extend(uncovered.map(|(shape, _)| Violation::NotCovered { shape: shape as u32 }));
    let lost = seen.iter().enumerate().filter(|(_, seen)| !**seen);
    found.extend(lost.map(|(id, _)| Violation::Unreachable { node: NodeId(id as u32) }));
}

/// Of a box that contains its content.
fn is_tight(bounds: &Aabb, content: &Aabb, slack: Vec3) -> bool {
    let beyond = (content.min - bounds.min).max(bounds.max - content.max);
    bounds == content || beyond.cmple(slack).all()
}

fn leaf_shapes<T: Nodes>(bvh: &T, leaf_idx: u32) -> &[u32] {
    let leaf = bvh.leaf_range(leaf_idx);
    let range = leaf.first as usize..leaf.first as usize + leaf.count as usize;
    bvh.refs().get(range).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, WideBvh, Width, build};
    use crate::task::Task;

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

    #[test]
    fn each_kind_of_damage_is_named() {
        let shrunk = broken(|t| t.nodes[0].sides[3][0] -= 0.5);
        assert!(matches!(shrunk[..], [Violation::NotContained { .. }, ..]), "{shrunk:?}");
        let grown = broken(|t| t.bounds.max.y += 1.0);
        assert_eq!(grown, [Violation::NotTight { node: NodeId(0) }]);
        let cycle = broken(|t| t.nodes[0].children[1] = ChildRef::inner(0));
        assert!(cycle.contains(&Violation::BadLink { node: NodeId(0) }), "{cycle:?}");
        let outside = broken(|t| t.nodes[0].children[1] = ChildRef::inner(1000));
        assert!(outside.contains(&Violation::BadLink { node: NodeId(1000) }), "{outside:?}");
        let lost_shape = broken(|t| t.refs[1] = t.refs[0]);
        assert!(lost_shape.iter().any(|v| matches!(v, Violation::ShapeMissing { .. })), "{lost_shape:?}");
        let twice = broken(|t| {
            let leaf = t.leaves.iter().find(|leaf| leaf.count == 2).expect("a leaf of two");
            t.refs[leaf.first as usize + 1] = t.refs[leaf.first as usize];
        });
        assert!(twice.iter().any(|v| matches!(v, Violation::ShapeRepeated { count: 2, .. })), "{twice:?}");
        let uncovered = broken(|t| {
            let shape = t.refs[0];
            t.refs[1] = shape;
            for node in &mut t.nodes {
                for slot in 0..2 {
                    if node.children[slot] == ChildRef::leaf(0) {
                        node.sides[0][slot] += 0.5;
                    }
                }
            }
        });
        let expected = Violation::NotCovered { shape: 0 };
        assert!(uncovered.contains(&expected), "{uncovered:?}");
        let empty_leaf = broken(|t| t.leaves[0].count = 0);
        assert!(empty_leaf.iter().any(|v| matches!(v, Violation::BadLeaf { .. })), "{empty_leaf:?}");
        let lost = broken(|t| t.nodes[0].children[1] = ChildRef::EMPTY);
        assert!(lost.iter().any(|v| matches!(v, Violation::Unreachable { .. })), "{lost:?}");
    }
}
