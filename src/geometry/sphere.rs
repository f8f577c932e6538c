//! A sphere.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sphere {
    pub center: Vec3,
    pub radius: f32,
}

impl Sphere {
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
