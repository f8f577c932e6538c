//! A few thousand spheres of all materials and sizes on a wide ground, under a sky.

use std::f32::consts::TAU;

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Color, Light, Scene, UpAxis};

const COUNT: usize = 3000;
const SEED: u64 = 0x5F_E3_E5;
/// The spheres lie within this distance of the origin.
const FIELD_RADIUS: f32 = 14.0;
const GROUND_HALF: f32 = 24.0;
/// Side of a cell of the grid that keeps the spheres apart; at least the largest small sphere's diameter.
const CELL: f32 = 0.6;
const GRID: usize = (2.0 * FIELD_RADIUS / CELL) as usize + 3;

/// The large ones in the middle: place, radius.
const HEROES: [(f32, f32, f32); 3] = [(-1.9, -0.6, 1.0), (0.25, 0.35, 1.15), (2.5, 0.0, 0.9)];

pub(super) fn make() -> Scene {
    let mut random = Pcg32::seed_from_u64(SEED);
    let mut scene = Assembly::new("spheres");
    let ground = Color::Checker {
        even: Vec3::new(0.50, 0.48, 0.44),
        odd: Vec3::new(0.36, 0.35, 0.33),
        size: 1.0 / 48.0,
        fine: Vec::new(),
    };
    let ground = scene.surface("ground", ground, 0.08);
    let side = 2.0 * GROUND_HALF;
    scene.quad(Vec3::new(-GROUND_HALF, 0.0, -GROUND_HALF), Vec3::Z * side, Vec3::X * side, ground);

    let materials = materials(&mut scene);
    let gold = scene.mirror("gold", Vec3::new(0.94, 0.72, 0.38));
    let heroes = [gold, materials[1], materials[4]];
    for ((x, z, radius), material) in HEROES.into_iter().zip(heroes) {
        scene.sphere(Vec3::new(x, radius, z), radius, material);
    }
    for (center, radius) in scatter(COUNT - HEROES.len(), &mut random) {
        let choice = random.random_range(0.0..1.0_f32);
        // Mirrors and glass are as common as any one colour; lamps are rare.
        let material = if choice < 0.012 {
            materials[2 + random.random_range(0..2)]
        } else {
            let others = [0, 1].into_iter().chain(4..materials.len()).collect::<Vec<_>>();
            materials[others[random.random_range(0..others.len())]]
        };
        scene.sphere(center, radius, material);
    }

    scene.sky(Vec3::new(0.30, 0.42, 0.62));
    let sun = Vec3::new(25.0, 22.0, 17.5);
    scene.light(Light::panel(Vec3::new(-8.0, 12.0, 5.0), Vec3::ZERO, 5.5, sun));
    scene.finish(Camera {
        eye: Vec3::new(0.6, 2.1, 7.6),
        target: Vec3::new(0.25, 0.75, 0.0),
        fov_y_degrees: 36.0,
        up: UpAxis::Y,
    })
}

/// Mirror, glass, two lamps, then colours.
fn materials(scene: &mut Assembly) -> Vec<u32> {
    let mut materials = vec![
        scene.mirror("mirror", Vec3::splat(0.94)),
        scene.glass("glass", Vec3::splat(0.05)),
        scene.emissive("warm lamp", Vec3::new(9.0, 5.4, 2.2)),
        scene.emissive("cool lamp", Vec3::new(2.6, 5.0, 8.0)),
    ];
    let colors = [
        ("terracotta", Vec3::new(0.72, 0.27, 0.15), 0.06),
        ("ochre", Vec3::new(0.82, 0.58, 0.18), 0.0),
        ("ivory", Vec3::new(0.82, 0.78, 0.70), 0.0),
        ("moss", Vec3::new(0.28, 0.42, 0.18), 0.0),
        ("petrol", Vec3::new(0.10, 0.32, 0.38), 0.1),
        ("slate", Vec3::new(0.22, 0.25, 0.32), 0.2),
        ("brass", Vec3::new(0.78, 0.60, 0.30), 0.6),
        ("plum", Vec3::new(0.42, 0.14, 0.26), 0.0),
    ];
    for (name, color, reflectivity) in colors {
        materials.push(scene.surface(name, Color::Solid(color), reflectivity));
    }
    materials
}

/// Spheres that rest on the ground and do not touch, denser and smaller ones in between: each is tried at a random place
/// and kept if it is free.
fn scatter(count: usize, random: &mut Pcg32) -> Vec<(Vec3, f32)> {
    let mut spheres: Vec<(Vec3, f32)> = Vec::with_capacity(count);
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); GRID * GRID];
    let cell = |value: f32| ((value + FIELD_RADIUS) / CELL) as usize + 1;
    while spheres.len() < count {
        let (distance, angle) = (random.random_range(0.0_f32..1.0).powf(0.62), random.random_range(0.0..TAU));
        let radius = 0.07 + 0.21 * random.random_range(0.0_f32..1.0).powi(2);
        let place = Vec3::new(angle.cos(), 0.0, angle.sin()) * distance * FIELD_RADIUS;
        let center = place.with_y(radius);
        let (cx, cz) = (cell(center.x), cell(center.z));
        let near = (cz - 1..=cz + 1).flat_map(|z| (cx - 1..=cx + 1).map(move |x| z * GRID + x));
        let free = |other: Vec3, other_radius: f32| center.distance(other) > radius + other_radius + 0.004;
        if near.flat_map(|c| &cells[c]).all(|i| free(spheres[*i].0, spheres[*i].1))
            && HEROES.into_iter().all(|(x, z, r)| free(Vec3::new(x, r, z), r))
        {
            cells[cz * GRID + cx].push(spheres.len());
            spheres.push((center, radius));
        }
    }
    spheres
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_rest_on_the_ground_and_do_not_touch() {
        let scene = make();
        assert_eq!(scene.spheres.len(), COUNT);
        for (i, a) in scene.spheres.iter().enumerate() {
            assert!((a.center.y - a.radius).abs() < 1e-6);
            for b in &scene.spheres[..i] {
                assert!(a.center.distance(b.center) > a.radius + b.radius, "{a:?} touches {b:?}");
            }
        }
        let kinds: std::collections::HashSet<_> = scene.shape_materials.iter().collect();
        assert!(kinds.len() >= 12, "all materials appear");
    }
}
