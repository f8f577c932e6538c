//! Random triangles in a cube, as many as one asks for.

use std::f32::consts::TAU;

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;

use super::random_direction;
use crate::geometry::Aabb;
use crate::scene::assembly::Assembly;
use crate::scene::load::LoadError;
use crate::scene::{Camera, Light, Mesh, MeshTriangle, Scene, UpAxis};
use crate::task::Task;

pub(super) const DEFAULT_COUNT: usize = 100_000;
const MAX_COUNT: usize = 20_000_000;
/// Triangles that share a random stream, so that the soup is the same at any number of threads.
const CHUNK: usize = 4096;
const SEED: u64 = 0x50_55_70;
const PALETTE: [Vec3; 5] = [
    Vec3::new(0.82, 0.36, 0.20),
    Vec3::new(0.88, 0.66, 0.30),
    Vec3::new(0.76, 0.74, 0.66),
    Vec3::new(0.28, 0.50, 0.52),
    Vec3::new(0.20, 0.30, 0.44),
];

/// How many triangles the text behind `soup:` asks for.
pub(super) fn count(parameter: Option<&str>) -> Result<usize, LoadError> {
    let Some(text) = parameter else { return Ok(DEFAULT_COUNT) };
    match text.parse() {
        Ok(count) if (1..=MAX_COUNT).contains(&count) => Ok(count),
        _ => Err(LoadError::Parameter {
            scene: "soup".to_owned(),
            value: format!("soup:{text}"),
            reason: format!("give the number of triangles, from 1 to {MAX_COUNT}, as in soup:1000000"),
        }),
    }
}

/// A soup of `count` triangles in the cube from -1 to 1. Their area falls as the number grows, so that a ray
/// meets about as many.
pub(super) fn make(name: &str, count: usize, task: &Task) -> Result<Scene, LoadError> {
    let size = (30.0 / count as f32).sqrt().min(0.9);
    let mut positions = vec![Vec3::ZERO; count * 3];
    let mut materials = vec![0; count];
    let chunks = positions.par_chunks_mut(CHUNK * 3).zip(materials.par_chunks_mut(CHUNK)).enumerate();
    chunks.try_for_each(|(chunk, (positions, materials))| {
        task.check().map_err(|_| LoadError::Cancelled)?;
        let mut random = Pcg32::seed_from_u64(SEED.wrapping_add(chunk as u64));
        for (triangle, material) in positions.chunks_exact_mut(3).zip(materials) {
            fill_triangle(triangle, size, &mut random);
            *material = random.random_range(0..PALETTE.len() as u32);
        }
        Ok(())
    })?;
    let triangle = |i: u32| MeshTriangle::flat([3 * i, 3 * i + 1, 3 * i + 2]);
    let triangles = (0..count as u32).into_par_iter().map(triangle).collect();
    task.check().map_err(|_| LoadError::Cancelled)?;

    let mut scene = Assembly::new(name);
    for (i, color) in PALETTE.into_iter().enumerate() {
        scene.matt(&format!("soup {}", i + 1), color);
    }
    scene.whole_mesh(Mesh { positions, triangles, ..Mesh::default() }, materials);
    light_cube(&mut scene);
    Ok(scene.finish(Camera::framing(&Aabb::new(Vec3::splat(-1.0), Vec3::ONE), UpAxis::Y)))
}

/// A triangle around a random point of the cube, about `size` wide, wholly inside.
fn fill_triangle(triangle: &mut [Vec3], size: f32, random: &mut Pcg32) {
    let center = Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
    let (a, b) = random_direction(random).any_orthonormal_pair();
    for (corner, point) in triangle.iter_mut().enumerate() {
        let angle = (corner as f32 + random.random_range(0.0..0.8)) * TAU / 3.0;
        let radius = size * random.random_range(0.4..1.0);
        *point = (center + radius * (angle.cos() * a + angle.sin() * b)).clamp(Vec3::splat(-1.0), Vec3::ONE);
    }
}

/// Light that is no shape, above and in front of the cube from -1 to 1, and a sky.
pub(super) fn light_cube(scene: &mut Assembly) {
    scene.light(Light::panel(Vec3::new(1.2, 3.4, 2.6), Vec3::ZERO, 2.2, Vec3::new(13.0, 12.2, 11.0)));
    scene.sky(Vec3::new(0.17, 0.20, 0.26));
}
