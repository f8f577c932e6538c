//! The same shadow ray asked three ways: `intersect`, `occluded`, and `occluded` with a filter.

use serde::Serialize;

/// What a pixel shows when both answers are held against each other. The discriminant is what a class film stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[repr(u8)]
pub enum ShadowClass {
    /// A miss, an emitter, or the light behind the surface: no ray is asked.
    NotAsked = 0,
    LitInBoth = 1,
    DarkInBoth = 2,
    /// The false shadow.
    DarkOnlyInOccluded = 3,
    /// Impossible; a test holds it at zero.
    DarkOnlyInIntersect = 4,
}

impl ShadowClass {
    pub const ALL: [Self; 5] = [
        Self::NotAsked,
        Self::LitInBoth,
        Self::DarkInBoth,
        Self::DarkOnlyInOccluded,
        Self::DarkOnlyInIntersect,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::NotAsked => "not asked",
            Self::LitInBoth => "lit in both",
            Self::DarkInBoth => "dark in both",
            Self::DarkOnlyInOccluded => "dark only in occluded (false shadow)",
            Self::DarkOnlyInIntersect => "dark only in intersect (impossible)",
        }
    }

    /// sRGB, as in the view.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::NotAsked => [38, 40, 46],
            Self::LitInBoth => [222, 214, 190],
            Self::DarkInBoth => [86, 92, 104],
            Self::DarkOnlyInOccluded => [232, 80, 64],
            Self::DarkOnlyInIntersect => [255, 0, 255],
        }
    }

    /// The class that a class film stored.
    pub fn from_number(number: f32) -> Option<Self> {
        Self::ALL.into_iter().find(|c| f32::from(*c as u8) == number)
    }
}
