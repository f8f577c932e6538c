//! Arrays as `np.savez` and `np.savez_compressed` write them: a ZIP archive of `.npy` files.

use std::io::{BufReader, Cursor, Read};

use glam::Vec3;
use zip::ZipArchive;
use zip::result::ZipError;

use super::super::fault::{Fault, guarded, one_line};
use super::TreeArrays;
use super::npy::{self, Header};
use crate::task::Task;

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

pub fn read(bytes: &[u8], task: &Task) -> Result<TreeArrays, Fault> {
    task.start(bytes.len() as u64);
    guarded("NPZ", || read_archive(bytes, task))?
}

fn read_archive(bytes: &[u8], task: &Task) -> Result<TreeArrays, Fault> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
        Fault::of_file(format!("it is no .npz: {}; write it with np.savez", one_line(&error.to_string())))
    })?;
    let (width, child_index) = indices(&mut archive, "child_index", 2, task)?;
    let (_, leaf_first) = indices(&mut archive, "leaf_first", 1, task)?;
    let (_, leaf_count) = indices(&mut archive, "leaf_count", 1, task)?;
    let (_, shape_index) = indices(&mut archive, "shape_index", 1, task)?;
    let corners = |archive: &mut Archive, name: &str| {
        let missing = || missing(name);
        corners(archive, name, width, task)?.ok_or_else(missing)
    };
    let child_min = corners(&mut archive, "child_min")?;
    let child_max = corners(&mut archive, "child_max")?;
    let triangles = self::corners(&mut archive, "triangles", 3, task)?;
    let triangles =
        triangles.map(|corners| corners.as_chunks().0.iter().map(|c| c.map(Vec3::from)).collect());
    Ok(TreeArrays {
        width,
        child_min,
        child_max,
        child_index,
        leaf_first,
        leaf_count,
        shape_index,
        triangles,
        content_hash: String::new(),
    })
}

fn missing(name: &str) -> Fault {
    Fault::of_file(format!("there is no array '{name}' in it; docs/tree-format.md lists what a tree needs"))
}

/// Opens an array; `None` if there is none of that name.
fn open<T>(
    archive: &mut Archive,
    name: &str,
    read: impl FnOnce(Header, &mut BufReader<&mut dyn Read>) -> Result<T, Fault>,
) -> Result<Option<T>, Fault> {
    let broken = |error: ZipError| {
        Fault::of_file(format!("the array {name} cannot be read: {}", one_line(&error.to_string())))
    };
    let mut file = match archive.by_name(&format!("{name}.npy")) {
        Ok(file) => file,
        Err(ZipError::FileNotFound) => return Ok(None),
        Err(error) => return Err(broken(error)),
    };
    let from: &mut dyn Read = &mut file;
    let mut from = BufReader::with_capacity(1 << 16, from);
    let header = npy::header(name, &mut from)?;
    read(header, &mut from).map(Some)
}

fn shape_fault(name: &str, shape: &[usize], wanted: &str) -> Fault {
    let sizes: Vec<_> = shape.iter().map(usize::to_string).collect();
    Fault::of_file(format!("the array {name} has the shape ({}); wanted is {wanted}", sizes.join(", ")))
}

/// An array of indices of one or two dimensions, and its last dimension.
fn indices(
    archive: &mut Archive,
    name: &str,
    dimensions: usize,
    task: &Task,
) -> Result<(usize, Vec<i32>), Fault> {
    let found = open(archive, name, |header, from| {
        let Header { dtype, shape } = header;
        let count = shape.iter().try_fold(1, |product: usize, size| product.checked_mul(*size));
        let is_empty = count == Some(0);
        let Some(count) = count.filter(|_| shape.len() == dimensions || (is_empty && !shape.is_empty()))
        else {
            let wanted = if dimensions == 2 { "(nodes, slots)" } else { "one number, the length" };
            return Err(shape_fault(name, &shape, wanted));
        };
        let last = shape.last().copied().unwrap_or(0);
        Ok((last, npy::numbers(name, from, dtype, count, npy::index, task)?))
    })?;
    found.ok_or_else(|| missing(name))
}

/// An array of points, `per` in each entry.
fn corners(
    archive: &mut Archive,
    name: &str,
    per: usize,
    task: &Task,
) -> Result<Option<Vec<[f32; 3]>>, Fault> {
    open(archive, name, |header, from| {
        let Header { dtype, shape } = header;
        let count = shape.iter().try_fold(1, |product: usize, size| product.checked_mul(*size));
        let fits =
            matches!(shape[..], [_, slots, 3] if slots == per) || (count == Some(0) && !shape.is_empty());
        let Some(count) = count.filter(|_| fits) else {
            return Err(shape_fault(name, &shape, &format!("(n, {per}, 3)")));
        };
        let numbers = npy::numbers(name, from, dtype, count, npy::float, task)?;
        Ok(numbers.as_chunks().0.to_vec())
    })
}
