//! The boxes of a tree, drawn over a picture by a rasteriser of our own that tests against the tracer's depth.

mod band;
mod color;
mod draw;
mod hidden;
mod project;
mod select;
mod settings;

use glam::Vec2;
use image::RgbaImage;
use rayon::prelude::*;

use super::tiles::{add, tiles};
use super::visits;
use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::{NodeFigure, Packets, World};

pub use color::{NEUTRAL_COLOR, ramp};
pub use draw::{DENSITY_MAP, density_position};
pub use settings::{BoxStyle, OverlaySettings};

/// A drawn overlay, and what was left out.
#[derive(Clone, Debug)]
pub struct Overlay {
    /// Premultiplied alpha, sRGB, same size as the picture.
    pub image: RgbaImage,
    /// Boxes that the depth range and `leaves_only` select.
    pub selected: usize,
    /// Drawn, or to be drawn but behind surfaces.
    pub drawn: usize,
    /// Outside the picture.
    pub outside: usize,
    /// Smaller than a pixel, drawn as nothing.
    pub too_small: usize,
    /// Beyond the budget.
    pub over_budget: usize,
    /// What the boxes' colours mean: the values at the two ends of [`NodeFigure::color`]; `None` if none has a value, and
    /// for a density.
    pub color_range: Option<[f32; 2]>,
    /// Fewest and most boxes over one pixel; `None` unless the style is density. See [`density_position`].
    pub density_range: Option<[u32; 2]>,
}

/// What is said of nodes, by [`NodeId`](crate::accel::NodeId).
#[derive(Clone, Copy, Debug, Default)]
pub struct NodesShown<'a> {
    /// What the colours say; empty for depths, which are known on the way.
    values: &'a [f32],
    /// Whether a node is drawn; `None` for all.
    shown: Option<&'a [bool]>,
}

/// Draws the boxes of the world's tree, or of a broken one from a file, but for those that hold nothing but `hidden` shapes
/// (ascending). `depth`: distance along each pixel centre's camera ray to the first surface
/// (infinity for none), from [`first_hit_distances`].
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// If `depth` has not one entry a pixel.
pub fn draw_boxes(
    world: &World,
    camera: &Camera,
    settings: &OverlaySettings,
    hidden: &[u32],
    depth: &[f32],
    [width, height]: [u32; 2],
    task: &Task,
) -> Result<Overlay, Cancelled> {
    // Of a density no box has a colour, and the depth is known on the way.
    let values = match settings.color {
        _ if settings.style == BoxStyle::Density => Vec::new(),
        NodeFigure::Depth => Vec::new(),
        figure => visits::node_values(world, figure, camera, [width, height], &task.step())?,
    };
    let tree = world.shown_tree();
    let shown = if hidden.is_empty() { None } else { Some(select::with_shapes_beside(tree, hidden)) };
    let nodes = NodesShown { values: &values, shown: shown.as_deref() };
    draw::draw_tree(tree, nodes, camera.frame(width, height), settings, depth, task)
}

/// Distance along the ray through each pixel's centre to the first surface; infinity for none.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn first_hit_distances(
    world: &World,
    camera: &Camera,
    width: u32,
    height: u32,
    task: &Task,
) -> Result<Vec<f32>, Cancelled> {
    let frame = camera.frame(width, height);
    let (size, state) = ([width, height], || (Packets::new(world), Vec::new()));
    let found = tiles(size, task, &|_| (), state, |(packets, rays), pixels, distances| {
        rays.clear();
        rays.extend(pixels.iter().map(|&[x, y]| frame.ray(Vec2::new(x as f32 + 0.5, y as f32 + 0.5))));
        for (distance, hit) in distances.iter_mut().zip(packets.intersect(rays)) {
            *distance = hit.map_or(f32::INFINITY, |hit| hit.t);
        }
        Ok(())
    })?;
    let mut distances = vec![0.0; width as usize * height as usize];
    add(&mut distances, &found, size);
    Ok(distances)
}

/// Lays an overlay over a picture of the same size.
///
/// # Panics
/// If the sizes differ.
pub fn compose(picture: &mut RgbaImage, overlay: &Overlay) {
    assert_eq!(picture.dimensions(), overlay.image.dimensions(), "an overlay has the size of its picture");
    const CHUNK: usize = 1 << 14;
    picture.par_chunks_mut(4 * CHUNK).zip(overlay.image.par_chunks(4 * CHUNK)).for_each(|(below, above)| {
        for (below, above) in below.chunks_exact_mut(4).zip(above.chunks_exact(4)) {
            let through = 255 - u32::from(above[3]);
            for (below, &above) in below.iter_mut().zip(above) {
                *below = (u32::from(above) + (u32::from(*below) * through + 127) / 255).min(255) as u8;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composing_is_premultiplied_over() {
        let mut picture = RgbaImage::from_pixel(8, 8, image::Rgba([100, 200, 50, 255]));
        let mut overlay = Overlay {
            image: RgbaImage::new(8, 8),
            selected: 0,
            drawn: 0,
            outside: 0,
            too_small: 0,
            over_budget: 0,
            color_range: None,
            density_range: None,
        };
        overlay.image.put_pixel(3, 4, image::Rgba([64, 0, 128, 128]));
        overlay.image.put_pixel(5, 6, image::Rgba([9, 8, 7, 255]));
        compose(&mut picture, &overlay);
        assert_eq!(picture.get_pixel(0, 0).0, [100, 200, 50, 255]);
        assert_eq!(picture.get_pixel(3, 4).0, [114, 100, 153, 255]);
        assert_eq!(picture.get_pixel(5, 6).0, [9, 8, 7, 255]);
    }
}
