//! Light sources.

use glam::Vec3;

use crate::geometry::Quad;

/// One light that can be sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A shape with an emissive material: it can be hit, too.
    Shape { shape: u32 },
    /// Radiant intensity (W/sr) in all directions.
    Point { position: Vec3, intensity: Vec3 },
    /// A rectangle that shines along its normal with `radiance` but is not a shape: no ray hits it.
    Panel { quad: Quad, radiance: Vec3 },
}

/// A plain dome: the radiance that comes from every direction that hits nothing. Black for none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sky {
    pub radiance: Vec3,
}
