//! From a session to what it shows: the scene at its moment, staged, and the camera. The window and the commands open
//! scenes here, so that both show the same.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::{Session, SessionScene, TreeRef};
use crate::geometry::Shape;
use crate::scene::load::{Place, TreeArrays, load, load_tree, scene_of_tree};
use crate::scene::{Camera, LoadError, Loaded, Scene, SceneRef};
use crate::task::Task;
use crate::world::TreeFile;

/// A scene that was opened.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// As it was loaded: at t = 0, without the ground. [`stage`] makes the scene of another moment from it.
    pub still: Arc<Scene>,
    /// At the session's time, with its ground.
    pub scene: Arc<Scene>,
    /// The session's camera, or the scene's own.
    pub camera: Camera,
    /// The tree of the session's file, if it has one.
    pub tree: Option<Arc<TreeFile>>,
    /// What had to be repaired, and whether the scene is another one than the session remembers; a line each.
    pub warnings: Vec<String>,
}

/// Loads the session's scene, and its tree if it has one from a file, and fills in what the session remembers of them:
/// content hashes and shape count.
///
/// # Errors
/// [`LoadError`]; the session is then as before.
pub fn open(session: &mut Session, task: &Task) -> Result<Prepared, LoadError> {
    let arrays = session.tree().map(|tree| load_tree(&tree.path, task)).transpose()?;
    let in_one = session.tree().is_some_and(|t| session.scene.reference == SceneRef::File(t.path.clone()));
    let loaded = match (session.tree(), &arrays) {
        (Some(tree), Some(arrays)) if in_one => scene_of_tree(&tree.path, arrays, session.up, task)?,
        _ => load(&session.scene.reference, session.up, task)?,
    };
    let Loaded { scene, mut warnings, content_hash } = loaded;
    let tree = arrays.map(|arrays| adopt_tree(session, arrays, &scene, &mut warnings)).transpose()?;
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
    Ok(Prepared { still, scene, camera, tree, warnings })
}

/// Opens the tree of a file: over `still`, the scene of now as it was loaded, if the file's triangles are those of the scene
/// or it has none; else over the scene of its own triangles.
///
/// # Errors
/// [`LoadError`]; the session may have the tree by then.
pub fn import(
    session: &mut Session,
    still: Option<&Arc<Scene>>,
    path: &Path,
    task: &Task,
) -> Result<Prepared, LoadError> {
    session.set_tree(None);
    session.set_tree(Some(path.to_owned()));
    let arrays = load_tree(path, task)?;
    let mut warnings = Vec::new();
    let still = match still.filter(|still| is_over(&arrays, still)) {
        Some(still) => Arc::clone(still),
        None => {
            let Loaded { scene, content_hash, .. } = scene_of_tree(path, &arrays, session.up, task)?;
            session.scene = SessionScene {
                reference: SceneRef::File(path.to_owned()),
                content_hash,
                shape_count: Some(scene.shape_count()),
            };
            (session.camera, session.time) = (None, 0.0);
            Arc::new(scene)
        }
    };
    let tree = Some(adopt_tree(session, arrays, &still, &mut warnings)?);
    let scene = stage(&still, session);
    let camera = camera(&scene, session);
    Ok(Prepared { still, scene, camera, tree, warnings })
}

/// Whether a tree can be one over the shapes of this scene: it says nothing of them, or they are the same triangles.
fn is_over(arrays: &TreeArrays, scene: &Scene) -> bool {
    arrays.triangles.as_ref().is_none_or(|triangles| {
        let is_same = |(shape, corners): (usize, &[Vec3; 3])| {
            matches!(scene.shape(shape as u32), Shape::Triangle(triangle) if triangle.v == *corners)
        };
        triangles.len() == scene.shape_count() && triangles.iter().enumerate().all(is_same)
    })
}

