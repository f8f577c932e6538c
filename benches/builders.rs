//! What a build takes: every builder at every width, on one thread and on all, over a scene and over a soup.

use std::sync::Arc;
use std::time::Duration;

use bvhscope::accel::{BuildConfig, Builder, Width};
use bvhscope::scene::{Scene, builtin};
use bvhscope::task::Task;
use bvhscope::world::World;
use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;

const SCENES: [&str; 2] = ["bunny", "soup:100000"];

fn builders(criterion: &mut Criterion) {
    for name in SCENES {
        let scene = Arc::new(builtin::make(name).expect("a built-in scene"));
        for threads in thread_counts() {
            let mut group = criterion.benchmark_group(format!("build {name} on {threads}"));
            group.throughput(Throughput::Elements(scene.shape_count() as u64));
            // A build is long: as many of them a sample as fit, no more.
            group.sampling_mode(SamplingMode::Flat);
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            for builder in Builder::ALL {
                for width in Width::ALL {
                    let config = BuildConfig { builder, width, ..BuildConfig::default() };
                    group.bench_function(BenchmarkId::new(builder.name(), width.name()), |bencher| {
                        // The program's own figure, from the scene to rays: without the tree's figures, which no build
                        // needs, and without freeing the tree.
                        bencher.iter_custom(|times| {
                            (0..times).map(|_| pool.install(|| build_time(&scene, &config))).sum()
                        });
                    });
                }
            }
            group.finish();
        }
    }
}

fn build_time(scene: &Arc<Scene>, config: &BuildConfig) -> Duration {
    let world = World::build(Arc::clone(scene), config, &Task::new()).expect("nobody cancels");
    Duration::from_secs_f64(world.report.build_ms * 1e-3)
}

/// One and all; the same where all are one.
fn thread_counts() -> Vec<usize> {
    let mut counts = vec![1, rayon::current_num_threads()];
    counts.dedup();
    counts
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .nresamples(10_000);
    targets = builders
}
criterion_main!(benches);
