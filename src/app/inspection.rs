//! The rays of one pixel, or one that was drawn, and the step at which they are looked at.

use std::time::{Duration, Instant};

use crate::geometry::Ray;
use crate::inspect::ray_history::RayHistory;
use crate::inspect::ray_tree::{PixelQuestion, PixelRay, RaySource, in_outline};
use crate::render::observer::RayKind;
use crate::scene::{Camera, ShadowRule};
use crate::world::{RayQuery, World};

use super::jobs::TreeKey;

/// Steps a second that a history can be played at, the middle one first.
pub const SPEEDS: [f32; 5] = [8.0, 2.0, 4.0, 20.0, 60.0];

/// Where rays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayOrigin {
    /// Those of a pixel, as seen by the camera of that moment.
    Pixel { camera: Camera, pixel: [u32; 2] },
    /// One that was typed in or drawn.
    Free(Ray),
}

/// What is asked of a ray, besides what its integrator asks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AskedAs {
    /// As the integrator asks it.
    #[default]
    Traced,
    Intersect,
    Occluded,
    Filtered,
}

impl AskedAs {
    pub const ALL: [Self; 4] = [Self::Traced, Self::Intersect, Self::Occluded, Self::Filtered];

    pub fn name(self) -> &'static str {
        match self {
            Self::Traced => "as traced",
            Self::Intersect => "intersect",
            Self::Occluded => "occluded",
            Self::Filtered => "filtered",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Traced => "the query that the integrator asks with this ray",
            Self::Intersect => "the nearest hit; of a shadow ray, on through what lets light pass",
            Self::Occluded => "any hit: stops at the first that is found",
            Self::Filtered => "any hit that blocks light: stops at the first that is found",
        }
    }

    /// The query for a ray that was traced with `traced`.
    pub fn query(self, traced: RayQuery, kind: RayKind, rule: ShadowRule) -> RayQuery {
        match self {
            Self::Traced => traced,
            Self::Intersect if kind == RayKind::Shadow => RayQuery::IntersectThrough(rule),
            Self::Intersect => RayQuery::Intersect,
            Self::Occluded => RayQuery::Occluded,
            Self::Filtered => RayQuery::OccludedFiltered(rule),
        }
    }
}

/// What the user has set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayView {
    pub origin: Option<RayOrigin>,
    /// `None`: as the view that is shown.
    pub source: Option<RaySource>,
    pub sample: u32,
    /// Index into the rays.
    pub chosen: usize,
    pub asked_as: AskedAs,
    /// Steps that have been made.
    pub step: usize,
    pub playing: bool,
    pub speed: f32,
    /// Whether steps are drawn in the viewport.
    pub drawn: bool,
    /// A drag in the viewport draws a ray instead of turning the camera.
    pub drawing: bool,
}

impl Default for RayView {
    fn default() -> Self {
        Self {
            origin: None,
            source: None,
            sample: 0,
            chosen: 0,
            asked_as: AskedAs::default(),
            step: usize::MAX,
            playing: false,
            speed: SPEEDS[0],
            drawn: true,
            drawing: false,
        }
    }
}

/// Which rays were asked for: equal questions, equal rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaysKey {
    pub tree: TreeKey,
    pub asked: RaysAsked,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RaysAsked {
    Pixel(PixelQuestion),
    Free(Ray),
}

/// The rays that were found.
#[derive(Clone, Debug)]
pub struct FoundRays {
    pub key: RaysKey,
    pub rays: Vec<PixelRay>,
    /// The order of an outline.
    pub order: Vec<usize>,
}

impl FoundRays {
    pub fn new(key: RaysKey, rays: Vec<PixelRay>) -> Self {
        Self { key, order: in_outline(&rays), rays }
    }

    /// The ray before or after one in the outline; the same at the ends.
    pub fn neighbour(&self, chosen: usize, forward: bool) -> usize {
        let at = self.order.iter().position(|i| *i == chosen).unwrap_or(0);
        let next = if forward { at + 1 } else { at.saturating_sub(1) };
        self.order.get(next.min(self.order.len().saturating_sub(1))).copied().unwrap_or(0)
    }
}

/// The chosen ray asked in three ways, the first as it is looked at.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Of which ray, and how it is asked.
    pub of: (RaysKey, usize, RayQuery),
    pub history: RayHistory,
    /// By `intersect`, `occluded`, and `occluded` with filter.
    pub ways: [RayHistory; 3],
}

impl Recorded {
    pub fn new(
        world: &World,
        key: RaysKey,
        chosen: usize,
        ray: &PixelRay,
        asked_as: AskedAs,
        rule: ShadowRule,
    ) -> Self {
        let query = asked_as.query(ray.query, ray.kind, rule);
        let record = |query| RayHistory::record(world, &ray.ray, query);
        let ways = [AskedAs::Intersect, AskedAs::Occluded, AskedAs::Filtered];
        Self {
            of: (key, chosen, query),
            history: record(query),
            ways: ways.map(|way| record(way.query(ray.query, ray.kind, rule))),
        }
    }
}

