//! From a film to a picture of 8-bit sRGB: exposure and tone mapping, or a colour map over a range.

use image::RgbaImage;
use serde::{Deserialize, Serialize};

use super::film::Film;
use super::tonemap::ToneMap;

/// A perceptual colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorMap {
    #[default]
    Inferno,
    Magma,
    Plasma,
    Viridis,
    Cividis,
    Turbo,
    Greys,
}

impl ColorMap {
    pub const ALL: [Self; 7] =
        [Self::Inferno, Self::Magma, Self::Plasma, Self::Viridis, Self::Cividis, Self::Turbo, Self::Greys];

    pub fn name(self) -> &'static str {
        match self {
            Self::Inferno => "inferno",
            Self::Magma => "magma",
            Self::Plasma => "plasma",
            Self::Viridis => "viridis",
            Self::Cividis => "cividis",
            Self::Turbo => "turbo",
            Self::Greys => "greys",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Inferno => "black, red, yellow, white; even steps look even",
            Self::Magma => "black, purple, orange, white; even steps look even",
            Self::Plasma => "blue, magenta, yellow; even steps look even",
            Self::Viridis => "purple, green, yellow; even steps look even",
            Self::Cividis => "blue to yellow; looks the same to the colour-blind",
            Self::Turbo => "a rainbow with even brightness; shows small steps, hides order",
            Self::Greys => "black to white",
        }
    }

    /// sRGB of `t` in 0..=1 (clamped).
    pub fn color(self, t: f32) -> [u8; 3] {
        let _ = t;
        todo!()
    }
}

/// How a film is shown. Changing it never renders again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DisplaySettings {
    pub colormap: ColorMap,
    /// Values at the two ends of the colour map; `None`: from 0 (heat) or the smallest value (distance) to the 99.5th percentile.
    pub range: Option<[f32; 2]>,
    /// Heat values of at least this are shown in one flat colour, the rest dimmed.
    pub threshold: Option<f32>,
    /// In stops.
    pub exposure: f32,
    pub tonemap: ToneMap,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            colormap: ColorMap::default(),
            range: None,
            threshold: None,
            exposure: 0.0,
            tonemap: ToneMap::default(),
        }
    }
}

/// The range that a film of numbers is shown with: the set one, or the automatic one. `None` for a film of colours or
/// one without any number.
pub fn effective_range(film: &Film, settings: &DisplaySettings) -> Option<[f32; 2]> {
    let _ = (film, settings);
    todo!()
}

/// The picture, opaque. A film without samples is black.
pub fn picture(film: &Film, settings: &DisplaySettings) -> RgbaImage {
    let _ = (film, settings);
    todo!()
}
