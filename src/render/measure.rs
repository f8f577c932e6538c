//! Figures from tracing rays with counters, and from timing without.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::film::RenderSettings;
use super::integrate::{count_pixel, whitted_frame};
use super::observer::{CountRays, RayKind, RayObserver};
use super::pass::Pass;
use super::views::CountKind;
use super::whitted::Whitted;
use crate::accel::RayCounters;
use crate::geometry::Ray;
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Times that a timed measurement is taken; its median counts.
const REPEATS: usize = 5;

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
    let sums = picked(settings.height, stride)
        .into_par_iter()
        .map(|y| {
            let mut whitted = Whitted::default();
            let mut rays = CountRays::at_root(count, &world.tree);
            for &x in &columns {
                task.check()?;
                rays = count_pixel(&pass, &mut whitted, rays, x, y);
            }
            Ok(rays)
        })
        // Sums of integers: the same in any order.
        .try_reduce(|| CountRays::at_root(count, &world.tree), |a, b| Ok(a.merged(&b)))?;
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

/// A ray of the frame, and whether any hit answers it.
#[derive(Clone, Copy, Debug)]
struct RecordedRay {
    ray: Ray,
    shadow: bool,
}

/// Keeps the rays in the order in which they are traced.
#[derive(Clone, Debug, Default)]
struct RecordRays {
    rays: Vec<RecordedRay>,
    probe: (),
}

impl RayObserver for RecordRays {
    type Probe = ();

    fn begin(&mut self, kind: RayKind, ray: &Ray) -> &mut () {
        self.rays.push(RecordedRay { ray: *ray, shadow: kind == RayKind::Shadow });
        &mut self.probe
    }

    fn end(&mut self) {}
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

/// The rays of some rows, a row an entry.
fn record(
    pass: &Pass,
    width: u32,
    rows: std::ops::Range<u32>,
    task: &Task,
) -> Result<Vec<Vec<RecordedRay>>, Cancelled> {
    rows.into_par_iter()
        .map(|y| {
            let mut whitted = Whitted::default();
            let mut recorder = RecordRays::default();
            for x in 0..width {
                task.check()?;
                let ray = pass.camera_ray(x, y);
                whitted.radiance(pass, ray, &mut pass.sampler(x, y), &mut recorder);
            }
            Ok(recorder.rays)
        })
        .collect()
}

/// Traces recorded rays; the number of those that hit.
fn trace(pass: &Pass, rows: &[Vec<RecordedRay>], task: &Task) -> Result<u64, Cancelled> {
    let hits = |rays: &[RecordedRay]| {
        task.check()?;
        let hit = |r: &&RecordedRay| match r.shadow {
            true => pass.world.occluded_filtered(&r.ray, pass.shadow_rule, &mut ()).is_some(),
            false => pass.world.intersect(&r.ray, &mut ()).is_some(),
        };
        Ok(rays.iter().filter(hit).count() as u64)
    };
    rows.par_iter().flat_map(|row| row.par_chunks(256)).map(hits).try_reduce(|| 0, |a, b| Ok(a + b))
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
    use crate::accel::BuildConfig;
    use crate::scene::builtin;

    #[test]
    fn the_rays_that_are_timed_are_the_rays_that_are_counted() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let task = Task::new();
        let world = World::build(scene, &BuildConfig::default(), &task).expect("nobody cancels");
        let settings = RenderSettings { width: 30, height: 20, ..RenderSettings::default() };
        let camera = world.scene.camera;
        let pass = frame_pass(&world, &camera, &settings);
        let rows = record(&pass, 30, 0..20, &task).expect("nobody cancels");
        for (count, kept) in [(CountKind::All, [true, true]), (CountKind::Shadow, [true, false])] {
            let figures = count_rays(&world, &camera, &settings, count, 1, &task).expect("nobody cancels");
            let recorded = rows.iter().flatten().filter(|ray| kept[usize::from(!ray.shadow)]).count();
            assert_eq!(recorded as u64, figures.ray_count, "{count:?}");
        }
        // The room is closed, so every ray but those to the light hits.
        let others = rows.iter().flatten().filter(|ray| !ray.shadow).count() as u64;
        let hits = trace(&pass, &rows, &task).expect("nobody cancels");
        assert!(hits > others && hits < rows.iter().flatten().count() as u64, "{hits} hits, {others} others");
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
        let mut rays = CountRays::new(CountKind::All);
        for leaves in [2u32, 4, 4, 4, 5, 5, 7, 9] {
            let probe = rays.begin(RayKind::Camera, &Ray::new(glam::Vec3::ZERO, glam::Vec3::Z));
            crate::accel::Probe::inner_visited(probe, 0, 2);
            (0..leaves).for_each(|leaf| crate::accel::Probe::leaf_visited(probe, leaf));
            crate::accel::Probe::shapes_tested(probe, 3);
            rays.end();
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
        let figures = RayFigures::of(&CountRays::new(CountKind::Shadow), 1.0, 1.0);
        assert_eq!((figures.ray_count, figures.nodes_visited_mean, figures.lcv), (0, None, None));
    }
}
