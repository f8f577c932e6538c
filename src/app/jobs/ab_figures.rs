//! Every figure of two trees, and the mean ray cost of both with its confidence: in the background.

use std::sync::Arc;

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::compare::Comparison;
use crate::inspect::paired_cost::PairedRayCost;
use crate::inspect::stats::tree_stats;
use crate::render::{CountKind, RenderSettings};
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// What the figures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbKey {
    pub trees: [TreeKey; 2],
    pub cameras: [Camera; 2],
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    pub max_depth: u32,
    pub count: CountKind,
    /// Whether frames are timed, with nothing else running.
    pub timed: bool,
}

#[derive(Clone)]
pub struct AbFiguresRequest {
    pub key: AbKey,
    pub names: [String; 2],
    pub worlds: [Arc<World>; 2],
    pub settings: RenderSettings,
}

pub type AbFiguresJob = Job<AbFiguresRequest, (AbKey, Box<Comparison>)>;

pub fn job() -> AbFiguresJob {
    Job::new(Patience::None, PoolKind::Work, |run| {
        if let Ok(comparison) = measure(run) {
            run.emit((run.request.key, Box::new(comparison)));
        }
    })
}

fn measure(run: &Run<AbFiguresRequest, (AbKey, Box<Comparison>)>) -> Result<Comparison, Cancelled> {
    if !run.request.key.timed {
        let _pass = run.context.gate.enter(run.task, OnLease::Finish)?;
        return figures(run.request, run.task);
    }
    // This thread waits for the lease. The pool that measures must have all of its own.
    let pool = run.context.pools().get(PoolKind::Measure);
    let _lease = run.context.gate.lease(run.task)?;
    pool.install(|| figures(run.request, run.task))
}

fn figures(request: &AbFiguresRequest, task: &Task) -> Result<Comparison, Cancelled> {
    let AbFiguresRequest { key, names, worlds, settings } = request;
    task.start(3);
    let stats = |i: usize| {
        let (world, camera) = (&worlds[i], &key.cameras[i]);
        let stats = tree_stats(&names[i], world, camera, settings, key.count, key.timed, &task.step())?;
        task.advance(1);
        Ok(stats)
    };
    let mut comparison = Comparison::of(stats(0)?, stats(1)?);
    let [a, b] = &key.cameras;
    comparison.ray_cost = PairedRayCost::measure([&worlds[0], &worlds[1]], [a, b], settings, &task.step())?;
    task.advance(1);
    Ok(comparison)
}
