//! Every builder, width and way of widening on many kinds of boxes; determinism; builders against slow searches.

mod builders;

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::bound::Bound;
use super::*;
use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::{Block, Improver, Morton, StopRule, Widen};
use crate::accel::quality::TreeFigures;
use crate::accel::validate::validate;
use crate::accel::widen::widen;

fn rng() -> Pcg32 {
    Pcg32::seed_from_u64(7)
}

fn random_boxes(count: usize, extent: f32, size: f32) -> Vec<Aabb> {
    let mut rng = rng();
    let mut unit = move || Vec3::new(rng.random(), rng.random(), rng.random());
    (0..count)
        .map(|_| {
            let min = (unit() - 0.5) * extent;
            Aabb::new(min, min + unit() * size)
        })
        .collect()
}

/// Boxes that builders find hard, by name.
fn hard_cases() -> Vec<(&'static str, Vec<Aabb>)> {
    let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
    let at = |p: Vec3| Aabb::new(p, p);
    vec![
        ("none", vec![]),
        ("one", vec![unit]),
        ("two", vec![unit, at(Vec3::ONE)]),
        ("random", random_boxes(700, 10.0, 1.0)),
        ("points", random_boxes(300, 10.0, 0.0)),
        ("identical", vec![unit; 500]),
        (
            "same middle",
            (1..200)
                .map(|i| Aabb::EMPTY.union(at(Vec3::splat(i as f32))).union(at(Vec3::splat(-i as f32))))
                .collect(),
        ),
        ("line", (0..300).map(|i| at(Vec3::X * i as f32)).collect()),
        (
            "flat",
            random_boxes(300, 5.0, 1.0)
                .iter()
                .map(|b| Aabb::new(b.min.with_z(0.0), b.max.with_z(0.0)))
                .collect(),
        ),
        ("huge", random_boxes(300, 1e17, 1e16)),
        ("tiny", random_boxes(300, 1e-30, 1e-31)),
        // Each box is half as far as the one before: a split by bins takes off one at a time.
        ("powers", (0..120).map(|i| at(Vec3::X * 0.5_f32.powi(i))).collect()),
        (
            "large and small",
            random_boxes(100, 1e-3, 1e-4).into_iter().chain(random_boxes(100, 1e6, 1e5)).collect(),
        ),
    ]
}

fn every_config() -> Vec<BuildConfig> {
    let mut configs = Vec::new();
    for builder in Builder::ALL {
        for width in Width::ALL {
            for widen in Widen::ALL {
                for stop in StopRule::ALL {
                    for (leaf, bins, block) in
                        [(1, 16, Block::B1), (2, 2, Block::B2), (5, 256, Block::B4), (64, 33, Block::B8)]
                    {
                        // Each improver with half of what else there is.
                        let improver = Improver::ALL[configs.len() % Improver::ALL.len()];
                        let compressed = width == Width::W8 && configs.len() % 7 < 3;
                        configs.push(BuildConfig {
                            builder,
                            width,
                            layout: if compressed { Layout::Compressed } else { Layout::Full },
                            widen,
                            stop,
                            leaf,
                            bins,
                            block,
                            improver,
                            pre_split: if configs.len() % 5 == 0 { 0.8 } else { 0.0 },
                            rounds: 3,
                            share: 0.5,
                            ..BuildConfig::default()
                        });
                    }
                }
            }
        }
    }
    configs
}

fn tree(boxes: &[Aabb], config: &BuildConfig) -> Tree {
    build(boxes, config, &Task::new()).expect("not cancelled").0
}

/// Boxes that are hollow, so that cutting them in advance pays.
struct Hollow<'a>(&'a [Aabb]);

impl Shapes for Hollow<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, shape: u32) -> Aabb {
        self.0.bounds(shape)
    }

    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
        self.0.bounds_between(shape, axis, from, to)
    }

    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
        self.0.bounds_inside(shape, clip)
    }

    fn area_in_parts(&self, _: u32) -> f32 {
        0.0
    }
}

fn hollow_tree(boxes: &[Aabb], config: &BuildConfig) -> Tree {
    build_over(&Hollow(boxes), config, &Task::new()).expect("not cancelled").0
}

