//! Adds samples to a film: picks the integrator for the view and runs it over tiles.

use std::ops::AddAssign;

use glam::Vec3;
use rayon::prelude::*;

use super::film::{Film, FilmContent, FilmSubject, RenderSettings};
use super::observer::{CountRays, RayKind, RayObserver};
use super::pass::Pass;
use super::path::{self, Estimator};
use super::sampler::scramble;
use super::shadow::{self, ShadowQuery};
use super::tonemap::srgb_decode;
use super::views::{Counter, View};
use super::whitted::Whitted;
use crate::accel::RayCounters;
use crate::geometry::{Hit, Ray};
use crate::scene::{Camera, MaterialKind, Surface};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Pixels along the side of a tile, the piece of work of one thread.
const TILE: usize = 16;

/// Adds one sample to every pixel: sample number `film.samples`. The result depends on world, camera, settings and that
/// number only, not on the number of threads. Runs in the current rayon pool.
///
/// The picture's size is the film's. Looks at `task` for a cancel alone; its progress is left to the caller, or see
/// [`render`].
///
/// # Errors
/// [`Cancelled`] when the task was; the film is then as before.
pub fn add_sample(
    film: &mut Film,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<(), Cancelled> {
    add_sample_and(film, world, camera, settings, task, &|_| ())
}

/// A whole picture of the size in `settings` with `samples` samples a pixel (one for a view that more do not refine).
/// Announces its progress on `task`, in pixels.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn render(
    subject: FilmSubject,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    samples: u32,
    task: &Task,
) -> Result<Film, Cancelled> {
    let samples = if subject.view.refines(subject.count) { samples.max(1) } else { 1 };
    let mut film = Film::new(settings.width, settings.height, subject);
    task.start(u64::from(settings.width) * u64::from(settings.height) * u64::from(samples));
    for _ in 0..samples {
        add_sample_and(&mut film, world, camera, settings, task, &|pixels| task.advance(pixels))?;
    }
    Ok(film)
}

/// The index of the sample that a film takes next. A view that does not refine is always sampled through the centre.
fn next_sample(film: &Film) -> u32 {
    if film.subject.view.refines(film.subject.count) { film.samples } else { 0 }
}

fn add_sample_and(
    film: &mut Film,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
) -> Result<(), Cancelled> {
    let subject = film.subject;
    let size = [film.width, film.height];
    let pass = Pass::new(world, camera, size, settings, subject.shadow_rule, next_sample(film));
    match &mut film.content {
        FilmContent::Color(sums) => {
            let colors = colors(&pass, subject.view, size, task, finished)?;
            add(sums, &colors, size);
        }
        FilmContent::Number(sums) => {
            let numbers = numbers(&pass, subject, size, task, finished)?;
            add(sums, &numbers, size);
        }
    }
    film.samples += 1;
    Ok(())
}

/// One sample of every pixel of a view of colours, in tiles.
fn colors(
    pass: &Pass,
    view: View,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
) -> Result<Tiled<Vec3>, Cancelled> {
    let shadow =
        |query| tiled(size, task, finished, || (), move |(), x, y| shadow::shaded(pass, query, x, y));
    let surface = |color: fn(&Pass, &Surface) -> Vec3| {
        tiled(
            size,
            task,
            finished,
            || (),
            move |(), x, y| {
                camera_hit(pass, x, y)
                    .map_or(Vec3::ZERO, |(ray, hit)| color(pass, &pass.world.scene.surface(&ray, &hit)))
            },
        )
    };
    match view {
        View::Path => tiled(
            size,
            task,
            finished,
            || (),
            |(), x, y| {
                let ray = pass.camera_ray(x, y);
                only_finite(path::radiance(pass, Estimator::Mis, ray, &mut pass.sampler(x, y)))
            },
        ),
        View::Whitted => whitted_frame(pass, size, task, finished),
        View::Albedo => surface(albedo),
        View::Normal => surface(|_, surface| shown_as(0.5 * surface.shading_normal + 0.5)),
        View::ShapeId => surface(|_, surface| shown_as(shape_color(surface.shape))),
        View::ShadowIntersect => shadow(ShadowQuery::Intersect),
        View::ShadowOccluded => shadow(ShadowQuery::Occluded),
        View::ShadowFiltered => shadow(ShadowQuery::Filtered),
        View::Depth
        | View::NodesVisited
        | View::BoxTests
        | View::ShapeTests
        | View::LeafVisits
        | View::RayCost
        | View::ShadowDifference
        | View::ShadowSaving => unreachable!("a film of {} holds numbers", view.name()),
    }
}

