//! A sweep in the background, with nothing else running: a point after the other, so that each is shown when it is there.

use std::sync::Arc;
use std::time::Duration;

use super::keys::SceneKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::BuildConfig;
use crate::inspect::best::{Best, Search};
use crate::inspect::stats::Measurement;
use crate::inspect::sweep::{SweepEvent, SweepGrid, SweepPoint, Sweeper};
use crate::render::{CountKind, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::task::Cancelled;

/// Builds of each tree; the build time is their median.
pub const BUILDS: usize = 3;

/// What is to be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan {
    pub grid: SweepGrid,
    /// Instead of the grid.
    pub search: Option<Search>,
    /// Whether a frame is timed with every tree, too.
    pub timed: bool,
    /// The settings that everything else is taken from.
    pub base: BuildConfig,
}

/// What points depend on besides their settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepKey {
    pub scene: SceneKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub max_depth: u32,
    pub threads: usize,
    pub count: CountKind,
}

#[derive(Clone)]
pub struct SweepRequest {
    pub plan: SweepPlan,
    pub scene: Arc<Scene>,
    pub camera: Camera,
    pub settings: RenderSettings,
    pub count: CountKind,
    /// C_t and C_i of all figures.
    pub costs: [f32; 2],
    pub known: Vec<SweepPoint>,
}

pub enum SweepMessage {
    Started { name: String },
    Point { point: Box<SweepPoint>, took: Option<Duration> },
    Done(Option<Box<Best>>),
}

pub type SweepJob = Job<SweepRequest, SweepMessage>;

pub fn job() -> SweepJob {
    Job::new(Patience::None, PoolKind::Work, |run| {
        // When the user does something the shell cancels, and asks for the rest later.
        let _ = measure(run);
    })
}

fn measure(run: &Run<SweepRequest, SweepMessage>) -> Result<(), Cancelled> {
    let SweepRequest { plan, scene, camera, settings, count, costs, known } = run.request;
    // This thread waits for the lease. The pool that measures must have all of its own.
    let pool = run.context.pools().get(PoolKind::Measure);
    let _lease = run.context.gate.lease(run.task)?;
    let timed = plan.timed;
    let measurement = Measurement { scene, camera, settings, count: *count, timed, builds: BUILDS };
    let sweeper = Sweeper { measurement, costs: *costs, known };
    let mut say = |event: SweepEvent| {
        run.emit(match event {
            SweepEvent::Started { name, .. } => SweepMessage::Started { name: name.to_owned() },
            SweepEvent::Measured { point, took } => {
                SweepMessage::Point { point: Box::new(point.clone()), took: Some(took) }
            }
            SweepEvent::Known { point } => SweepMessage::Point { point: Box::new(point.clone()), took: None },
        });
    };
    let best = pool.install(|| match &plan.search {
        None => sweeper.grid(&plan.grid, &plan.base, run.task, &mut say).map(|_| None),
        Some(search) => {
            let measure = &mut |name: &str, config: &BuildConfig, fresh: bool| {
                sweeper.point(name, config, fresh, run.task, &mut say)
            };
            search.run(&plan.base, run.task, measure).map(|best| Some(Box::new(best)))
        }
    })?;
    run.emit(SweepMessage::Done(best));
    Ok(())
}