#[test]
fn every_tree_is_valid_on_every_hard_case() {
    for (name, boxes) in hard_cases() {
        for config in every_config() {
            let tree = hollow_tree(&boxes, &config);
            assert_eq!(validate(&tree, &boxes), [], "{name}, {config:?}");
            let most = tree.leaf_ranges().iter().map(|l| l.count as usize).max().unwrap_or(0);
            let limited = most <= config.leaf_limit() || config.builder.is_peer();
            assert!(limited, "{name}, {config:?}: a leaf of {most}");
            let more = tree.refs().len() - boxes.len();
            let share = if config.builder == Builder::Spatial { config.split_budget } else { 0.0 };
            let budget = boxes.len() as f32 * (share + config.pre_split);
            assert!(
                more == 0 || (config.duplicates() && more as f32 <= budget),
                "{name}, {config:?}: {more} references too many"
            );
        }
    }
}

#[test]
fn halving_4977_boxes_gives_5857_nodes() {
    let config = BuildConfig { builder: Builder::Median, width: Width::W2, ..BuildConfig::default() };
    assert_eq!(tree(&random_boxes(4977, 10.0, 0.1), &config).node_count(), 5857);
}

#[test]
fn the_tree_is_the_same_at_any_number_of_threads() {
    let boxes = random_boxes(40_000, 10.0, 0.1);
    for (builder, pre_split) in Builder::ALL.into_iter().flat_map(|b| [(b, 0.0), (b, 0.3)]) {
        let config = BuildConfig { builder, pre_split, layout: Layout::Compressed, ..BuildConfig::default() };
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| hollow_tree(&boxes, &config))
        };
        let one = with_threads(1);
        assert!(one == with_threads(2) && one == with_threads(5), "{builder:?}, {pre_split}");
    }
}

/// The least split cost over all positions on all axes, by trying each.
fn least_split_cost(boxes: &[Aabb], block: Block) -> f32 {
    let union = |part: &[Aabb]| {
        let bounds = part.iter().fold(Aabb::EMPTY, |a, b| a.union(*b));
        bounds.half_area() * block.count(part.len()) as f32
    };
    let mut least = f32::INFINITY;
    for axis in 0..3 {
        let mut sorted = boxes.to_vec();
        sorted.sort_by(|a, b| a.center()[axis].total_cmp(&b.center()[axis]));
        for mid in 1..sorted.len() {
            least = least.min(union(&sorted[..mid]) + union(&sorted[mid..]));
        }
    }
    least
}

#[test]
fn the_sweep_finds_the_best_split_at_the_root() {
    let cases = [2, 3, 10, 60].into_iter().flat_map(|count| Block::ALL.map(|block| (count, block)));
    for (count, block) in cases {
        let boxes = random_boxes(count, 5.0, 2.0);
        let config = BuildConfig {
            builder: Builder::Sweep,
            width: Width::W2,
            leaf: 1,
            block,
            ..BuildConfig::default()
        };
        let tree = tree(&boxes, &config);
        let mut cost = 0.0;
        tree.walk(|view| {
            if view.depth == 1 {
                let mut below = 0;
                count_below(&tree, view.id, &mut below);
                cost += view.bounds.half_area() * block.count(below) as f32;
            }
            view.depth < 1
        });
        let least = least_split_cost(&boxes, block);
        assert!((cost - least).abs() <= 1e-4 * least, "{count} boxes, {block:?}: {cost} against {least}");
    }
}

#[test]
fn counting_blocks_fills_leaves() {
    let boxes = random_boxes(4000, 10.0, 0.5);
    for builder in [Builder::Sweep, Builder::Binned] {
        let leaves = |block| {
            let config = BuildConfig { builder, leaf: 4, block, ..BuildConfig::default() };
            tree(&boxes, &config).leaf_count()
        };
        let [one, four] = [leaves(Block::B1), leaves(Block::B4)];
        assert!(four * 10 < one * 9, "{builder:?}: {one} leaves by shapes, {four} by blocks");
    }
}

/// Adds the number of references below a node.
fn count_below(tree: &Tree, top: crate::accel::NodeId, count: &mut usize) {
    let mut inside = vec![false; tree.node_count()];
    tree.walk_nodes(|v| {
        let parent_inside = v.parent.is_some_and(|p| inside[p.0 as usize]);
        inside[v.id.0 as usize] = v.id == top || parent_inside;
        if let (true, Some(leaf_idx)) = (inside[v.id.0 as usize], tree.leaf_index(v.id)) {
            *count += tree.leaf_shapes(leaf_idx).len();
        }
        true
    });
}

