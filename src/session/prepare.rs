//! From a session to what it shows: the scene at its moment, staged, and the camera. The window and the commands open
//! scenes here, so that both show the same.

use std::sync::Arc;

use glam::Vec3;

use super::{Session, SessionScene};
use crate::geometry::Plane;
use crate::scene::{
    Camera, Color, LoadError, Loaded, Material, MaterialKind, Scene, SceneRef, UpAxis, load::load,
};
use crate::task::Task;

/// A scene that was opened.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// As it was loaded: at t = 0, without the ground. [`stage`] makes the scene of another moment from it.
    pub still: Arc<Scene>,
    /// At the session's time, with its ground.
    pub scene: Arc<Scene>,
    /// The session's camera, or the scene's own.
    pub camera: Camera,
    /// What had to be repaired, and whether the scene is another one than the session remembers; a line each.
    pub warnings: Vec<String>,
}

/// Loads the session's scene and fills in what the session remembers of it: content hash and shape count.
///
/// # Errors
/// [`LoadError`]; the session is then as before.
pub fn open(session: &mut Session, task: &Task) -> Result<Prepared, LoadError> {
    let Loaded { scene, mut warnings, content_hash } = load(&session.scene.reference, session.up, task)?;
    let found = SessionScene {
        reference: session.scene.reference.clone(),
        content_hash,
        shape_count: Some(scene.shape_count()),
    };
    warnings.extend(change_warning(&session.scene, &found));
    session.scene = found;
    let still = Arc::new(scene);
    let scene = stage(&still, session);
    let camera = camera(&scene, session);
    Ok(Prepared { still, scene, camera, warnings })
}

/// The scene of the session's moment, with a ground if the session has one. `still` is the scene of t = 0 as loaded.
pub fn stage(still: &Arc<Scene>, session: &Session) -> Arc<Scene> {
    let moves = session.time != still.time && still.is_animated();
    if !moves && !session.ground {
        return Arc::clone(still);
    }
    let mut scene = if moves { still.at(session.time) } else { Scene::clone(still) };
    if session.ground {
        lay_ground(&mut scene, still, session.up);
    }
    Arc::new(scene)
}

/// The session's camera, or the scene's own, with the session's up axis.
pub fn camera(scene: &Scene, session: &Session) -> Camera {
    Camera { up: session.up, ..session.camera.unwrap_or(scene.camera) }
}

/// A checkered ground just below the still scene, so that a floor of its own hides it.
fn lay_ground(scene: &mut Scene, still: &Scene, up: UpAxis) {
    let bounds = still.bounds();
    let size = bounds.extent().length();
    let lowest = if bounds.is_empty() { 0.0 } else { bounds.min.dot(up.vector()) };
    let plane = Plane { normal: up.vector(), offset: lowest - size * 1e-4 };
    let material = Material {
        name: "ground".to_owned(),
        color: Color::Checker {
            even: Vec3::splat(0.5),
            odd: Vec3::splat(0.42),
            size: round_size(size / 12.0),
            fine: Vec::new(),
        },
        kind: MaterialKind::Diffuse { reflectivity: 0.0 },
    };
    let materials = Arc::make_mut(&mut scene.materials);
    materials.push(material);
    scene.ground = Some((plane, materials.len() as u32 - 1));
}

/// The largest 1, 2 or 5 times a power of ten up to `size`; 1 for nothing.
fn round_size(size: f32) -> f32 {
    if !(size > 0.0 && size.is_finite()) {
        return 1.0;
    }
    let power = 10f32.powf(size.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    steps.iter().map(|step| step * power).find(|rounded| *rounded <= size).unwrap_or(power)
}

/// What to say when the scene that was found is not the one that the session was saved with.
fn change_warning(saved: &SessionScene, found: &SessionScene) -> Option<String> {
    let name = saved.reference.text();
    let counts = || match (saved.shape_count, found.shape_count) {
        (Some(before), Some(now)) if before != now => format!(" (it had {before} shapes and has {now})"),
        _ => String::new(),
    };
    let differs = !saved.content_hash.is_empty() && saved.content_hash != found.content_hash;
    match &saved.reference {
        SceneRef::File(_) if differs => Some(format!(
            "{name} has changed since this session was saved{}: pictures and figures will differ",
            counts()
        )),
        SceneRef::Builtin(_) if !counts().is_empty() => Some(format!(
            "this program's scene {name} is not the one of the session{}: pictures will differ",
            counts()
        )),
        SceneRef::File(_) | SceneRef::Builtin(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{ShapeKind, Sphere};
    use crate::scene::ShapeSlot;

    fn ball() -> Arc<Scene> {
        Arc::new(Scene {
            shapes: vec![ShapeSlot { kind: ShapeKind::Sphere, index: 0 }],
            shape_materials: vec![0],
            spheres: vec![Sphere { center: Vec3::new(0.0, 3.0, 5.0), radius: 1.0 }],
            materials: Arc::new(vec![Material {
                name: "matt".to_owned(),
                color: Color::Solid(Vec3::ONE),
                kind: MaterialKind::Diffuse { reflectivity: 0.0 },
            }]),
            ..Scene::default()
        })
    }

    #[test]
    fn a_still_scene_without_ground_is_shared() {
        let still = ball();
        let staged = stage(&still, &Session { time: 3.0, ..Session::default() });
        assert!(Arc::ptr_eq(&still, &staged));
    }

    #[test]
    fn the_ground_lies_below_the_scene_along_the_up_axis_and_adds_no_shape() {
        let still = ball();
        for (up, bottom) in [(UpAxis::Y, 2.0), (UpAxis::Z, 4.0)] {
            let staged = stage(&still, &Session { ground: true, up, ..Session::default() });
            let (plane, material) = staged.ground.expect("a ground");
            assert_eq!(plane.normal, up.vector());
            assert!(plane.offset < bottom && plane.offset > bottom - 0.01, "{plane:?}");
            assert_eq!(staged.materials[material as usize].name, "ground");
            assert_eq!((staged.shape_count(), still.materials.len()), (1, 1));
        }
    }

    #[test]
    fn checker_tiles_have_round_sizes() {
        for (size, expected) in [(0.7, 0.5), (1.0, 1.0), (4.9, 2.0), (0.0, 1.0), (f32::INFINITY, 1.0)] {
            assert!((round_size(size) - expected).abs() < 1e-6, "{size}");
        }
    }

    #[test]
    fn a_changed_file_is_said_with_its_shape_counts() {
        let scene = |hash: &str, count| SessionScene {
            reference: SceneRef::File("a.obj".into()),
            content_hash: hash.to_owned(),
            shape_count: Some(count),
        };
        let text = change_warning(&scene("aa", 3), &scene("bb", 5)).expect("a warning");
        assert!(text.contains("a.obj has changed") && text.contains("had 3 shapes and has 5"), "{text}");
        assert_eq!(change_warning(&scene("aa", 3), &scene("aa", 3)), None);
        assert_eq!(change_warning(&scene("", 3), &scene("bb", 5)), None, "nothing was remembered");
    }
}
