//! Points on lights, with their PDFs by solid angle.
//!
//! Spheres are sampled within the cone that they fill (Shirley, Wang, Zimmerman, "Monte Carlo Techniques for Direct
//! Lighting Calculations", 1996), every other shape by its area, the dome by the cosine against the receiver.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::{Vec2, Vec3};

use super::bsdf::{ShadingFrame, cosine_weighted};
use super::sampler::Sampler;
use crate::geometry::{Ray, Shape, ShapeKind, Sphere, SurfaceSample};
use crate::scene::{Light, MaterialKind, Scene, Surface};

/// The share of picks that the sky gets beside other lights. Small: it is everywhere, and scattered rays find it.
const SKY_SHARE: f64 = 0.25;

/// A scene's lights with the probability of picking each, in proportion to its power. Made in one pass over the lights.
#[derive(Clone, Debug)]
pub struct LightTable<'s> {
    scene: &'s Scene,
    /// Sums of the probabilities up to and with each of `scene.lights`.
    cumulative: Vec<f64>,
    probability: Vec<f32>,
    /// 0 for a point light.
    area: Vec<f32>,
    /// Shape index and light index, sorted by shape.
    shape_lights: Vec<(u32, u32)>,
    sky_probability: f32,
}

/// The way to one point of a light, not yet asked whether it is free.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, from the receiver.
    pub direction: Vec3,
    /// Incoming radiance, if the way is free. For a point light its intensity over the squared distance.
    pub radiance: Vec3,
    /// By solid angle, with the probability of the pick in it; for a point light that probability alone.
    pub pdf: f32,
    /// Whether a scattered ray can find this light, too.
    pub can_be_hit: bool,
    /// From the receiver's surface to just before the light. Its direction is not of unit length.
    pub shadow_ray: Ray,
}

/// What a light's surface sends out.
#[derive(Clone, Copy, Debug)]
struct Emission {
    radiance: Vec3,
    can_be_hit: bool,
}

/// A point of a light drawn by area, before the receiver is known.
#[derive(Clone, Copy, Debug)]
pub struct AreaPoint {
    index: usize,
    point: SurfaceSample,
    emission: Emission,
}

/// A point of a light's surface, seen from a receiver.
struct LightPoint {
    point: SurfaceSample,
    /// Unit, from the receiver.
    direction: Vec3,
    /// By solid angle.
    pdf: f32,
}

impl<'s> LightTable<'s> {
    pub fn new(scene: &'s Scene) -> Self {
        let area: Vec<f32> = scene.lights.iter().map(|light| light_area(scene, light)).collect();
        let power = scene.lights.iter().zip(&area).map(|(light, area)| light_power(scene, light, *area));
        let mut cumulative: Vec<f64> = power
            .scan(0.0, |sum, power| {
                *sum += power;
                Some(*sum)
            })
            .collect();
        let total = cumulative.last().copied().unwrap_or(0.0);
        let sky_probability = match (has_light(scene.sky.radiance), total > 0.0) {
            (false, _) => 0.0,
            (true, true) => SKY_SHARE,
            (true, false) => 1.0,
        };
        let mut before = 0.0;
        let mut probability = Vec::with_capacity(cumulative.len());
        for sum in &mut cumulative {
            *sum = if total > 0.0 { *sum / total } else { 0.0 };
            probability.push(((*sum - before) * (1.0 - sky_probability)) as f32);
            before = *sum;
        }
        let mut shape_lights: Vec<(u32, u32)> = scene
            .lights
            .iter()
            .zip(0..)
            .filter_map(|(light, i)| match light {
                Light::Shape { shape } => Some((*shape, i)),
                Light::Point { .. } | Light::Panel { .. } => None,
            })
            .collect();
        shape_lights.sort_unstable();
        Self { scene, cumulative, probability, area, shape_lights, sky_probability: sky_probability as f32 }
    }