#[test]
fn searches_among_few_references_give_the_dense_answer() {
    use super::order::{RefSlice, build_refs};
    use super::top_down::Splitter;
    for seed in 0..40 {
        let boxes = random_boxes(63 + seed, 5.0, 1.0);
        // On a coarse lattice many centroids share a bin, and planes cost the same.
        let snap = |p: Vec3| (p * 0.4).round() / 0.4;
        let coarse: Vec<Aabb> = boxes.iter().map(|b| Aabb::new(snap(b.min), snap(b.max))).collect();
        for (boxes, bins) in
            [(&boxes, 256), (&boxes, 16), (&boxes, 3), (&coarse, 256), (&coarse, 16), (&coarse, 2)]
        {
            for count in [2, 3, 4, 5, 6, 7, 8, 9, 31, 63] {
                let task = Task::new();
                let at = |shape: u32| boxes[seed + shape as usize];
                let mut refs = build_refs(count, at, &task).expect("not cancelled");
                let block = Block::ALL[seed % Block::ALL.len()];
                let config = BuildConfig { bins, block, ..BuildConfig::default() };
                let splitter = binned::Binned::new(&config, &task);
                let found = splitter.find(&mut RefSlice::new(&mut refs), &Bound::EMPTY);
                let dense = splitter.find_dense_for_tests(&refs);
                let told = |split: top_down::Split<binned::BinPlane>| {
                    let boxes = (split.left.aabb(), split.right.aabb());
                    (split.cost, split.left_count, boxes, split.plan)
                };
                assert_eq!(found.map(told), dense.map(told), "{count} boxes, {bins} bins, {seed}");
            }
        }
    }
}

#[test]
fn many_bins_come_close_to_the_sweep_and_few_are_worse() {
    let boxes = random_boxes(3000, 10.0, 0.5);
    let cost = |builder, bins| {
        let tree = tree(&boxes, &BuildConfig { builder, bins, ..BuildConfig::default() });
        TreeFigures::measure(&tree, 1.0, 1.0).sah_cost.expect("an area").total()
    };
    let sweep = cost(Builder::Sweep, 16);
    assert!((cost(Builder::Binned, 256) / sweep - 1.0).abs() < 0.03);
    assert!(cost(Builder::Binned, 2) > 1.03 * sweep);
    assert!(cost(Builder::Median, 16) > 1.1 * sweep);
}

/// The binary tree, node by node.
fn binary(tree: &Tree) -> Bvh2 {
    let Tree::W2(tree) = tree else { panic!("not a binary tree") };
    let mut nodes = vec![Bvh2Node { bounds: tree.bounds, first: 0, count: 0 }];
    let mut open = vec![(0, tree.root)];
    while let Some((at, child)) = open.pop() {
        if let Some(leaf_idx) = child.as_leaf() {
            let leaf = tree.leaves[leaf_idx as usize];
            (nodes[at].first, nodes[at].count) = (leaf.first, leaf.count);
        } else if let Some(node_idx) = child.as_inner() {
            let node = &tree.nodes[node_idx as usize];
            nodes[at].first = nodes.len() as u32;
            for slot in 0..2 {
                open.push((nodes.len(), node.children[slot]));
                nodes.push(Bvh2Node { bounds: node.child_bounds(slot), first: 0, count: 0 });
            }
        }
    }
    Bvh2 { nodes, refs: tree.refs.clone() }
}

#[test]
fn wide_trees_are_the_binary_tree_with_children_opened() {
    for (boxes, builder) in
        [(random_boxes(3000, 5.0, 1.0), Builder::Binned), (random_boxes(400, 5.0, 1.0), Builder::Sweep)]
    {
        for how in [Widen::Split, Widen::Collapse] {
            let config = BuildConfig { builder, width: Width::W2, widen: how, ..BuildConfig::default() };
            let bvh = binary(&tree(&boxes, &config));
            let widened = |width| match width {
                Width::W2 => Tree::W2(widen(&bvh, &config, &Task::new()).expect("not cancelled")),
                Width::W4 => Tree::W4(widen(&bvh, &config, &Task::new()).expect("not cancelled")),
                Width::W8 => Tree::W8(widen(&bvh, &config, &Task::new()).expect("not cancelled")),
            };
            for width in Width::ALL {
                assert!(
                    tree(&boxes, &BuildConfig { width, ..config }) == widened(width),
                    "{width:?}, {config:?}"
                );
            }
        }
    }
}

/// The least SAH cost, times the root's area, of what is below a binary node in at most `slots` slots of a wide node:
/// every way tried.
fn least_cost(bvh: &Bvh2, node: u32, slots: usize, width: usize, leaf: usize) -> (f64, usize) {
    let binary = &bvh.nodes[node as usize];
    let area = f64::from(binary.bounds.half_area());
    if binary.is_leaf() {
        return (area * f64::from(binary.count), binary.count as usize);
    }
    let shared = |slots: usize| {
        let [left, right] = binary.children();
        (1..slots).map(move |of_left| {
            let (a, a_count) = least_cost(bvh, left, of_left, width, leaf);
            let (b, b_count) = least_cost(bvh, right, slots - of_left, width, leaf);
            (a + b, a_count + b_count)
        })
    };
    let (mut best, count) = shared(width).min_by(|a, b| a.0.total_cmp(&b.0)).expect("two slots or more");
    best += area;
    if count <= leaf {
        best = best.min(area * count as f64);
    }
    (shared(slots).map(|(cost, _)| cost).fold(best, f64::min), count)
}

