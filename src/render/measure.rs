//! Figures from tracing rays with counters, and from timing without.

use serde::Serialize;

use super::film::RenderSettings;
use super::views::CountKind;
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Means per ray over the counted rays. `None` where no ray was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RayFigures {
    pub ray_count: u64,
    /// Rays that miss the root's box; they visit nothing.
    pub missed_root_count: u64,
    pub nodes_visited_mean: Option<f64>,
    pub inner_visits_mean: Option<f64>,
    pub leaf_visits_mean: Option<f64>,
    pub box_tests_mean: Option<f64>,
    pub shape_tests_mean: Option<f64>,
    pub ray_cost_mean: Option<f64>,
    /// Standard deviation of the number of leaves that a ray visits.
    pub lcv: Option<f64>,
}

/// Times of a Whitted frame; medians.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Tracing all rays of the frame, without shading and counting, median of 5.
    pub traversal_ms: f64,
    /// 1000 / time of a whole frame with shading, without the build.
    pub frames_per_s: f64,
    /// Threads that traced.
    pub threads: usize,
}

/// Counts the rays of one Whitted frame of the given kind. With `stride > 1` only every `stride`-th pixel in x and y.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn count_rays(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    count: CountKind,
    stride: u32,
    task: &Task,
) -> Result<RayFigures, Cancelled> {
    let _ = (world, camera, settings, count, stride, task);
    todo!()
}

/// Times a Whitted frame. The caller holds the lease: nothing else may run meanwhile.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn time_frame(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<FrameTimes, Cancelled> {
    let _ = (world, camera, settings, task);
    todo!()
}