    /// How many lights there are, without the sky.
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// Whether there is no light but perhaps the sky.
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }

    /// Picks a light or the sky, and a point of it. `None` where the pick sends no light to the receiver.
    #[inline]
    pub fn sample(&self, to: &Surface, frame: &ShadingFrame, sampler: &mut Sampler) -> Option<LightSample> {
        let pick = sampler.next_fine();
        let u = sampler.next_2d();
        let sky = f64::from(self.sky_probability);
        if pick < sky {
            return self.sample_sky(to, frame, u).map(|s| s.picked(self.sky_probability));
        }
        let index = self.light_at((pick - sky) / (1.0 - sky))?;
        self.sample_one(index, to, u).map(|s| s.picked(self.probability[index]))
    }

    /// Like [`LightTable::sample`], but picks among the lights without the sky, by `pick` in `[0, 1)`. The sky alone, if
    /// there are no others.
    #[inline]
    pub fn sample_lights(
        &self,
        to: &Surface,
        frame: &ShadingFrame,
        pick: f64,
        u: Vec2,
    ) -> Option<LightSample> {
        match self.light_at(pick) {
            Some(index) => {
                let probability = self.probability[index] / (1.0 - self.sky_probability);
                self.sample_one(index, to, u).map(|s| s.picked(probability))
            }
            None if self.sky_probability > 0.0 => self.sample_sky(to, frame, u),
            None => None,
        }
    }

    /// A point of light number `index`, with a PDF that holds no pick.
    #[inline]
    pub fn sample_one(&self, index: usize, to: &Surface, u: Vec2) -> Option<LightSample> {
        match self.scene.lights[index] {
            Light::Point { position, intensity } => sample_point(position, intensity, to),
            Light::Panel { .. } | Light::Shape { .. } => match self.shape(index) {
                Shape::Sphere(sphere) => {
                    cone_point(&sphere, to.position, u)?.seen_from(to, self.emission(index)?)
                }
                other => self.sample_at(&self.area_point(index, &other, u)?, to),
            },
        }
    }

    /// The point of light number `index` for `u`, where it is the same for every receiver and as good for all: on flat
    /// lights, which show all of them the same side.
    pub fn flat_point(&self, index: usize, u: Vec2) -> Option<AreaPoint> {
        match self.scene.lights[index] {
            Light::Point { .. } => None,
            Light::Panel { .. } | Light::Shape { .. } => {
                let shape = self.shape(index);
                match shape.kind() {
                    ShapeKind::Triangle | ShapeKind::Quad => self.area_point(index, &shape, u),
                    ShapeKind::Sphere | ShapeKind::Cuboid | ShapeKind::Torus => None,
                }
            }
        }
    }

    /// The way to a point drawn by area; `None` where the receiver is on its inside.
    #[inline(always)]
    pub fn sample_at(&self, light: &AreaPoint, to: &Surface) -> Option<LightSample> {
        let way = light.point.position - to.position;
        let distance = way.length();
        let direction = way / distance;
        let pdf = area_pdf(self.area[light.index], -direction.dot(light.point.normal), distance);
        if pdf > 0.0 {
            LightPoint { point: light.point, direction, pdf }.seen_from(to, light.emission)
        } else {
            None
        }
    }

    /// Whether light number `index` is as good to sample with the same `u` for all receivers: a point, a flat light or a
    /// sphere, whose visible cap turns along; a cuboid may show another side.
    pub fn shows_one_side(&self, index: usize) -> bool {
        match self.scene.lights[index] {
            Light::Point { .. } | Light::Panel { .. } => true,
            Light::Shape { shape } => match self.scene.shapes[shape as usize].kind {
                ShapeKind::Triangle | ShapeKind::Quad | ShapeKind::Sphere => true,
                ShapeKind::Cuboid | ShapeKind::Torus => false,
            },
        }
    }

    /// The PDF by solid angle with which [`LightTable::sample`] would have drawn the point of an emitter that a ray of unit
    /// `direction` from `from` hit at `distance`; 0 for one that it never draws.
    pub fn pdf_of_hit(&self, from: Vec3, direction: Vec3, distance: f32, hit: &Surface) -> f32 {
        let Ok(found) = self.shape_lights.binary_search_by_key(&hit.shape, |(shape, _)| *shape) else {
            return 0.0;
        };
        let light = self.shape_lights[found].1 as usize;
        let pdf = match self.scene.shape(hit.shape) {
            Shape::Sphere(sphere) => cone(&sphere, from).map_or(0.0, |c| c.pdf),
            _ => area_pdf(self.area[light], -direction.dot(hit.geometric_normal), distance),
        };
        self.probability[light] * pdf
    }

    /// The PDF by solid angle with which [`LightTable::sample`] draws a direction of the sky at cosine `cosine` against the
    /// receiver.
    #[inline]
    pub fn pdf_of_sky(&self, cosine: f32) -> f32 {
        self.sky_probability * cosine / PI
    }

    /// The light on whose share of the power `pick` in `[0, 1)` falls.
    fn light_at(&self, pick: f64) -> Option<usize> {
        let index = self.cumulative.partition_point(|sum| *sum <= pick);
        // Past the end: no light has any power (rounding cannot, as the last sum is exactly 1).
        (index < self.cumulative.len()).then_some(index)
    }

    /// The shape of a light that is no point.
    #[inline]
    fn shape(&self, index: usize) -> Shape {
        match self.scene.lights[index] {
            Light::Panel { quad, .. } => Shape::Quad(quad),
            Light::Shape { shape } => self.scene.shape(shape),
            Light::Point { .. } => unreachable!("a point light has no shape"),
        }
    }

    /// What a light that is no point sends out; `None` for a shape that is no emitter.
    #[inline]
    fn emission(&self, index: usize) -> Option<Emission> {
        match self.scene.lights[index] {
            Light::Panel { radiance, .. } => Some(Emission { radiance, can_be_hit: false }),
            Light::Shape { shape } => {
                Some(Emission { radiance: emitted(self.scene, shape)?, can_be_hit: true })
            }
            Light::Point { .. } => None,
        }
    }

    #[inline]
    fn area_point(&self, index: usize, shape: &Shape, u: Vec2) -> Option<AreaPoint> {
        Some(AreaPoint { index, point: shape.sample(u), emission: self.emission(index)? })
    }

    fn sample_sky(&self, to: &Surface, frame: &ShadingFrame, u: Vec2) -> Option<LightSample> {
        let direction = cosine_weighted(frame.normal, u);
        let pdf = frame.cosine(direction) / PI;
        (pdf > 0.0).then(|| LightSample {
            direction,
            radiance: self.scene.sky.radiance,
            pdf,
            can_be_hit: true,
            shadow_ray: Ray::new(to.ray_origin(direction), direction),
        })
    }
}

