//! Where siblings overlap most: the pairs of a tree in order.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use crate::accel::{NodeId, Nodes, Tree};
use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// Inner nodes that one thread looks at between two looks for a cancel.
const CHUNK: usize = 4096;

/// Two children of a node whose boxes overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlappingPair {
    pub parent: NodeId,
    pub a: NodeId,
    pub b: NodeId,
    /// What both boxes cover.
    pub common: Aabb,
    /// Area of `common` / area of the root's box: how likely a line that hits the root hits both boxes' common part.
    pub of_root: f64,
    /// Area of `common` / area of the parent's box.
    pub of_parent: f64,
}

/// By which pairs are put in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OverlapMeasure {
    /// What it costs the rays: large boxes count more.
    #[default]
    OfRoot,
    /// How bad a split is by itself: small boxes count as much.
    OfParent,
}

impl OverlapMeasure {
    pub const ALL: [Self; 2] = [Self::OfRoot, Self::OfParent];

    pub fn name(self) -> &'static str {
        match self {
            Self::OfRoot => "of the root",
            Self::OfParent => "of the parent",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::OfRoot => "area of the common box / area of the root's box: what it costs the rays",
            Self::OfParent => {
                "area of the common box / area of the parent's box: how bad the split is by itself"
            }
        }
    }

    pub fn of(self, pair: &OverlappingPair) -> f64 {
        match self {
            Self::OfRoot => pair.of_root,
            Self::OfParent => pair.of_parent,
        }
    }
}

/// A pair in a heap that keeps the largest: of equal ones that with the smaller numbers is larger.
#[derive(Clone, Copy, Debug)]
struct Ranked {
    measure: f64,
    pair: OverlappingPair,
}

impl Ranked {
    fn key(&self) -> (Reverse<u32>, Reverse<u32>) {
        (Reverse(self.pair.a.0), Reverse(self.pair.b.0))
    }
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ranked {}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.measure.total_cmp(&other.measure).then(self.key().cmp(&other.key()))
    }
}

/// The `most` pairs of siblings that overlap most, the worst first. Boxes that only touch do not overlap. The same pairs at
/// any number of threads.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn worst_pairs(
    tree: &Tree,
    measure: OverlapMeasure,
    most: usize,
    task: &Task,
) -> Result<Vec<OverlappingPair>, Cancelled> {
    let root_area = f64::from(tree.bounds().area());
    if root_area == 0.0 || most == 0 {
        return Ok(Vec::new());
    }
    let chunks = tree.inner_count().div_ceil(CHUNK);
    let found: Vec<BinaryHeap<Reverse<Ranked>>> = (0..chunks)
        .into_par_iter()
        .map(|chunk| {
            task.check()?;
            let nodes = chunk * CHUNK..((chunk + 1) * CHUNK).min(tree.inner_count());
            let mut heap = BinaryHeap::new();
            for node_idx in nodes {
                each_width!(tree, t => pairs_of(t, node_idx as u32, root_area, &mut |pair| {
                    keep(&mut heap, Ranked { measure: measure.of(&pair), pair }, most);
                }));
            }
            Ok(heap)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut all = BinaryHeap::new();
    for Reverse(ranked) in found.into_iter().flatten() {
        keep(&mut all, ranked, most);
    }
    let mut all: Vec<Ranked> = all.into_iter().map(|Reverse(ranked)| ranked).collect();
    all.sort_unstable_by(|a, b| b.cmp(a));
    Ok(all.into_iter().map(|ranked| ranked.pair).collect())
}

fn keep(heap: &mut BinaryHeap<Reverse<Ranked>>, ranked: Ranked, most: usize) {
    if heap.len() < most {
        heap.push(Reverse(ranked));
    } else if heap.peek().is_some_and(|Reverse(least)| *least < ranked) {
        heap.pop();
        heap.push(Reverse(ranked));
    }
}

fn pairs_of<T: Nodes>(tree: &T, node_idx: u32, root_area: f64, found: &mut impl FnMut(OverlappingPair)) {
    let children: Vec<(NodeId, Aabb)> = tree.children(node_idx).collect();
    let own = children.iter().fold(Aabb::EMPTY, |all, (_, bounds)| all.union(*bounds)).area();
    for (i, (a, a_bounds)) in children.iter().enumerate() {
        for (b, b_bounds) in &children[i + 1..] {
            let common = a_bounds.intersection(*b_bounds);
            if common.is_empty() || common.extent().min_element() <= 0.0 {
                continue;
            }
            let area = f64::from(common.area());
            found(OverlappingPair {
                parent: NodeId(node_idx),
                a: *a,
                b: *b,
                common,
                of_root: area / root_area,
                of_parent: if own > 0.0 { area / f64::from(own) } else { 0.0 },
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, build};

    #[test]
    fn the_worst_pairs_are_those_of_sorting_all() {
        let at = |i: usize| Vec3::new((i * 7 % 13) as f32, (i * 5 % 17) as f32, (i * 3 % 11) as f32);
        let boxes: Vec<Aabb> = (0..400).map(|i| Aabb::new(at(i), at(i) + Vec3::splat(2.5))).collect();
        for &(width, layout) in &BuildConfig::NODES {
            let config = BuildConfig { width, layout, ..BuildConfig::default() };
            let tree = build(&boxes, &config, &Task::new()).expect("nobody cancels").0;
            let mut all = Vec::new();
            tree.walk(|node| {
                if let crate::accel::NodeKind::Inner(children) = &node.kind {
                    for (i, (a, a_box)) in children.iter().enumerate() {
                        for (b, b_box) in &children[i + 1..] {
                            let common = a_box.intersection(*b_box);
                            if !common.is_empty() && common.extent().min_element() > 0.0 {
                                all.push((common.area(), a.0, b.0));
                            }
                        }
                    }
                }
                true
            });
            all.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)).then(x.2.cmp(&y.2)));
            for most in [1, 10, all.len() + 5] {
                let worst = worst_pairs(&tree, OverlapMeasure::OfRoot, most, &Task::new());
                let worst: Vec<_> = worst.expect("nobody cancels").iter().map(|p| (p.a.0, p.b.0)).collect();
                let expected: Vec<_> = all.iter().take(most).map(|x| (x.1, x.2)).collect();
                assert_eq!(worst, expected);
            }
        }
    }

    #[test]
    fn boxes_that_touch_do_not_overlap() {
        let boxes: Vec<Aabb> =
            (0..8).map(|i| Vec3::X * i as f32).map(|p| Aabb::new(p, p + Vec3::ONE)).collect();
        let (tree, _) = build(&boxes, &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        assert!(worst_pairs(&tree, OverlapMeasure::OfParent, 9, &Task::new()).expect("done").is_empty());
    }
}
