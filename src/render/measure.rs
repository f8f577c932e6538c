//! Figures from tracing rays with counters, and from timing without.

use std::hint::black_box;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::film::RenderSettings;
use super::integrate::whitted_frame;
use super::observer::{CountRays, RayKind, RayObserver, TracedRays};
use super::pass::Pass;
use super::tiles::tiles;
use super::views::CountKind;
use super::whitted::Whitted;
use crate::accel::RayCounters;
use crate::geometry::Ray;
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::{Packets, World};

/// Times that a timed measurement is taken; its median counts.
const REPEATS: usize = 5;

/// Rows, and columns, of pixels whose rays are counted together.
const ROWS_TOGETHER: usize = 8;

/// Pixels whose rays are held in memory at once while they are timed.
const PIXELS_HELD: usize = 1 << 18;

/// Means per ray over the counted rays. `None` where no ray was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RayFigures {
    pub ray_count: u64,
    /// Rays that miss the root's box; they visit nothing.
    pub missed_root_count: u64,
    pub nodes_visited_mean: Option<f64>,
    pub inner_visits_mean: Option<f64>,
    pub leaf_visits_mean: Option<f64>,
    pub box_tests_mean: Option<f64>,
    pub shape_tests_mean: Option<f64>,
    pub ray_cost_mean: Option<f64>,
    /// Standard deviation of the number of leaves that a ray visits.
    pub lcv: Option<f64>,
}

/// Times of a Whitted frame; medians.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Tracing all rays of the frame, without shading and counting, median of 5.
    pub traversal_ms: f64,
    /// 1000 / time of a whole frame with shading, without the build.
    pub frames_per_s: f64,
    /// Threads that traced.
    pub threads: usize,
}

/// Counts the rays of one Whitted frame of the given kind. With `stride > 1` only every `stride`-th pixel in x and y.
///
/// The frame is that of sample 0, through the pixels' centres, with shadows by the default rule.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn count_rays(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    count: CountKind,
    stride: u32,
    task: &Task,
) -> Result<RayFigures, Cancelled> {
    let pass = frame_pass(world, camera, settings);
    let columns = picked(settings.width, stride);
    let rows = picked(settings.height, stride);
    let sums = rows
        .par_chunks(ROWS_TOGETHER)
        .map_init(
            || Whitted::new(world),
            |whitted, rows| {
                let mut rays = CountRays::new(count, &world.tree);
                // Pixels that lie side by side in both directions make better packets.
                for columns in columns.chunks(ROWS_TOGETHER) {
                    let pixels: Vec<_> =
                        rows.iter().flat_map(|&y| columns.iter().map(move |&x| [x, y])).collect();
                    whitted.radiance(&pass, &pixels, &mut rays, task)?;
                }
                Ok(rays)
            },
        )
        // Sums of integers: the same in any order.
        .try_reduce(|| CountRays::new(count, &world.tree), |a, b| Ok(a.merged(&b)))?;
    let config = &world.report.config;
    Ok(RayFigures::of(&sums, config.traversal_cost, config.intersection_cost))
}

/// Times a Whitted frame. The caller holds the lease: nothing else may run meanwhile.
///
/// The frame is that of [`count_rays`]. The rays are recorded first and then traced alone, in the same order and by the
/// same queries, by the threads of the current rayon pool.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn time_frame(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<FrameTimes, Cancelled> {
    let pass = frame_pass(world, camera, settings);
    let size = [settings.width, settings.height];
    let mut frame_ms = [0.0; REPEATS];
    for ms in &mut frame_ms {
        let start = Instant::now();
        black_box(whitted_frame(&pass, size, task, &|_| ())?);
        *ms = milliseconds(start);
    }
    Ok(FrameTimes {
        traversal_ms: median(traversal_ms(&pass, size, task)?),
        frames_per_s: 1000.0 / median(frame_ms),
        threads: rayon::current_num_threads(),
    })
}

