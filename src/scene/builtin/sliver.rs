//! Long thin triangles along the diagonals of a cube: their boxes are large and nearly empty, whatever a builder does.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::random_direction;
use super::soup::light_cube;
use crate::geometry::Aabb;
use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Mesh, Scene, UpAxis};

/// More of them would show no more, and trace for minutes.
const COUNT: usize = 3000;
const SEED: u64 = 0x51_17_3B;
const WIDTH: f32 = 0.014;
/// The four diagonals of a cube, each with its colour.
const DIAGONALS: [(Vec3, Vec3); 4] = [
    (Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.86, 0.62, 0.26)),
    (Vec3::new(-1.0, 1.0, 1.0), Vec3::new(0.80, 0.34, 0.20)),
    (Vec3::new(1.0, 1.0, -1.0), Vec3::new(0.26, 0.46, 0.50)),
    (Vec3::new(-1.0, 1.0, -1.0), Vec3::new(0.74, 0.72, 0.66)),
];

pub(super) fn make() -> Scene {
    let mut random = Pcg32::seed_from_u64(SEED);
    let mut positions = Vec::with_capacity(COUNT * 3);
    let mut materials = Vec::with_capacity(COUNT);
    for _ in 0..COUNT {
        let diagonal = random.random_range(0..DIAGONALS.len());
        let direction = DIAGONALS[diagonal].0.normalize() + 0.05 * random_direction(&mut random);
        let half = direction * random.random_range(0.35..0.75);
        let center = Vec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0))) * 0.55;
        let aside = half.cross(random_direction(&mut random)).normalize_or(Vec3::X) * WIDTH;
        positions.extend([center - half - aside, center - half + aside, center + half]);
        materials.push(diagonal as u32);
    }
    let triangles: Vec<[u32; 3]> = (0..COUNT as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();

    let mut scene = Assembly::new("sliver");
    for (i, (_, color)) in DIAGONALS.into_iter().enumerate() {
        scene.matt(&format!("diagonal {}", i + 1), color);
    }
    scene.whole_mesh(Mesh::flat(positions, &triangles), materials);
    light_cube(&mut scene);
    scene.finish(Camera::framing(&Aabb::new(Vec3::splat(-0.8), Vec3::splat(0.8)), UpAxis::Y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slivers_fill_almost_nothing_of_their_boxes() {
        let scene = make();
        assert_eq!(scene.shape_count(), COUNT);
        for i in 0..COUNT as u32 {
            let v = scene.triangle(i).v;
            let area = (v[1] - v[0]).cross(v[2] - v[0]).length() / 2.0;
            let box_area = Aabb::from_points(v).area();
            assert!(area < 0.02 * box_area, "sliver {i} is {area} of {box_area}");
        }
    }
}
