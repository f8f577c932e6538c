//! Rotations: a child changes places with a grandchild of the other side, or two grandchildren with each other, where that
//! makes the boxes between smaller (Kensler, "Tree Rotations for Improving Bounding Volume Hierarchies", 2008).
//!
//! A round visits every node once, from the leaves upwards, and makes the best of its six rotations: the paper's hill
//! climbing.

use crate::accel::bvh2::Bvh2Node;
use crate::accel::config::BuildConfig;
use crate::task::{Cancelled, Task};

/// Nodes between two looks at the cancel flag.
const CHECK_EVERY: usize = 4096;

/// Two nodes that change places.
#[derive(Clone, Copy, Debug)]
struct Swap {
    a: u32,
    b: u32,
    /// By how much the sum of the half areas of the children falls.
    gain: f32,
}

/// The nodes after one round, in any order; `None` if nothing was rotated. They must be in depth-first order.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn round(
    nodes: &[Bvh2Node],
    _config: &BuildConfig,
    task: &Task,
) -> Result<Option<Vec<Bvh2Node>>, Cancelled> {
    let mut nodes = nodes.to_vec();
    let mut rotated = false;
    // Children have higher indices than their parents, and what is below a node changes places only among itself.
    for node_idx in (0..nodes.len()).rev() {
        if node_idx % CHECK_EVERY == 0 {
            task.check()?;
        }
        if let Some(Swap { a, b, .. }) = best_swap(&nodes, node_idx as u32) {
            nodes.swap(a as usize, b as usize);
            for child in nodes[node_idx].children() {
                fit(&mut nodes, child);
            }
            rotated = true;
        }
    }
    Ok(rotated.then_some(nodes))
}

/// The rotation below a node that gains most, the first of equal ones; `None` if none gains anything.
fn best_swap(nodes: &[Bvh2Node], node_idx: u32) -> Option<Swap> {
    let node = |node_idx: u32| &nodes[node_idx as usize];
    if node(node_idx).is_leaf() {
        return None;
    }
    let area = |a: u32, b: u32| node(a).bounds.union(node(b).bounds).half_area();
    let children = node(node_idx).children();
    let below = children.map(|child| (!node(child).is_leaf()).then(|| node(child).children()));
    let mut best = Swap { a: 0, b: 0, gain: 0.0 };
    let mut consider = |a, b, before: f32, after: f32| {
        if before - after > best.gain {
            best = Swap { a, b, gain: before - after };
        }
    };
    let areas = children.map(|child| node(child).bounds.half_area());
    for (side, pair) in below.iter().enumerate() {
        let (Some([first, second]), other) = (*pair, children[1 - side]) else { continue };
        consider(other, first, areas[side], area(other, second));
        consider(other, second, areas[side], area(first, other));
    }
    if let [Some([a, b]), Some([c, d])] = below {
        let before = areas[0] + areas[1];
        consider(a, c, before, area(c, b) + area(a, d));
        consider(a, d, before, area(d, b) + area(c, a));
    }
    (best.gain > 0.0).then_some(best)
}

/// Fits the box of an inner node to its children.
fn fit(nodes: &mut [Bvh2Node], node_idx: u32) {
    let node = nodes[node_idx as usize];
    if !node.is_leaf() {
        let [left, right] = node.children().map(|child| nodes[child as usize].bounds);
        nodes[node_idx as usize].bounds = left.union(right);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng};

    use super::super::{improve, sum_of_areas};
    use super::*;
    use crate::accel::build::Onlooker;
    use crate::accel::bvh2::Bvh2;
    use crate::accel::{Builder, Improver, Tree, Width, build};
    use crate::geometry::Aabb;

    fn built(count: usize) -> Bvh2 {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
        let mut point = |size: f32| Vec3::from_array(std::array::from_fn(|_| size * rng.random::<f32>()));
        let boxes: Vec<_> = (0..count)
            .map(|_| {
                let min = point(10.0);
                Aabb::new(min, min + point(1.0))
            })
            .collect();
        let config =
            BuildConfig { builder: Builder::Random, width: Width::W2, leaf: 1, ..BuildConfig::default() };
        match build(&boxes, &config, &Task::new()) {
            Ok((Tree::W2(tree), _)) => Bvh2::from_wide(&tree),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_rotation_gains_what_it_says_and_no_other_gains_more() {
        let bvh = built(60);
        let before = sum_of_areas(&bvh.nodes);
        let mut found = 0;
        for node_idx in 0..bvh.nodes.len() as u32 {
            let node = &bvh.nodes[node_idx as usize];
            if node.is_leaf() {
                continue;
            }
            // What is swapped with what, tried one by one.
            let children = node.children();
            let grandchildren = children.map(|child| {
                let child = &bvh.nodes[child as usize];
                if child.is_leaf() { Vec::new() } else { child.children().to_vec() }
            });
            let mut swaps = Vec::new();
            for side in 0..2 {
                swaps.extend(grandchildren[side].iter().map(|&b| (children[1 - side], b)));
            }
            swaps
                .extend(grandchildren[0].iter().flat_map(|&a| grandchildren[1].iter().map(move |&b| (a, b))));
            let fallen = |(a, b): (u32, u32)| {
                let mut nodes = bvh.nodes.clone();
                nodes.swap(a as usize, b as usize);
                children.into_iter().for_each(|child| fit(&mut nodes, child));
                before - sum_of_areas(&nodes)
            };
            let most = swaps.into_iter().map(fallen).fold(0.0, f64::max);
            let gain = best_swap(&bvh.nodes, node_idx).map_or(0.0, |swap| f64::from(swap.gain));
            assert!((gain - most).abs() < 1e-5 * before, "{node_idx}: {gain}, not {most}");
            found += usize::from(gain > 0.0);
        }
        assert!(found > 10);
    }

    #[test]
    fn rounds_lower_the_cost_until_nothing_is_left() {
        let mut bvh = built(800);
        let mut shapes = bvh.refs.clone();
        let config = BuildConfig { improver: Improver::Rotations, rounds: 1000, ..BuildConfig::default() };
        let costs = improve(&mut bvh, &config, &mut Onlooker::nobody(), &Task::new()).expect("not cancelled");
        let costs: Vec<f64> = costs.into_iter().flatten().collect();
        assert!(costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
        assert!((3..1000).contains(&costs.len()), "it ends by itself: {}", costs.len());
        assert!(costs[costs.len() - 1] < 0.6 * costs[0], "{costs:?}");
        let mut kept = bvh.refs.clone();
        shapes.sort_unstable();
        kept.sort_unstable();
        assert_eq!(kept, shapes);
    }

    #[test]
    fn a_cancel_stops_it() {
        let task = Task::new();
        task.cancel();
        let config = BuildConfig { improver: Improver::Rotations, ..BuildConfig::default() };
        assert_eq!(improve(&mut built(9), &config, &mut Onlooker::nobody(), &task), Err(Cancelled));
    }
}
