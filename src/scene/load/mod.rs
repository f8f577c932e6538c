//! Reading of models and textures: one file per format, and [`LoadError`]. Nothing else of the program reads models.

mod fault;
mod gltf;
mod model;
mod mtl;
mod obj;
mod obj_text;
mod ply;
mod polygon;
mod stage;
mod stl;
mod texture;
mod tree_file;

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Scene, SceneRef, UpAxis, builtin};
use crate::task::Task;
use fault::Fault;
use model::Model;

pub use tree_file::{TreeArrays, TreeFormat, load_tree};

/// A scene, and what had to be repaired to get it, a line each, with counts.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub scene: Scene,
    pub warnings: Vec<String>,
    /// SHA-256 of the file, hexadecimal; empty for a built-in scene.
    pub content_hash: String,
}

/// Why a scene could not be loaded. Every message says what, where, and what to do, in one line.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    #[error("cancelled")]
    Cancelled,
    #[error("there is no built-in scene '{name}'; choose one of: {choices}, or name a file")]
    UnknownScene { name: String, choices: String },
    #[error("cannot make '{value}': {reason}")]
    Parameter { scene: String, value: String, reason: String },
    /// The file could not be read at all.
    #[error("cannot read {path}: {reason}")]
    Read { path: PathBuf, reason: String },
    /// The file could be read, but holds no model that could be shown.
    #[error("cannot read {path}{place}: {reason}")]
    Content { path: PathBuf, place: Place, reason: String },
}

/// Where in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the file as a whole.
    File,
    /// From 1.
    Line(usize),
    /// From 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, ", line {line}"),
            Self::Byte(byte) => write!(f, ", byte {byte}"),
        }
    }
}

/// The formats of model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Obj,
    Ply,
    Stl,
    Gltf,
    Glb,
}

impl Format {
    pub const ALL: [Self; 5] = [Self::Obj, Self::Ply, Self::Stl, Self::Gltf, Self::Glb];

    /// The file extension, in lower case and without the dot.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
        }
    }

    /// The format that a path's extension names, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(extension))
    }
}

/// Loads a built-in scene or a file (by its extension; `.obj .ply .stl .gltf .glb`, or the shapes of a tree's `.npz .json`),
/// at t = 0. `up` orients the camera that frames a file.
///
/// # Errors
/// [`LoadError`]; what can be repaired is loaded, with a warning that counts it.
pub fn load(scene: &SceneRef, up: UpAxis, task: &Task) -> Result<Loaded, LoadError> {
    match scene {
        SceneRef::Builtin(name) => Ok(Loaded {
            scene: builtin::make_with(name, task)?,
            warnings: Vec::new(),
            content_hash: String::new(),
        }),
        SceneRef::File(path) => load_file(path, up, task),
    }
}

fn load_file(path: &Path, up: UpAxis, task: &Task) -> Result<Loaded, LoadError> {
    if TreeFormat::of(path).is_some() {
        return scene_of_tree(path, &load_tree(path, task)?, up, task);
    }
    let format = Format::of(path);
    let bytes = read_file(path, task)?;
    let format = format.expect("a file of another format is not read");
    task.start(bytes.len() as u64);
    let (content_hash, parsed) = rayon::join(|| content_hash(&bytes), || parse(format, &bytes, path, task));
    let finish = |model: Model| {
        task.check()?;
        model.finish(&file_name(path), up)
    };
    let (scene, warnings) = parsed.and_then(finish).map_err(|fault| located(path, fault))?;
    Ok(Loaded { scene, warnings, content_hash })
}

/// The scene of the triangles in a tree's file.
///
/// # Errors
/// [`LoadError::Content`]: it has none, or some that cannot be shown.
pub fn scene_of_tree(path: &Path, tree: &TreeArrays, up: UpAxis, task: &Task) -> Result<Loaded, LoadError> {
    let scene = tree.scene(&file_name(path), up, task).map_err(|fault| located(path, fault))?;
    Ok(Loaded { scene, warnings: Vec::new(), content_hash: tree.content_hash.clone() })
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A reader's fault with the file in which it is.
fn located(path: &Path, fault: Fault) -> LoadError {
    match fault {
        Fault::Cancelled => LoadError::Cancelled,
        Fault::Content { place, reason } => LoadError::Content { path: path.to_owned(), place, reason },
    }
}

fn parse(format: Format, bytes: &[u8], path: &Path, task: &Task) -> Result<Model, Fault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    match format {
        Format::Obj => obj::read(bytes, folder, task),
        Format::Ply => ply::read(bytes, task),
        Format::Stl => stl::read(bytes, task),
        Format::Gltf | Format::Glb => gltf::read(bytes, folder, task),
    }
}

/// The whole file, if it is one that can be read and holds anything.
fn read_file(path: &Path, task: &Task) -> Result<Vec<u8>, LoadError> {
    let refused = |reason: String| LoadError::Read { path: path.to_owned(), reason };
    let known = Format::ALL.map(|f| format!(".{}", f.name())).join(" ");
    let metadata = std::fs::metadata(path).map_err(|error| refused(io_reason(&error)))?;
    if metadata.is_dir() {
        return Err(refused(format!("this is a folder; name a file in it ({known})")));
    }
    if Format::of(path).is_none() && TreeFormat::of(path).is_none() {
        let what = match path.extension() {
            Some(extension) => {
                format!("'.{}' is no format that this program reads", extension.to_string_lossy())
            }
            None => "the file has no extension that says its format".to_owned(),
        };
        return Err(refused(format!("{what}; convert the model to one of {known}")));
    }
    let mut file = File::open(path).map_err(|error| refused(io_reason(&error)))?;
    let mut bytes = Vec::new();
    // Read in pieces, so that a large file or a slow disk can be cancelled.
    loop {
        task.check().map_err(|_| LoadError::Cancelled)?;
        let read = file.by_ref().take(READ_PIECE).read_to_end(&mut bytes);
        if read.map_err(|error| refused(io_reason(&error)))? == 0 {
            break;
        }
    }
    if bytes.is_empty() {
        return Err(refused("the file is empty; export the model again".to_owned()));
    }
    Ok(bytes)
}

const READ_PIECE: u64 = 4 << 20;

/// An error of the operating system, with what to do.
fn io_reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => {
            "there is no such file; check the path, or name a built-in scene".to_owned()
        }
        std::io::ErrorKind::PermissionDenied => {
            "permission denied; make the file readable for you".to_owned()
        }
        _ => format!("{error}; check that the file can be opened elsewhere"),
    }
}

/// SHA-256, in hexadecimal.
fn content_hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
