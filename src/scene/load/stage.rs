//! What the program adds to an opened file: a camera, a light that is no shape, a sky. Outside every tree and figure.

use glam::Vec3;

use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Light, Scene, UpAxis};

/// A sky that keeps shadows readable.
const SKY: Vec3 = Vec3::new(0.20, 0.22, 0.25);
/// The sky over a model that has lamps of its own.
const FAINT_SKY: Vec3 = Vec3::new(0.02, 0.022, 0.026);
/// Sized so that a matt grey surface at the model's middle is about middle grey.
const LIGHT: Vec3 = Vec3::new(5.6, 5.3, 4.9);

/// The scene, framed by its camera. Unless it has lamps of its own, it is lit from above, the front and the left.
pub(super) fn finish(assembly: Assembly, up: UpAxis) -> Scene {
    let mut scene = assembly.finish(Camera::default());
    let bounds = scene.bounds();
    scene.camera = Camera::framing(&bounds, up);
    if !scene.lights.is_empty() {
        scene.sky.radiance = FAINT_SKY;
        return scene;
    }
    scene.sky.radiance = SKY;
    let center = bounds.center();
    // A point, too, is lit from somewhere.
    let radius = (bounds.extent().length() * 0.5).max(center.length() * 1e-4).max(1e-12);
    let front = up.front().as_vec3();
    let side = front.cross(up.vector());
    let towards_light = (up.vector() * 1.5 - front * 0.9 - side * 0.7).normalize();
    scene.lights.push(Light::panel(center + towards_light * radius * 2.4, center, radius * 1.6, LIGHT));
    scene
}
