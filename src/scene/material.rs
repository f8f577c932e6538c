//! Materials and textures.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// How a surface answers light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MaterialKind {
    /// Lambertian. A share `reflectivity` (0 to 1) of the light is reflected as by a mirror instead.
    Diffuse {
        reflectivity: f32,
    },
    Mirror,
    /// Smooth dielectric with Fresnel reflection. `absorption` per unit length (Beer-Lambert).
    Glass {
        ior: f32,
        absorption: Vec3,
    },
    /// Emits `radiance` from the outside of the surface; reflects nothing.
    Emissive {
        radiance: Vec3,
    },
}

/// A colour over a surface, linear.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    Solid(Vec3),
    /// Squares of side `size` in units of uv, alternating from the one at the origin.
    Checker {
        even: Vec3,
        odd: Vec3,
        size: f32,
        fine: Vec<FineTiles>,
    },
    /// Index into the scene's images, multiplied by `tint`.
    Image {
        image: u32,
        tint: Vec3,
    },
}

/// A rectangle of uv in which a checker is much finer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineTiles {
    pub min: Vec2,
    pub max: Vec2,
    pub size: f32,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    pub color: Color,
    pub kind: MaterialKind,
}

/// A texture: linear RGB, decoded from sRGB where the file was, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<Vec3>,
}

/// Which materials let shadow rays pass straight on. Belongs to Whitted and the shadow views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowRule {
    #[default]
    Glass,
    #[serde(rename = "glass+mirror")]
    GlassMirror,
}

impl ShadowRule {
    pub const ALL: [Self; 2] = [Self::Glass, Self::GlassMirror];

    pub fn name(self) -> &'static str {
        match self {
            Self::Glass => "glass",
            Self::GlassMirror => "glass+mirror",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Glass => "light passes glass",
            Self::GlassMirror => "light passes glass and mirrors",
        }
    }
}

impl Material {
    /// Whether a shadow ray goes on behind this material.
    pub fn lets_light_pass(&self, rule: ShadowRule) -> bool {
        match self.kind {
            MaterialKind::Glass { .. } => true,
            MaterialKind::Mirror => rule == ShadowRule::GlassMirror,
            MaterialKind::Diffuse { .. } | MaterialKind::Emissive { .. } => false,
        }
    }

    /// The colour at a point of the surface.
    pub fn color_at(&self, uv: Vec2, images: &[Image]) -> Vec3 {
        let _ = (uv, images);
        todo!()
    }
}
