//! The path tracer: the rendering equation by cosine-weighted and light sampling with multiple importance sampling.
//!
//! Kajiya, "The Rendering Equation" (1986); Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo
//! Rendering" (1995), whose power heuristic weighs the two. Shadow rays are always plain `occluded`: glass and mirrors
//! block, and light through them is found by sampling the BSDF, so nothing is counted twice.

use glam::Vec3;

use super::bsdf::{Bsdf, ShadingFrame, transmittance};
use super::observer::{RayKind, RayObserver, TracedRays};
use super::pass::Pass;
use super::sampler::Sampler;
use crate::geometry::Ray;
use crate::scene::Surface;

/// Bounces before Russian roulette may end a path.
const ROULETTE_FROM: u32 = 3;

/// How light is found. All have the same expected value; panels and point lights, which no ray can hit, need light
/// sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Estimator {
    /// By scattered rays alone.
    Plain,
    /// By sampling the lights wherever they can be sampled.
    NextEvent,
    /// By both, weighted.
    #[default]
    Mis,
}

impl Estimator {
    pub const ALL: [Self; 3] = [Self::Plain, Self::NextEvent, Self::Mis];

    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::NextEvent => "next-event",
            Self::Mis => "mis",
        }
    }

    /// The weight of light found by a scattered ray of PDF `scattered`, when light sampling would have found it with PDF
    /// `sampled` (0 for never).
    fn scattered_weight(self, scattered: f32, sampled: f32) -> f32 {
        match self {
            Self::Plain => 1.0,
            Self::NextEvent => f32::from(u8::from(sampled == 0.0)),
            Self::Mis => power_heuristic(scattered, sampled),
        }
    }

    /// The weight of light found by light sampling with PDF `sampled`, when a scattered ray would have found it with PDF
    /// `scattered` (0 for never).
    fn sampled_weight(self, sampled: f32, scattered: f32) -> f32 {
        match self {
            Self::Plain => 0.0,
            Self::NextEvent => 1.0,
            Self::Mis => power_heuristic(sampled, scattered),
        }
    }
}

/// The share of the first of two techniques, from their PDFs squared.
fn power_heuristic(first: f32, second: f32) -> f32 {
    // Divided before squaring: a PDF may be as large as f32 allows.
    let ratio = second / first;
    1.0 / (1.0 + ratio * ratio)
}

/// Where and how the last ray was scattered by a smooth lobe.
struct Scattered {
    position: Vec3,
    pdf: f32,
    /// Against the shading normal there.
    cosine: f32,
}

/// The radiance that arrives along a camera ray: one sample of it. `observer` is told of every ray; what they count is not
/// looked at.
pub fn radiance<O: RayObserver>(
    pass: &Pass,
    estimator: Estimator,
    mut ray: Ray,
    sampler: &mut Sampler,
    observer: &mut O,
) -> Vec3 {
    let scene = &*pass.world.scene;
    let mut sum = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // `None` after the eye, a mirror or glass: light sampling cannot have found what such a ray hits.
    let mut scattered: Option<Scattered> = None;
    let mut medium = Vec3::ZERO;
    for bounce in 0.. {
        let kind = if bounce == 0 { RayKind::Camera } else { RayKind::Bounce };
        observer.traced(&traced_alone(kind, &ray));
        let Some(hit) = pass.world.intersect(&ray, &mut ()) else {
            let weight = scattered
                .as_ref()
                .map_or(1.0, |s| estimator.scattered_weight(s.pdf, pass.lights.pdf_of_sky(s.cosine)));
            sum += throughput * weight * scene.sky.radiance;
            break;
        };
        let surface = scene.surface(&ray, &hit);
        let frame = ShadingFrame::new(&surface, ray.direction);
        let bsdf = Bsdf::new(&scene.materials[surface.material as usize], surface.uv, &scene.images);
        throughput *= transmittance(absorption_before(&bsdf, surface.front, medium), hit.t);
        if let Bsdf::Emissive { radiance } = bsdf {
            if surface.front {
                let weight = scattered.as_ref().map_or(1.0, |s| {
                    let sampled = pass.lights.pdf_of_hit(s.position, ray.direction, hit.t, &surface);
                    estimator.scattered_weight(s.pdf, sampled)
                });
                sum += throughput * weight * radiance;
            }
            break;
        }
        if bounce >= pass.max_depth {
            break;
        }
        if estimator != Estimator::Plain && bsdf.has_smooth_lobe() {
            sum += throughput * sampled_light(pass, estimator, &surface, &frame, &bsdf, sampler, observer);
        }
        let lobe = sampler.next_1d();
        let Some(sample) = bsdf.sample(&frame, lobe, sampler.next_2d()) else { break };
        throughput *= sample.weight;
        if !survives(&mut throughput, bounce, sampler) {
            break;
        }
        scattered = sample.pdf.map(|pdf| Scattered {
            position: surface.position,
            pdf,
            cosine: frame.cosine(sample.direction),
        });
        medium = medium_behind(&bsdf, &frame, sample.direction, medium);
        ray = Ray::new(surface.ray_origin(sample.direction), sample.direction);
    }
    sum
}

