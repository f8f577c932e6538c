//! Trees for other programs, as `docs/tree-format.md` says: `.npz`, arrays as NumPy writes them, or JSON.

use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::{ExportError, atomic};
use crate::accel::{RawTree, Tree};
use crate::geometry::Shape;
use crate::scene::Scene;
use crate::scene::load::TreeFormat;

/// Extensions of trees' files, the usual one first.
pub const EXTENSIONS: [&str; 2] = ["npz", "json"];

/// Whether a file of that name is opened as a tree.
pub fn is_tree_path(path: &Path) -> bool {
    TreeFormat::of(path).is_some()
}

/// Writes a tree, and with it the triangles of its scene if it has no other shapes. Whether it could.
///
/// # Errors
/// [`ExportError::Write`]
pub fn save(tree: &Tree, scene: &Scene, path: &Path) -> Result<bool, ExportError> {
    let raw = RawTree::of(tree);
    let triangles = triangles(scene);
    match TreeFormat::of(path) {
        Some(TreeFormat::Npz) => atomic::write_with(path, |file| {
            write_npz(&raw, triangles.as_deref(), file).map_err(|error| atomic::refusal(path, &error))
        })?,
        Some(TreeFormat::Json) => atomic::write_bytes(path, json(&raw, triangles.as_deref()).as_bytes())?,
        None => {
            let reason = "a tree is written as .npz or .json".to_owned();
            return Err(ExportError::Write { path: path.to_owned(), reason });
        }
    }
    Ok(triangles.is_some())
}

/// The scene's shapes, if all are triangles.
fn triangles(scene: &Scene) -> Option<Vec<[[f32; 3]; 3]>> {
    let corners = (0..scene.shape_count() as u32).map(|shape| match scene.shape(shape) {
        Shape::Triangle(triangle) => Some(triangle.v.map(|v| v.to_array())),
        Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Quad(_) | Shape::Torus(_) => None,
    });
    corners.collect()
}

fn write_npz(
    raw: &RawTree,
    triangles: Option<&[[[f32; 3]; 3]]>,
    file: &mut dyn atomic::WriteSeek,
) -> io::Result<()> {
    let (nodes, width) = (raw.node_count(), raw.width);
    let mut zip = ZipWriter::new(file);
    let mut array = |name: &str, descr: &str, shape: &str, bytes: &[u8]| -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(bytes.len() >= u32::MAX as usize - 1000);
        zip.start_file(format!("{name}.npy"), options)?;
        zip.write_all(&npy_header(descr, shape))?;
        zip.write_all(bytes)
    };
    let boxes = format!("({nodes}, {width}, 3)");
    // The machines that this runs on are little-endian, as the file is.
    array("child_min", "<f4", &boxes, bytemuck::cast_slice(&raw.child_min))?;
    array("child_max", "<f4", &boxes, bytemuck::cast_slice(&raw.child_max))?;
    array("child_index", "<i4", &format!("({nodes}, {width})"), bytemuck::cast_slice(&raw.child_index))?;
    for (name, numbers) in
        [("leaf_first", &raw.leaf_first), ("leaf_count", &raw.leaf_count), ("shape_index", &raw.shape_index)]
    {
        array(name, "<i4", &format!("({},)", numbers.len()), bytemuck::cast_slice(numbers))?;
    }
    if let Some(triangles) = triangles {
        array("triangles", "<f4", &format!("({}, 3, 3)", triangles.len()), bytemuck::cast_slice(triangles))?;
    }
    zip.finish()?;
    Ok(())
}

/// The header of an array, filled up so that the numbers begin at a multiple of 64 bytes.
fn npy_header(descr: &str, shape: &str) -> Vec<u8> {
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}").into_bytes();
    text.resize((10 + text.len() + 1).next_multiple_of(64) - 11, b' ');
    text.push(b'\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((text.len() as u16).to_le_bytes());
    header.extend(text);
    header
}

fn json(raw: &RawTree, triangles: Option<&[[[f32; 3]; 3]]>) -> String {
    #[derive(Serialize)]
    struct Json<'a> {
        child_min: Vec<&'a [[f32; 3]]>,
        child_max: Vec<&'a [[f32; 3]]>,
        child_index: Vec<&'a [i32]>,
        leaf_first: &'a [i32],
        leaf_count: &'a [i32],
        shape_index: &'a [i32],
        #[serde(skip_serializing_if = "Option::is_none")]
        triangles: Option<&'a [[[f32; 3]; 3]]>,
    }
    let text = serde_json::to_string(&Json {
        child_min: raw.child_min.chunks(raw.width).collect(),
        child_max: raw.child_max.chunks(raw.width).collect(),
        child_index: raw.child_index.chunks(raw.width).collect(),
        leaf_first: &raw.leaf_first,
        leaf_count: &raw.leaf_count,
        shape_index: &raw.shape_index,
        triangles,
    });
    let mut text = text.expect("arrays are plain data");
    // An array a line, so that it can be read.
    for name in
        ["child_min", "child_max", "child_index", "leaf_first", "leaf_count", "shape_index", "triangles"]
    {
        text = text.replace(&format!("\"{name}\":"), &format!("\n  \"{name}\": "));
    }
    text.truncate(text.len() - 1);
    text + "\n}\n"
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Width};
    use crate::scene::builtin;
    use crate::scene::load::load_tree;
    use crate::task::Task;
    use crate::world::{TreeFile, World};

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, width) in [("a.npz", Width::W8), ("b.json", Width::W2), ("c.NPZ", Width::W4)] {
            let scene = Arc::new(builtin::make("soup:200").expect("a scene"));
            let config = BuildConfig { width, ..BuildConfig::default() };
            let world = World::build(Arc::clone(&scene), &config, &Task::new()).expect("not cancelled");
            let path = folder.path().join(name);
            assert!(save(&world.tree, &scene, &path).expect("written"), "with its triangles");
            let arrays = load_tree(&path, &Task::new()).expect("a tree");
            assert_eq!(arrays.triangles.as_ref().map(Vec::len), Some(200));
            let file = TreeFile::new(&path, arrays);
            assert_eq!(file.raw, RawTree::of(&world.tree), "{name}");
            let back = World::with_tree(scene, Arc::new(file), &config, &Task::new()).expect("not cancelled");
            assert_eq!((&back.tree, &back.figures), (&world.tree, &world.figures));
            assert!(back.traced_file().is_some());
        }
    }

    #[test]
    fn a_scene_of_other_shapes_keeps_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.json");
        let scene = Arc::new(builtin::make("cornell").expect("a scene"));
        let world =
            World::build(Arc::clone(&scene), &BuildConfig::default(), &Task::new()).expect("not cancelled");
        assert!(!save(&world.tree, &scene, &path).expect("written"));
        assert_eq!(load_tree(&path, &Task::new()).expect("a tree").triangles, None);
        let message =
            save(&world.tree, &scene, &folder.path().join("t.obj")).expect_err("refused").to_string();
        assert!(message.contains("written as .npz or .json"), "{message}");
    }
}
