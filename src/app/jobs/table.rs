//! Measuring the five trees in the background, with nothing else running.

use std::sync::Arc;

use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::BuildConfig;
use crate::inspect::stats::TreeStats;
use crate::inspect::table::five_trees;
use crate::render::RenderSettings;
use crate::scene::{Camera, Scene};
use crate::task::Cancelled;

use super::keys::SceneKey;

#[derive(Clone)]
pub struct TableRequest {
    pub key: TableKey,
    pub scene: Arc<Scene>,
    pub settings: RenderSettings,
}

/// What the table depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableKey {
    pub scene: SceneKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub max_depth: u32,
    pub threads: usize,
    /// Leaf limit, bins and costs; builder and width do not matter.
    pub base: BuildConfig,
}

impl TableKey {
    pub fn new(scene: SceneKey, camera: &Camera, settings: &RenderSettings, config: &BuildConfig) -> Self {
        let blank = BuildConfig::default();
        let base = BuildConfig {
            builder: blank.builder,
            width: blank.width,
            widen: blank.widen,
            stop: blank.stop,
            improver: blank.improver,
            rounds: blank.rounds,
            share: blank.share,
            layout: blank.layout,
            pre_split: blank.pre_split,
            ..*config
        };
        let RenderSettings { width, height, max_depth, threads, .. } = *settings;
        Self { scene, camera: *camera, width, height, max_depth, threads, base }
    }
}

pub enum TableMessage {
    /// A tree is measured.
    Row(Box<TreeStats>),
    /// All are.
    Done,
}

pub type TableJob = Job<TableRequest, TableMessage>;

pub fn job() -> TableJob {
    Job::new(Patience::None, PoolKind::Work, |run| {
        // When the user interacts the shell cancels, and asks again later.
        let _ = measure(run);
    })
}

fn measure(run: &Run<TableRequest, TableMessage>) -> Result<(), Cancelled> {
    let TableRequest { key, scene, settings } = run.request;
    // This thread waits for the lease. The pool that measures must have all of its own.
    let pool = run.context.pools().get(PoolKind::Measure);
    let _lease = run.context.gate.lease(run.task)?;
    let mut finished = |row: &TreeStats| run.emit(TableMessage::Row(Box::new(row.clone())));
    pool.install(|| five_trees(scene, &key.camera, &key.base, settings, run.task, &mut finished))?;
    run.emit(TableMessage::Done);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Builder, Width};

    #[test]
    fn the_chosen_builder_does_not_make_a_table_stale() {
        let key = |config: BuildConfig| {
            TableKey::new(SceneKey::for_tests(1), &Camera::default(), &RenderSettings::default(), &config)
        };
        let base = BuildConfig::default();
        let other = BuildConfig { builder: Builder::Median, width: Width::W8, ..base };
        assert_eq!(key(base), key(other));
        assert_ne!(key(base), key(BuildConfig { leaf: 7, ..base }));
        assert_ne!(key(base), key(BuildConfig { bins: 7, ..base }));
    }
}
