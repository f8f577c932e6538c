//! Files of trees from other programs, `.npz` and `.json` (`docs/tree-format.md`), as plain arrays. What the arrays mean is
//! checked elsewhere; here they are of the right names, kinds and lengths.

mod json;
mod npy;
mod npz;

use std::path::Path;

use glam::Vec3;

use super::fault::{Fault, counted};
use super::model::MAX_COORDINATE;
use super::{LoadError, stage};
use crate::scene::assembly::Assembly;
use crate::scene::{Mesh, MeshTriangle, Scene, UpAxis};
use crate::task::Task;

/// The arrays of a tree's file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeArrays {
    /// Slots a node; 0 if there are no nodes to tell it.
    pub width: usize,
    /// `width` a node, as the other two.
    pub child_min: Vec<[f32; 3]>,
    pub child_max: Vec<[f32; 3]>,
    pub child_index: Vec<i32>,
    pub leaf_first: Vec<i32>,
    pub leaf_count: Vec<i32>,
    pub shape_index: Vec<i32>,
    /// The shapes, if the file has them.
    pub triangles: Option<Vec<[Vec3; 3]>>,
    /// SHA-256 of the file, hexadecimal.
    pub content_hash: String,
}

/// The forms of trees' files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeFormat {
    Npz,
    Json,
}

impl TreeFormat {
    pub const ALL: [Self; 2] = [Self::Npz, Self::Json];

    /// The file extension, in lower case and without the dot.
    pub fn name(self) -> &'static str {
        match self {
            Self::Npz => "npz",
            Self::Json => "json",
        }
    }

    /// The form that a path's extension names, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(extension))
    }
}

/// Reads the file of a tree.
///
/// # Errors
/// [`LoadError`]: it cannot be read, or its arrays are not those of a tree.
pub fn load_tree(path: &Path, task: &Task) -> Result<TreeArrays, LoadError> {
    let Some(format) = TreeFormat::of(path) else {
        let reason = "a tree is read from .npz or .json; see docs/tree-format.md".to_owned();
        return Err(LoadError::Read { path: path.to_owned(), reason });
    };
    let bytes = super::read_file(path, task)?;
    let (content_hash, arrays) = rayon::join(|| super::content_hash(&bytes), || read(&bytes, format, task));
    let arrays = arrays.map_err(|fault| super::located(path, fault))?;
    Ok(TreeArrays { content_hash, ..arrays })
}

pub(super) fn read(bytes: &[u8], format: TreeFormat, task: &Task) -> Result<TreeArrays, Fault> {
    let arrays = match format {
        TreeFormat::Npz => npz::read(bytes, task)?,
        TreeFormat::Json => json::read(bytes, task)?,
    };
    arrays.check()?;
    Ok(arrays)
}

impl TreeArrays {
    /// Checks that the arrays' lengths fit together.
    fn check(&self) -> Result<(), Fault> {
        let slots = self.child_index.len();
        for (name, len) in [("child_min", self.child_min.len()), ("child_max", self.child_max.len())] {
            if len != slots {
                return Err(Fault::of_file(format!(
                    "{name} has {} of boxes, child_index has {slots}; both need one for each slot of each node",
                    counted(len, "slot")
                )));
            }
        }
        if slots > 0 && !(2..=16).contains(&self.width) {
            return Err(Fault::of_file(format!(
                "its nodes have {}; allowed are 2 to 16",
                counted(self.width, "slot")
            )));
        }
        if self.leaf_first.len() != self.leaf_count.len() {
            return Err(Fault::of_file(format!(
                "leaf_first has {} entries and leaf_count {}; both need one a leaf",
                self.leaf_first.len(),
                self.leaf_count.len()
            )));
        }
        Ok(())
    }

    /// A scene of the file's triangles, every one of them, in their order: matt grey, framed and lit as a model is.
    pub(super) fn scene(&self, name: &str, up: UpAxis, task: &Task) -> Result<Scene, Fault> {
        let Some(triangles) = &self.triangles else {
            return Err(Fault::of_file(
                "it holds a tree without its shapes (there is no array 'triangles'); name the scene that the tree was \
                 built over: bvhscope import TREE SCENE",
            ));
        };
        if triangles.is_empty() {
            return Err(Fault::of_file("there are no triangles in it"));
        }
        task.check()?;
        // A NaN fails the comparison.
        let is_number = |v: &Vec3| v.abs().max_element() <= MAX_COORDINATE && !v.is_nan();
        if let Some(bad) = triangles.iter().position(|corners| !corners.iter().all(is_number)) {
            return Err(Fault::of_file(format!(
                "triangle {bad} (counted from 0) has a coordinate that is not a number, infinite, or beyond 1e12"
            )));
        }
        let mut mesh = Mesh { positions: triangles.concat(), ..Mesh::default() };
        let corners = (0..mesh.positions.len() as u32).step_by(3);
        mesh.triangles = corners.map(|first| MeshTriangle::flat([first, first + 1, first + 2])).collect();
        let mut assembly = Assembly::new(name);
        let grey = assembly.matt("(none)", Vec3::splat(0.7));
        let materials = vec![grey; mesh.triangles.len()];
        assembly.whole_mesh(mesh, materials);
        Ok(stage::finish(assembly, up))
    }
}

#[cfg(test)]
mod tests;
