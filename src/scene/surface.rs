//! What a hit is a hit of.

use glam::{Vec2, Vec3};

use crate::geometry::{Hit, Ray};

use super::Scene;

/// A point on a surface with everything that shading asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    pub position: Vec3,
    /// Bound of the absolute error of `position`.
    pub error: Vec3,
    /// Unit normal on the shape's outside, as the geometry has it.
    pub geometric_normal: Vec3,
    /// Interpolated from vertex normals where the mesh has them, on the same side as `geometric_normal`.
    pub shading_normal: Vec3,
    pub uv: Vec2,
    /// Index of the shape (or plane, or ground) and of its material.
    pub shape: u32,
    pub material: u32,
    /// Whether the ray came from outside: `dot(ray.direction, geometric_normal) < 0`.
    pub front: bool,
}

impl Scene {
    /// The surface at `hit`, the answer to `ray`.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let _ = (ray, hit);
        todo!()
    }
}

impl Surface {
    /// The origin of a ray that leaves along `direction`: `position` moved along the geometric normal by the error
    /// bound to the side that `direction` points to (Waechter and Binder, "A Fast and Robust Method for Avoiding
    /// Self-Intersection", 2019).
    pub fn ray_origin(&self, direction: Vec3) -> Vec3 {
        let _ = direction;
        todo!()
    }
}
