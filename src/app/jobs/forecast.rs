//! What is predicted of a tree and what its rays pay, for the tree at hand and, when all is quiet, for those built before.

use std::sync::Arc;

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::prediction::Forecast;
use crate::render::RenderSettings;
use crate::render::ray_costs::ray_costs;
use crate::scene::{Camera, Scene};
use crate::task::Cancelled;
use crate::world::World;

/// From where rays are counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForecastView {
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
}

/// A tree, and from where it is looked at.
#[derive(Clone)]
pub struct ForecastRequest {
    pub tree: TreeKey,
    pub view: ForecastView,
    pub scene: Arc<Scene>,
    /// The tree itself, if it is at hand; else it is built again.
    pub world: Option<Arc<World>>,
    pub settings: RenderSettings,
}

pub type ForecastJob = Job<ForecastRequest, (TreeKey, ForecastView, Forecast)>;

pub fn job() -> ForecastJob {
    Job::new(Patience::None, PoolKind::Background, |run| {
        // When something changes the shell cancels, and asks again later.
        let _ = measure(run);
    })
}

fn measure(run: &Run<ForecastRequest, (TreeKey, ForecastView, Forecast)>) -> Result<(), Cancelled> {
    let _pass = run.context.gate.enter(run.task, OnLease::Finish)?;
    let ForecastRequest { tree, view, scene, world, settings } = run.request;
    let world = match world {
        Some(world) => Arc::clone(world),
        None => Arc::new(World::build(Arc::clone(scene), &tree.config, run.task)?),
    };
    let settings = RenderSettings { width: view.width, height: view.height, ..*settings };
    let ray_costs = ray_costs(&world, &view.camera, &settings, run.task)?;
    let sah_cost = world.figures.sah_cost.map(|cost| cost.total());
    // Rays first: EPO of a large tree takes its time.
    run.emit((*tree, *view, Forecast { sah_cost, epo: None, ray_costs }));
    let epo = world.epo(run.task)?.map(|epo| epo.total);
    run.emit((*tree, *view, Forecast { sah_cost, epo, ray_costs }));
    Ok(())
}
