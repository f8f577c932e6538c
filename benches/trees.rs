//! What trees are worth, not how fast they are walked: SAH cost, EPO, and the counted cost of three kinds of rays, of this
//! program's trees and of those of `obvhs`, `bvh` and `parry3d` on the same triangles and rays. `benches/README.md` tells how
//! to run it. All numbers but the build times are the same on every machine.

#[expect(dead_code, reason = "the peers' harness also writes its inputs")]
#[path = "peers/inputs.rs"]
mod inputs;

use std::path::PathBuf;
use std::sync::Arc;

use bvhscope::accel::{BuildConfig, Builder, Improver, RayCounters, StopRule, Widen, Width};
use bvhscope::render::bench::{Query, RaySet};
use bvhscope::task::Task;
use bvhscope::world::World;
use inputs::Input;
use rayon::prelude::*;

const BUILTIN_SCENES: [&str; 3] = ["bunny", "teapot", "soup:200000"];

/// Rays of a set that are counted, at most.
const MOST_RAYS: usize = 100_000;

/// What a row shows, all of them better if lower.
const COLUMNS: [&str; 6] = ["build, ms", "SAH cost", "EPO", "primary", "diffuse", "shadow"];

fn main() {
    if !std::env::args().any(|arg| arg == "--bench") {
        println!("nothing measured: run `cargo bench --bench trees --features peers`");
        return;
    }
    let work = std::env::var_os("PEERS_WORK").map(PathBuf::from);
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|w| name == w);
    for name in BUILTIN_SCENES.into_iter().filter(|name| is_wanted(name)) {
        report(&Input::builtin(name));
    }
    if let Some(work) = &work {
        for name in inputs::names(work).into_iter().filter(|name| is_wanted(name)) {
            report(&Input::from_files(work, &name));
        }
    }
}

/// This program's trees that are worth comparing, and every other library's, at one width.
fn trees(width: Width) -> Vec<(String, BuildConfig)> {
    let widen = Widen::Optimal;
    let base = BuildConfig { width, widen, leaf: 8, stop: StopRule::Cost, ..BuildConfig::default() };
    let improved = |builder| {
        let config = BuildConfig { builder, improver: Improver::Reinsertion, rounds: 20, share: 0.2, ..base };
        (format!("`{}`, reinsertion", builder.name()), config)
    };
    let plain = |builder: Builder| (format!("`{}`", builder.name()), BuildConfig { builder, ..base });
    let mut trees = vec![
        plain(Builder::Binned),
        plain(Builder::Ploc),
        improved(Builder::Binned),
        improved(Builder::Ploc),
        improved(Builder::Spatial),
    ];
    for builder in [Builder::Binned, Builder::Ploc] {
        let (name, config) = improved(builder);
        let name = format!("{name}, shapes cut in advance");
        trees.push((name, BuildConfig { pre_split: 0.5, ..config }));
    }
    trees.extend(Builder::ALL.into_iter().filter(|builder| builder.is_peer()).map(plain));
    trees
}

fn report(input: &Input) {
    for width in [Width::W2, Width::W8] {
        println!("\n**{}**, {} triangles, width {}\n", input.name, input.triangles.len(), width.name());
        println!("| tree | {} |\n|---|{}", COLUMNS.join(" | "), "--:|".repeat(COLUMNS.len()));
        let rows: Vec<_> = trees(width)
            .into_iter()
            .map(|(name, config)| (name, config.builder.is_peer(), measure(input, &config)))
            .collect();
        for (name, _, row) in &rows {
            let cells: Vec<_> = row.iter().map(|x| format!("{x:.2}")).collect();
            println!("| {name} | {} |", cells.join(" | "));
        }
        let best = |peer: bool, column: usize| {
            let of = rows.iter().filter(|(_, is_peer, _)| *is_peer == peer).map(|(.., row)| row[column]);
            of.fold(f64::INFINITY, f64::min)
        };
        let ratio = |column| format!("{:.3}", best(false, column) / best(true, column));
        let ratios: Vec<_> = (1..COLUMNS.len()).map(ratio).collect();
        println!("| best of ours / best of theirs | | {} |", ratios.join(" | "));
    }
}

/// The figures of [`COLUMNS`].
fn measure(input: &Input, config: &BuildConfig) -> [f64; COLUMNS.len()] {
    let task = Task::new();
    let scene = input.scene();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let world = one.install(|| World::build(Arc::clone(&scene), config, &task)).expect("nobody cancels");
    let sah_cost = world.figures.sah_cost.map_or(f64::NAN, |cost| cost.total());
    let epo = world.epo(&task).expect("nobody cancels").map_or(f64::NAN, |epo| epo.total);
    let [primary, diffuse, shadow] = input.sets.each_ref().map(|set| ray_cost(&world, set));
    [world.report.build_ms, sah_cost, epo, primary, diffuse, shadow]
}

/// The mean of every n-th ray.
fn ray_cost(world: &World, set: &RaySet) -> f64 {
    let stride = set.rays.len().div_ceil(MOST_RAYS).max(1);
    let rays: Vec<_> = set.rays.iter().step_by(stride).collect();
    let count = |ray| {
        let mut counters = RayCounters::default();
        match set.query {
            Query::Intersect => drop(world.intersect(ray, &mut counters)),
            Query::Occluded => drop(world.occluded(ray, &mut counters)),
        }
        counters
    };
    let sum = rays.par_iter().map(|ray| count(ray)).reduce(RayCounters::default, |a, b| a + b);
    sum.ray_cost(1.0, 1.0) / rays.len() as f64
}
