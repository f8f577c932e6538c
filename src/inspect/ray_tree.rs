//! All rays of one pixel: the camera ray, what it bounces to, and the shadow rays of every hit.

use serde::Serialize;

use crate::accel::RayCounters;
use crate::geometry::{Hit, Ray};
use crate::render::observer::{RayKind, RayObserver, TracedRays};
use crate::render::pass::Pass;
use crate::render::path::{self, Estimator};
use crate::render::shadow::{self, FirstHit};
use crate::render::whitted::Whitted;
use crate::render::{RenderSettings, View};
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::{RayQuery, World};

/// Whose rays a pixel's are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RaySource {
    #[default]
    Whitted,
    Path,
    /// The one shadow ray of the shadow views.
    ShadowViews,
}

impl RaySource {
    pub const ALL: [Self; 3] = [Self::Whitted, Self::Path, Self::ShadowViews];

    pub fn name(self) -> &'static str {
        match self {
            Self::Whitted => "whitted",
            Self::Path => "path",
            Self::ShadowViews => "shadow views",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Whitted => "the rays of a Whitted picture: those that heatmaps count",
            Self::Path => "one path of the path tracer, for the sample that is set",
            Self::ShadowViews => "the camera ray and the one shadow ray that is asked three ways",
        }
    }

    /// Whose rays a view is made of.
    pub fn of(view: View) -> Self {
        match view {
            View::Path => Self::Path,
            View::ShadowIntersect
            | View::ShadowOccluded
            | View::ShadowFiltered
            | View::ShadowDifference
            | View::ShadowSaving => Self::ShadowViews,
            View::Whitted
            | View::Albedo
            | View::Normal
            | View::Depth
            | View::ShapeId
            | View::NodesVisited
            | View::BoxTests
            | View::ShapeTests
            | View::LeafVisits
            | View::RayCost
            | View::LeafDepth
            | View::LeafSize
            | View::LeafSahShare
            | View::LeafEpo
            | View::LeafFill
            | View::LeafRays
            | View::ParentOverlap
            | View::ParentEmptySpace
            | View::LeafId
            | View::Material => Self::Whitted,
        }
    }
}

/// A ray of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelRay {
    pub kind: RayKind,
    pub ray: Ray,
    /// Index of the ray from whose hit it goes on; `None` for the camera ray.
    pub parent: Option<usize>,
    /// The root is the camera ray.
    pub depth: usize,
    /// What was asked with it.
    pub query: RayQuery,
    /// The shape that it found.
    pub shape: Option<u32>,
    /// Where it hits that; of a shadow ray that stops early, too.
    pub t: Option<f32>,
    pub counters: RayCounters,
}

/// Which pixel, and which of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelQuestion {
    pub camera: Camera,
    /// Also the picture's size.
    pub settings: RenderSettings,
    pub shadow_rule: ShadowRule,
    pub source: RaySource,
    /// From 0; 0 goes through the pixel's centre.
    pub sample: u32,
    pub pixel: [u32; 2],
}

/// The rays of a pixel, each after its parent, as the integrators trace them.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn pixel_rays(world: &World, question: &PixelQuestion, task: &Task) -> Result<Vec<PixelRay>, Cancelled> {
    let PixelQuestion { camera, settings, shadow_rule, source, sample, pixel: [x, y] } = question;
    let size = [settings.width, settings.height];
    let pass = Pass::new(world, camera, size, settings, *shadow_rule, *sample);
    let mut collector = Collector::default();
    match source {
        RaySource::Whitted => {
            collector.shadow_query = RayQuery::OccludedFiltered(*shadow_rule);
            Whitted::new(world).radiance(&pass, &[[*x, *y]], &mut collector, task)?;
        }
        RaySource::Path => {
            let (ray, mut sampler) = (pass.camera_ray(*x, *y), pass.sampler(*x, *y));
            path::radiance(&pass, Estimator::Mis, ray, &mut sampler, &mut collector);
        }
        RaySource::ShadowViews => {
            let ray = pass.camera_ray(*x, *y);
            collector.told(RayKind::Camera, &ray, 0);
            let first = shadow::first_hit(&pass, [*x, *y], &ray, world.intersect(&ray, &mut ()));
            if let FirstHit::Asked { shadow_ray, .. } = first {
                collector.shadow_query = RayQuery::OccludedFiltered(*shadow_rule);
                collector.told(RayKind::Shadow, &shadow_ray, 0);
            }
        }
    }
    Ok(collector.rays.into_iter().map(|told| told.answered(world)).collect())
}

