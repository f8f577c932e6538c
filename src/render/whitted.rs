//! Whitted ray tracing: direct light, mirrors and glass (Whitted, "An Improved Illumination Model for Shaded Display", 1980).
//!
//! Every diffuse surface is lit by all lights with one shadow ray each, by the shadow rule: area lights at one point a sample,
//! in the first sample their middle, so that shadows are free of noise, hard at first and soft in time. Mirrors reflect, glass both reflects and refracts. The sky lights as if nothing stood in its
//! way. Scenes with more than [`LIGHTS_MAX`] lights draw that many by power instead.

//!
//! The pixels of a tile are walked together, bounce by bounce, so that rays of one kind are traced in packets.

use std::f32::consts::PI;

use glam::Vec3;

use super::bsdf::{Bsdf, ShadingFrame, transmittance};
use super::light_sampling::LightSample;
use super::observer::{RayKind, RayObserver, TracedRays};
use super::pass::{LIGHTS_MAX, Pass};
use super::path::{absorption_before, medium_behind};
use super::sampler::Sampler;
use crate::geometry::{Hit, Ray};
use crate::scene::Surface;
use crate::task::{Cancelled, Task};
use crate::world::{Packets, World};

/// A reflected or refracted ray that would add less than this is not traced.
const WEIGHT_MIN: f32 = 1.0 / 512.0;

/// What belongs to a ray of a pixel's tree that is still to be traced.
#[derive(Clone, Copy, Debug)]
struct Branch {
    /// What its radiance is multiplied with.
    weight: Vec3,
    /// What the medium that it runs through absorbs per unit length.
    medium: Vec3,
}

/// The pixel of a ray, and from whose hit it goes on.
#[derive(Clone, Copy, Debug)]
struct Origin {
    pixel: u32,
    parent: u32,
}

/// Rays of one kind, each for a pixel and with what belongs to it.
#[derive(Clone, Debug)]
struct Rays<T> {
    rays: Vec<Ray>,
    pixels: Vec<u32>,
    /// As in [`TracedRays`].
    parents: Vec<u32>,
    with: Vec<T>,
}

impl<T> Default for Rays<T> {
    fn default() -> Self {
        Self { rays: Vec::new(), pixels: Vec::new(), parents: Vec::new(), with: Vec::new() }
    }
}

impl<T> Rays<T> {
    fn clear(&mut self) {
        self.rays.clear();
        self.pixels.clear();
        self.parents.clear();
        self.with.clear();
    }

    fn push(&mut self, ray: Ray, of: Origin, with: T) {
        self.rays.push(ray);
        self.pixels.push(of.pixel);
        self.parents.push(of.parent);
        self.with.push(with);
    }
}

/// Walks the ray trees of camera rays. Keeps its memory from one call to the next: one for a thread.
#[derive(Debug)]
pub struct Whitted<'w> {
    packets: Packets<'w>,
    branches: Rays<Branch>,
    next: Rays<Branch>,
    /// Shadow rays with the light that arrives if nothing blocks them.
    shadows: Rays<Vec3>,
    samplers: Vec<Sampler>,
    sums: Vec<Vec3>,
}

impl<'w> Whitted<'w> {
    pub fn new(world: &'w World) -> Self {
        Self {
            packets: Packets::new(world),
            branches: Rays::default(),
            next: Rays::default(),
            shadows: Rays::default(),
            samplers: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// The radiance that arrives at each of some pixels: one sample of it. `observer` is told of every ray.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn radiance<O: RayObserver>(
        &mut self,
        pass: &Pass,
        pixels: &[[u32; 2]],
        observer: &mut O,
        task: &Task,
    ) -> Result<&[Vec3], Cancelled> {
        self.sums.clear();
        self.sums.resize(pixels.len(), Vec3::ZERO);
        self.samplers.clear();
        self.samplers.extend(pixels.iter().map(|&[x, y]| pass.sampler(x, y)));
        self.branches.clear();
        for (pixel, &[x, y]) in pixels.iter().enumerate() {
            let branch = Branch { weight: Vec3::ONE, medium: Vec3::ZERO };
            let of = Origin { pixel: pixel as u32, parent: 0 };
            self.branches.push(pass.camera_ray(x, y), of, branch);
        }
        let mut depth = 0;
        while !self.branches.rays.is_empty() {
            task.check()?;
            let kind = if depth == 0 { RayKind::Camera } else { RayKind::Bounce };
            let Rays { rays, pixels, parents, with } = &self.branches;
            let hits = if O::COUNTS {
                let (hits, counters) = self.packets.intersect_and_count(rays);
                observer.traced(&TracedRays { kind, rays, pixels, parents, counters });
                hits
            } else {
                observer.traced(&TracedRays { kind, rays, pixels, parents, counters: &[] });
                self.packets.intersect(rays)
            };
            if observer.asks_for_camera_rays_alone() {
                break;
            }
            self.next.clear();
            self.shadows.clear();
            let deeper = depth < pass.max_depth;
            let found = rays.iter().zip(pixels).zip(with).zip(hits);
            for (parent, (((ray, &pixel), branch), hit)) in found.enumerate() {
                let mut shading = Shading {
                    of: Origin { pixel, parent: parent as u32 },
                    sum: &mut self.sums[pixel as usize],
                    sampler: &mut self.samplers[pixel as usize],
                    next: deeper.then_some(&mut self.next),
                    shadows: &mut self.shadows,
                };
                shading.shade(pass, ray, branch, hit.as_ref());
            }
            self.light(pass, observer);
            std::mem::swap(&mut self.branches, &mut self.next);
            depth += 1;
        }
        Ok(&self.sums)
    }

    /// Adds the light whose way is free.
    fn light<O: RayObserver>(&mut self, pass: &Pass, observer: &mut O) {
        let Rays { rays, pixels, parents, with } = &self.shadows;
        let kind = RayKind::Shadow;
        let blocked = if O::COUNTS {
            let (blocked, counters) = self.packets.occluded_filtered_and_count(rays, pass.shadow_rule);
            observer.traced(&TracedRays { kind, rays, pixels, parents, counters });
            blocked
        } else {
            observer.traced(&TracedRays { kind, rays, pixels, parents, counters: &[] });
            self.packets.occluded_filtered(rays, pass.shadow_rule)
        };
        for ((&pixel, &light), &blocked) in pixels.iter().zip(with).zip(blocked) {
            if !blocked {
                self.sums[pixel as usize] += light;
            }
        }
    }
}

/// Where the light of one hit goes, and the rays that it asks for.
struct Shading<'s> {
    /// Of the rays that go on from here.
    of: Origin,
    sum: &'s mut Vec3,
    sampler: &'s mut Sampler,
    /// `None` at the greatest depth.
    next: Option<&'s mut Rays<Branch>>,
    shadows: &'s mut Rays<Vec3>,
}

