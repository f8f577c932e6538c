//! The same shadow ray asked three ways: `intersect`, `occluded`, and `occluded` with a filter.

use std::f32::consts::PI;

use glam::Vec3;
use serde::Serialize;

use super::bsdf::ShadingFrame;
use super::film::RenderSettings;
use super::light_sampling::LightSample;
use super::pass::{LIGHTS_MAX, Pass};
use super::sampler::Sampler;
use crate::accel::{Probe, RayCounters};
use crate::geometry::{Hit, Ray};
use crate::scene::{Camera, MaterialKind, ShadowRule, Surface};
use crate::world::World;

/// What a pixel shows when both answers are held against each other. The discriminant is what a class film stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[repr(u8)]
pub enum ShadowClass {
    /// A miss, an emitter, or the light behind the surface: no ray is asked.
    NotAsked = 0,
    LitInBoth = 1,
    DarkInBoth = 2,
    /// The false shadow.
    DarkOnlyInOccluded = 3,
    /// Impossible; a test holds it at zero.
    DarkOnlyInIntersect = 4,
}

impl ShadowClass {
    pub const ALL: [Self; 5] = [
        Self::NotAsked,
        Self::LitInBoth,
        Self::DarkInBoth,
        Self::DarkOnlyInOccluded,
        Self::DarkOnlyInIntersect,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::NotAsked => "not asked",
            Self::LitInBoth => "lit in both",
            Self::DarkInBoth => "dark in both",
            Self::DarkOnlyInOccluded => "dark only in occluded (false shadow)",
            Self::DarkOnlyInIntersect => "dark only in intersect (impossible)",
        }
    }

    /// sRGB, as in the view.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::NotAsked => [38, 40, 46],
            Self::LitInBoth => [222, 214, 190],
            Self::DarkInBoth => [86, 92, 104],
            Self::DarkOnlyInOccluded => [232, 80, 64],
            Self::DarkOnlyInIntersect => [255, 0, 255],
        }
    }

    /// The class that a class film stored.
    pub fn from_number(number: f32) -> Option<Self> {
        Self::ALL.into_iter().find(|c| f32::from(*c as u8) == number)
    }
}

/// The nodes visited and the answer of one way of asking.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShadowAnswer {
    /// The shape that blocks, if one does: for `intersect` the nearest, for the others the one found first.
    pub blocker: Option<u32>,
    pub counters: RayCounters,
}

/// The three ways of asking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShadowQuery {
    /// Nearest hits, going on through what lets light pass.
    Intersect,
    /// Any hit.
    Occluded,
    /// Any hit that blocks.
    Filtered,
}

impl ShadowQuery {
    pub const ALL: [Self; 3] = [Self::Intersect, Self::Occluded, Self::Filtered];

    pub fn name(self) -> &'static str {
        match self {
            Self::Intersect => "intersect",
            Self::Occluded => "occluded",
            Self::Filtered => "occluded with filter",
        }
    }

    /// Asks a shadow ray this way: the blocking shape.
    #[inline]
    pub fn ask<P: Probe>(self, world: &World, ray: &Ray, rule: ShadowRule, probe: &mut P) -> Option<u32> {
        match self {
            Self::Intersect => world.occluded_by_intersect(ray, rule, probe),
            Self::Occluded => world.occluded(ray, probe),
            Self::Filtered => world.occluded_filtered(ray, rule, probe),
        }
    }
}

/// One shadow ray asked three ways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShadowAnswers {
    pub class: ShadowClass,
    pub intersect: ShadowAnswer,
    pub occluded: ShadowAnswer,
    pub filtered: ShadowAnswer,
}

impl ShadowAnswers {
    /// Asks `ray` all three ways.
    pub fn of(world: &World, ray: &Ray, rule: ShadowRule) -> Self {
        let [intersect, occluded, filtered] = ShadowQuery::ALL.map(|query| {
            let mut counters = RayCounters::default();
            let blocker = query.ask(world, ray, rule, &mut counters);
            ShadowAnswer { blocker, counters }
        });
        Self { class: class_of(intersect.blocker, occluded.blocker), intersect, occluded, filtered }
    }

    /// Nodes visited by `intersect` minus those visited by `occluded` with filter.
    pub fn nodes_saved(&self) -> i64 {
        self.intersect.counters.nodes_visited() as i64 - self.filtered.counters.nodes_visited() as i64
    }
}

/// The class of a pixel whose shadow ray was blocked by these, if by anything.
fn class_of(intersect: Option<u32>, occluded: Option<u32>) -> ShadowClass {
    match (intersect, occluded) {
        (None, None) => ShadowClass::LitInBoth,
        (Some(_), Some(_)) => ShadowClass::DarkInBoth,
        (None, Some(_)) => ShadowClass::DarkOnlyInOccluded,
        (Some(_), None) => ShadowClass::DarkOnlyInIntersect,
    }
}

/// What a pixel's camera ray meets, as the shadow views see it.
#[derive(Clone, Copy, Debug)]
pub enum FirstHit {
    /// A miss, an emitter, or no light before the surface: its colour, with no ray to ask.
    NotAsked { color: Vec3 },
    /// A surface that a light may shine on. Whatever its material, it is shaded as diffuse.
    Asked {
        /// From the surface to one point of one light, the same for every way of asking.
        shadow_ray: Ray,
        /// The colour in shadow, from the sky alone.
        dark: Vec3,
        /// What the light adds where the way is free.
        light: Vec3,
    },
}

