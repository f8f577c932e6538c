//! Figures of camera rays: quick counts for each new tree, and again when the camera has come to rest.

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind};
use crate::render::measure::{RayFigures, count_rays};
use crate::render::{CountKind, RenderSettings};
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Camera rays that are counted, at most: enough for a mean to three digits, and done in a moment.
const MOST_RAYS: u64 = 20_000;

/// A camera before a tree.
#[derive(Clone)]
pub struct FiguresRequest {
    pub key: FiguresKey,
    pub world: std::sync::Arc<World>,
    pub settings: RenderSettings,
}

/// What the figures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiguresKey {
    pub tree: TreeKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
}

/// The job that counts for a camera at rest.
pub type FiguresJob = Job<FiguresRequest, (FiguresKey, RayFigures)>;

pub fn job() -> FiguresJob {
    Job::new(Patience::None, PoolKind::Background, |run| {
        let Ok(_pass) = run.context.gate.enter(run.task, OnLease::Finish) else { return };
        let FiguresRequest { key, world, settings } = run.request;
        if let Ok(rays) = count_camera_rays(world, &key.camera, settings, run.task) {
            run.emit((*key, rays));
        }
    })
}

/// Counts a fixed part of the camera rays. In the current pool.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn count_camera_rays(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<RayFigures, Cancelled> {
    count_rays(world, camera, settings, CountKind::Camera, stride(settings, MOST_RAYS), task)
}

/// Every how many pixels in x and y a ray is counted, so that there are about `most` of them.
pub fn stride(settings: &RenderSettings, most: u64) -> u32 {
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    (pixels as f64 / most as f64).sqrt().ceil().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stride_keeps_the_number_of_rays_in_bounds() {
        for (width, height) in [(1, 1), (100, 100), (1280, 720), (16384, 16384)] {
            let settings = RenderSettings { width, height, ..Default::default() };
            let s = stride(&settings, MOST_RAYS);
            let rays = u64::from(width.div_ceil(s)) * u64::from(height.div_ceil(s));
            assert!(rays <= MOST_RAYS + MOST_RAYS / 4, "{width}x{height}: {rays}");
            assert!(s == 1 || rays >= MOST_RAYS / 4);
        }
    }
}
