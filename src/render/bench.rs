//! Sets of rays of one kind, and how fast a world answers them.

use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use super::bsdf::{ShadingFrame, cosine_weighted};
use super::film::RenderSettings;
use super::pass::Pass;
use super::sampler::Sampler;
use super::tiles::{BLOCK, in_blocks};
use crate::geometry::{Hit, Ray};
use crate::scene::{Camera, ShadowRule, Surface};
use crate::task::{Cancelled, Task};
use crate::world::{Packets, World};

/// The seed of the diffuse and shadow sets; the session's own does not change them.
const SEED: u64 = 1;

/// Rays that a thread takes at once.
const CHUNK: usize = 1024;

/// Times that a set is traced, unless that takes longer than [`SECONDS_MAX`]; the median counts.
const REPEATS: usize = 5;
const SECONDS_MAX: f64 = 2.0;

/// What a ray asks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Query {
    /// The nearest hit.
    #[default]
    Intersect,
    /// Any hit.
    Occluded,
}

impl Query {
    pub const ALL: [Self; 2] = [Self::Intersect, Self::Occluded];

    pub fn name(self) -> &'static str {
        match self {
            Self::Intersect => "intersect",
            Self::Occluded => "occluded",
        }
    }
}

/// Which rays of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RaySetKind {
    /// Through the centre of every pixel.
    Primary,
    /// From every primary hit, one cosine-weighted bounce whatever the material.
    Diffuse,
    /// From every primary hit to one point of a light, where the light is before the surface.
    Shadow,
}

impl RaySetKind {
    pub const ALL: [Self; 3] = [Self::Primary, Self::Diffuse, Self::Shadow];

    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Diffuse => "diffuse",
            Self::Shadow => "shadow",
        }
    }

    pub fn query(self) -> Query {
        match self {
            Self::Primary | Self::Diffuse => Query::Intersect,
            Self::Shadow => Query::Occluded,
        }
    }
}

/// Rays that all ask the same.
#[derive(Clone, Debug, PartialEq)]
pub struct RaySet {
    pub rays: Vec<Ray>,
    pub query: Query,
}

/// The answers to a set, and how long they took.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceResult {
    pub ray_count: usize,
    pub hit_count: usize,
    /// The sum of the hits' answers: of t for `intersect`, their number for `occluded`.
    pub sum_t: f64,
    /// Wall time of tracing the set once, median of up to 5.
    pub seconds: f64,
    /// A ray an entry: for `intersect` the hit's t, infinity for a miss; for `occluded` 1 or 0.
    pub answers: Vec<f32>,
}

impl TraceResult {
    /// Millions of rays a second; `None` for no rays.
    pub fn mrays_per_s(&self) -> Option<f64> {
        (self.ray_count > 0 && self.seconds > 0.0).then(|| self.ray_count as f64 / self.seconds * 1e-6)
    }
}

/// The rays of a picture of the size in `settings`, square by square of 8 x 8 pixels. The same for any settings of the tree
/// and at any number of threads.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn make_rays(
    kind: RaySetKind,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<RaySet, Cancelled> {
    let size = [settings.width, settings.height];
    let pass = Pass::new(world, camera, size, settings, ShadowRule::default(), 0);
    let [width, height] = size.map(|s| s as usize);
    let bands: Vec<Vec<Ray>> = (0..height.div_ceil(BLOCK))
        .into_par_iter()
        .map(|band| {
            let (top, bottom) = (band * BLOCK, height.min((band + 1) * BLOCK));
            let mut rays = Vec::with_capacity(width * (bottom - top));
            let mut pixels = Vec::new();
            in_blocks([0, top], [width, bottom], &mut pixels);
            for [x, y] in pixels {
                task.check()?;
                rays.extend(ray_of(kind, &pass, x, y));
            }
            Ok(rays)
        })
        .collect::<Result<_, _>>()?;
    Ok(RaySet { rays: bands.concat(), query: kind.query() })
}

/// Traces a set on `threads` threads (0 for all), ray by ray or in packets of those that follow each other.
pub fn trace_rays(world: &World, set: &RaySet, threads: usize, in_packets: bool) -> TraceResult {
    let mut answers = vec![0.0f32; set.rays.len()];
    let distance = |hit: &Option<Hit>| hit.map_or(f32::INFINITY, |hit| hit.t);
    let stopped = |stopped: bool| f32::from(u8::from(stopped));
    let mut trace = || {
        let pieces = set.rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
        pieces.for_each_init(
            || Packets::new(world),
            |packets, (rays, answers)| match (set.query, in_packets) {
                (Query::Intersect, false) => {
                    fill(answers, rays, |ray| distance(&world.intersect(ray, &mut ())));
                }
                (Query::Intersect, true) => fill(answers, packets.intersect(rays), distance),
                (Query::Occluded, false) => {
                    fill(answers, rays, |ray| stopped(world.occluded(ray, &mut ()).is_some()));
                }
                (Query::Occluded, true) => fill(answers, packets.occluded(rays), |found| stopped(*found)),
            },
        );
    };
    let mut measure = || {
        let mut seconds = Vec::with_capacity(REPEATS);
        while seconds.len() < REPEATS && seconds.iter().sum::<f64>() < SECONDS_MAX {
            let start = Instant::now();
            trace();
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    };
    let seconds = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(measure),
        // The system gives no more threads: the ones there are must do.
        Err(_) => measure(),
    };
    let is_hit = |answer: &&f32| match set.query {
        Query::Intersect => answer.is_finite(),
        Query::Occluded => **answer > 0.0,
    };
    TraceResult {
        ray_count: set.rays.len(),
        hit_count: answers.iter().filter(is_hit).count(),
        sum_t: answers.iter().filter(is_hit).map(|t| f64::from(*t)).sum(),
        seconds,
        answers,
    }
}

/// An answer for each of `asked`.
fn fill<T>(answers: &mut [f32], asked: &[T], answer: impl Fn(&T) -> f32) {
    for (to, asked) in answers.iter_mut().zip(asked) {
        *to = answer(asked);
    }
}

/// The ray of a pixel, if it has one in that set.
fn ray_of(kind: RaySetKind, pass: &Pass, x: u32, y: u32) -> Option<Ray> {
    let ray = pass.camera_ray(x, y);
    let mut sampler = Sampler::new(SEED, [x, y], 0);
    match kind {
        RaySetKind::Primary => Some(ray),
        RaySetKind::Diffuse => {
            let (surface, frame) = first_surface(pass, &ray)?;
            let direction = cosine_weighted(frame.geometric_normal, sampler.next_2d());
            Some(Ray::new(surface.ray_origin(direction), direction))
        }
        RaySetKind::Shadow => {
            let (surface, frame) = first_surface(pass, &ray)?;
            let pick = sampler.next_fine();
            let light = pass.lights.sample_lights(&surface, &frame, pick, sampler.next_2d())?;
            let before = frame.geometric_normal.dot(light.direction) > 0.0;
            (before && light.radiance != Vec3::ZERO).then_some(light.shadow_ray)
        }
    }
}

fn first_surface(pass: &Pass, ray: &Ray) -> Option<(Surface, ShadingFrame)> {
    let hit = pass.world.intersect(ray, &mut ())?;
    let surface = pass.world.scene.surface(ray, &hit);
    Some((surface, ShadingFrame::new(&surface, ray.direction)))
}
