//! The rays of a pixel, found again as its integrator traced them.

use std::sync::Arc;

use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::app::inspection::{FoundRays, RaysAsked, RaysKey};
use crate::inspect::ray_tree::{PixelRay, pixel_rays};
use crate::render::observer::RayKind;
use crate::world::{RayQuery, World};

#[derive(Clone)]
pub struct RaysRequest {
    pub key: RaysKey,
    pub world: Arc<World>,
}

pub type RaysJob = Job<RaysRequest, FoundRays>;

/// Nobody waits for the picture meanwhile: it takes no lease.
pub fn job() -> RaysJob {
    Job::new(Patience::None, PoolKind::Draw, |run: &Run<RaysRequest, FoundRays>| {
        let RaysRequest { key, world } = run.request;
        let rays = match &key.asked {
            RaysAsked::Pixel(question) => match pixel_rays(world, question, run.task) {
                Ok(rays) => rays,
                // The next ones are on their way.
                Err(_) => return,
            },
            RaysAsked::Free(ray) => {
                vec![PixelRay::alone(world, RayKind::Camera, ray, RayQuery::Intersect)]
            }
        };
        run.emit(FoundRays::new(*key, rays));
    })
}
