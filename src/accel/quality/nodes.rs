//! What the boxes alone tell of every single node: a number each, by [`NodeId`](crate::accel::NodeId), NaN where it is
//! undefined.

use super::siblings::{empty_space, overlap};
use super::{FILL_LANES, MOST_CHILDREN};
use crate::accel::tree::{Nodes, Tree, Visit};
use crate::each_width;
use crate::geometry::Aabb;

/// Every node's own share of the SAH cost: `C * A / A_root / cost`, C = `C_t` for an inner node, `C_i * N` for a leaf. The
/// shares add up to 1; all are 0 where the cost is undefined or 0.
pub fn sah_shares(tree: &Tree, traversal_cost: f32, intersection_cost: f32) -> Vec<f32> {
    let mut costs = vec![0.0_f64; tree.node_count()];
    tree.walk_nodes(|Visit { id, bounds, .. }| {
        let weight = match tree.leaf_index(id) {
            Some(leaf_idx) => f64::from(intersection_cost) * f64::from(tree.leaf_range(leaf_idx).count),
            None => f64::from(traversal_cost),
        };
        costs[id.0 as usize] = weight * f64::from(bounds.area());
        true
    });
    let total: f64 = costs.iter().sum();
    costs.into_iter().map(|cost| if total > 0.0 { (cost / total) as f32 } else { 0.0 }).collect()
}

/// References in a leaf.
pub fn leaf_sizes(tree: &Tree) -> Vec<f32> {
    of_nodes(tree, |_| f32::NAN, |size| size as f32)
}

/// Of an inner node: the overlap of its children, `sum over pairs of area(box_i ∩ box_j) / area(its box)`.
pub fn overlaps(tree: &Tree) -> Vec<f32> {
    of_nodes(tree, |children| overlap(children) as f32, |_| f32::NAN)
}

/// Of an inner node: `1 - volume of the union of its children's boxes / volume of its own`.
pub fn empty_spaces(tree: &Tree) -> Vec<f32> {
    of_nodes(tree, |children| empty_space(children).map_or(f32::NAN, |x| x as f32), |_| f32::NAN)
}

/// How full a node is: of an inner node the share of its slots with a child, of a leaf the share of lanes with a
/// reference, where [`FILL_LANES`] of them are tested at once.
pub fn fills(tree: &Tree) -> Vec<f32> {
    let width = tree.width() as f32;
    of_nodes(
        tree,
        |children| children.len() as f32 / width,
        |size| size as f32 / (size.div_ceil(FILL_LANES) * FILL_LANES) as f32,
    )
}

/// A number of the children's boxes for each inner node, and one of the number of references for each leaf.
fn of_nodes(tree: &Tree, inner: impl Fn(&[Aabb]) -> f32, leaf: impl Fn(usize) -> f32) -> Vec<f32> {
    let mut values = Vec::with_capacity(tree.node_count());
    for node_idx in 0..tree.inner_count() as u32 {
        let (mut boxes, mut count) = ([Aabb::EMPTY; MOST_CHILDREN], 0);
        each_width!(tree, t => for (_, bounds) in t.children(node_idx) {
            boxes[count] = bounds;
            count += 1;
        });
        values.push(inner(&boxes[..count]));
    }
    let sizes = (0..tree.leaf_count() as u32).map(|leaf_idx| tree.leaf_range(leaf_idx).count as usize);
    values.extend(sizes.map(leaf));
    values
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, Width, build};
    use crate::task::Task;

    /// Five unit cubes in a row, a gap of one between them.
    fn tree(width: Width, leaf: usize) -> Tree {
        let at = |i: usize| Vec3::X * (2.0 * i as f32);
        let boxes: Vec<_> = (0..5).map(|i| Aabb::new(at(i), at(i) + Vec3::ONE)).collect();
        let config = BuildConfig { width, leaf, ..BuildConfig::default() };
        build(&boxes, &config, &Task::new()).expect("nobody cancels").0
    }

    #[test]
    fn shares_add_up_to_one() {
        let tree = tree(Width::W8, 2);
        let shares = sah_shares(&tree, 1.0, 2.0);
        assert_eq!(shares.len(), tree.node_count());
        assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_row_of_cubes_done_by_hand() {
        let wide = tree(Width::W8, 1);
        assert_eq!((wide.inner_count(), wide.leaf_count()), (1, 5));
        // Five of nine units are full.
        assert!((empty_spaces(&wide)[0] - 4.0 / 9.0).abs() < 1e-6);
        assert_eq!((overlaps(&wide)[0], fills(&wide)[0], fills(&wide)[1]), (0.0, 5.0 / 8.0, 0.25));
        assert!(leaf_sizes(&wide)[0].is_nan() && overlaps(&wide)[1].is_nan());
        assert_eq!(leaf_sizes(&wide)[1..], [1.0; 5]);
        let full = tree(Width::W2, 5);
        assert_eq!((full.inner_count(), fills(&full)), (0, vec![5.0 / 8.0]));
    }
}
