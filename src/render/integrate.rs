//! Adds samples to a film: picks the integrator for the view and runs it over tiles.

use glam::Vec3;

use super::film::{Film, FilmContent, FilmSubject, RenderSettings};
use super::observer::CountPixels;
use super::pass::Pass;
use super::path::{self, Estimator};
use super::sampler::scramble;
use super::shadow::{self, ShadowQuery};
use super::tiles::{Tiled, add, camera_tiled, counted_tiled, tiled, tiles};
use super::tonemap::srgb_decode;
use super::views::{CountKind, Counter, View};
use super::visits::{self, shape_values};
use super::whitted::Whitted;
use crate::accel::RayCounters;
use crate::scene::{Camera, MaterialKind, Surface};
use crate::task::{Cancelled, Task};
use crate::world::{NodeFigure, World};

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
    let shadow = |query| {
        camera_tiled(pass, size, task, finished, move |at, ray, hit| {
            shadow::shaded(pass, query, &shadow::first_hit(pass, at, ray, hit))
        })
    };
    let surface = |color: fn(&Pass, &Surface) -> Vec3| {
        camera_tiled(pass, size, task, finished, move |_, ray, hit| {
            hit.map_or(Vec3::ZERO, |hit| color(pass, &pass.world.scene.surface(ray, &hit)))
        })
    };
    match view {
        View::Path => tiled(
            size,
            task,
            finished,
            || (),
            |(), x, y| {
                let ray = pass.camera_ray(x, y);
                only_finite(path::radiance(pass, Estimator::Mis, ray, &mut pass.sampler(x, y), &mut ()))
            },
        ),
        View::Whitted => whitted_frame(pass, size, task, finished),
        View::Albedo => surface(albedo),
        View::Normal => surface(|_, surface| shown_as(0.5 * surface.shading_normal + 0.5)),
        View::ShapeId => surface(|_, surface| shown_as(shape_color(surface.shape))),
        View::Material => surface(|_, surface| shown_as(shape_color(surface.material))),
        View::LeafId => {
            let leaves = shape_values(pass.world, NodeFigure::Unique, &[], &task.step())?;
            camera_tiled(pass, size, task, finished, move |_, _, hit| {
                let leaf = hit.and_then(|hit| leaves.get(hit.shape as usize).copied());
                // A shape outside the tree is in no leaf.
                leaf.map_or(Vec3::ZERO, |leaf| shown_as(shape_color(leaf.to_bits())))
            })
        }
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
        | View::ShadowSaving
        | View::LeafDepth
        | View::LeafSize
        | View::LeafSahShare
        | View::LeafEpo
        | View::LeafFill
        | View::LeafRays
        | View::ParentOverlap
        | View::ParentEmptySpace => unreachable!("a film of {} holds numbers", view.name()),
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
        if subject.count == CountKind::Camera {
            return counted_tiled(pass, size, task, finished, |counters| number(pass, counters) as f32);
        }
        let state = || (Whitted::new(pass.world), CountPixels::new(subject.count));
        tiles(size, task, finished, state, |(whitted, rays), pixels, values| {
            rays.restart(pixels.len());
            whitted.radiance(pass, pixels, rays, task)?;
            for (value, counters) in values.iter_mut().zip(rays.counters()) {
                *value = number(pass, counters) as f32;
            }
            Ok(())
        })
    };
    if let Some(figure) = subject.view.leaf_figure() {
        let values = leaf_values(pass, figure, size, task)?;
        return camera_tiled(pass, size, task, finished, |_, _, hit| {
            hit.and_then(|hit| values.get(hit.shape as usize).copied()).unwrap_or(f32::NAN)
        });
    }
    match subject.view.counter() {
        Some(Counter::NodesVisited) => counted(|_, c| c.nodes_visited() as f64),
        Some(Counter::BoxTests) => counted(|_, c| c.box_tests as f64),
        Some(Counter::ShapeTests) => counted(|_, c| c.shape_tests as f64),
        Some(Counter::LeafVisits) => counted(|_, c| c.leaf_visits as f64),
        Some(Counter::RayCost) => counted(|pass, c| {
            let config = &pass.world.report.config;
            c.ray_cost(config.traversal_cost, config.intersection_cost)
        }),
        Some(Counter::ShadowSaving) => camera_tiled(pass, size, task, finished, |at, ray, hit| {
            let answers = shadow::answers(pass, &shadow::first_hit(pass, at, ray, hit));
            answers.map_or(f32::NAN, |answers| answers.nodes_saved() as f32)
        }),
        None if subject.view == View::ShadowDifference => {
            camera_tiled(pass, size, task, finished, |at, ray, hit| {
                f32::from(shadow::class(pass, &shadow::first_hit(pass, at, ray, hit)) as u8)
            })
        }
        None => camera_tiled(pass, size, task, finished, |_, _, hit| hit.map_or(f32::NAN, |hit| hit.t)),
    }
}

/// A figure of the leaf of each shape, or of the node above it where the figure is one of inner nodes.
fn leaf_values(pass: &Pass, figure: NodeFigure, size: [u32; 2], task: &Task) -> Result<Vec<f32>, Cancelled> {
    let visits = match figure {
        NodeFigure::Visits => visits::camera_visits(pass, size, task)?,
        _ => Vec::new(),
    };
    shape_values(pass.world, figure, &visits, &task.step())
}

/// One sample of every pixel of a Whitted picture.
pub(super) fn whitted_frame(
    pass: &Pass,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
) -> Result<Tiled<Vec3>, Cancelled> {
    let state = || Whitted::new(pass.world);
    tiles(size, task, finished, state, |whitted, pixels, values| {
        let found = whitted.radiance(pass, pixels, &mut (), task)?;
        for (value, &color) in values.iter_mut().zip(found) {
            *value = only_finite(color);
        }
        Ok(())
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_shapes_have_different_colours() {
        for shape in 0..100 {
            let distance = shape_color(shape).distance(shape_color(shape + 1));
            assert!(distance > 0.02, "{shape}: {distance}");
        }
    }
}
