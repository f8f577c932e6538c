//! The unbounded plane. It has no box, stays outside every tree, and is tested for each ray.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{PreparedRay, Ray, ShapeHit, SurfacePoint};

/// Points p with `normal . p = offset`; the normal is of unit length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    pub normal: Vec3,
    pub offset: f32,
}

impl Plane {
    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        todo!()
    }
    /// uv are world coordinates along two fixed tangents, in scene units (for axis-aligned planes: the two other axes in order).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        todo!()
    }
}