impl PixelRay {
    /// A ray that nobody traced, asked once.
    pub fn alone(world: &World, kind: RayKind, ray: &Ray, query: RayQuery) -> Self {
        Told { kind, ray: *ray, parent: None, depth: 0, query }.answered(world)
    }
}

/// A ray as an integrator told of it.
#[derive(Clone, Copy, Debug)]
struct Told {
    kind: RayKind,
    ray: Ray,
    parent: Option<usize>,
    depth: usize,
    query: RayQuery,
}

impl Told {
    fn answered(self, world: &World) -> PixelRay {
        let mut counters = RayCounters::default();
        let Self { kind, ray, parent, depth, query } = self;
        let hit: Option<Hit> = match query {
            RayQuery::Intersect => world.intersect(&ray, &mut counters),
            RayQuery::Occluded => at(world, &ray, world.occluded(&ray, &mut counters)),
            RayQuery::OccludedFiltered(rule) => {
                at(world, &ray, world.occluded_filtered(&ray, rule, &mut counters))
            }
            RayQuery::IntersectThrough(rule) => {
                at(world, &ray, world.occluded_by_intersect(&ray, rule, &mut counters))
            }
        };
        let (shape, t) = (hit.map(|h| h.shape), hit.map(|h| h.t));
        PixelRay { kind, ray, parent, depth, query, shape, t, counters }
    }
}

fn at(world: &World, ray: &Ray, shape: Option<u32>) -> Option<Hit> {
    world.hit_alone(ray, shape?)
}

/// Puts batches of rays into a tree.
#[derive(Debug)]
struct Collector {
    rays: Vec<Told>,
    /// Where the camera or bounce rays that were told of last begin.
    last: usize,
    shadow_query: RayQuery,
}

impl Default for Collector {
    fn default() -> Self {
        Self { rays: Vec::new(), last: 0, shadow_query: RayQuery::Occluded }
    }
}

impl Collector {
    fn told(&mut self, kind: RayKind, ray: &Ray, parent: usize) {
        let parent = (kind != RayKind::Camera).then_some(self.last + parent);
        let depth = parent.map_or(0, |parent| self.rays[parent].depth + 1);
        let query = if kind == RayKind::Shadow { self.shadow_query } else { RayQuery::Intersect };
        self.rays.push(Told { kind, ray: *ray, parent, depth, query });
    }
}

impl RayObserver for Collector {
    const COUNTS: bool = false;

    fn traced(&mut self, traced: &TracedRays) {
        let first = self.rays.len();
        for (ray, parent) in traced.rays.iter().zip(traced.parents) {
            self.told(traced.kind, ray, *parent as usize);
        }
        if traced.kind != RayKind::Shadow {
            self.last = first;
        }
    }
}