fn traced_alone(kind: RayKind, ray: &Ray) -> TracedRays<'_> {
    TracedRays { kind, rays: std::slice::from_ref(ray), pixels: &[0], parents: &[0], counters: &[] }
}

/// What the medium before a surface absorbs per unit length: inside glass that glass's own, whatever was crossed before.
pub fn absorption_before(bsdf: &Bsdf, front: bool, medium: Vec3) -> Vec3 {
    match *bsdf {
        Bsdf::Glass { absorption, .. } if !front => absorption,
        Bsdf::Glass { .. } | Bsdf::Diffuse { .. } | Bsdf::Mirror { .. } | Bsdf::Emissive { .. } => medium,
    }
}

/// What the medium absorbs into which a ray of `direction` leaves the surface.
pub fn medium_behind(bsdf: &Bsdf, frame: &ShadingFrame, direction: Vec3, medium: Vec3) -> Vec3 {
    match *bsdf {
        Bsdf::Glass { absorption, .. } => {
            let goes_through = frame.geometric_normal.dot(direction) < 0.0;
            match (frame.front, goes_through) {
                (true, true) | (false, false) => absorption,
                (true, false) => medium,
                (false, true) => Vec3::ZERO,
            }
        }
        Bsdf::Diffuse { .. } | Bsdf::Mirror { .. } | Bsdf::Emissive { .. } => medium,
    }
}

/// Light from one sampled point of a light, scattered towards the viewer.
fn sampled_light<O: RayObserver>(
    pass: &Pass,
    estimator: Estimator,
    surface: &Surface,
    frame: &ShadingFrame,
    bsdf: &Bsdf,
    sampler: &mut Sampler,
    observer: &mut O,
) -> Vec3 {
    let Some(light) = pass.lights.sample(surface, frame, sampler) else { return Vec3::ZERO };
    let cosine = frame.cosine(light.direction);
    if cosine == 0.0 {
        return Vec3::ZERO;
    }
    observer.traced(&traced_alone(RayKind::Shadow, &light.shadow_ray));
    if pass.world.occluded(&light.shadow_ray, &mut ()).is_some() {
        return Vec3::ZERO;
    }
    let scattered = if light.can_be_hit { bsdf.pdf(frame, light.direction) } else { 0.0 };
    let weight = estimator.sampled_weight(light.pdf, scattered);
    bsdf.f(frame, light.direction) * light.radiance * (cosine * weight / light.pdf)
}

/// Russian roulette: whether the path goes on, its throughput raised by what ends. The chance is the throughput, kept
/// within 0.1 and 0.9.
fn survives(throughput: &mut Vec3, bounce: u32, sampler: &mut Sampler) -> bool {
    let most = throughput.max_element();
    if most <= 0.0 {
        return false;
    }
    if bounce < ROULETTE_FROM {
        return true;
    }
    let chance = most.clamp(0.1, 0.9);
    *throughput /= chance;
    sampler.next_1d() < chance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_both_techniques_add_up_to_one() {
        for estimator in [Estimator::NextEvent, Estimator::Mis] {
            for (scattered, sampled) in [(0.3, 0.5), (1e-20, 3.0), (2.0, 1e30), (0.5, 0.5)] {
                let sum = estimator.scattered_weight(scattered, sampled)
                    + estimator.sampled_weight(sampled, scattered);
                assert!((sum - 1.0).abs() < 1e-6, "{estimator:?} {scattered} {sampled}: {sum}");
            }
            // What light sampling never finds is left to scattered rays whole, and the other way round.
            assert_eq!(estimator.scattered_weight(0.3, 0.0), 1.0);
            assert_eq!(estimator.sampled_weight(0.3, 0.0), 1.0);
        }
        assert_eq!(Estimator::Plain.scattered_weight(0.3, 0.5), 1.0);
        assert_eq!(Estimator::Plain.sampled_weight(0.5, 0.3), 0.0);
    }

    #[test]
    fn roulette_keeps_the_expected_throughput() {
        for start in [0.02, 0.5, 2.0] {
            let mut sampler = Sampler::new(5, [0, 0], 0);
            let mut sum = 0.0;
            for _ in 0..20_000 {
                let mut throughput = Vec3::splat(start);
                if survives(&mut throughput, ROULETTE_FROM, &mut sampler) {
                    sum += f64::from(throughput.x);
                }
            }
            let mean = sum / 2e4;
            assert!((mean / f64::from(start) - 1.0).abs() < 0.05, "{start}: {mean}");
        }
    }

    #[test]
    fn roulette_waits_and_ends_what_is_black_at_once() {
        let mut sampler = Sampler::new(5, [0, 0], 0);
        assert!(!survives(&mut Vec3::ZERO.clone(), 0, &mut sampler));
        for _ in 0..100 {
            let mut throughput = Vec3::splat(0.01);
            assert!(survives(&mut throughput, ROULETTE_FROM - 1, &mut sampler));
            assert_eq!(throughput, Vec3::splat(0.01));
        }
    }
}