/// One sample of every pixel of a view of numbers, in tiles.
fn numbers(
    pass: &Pass,
    subject: FilmSubject,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
) -> Result<Tiled<f32>, Cancelled> {
    let counted = |number: fn(&Pass, &RayCounters) -> f64| {
        tiled(size, task, finished, Whitted::default, move |whitted, x, y| {
            number(pass, &count_pixel(pass, whitted, CountRays::new(subject.count), x, y).counters) as f32
        })
    };
    match subject.view.counter() {
        Some(Counter::NodesVisited) => counted(|_, c| c.nodes_visited() as f64),
        Some(Counter::BoxTests) => counted(|_, c| c.box_tests as f64),
        Some(Counter::ShapeTests) => counted(|_, c| c.shape_tests as f64),
        Some(Counter::LeafVisits) => counted(|_, c| c.leaf_visits as f64),
        Some(Counter::RayCost) => counted(|pass, c| {
            let config = &pass.world.report.config;
            c.ray_cost(config.traversal_cost, config.intersection_cost)
        }),
        Some(Counter::ShadowSaving) => tiled(
            size,
            task,
            finished,
            || (),
            |(), x, y| shadow::answers(pass, x, y).map_or(f32::NAN, |answers| answers.nodes_saved() as f32),
        ),
        None if subject.view == View::ShadowDifference => {
            tiled(size, task, finished, || (), |(), x, y| f32::from(shadow::class(pass, x, y) as u8))
        }
        None => tiled(
            size,
            task,
            finished,
            || (),
            |(), x, y| camera_hit(pass, x, y).map_or(f32::NAN, |(_, hit)| hit.t),
        ),
    }
}

/// One sample of every pixel of a Whitted picture.
pub(super) fn whitted_frame(
    pass: &Pass,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
) -> Result<Tiled<Vec3>, Cancelled> {
    tiled(size, task, finished, Whitted::default, |whitted, x, y| {
        let ray = pass.camera_ray(x, y);
        only_finite(whitted.radiance(pass, ray, &mut pass.sampler(x, y), &mut ()))
    })
}

/// Counts the rays of one sample of one pixel. Traces no more than it must.
#[inline]
pub(super) fn count_pixel<'t>(
    pass: &Pass,
    whitted: &mut Whitted,
    mut rays: CountRays<'t>,
    x: u32,
    y: u32,
) -> CountRays<'t> {
    let ray = pass.camera_ray(x, y);
    if rays.counts_camera_rays_alone() {
        pass.world.intersect(&ray, rays.begin(RayKind::Camera, &ray));
        rays.end();
    } else {
        whitted.radiance(pass, ray, &mut pass.sampler(x, y), &mut rays);
    }
    rays
}

fn camera_hit(pass: &Pass, x: u32, y: u32) -> Option<(Ray, Hit)> {
    let ray = pass.camera_ray(x, y);
    pass.world.intersect(&ray, &mut ()).map(|hit| (ray, hit))
}

/// A surface's colour without light; a light's is that of its radiance, at full brightness.
fn albedo(pass: &Pass, surface: &Surface) -> Vec3 {
    let scene = &pass.world.scene;
    let material = &scene.materials[surface.material as usize];
    match material.kind {
        MaterialKind::Emissive { radiance } => {
            let most = radiance.max_element();
            if most > 0.0 { only_finite(radiance / most) } else { Vec3::ZERO }
        }
        MaterialKind::Diffuse { .. } | MaterialKind::Mirror | MaterialKind::Glass { .. } => {
            material.color_at(surface.uv, &scene.images)
        }
    }
}

/// The linear colour that a display shows as these codes (in 0..=1): what is no light is not to be encoded as light.
fn shown_as(codes: Vec3) -> Vec3 {
    Vec3::from_array(codes.to_array().map(srgb_decode))
}

