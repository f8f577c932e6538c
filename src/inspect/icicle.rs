//! An icicle plot of a tree: a row a depth, every node as wide as its share of some weight, its children below it. Only what
//! can be seen is laid out, so that it does not matter how large the tree is. (Kruskal and Landwehr, "Icicle Plots: Better
//! Displays for Hierarchical Clustering", 1983.)

use crate::accel::{Family, NodeId, Nodes, Tree};
use crate::each_width;

/// What is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IcicleWindow {
    /// The part of the root's width, in 0..=1.
    pub from: f64,
    pub to: f64,
    /// A node that is narrower than this share of the root's width is drawn together with its neighbours.
    pub least: f64,
    /// The depths, both included.
    pub depths: [u32; 2],
}

/// A node of the plot, or several that are too narrow to be told apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IcicleCell {
    /// The only node, or the widest of several.
    pub node: NodeId,
    /// Nodes of this depth in it.
    pub count: u32,
    pub depth: u32,
    /// In 0..=1 of the root's width.
    pub from: f64,
    pub to: f64,
}

/// The cells that can be seen, row by row within each branch. `weight`: of a node and all below it, at least the sum of its
/// children's.
pub fn cells(tree: &Tree, weight: &impl Fn(NodeId) -> f64, window: &IcicleWindow) -> Vec<IcicleCell> {
    let mut cells = Vec::new();
    let total = if tree.node_count() > 0 { weight(NodeId(0)) } else { 0.0 };
    if total <= 0.0 {
        return cells;
    }
    let root = IcicleCell { node: NodeId(0), count: 1, depth: 0, from: 0.0, to: 1.0 };
    let mut open = vec![root];
    while let Some(cell) = open.pop() {
        if cell.depth >= window.depths[0] {
            cells.push(cell);
        }
        let is_inner = (cell.node.0 as usize) < tree.inner_count();
        let can_be_told_apart = cell.count == 1 && cell.to - cell.from >= window.least;
        if can_be_told_apart && is_inner && cell.depth < window.depths[1] {
            each_width!(tree, t => lay_out(t, &cell, weight, total, window, &mut open));
        }
    }
    cells
}

/// The children of a cell's node that can be seen.
fn lay_out<T: Nodes>(
    tree: &T,
    parent: &IcicleCell,
    weight: &impl Fn(NodeId) -> f64,
    total: f64,
    window: &IcicleWindow,
    open: &mut Vec<IcicleCell>,
) {
    let mut from = parent.from;
    // Neighbours that are too narrow, with the widest one's width.
    let mut narrow: Option<(IcicleCell, f64)> = None;
    for (node, _) in tree.children(parent.node.0) {
        let width = weight(node) / total;
        let cell = IcicleCell { node, count: 1, depth: parent.depth + 1, from, to: from + width };
        from = cell.to;
        if cell.to < window.from || cell.from > window.to {
            continue;
        }
        if width >= window.least {
            open.extend(narrow.take().map(|(cell, _)| cell));
            open.push(cell);
            continue;
        }
        narrow = Some(match narrow {
            Some((together, widest)) => {
                let node = if width > widest { node } else { together.node };
                let together = IcicleCell { node, count: together.count + 1, to: cell.to, ..together };
                (together, widest.max(width))
            }
            None => (cell, width),
        });
    }
    open.extend(narrow.map(|(cell, _)| cell));
}

/// Where a node lies, in 0..=1 of the root's width; `None` where the root has no weight.
pub fn place(
    tree: &Tree,
    family: &Family,
    weight: &impl Fn(NodeId) -> f64,
    node: NodeId,
) -> Option<[f64; 2]> {
    let path = family.path(node);
    let total = weight(NodeId(0));
    if total <= 0.0 {
        return None;
    }
    let mut from = 0.0;
    for pair in path.windows(2) {
        let before = each_width!(tree, t => {
            let elder = t.children(pair[0].0).map(|(child, _)| child).take_while(|child| *child != pair[1]);
            elder.map(weight).sum::<f64>()
        });
        from += before / total;
    }
    Some([from, from + weight(node) / total])
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, build};
    use crate::geometry::Aabb;
    use crate::task::Task;

    const ALL: IcicleWindow = IcicleWindow { from: 0.0, to: 1.0, least: 0.0, depths: [0, u32::MAX] };

    fn example() -> (Tree, Family) {
        let at = |i: usize| Vec3::new((i * 7 % 13) as f32, (i * 5 % 17) as f32, (i * 3 % 11) as f32);
        let boxes: Vec<Aabb> = (0..500).map(|i| Aabb::new(at(i), at(i) + Vec3::ONE)).collect();
        let (tree, _) = build(&boxes, &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let family = Family::of(&tree, &Task::new()).expect("nobody cancels");
        (tree, family)
    }

    #[test]
    fn every_node_lies_below_its_parent_and_is_as_wide_as_its_share() {
        let (tree, family) = example();
        let weight = |node| f64::from(family.references(node));
        let cells = cells(&tree, &weight, &ALL);
        assert_eq!(cells.len(), tree.node_count());
        let mut by_node = vec![None; tree.node_count()];
        for cell in &cells {
            by_node[cell.node.0 as usize] = Some(*cell);
        }
        for cell in &cells {
            let share = weight(cell.node) / 500.0;
            assert!((cell.to - cell.from - share).abs() < 1e-9 && cell.count == 1);
            assert_eq!(cell.depth, family.depth(cell.node));
            let [from, to] = place(&tree, &family, &weight, cell.node).expect("the root has shapes");
            assert!((from - cell.from).abs() < 1e-9 && (to - cell.to).abs() < 1e-9);
            if let Some(parent) = family.parent(cell.node) {
                let parent = by_node[parent.0 as usize].expect("all are there");
                assert!(parent.from <= cell.from + 1e-9 && cell.to <= parent.to + 1e-9);
            }
        }
    }

    #[test]
    fn what_cannot_be_seen_is_not_laid_out() {
        let (tree, family) = example();
        let weight = |node| f64::from(family.references(node));
        let window = IcicleWindow { from: 0.25, to: 0.5, least: 0.02, depths: [1, 4] };
        let cells = cells(&tree, &weight, &window);
        assert!(!cells.is_empty() && cells.len() < 60);
        for cell in &cells {
            assert!(cell.to >= 0.25 && cell.from <= 0.5 && (1..=4).contains(&cell.depth));
            if let Some(parent) = family.parent(cell.node).filter(|_| cell.depth > 1) {
                assert!(weight(parent) / 500.0 >= 0.02, "nothing is shown below what is too narrow");
            }
        }
        // Without gaps: the cells of a row cover the window where their parents do.
        let row: f64 = cells.iter().filter(|c| c.depth == 1).map(|c| c.to.min(0.5) - c.from.max(0.25)).sum();
        assert!((row - 0.25).abs() < 1e-9, "{row}");
    }

    #[test]
    fn a_tree_without_weight_has_no_cells() {
        let (tree, _) = example();
        assert!(cells(&tree, &|_| 0.0, &ALL).is_empty());
    }
}
