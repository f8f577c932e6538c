//! The five trees side by side.

use std::sync::Arc;

use super::stats::{Measurement, TreeStats};
use crate::accel::BuildConfig;
use crate::render::{CountKind, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};

/// Builds of each tree; the build time is their median.
const BUILDS: usize = 5;

/// Builds and measures the five trees at the leaf limit, bins and costs of `base`, all rays of a Whitted frame counted;
/// build time is the median of 5 builds. Progress on `task` in steps; `finished` gets each row as it comes.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn five_trees(
    scene: &Arc<Scene>,
    camera: &Camera,
    base: &BuildConfig,
    settings: &RenderSettings,
    task: &Task,
    finished: &mut dyn FnMut(&TreeStats),
) -> Result<Vec<TreeStats>, Cancelled> {
    let measurement =
        Measurement { scene, camera, settings, count: CountKind::All, timed: true, builds: BUILDS };
    measurement.rows(&base.five_trees().map(|(name, config)| (name.to_owned(), config)), task, finished)
}

impl Measurement<'_> {
    /// Measures one tree after the other. Progress on `task`; `finished` gets each row as it comes.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn rows(
        &self,
        trees: &[(String, BuildConfig)],
        task: &Task,
        finished: &mut dyn FnMut(&TreeStats),
    ) -> Result<Vec<TreeStats>, Cancelled> {
        task.start(self.steps() * trees.len() as u64);
        let mut rows = Vec::with_capacity(trees.len());
        for (name, config) in trees {
            let row = self.of(name, config, task)?;
            finished(&row);
            rows.push(row);
        }
        Ok(rows)
    }
}
