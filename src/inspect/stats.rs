//! All figures of one tree on one scene and view, with the settings that gave them.

use serde::Serialize;

use crate::accel::BuildConfig;
use crate::accel::build::BuildPhase;
use crate::accel::quality::TreeFigures;
use crate::render::measure::{FrameTimes, RayFigures};
use crate::render::{CountKind, RenderSettings};
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// One object a tree: what `stats`, `table`, `sweep` and `compare` print, and what the panels show.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TreeStats {
    /// `BVH_SAH`, `A`, or what else the caller calls it.
    pub name: String,
    pub scene: String,
    pub shape_count: usize,
    pub config: BuildConfig,
    pub count: CountKind,
    pub figures: TreeFigures,
    pub phases: Vec<BuildPhase>,
    pub build_ms: f64,
    pub rays: RayFigures,
    /// `None` when not timed.
    pub times: Option<FrameTimes>,
    /// Tree and shapes ready to trace.
    pub bytes: usize,
}

/// Measures a world: counts rays, and times a frame if `timed`.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn tree_stats(
    name: &str,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    count: CountKind,
    timed: bool,
    task: &Task,
) -> Result<TreeStats, Cancelled> {
    let _ = (name, world, camera, settings, count, timed, task);
    todo!()
}
