//! The classic teaching room of `tmpl8rt_2022`: six planes, a mirror ball, a glass cube, a light that swings.
//!
//! The axes here are right-handed, so the picture is the mirror image of the left-handed original.

use std::f32::consts::FRAC_PI_4;

use glam::{Quat, Vec2, Vec3};

use crate::geometry::Rigid;
use crate::scene::assembly::Assembly;
use crate::scene::material::FineTiles;
use crate::scene::{Camera, Color, Motion, Scene, Track, UpAxis};

/// The point that the light hangs from.
const PIVOT: Vec3 = Vec3::new(0.0, 2.6, 2.0);

pub(super) fn make() -> Scene {
    let mut scene = Assembly::new("room");
    let wall = scene.matt("wall", Vec3::splat(0.93));
    let floor = scene.surface("floor", floor_color(), 0.3);
    let mirror = scene.mirror("mirror ball", Vec3::ONE);
    let glass = scene.glass("glass cube", Vec3::ZERO);
    let lamp = scene.emissive("light", Vec3::new(24.0, 24.0, 22.0));

    let middle = PIVOT - Vec3::Y * 0.9;
    let light = scene.quad(middle - Vec3::new(0.5, 0.0, 0.5), Vec3::X, Vec3::Z, lamp);
    let motion = Motion::Swing { pivot: PIVOT, amplitude: 0.1, rate: 0.6 };
    scene.track(Track::Shape { shape: light, motion });

    let ball = scene.sphere(Vec3::new(-1.4, -0.5, 2.0), 0.5, mirror);
    scene.track(Track::Shape { shape: ball, motion: Motion::Bounce { height: 1.0 } });
    // Around the whole room and seen from inside: it rounds the far corners.
    scene.sphere(Vec3::new(0.0, 2.5, -3.07), 8.0, wall);

    let turned = Quat::from_rotation_x(FRAC_PI_4) * Quat::from_rotation_z(FRAC_PI_4);
    let cube = scene.cuboid(Rigid::new(turned, Vec3::new(1.4, 0.0, 2.0)), Vec3::splat(1.15 / 2.0), glass);
    scene.track(Track::Shape { shape: cube, motion: Motion::Turn { axis: Vec3::Y, rate: 0.5 } });

    // Facing inwards, with their distance from the origin.
    for (normal, distance, material) in [
        (Vec3::X, 3.0, wall),
        (Vec3::NEG_X, 2.99, wall),
        (Vec3::Y, 1.0, floor),
        (Vec3::NEG_Y, 2.0, wall),
        (Vec3::Z, 3.0, wall),
        (Vec3::NEG_Z, 3.99, wall),
    ] {
        scene.plane(normal, -distance, material);
    }
    scene.finish(Camera {
        eye: Vec3::new(0.0, 0.0, -2.0),
        target: Vec3::ZERO,
        // Half the height at distance 2 is 1.
        fov_y_degrees: 2.0 * 0.5_f32.atan().to_degrees(),
        up: UpAxis::Y,
    })
}

/// Squares of 0.5 units, with two tiles of a very fine checker for the eyes of filtering tests.
fn floor_color() -> Color {
    let tile = |x: f32, z: f32, size: f32| {
        let min = Vec2::new(x, z);
        FineTiles { min, max: min + 0.5, size }
    };
    Color::Checker {
        even: Vec3::splat(0.3),
        odd: Vec3::ONE,
        size: 0.5,
        fine: vec![tile(1.0, 1.0, 1.0 / 32.0), tile(-1.0, 1.0, 1.0 / 64.0)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ShapeKind;

    #[test]
    fn has_four_bounded_shapes_and_six_planes() {
        let scene = make();
        let kinds: Vec<_> = scene.shapes.iter().map(|s| s.kind).collect();
        assert_eq!(kinds, [ShapeKind::Quad, ShapeKind::Sphere, ShapeKind::Sphere, ShapeKind::Cuboid]);
        assert_eq!(scene.unbounded().count(), 6);
        assert!((scene.camera.fov_y_degrees - 53.13).abs() < 0.01);
        for (_, plane, _) in scene.unbounded() {
            assert!(plane.normal.dot(scene.camera.eye) > plane.offset, "the camera is outside");
        }
    }
}
