//! Rays a second on one thread: the three sets of rays, every width, every level of instructions that there is.

use std::sync::Arc;
use std::time::Duration;

use bvhscope::accel::simd::SimdLevel;
use bvhscope::accel::{BuildConfig, Width};
use bvhscope::render::RenderSettings;
use bvhscope::render::bench::{Query, RaySet, RaySetKind, make_rays};
use bvhscope::scene::builtin;
use bvhscope::task::Task;
use bvhscope::world::World;
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

const SCENES: [&str; 2] = ["bunny", "soup:200000"];
/// Pixels along each side of the picture whose rays are traced.
const SIZE: u32 = 256;

fn traversal(criterion: &mut Criterion) {
    for name in SCENES {
        let scene = Arc::new(builtin::make(name).expect("a built-in scene"));
        let build = |config: &BuildConfig| {
            World::build(Arc::clone(&scene), config, &Task::new()).expect("nobody cancels")
        };
        let settings = RenderSettings { width: SIZE, height: SIZE, ..RenderSettings::default() };
        // The rays are the same whatever the tree.
        let any = build(&BuildConfig::default());
        let sets = RaySetKind::ALL.map(|kind| {
            let set = make_rays(kind, &any, &scene.camera, &settings, &Task::new());
            (kind, set.expect("nobody cancels"))
        });
        let levels = || SimdLevel::ALL.into_iter().filter(|s| *s != SimdLevel::Auto && s.is_available());
        let configs = Width::ALL.into_iter().flat_map(|width| {
            levels().map(move |simd| BuildConfig { width, simd, ..BuildConfig::default() })
        });
        let worlds: Vec<(BuildConfig, World)> = configs.map(|config| (config, build(&config))).collect();
        for (kind, set) in &sets {
            let mut group = criterion.benchmark_group(format!("trace {name} {}", kind.name()));
            group.throughput(Throughput::Elements(set.rays.len() as u64));
            group.sampling_mode(SamplingMode::Flat);
            for (config, world) in &worlds {
                let id = BenchmarkId::new(config.simd.name(), config.width.name());
                group.bench_function(id, |bencher| bencher.iter(|| trace(world, set)));
            }
            group.finish();
        }
    }
}

/// The number of rays that hit something.
fn trace(world: &World, set: &RaySet) -> usize {
    match set.query {
        Query::Intersect => set.rays.iter().filter(|ray| world.intersect(ray, &mut ()).is_some()).count(),
        Query::Occluded => set.rays.iter().filter(|ray| world.occluded(ray, &mut ()).is_some()).count(),
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .nresamples(10_000);
    targets = traversal
}
criterion_main!(benches);
