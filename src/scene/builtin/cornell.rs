//! The Cornell box, after the measured data of Cornell University's Program of Computer Graphics; a unit is a metre.

use glam::{Quat, Vec3};

use crate::geometry::Rigid;
use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Scene, UpAxis};

const SIZE: Vec3 = Vec3::new(5.56, 5.488, 5.592);

pub(super) fn make() -> Scene {
    let mut scene = Assembly::new("cornell");
    let white = scene.matt("white", Vec3::new(0.73, 0.71, 0.68));
    let red = scene.matt("red", Vec3::new(0.57, 0.04, 0.044));
    let green = scene.matt("green", Vec3::new(0.11, 0.41, 0.09));
    let lamp = scene.emissive("light", Vec3::new(47.0, 36.0, 21.0));

    // The measured corners are those of right prisms, turned about the vertical.
    let block = |middle: Vec3, degrees: f32| Rigid::new(Quat::from_rotation_y(degrees.to_radians()), middle);
    let short = Vec3::new(0.825, 0.825, 0.825);
    scene.cuboid(block(Vec3::new(1.855, short.y + 0.001, 1.69), 16.6), short, white);
    let tall = Vec3::new(0.825, 1.65, 0.825);
    scene.cuboid(block(Vec3::new(3.685, tall.y + 0.001, 3.515), -17.0), tall, white);

    let (x, y, z) = (Vec3::X * SIZE.x, Vec3::Y * SIZE.y, Vec3::Z * SIZE.z);
    scene.quad(Vec3::ZERO, z, x, white);
    scene.quad(y, x, z, white);
    scene.quad(z, y, x, white);
    // Looking along +z, the larger x is on the left.
    scene.quad(x, z, y, red);
    scene.quad(Vec3::ZERO, y, z, green);
    scene.quad(Vec3::new(2.13, SIZE.y - 0.002, 2.27), Vec3::X * 1.3, Vec3::Z * 1.05, lamp);

    scene.finish(Camera {
        eye: Vec3::new(2.78, 2.73, -8.0),
        target: Vec3::new(2.78, 2.73, 0.0),
        fov_y_degrees: 39.3,
        up: UpAxis::Y,
    })
}
