//! One sample of every pixel of a picture: what all integrators and counters of that sample share.

use glam::Vec2;

use super::film::RenderSettings;
use super::light_sampling::{AreaPoint, LightSample, LightTable};
use super::sampler::{Sampler, pixel_offset, shared_pick, shared_point};
use crate::geometry::Ray;
use crate::scene::camera::CameraFrame;
use crate::scene::{Camera, ShadowRule, Surface};
use crate::world::World;

/// With more lights than this, Whitted and the shadow views draw some by their power instead of asking all.
pub const LIGHTS_MAX: usize = 16;

/// Everything that a pixel's value is a function of, for one sample number.
#[derive(Debug)]
pub struct Pass<'a> {
    pub world: &'a World,
    pub lights: LightTable<'a>,
    pub camera: CameraFrame,
    pub shadow_rule: ShadowRule,
    pub seed: u64,
    pub max_depth: u32,
    /// Number of the sample, from 0. Sample 0 goes through the pixel's centre.
    pub sample: u32,
    /// Where in its pixel every camera ray goes, in pixels from the top left.
    pixel_offset: Vec2,
    /// Where on flat and round lights all pixels of this sample sample them, for Whitted and the shadow views.
    pub light_point: Vec2,
    /// That point of every flat light, up to [`LIGHTS_MAX`] lights.
    flat_points: Vec<Option<AreaPoint>>,
    /// Which of several lights the shadow views ask for, as a share of what arrives from all of them.
    pub light_pick: f32,
}

impl<'a> Pass<'a> {
    /// Sample number `sample` of a picture of `size` pixels (the size in `settings` is not looked at).
    pub fn new(
        world: &'a World,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
        shadow_rule: ShadowRule,
        sample: u32,
    ) -> Self {
        let lights = LightTable::new(&world.scene);
        let light_point = shared_point(sample);
        let count = lights.len().min(LIGHTS_MAX);
        Self {
            world,
            flat_points: (0..count).map(|index| lights.flat_point(index, light_point)).collect(),
            lights,
            camera: camera.frame(size[0], size[1]),
            shadow_rule,
            seed: settings.seed,
            max_depth: settings.max_depth,
            sample,
            pixel_offset: pixel_offset(sample),
            light_point,
            light_pick: shared_pick(sample),
        }
    }

    /// A point of light number `index`, one of the first [`LIGHTS_MAX`]: the one that all pixels share, where that is as
    /// good for all.
    #[inline(always)]
    pub fn sample_light(&self, index: usize, to: &Surface, sampler: &mut Sampler) -> Option<LightSample> {
        if let Some(flat) = &self.flat_points[index] {
            return self.lights.sample_at(flat, to);
        }
        let u = if self.lights.shows_one_side(index) { self.light_point } else { sampler.next_2d() };
        self.lights.sample_one(index, to, u)
    }

    /// The camera ray of this sample.
    #[inline]
    pub fn camera_ray(&self, x: u32, y: u32) -> Ray {
        self.camera.ray(Vec2::new(x as f32, y as f32) + self.pixel_offset)
    }

    /// The random numbers of a pixel in this sample.
    #[inline]
    pub fn sampler(&self, x: u32, y: u32) -> Sampler {
        Sampler::new(self.seed, [x, y], self.sample)
    }
}
