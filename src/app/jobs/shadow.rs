//! Counting the pixel classes of the shadow views, and the nodes that each way of asking visits.

use std::sync::Arc;

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::shadow_difference::{ClassCounts, shadow_nodes_mean};
use crate::render::film::FilmSubject;
use crate::render::integrate::render;
use crate::render::{CountKind, RenderSettings, View};
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Shadow rays whose nodes are counted, about.
const NODE_RAYS: u64 = 40_000;

/// What the counts depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowKey {
    pub tree: TreeKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub rule: ShadowRule,
}

#[derive(Clone)]
pub struct ShadowRequest {
    pub key: ShadowKey,
    pub world: Arc<World>,
    pub settings: RenderSettings,
}

/// The shadow rays of a picture, asked three ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowFigures {
    pub counts: ClassCounts,
    /// Nodes visited a ray by `intersect`, by plain `occluded`, by the filtered one; `None` if no ray was asked.
    pub nodes_mean: Option<[f64; 3]>,
}

pub type ShadowJob = Job<ShadowRequest, (ShadowKey, ShadowFigures)>;

pub fn job() -> ShadowJob {
    Job::new(Patience::None, PoolKind::Background, |run: &Run<ShadowRequest, _>| {
        let Ok(_pass) = run.context.gate.enter(run.task, OnLease::Finish) else { return };
        let ShadowRequest { key, world, settings } = run.request;
        let settings = RenderSettings { width: key.width, height: key.height, ..*settings };
        if let Ok(figures) = ask(world, &key.camera, &settings, key.rule, run.task) {
            run.emit((*key, figures));
        }
    })
}

/// Asks the shadow ray of every pixel for the classes, and of a fixed part of them for the nodes. In the current pool.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn ask(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    rule: ShadowRule,
    task: &Task,
) -> Result<ShadowFigures, Cancelled> {
    let subject =
        FilmSubject { view: View::ShadowDifference, count: CountKind::default(), shadow_rule: rule };
    let film = render(subject, world, camera, settings, 1, &task.step())?;
    let counts = ClassCounts::of(&film).expect("a film of classes");
    let stride = super::figures::stride(settings, NODE_RAYS);
    let nodes_mean = shadow_nodes_mean(world, camera, settings, rule, stride, &task.step())?;
    Ok(ShadowFigures { counts, nodes_mean })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;
    use crate::scene::builtin;

    #[test]
    fn every_pixel_has_a_class_and_the_early_out_saves_nodes() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let camera = scene.camera;
        let task = Task::new();
        let world = World::build(scene, &BuildConfig::default(), &task).expect("not cancelled");
        let settings = RenderSettings { width: 48, height: 32, ..Default::default() };
        let figures = ask(&world, &camera, &settings, ShadowRule::Glass, &task).expect("not cancelled");
        assert_eq!(figures.counts.0.iter().sum::<u64>(), 48 * 32);
        let [intersect, occluded, _] = figures.nodes_mean.expect("rays were asked");
        assert!(intersect > occluded, "{intersect} nodes against {occluded}");
    }
}