impl RayFigures {
    fn of(rays: &CountRays, traversal_cost: f32, intersection_cost: f32) -> Self {
        let RayCounters { inner_visits, leaf_visits, box_tests, shape_tests } = rays.counters;
        let n = rays.ray_count as f64;
        let per_ray = |sum: f64| (rays.ray_count > 0).then(|| sum / n);
        let leaf_visits_mean = per_ray(leaf_visits as f64);
        // In integers, so that rays that all visit as many leaves have a deviation of exactly zero.
        let spread = u128::from(rays.ray_count) * u128::from(rays.squared_leaf_visits)
            - u128::from(leaf_visits) * u128::from(leaf_visits);
        Self {
            ray_count: rays.ray_count,
            missed_root_count: rays.missed_root_count,
            nodes_visited_mean: per_ray(rays.counters.nodes_visited() as f64),
            inner_visits_mean: per_ray(inner_visits as f64),
            leaf_visits_mean,
            box_tests_mean: per_ray(box_tests as f64),
            shape_tests_mean: per_ray(shape_tests as f64),
            ray_cost_mean: per_ray(rays.counters.ray_cost(traversal_cost, intersection_cost)),
            lcv: per_ray((spread as f64).sqrt()),
        }
    }
}

/// The frame that is counted and timed.
fn frame_pass<'a>(world: &'a World, camera: &Camera, settings: &RenderSettings) -> Pass<'a> {
    Pass::new(world, camera, [settings.width, settings.height], settings, ShadowRule::default(), 0)
}

/// Every `stride`-th of `size` pixels, from the middle of the first stride; at least one.
fn picked(size: u32, stride: u32) -> Vec<u32> {
    let stride = stride.clamp(1, size.max(1));
    (stride / 2..size).step_by(stride as usize).collect()
}

/// Rays of the frame that are traced together.
#[derive(Clone, Debug)]
struct RecordedRays {
    rays: Vec<Ray>,
    /// Whether any hit answers them.
    shadow: bool,
}

/// Keeps the rays in the order in which they are traced.
#[derive(Clone, Debug, Default)]
struct RecordRays(Vec<RecordedRays>);

impl RayObserver for RecordRays {
    const COUNTS: bool = false;

    fn traced(&mut self, traced: &TracedRays) {
        self.0.push(RecordedRays { rays: traced.rays.to_vec(), shadow: traced.kind == RayKind::Shadow });
    }
}

/// Times of tracing all rays of the frame. A part of the picture at a time, so that the rays of a large one fit in memory.
fn traversal_ms(pass: &Pass, size: [u32; 2], task: &Task) -> Result<[f64; REPEATS], Cancelled> {
    let rows = (PIXELS_HELD / (size[0] as usize).max(1)).max(1) as u32;
    let mut sums = [0.0; REPEATS];
    for top in (0..size[1]).step_by(rows as usize) {
        let rays = record(pass, size[0], top..size[1].min(top.saturating_add(rows)), task)?;
        for sum in &mut sums {
            let start = Instant::now();
            black_box(trace(pass, &rays, task)?);
            *sum += milliseconds(start);
        }
    }
    Ok(sums)
}

/// The rays of some rows, an entry a tile.
fn record(
    pass: &Pass,
    width: u32,
    rows: std::ops::Range<u32>,
    task: &Task,
) -> Result<Vec<Vec<RecordedRays>>, Cancelled> {
    let kept = Mutex::new(Vec::new());
    let size = [width, rows.len() as u32];
    let state = || Whitted::new(pass.world);
    tiles(size, task, &|_| (), state, |whitted, pixels, _: &mut [()]| {
        let mut recorder = RecordRays::default();
        let pixels: Vec<_> = pixels.iter().map(|&[x, y]| [x, rows.start + y]).collect();
        whitted.radiance(pass, &pixels, &mut recorder, task)?;
        kept.lock().unwrap_or_else(PoisonError::into_inner).push((pixels[0], recorder.0));
        Ok(())
    })?;
    let mut kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
    kept.sort_unstable_by_key(|&([x, y], _)| (y, x));
    Ok(kept.into_iter().map(|(_, rays)| rays).collect())
}

