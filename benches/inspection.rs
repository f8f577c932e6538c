//! What a user waits for who looks into a tree: from a click to the steps of the pixel's rays over a million triangles, the
//! splits of a root of a million shapes, and what a frame of the icicle plot and of the outline takes at ten million nodes.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use bvhscope::accel::{BuildConfig, Family, NodeId, Width};
use bvhscope::inspect::icicle::{IcicleWindow, cells, place};
use bvhscope::inspect::outline::Outline;
use bvhscope::inspect::ray_history::RayHistory;
use bvhscope::inspect::ray_tree::{PixelQuestion, RaySource, pixel_rays};
use bvhscope::inspect::split_curve::SplitCurve;
use bvhscope::render::RenderSettings;
use bvhscope::scene::{ShadowRule, builtin};
use bvhscope::task::Task;
use bvhscope::world::{RayQuery, World};
use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};

fn world(scene: &str, config: &BuildConfig) -> World {
    let scene = Arc::new(builtin::make(scene).expect("a built-in scene"));
    World::build(scene, config, &Task::new()).expect("nobody cancels")
}

fn a_million_shapes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a million triangles");
    group.sampling_mode(SamplingMode::Flat);
    let defaults = BuildConfig::default();
    for (name, config) in [("8-wide", defaults), ("binary", BuildConfig { width: Width::W2, ..defaults })] {
        let world = world("soup:1000000", &config);
        for (source_name, source) in [("path", RaySource::Path), ("whitted", RaySource::Whitted)] {
            let question = PixelQuestion {
                camera: world.scene.camera,
                settings: RenderSettings { width: 1280, height: 720, ..RenderSettings::default() },
                shadow_rule: ShadowRule::default(),
                source,
                sample: 0,
                pixel: [640, 360],
            };
            group.bench_function(format!("click to steps, {source_name}, {name}"), |bencher| {
                bencher.iter(|| {
                    let rays = pixel_rays(&world, &question, &Task::new()).expect("nobody cancels");
                    let first = rays.first().expect("a camera ray");
                    let three = [
                        RayQuery::Intersect,
                        RayQuery::Occluded,
                        RayQuery::OccludedFiltered(ShadowRule::default()),
                    ];
                    three.map(|query| RayHistory::record(&world, &first.ray, query))
                });
            });
        }
        let family = Family::of(world.shown_tree(), &Task::new()).expect("nobody cancels");
        group.bench_function(format!("split curve of the root, {name}"), |bencher| {
            bencher
                .iter(|| SplitCurve::of(&world, &family, NodeId(0), &Task::new()).expect("nobody cancels"));
        });
    }
    group.finish();
}

fn ten_million_nodes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ten million nodes");
    group.sampling_mode(SamplingMode::Flat);
    let config = BuildConfig { width: Width::W2, leaf: 1, ..BuildConfig::default() };
    let world = world("soup:5000000", &config);
    let tree = world.shown_tree();
    assert!(tree.node_count() > 9_900_000, "{}", tree.node_count());
    let family = Family::of(tree, &Task::new()).expect("nobody cancels");
    let weight = |node| f64::from(family.references(node));
    let node = NodeId(tree.inner_count() as u32 / 2);
    let [from, to] = place(tree, &family, &weight, node).expect("a tree with shapes");
    // As in a plot 900 points wide, with cells of 1.5 points and 19 rows.
    for (name, from, to, depths) in [
        ("the whole tree", 0.0, 1.0, [0, 18]),
        ("deep down", from, to, [family.depth(node), family.depth(node) + 18]),
    ] {
        let window = IcicleWindow { from, to, least: 1.5 * (to - from) / 900.0, depths };
        group.bench_function(format!("icicle, {name}"), |bencher| {
            bencher.iter(|| cells(black_box(tree), &weight, &window));
        });
    }
    group.bench_function("outline, to a node far below", |bencher| {
        let path = family.path(node);
        bencher.iter(|| {
            let mut outline = Outline::new(tree);
            outline.reveal(tree, &path, Some(&weight))
        });
    });
    let mut outline = Outline::new(tree);
    outline.open_below(tree, 0, 64, 100_000, None);
    group.bench_function("outline, one more node of 100,000 open lines", |bencher| {
        let index = outline.lines().iter().rposition(|line| !line.is_leaf).expect("an inner node");
        bencher.iter(|| outline.toggle(tree, index, None));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .without_plots();
    targets = a_million_shapes, ten_million_nodes
}
criterion_main!(benches);