impl Shading<'_> {
    #[inline]
    fn shade(&mut self, pass: &Pass, ray: &Ray, branch: &Branch, hit: Option<&Hit>) {
        let scene = &*pass.world.scene;
        let &Branch { weight, medium } = branch;
        let Some(hit) = hit else {
            *self.sum += weight * scene.sky.radiance;
            return;
        };
        let surface = scene.surface(ray, hit);
        let frame = ShadingFrame::new(&surface, ray.direction);
        let bsdf = Bsdf::new(&scene.materials[surface.material as usize], surface.uv, &scene.images);
        let weight = weight * transmittance(absorption_before(&bsdf, surface.front, medium), hit.t);
        let mut go_on = |direction: Vec3, weight: Vec3| {
            if let Some(next) = &mut self.next
                && weight.max_element() >= WEIGHT_MIN
            {
                let medium = medium_behind(&bsdf, &frame, direction, medium);
                let ray = Ray::new(surface.ray_origin(direction), direction);
                next.push(ray, self.of, Branch { weight, medium });
            }
        };
        match bsdf {
            Bsdf::Emissive { radiance } if surface.front => *self.sum += weight * radiance,
            Bsdf::Emissive { .. } => {}
            Bsdf::Mirror { tint } => go_on(frame.reflected(), weight * tint),
            Bsdf::Glass { ior, .. } => {
                let split = frame.split(ior);
                go_on(split.reflected, weight * split.reflectance);
                if let Some(refracted) = split.refracted {
                    go_on(refracted, weight * (1.0 - split.reflectance));
                }
            }
            Bsdf::Diffuse { albedo, reflectivity } => {
                if reflectivity > 0.0 {
                    go_on(frame.reflected(), weight * reflectivity);
                }
                let reflected = weight * ((1.0 - reflectivity) * albedo);
                *self.sum += reflected * scene.sky.radiance;
                self.ask_for_light(pass, &surface, &frame, reflected / PI);
            }
        }
    }

    /// Shadow rays to all lights but the sky; `reflected` is the radiance for unit irradiance.
    #[inline(always)]
    fn ask_for_light(&mut self, pass: &Pass, surface: &Surface, frame: &ShadingFrame, reflected: Vec3) {
        let lights = &pass.lights;
        if lights.len() <= LIGHTS_MAX {
            for index in 0..lights.len() {
                let light = pass.sample_light(index, surface, self.sampler);
                self.ask(light, frame, reflected);
            }
        } else {
            for part in 0..LIGHTS_MAX {
                let pick = (part as f64 + self.sampler.next_fine()) / LIGHTS_MAX as f64;
                let light = lights.sample_lights(surface, frame, pick, self.sampler.next_2d());
                self.ask(light, frame, reflected / LIGHTS_MAX as f32);
            }
        }
    }

    #[inline(always)]
    fn ask(&mut self, light: Option<LightSample>, frame: &ShadingFrame, reflected: Vec3) {
        let Some(light) = light else { return };
        let cosine = frame.cosine(light.direction);
        if cosine > 0.0 {
            let arriving = light.radiance * (cosine / light.pdf);
            self.shadows.push(light.shadow_ray, self.of, reflected * arriving);
        }
    }
}
