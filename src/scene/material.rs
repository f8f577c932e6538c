//! Materials and textures.

use std::sync::LazyLock;

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

/// A texture, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub width: u32,
    pub height: u32,
    pub pixels: Pixels,
}

/// The pixels of a texture as its file holds them: most files are eight bits a component, and stay so in memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Encoded in sRGB; decoded when looked up, before any interpolation.
    Srgb8(Vec<[u8; 3]>),
    Linear(Vec<Vec3>),
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

    /// The colour at a point of the surface. A colour that names no image of `images` is its tint.
    #[inline]
    pub fn color_at(&self, uv: Vec2, images: &[Image]) -> Vec3 {
        match &self.color {
            Color::Solid(color) => *color,
            Color::Checker { even, odd, size, fine } => {
                let inside = |f: &&FineTiles| uv.cmpge(f.min).all() && uv.cmplt(f.max).all();
                let size = fine.iter().find(inside).map_or(*size, |f| f.size);
                if is_odd_square(uv, size) { *odd } else { *even }
            }
            Color::Image { image, tint } => {
                images.get(*image as usize).map_or(*tint, |image| *tint * image.sample(uv))
            }
        }
    }
}

/// Whether the square of a checker at `uv` is one of those beside the one at the origin.
fn is_odd_square(uv: Vec2, size: f32) -> bool {
    let square = (uv / size).floor();
    // `as` saturates and takes NaN to 0, so that any coordinate has a colour.
    (square.x as i64).wrapping_add(square.y as i64) & 1 != 0
}

impl Image {
    /// The colour at `uv`, bilinear between the centres of pixels, repeated in both directions. `v` points up: (0, 0) is
    /// the lower left corner. Black for an image without pixels.
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        let (width, height) = (self.width as usize, self.height as usize);
        if width == 0 || height == 0 || self.pixels.len() < width * height {
            return Vec3::ZERO;
        }
        let uv = if uv.is_finite() { uv - uv.floor() } else { Vec2::ZERO };
        let x = uv.x * width as f32 - 0.5;
        let y = (1.0 - uv.y) * height as f32 - 0.5;
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let wrapped = |value: f32, count: usize| (value.floor() as i64).rem_euclid(count as i64) as usize;
        let (x0, y0) = (wrapped(x, width), wrapped(y, height));
        let (x1, y1) = ((x0 + 1) % width, (y0 + 1) % height);
        let at = |x: usize, y: usize| self.pixels.linear(y * width + x);
        at(x0, y0).lerp(at(x1, y0), fx).lerp(at(x0, y1).lerp(at(x1, y1), fx), fy)
    }
}

impl Pixels {
    fn len(&self) -> usize {
        match self {
            Self::Srgb8(pixels) => pixels.len(),
            Self::Linear(pixels) => pixels.len(),
        }
    }

    /// The linear colour of a pixel.
    fn linear(&self, index: usize) -> Vec3 {
        match self {
            Self::Srgb8(pixels) => srgb8_to_linear(pixels[index]),
            Self::Linear(pixels) => pixels[index],
        }
    }
}

/// The linear colour that three sRGB-encoded bytes stand for.
pub fn srgb8_to_linear(encoded: [u8; 3]) -> Vec3 {
    static TABLE: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|byte| srgb_to_linear(byte as f32 / 255.0)));
    Vec3::from_array(encoded.map(|byte| TABLE[usize::from(byte)]))
}

/// The light that an sRGB-encoded component between 0 and 1 stands for (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colored(color: Color) -> Material {
        Material { name: String::new(), color, kind: MaterialKind::Mirror }
    }

    #[test]
    fn a_checker_alternates_across_the_origin_too() {
        let m = colored(Color::Checker { even: Vec3::ONE, odd: Vec3::ZERO, size: 0.5, fine: vec![] });
        for (u, v, even) in [
            (0.1, 0.1, true),
            (0.6, 0.1, false),
            (-0.1, 0.1, false),
            (-0.1, -0.1, true),
            (0.6, 0.6, true),
            (1.1, 0.1, true),
        ] {
            assert_eq!(m.color_at(Vec2::new(u, v), &[]) == Vec3::ONE, even, "at {u}, {v}");
        }
    }

    #[test]
    fn fine_tiles_replace_the_checker_in_their_rectangle_only() {
        let fine = FineTiles { min: Vec2::ONE, max: Vec2::splat(1.5), size: 1.0 / 32.0 };
        let m = colored(Color::Checker { even: Vec3::ONE, odd: Vec3::ZERO, size: 0.5, fine: vec![fine] });
        let count = |min: f32| {
            let colors = (0..64).map(|i| m.color_at(Vec2::new(min + (i as f32 + 0.5) / 128.0, 1.01), &[]).x);
            colors.clone().zip(colors.skip(1)).filter(|(a, b)| a != b).count()
        };
        assert_eq!((count(1.0), count(0.5)), (15, 0));
    }

    #[test]
    fn a_colour_exists_for_any_coordinate() {
        let image = Image { width: 1, height: 1, pixels: Pixels::Linear(vec![Vec3::ONE]) };
        for color in [
            Color::Checker { even: Vec3::ONE, odd: Vec3::ZERO, size: 0.0, fine: vec![] },
            Color::Image { image: 0, tint: Vec3::ONE },
            Color::Image { image: 7, tint: Vec3::ONE },
        ] {
            for x in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
                assert!(
                    colored(color.clone())
                        .color_at(Vec2::new(x, x), std::slice::from_ref(&image))
                        .is_finite()
                );
            }
        }
    }

    #[test]
    fn images_are_bilinear_repeat_and_start_at_the_top() {
        let (a, b, c, d) = (Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE);
        let image = Image { width: 2, height: 2, pixels: Pixels::Linear(vec![a, b, c, d]) };
        assert_eq!(image.sample(Vec2::new(0.25, 0.75)), a);
        assert_eq!(image.sample(Vec2::new(0.75, 0.75)), b);
        assert_eq!(image.sample(Vec2::new(0.25, 0.25)), c);
        assert_eq!(image.sample(Vec2::new(3.75, -2.75)), d);
        assert!((image.sample(Vec2::new(0.5, 0.75)) - (a + b) / 2.0).length() < 1e-6);
        assert!((image.sample(Vec2::new(0.0, 0.75)) - (a + b) / 2.0).length() < 1e-6, "wraps around");
    }

    #[test]
    fn encoded_pixels_are_decoded_before_they_are_mixed() {
        let image = Image { width: 2, height: 1, pixels: Pixels::Srgb8(vec![[0; 3], [255; 3]]) };
        assert!((image.sample(Vec2::new(0.5, 0.5)) - Vec3::splat(0.5)).length() < 1e-6);
        let none = Image { width: 2, height: 2, pixels: Pixels::Srgb8(vec![[255; 3]]) };
        assert_eq!(none.sample(Vec2::ZERO), Vec3::ZERO);
    }

    #[test]
    fn srgb_has_the_standard_values() {
        for (encoded, linear) in [(0.0, 0.0), (0.04, 0.003_096), (0.5, 0.214_041), (1.0, 1.0)] {
            assert!((srgb_to_linear(encoded) - linear).abs() < 1e-6);
        }
    }
}
