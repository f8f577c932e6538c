//! From linear light to what a display shows.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A tone curve, applied after exposure and before sRGB encoding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToneMap {
    Clamp,
    Reinhard,
    #[default]
    Filmic,
}

impl ToneMap {
    pub const ALL: [Self; 3] = [Self::Clamp, Self::Reinhard, Self::Filmic];

    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Clamp => "values above 1 are cut off",
            Self::Reinhard => "c / (1 + c): nothing is cut off, highlights are compressed",
            Self::Filmic => "a film-like curve with a toe and a soft shoulder",
        }
    }

    /// Maps linear light, 0 and up, to 0..=1, still linear.
    pub fn apply(self, color: Vec3) -> Vec3 {
        let _ = color;
        todo!()
    }
}
