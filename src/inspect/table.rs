//! The five trees side by side.

use std::sync::Arc;

use super::stats::TreeStats;
use crate::accel::BuildConfig;
use crate::render::RenderSettings;
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};

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
    let _ = (scene, camera, base, settings, task, finished);
    todo!()
}
