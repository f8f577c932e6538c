//! Every builder, width and way of widening on many kinds of boxes; determinism; builders against slow searches.

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
                        configs.push(BuildConfig {
                            builder,
                            width,
                            widen,
                            stop,
                            leaf,
                            bins,
                            block,
                            improver,
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

#[test]
fn every_tree_is_valid_on_every_hard_case() {
    for (name, boxes) in hard_cases() {
        for config in every_config() {
            let tree = tree(&boxes, &config);
            assert_eq!(validate(&tree, &boxes), [], "{name}, {config:?}");
            let most = tree.leaves().iter().map(|l| l.count as usize).max().unwrap_or(0);
            assert!(most <= config.leaf, "{name}, {config:?}: a leaf of {most}");
            let more = tree.refs().len() - boxes.len();
            let budget = if config.builder.duplicates() { boxes.len() / 2 } else { 0 };
            assert!(more <= budget, "{name}, {config:?}: {more} references too many");
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
    for builder in Builder::ALL {
        let config = BuildConfig { builder, width: Width::W4, ..BuildConfig::default() };
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| tree(&boxes, &config))
        };
        let one = with_threads(1);
        assert!(one == with_threads(2) && one == with_threads(5), "{builder:?}");
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
        let config = BuildConfig { builder, ..BuildConfig::default() };
        build(&random_boxes(5000, 5.0, 0.2), &config, &task).expect("not cancelled");
        assert_eq!(task.fraction(), Some(1.0), "{builder:?}");
    }
}

/// Straight lines from one point to another.
struct Needles(Vec<[Vec3; 2]>);

impl Shapes for Needles {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, shape: u32) -> Aabb {
        Aabb::from_points(self.0[shape as usize])
    }

    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
        let [a, b] = self.0[shape as usize];
        let along = |at: f32| (at - a[axis]) / (b[axis] - a[axis]);
        let (first, last) = (along(from).min(along(to)).max(0.0), along(from).max(along(to)).min(1.0));
        if first > last {
            Aabb::EMPTY
        } else {
            Aabb::from_points([first, last].map(|t| a.lerp(b, t))).padded(1e-5)
        }
    }
}

/// Many short ones, and a few from one side to the other.
fn needles() -> Needles {
    let mut rng = rng();
    let mut point = || Vec3::new(rng.random(), rng.random(), rng.random()) * 10.0;
    let needles = (0..400).map(|i| {
        let (a, b) = (point(), point());
        if i < 10 { [a.with_x(0.0), b.with_x(10.0)] } else { [a, a + b * 0.02] }
    });
    Needles(needles.collect())
}

#[test]
fn spatial_splits_cut_needles_within_their_budget() {
    let needles = needles();
    let figures = |builder| {
        let config = BuildConfig { builder, ..BuildConfig::default() };
        let (tree, _) = build_over(&needles, &config, &Task::new()).expect("not cancelled");
        let figures = TreeFigures::measure(&tree, 1.0, 1.0);
        (figures.reference_count, figures.sah_cost.map_or(f64::NAN, |cost| cost.total()))
    };
    let ((whole, binned), (cut, spatial)) = (figures(Builder::Binned), figures(Builder::Spatial));
    assert!(whole == 400 && (420..=600).contains(&cut), "{whole} and {cut} references");
    assert!(spatial < 0.9 * binned, "{spatial} against {binned}");
}

