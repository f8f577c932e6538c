//! A triangle; its outside is where its vertices turn counter-clockwise.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A triangle; its outside is where its vertices turn counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Triangle {
    pub v: [Vec3; 3],
}

impl Triangle {
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
