//! Which boxes are drawn, and how.

use serde::{Deserialize, Serialize};

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