/// Loads the tree of the session's file alone, if it has one, for a scene that is there.
///
/// # Errors
/// [`LoadError`]; the session is then as before.
pub fn open_tree(
    session: &mut Session,
    scene: &Scene,
    task: &Task,
) -> Result<Option<Arc<TreeFile>>, LoadError> {
    let Some(tree) = session.tree() else { return Ok(None) };
    let arrays = load_tree(&tree.path, task)?;
    adopt_tree(session, arrays, scene, &mut Vec::new()).map(Some)
}

fn adopt_tree(
    session: &mut Session,
    arrays: TreeArrays,
    scene: &Scene,
    warnings: &mut Vec<String>,
) -> Result<Arc<TreeFile>, LoadError> {
    let Some(TreeRef { path, content_hash }) = &mut session.variants[session.active].tree else {
        unreachable!("the arrays are those of the session's tree");
    };
    let file = TreeFile::new(path, arrays);
    file.check_scene(scene).map_err(|error| LoadError::Content {
        path: path.clone(),
        place: Place::File,
        reason: error.to_string(),
    })?;
    if !content_hash.is_empty() && *content_hash != file.content_hash {
        warnings.push(format!(
            "{} has changed since this session was saved: figures will differ",
            path.display()
        ));
    }
    content_hash.clone_from(&file.content_hash);
    Ok(Arc::new(file))
}

/// The scene of the session's moment, with a ground if the session has one. `still` is the scene of t = 0 as loaded. The
/// ground stays where the still scene stands, whatever moves.
pub fn stage(still: &Arc<Scene>, session: &Session) -> Arc<Scene> {
    let moves = session.time != still.time && still.is_animated();
    let grounded = session.ground.then(|| still.with_ground(true, session.up));
    match grounded {
        // What a tree is refitted from is the scene as loaded, with or without a ground.
        Some(Scene { ground, materials, .. }) if moves => {
            Arc::new(Scene { ground, materials, ..still.at(session.time) })
        }
        Some(grounded) => Arc::new(grounded),
        None if moves => Arc::new(still.at(session.time)),
        None => Arc::clone(still),
    }
}

/// The session's camera, or the scene's own, with the session's up axis.
pub fn camera(scene: &Scene, session: &Session) -> Camera {
    Camera { up: session.up, ..session.camera.unwrap_or(scene.camera) }
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
    use crate::scene::{UpAxis, builtin};

    #[test]
    fn a_still_scene_without_ground_is_shared() {
        let still = Arc::new(builtin::make("soup:20").expect("a scene"));
        let staged = stage(&still, &Session { time: 3.0, ..Session::default() });
        assert!(Arc::ptr_eq(&still, &staged));
    }

    #[test]
    fn the_ground_stays_while_the_scene_moves() {
        let still = Arc::new(builtin::make("bunny").expect("a scene"));
        let at = |time| stage(&still, &Session { ground: true, time, ..Session::default() });
        let (now, later) = (at(0.0), at(0.7));
        assert_eq!(now.ground.expect("a ground").0, later.ground.expect("a ground").0);
        assert_ne!(now.mesh.positions, later.mesh.positions);
        assert_eq!((later.time, later.shape_count()), (0.7, still.shape_count()));
        assert!(still.ground.is_none());
    }

    #[test]
    fn opening_fills_in_what_the_session_remembers_and_warns_of_another_scene() {
        let mut session = Session { up: UpAxis::Z, ..Session::default() };
        session.scene.reference = SceneRef::Builtin("soup:50".to_owned());
        session.scene.shape_count = Some(51);
        let prepared = open(&mut session, &Task::new()).expect("opened");
        assert_eq!(session.scene.shape_count, Some(50));
        assert!(prepared.warnings[0].contains("had 51 shapes and has 50"), "{:?}", prepared.warnings);
        assert_eq!(prepared.camera.up, UpAxis::Z);
        assert!(open(&mut session, &Task::new()).expect("opened").warnings.is_empty());
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