/// The order of an outline: each ray right after its parent and what comes of its elder siblings, shadow rays first.
pub fn in_outline(rays: &[PixelRay]) -> Vec<usize> {
    let mut children = vec![Vec::new(); rays.len()];
    let mut roots = Vec::new();
    for (i, ray) in rays.iter().enumerate() {
        match ray.parent {
            Some(parent) => children[parent].push(i),
            None => roots.push(i),
        }
    }
    let (mut open, mut order) = (roots, Vec::new());
    open.reverse();
    while let Some(i) = open.pop() {
        order.push(i);
        let mut below = std::mem::take(&mut children[i]);
        below.sort_by_key(|&child| (rays[child].kind != RayKind::Shadow, child));
        open.extend(below.into_iter().rev());
    }
    order
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::render::CountKind;
    use crate::render::measure::count_rays;
    use crate::scene::builtin;

    fn question(world: &World, source: RaySource, pixel: [u32; 2], sample: u32) -> PixelQuestion {
        let settings = RenderSettings { width: 24, height: 16, ..RenderSettings::default() };
        let shadow_rule = ShadowRule::Glass;
        PixelQuestion { camera: world.scene.camera, settings, shadow_rule, source, sample, pixel }
    }

    fn world(name: &str) -> World {
        let scene = Arc::new(builtin::make(name).expect("a built-in scene"));
        World::build(scene, &BuildConfig::default(), &Task::new()).expect("nobody cancels")
    }

    fn check(rays: &[PixelRay]) {
        assert_eq!(rays[0].kind, RayKind::Camera);
        for ray in &rays[1..] {
            let parent = &rays[ray.parent.expect("only the camera ray has none")];
            assert_eq!(ray.depth, parent.depth + 1);
            assert_ne!(parent.kind, RayKind::Shadow);
            let hit = parent.ray.at(parent.t.expect("rays go on from hits"));
            let scale = 1e-3 * (1.0 + hit.abs().max_element());
            assert!(hit.distance(ray.ray.origin) < scale, "{hit} {}", ray.ray.origin);
        }
        let mut order = in_outline(rays);
        for pair in order.windows(2) {
            assert!(rays[pair[1]].depth <= rays[pair[0]].depth + 1);
        }
        order.sort_unstable();
        assert!(order.into_iter().eq(0..rays.len()));
        assert!(rays.iter().all(|r| r.shape.is_none() == r.t.is_none()));
    }

    #[test]
    fn rays_go_on_from_the_hits_of_their_parents() {
        let world = world("bunny");
        for source in RaySource::ALL {
            for (x, y) in (0..24).flat_map(|x| (0..16).map(move |y| (x, y))) {
                let question = question(&world, source, [x, y], (x + y) % 3);
                check(&pixel_rays(&world, &question, &Task::new()).expect("nobody cancels"));
            }
        }
    }

    #[test]
    fn the_rays_of_all_pixels_are_those_of_the_frame() {
        let world = world("room");
        let mut visits = 0;
        let mut count = 0;
        for (x, y) in (0..24).flat_map(|x| (0..16).map(move |y| (x, y))) {
            let question = question(&world, RaySource::Whitted, [x, y], 0);
            for ray in pixel_rays(&world, &question, &Task::new()).expect("nobody cancels") {
                visits += ray.counters.nodes_visited();
                count += 1;
            }
        }
        let settings = RenderSettings { width: 24, height: 16, ..RenderSettings::default() };
        let figures = count_rays(&world, &world.scene.camera, &settings, CountKind::All, 1, &Task::new());
        let figures = figures.expect("nobody cancels");
        assert_eq!(figures.ray_count, count);
        let mean = visits as f64 / count as f64;
        assert!((figures.nodes_visited_mean.expect("counted") - mean).abs() < 1e-9);
    }

    #[test]
    fn a_shadow_view_asks_one_shadow_ray() {
        let world = world("cornell");
        let mut asked = 0;
        for x in 0..24 {
            let question = question(&world, RaySource::ShadowViews, [x, 9], 0);
            let rays = pixel_rays(&world, &question, &Task::new()).expect("nobody cancels");
            let kinds: Vec<RayKind> = rays.iter().map(|r| r.kind).collect();
            match &kinds[..] {
                [RayKind::Camera] => {}
                [RayKind::Camera, RayKind::Shadow] => asked += 1,
                _ => panic!("{kinds:?}"),
            }
        }
        assert!(asked > 5, "{asked}");
    }
}
