//! What one builder does and others do not.

use super::*;

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

    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
        let part = |all: Aabb, axis| {
            all.intersection(self.bounds_between(shape, axis, clip.min[axis], clip.max[axis]))
        };
        [0, 1, 2].into_iter().fold(*clip, part)
    }

    fn area_in_parts(&self, _: u32) -> f32 {
        0.0
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
fn needles_cut_in_advance_make_better_trees_of_any_builder() {
    let needles = needles();
    let boxes: Vec<_> = (0..400).map(|shape| needles.bounds(shape)).collect();
    for builder in Builder::ALL {
        let figures = |pre_split| {
            let config = BuildConfig { builder, pre_split, leaf: 4, ..BuildConfig::default() };
            let (tree, report) = build_over(&needles, &config, &Task::new()).expect("not cancelled");
            assert_eq!(validate(&tree, &boxes), [], "{config:?}");
            assert_eq!(report.phases.iter().any(|phase| phase.name == "presplit"), pre_split > 0.0);
            let figures = TreeFigures::measure(&tree, 1.0, 1.0);
            (figures.reference_count, figures.sah_cost.map_or(f64::NAN, |cost| cost.total()))
        };
        let ((_, whole), (few, little), (many, much)) = (figures(0.0), figures(0.02), figures(1.0));
        if builder != Builder::Spatial {
            assert!(few <= 408 && many <= 800 && few < many, "{builder:?}: {few}, {many} references");
            assert!(little < 1.05 * whole, "{builder:?}: {little} against {whole}");
        }
        // There is nothing to gain in parts without any order, or beside cuts where they are best.
        let gains = !matches!(builder, Builder::Spatial | Builder::Random);
        assert!(!gains || much < 0.95 * whole, "{builder:?}: {much} against {whole}");
    }
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
