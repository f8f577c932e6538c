//! The scenes that the program carries, by name: one file each.

mod asset;
mod bunny;
mod cornell;
mod curved;
mod room;
mod sliver;
mod soup;
mod spheres;
mod teapot;

use std::f32::consts::TAU;

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg32;

use super::Scene;
use super::load::LoadError;
use crate::task::Task;

/// Names with a line on each, as `bvhscope list scenes` prints them.
pub const SCENES: [(&str, &str); 7] = [
    (
        "bunny",
        "the default: a bunny of 4,968 triangles in a room of quads, with a glass cuboid and a mirror sphere",
    ),
    ("room", "the classic teaching room: six planes, a mirror ball, a glass cube, a swinging light"),
    ("cornell", "the Cornell box"),
    ("spheres", "thousands of random spheres"),
    ("soup", "random triangles; soup:1000000 sets how many"),
    ("teapot", "the Utah teapot"),
    ("sliver", "long thin diagonal triangles, the classic enemy of box trees"),
];

/// Whether `text` names a built-in scene, with or without a parameter.
pub fn is_name(text: &str) -> bool {
    let name = text.split(':').next().unwrap_or(text);
    SCENES.iter().any(|(n, _)| *n == name)
}

/// Makes a built-in scene at t = 0.
///
/// # Errors
/// For an unknown name, or a parameter that is not a number in range.
pub fn make(name: &str) -> Result<Scene, LoadError> {
    make_with(name, &Task::new())
}

/// [`make`], which can be cancelled.
///
/// # Errors
/// Also [`LoadError::Cancelled`] when the task was.
pub fn make_with(text: &str, task: &Task) -> Result<Scene, LoadError> {
    let (name, parameter) = match text.split_once(':') {
        Some((name, parameter)) => (name, Some(parameter)),
        None => (text, None),
    };
    if name == "soup" {
        return soup::make(text, soup::count(parameter)?, task);
    }
    let scene = match name {
        "bunny" => bunny::make(),
        "room" => room::make(),
        "cornell" => cornell::make(),
        "spheres" => spheres::make(),
        "teapot" => teapot::make(),
        "sliver" => sliver::make(),
        _ => {
            let choices = SCENES.map(|(name, _)| name).join(", ");
            return Err(LoadError::UnknownScene { name: text.to_owned(), choices });
        }
    };
    match parameter {
        None => Ok(scene),
        Some(_) => Err(LoadError::Parameter {
            scene: name.to_owned(),
            value: text.to_owned(),
            reason: format!("this scene takes no parameter; write just '{name}'"),
        }),
    }
}

/// A direction, uniform over the sphere.
fn random_direction(random: &mut Pcg32) -> Vec3 {
    let z = random.random_range(-1.0..1.0_f32);
    let angle = random.random_range(0.0..TAU);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;
    use crate::scene::{Light, MaterialKind};

    #[test]
    fn every_scene_is_sound() {
        for (name, line) in SCENES {
            assert!(!line.is_empty() && is_name(name));
            let scene = make(name).expect("a built-in scene");
            assert_eq!(scene.name, name);
            assert_eq!(scene.shapes.len(), scene.shape_materials.len(), "{name}");
            assert!(scene.shape_count() > 0, "{name}");
            assert!(scene.shape_materials.iter().all(|m| (*m as usize) < scene.materials.len()), "{name}");
            assert!(!scene.lights.is_empty(), "{name} is dark");
            for light in &scene.lights {
                let Light::Shape { shape } = light else { continue };
                assert!(matches!(scene.material(*shape).kind, MaterialKind::Emissive { .. }), "{name}");
            }
            for triangle in &scene.mesh.triangles {
                assert!(
                    triangle.position.iter().all(|i| (*i as usize) < scene.mesh.positions.len()),
                    "{name}"
                );
                let normals = triangle.normal.iter().filter(|i| **i != u32::MAX);
                assert!(normals.clone().all(|i| (*i as usize) < scene.mesh.normals.len()), "{name}");
            }
            let frame = scene.camera.frame(1280, 720);
            assert!(frame.eye.is_finite() && frame.forward.is_normalized(), "{name}");
        }
    }

    #[test]
    fn the_same_name_makes_the_same_scene() {
        for name in ["bunny", "spheres", "soup:1000", "sliver"] {
            let (a, b) = (make(name).expect("a scene"), make(name).expect("a scene"));
            assert_eq!(a.mesh.positions, b.mesh.positions, "{name}");
            assert_eq!((a.spheres, a.shape_materials), (b.spheres, b.shape_materials), "{name}");
        }
    }

    #[test]
    fn soup_has_as_many_triangles_as_asked_for_at_any_thread_count() {
        for (text, count) in [("soup", soup::DEFAULT_COUNT), ("soup:1", 1), ("soup:12345", 12345)] {
            assert_eq!(make(text).expect("a scene").shape_count(), count);
        }
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        let alone = one.install(|| make("soup:9000").expect("a scene"));
        let many = make("soup:9000").expect("a scene");
        assert_eq!(alone.mesh.positions, many.mesh.positions);
        let fewer = make("soup:100").expect("a scene");
        assert!(matches!(fewer.shape(99), Shape::Triangle(_)));
    }

    #[test]
    fn what_cannot_be_made_is_said() {
        for (name, part) in [
            ("dragon", "bunny, room"),
            ("", "no built-in scene"),
            ("bunny:4", "takes no parameter"),
            ("soup:", "from 1 to 20000000"),
            ("soup:0", "from 1 to 20000000"),
            ("soup:20000001", "from 1 to 20000000"),
            ("soup:-3", "from 1 to 20000000"),
            ("soup:9e9", "from 1 to 20000000"),
        ] {
            let message = make(name).expect_err("an error").to_string();
            assert!(message.contains(part) && !message.contains('\n'), "{name}: {message}");
        }
        let task = Task::new();
        task.cancel();
        assert!(matches!(make_with("soup:100000", &task), Err(LoadError::Cancelled)));
    }
}
