//! The program's dark and light looks.

use egui::Color32;

/// Colours that panels use besides egui's own visuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette {
    pub dark: bool,
    /// The one colour that draws the eye: the current value, the selection.
    pub accent: Color32,
    /// A second series in a plot.
    pub second: Color32,
    /// A third series.
    pub third: Color32,
    pub good: Color32,
    pub warning: Color32,
    pub error: Color32,
    /// Quiet text: units, captions.
    pub muted: Color32,
}

impl Palette {
    pub fn dark() -> Self {
        Self {
            dark: true,
            accent: Color32::from_rgb(94, 178, 255),
            second: Color32::from_rgb(255, 176, 84),
            third: Color32::from_rgb(150, 220, 140),
            good: Color32::from_rgb(122, 204, 130),
            warning: Color32::from_rgb(240, 190, 90),
            error: Color32::from_rgb(240, 110, 100),
            muted: Color32::from_rgb(140, 146, 158),
        }
    }

    pub fn light() -> Self {
        Self {
            dark: false,
            accent: Color32::from_rgb(20, 104, 190),
            second: Color32::from_rgb(190, 100, 10),
            third: Color32::from_rgb(50, 130, 60),
            good: Color32::from_rgb(40, 130, 60),
            warning: Color32::from_rgb(160, 110, 0),
            error: Color32::from_rgb(190, 40, 40),
            muted: Color32::from_rgb(100, 106, 116),
        }
    }
}
