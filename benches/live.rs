//! The live loop on the default scene at 1280 x 720 with all threads: from a change of the bins to the new tree, the heatmap
//! and the pictures.

use std::sync::Arc;
use std::time::Duration;

use bvhscope::accel::{BuildConfig, Width};
use bvhscope::render::film::{Film, FilmSubject};
use bvhscope::render::integrate::render;
use bvhscope::render::{CountKind, RenderSettings, View};
use bvhscope::scene::{ShadowRule, builtin};
use bvhscope::task::Task;
use bvhscope::world::World;
use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};

fn live(criterion: &mut Criterion) {
    let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
    let settings = RenderSettings { width: 1280, height: 720, ..RenderSettings::default() };
    let defaults = BuildConfig::default();
    let configs = [("default", defaults), ("binary", BuildConfig { width: Width::W2, ..defaults })];
    for (name, config) in configs {
        let mut group = criterion.benchmark_group(format!("live {name}"));
        group.sampling_mode(SamplingMode::Flat);
        let build = |bins| {
            let config = BuildConfig { bins, ..config };
            World::build(Arc::clone(&scene), &config, &Task::new()).expect("nobody cancels")
        };
        let mut bins = 16;
        group.bench_function("tree", |bencher| {
            bencher.iter(|| {
                bins = 16 + (bins + 1) % 16;
                build(bins)
            });
        });
        let world = build(16);
        let picture = |view: View, count: CountKind| -> Film {
            let subject = FilmSubject { view, count, shadow_rule: ShadowRule::default() };
            let film = render(subject, &world, &scene.camera, &settings, 1, &Task::new());
            film.expect("nobody cancels")
        };
        for (name, view, count) in [
            ("heatmap", View::NodesVisited, CountKind::Camera),
            ("heatmap of all rays", View::NodesVisited, CountKind::All),
            ("depth", View::Depth, CountKind::Camera),
            ("whitted", View::Whitted, CountKind::Camera),
            ("path", View::Path, CountKind::Camera),
        ] {
            group.bench_function(name, |bencher| bencher.iter(|| picture(view, count)));
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .without_plots();
    targets = live
}
criterion_main!(benches);
