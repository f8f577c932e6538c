//! Which boxes are drawn, and how.

use serde::{Deserialize, Serialize};

use crate::world::NodeFigure;

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

/// Which boxes, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct OverlaySettings {
    /// Depths `[min, max]`, both shown; `None`: no boxes at all.
    pub depths: Option<[u32; 2]>,
    pub leaves_only: bool,
    pub style: BoxStyle,
    /// What the colour of a box tells.
    pub color: NodeFigure,
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
            color: NodeFigure::default(),
            show_hidden: false,
            budget: 100_000,
        }
    }
}
