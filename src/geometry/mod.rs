//! Rays, boxes, transforms, and each shape's own intersection maths. Knows nothing of scenes or trees.

pub mod aabb;
pub mod ray;
pub mod shape;
pub mod slabs;
pub mod transform;

mod polygon;
mod roots;
mod rounding;
mod sampled_area;

#[cfg(test)]
mod checks;

pub mod cuboid;
pub mod plane;
pub mod quad;
pub mod sphere;
pub mod torus;
pub mod triangle;

pub use aabb::Aabb;
pub use cuboid::Cuboid;
pub use plane::Plane;
pub use polygon::Polygon;
pub use quad::Quad;
pub use ray::{Hit, PreparedRay, Ray};
pub use shape::{Shape, ShapeHit, ShapeKind, SurfacePoint, SurfaceSample, leave_surface};
pub use slabs::{Slabs, Span};
pub use sphere::Sphere;
pub use torus::Torus;
pub use transform::Rigid;
pub use triangle::Triangle;