/// What a pixel's camera ray hit in a pass, with its one light sample. The sky is sampled only where there is no other light.
pub fn first_hit(pass: &Pass, [x, y]: [u32; 2], ray: &Ray, hit: Option<Hit>) -> FirstHit {
    let scene = &*pass.world.scene;
    let Some(hit) = hit else {
        return FirstHit::NotAsked { color: scene.sky.radiance };
    };
    let surface = scene.surface(ray, &hit);
    let material = &scene.materials[surface.material as usize];
    if let MaterialKind::Emissive { radiance } = material.kind {
        return FirstHit::NotAsked { color: if surface.front { radiance } else { Vec3::ZERO } };
    }
    let frame = ShadingFrame::new(&surface, ray.direction);
    let albedo = material.color_at(surface.uv, &scene.images).clamp(Vec3::ZERO, Vec3::ONE);
    let dark = if pass.lights.is_empty() { Vec3::ZERO } else { albedo * scene.sky.radiance };
    match one_light(pass, &surface, &frame, &mut pass.sampler(x, y)) {
        Some((light, irradiance)) => {
            FirstHit::Asked { shadow_ray: light.shadow_ray, dark, light: albedo * irradiance / PI }
        }
        None => FirstHit::NotAsked { color: dark },
    }
}

/// One point of one light that is before the surface, and the irradiance that it stands for: of several lights each as
/// often as its share of what would arrive without any shadow. `None` where nothing would.
fn one_light(
    pass: &Pass,
    surface: &Surface,
    frame: &ShadingFrame,
    sampler: &mut Sampler,
) -> Option<(LightSample, Vec3)> {
    let lights = &pass.lights;
    let arriving = |light: &LightSample| light.radiance * (frame.cosine(light.direction) / light.pdf);
    let shines = |(_, irradiance): &(LightSample, Vec3)| irradiance.max_element() > 0.0;
    if lights.is_empty() || lights.len() > LIGHTS_MAX {
        let pick = sampler.next_fine();
        let light = lights.sample_lights(surface, frame, pick, sampler.next_2d())?;
        return Some((light, arriving(&light))).filter(shines);
    }
    let mut candidates = [None; LIGHTS_MAX];
    for (index, candidate) in candidates.iter_mut().enumerate().take(lights.len()) {
        let light = pass.sample_light(index, surface, sampler);
        *candidate = light.map(|light| (light, arriving(&light))).filter(shines);
    }
    let total: f32 = candidates.iter().flatten().map(|(_, irradiance)| irradiance.max_element()).sum();
    let mut rest = pass.light_pick * total;
    let mut picked = None;
    for (light, irradiance) in candidates.into_iter().flatten() {
        let share = irradiance.max_element();
        picked = Some((light, irradiance * (total / share)));
        if rest < share {
            break;
        }
        rest -= share;
    }
    picked
}

/// The pixel's colour with shadows by one way of asking.
pub fn shaded(pass: &Pass, query: ShadowQuery, first: &FirstHit) -> Vec3 {
    match first {
        FirstHit::NotAsked { color } => *color,
        FirstHit::Asked { shadow_ray, dark, light } => {
            let blocked = query.ask(pass.world, shadow_ray, pass.shadow_rule, &mut ()).is_some();
            if blocked { *dark } else { *dark + *light }
        }
    }
}

/// The pixel's class.
pub fn class(pass: &Pass, first: &FirstHit) -> ShadowClass {
    match first {
        FirstHit::NotAsked { .. } => ShadowClass::NotAsked,
        FirstHit::Asked { shadow_ray, .. } => class_of(
            ShadowQuery::Intersect.ask(pass.world, shadow_ray, pass.shadow_rule, &mut ()),
            ShadowQuery::Occluded.ask(pass.world, shadow_ray, pass.shadow_rule, &mut ()),
        ),
    }
}

/// Asks the shadow ray of a pixel in a pass three ways; `None` where there is none.
pub fn answers(pass: &Pass, first: &FirstHit) -> Option<ShadowAnswers> {
    match first {
        FirstHit::NotAsked { .. } => None,
        FirstHit::Asked { shadow_ray, .. } => {
            Some(ShadowAnswers::of(pass.world, shadow_ray, pass.shadow_rule))
        }
    }
}

/// Asks the shadow ray of one pixel of a picture of the size in `settings` three ways, as the views `shadow-difference` and
/// `shadow-saving` do; `None` where there is none.
pub fn answers_at(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    rule: ShadowRule,
    pixel: [u32; 2],
) -> Option<ShadowAnswers> {
    let pass = Pass::new(world, camera, [settings.width, settings.height], settings, rule, 0);
    let ray = pass.camera_ray(pixel[0], pixel[1]);
    answers(&pass, &first_hit(&pass, pixel, &ray, world.intersect(&ray, &mut ())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_film_s_numbers_name_the_classes() {
        for class in ShadowClass::ALL {
            assert_eq!(ShadowClass::from_number(f32::from(class as u8)), Some(class));
        }
        assert_eq!(ShadowClass::from_number(f32::NAN), None);
        assert_eq!(ShadowClass::from_number(2.5), None);
    }

    #[test]
    fn the_false_shadow_is_dark_in_occluded_alone() {
        assert_eq!(class_of(None, Some(3)), ShadowClass::DarkOnlyInOccluded);
        assert_eq!(class_of(Some(3), None), ShadowClass::DarkOnlyInIntersect);
        assert_eq!(class_of(Some(3), Some(4)), ShadowClass::DarkInBoth);
        assert_eq!(class_of(None, None), ShadowClass::LitInBoth);
    }
}
