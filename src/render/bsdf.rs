//! Scattering at a surface: BRDF values, PDFs, and samples of them, explicit.
//!
//! Smooth lobes (Lambert) have a value `f` and a PDF by solid angle; perfect mirrors and smooth glass scatter into single
//! directions, which only sampling finds. What is carried through glass is radiance over the index squared, which is
//! unchanged by refraction, so a light inside glass is as bright as outside.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::scene::{Image, Material, MaterialKind, Surface};

/// A surface as seen from where a ray came.
#[derive(Clone, Copy, Debug)]
pub struct ShadingFrame {
    /// Unit shading normal on the viewer's side.
    pub normal: Vec3,
    /// Unit geometric normal on the viewer's side.
    pub geometric_normal: Vec3,
    /// Unit direction back to the viewer.
    pub outgoing: Vec3,
    /// Whether the viewer is on the shape's outside.
    pub front: bool,
}

/// The scattering of one point of a surface, its textures looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian for a share `1 - reflectivity` of the light, a perfect mirror for the rest.
    Diffuse {
        albedo: Vec3,
        reflectivity: f32,
    },
    Mirror {
        tint: Vec3,
    },
    Glass {
        ior: f32,
        absorption: Vec3,
    },
    /// `radiance` towards the outside; scatters nothing.
    Emissive {
        radiance: Vec3,
    },
}

/// One sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit, away from the surface.
    pub direction: Vec3,
    /// `f * cos / pdf`.
    pub weight: Vec3,
    /// By solid angle; `None` for a mirror's or glass's single direction.
    pub pdf: Option<f32>,
}

/// What smooth glass does with a ray.
#[derive(Clone, Copy, Debug)]
pub struct GlassSplit {
    /// The share of light that is reflected; 1 at total internal reflection.
    pub reflectance: f32,
    pub reflected: Vec3,
    /// `None` at total internal reflection.
    pub refracted: Option<Vec3>,
}

impl ShadingFrame {
    /// `direction` is the ray's, of unit length.
    #[inline]
    pub fn new(surface: &Surface, direction: Vec3) -> Self {
        let side = if surface.front { 1.0 } else { -1.0 };
        let outgoing = -direction;
        let geometric_normal = side * surface.geometric_normal;
        let shading = side * surface.shading_normal;
        // A shading normal that looks away from the viewer would reflect below the surface.
        let normal = if shading.dot(outgoing) > 0.0 { shading } else { geometric_normal };
        Self { normal, geometric_normal, outgoing, front: surface.front }
    }

    /// The cosine of a direction against the shading normal; 0 on the other side of either normal.
    #[inline]
    pub fn cosine(&self, direction: Vec3) -> f32 {
        if self.geometric_normal.dot(direction) > 0.0 { self.normal.dot(direction).max(0.0) } else { 0.0 }
    }

    /// The mirror direction, always above the surface.
    #[inline]
    pub fn reflected(&self) -> Vec3 {
        let reflected = reflect(self.outgoing, self.normal);
        if self.geometric_normal.dot(reflected) > 0.0 {
            reflected
        } else {
            reflect(self.outgoing, self.geometric_normal)
        }
    }

    /// How glass of index `ior` splits the ray.
    pub fn split(&self, ior: f32) -> GlassSplit {
        let eta = if self.front { 1.0 / ior } else { ior };
        let split = self.split_about(self.normal, eta);
        let below = |d: Vec3| self.geometric_normal.dot(d) < 0.0;
        if below(split.reflected) || split.refracted.is_some_and(|d| !below(d)) {
            self.split_about(self.geometric_normal, eta)
        } else {
            split
        }
    }

    /// Snell's law and Fresnel's equations for unpolarised light; `eta` is the index on the viewer's side over the other.
    fn split_about(&self, normal: Vec3, eta: f32) -> GlassSplit {
        let cos_i = normal.dot(self.outgoing).clamp(0.0, 1.0);
        let reflected = reflect(self.outgoing, normal);
        let cos2_t = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
        if cos2_t <= 0.0 {
            return GlassSplit { reflectance: 1.0, reflected, refracted: None };
        }
        let cos_t = cos2_t.sqrt();
        let s = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let p = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let refracted = ((eta * cos_i - cos_t) * normal - eta * self.outgoing).normalize();
        GlassSplit { reflectance: 0.5 * (s * s + p * p), reflected, refracted: Some(refracted) }
    }
}

