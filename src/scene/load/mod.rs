//! Reading of models and textures: one file per format, and [`LoadError`].

use std::path::PathBuf;

use super::{Scene, SceneRef, UpAxis, builtin};
use crate::task::Task;

/// A scene, and what had to be repaired to get it, a line each, with counts.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub scene: Scene,
    pub warnings: Vec<String>,
    /// SHA-256 of the file, hexadecimal; empty for a built-in scene.
    pub content_hash: String,
}

/// Why a scene could not be loaded. Every message says what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    #[error("cancelled")]
    Cancelled,
    #[error("there is no built-in scene '{name}'; choose one of: {choices}, or name a file")]
    UnknownScene { name: String, choices: String },
    #[error("cannot make '{value}': {reason}")]
    Parameter { scene: String, value: String, reason: String },
    #[error("cannot read {path}: {reason}")]
    Read { path: PathBuf, reason: String },
}

/// Loads a built-in scene or a file (by its extension; `.obj .ply .stl .gltf .glb`), at t = 0. `up` orients the camera
/// that frames a file.
///
/// # Errors
/// [`LoadError`]; what can be repaired is loaded, with a warning that counts it.
pub fn load(scene: &SceneRef, up: UpAxis, task: &Task) -> Result<Loaded, LoadError> {
    let _ = up;
    match scene {
        SceneRef::Builtin(name) => Ok(Loaded {
            scene: builtin::make_with(name, task)?,
            warnings: Vec::new(),
            content_hash: String::new(),
        }),
        SceneRef::File(path) => {
            Err(LoadError::Read { path: path.clone(), reason: "no format is read yet".to_owned() })
        }
    }
}
