//! The Utah teapot on a plane.

use glam::Vec3;

use super::asset;
use super::curved::curved;
use crate::geometry::Aabb;
use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Color, Light, Mesh, Scene, UpAxis};

const HEIGHT: f32 = 1.5;
/// Pieces of each edge of the coarse mesh of 992 triangles.
const SEGMENTS: u32 = 3;

pub(super) fn make() -> Scene {
    let mut scene = Assembly::new("teapot");
    let china = scene.surface("china", Color::Solid(Vec3::new(0.14, 0.38, 0.44)), 0.08);
    scene.mesh(mesh(), china);
    let table = scene.matt("table", Vec3::new(0.60, 0.49, 0.38));
    // A hair below, so that the flat foot does not lie in it.
    scene.plane(Vec3::Y, -0.002, table);
    scene.light(Light::panel(Vec3::new(-1.8, 4.2, 1.6), Vec3::Y * 0.5, 2.2, Vec3::new(16.0, 14.6, 12.6)));
    scene.sky(Vec3::new(0.30, 0.36, 0.44));
    scene.finish(Camera {
        eye: Vec3::new(1.2, 2.5, 4.2),
        target: Vec3::new(0.05, 0.68, 0.0),
        fov_y_degrees: 36.0,
        up: UpAxis::Y,
    })
}

/// The teapot, standing on y = 0.
fn mesh() -> Mesh {
    let mut coarse = asset::welded(&asset::read(include_bytes!("../../../assets/teapot.ply")));
    coarse.compute_smooth_normals();
    let mut mesh = curved(&coarse, SEGMENTS);
    let bounds = Aabb::from_points(mesh.positions.iter().copied());
    let foot = bounds.center().with_y(bounds.min.y);
    let scale = HEIGHT / bounds.extent().y;
    for p in &mut mesh.positions {
        *p = (*p - foot) * scale;
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_teapot_stands_on_its_table() {
        assert_eq!(mesh().triangles.len(), 992 * 9);
        let bounds = Aabb::from_points(mesh().positions.iter().copied());
        assert!(bounds.min.y.abs() < 1e-6 && (bounds.max.y - HEIGHT).abs() < 1e-5);
    }
}