#[test]
fn builders_are_as_good_as_their_names() {
    // Long and short, thick and thin, as rooms are furnished.
    let boxes: Vec<_> = random_boxes(4000, 20.0, 1.0)
        .into_iter()
        .map(|b| Aabb::new(b.min, b.min + b.extent().powf(6.0) * 8.0))
        .collect();
    let cost_over = |boxes: &[Aabb], builder, change: fn(&mut BuildConfig)| {
        let mut config = BuildConfig { builder, width: Width::W2, leaf: 1, ..BuildConfig::default() };
        change(&mut config);
        TreeFigures::measure(&tree(boxes, &config), 1.0, 1.0).sah_cost.expect("the boxes have areas").total()
    };
    let cost = |builder, change| cost_over(&boxes, builder, change);
    let same = |_: &mut BuildConfig| ();
    let [sweep, ploc, lbvh, midpoint, random] =
        [Builder::Sweep, Builder::Ploc, Builder::Lbvh, Builder::Midpoint, Builder::Random]
            .map(|builder| cost(builder, same));
    assert!(ploc < lbvh && sweep < lbvh, "{sweep} {ploc} {lbvh}");
    assert!(midpoint < 1.5 * sweep && random > 5.0 * sweep, "{sweep} {midpoint} {random}");
    assert!(ploc < cost(Builder::Ploc, |c| c.radius = 1), "more neighbours, better pairs");
    // A crowd in one cell of the coarser curve.
    let mut crowd = random_boxes(2000, 1.0, 0.01);
    crowd.push(Aabb::new(Vec3::splat(5000.0), Vec3::splat(5000.1)));
    let [coarse, fine] = [(|c| c.morton = Morton::Bits30) as fn(&mut BuildConfig), |_| ()]
        .map(|change| cost_over(&crowd, Builder::Lbvh, change));
    // Above the root's share, which is 1.
    assert!(coarse - 1.0 > 5.0 * (fine - 1.0), "{coarse} {fine}");
}

#[test]
fn leaves_of_bottom_up_trees_follow_the_stop_rule() {
    let boxes = random_boxes(3000, 5.0, 1.0);
    for builder in [Builder::Lbvh, Builder::Ploc] {
        let with = |leaf, stop| {
            let config = BuildConfig { builder, width: Width::W2, leaf, stop, ..BuildConfig::default() };
            let bvh = binary(&tree(&boxes, &config));
            let leaves: Vec<_> = bvh.nodes.iter().filter(|node| node.is_leaf()).copied().collect();
            (bvh, leaves)
        };
        let ((single, _), (_, limited)) = (with(1, StopRule::Limit), with(6, StopRule::Limit));
        // Each leaf is a subtree of the tree of single references, and the one above it holds too much.
        let mut expected = Vec::new();
        let mut open = vec![0_u32];
        while let Some(at) = open.pop() {
            let mut below = 0;
            count_nodes(&single, at, &mut below);
            match below <= 6 {
                true => expected.push(below),
                false => open.extend(single.nodes[at as usize].children()),
            }
        }
        let mut sizes: Vec<_> = limited.iter().map(|leaf| leaf.count as usize).collect();
        sizes.sort_unstable();
        expected.sort_unstable();
        assert_eq!(sizes, expected, "{builder:?}");
        // Where splits cost nothing, none is left out.
        let config = BuildConfig { traversal_cost: 1e-6, stop: StopRule::Cost, ..BuildConfig::default() };
        let config = BuildConfig { builder, width: Width::W2, leaf: 6, ..config };
        let leaves = tree(&boxes, &config).leaf_count();
        assert!(leaves > limited.len() && with(6, StopRule::Cost).1.len() < leaves, "{builder:?}");
    }
}

/// How many references lie below a node.
fn count_nodes(bvh: &Bvh2, at: u32, found: &mut usize) {
    let node = bvh.nodes[at as usize];
    *found += node.count as usize;
    if !node.is_leaf() {
        node.children().into_iter().for_each(|child| count_nodes(bvh, child, found));
    }
}

#[test]
fn cuts_keep_to_their_budget_and_begin_at_their_overlap() {
    let needles = needles();
    let refs = |split_alpha, split_budget| {
        let config =
            BuildConfig { builder: Builder::Spatial, split_alpha, split_budget, ..BuildConfig::default() };
        build_over(&needles, &config, &Task::new()).expect("not cancelled").0.refs().len()
    };
    assert_eq!([refs(1e-5, 0.0), refs(1.0, 0.5)], [400; 2]);
    let [little, much] = [0.02, 2.0].map(|budget| refs(1e-5, budget));
    assert!(400 < little && little <= 408 && little < much, "{little} {much}");
    assert!(refs(0.05, 2.0) < much, "only large overlaps");
}
