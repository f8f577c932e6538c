//! What holds for every shape, checked on random rays and boxes; each shape's own tests call these.

use glam::{Quat, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::*;

pub fn rng(seed: u64) -> Pcg32 {
    Pcg32::seed_from_u64(seed)
}

pub fn random_vec(rng: &mut Pcg32, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

pub fn random_direction(rng: &mut Pcg32) -> Vec3 {
    loop {
        let v = random_vec(rng, 1.0);
        if v.length() > 0.1 && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

pub fn random_placement(rng: &mut Pcg32) -> Rigid {
    let rotation = Quat::from_axis_angle(random_direction(rng), rng.random_range(0.0..6.0));
    Rigid::new(rotation, random_vec(rng, 3.0))
}

pub fn unit_square(rng: &mut Pcg32) -> Vec2 {
    Vec2::new(rng.random(), rng.random())
}

pub fn hit(shape: &Shape, origin: Vec3, direction: Vec3) -> Option<ShapeHit> {
    shape.intersect(&PreparedRay::new(Ray::new(origin, direction)))
}

/// Everything below. `closed`: whether the surface has an inside.
pub fn check_shape(shape: &Shape, closed: bool) {
    let rng = &mut rng(7);
    samples_lie_on_the_surface(shape, rng);
    rays_at_samples_hit(shape, rng);
    hits_respect_their_interval(shape, rng);
    rays_that_leave_do_not_come_back_at_once(shape, closed, rng);
    samples_are_seen_from_afar(shape, rng);
    parts_in_boxes_agree_with_samples(shape, rng);
}

fn size(shape: &Shape) -> f32 {
    shape.bounds().extent().max_element()
}

fn samples_lie_on_the_surface(shape: &Shape, rng: &mut Pcg32) {
    let bounds = shape.bounds();
    for _ in 0..200 {
        let s = shape.sample(unit_square(rng));
        assert!((s.normal.length() - 1.0).abs() < 1e-6, "{shape:?} {s:?}");
        assert!(s.error.cmpgt(Vec3::ZERO).all() && s.error.max_element() < 1e-5, "{shape:?} {s:?}");
        let slack = Aabb { min: bounds.min - s.error, max: bounds.max + s.error };
        assert!(slack.contains_point(s.position), "{shape:?} {s:?}");
        // A short ray through the point along its normal finds the point.
        let step = 0.01 * size(shape);
        let found = hit(shape, s.position + s.normal * step, -s.normal).expect("the point is on the surface");
        assert!((found.t - step).abs() < 1e-4 * size(shape), "{shape:?} {s:?} {found:?}");
    }
}

fn rays_at_samples_hit(shape: &Shape, rng: &mut Pcg32) {
    for _ in 0..500 {
        let target = shape.sample(unit_square(rng));
        let origin = shape.bounds().center() + random_direction(rng) * 3.0 * size(shape);
        let direction = target.position - origin;
        if direction.normalize().dot(target.normal).abs() < 0.01 {
            continue;
        }
        let ray = Ray::new(origin, direction);
        let found = shape.intersect(&PreparedRay::new(ray)).expect("aimed at the surface");
        assert!(found.t <= 1.0 + 1e-4, "{shape:?} {ray:?} {found:?}");
        let surface = shape.surface(&ray, &found);
        let off = (surface.position - ray.at(found.t)).length();
        assert!(off < 1e-4 * size(shape), "{shape:?} {ray:?} {found:?} {surface:?} {off}");
        assert!((surface.normal.length() - 1.0).abs() < 1e-6);
        if found.t > 1.0 - 1e-6 {
            let turned = surface.normal.dot(target.normal);
            assert!(turned > 0.95, "{shape:?} {found:?} {surface:?} {target:?}");
        }
    }
}

fn hits_respect_their_interval(shape: &Shape, rng: &mut Pcg32) {
    for _ in 0..300 {
        let target = shape.sample(unit_square(rng)).position;
        let origin = shape.bounds().center() + random_direction(rng) * 2.0 * size(shape);
        let ray = PreparedRay::new(Ray::new(origin, target - origin));
        let (mut t_min, mut count) = (0.0, 0);
        while let Some(found) = shape.intersect_within(&ray, t_min, f32::MAX) {
            assert!(found.t >= t_min, "{shape:?}");
            assert_eq!(shape.intersect_within(&ray, found.t, found.t), Some(found), "{shape:?} {ray:?}");
            assert_eq!(shape.intersect_within(&ray, t_min, found.t), Some(found), "{shape:?} {ray:?}");
            if t_min < found.t {
                assert_eq!(shape.intersect_within(&ray, t_min, found.t.next_down()), None, "{shape:?}");
            }
            t_min = found.t.next_up();
            count += 1;
            assert!(count <= 4, "{shape:?} {ray:?}");
        }
        assert_eq!(shape.intersect_within(&ray, 0.5, f32::NAN), None);
    }
}

/// From either side of a hit, in any direction: the next hit of a closed shape is seen from the right side, and a flat
/// shape is not hit again at all.
fn rays_that_leave_do_not_come_back_at_once(shape: &Shape, closed: bool, rng: &mut Pcg32) {
    for i in 0..2000 {
        let target = shape.sample(unit_square(rng)).position;
        let origin = shape.bounds().center() + random_direction(rng) * 2.0 * size(shape);
        let ray = Ray::new(origin, target - origin);
        let Some(found) = shape.intersect(&PreparedRay::new(ray)) else { continue };
        let surface = shape.surface(&ray, &found);
        let mut direction = random_direction(rng);
        if i % 2 == 0 {
            // All but along the surface.
            let lift = surface.normal * rng.random_range(-1e-4..1e-4);
            direction = (direction - surface.normal * direction.dot(surface.normal) + lift).normalize();
        }
        let outwards = direction.dot(surface.normal) > 0.0;
        let leaving = Ray::new(surface.leave(direction), direction);
        let next = shape.intersect(&PreparedRay::new(leaving));
        let Some(next) = next else {
            assert!(outwards || !closed, "{shape:?} {leaving:?} escapes from inside");
            continue;
        };
        assert!(closed, "{shape:?} {leaving:?} {next:?} hits its own surface");
        let facing = shape.surface(&leaving, &next).normal.dot(direction);
        let grazing = facing.abs() < 1e-3;
        assert!(grazing || (facing < 0.0) == outwards, "{shape:?} {leaving:?} {next:?} {facing}");
    }
}

/// Two sides that hold each other's light: the ray to a sample ends before the surface it was drawn from.
fn samples_are_seen_from_afar(shape: &Shape, rng: &mut Pcg32) {
    for _ in 0..1000 {
        let sample = shape.sample(unit_square(rng));
        let direction = random_direction(rng);
        let side = sample.normal * direction.dot(sample.normal).signum();
        let origin = sample.position + (direction + side * 0.001) * 0.3 * size(shape);
        let ray = sample.ray_from(origin);
        let Some(found) = shape.intersect(&PreparedRay::new(ray)) else { continue };
        // A curved shape may stand in its own way, never at the very end.
        assert!(found.t < 1.0 - 1e-5, "{shape:?} {sample:?} {ray:?} {found:?}");
    }
}

fn parts_in_boxes_agree_with_samples(shape: &Shape, rng: &mut Pcg32) {
    let bounds = shape.bounds();
    let whole = shape.area();
    assert!((shape.area_inside(&bounds.padded(1.0)) - whole).abs() <= 1e-5 * whole, "{shape:?}");
    let away = Aabb::new(bounds.max + Vec3::ONE, bounds.max + Vec3::splat(2.0));
    assert_eq!((shape.area_inside(&away), shape.clipped_bounds(&away)), (0.0, Aabb::EMPTY), "{shape:?}");
    for _ in 0..10 {
        let corner = |rng: &mut Pcg32| bounds.center() + random_vec(rng, 0.6) * (bounds.extent() + 0.01);
        let clip = Aabb::from_points([corner(rng), corner(rng)]);
        let part = shape.clipped_bounds(&clip);
        assert!(clip.contains(&part) && bounds.contains(&part), "{shape:?} {clip:?} {part:?}");
        let (mut inside, count) = (0, 4000);
        for _ in 0..count {
            let sample = shape.sample(unit_square(rng));
            if clip.contains_point(sample.position) {
                inside += 1;
                let slack = Aabb { min: part.min - sample.error, max: part.max + sample.error };
                assert!(slack.contains_point(sample.position), "{shape:?} {clip:?} {part:?} {sample:?}");
            }
        }
        let expected = inside as f32 / count as f32;
        let share = shape.area_inside(&clip) / whole;
        assert!((share - expected).abs() < 0.04, "{shape:?} {clip:?}: {share} against {expected}");
    }
}