/// Traces recorded rays; the number of those that hit.
fn trace(pass: &Pass, tiles: &[Vec<RecordedRays>], task: &Task) -> Result<u64, Cancelled> {
    let hits = |packets: &mut Packets, tile: &Vec<RecordedRays>| {
        let mut hits = 0;
        for RecordedRays { rays, shadow } in tile {
            task.check()?;
            hits += match shadow {
                true => packets
                    .occluded_filtered(rays, pass.shadow_rule)
                    .iter()
                    .filter(|blocked| **blocked)
                    .count(),
                false => packets.intersect(rays).iter().flatten().count(),
            };
        }
        Ok(hits as u64)
    };
    let state = || Packets::new(pass.world);
    tiles.par_iter().map_init(state, hits).try_reduce(|| 0, |a, b| Ok(a + b))
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// The middle of an odd number of times.
fn median(mut times: [f64; REPEATS]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Tree, WideBvh};
    use crate::scene::builtin;

    #[test]
    fn the_rays_that_are_timed_are_the_rays_that_are_counted() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let task = Task::new();
        let world = World::build(scene, &BuildConfig::default(), &task).expect("nobody cancels");
        let settings = RenderSettings { width: 30, height: 20, ..RenderSettings::default() };
        let camera = world.scene.camera;
        let pass = frame_pass(&world, &camera, &settings);
        let tiles = record(&pass, 30, 0..20, &task).expect("nobody cancels");
        let number = |shadow: bool| -> u64 {
            let of_kind = tiles.iter().flatten().filter(|rays| rays.shadow == shadow);
            of_kind.map(|rays| rays.rays.len() as u64).sum()
        };
        let (shadows, others) = (number(true), number(false));
        for (count, expected) in [(CountKind::All, shadows + others), (CountKind::Shadow, shadows)] {
            let figures = count_rays(&world, &camera, &settings, count, 1, &task).expect("nobody cancels");
            assert_eq!(figures.ray_count, expected, "{count:?}");
        }
        // The room is closed, so every ray but those to the light hits.
        let hits = trace(&pass, &tiles, &task).expect("nobody cancels");
        assert!(hits > others && hits < shadows + others, "{hits} hits, {others} others");
    }

    #[test]
    fn every_stride_th_pixel_and_never_none() {
        assert_eq!(picked(5, 1), [0, 1, 2, 3, 4]);
        assert_eq!(picked(10, 4), [2, 6]);
        assert_eq!(picked(3, 100), [1]);
        assert_eq!(picked(3, 0), [0, 1, 2]);
        assert!(picked(0, 3).is_empty());
    }

    #[test]
    fn figures_are_means_per_ray_and_lcv_is_a_standard_deviation() {
        let tree = Tree::W2(WideBvh::empty());
        let mut rays = CountRays::new(CountKind::All, &tree);
        let ray = Ray::new(glam::Vec3::ZERO, glam::Vec3::Z);
        for leaf_visits in [2, 4, 4, 4, 5, 5, 7, 9] {
            let counters = [RayCounters { inner_visits: 1, leaf_visits, box_tests: 2, shape_tests: 3 }];
            rays.traced(&TracedRays {
                kind: RayKind::Camera,
                rays: &[ray],
                pixels: &[0],
                parents: &[0],
                counters: &counters,
            });
        }
        let figures = RayFigures::of(&rays, 2.0, 0.5);
        assert_eq!(figures.ray_count, 8);
        assert_eq!(figures.leaf_visits_mean, Some(5.0));
        assert_eq!(figures.lcv, Some(2.0));
        assert_eq!(figures.nodes_visited_mean, Some(6.0));
        assert_eq!(figures.box_tests_mean, Some(2.0));
        assert_eq!(figures.ray_cost_mean, Some(3.5));
    }

    #[test]
    fn no_ray_has_no_mean() {
        let figures =
            RayFigures::of(&CountRays::new(CountKind::Shadow, &Tree::W2(WideBvh::empty())), 1.0, 1.0);
        assert_eq!((figures.ray_count, figures.nodes_visited_mean, figures.lcv), (0, None, None));
    }
}