impl LightSample {
    fn picked(self, probability: f32) -> Self {
        Self { pdf: self.pdf * probability, ..self }
    }
}

impl LightPoint {
    #[inline(always)]
    fn seen_from(self, to: &Surface, emission: Emission) -> Option<LightSample> {
        let Self { point, direction, pdf } = self;
        let Emission { radiance, can_be_hit } = emission;
        let shadow_ray = point.ray_from(to.ray_origin(direction));
        pdf.is_finite().then_some(LightSample { direction, radiance, pdf, can_be_hit, shadow_ray })
    }
}

/// Whether a colour sends out any light; NaN does not.
fn has_light(radiance: Vec3) -> bool {
    radiance.max_element() > 0.0 && radiance.is_finite()
}

/// The radiance of a shape, if it is an emitter.
#[inline]
fn emitted(scene: &Scene, shape: u32) -> Option<Vec3> {
    match scene.material(shape).kind {
        MaterialKind::Emissive { radiance } => Some(radiance),
        MaterialKind::Diffuse { .. } | MaterialKind::Mirror | MaterialKind::Glass { .. } => None,
    }
}

fn light_area(scene: &Scene, light: &Light) -> f32 {
    match light {
        Light::Point { .. } => 0.0,
        Light::Panel { quad, .. } => quad.area(),
        Light::Shape { shape } => scene.shape(*shape).area(),
    }
}

