//! Refitting: a tree for shapes that have moved, of the same nodes, with boxes that fit again. Much cheaper than a build, but
//! the tree decays, because nodes stay together that have moved apart.

use rayon::prelude::*;

use crate::accel::build::Shapes;
use crate::accel::compressed::CompressedBvh;
use crate::accel::tree::{ChildRef, Nodes, Tree, WideBvh, WideNode};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// The same tree over other boxes of the same shapes: each node's box is what its children's need together, from the leaves
/// up. A shape that was cut in parts counts with all of its box wherever it is referenced. The answer does not depend on
/// the boxes that the tree had.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// If the tree names a shape that is not there.
pub fn refit<B: Shapes + ?Sized>(tree: &Tree, shapes: &B, task: &Task) -> Result<Tree, Cancelled> {
    Ok(match tree {
        Tree::W2(tree) => Tree::W2(fitted(tree, shapes, task)?),
        Tree::W4(tree) => Tree::W4(fitted(tree, shapes, task)?),
        Tree::W8(tree) => Tree::W8(fitted(tree, shapes, task)?),
        Tree::W16(tree) => Tree::W16(fitted(tree, shapes, task)?),
        // The grids of compressed nodes follow the boxes.
        Tree::C8(tree) => Tree::C8(CompressedBvh::new(&fitted(tree, shapes, task)?)),
    })
}

fn fitted<const N: usize, T: Nodes, B: Shapes + ?Sized>(
    tree: &T,
    shapes: &B,
    task: &Task,
) -> Result<WideBvh<N>, Cancelled> {
    task.check()?;
    let refs = tree.refs();
    let leaves: Vec<_> = (0..tree.leaf_count() as u32).map(|leaf_idx| tree.leaf_range(leaf_idx)).collect();
    let leaf_bounds = leaves.par_iter().map(|leaf| {
        let shapes_of_leaf = &refs[leaf.first as usize..][..leaf.count as usize];
        shapes_of_leaf.iter().fold(Aabb::EMPTY, |all, &shape| all.union(shapes.bounds(shape)))
    });
    let leaf_bounds: Vec<Aabb> = leaf_bounds.collect();
    task.check()?;
    let mut nodes = vec![WideNode::<N>::EMPTY; tree.inner_count()];
    let mut inner_bounds = vec![Aabb::EMPTY; nodes.len()];
    // Parents come before their children, so from the end on all children are known.
    for (node_idx, node) in nodes.iter_mut().enumerate().rev() {
        let mut bounds = Aabb::EMPTY;
        for slot in 0..N {
            let child = tree.slot(node_idx as u32, slot).0;
            let Some(child_bounds) = bounds_of(child, &inner_bounds, &leaf_bounds) else { continue };
            node.children[slot] = child;
            node.set_bounds(slot, &child_bounds);
            bounds = bounds.union(child_bounds);
        }
        inner_bounds[node_idx] = bounds;
    }
    Ok(WideBvh {
        root: tree.root(),
        bounds: bounds_of(tree.root(), &inner_bounds, &leaf_bounds).unwrap_or(Aabb::EMPTY),
        nodes,
        leaves,
        refs: refs.to_vec(),
        depth_max: tree.depth_max(),
    })
}

fn bounds_of(child: ChildRef, inner_bounds: &[Aabb], leaf_bounds: &[Aabb]) -> Option<Aabb> {
    let inner = child.as_inner().map(|node_idx| inner_bounds[node_idx as usize]);
    inner.or_else(|| child.as_leaf().map(|leaf_idx| leaf_bounds[leaf_idx as usize]))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::validate::validate;
    use crate::accel::{BuildConfig, Builder, build};

    fn boxes(count: u32, at: impl Fn(u32) -> Vec3) -> Vec<Aabb> {
        (0..count).map(|i| Aabb { min: at(i), max: at(i) + Vec3::splat(0.3) }).collect()
    }

    fn lattice(i: u32) -> Vec3 {
        Vec3::new((i % 7) as f32, (i / 7 % 5) as f32, (i / 35) as f32)
    }

    #[test]
    fn a_refitted_tree_is_valid_and_keeps_its_nodes() {
        let still = boxes(300, lattice);
        let moved = boxes(300, |i| lattice(i) * Vec3::new(1.0, -2.0, 0.5) + Vec3::X * (i as f32 * 1.7).sin());
        for builder in Builder::ALL {
            for (width, layout) in BuildConfig::NODES {
                let config = BuildConfig { builder, width, layout, ..BuildConfig::default() };
                let tree = build(&still, &config, &Task::new()).expect("not cancelled").0;
                let fitted = refit(&tree, &moved[..], &Task::new()).expect("not cancelled");
                assert_eq!(fitted.refs(), tree.refs());
                assert_eq!(fitted.leaf_ranges(), tree.leaf_ranges());
                assert_eq!(validate(&fitted, &moved), [], "{config:?}");
                let back = refit(&fitted, &still[..], &Task::new()).expect("not cancelled");
                if !config.duplicates() {
                    assert_eq!(back, tree, "{config:?}: where nothing has moved the tree stays");
                }
                let again = refit(&back, &moved[..], &Task::new()).expect("not cancelled");
                assert_eq!(again, fitted, "the boxes before do not matter");
            }
        }
    }

    #[test]
    fn nothing_and_a_single_leaf_are_refitted_too() {
        let config = BuildConfig::default();
        for count in [0, 1] {
            let still = boxes(count, lattice);
            let moved = boxes(count, |_| Vec3::ONE);
            let tree = build(&still, &config, &Task::new()).expect("not cancelled").0;
            let fitted = refit(&tree, &moved[..], &Task::new()).expect("not cancelled");
            assert_eq!(fitted.bounds(), moved.first().copied().unwrap_or(Aabb::EMPTY));
        }
    }

    #[test]
    fn a_cancel_ends_it() {
        let still = boxes(50, lattice);
        let tree = build(&still, &BuildConfig::default(), &Task::new()).expect("not cancelled").0;
        let task = Task::new();
        task.cancel();
        assert!(refit(&tree, &still[..], &task).is_err());
    }
}
