//! A torus around its object's y axis.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A torus around its object's y axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Torus {
    pub world_from_object: Rigid,
    /// From the centre to the middle of the tube.
    pub major_radius: f32,
    /// Of the tube.
    pub minor_radius: f32,
}

impl Torus {
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