/// Emitted power in watts, as the mean of the three channels. Not finite or negative: none.
fn light_power(scene: &Scene, light: &Light, area: f32) -> f64 {
    use std::f64::consts::PI;
    let mean = |c: Vec3| f64::from(c.x + c.y + c.z) / 3.0;
    let power = match light {
        Light::Point { intensity, .. } => 4.0 * PI * mean(*intensity),
        Light::Panel { radiance, .. } => PI * f64::from(area) * mean(*radiance),
        Light::Shape { shape } => PI * f64::from(area) * emitted(scene, *shape).map_or(0.0, mean),
    };
    if power.is_finite() { power.max(0.0) } else { 0.0 }
}

fn sample_point(position: Vec3, intensity: Vec3, to: &Surface) -> Option<LightSample> {
    let way = position - to.position;
    let distance2 = way.length_squared();
    let direction = way.try_normalize()?;
    let origin = to.ray_origin(direction);
    let shadow_ray = Ray { origin, direction: position - origin, t_min: 0.0, t_max: 1.0 };
    let radiance = intensity / distance2;
    Some(LightSample { direction, radiance, pdf: 1.0, can_be_hit: false, shadow_ray })
}

/// The PDF by solid angle of a point drawn uniformly from `area`, seen at `cosine` against its normal; 0 from behind.
fn area_pdf(area: f32, cosine: f32, distance: f32) -> f32 {
    if cosine > 0.0 && area > 0.0 { distance * distance / (cosine * area) } else { 0.0 }
}

/// The cone that a sphere fills.
struct Cone {
    /// From the receiver to the centre.
    way: Vec3,
    /// 1 - cosine of half the opening angle.
    one_minus_cos: f32,
    pdf: f32,
}

/// `None` from inside.
fn cone(sphere: &Sphere, from: Vec3) -> Option<Cone> {
    let way = sphere.center - from;
    let sin2 = sphere.radius * sphere.radius / way.length_squared();
    // Not 1 - sqrt(1 - sin2), which cancels for small or far spheres.
    let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
    (sin2 < 1.0).then(|| Cone { way, one_minus_cos, pdf: 1.0 / (TAU * one_minus_cos) })
}

/// A point of the visible cap, uniform in the cone.
fn cone_point(sphere: &Sphere, from: Vec3, u: Vec2) -> Option<LightPoint> {
    let cone = cone(sphere, from)?;
    let distance = cone.way.length();
    let disk = concentric_disk(u);
    // As uniform in the cone as the point is in the disk: both areas grow with the squared radius.
    let one_minus_cos = disk.length_squared().min(1.0) * cone.one_minus_cos;
    let cos = 1.0 - one_minus_cos;
    let sin2 = one_minus_cos * (2.0 - one_minus_cos);
    // Where that ray enters the sphere.
    let half_chord2 = sphere.radius * sphere.radius - distance * distance * sin2;
    let t = distance * cos - half_chord2.max(0.0).sqrt();
    let across = disk.normalize_or_zero();
    let axis = cone.way / distance;
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    let direction = sin2.sqrt() * (across.x * tangent + across.y * bitangent) + cos * axis;
    let normal = (t * direction - cone.way).try_normalize()?;
    let position = sphere.center + sphere.radius * normal;
    // Centre, product and sum are each rounded once, and the unit normal four times.
    let error = (sphere.center.abs() + Vec3::splat(6.0 * sphere.radius)) * f32::EPSILON;
    let point = SurfaceSample { position, error, normal, uv: Vec2::ZERO };
    let direction = (position - from).try_normalize()?;
    Some(LightPoint { point, direction, pdf: cone.pdf })
}

