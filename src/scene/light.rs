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

impl Light {
    /// A square panel with sides of length `side`, its middle at `center`, that shines towards `target`.
    pub fn panel(center: Vec3, target: Vec3, side: f32, radiance: Vec3) -> Self {
        let normal = (target - center).normalize_or(Vec3::NEG_Y);
        let (u, v) = normal.any_orthonormal_pair();
        // The quad's normal is `edge_u x edge_v`.
        let (edge_u, edge_v) =
            if u.cross(v).dot(normal) > 0.0 { (u * side, v * side) } else { (v * side, u * side) };
        Self::Panel { quad: Quad { corner: center - (edge_u + edge_v) * 0.5, edge_u, edge_v }, radiance }
    }
}

/// A plain dome: the radiance that comes from every direction that hits nothing. Black for none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sky {
    pub radiance: Vec3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_faces_its_target() {
        for (center, target) in [(Vec3::Y, Vec3::ZERO), (Vec3::ONE, -Vec3::X), (Vec3::Z, Vec3::Z)] {
            let Light::Panel { quad, .. } = Light::panel(center, target, 2.0, Vec3::ONE) else {
                unreachable!()
            };
            let normal = quad.edge_u.cross(quad.edge_v);
            assert!((normal.length() - 4.0).abs() < 1e-4, "{quad:?}");
            assert!(normal.normalize().dot((target - center).normalize_or(Vec3::NEG_Y)) > 0.999);
            assert!((quad.corner + (quad.edge_u + quad.edge_v) * 0.5 - center).length() < 1e-5);
        }
    }
}