/// The rays at hand, and the clock of the player.
#[derive(Debug, Default)]
pub struct Inspection {
    pub view: RayView,
    pub found: Option<FoundRays>,
    pub recorded: Option<Recorded>,
    /// When the last step was played.
    played: Option<Instant>,
}

impl Inspection {
    /// The chosen ray.
    pub fn ray(&self) -> Option<&PixelRay> {
        self.found.as_ref()?.rays.get(self.view.chosen)
    }

    /// How many steps have been made of how many.
    pub fn step(&self) -> (usize, usize) {
        let count = self.recorded.as_ref().map_or(0, |r| r.history.steps.len());
        (self.view.step.min(count), count)
    }

    /// Makes the steps that are due; when the next one is.
    pub fn play(&mut self, now: Instant) -> Option<Duration> {
        let (step, count) = self.step();
        if !self.view.playing {
            self.played = None;
            return None;
        }
        if step >= count {
            self.view.playing = false;
            self.played = None;
            return None;
        }
        let a_step = Duration::from_secs_f32(1.0 / self.view.speed.max(0.1));
        let last = *self.played.get_or_insert(now);
        let due = (now.saturating_duration_since(last).as_secs_f32() * self.view.speed) as usize;
        if due > 0 {
            self.view.step = (step + due).min(count);
            self.played = Some(now);
        }
        Some(a_step)
    }

    /// Another scene is open.
    pub fn forget(&mut self) {
        let view = RayView { origin: None, chosen: 0, step: usize::MAX, playing: false, ..self.view };
        *self = Self { view, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;
    use crate::app::jobs::SceneKey;
    use crate::inspect::ray_tree::pixel_rays;
    use crate::render::RenderSettings;
    use crate::scene::builtin;
    use crate::task::Task;
    use std::sync::Arc;

    fn inspection() -> Inspection {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let config = BuildConfig::default();
        let world = World::build(Arc::clone(&scene), &config, &Task::new()).expect("nobody cancels");
        let question = PixelQuestion {
            camera: scene.camera,
            settings: RenderSettings { width: 32, height: 24, ..RenderSettings::default() },
            shadow_rule: ShadowRule::default(),
            source: RaySource::Whitted,
            sample: 0,
            pixel: [16, 20],
        };
        let tree = TreeKey { scene: SceneKey::for_tests(1), config, file: None };
        let key = RaysKey { tree, asked: RaysAsked::Pixel(question) };
        let rays = pixel_rays(&world, &question, &Task::new()).expect("nobody cancels");
        let recorded = Recorded::new(&world, key, 0, &rays[0], AskedAs::Traced, ShadowRule::default());
        let found = Some(FoundRays::new(key, rays));
        Inspection { found, recorded: Some(recorded), ..Inspection::default() }
    }

    #[test]
    fn a_history_is_played_to_its_end_and_stops() {
        let mut inspection = inspection();
        let start = Instant::now();
        inspection.view = RayView { step: 0, playing: true, speed: 10.0, ..inspection.view };
        assert!(inspection.play(start).is_some());
        assert_eq!(inspection.step().0, 0);
        inspection.play(start + Duration::from_millis(310));
        assert_eq!(inspection.step().0, 3);
        inspection.play(start + Duration::from_secs(900));
        let (step, count) = inspection.step();
        assert_eq!(step, count);
        assert_eq!(inspection.play(start + Duration::from_secs(901)), None);
        assert!(!inspection.view.playing);
    }

    #[test]
    fn the_next_ray_is_that_of_the_outline() {
        let inspection = inspection();
        let found = inspection.found.as_ref().expect("found");
        let mut seen = vec![found.order[0]];
        while seen.len() < found.order.len() {
            let next = found.neighbour(seen[seen.len() - 1], true);
            assert_eq!(found.neighbour(next, false), seen[seen.len() - 1]);
            seen.push(next);
        }
        assert_eq!(seen, found.order);
        assert_eq!(found.neighbour(seen[seen.len() - 1], true), seen[seen.len() - 1]);
    }

    #[test]
    fn the_three_ways_ask_the_same_ray() {
        let inspection = inspection();
        let recorded = inspection.recorded.as_ref().expect("recorded");
        assert!(recorded.ways.iter().all(|way| way.ray == recorded.history.ray));
        assert_eq!(recorded.ways[0].query, RayQuery::Intersect, "a camera ray");
        assert!(recorded.ways[1].counters.nodes_visited() <= recorded.ways[0].counters.nodes_visited());
    }
}
