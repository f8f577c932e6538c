//! A ray that somebody watches step by step, and everything about the scene that its steps need.

use super::store::Beyond;
use super::{Best, World};
use crate::accel::traverse::{self, Step, Watch};
use crate::geometry::{Hit, PreparedRay, Ray, Shape};
use crate::scene::ShadowRule;

/// What is asked with a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayQuery {
    /// [`World::intersect`].
    Intersect,
    /// [`World::occluded_by_intersect`].
    IntersectThrough(ShadowRule),
    /// [`World::occluded`].
    Occluded,
    /// [`World::occluded_filtered`].
    OccludedFiltered(ShadowRule),
}

impl RayQuery {
    pub fn name(self) -> &'static str {
        match self {
            Self::Intersect | Self::IntersectThrough(_) => "intersect",
            Self::Occluded => "occluded",
            Self::OccludedFiltered(_) => "occluded with filter",
        }
    }

    /// One sentence for tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Intersect => "the nearest hit",
            Self::IntersectThrough(_) => {
                "nearest hits one after the other, going on through what lets light pass"
            }
            Self::Occluded => "any hit at all: stops at the first that is found",
            Self::OccludedFiltered(_) => "any hit that blocks light: stops at the first that is found",
        }
    }

    /// Whether it stops at the first hit that counts, in whatever order leaves come.
    pub fn stops_early(self) -> bool {
        match self {
            Self::Intersect | Self::IntersectThrough(_) => false,
            Self::Occluded | Self::OccludedFiltered(_) => true,
        }
    }
}

/// One thing that happens to a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Watched<'a> {
    /// The walk of the tree begins (again, past the last hit), from `t_min` on.
    Walk {
        t_min: f32,
    },
    Step(Step<'a>),
    /// The walk is over with this hit of a shape, which may lie outside the tree.
    Found {
        shape: u32,
        t: Option<f32>,
    },
}

impl World {
    /// Asks a ray and tells `watcher` of every step: the shape that is the answer, if there is one. The same answer and the
    /// same visits as those of the query that is named.
    pub fn watch(&self, ray: &Ray, query: RayQuery, watcher: &mut dyn FnMut(Watched)) -> Option<u32> {
        match query {
            RayQuery::Intersect => self.watch_nearest(ray, None, watcher).map(|hit| hit.shape),
            RayQuery::IntersectThrough(rule) => {
                let blocks = self.blockers.under(rule);
                let mut hit = self.watch_nearest(ray, None, watcher)?;
                while !blocks(hit.shape) {
                    let rest = Ray { t_min: hit.t, ..*ray };
                    hit = self.watch_nearest(&rest, Some(&hit), watcher)?;
                }
                Some(hit.shape)
            }
            RayQuery::Occluded => self.watch_any(ray, |_| true, watcher),
            RayQuery::OccludedFiltered(rule) => self.watch_any(ray, self.blockers.under(rule), watcher),
        }
    }

    fn watch_nearest(
        &self,
        ray: &Ray,
        beyond: Option<&Hit>,
        watcher: &mut dyn FnMut(Watched),
    ) -> Option<Hit> {
        watcher(Watched::Walk { t_min: ray.t_min });
        let beyond = beyond.map(|hit| Beyond { store: &self.store, t: hit.t, shape: hit.shape });
        let mut best = Best::new(Hit::none(ray.last()));
        let mut tell = |step: Step| watcher(Watched::Step(step));
        let mut watch = Watch(&mut tell);
        match &beyond {
            None => {
                self.outside_nearest(ray, |_| ray.t_min, &mut best);
                traverse::watch_nearest(&self.tree, &self.store, ray, &mut best, &mut watch);
            }
            Some(beyond) => {
                self.outside_nearest(ray, |shape| beyond.t_min(shape), &mut best);
                traverse::watch_nearest(&self.tree, beyond, ray, &mut best, &mut watch);
            }
        }
        let hit = *best.exact(ray);
        let hit = hit.is_some().then_some(hit)?;
        watcher(Watched::Found { shape: hit.shape, t: Some(hit.t) });
        Some(hit)
    }

    fn watch_any(
        &self,
        ray: &Ray,
        blocks: impl Fn(u32) -> bool,
        watcher: &mut dyn FnMut(Watched),
    ) -> Option<u32> {
        watcher(Watched::Walk { t_min: ray.t_min });
        let mut found = self.outside_stops(ray, &blocks);
        if found.is_none() {
            let mut tell = |step: Step| watcher(Watched::Step(step));
            found = traverse::watch_any(&self.tree, &self.store, ray, &blocks, &mut Watch(&mut tell));
        }
        let shape = found?;
        watcher(Watched::Found { shape, t: None });
        Some(shape)
    }

    /// Where a ray hits a shape, whatever else is in the way; also one outside the tree.
    pub fn hit_alone(&self, ray: &Ray, shape: u32) -> Option<Hit> {
        let prepared = PreparedRay::new(*ray);
        let found = if (shape as usize) < self.scene.shape_count() {
            self.scene.shape(shape).intersect(&prepared)
        } else {
            self.scene.unbounded().find(|(index, ..)| *index == shape)?.1.intersect(&prepared)
        };
        found.map(|hit| Hit { t: hit.t, shape, u: hit.u, v: hit.v })
    }

    /// Whether a shape stops light under a rule.
    pub fn blocks(&self, shape: u32, rule: ShadowRule) -> bool {
        self.blockers.under(rule)(shape)
    }

    /// The shapes of a leaf in the order in which they are tested: triangles in blocks of four, each of which is tested
    /// whole, then one by one the spheres, cuboids, quads and tori. A number a test: those of a block share one.
    pub fn test_order(&self, leaf_idx: u32) -> Vec<(u32, usize)> {
        let shapes = self.tree.leaf_shapes(leaf_idx);
        let rank = |shape: &u32| match self.scene.shape(*shape) {
            Shape::Triangle(_) => 0,
            Shape::Sphere(_) => 1,
            Shape::Cuboid(_) => 2,
            Shape::Quad(_) => 3,
            Shape::Torus(_) => 4,
        };
        let mut order: Vec<u32> = shapes.to_vec();
        order.sort_by_key(rank);
        let triangles = order.iter().filter(|shape| rank(shape) == 0).count();
        let blocks = triangles.div_ceil(super::block::LANES);
        let test = |i: usize| if i < triangles { i / super::block::LANES } else { blocks + i - triangles };
        order.iter().enumerate().map(|(i, &shape)| (shape, test(i))).collect()
    }
}