#[test]
fn no_way_of_widening_costs_less_than_the_optimal_one() {
    for (count, width, leaf) in
        [(9, Width::W4, 1), (11, Width::W4, 4), (13, Width::W8, 3), (6, Width::W8, 64)]
    {
        let boxes = random_boxes(count, 5.0, 1.0);
        let binary_config = BuildConfig { width: Width::W2, leaf: 1, ..BuildConfig::default() };
        let bvh = binary(&tree(&boxes, &binary_config));
        let (least, _) = least_cost(&bvh, 0, 1, width.get(), leaf);
        let cost = |widen| {
            let tree = tree(&boxes, &BuildConfig { width, widen, leaf, ..BuildConfig::default() });
            TreeFigures::measure(&tree, 1.0, 1.0).sah_cost.expect("the boxes have areas").total()
        };
        let optimal = cost(Widen::Optimal);
        let least = least / f64::from(bvh.nodes[0].bounds.half_area());
        assert!((optimal - least).abs() < 1e-4 * least, "{count} {width:?} {leaf}: {optimal}, not {least}");
        assert!(optimal <= cost(Widen::Split) * 1.0001 && optimal <= cost(Widen::Collapse) * 1.0001);
    }
}

#[test]
fn reinsertion_lowers_the_cost_round_by_round_and_is_the_same_at_any_thread_count() {
    let boxes = random_boxes(3000, 5.0, 1.0);
    for width in Width::ALL {
        let plain = BuildConfig { builder: Builder::Median, width, ..BuildConfig::default() };
        let config = BuildConfig { improver: Improver::Reinsertion, rounds: 3, share: 0.3, ..plain };
        let cost = |config| TreeFigures::measure(&tree(&boxes, config), 1.0, 1.0).sah_cost.map(|c| c.total());
        assert!(cost(&config) < cost(&plain), "{width:?}");
        let (_, report) = build(&boxes, &config, &Task::new()).expect("not cancelled");
        let rounds: Vec<f64> = report.rounds.iter().flatten().copied().collect();
        assert_eq!(rounds.len(), 4);
        assert!(rounds.windows(2).all(|pair| pair[1] < pair[0]), "{rounds:?}");
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| tree(&boxes, &config))
        };
        assert!(on(1) == on(3), "{width:?}");
    }
}

#[test]
fn wide_trees_keep_the_leaves_and_have_fewer_nodes() {
    let boxes = random_boxes(2000, 5.0, 0.2);
    for widen in [Widen::Split, Widen::Collapse] {
        let trees =
            Width::ALL.map(|width| tree(&boxes, &BuildConfig { width, widen, ..BuildConfig::default() }));
        assert!(trees.windows(2).all(|w| w[0].leaf_count() == w[1].leaf_count()));
        assert!(trees.windows(2).all(|w| w[0].inner_count() > w[1].inner_count()));
    }
}

#[test]
fn the_stop_rule_cost_makes_larger_leaves_where_tests_are_cheap() {
    let boxes = random_boxes(2000, 5.0, 0.2);
    let config = BuildConfig { stop: StopRule::Cost, leaf: 16, ..BuildConfig::default() };
    let dear = tree(&boxes, &BuildConfig { intersection_cost: 8.0, ..config }).leaf_count();
    let cheap = tree(&boxes, &BuildConfig { traversal_cost: 8.0, ..config }).leaf_count();
    assert!(cheap < dear, "{cheap} leaves against {dear}");
}

#[test]
fn a_cancelled_build_says_so() {
    let task = Task::new();
    task.cancel();
    assert_eq!(build(&random_boxes(5000, 5.0, 0.2), &BuildConfig::default(), &task), Err(Cancelled));
}

#[test]
fn progress_reaches_the_end() {
    for builder in Builder::ALL {
        let task = Task::new();
        for pre_split in [0.0, 0.4] {
            let config = BuildConfig { builder, pre_split, ..BuildConfig::default() };
            build_over(&Hollow(&random_boxes(5000, 5.0, 0.2)), &config, &task).expect("not cancelled");
            assert_eq!(task.fraction(), Some(1.0), "{builder:?}, {pre_split}");
        }
    }
}
