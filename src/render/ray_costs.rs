//! What the three kinds of rays pay on average: what the figures of a tree's boxes try to predict.

use rayon::prelude::*;
use serde::Serialize;

use super::bench::{Query, RaySetKind, make_rays};
use super::film::RenderSettings;
use crate::accel::RayCounters;
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Rays of a kind that are counted, at most: enough for a mean to three digits.
const MOST_RAYS: u64 = 40_000;

/// Rays that a thread takes at once.
const CHUNK: usize = 512;

/// Mean ray cost, `C_t * inner visits + C_i * shape tests` per ray, of each kind of [`RaySetKind`]; `None` where no ray was
/// asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RayCosts {
    pub primary: Option<f64>,
    pub diffuse: Option<f64>,
    pub shadow: Option<f64>,
}

impl RayCosts {
    pub fn of(&self, kind: RaySetKind) -> Option<f64> {
        match kind {
            RaySetKind::Primary => self.primary,
            RaySetKind::Diffuse => self.diffuse,
            RaySetKind::Shadow => self.shadow,
        }
    }
}

/// Counts rays of the three kinds from this camera, through every n-th pixel of a picture of the size in `settings`. The same
/// at any number of threads; at most 40,000 of a kind.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn ray_costs(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<RayCosts, Cancelled> {
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let stride = (pixels as f64 / MOST_RAYS as f64).sqrt().max(1.0);
    let coarse = |size: u32| ((f64::from(size) / stride) as u32).max(1);
    let settings =
        RenderSettings { width: coarse(settings.width), height: coarse(settings.height), ..*settings };
    let mean = |kind| {
        let set = make_rays(kind, world, camera, &settings, task)?;
        let counters = set.rays.par_chunks(CHUNK).map(|rays| {
            task.check()?;
            let mut counters = RayCounters::default();
            for ray in rays {
                match set.query {
                    Query::Intersect => drop(world.intersect(ray, &mut counters)),
                    Query::Occluded => drop(world.occluded(ray, &mut counters)),
                }
            }
            Ok(counters)
        });
        // Sums of integers: the same in any order.
        let sum = counters.try_reduce(RayCounters::default, |a, b| Ok(a + b))?;
        let config = &world.report.config;
        let cost = sum.ray_cost(config.traversal_cost, config.intersection_cost);
        Ok((!set.rays.is_empty()).then(|| cost / set.rays.len() as f64))
    };
    Ok(RayCosts {
        primary: mean(RaySetKind::Primary)?,
        diffuse: mean(RaySetKind::Diffuse)?,
        shadow: mean(RaySetKind::Shadow)?,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::render::CountKind;
    use crate::render::measure::count_rays;
    use crate::scene::builtin;

    fn world(scene: &str, builder: Builder) -> World {
        let scene = Arc::new(builtin::make(scene).expect("a built-in scene"));
        let config = BuildConfig { builder, traversal_cost: 1.5, ..BuildConfig::default() };
        World::build(scene, &config, &Task::new()).expect("nobody cancels")
    }

    #[test]
    fn primary_rays_are_the_camera_rays_of_every_other_figure() {
        let world = world("bunny", Builder::Binned);
        let settings = RenderSettings { width: 64, height: 36, ..RenderSettings::default() };
        let camera = world.scene.camera;
        let costs = ray_costs(&world, &camera, &settings, &Task::new()).expect("nobody cancels");
        let counted = count_rays(&world, &camera, &settings, CountKind::Camera, 1, &Task::new());
        assert_eq!(costs.primary, counted.expect("nobody cancels").ray_cost_mean);
        assert!(RaySetKind::ALL.into_iter().all(|kind| costs.of(kind).is_some_and(|cost| cost > 1.0)));
    }

    #[test]
    fn a_bad_tree_is_dearer_for_every_kind_and_what_is_not_asked_has_no_mean() {
        let settings = RenderSettings { width: 100, height: 60, ..RenderSettings::default() };
        let costs = |builder| {
            let world = world("bunny", builder);
            ray_costs(&world, &world.scene.camera, &settings, &Task::new()).expect("nobody cancels")
        };
        let (good, bad) = (costs(Builder::Binned), costs(Builder::Random));
        for kind in RaySetKind::ALL {
            assert!(bad.of(kind) > good.of(kind), "{kind:?}: {bad:?} {good:?}");
        }
        let empty =
            World::build(Arc::default(), &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let none = ray_costs(&empty, &Camera::default(), &settings, &Task::new()).expect("nobody cancels");
        assert_eq!((none.primary, none.diffuse, none.shadow), (Some(0.0), None, None));
    }
}