/// A uniform point of the unit disk; the centre of the square maps to that of the disk, and neighbours stay neighbours
/// (Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997).
fn concentric_disk(u: Vec2) -> Vec2 {
    let p = 2.0 * u - 1.0;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    radius * Vec2::from_angle(angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sky;

    #[test]
    fn the_disk_is_filled_evenly_from_its_centre() {
        assert_eq!(concentric_disk(Vec2::splat(0.5)), Vec2::ZERO);
        const N: usize = 400;
        let mut rings = [0usize; 10];
        let mut sum = Vec2::ZERO;
        for i in 0..N * N {
            let p = concentric_disk((Vec2::new((i % N) as f32, (i / N) as f32) + 0.5) / N as f32);
            rings[((p.length_squared() * 10.0) as usize).min(9)] += 1;
            sum += p;
        }
        // Rings of equal area, off by the square's points on a ring at most.
        assert!(rings.iter().all(|r| r.abs_diff(N * N / 10) < 4 * N), "{rings:?}");
        assert!(sum.length() < 1.0);
    }

    #[test]
    fn the_cone_of_a_tiny_far_sphere_has_its_solid_angle() {
        let sphere = Sphere { center: Vec3::Z * 1000.0, radius: 0.01 };
        let cone = cone(&sphere, Vec3::ZERO).expect("seen from outside");
        let solid_angle = std::f64::consts::PI * 1e-10;
        assert!((f64::from(cone.pdf) * solid_angle - 1.0).abs() < 1e-4);
        assert!(self::cone(&sphere, sphere.center).is_none());
    }

    #[test]
    fn points_of_a_cone_lie_on_the_side_of_the_sphere_that_is_seen() {
        let sphere = Sphere { center: Vec3::new(3.0, -1.0, 2.0), radius: 1.5 };
        let from = Vec3::new(-0.5, 0.3, 0.2);
        for i in 0..100 {
            let u = Vec2::new((i % 10) as f32 + 0.5, (i / 10) as f32 + 0.5) / 10.0;
            let light = cone_point(&sphere, from, u).expect("seen from outside");
            assert!((light.point.position.distance(sphere.center) - 1.5).abs() < 1e-5);
            assert!(light.point.normal.dot(from - light.point.position) >= 0.0);
        }
        let middle = cone_point(&sphere, from, Vec2::splat(0.5)).expect("seen from outside").point;
        assert!(middle.normal.dot((from - sphere.center).normalize()) > 0.9999);
    }

    #[test]
    fn lights_are_picked_by_their_power_and_dark_ones_never() {
        let point = |intensity| Light::Point { position: Vec3::ZERO, intensity: Vec3::splat(intensity) };
        let scene = Scene {
            lights: vec![point(0.0), point(1.0), point(f32::NAN), point(3.0), point(-1.0)],
            ..Scene::default()
        };
        let table = LightTable::new(&scene);
        assert_eq!(table.probability, [0.0, 0.25, 0.0, 0.75, 0.0]);
        assert_eq!((table.light_at(0.0), table.light_at(0.2499)), (Some(1), Some(1)));
        assert_eq!((table.light_at(0.25), table.light_at(0.999_999_9)), (Some(3), Some(3)));
    }

    #[test]
    fn the_sky_is_picked_alone_or_beside_lights_and_a_dark_scene_picks_nothing() {
        let sky = Sky { radiance: Vec3::ONE };
        let light = Light::Point { position: Vec3::ZERO, intensity: Vec3::ONE };
        let table = |lights: Vec<Light>, sky: Sky| {
            let scene = Scene { lights, sky, ..Scene::default() };
            let table = LightTable::new(&scene);
            (table.sky_probability, table.probability.clone(), table.light_at(0.5))
        };
        assert_eq!(table(vec![], sky), (1.0, vec![], None));
        assert_eq!(table(vec![light], sky), (0.25, vec![0.75], Some(0)));
        assert_eq!(table(vec![light], Sky::default()), (0.0, vec![1.0], Some(0)));
        let dark = Light::Point { position: Vec3::ZERO, intensity: Vec3::ZERO };
        assert_eq!(table(vec![dark], Sky::default()), (0.0, vec![0.0], None));
    }
}