/// A colour for a shape index: far apart for neighbouring indices, never dark.
fn shape_color(shape: u32) -> Vec3 {
    let bits = scramble(u64::from(shape));
    let channel = |shift: u32| f32::from((bits >> shift) as u8) / 255.0;
    Vec3::new(channel(0), channel(8), channel(16)) * 0.85 + 0.1
}

/// A pixel keeps its other samples when one is not a number (as light of infinite radiance makes it).
fn only_finite(color: Vec3) -> Vec3 {
    if color.is_finite() { color } else { Vec3::ZERO }
}

/// Values of all pixels, tile by tile; tiles at the right and lower edge are padded.
pub(super) struct Tiled<T> {
    values: Vec<T>,
    columns: usize,
}

/// Evaluates every pixel, a tile a piece of work, each with a `state` of its own. `finished` is told the pixels of every
/// finished tile.
fn tiled<T, S>(
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
    state: impl Fn() -> S + Sync,
    pixel: impl Fn(&mut S, u32, u32) -> T + Sync,
) -> Result<Tiled<T>, Cancelled>
where
    T: Copy + Default + Send + Sync,
{
    let [width, height] = size.map(|s| s as usize);
    let columns = width.div_ceil(TILE);
    let mut values = vec![T::default(); columns * height.div_ceil(TILE) * TILE * TILE];
    values.par_chunks_mut(TILE * TILE).enumerate().try_for_each(|(tile, values)| {
        let (left, top) = (tile % columns * TILE, tile / columns * TILE);
        let (right, bottom) = ((left + TILE).min(width), (top + TILE).min(height));
        let mut state = state();
        for y in top..bottom {
            for x in left..right {
                task.check()?;
                values[(y - top) * TILE + x - left] = pixel(&mut state, x as u32, y as u32);
            }
        }
        finished(((right - left) * (bottom - top)) as u64);
        Ok(())
    })?;
    Ok(Tiled { values, columns })
}

impl<T: Copy> Tiled<T> {
    fn get(&self, x: usize, y: usize) -> T {
        let tile = y / TILE * self.columns + x / TILE;
        self.values[tile * TILE * TILE + y % TILE * TILE + x % TILE]
    }
}

/// Adds a sample of every pixel to the sums.
fn add<T: Copy + AddAssign + Send + Sync>(sums: &mut [T], sample: &Tiled<T>, size: [u32; 2]) {
    let width = (size[0] as usize).max(1);
    sums.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, sum) in row.iter_mut().enumerate() {
            *sum += sample.get(x, y);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinates(size: [u32; 2]) -> Vec<f32> {
        let tiles = tiled(size, &Task::new(), &|_| (), || (), |(), x, y| (x + 1000 * y) as f32)
            .expect("nobody cancels");
        let mut sums = vec![0.0; size[0] as usize * size[1] as usize];
        add(&mut sums, &tiles, size);
        sums
    }

    #[test]
    fn tiles_put_every_pixel_in_its_place() {
        for size in [[1, 1], [16, 16], [17, 33], [50, 3], [0, 0], [5, 0]] {
            let expected: Vec<f32> =
                (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x + 1000 * y) as f32)).collect();
            assert_eq!(coordinates(size), expected, "{size:?}");
        }
    }

    #[test]
    fn every_pixel_is_reported_once() {
        let pixels = std::sync::atomic::AtomicU64::new(0);
        let count = |n| {
            pixels.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
        };
        tiled([37, 21], &Task::new(), &count, || (), |(), _, _| 0.0).map(|_| ()).expect("nobody cancels");
        assert_eq!(pixels.into_inner(), 37 * 21);
    }

    #[test]
    fn a_cancelled_task_stops_the_tiles() {
        let task = Task::new();
        let stopped = tiled(
            [64, 64],
            &task,
            &|_| (),
            || (),
            |(), x, y| {
                if (x, y) == (20, 20) {
                    task.cancel();
                }
                0.0
            },
        );
        assert!(stopped.is_err());
    }

    #[test]
    fn neighbouring_shapes_have_different_colours() {
        for shape in 0..100 {
            let distance = shape_color(shape).distance(shape_color(shape + 1));
            assert!(distance > 0.02, "{shape}: {distance}");
        }
    }
}
