//! What the bins do: SAH cost, nodes visited and build time over the number of bins, and the full sweep as a line.

use std::sync::Arc;

use serde::Serialize;

use crate::accel::BuildConfig;
use crate::render::RenderSettings;
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};

/// One number of bins; `bins` is `None` for the full sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BinPoint {
    pub bins: Option<usize>,
    pub sah_cost: Option<f64>,
    pub nodes_visited_mean: Option<f64>,
    pub build_ms: f64,
    /// Whether `build_ms` was taken with nothing else running.
    pub timed_alone: bool,
}

/// About 24 numbers of bins from 2 to 256, closer together where they are few.
pub fn coarse_bins() -> Vec<usize> {
    todo!()
}

/// Builds the binned tree (or, for `None`, the swept one) with `base`'s other settings, and counts the camera rays of
/// every `stride`-th pixel.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn measure_bins(
    scene: &Arc<Scene>,
    camera: &Camera,
    base: &BuildConfig,
    bins: Option<usize>,
    settings: &RenderSettings,
    stride: u32,
    timed_alone: bool,
    task: &Task,
) -> Result<BinPoint, Cancelled> {
    let _ = (scene, camera, base, bins, settings, stride, timed_alone, task);
    todo!()
}
