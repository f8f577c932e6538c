//! Reading of texture images.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::Vec3;
use image::{DynamicImage, ImageFormat, ImageReader};
use rayon::prelude::*;

use super::fault::{Fault, one_line};
use crate::scene::{Image, Pixels};
use crate::task::Task;

/// The texture files that a model asks for, each once.
pub(super) struct Textures<'a> {
    folder: &'a Path,
    paths: Vec<PathBuf>,
    index_of: HashMap<PathBuf, u32>,
}

impl<'a> Textures<'a> {
    /// Textures whose names are relative to `folder`.
    pub fn new(folder: &'a Path) -> Self {
        Self { folder, paths: Vec::new(), index_of: HashMap::new() }
    }

    /// The index that the file's image will have.
    pub fn request(&mut self, name: &str) -> u32 {
        let path = self.find(name);
        let next = self.paths.len() as u32;
        *self.index_of.entry(path).or_insert_with_key(|path| {
            self.paths.push(path.clone());
            next
        })
    }

    /// Files come from other machines: separators of Windows, and paths that exist only there.
    fn find(&self, name: &str) -> PathBuf {
        let name = name.replace('\\', "/");
        let named = self.folder.join(&name);
        if named.is_file() {
            return named;
        }
        let beside = self.folder.join(name.rsplit('/').next().unwrap_or(&name));
        if beside.is_file() { beside } else { named }
    }

    /// Reads all of them. One that cannot be read is white, and a warning says so.
    pub fn read(self, task: &Task, warnings: &mut Vec<String>) -> Result<Vec<Image>, Fault> {
        let read = |path: &PathBuf| {
            if task.is_cancelled() {
                return Err("cancelled".to_owned());
            }
            let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
            decode(&bytes, ImageFormat::from_path(path).ok())
        };
        let images: Vec<_> = self.paths.par_iter().map(read).collect();
        task.check()?;
        let or_white = |(image, path): (Result<Image, String>, &PathBuf)| {
            image.unwrap_or_else(|reason| {
                let reason = one_line(&reason);
                warnings
                    .push(format!("texture {} cannot be read ({reason}); shown without it", path.display()));
                white()
            })
        };
        Ok(images.into_iter().zip(&self.paths).map(or_white).collect())
    }
}

/// A single white pixel.
pub(super) fn white() -> Image {
    Image { width: 1, height: 1, pixels: Pixels::Linear(vec![Vec3::ONE]) }
}

/// Decodes an image, whose bytes say its format better than its name (`hint`) does.
pub(super) fn decode(bytes: &[u8], hint: Option<ImageFormat>) -> Result<Image, String> {
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    if let (None, Some(hint)) = (reader.format(), hint) {
        reader.set_format(hint);
    }
    Ok(from_dynamic(reader.decode().map_err(|error| error.to_string())?))
}

/// Floats are linear light, integers are encoded in sRGB. Transparency is dropped.
fn from_dynamic(image: DynamicImage) -> Image {
    let (width, height) = (image.width(), image.height());
    let pixels = match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let finite = |c: f32| if c.is_finite() { c.max(0.0) } else { 0.0 };
            let pixels = image.into_rgb32f().into_raw();
            Pixels::Linear(
                pixels.chunks_exact(3).map(|p| Vec3::new(finite(p[0]), finite(p[1]), finite(p[2]))).collect(),
            )
        }
        _ => Pixels::Srgb8(image.into_rgb8().into_raw().as_chunks().0.to_vec()),
    };
    Image { width, height, pixels }
}
