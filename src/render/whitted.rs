//! Whitted ray tracing: direct light, mirrors and glass (Whitted, "An Improved Illumination Model for Shaded Display", 1980).
//!
//! Every diffuse surface is lit by all lights with one shadow ray each, by the shadow rule: area lights at one point a sample,
//! in the first sample their middle, so that shadows are free of noise, hard at first and soft in time. Mirrors reflect, glass both reflects and refracts. The sky lights as if nothing stood in its
//! way. Scenes with more than [`LIGHTS_MAX`] lights draw that many by power instead.

use std::f32::consts::PI;

use glam::Vec3;

use super::bsdf::{Bsdf, ShadingFrame, transmittance};
use super::light_sampling::LightSample;
use super::observer::{RayKind, RayObserver};
use super::pass::{LIGHTS_MAX, Pass};
use super::path::{absorption_before, medium_behind};
use super::sampler::Sampler;
use crate::geometry::Ray;
use crate::scene::Surface;

/// A reflected or refracted ray that would add less than this is not traced.
const WEIGHT_MIN: f32 = 1.0 / 512.0;

/// A ray of the tree that is still to be traced.
#[derive(Clone, Copy, Debug)]
struct Pending {
    ray: Ray,
    /// What its radiance is multiplied with.
    weight: Vec3,
    /// What the medium that it runs through absorbs per unit length.
    medium: Vec3,
    depth: u32,
}

/// Walks the ray trees of camera rays. Keeps its stack, so that no ray allocates.
#[derive(Clone, Debug, Default)]
pub struct Whitted {
    pending: Vec<Pending>,
}

impl Whitted {
    /// The radiance that arrives along a camera ray: one sample of it. `observer` is told of every ray.
    #[inline]
    pub fn radiance<O: RayObserver>(
        &mut self,
        pass: &Pass,
        ray: Ray,
        sampler: &mut Sampler,
        observer: &mut O,
    ) -> Vec3 {
        let scene = &*pass.world.scene;
        let mut sum = Vec3::ZERO;
        self.pending.clear();
        self.pending.push(Pending { ray, weight: Vec3::ONE, medium: Vec3::ZERO, depth: 0 });
        while let Some(Pending { ray, weight, medium, depth }) = self.pending.pop() {
            let kind = if depth == 0 { RayKind::Camera } else { RayKind::Bounce };
            let hit = pass.world.intersect(&ray, observer.begin(kind, &ray));
            observer.end();
            let Some(hit) = hit else {
                sum += weight * scene.sky.radiance;
                continue;
            };
            let surface = scene.surface(&ray, &hit);
            let frame = ShadingFrame::new(&surface, ray.direction);
            let bsdf = Bsdf::new(&scene.materials[surface.material as usize], surface.uv, &scene.images);
            let weight = weight * transmittance(absorption_before(&bsdf, surface.front, medium), hit.t);
            let mut push = |direction: Vec3, weight: Vec3| {
                if depth < pass.max_depth && weight.max_element() >= WEIGHT_MIN {
                    let ray = Ray::new(surface.ray_origin(direction), direction);
                    let medium = medium_behind(&bsdf, &frame, direction, medium);
                    self.pending.push(Pending { ray, weight, medium, depth: depth + 1 });
                }
            };
            match bsdf {
                Bsdf::Emissive { radiance } if surface.front => sum += weight * radiance,
                Bsdf::Emissive { .. } => {}
                Bsdf::Mirror { tint } => push(frame.reflected(), weight * tint),
                Bsdf::Glass { ior, .. } => {
                    let split = frame.split(ior);
                    push(split.reflected, weight * split.reflectance);
                    if let Some(refracted) = split.refracted {
                        push(refracted, weight * (1.0 - split.reflectance));
                    }
                }
                Bsdf::Diffuse { albedo, reflectivity } => {
                    if reflectivity > 0.0 {
                        push(frame.reflected(), weight * reflectivity);
                    }
                    let irradiance = irradiance(pass, &surface, &frame, sampler, observer);
                    let lit = (1.0 - reflectivity) * albedo * (irradiance / PI + scene.sky.radiance);
                    sum += weight * lit;
                }
            }
        }
        sum
    }
}

/// Irradiance from all lights but the sky.
#[inline]
fn irradiance<O: RayObserver>(
    pass: &Pass,
    surface: &Surface,
    frame: &ShadingFrame,
    sampler: &mut Sampler,
    observer: &mut O,
) -> Vec3 {
    let lights = &pass.lights;
    let mut sum = Vec3::ZERO;
    if lights.len() <= LIGHTS_MAX {
        for index in 0..lights.len() {
            let light = pass.sample_light(index, surface, sampler);
            sum += arriving(pass, light, frame, observer);
        }
    } else {
        for part in 0..LIGHTS_MAX {
            let pick = (part as f64 + sampler.next_fine()) / LIGHTS_MAX as f64;
            let light = lights.sample_lights(surface, frame, pick, sampler.next_2d());
            sum += arriving(pass, light, frame, observer) / LIGHTS_MAX as f32;
        }
    }
    sum
}

/// What a light sample adds to the irradiance, if the way is free under the shadow rule.
#[inline]
fn arriving<O: RayObserver>(
    pass: &Pass,
    light: Option<LightSample>,
    frame: &ShadingFrame,
    observer: &mut O,
) -> Vec3 {
    let Some(light) = light else { return Vec3::ZERO };
    let cosine = frame.cosine(light.direction);
    if cosine == 0.0 {
        return Vec3::ZERO;
    }
    let probe = observer.begin(RayKind::Shadow, &light.shadow_ray);
    let blocked = pass.world.occluded_filtered(&light.shadow_ray, pass.shadow_rule, probe).is_some();
    observer.end();
    if blocked { Vec3::ZERO } else { light.radiance * (cosine / light.pdf) }
}
