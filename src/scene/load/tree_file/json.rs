//! The same arrays as JSON, for trees that are small enough to be read and written by hand. `null` stands for NaN.

use glam::Vec3;
use serde::Deserialize;

use super::super::fault::{Fault, one_line};
use super::TreeArrays;
use crate::task::Task;

#[derive(Deserialize)]
struct JsonTree {
    child_min: Vec<Vec<[Option<f64>; 3]>>,
    child_max: Vec<Vec<[Option<f64>; 3]>>,
    child_index: Vec<Vec<i32>>,
    leaf_first: Vec<i32>,
    leaf_count: Vec<i32>,
    shape_index: Vec<i32>,
    #[serde(default)]
    triangles: Option<Vec<[[Option<f64>; 3]; 3]>>,
}

pub fn read(bytes: &[u8], task: &Task) -> Result<TreeArrays, Fault> {
    task.check()?;
    let tree: JsonTree = serde_json::from_slice(bytes).map_err(|error| {
        Fault::of_file(format!(
            "it is no tree in JSON: {}; see docs/tree-format.md",
            one_line(&error.to_string())
        ))
    })?;
    task.check()?;
    let width = tree.child_index.first().map_or(0, Vec::len);
    Ok(TreeArrays {
        width,
        child_min: points("child_min", &tree.child_min, width)?,
        child_max: points("child_max", &tree.child_max, width)?,
        child_index: same_width("child_index", &tree.child_index, width)?.into_iter().copied().collect(),
        leaf_first: tree.leaf_first,
        leaf_count: tree.leaf_count,
        shape_index: tree.shape_index,
        triangles: tree.triangles.map(|triangles| {
            triangles.iter().map(|corners| corners.map(|c| Vec3::from(single(&c)))).collect()
        }),
        content_hash: String::new(),
    })
}

fn single(point: &[Option<f64>; 3]) -> [f32; 3] {
    point.map(|x| x.map_or(f32::NAN, |x| x as f32))
}

fn points(name: &str, rows: &[Vec<[Option<f64>; 3]>], width: usize) -> Result<Vec<[f32; 3]>, Fault> {
    Ok(same_width(name, rows, width)?.into_iter().map(single).collect())
}

fn same_width<'t, T>(name: &str, rows: &'t [Vec<T>], width: usize) -> Result<Vec<&'t T>, Fault> {
    match rows.iter().position(|row| row.len() != width) {
        Some(row) => Err(Fault::of_file(format!(
            "{name} has {} in row {row} (counted from 0) where the first node has {width}",
            rows[row].len()
        ))),
        None => Ok(rows.iter().flatten().collect()),
    }
}
