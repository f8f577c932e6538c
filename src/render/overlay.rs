//! The boxes of a tree, drawn over a picture by a rasteriser of our own that tests against the tracer's depth.

use image::RgbaImage;
use serde::{Deserialize, Serialize};

use crate::scene::Camera;
use crate::task::{Cancelled, Task};
use crate::world::World;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxStyle {
    #[default]
    Wire,
    Fill,
    /// How many boxes lie behind each pixel, through the colour map.
    Density,
}

impl BoxStyle {
    pub const ALL: [Self; 3] = [Self::Wire, Self::Fill, Self::Density];

    pub fn name(self) -> &'static str {
        match self {
            Self::Wire => "wire",
            Self::Fill => "fill",
            Self::Density => "density",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Wire => "edges",
            Self::Fill => "translucent sides",
            Self::Density => "how many boxes lie over each pixel, added up",
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxColor {
    #[default]
    Depth,
    LeafSize,
    SahShare,
}

impl BoxColor {
    pub const ALL: [Self; 3] = [Self::Depth, Self::LeafSize, Self::SahShare];

    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::LeafSize => "leaf-size",
            Self::SahShare => "sah-share",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Depth => "by depth below the root",
            Self::LeafSize => "by the number of shapes in the leaf; inner nodes grey",
            Self::SahShare => "by the node's own share of the tree's SAH cost",
        }
    }
}

/// Which boxes, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct OverlaySettings {
    /// Depths `[min, max]`, both shown; `None`: no boxes at all.
    pub depths: Option<[u32; 2]>,
    pub leaves_only: bool,
    pub style: BoxStyle,
    pub color: BoxColor,
    /// Draw what lies behind geometry, too.
    pub show_hidden: bool,
    /// Most boxes drawn; the largest on screen go first.
    pub budget: u32,
}

impl Default for OverlaySettings {
    fn default() -> Self {
        Self {
            depths: None,
            leaves_only: false,
            style: BoxStyle::default(),
            color: BoxColor::default(),
            show_hidden: false,
            budget: 100_000,
        }
    }
}

/// A drawn overlay, and what was left out.
#[derive(Clone, Debug)]
pub struct Overlay {
    /// Premultiplied alpha, sRGB, same size as the picture.
    pub image: RgbaImage,
    /// Boxes that the depth range and `leaves_only` select.
    pub selected: usize,
    pub drawn: usize,
    /// Outside the picture.
    pub outside: usize,
    /// Smaller than a pixel, drawn as nothing.
    pub too_small: usize,
    /// Beyond the budget.
    pub over_budget: usize,
}

/// Draws the boxes of the world's tree. `depth`: distance along each pixel centre's camera ray to the first surface
/// (infinity for none), from [`first_hit_distances`].
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn draw_boxes(
    world: &World,
    camera: &Camera,
    settings: &OverlaySettings,
    depth: &[f32],
    width: u32,
    height: u32,
    task: &Task,
) -> Result<Overlay, Cancelled> {
    let _ = (world, camera, settings, depth, width, height, task);
    todo!()
}

/// Distance along the ray through each pixel's centre to the first surface; infinity for none.
pub fn first_hit_distances(
    world: &World,
    camera: &Camera,
    width: u32,
    height: u32,
    task: &Task,
) -> Result<Vec<f32>, Cancelled> {
    let _ = (world, camera, width, height, task);
    todo!()
}

/// Lays an overlay over a picture of the same size.
pub fn compose(picture: &mut RgbaImage, overlay: &Overlay) {
    let _ = (picture, overlay);
    todo!()
}