impl Bsdf {
    /// Looks up what a material is at a point. Colours are kept within 0 and 1, so that no surface makes light.
    #[inline]
    pub fn new(material: &Material, uv: Vec2, images: &[Image]) -> Self {
        let color = || material.color_at(uv, images).clamp(Vec3::ZERO, Vec3::ONE);
        match material.kind {
            MaterialKind::Diffuse { reflectivity } => {
                Self::Diffuse { albedo: color(), reflectivity: reflectivity.clamp(0.0, 1.0) }
            }
            MaterialKind::Mirror => Self::Mirror { tint: color() },
            MaterialKind::Glass { ior, absorption } => Self::Glass { ior, absorption },
            MaterialKind::Emissive { radiance } => Self::Emissive { radiance },
        }
    }

    /// Whether light sampling can find anything here.
    #[inline]
    pub fn has_smooth_lobe(&self) -> bool {
        matches!(self, Self::Diffuse { reflectivity, .. } if *reflectivity < 1.0)
    }

    /// The value of the smooth lobe towards a light, in 1/sr; black below the surface.
    #[inline]
    pub fn f(&self, frame: &ShadingFrame, direction: Vec3) -> Vec3 {
        match *self {
            Self::Diffuse { albedo, reflectivity } if frame.cosine(direction) > 0.0 => {
                albedo * ((1.0 - reflectivity) / PI)
            }
            Self::Diffuse { .. } | Self::Mirror { .. } | Self::Glass { .. } | Self::Emissive { .. } => {
                Vec3::ZERO
            }
        }
    }

    /// The PDF by solid angle with which [`Bsdf::sample`] draws `direction` from the smooth lobe.
    #[inline]
    pub fn pdf(&self, frame: &ShadingFrame, direction: Vec3) -> f32 {
        match *self {
            Self::Diffuse { reflectivity, .. } => (1.0 - reflectivity) * frame.cosine(direction) / PI,
            Self::Mirror { .. } | Self::Glass { .. } | Self::Emissive { .. } => 0.0,
        }
    }

    /// Draws a direction: `lobe` in `[0, 1)` picks reflection or the other way, `u` the direction in a smooth lobe.
    /// `None` where nothing is scattered.
    #[inline]
    pub fn sample(&self, frame: &ShadingFrame, lobe: f32, u: Vec2) -> Option<BsdfSample> {
        match *self {
            Self::Diffuse { reflectivity, .. } if lobe < reflectivity => {
                Some(BsdfSample { direction: frame.reflected(), weight: Vec3::ONE, pdf: None })
            }
            Self::Diffuse { albedo, .. } => {
                let direction = cosine_weighted(frame.normal, u);
                let pdf = self.pdf(frame, direction);
                // With an interpolated normal a part of the lobe lies below the surface: that light is lost.
                (pdf > 0.0).then_some(BsdfSample { direction, weight: albedo, pdf: Some(pdf) })
            }
            Self::Mirror { tint } => {
                Some(BsdfSample { direction: frame.reflected(), weight: tint, pdf: None })
            }
            Self::Glass { ior, .. } => {
                let split = frame.split(ior);
                let direction = match split.refracted {
                    Some(refracted) if lobe >= split.reflectance => refracted,
                    Some(_) | None => split.reflected,
                };
                // Each way is drawn with the share of the light that goes there, which leaves a weight of 1.
                Some(BsdfSample { direction, weight: Vec3::ONE, pdf: None })
            }
            Self::Emissive { .. } => None,
        }
    }
}

/// Mirrors `outgoing` about `normal`, both pointing away from the surface.
#[inline]
pub fn reflect(outgoing: Vec3, normal: Vec3) -> Vec3 {
    2.0 * normal.dot(outgoing) * normal - outgoing
}

