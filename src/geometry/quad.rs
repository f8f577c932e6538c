//! A parallelogram: corner, and its two edges; the outside is along `edge_u x edge_v`.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A parallelogram: corner, and its two edges; the outside is along `edge_u x edge_v`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quad {
    pub corner: Vec3,
    pub edge_u: Vec3,
    pub edge_v: Vec3,
}

impl Quad {
    pub fn bounds(&self) -> Aabb {
        todo!()
    }
    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        todo!()
    }
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        todo!()
    }
    pub fn area(&self) -> f32 {
        todo!()
    }
    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        todo!()
    }
    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        todo!()
    }
    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        todo!()
    }
}