/// A direction about `normal` with PDF `cos / pi` (Malley's method: a uniform point of the disk, lifted).
#[inline]
pub fn cosine_weighted(normal: Vec3, u: Vec2) -> Vec3 {
    let radius = u.x.sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    // 1 - u.x is at least 2^-24, so the direction is never in the surface.
    (radius * cos * tangent + radius * sin * bitangent + (1.0 - u.x).sqrt() * normal).normalize()
}

/// The share of light that is left after `distance` through a medium (Beer and Lambert).
#[inline]
pub fn transmittance(absorption: Vec3, distance: f32) -> Vec3 {
    if absorption == Vec3::ZERO { Vec3::ONE } else { (-absorption * distance).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sampler::Sampler;

    fn frame(front: bool, outgoing: Vec3) -> ShadingFrame {
        ShadingFrame { normal: Vec3::Y, geometric_normal: Vec3::Y, outgoing: outgoing.normalize(), front }
    }

    #[test]
    fn the_pdf_of_lambert_integrates_to_the_lobe_s_share_and_f_to_the_albedo() {
        let frame = frame(true, Vec3::new(1.0, 1.0, 0.0));
        let bsdf = Bsdf::Diffuse { albedo: Vec3::splat(0.6), reflectivity: 0.25 };
        let (mut pdf, mut energy) = (0.0, 0.0);
        const N: usize = 200;
        for i in 0..N {
            for j in 0..N {
                // Midpoints of equal areas of the whole sphere.
                let y = 1.0 - 2.0 * (i as f32 + 0.5) / N as f32;
                let (sin, cos) = (TAU * (j as f32 + 0.5) / N as f32).sin_cos();
                let r = (1.0 - y * y).sqrt();
                let direction = Vec3::new(r * cos, y, r * sin);
                pdf += bsdf.pdf(&frame, direction);
                energy += bsdf.f(&frame, direction).x * frame.cosine(direction);
            }
        }
        let solid_angle = 2.0 * TAU / (N * N) as f32;
        assert!((pdf * solid_angle - 0.75).abs() < 1e-3, "{}", pdf * solid_angle);
        assert!((energy * solid_angle - 0.75 * 0.6).abs() < 1e-3, "{}", energy * solid_angle);
    }

    #[test]
    fn samples_of_lambert_follow_their_pdf_and_weigh_f_cos_over_pdf() {
        let normal = Vec3::new(0.3, -0.8, 0.5).normalize();
        let frame = ShadingFrame { normal, geometric_normal: normal, outgoing: normal, front: true };
        let bsdf = Bsdf::Diffuse { albedo: Vec3::new(0.2, 0.5, 0.9), reflectivity: 0.3 };
        let mut sampler = Sampler::new(1, [0, 0], 0);
        let (mut mirrored, mut cosines) = (0, 0.0);
        const N: usize = 20_000;
        for _ in 0..N {
            let lobe = sampler.next_1d();
            let s = bsdf.sample(&frame, lobe, sampler.next_2d()).expect("diffuse always scatters");
            assert!((s.direction.length() - 1.0).abs() < 1e-5);
            match s.pdf {
                None => mirrored += 1,
                Some(pdf) => {
                    assert_eq!(pdf, bsdf.pdf(&frame, s.direction));
                    // The lobe's share stands in f and in the PDF alike.
                    let weight = bsdf.f(&frame, s.direction) * frame.cosine(s.direction) / pdf;
                    assert!((weight - s.weight).abs().max_element() < 1e-5);
                    cosines += f64::from(frame.cosine(s.direction));
                }
            }
        }
        let share = f64::from(mirrored) / N as f64;
        assert!((share - 0.3).abs() < 0.01, "{share}");
        let mean = cosines / (N as f64 - f64::from(mirrored));
        assert!((mean - 2.0 / 3.0).abs() < 0.01, "the mean cosine of a cosine lobe is 2/3, not {mean}");
    }

    #[test]
    fn fresnel_at_the_known_angles() {
        let straight = frame(true, Vec3::Y).split(1.5);
        assert!((straight.reflectance - 0.04).abs() < 1e-6);
        assert!((straight.refracted.expect("no total reflection from outside") + Vec3::Y).length() < 1e-6);
        let grazing = frame(true, Vec3::new(1.0, 1e-4, 0.0)).split(1.5);
        assert!(grazing.reflectance > 0.999);
        // At Brewster's angle p-polarised light passes whole, so R = Rs / 2 with Rs = ((n^2 - 1) / (n^2 + 1))^2.
        let brewster = 1.5f32.atan();
        let split = frame(true, Vec3::new(brewster.sin(), brewster.cos(), 0.0)).split(1.5);
        let rs = (1.25f32 / 3.25).powi(2);
        assert!((split.reflectance - 0.5 * rs).abs() < 1e-5, "{}", split.reflectance);
    }

    #[test]
    fn snell_holds_and_a_way_back_reflects_as_much() {
        for degrees in [5.0f32, 30.0, 60.0, 85.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let into = frame(true, Vec3::new(sin, cos, 0.0)).split(1.5);
            let inside = into.refracted.expect("refracts from outside at every angle");
            assert!((inside.x.abs() * 1.5 - sin).abs() < 1e-5 && inside.y < 0.0);
            // The viewer now stands inside and looks out along the same path.
            let out = frame(false, Vec3::new(inside.x, -inside.y, 0.0)).split(1.5);
            assert!((out.reflectance - into.reflectance).abs() < 1e-4, "{degrees}");
        }
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        let critical = (1.0f32 / 1.5).asin();
        for (angle, total) in [(critical - 0.01, false), (critical + 0.01, true)] {
            let split = frame(false, Vec3::new(angle.sin(), angle.cos(), 0.0)).split(1.5);
            assert_eq!(split.refracted.is_none(), total);
            assert_eq!(split.reflectance == 1.0, total);
        }
    }

    #[test]
    fn glass_draws_each_way_by_its_share_and_loses_nothing() {
        let frame = frame(true, Vec3::new(2.0, 1.0, 0.0));
        let glass = Bsdf::Glass { ior: 1.5, absorption: Vec3::ZERO };
        let reflectance = frame.split(1.5).reflectance;
        let mut sampler = Sampler::new(3, [0, 0], 0);
        let mut reflected = 0;
        for _ in 0..20_000 {
            let lobe = sampler.next_1d();
            let s = glass.sample(&frame, lobe, sampler.next_2d()).expect("glass always scatters");
            assert_eq!((s.weight, s.pdf), (Vec3::ONE, None));
            reflected += u32::from(s.direction.y > 0.0);
        }
        assert!((f64::from(reflected) / 2e4 - f64::from(reflectance)).abs() < 0.01);
        assert!(!glass.has_smooth_lobe() && glass.pdf(&frame, Vec3::Y) == 0.0);
    }

    #[test]
    fn a_leaning_shading_normal_never_reflects_below_the_surface() {
        let frame = ShadingFrame {
            normal: Vec3::new(-0.8, 0.6, 0.0),
            geometric_normal: Vec3::Y,
            outgoing: Vec3::new(-1.0, 0.05, 0.0).normalize(),
            front: true,
        };
        assert!(frame.reflected().y > 0.0);
        let split = frame.split(1.5);
        assert!(split.reflected.y > 0.0 && split.refracted.is_none_or(|d| d.y < 0.0));
        assert_eq!(frame.cosine(Vec3::new(-1.0, -0.1, 0.0)), 0.0);
    }

    #[test]
    fn absorption_is_exponential_in_the_distance() {
        let a = Vec3::new(0.0, 1.0, 2.0);
        let once = transmittance(a, 0.5);
        assert!((transmittance(a, 1.0) - once * once).abs().max_element() < 1e-6);
        assert_eq!(once.x, 1.0);
        assert_eq!(transmittance(Vec3::ZERO, f32::INFINITY), Vec3::ONE);
    }
}
