//! From a film to what the screen shows of it: the picture, the range of its numbers, their histogram.

use egui::ColorImage;

use crate::inspect::histogram::Histogram;
use crate::render::display::{effective_range, picture};
use crate::render::{DisplaySettings, Film};

/// Bars of a heatmap's histogram.
const HISTOGRAM_BINS: usize = 64;

/// A film made visible.
#[derive(Clone, Debug)]
pub struct Presented {
    /// With which settings.
    pub display: DisplaySettings,
    pub image: std::sync::Arc<ColorImage>,
    /// That the colour map covers.
    pub range: Option<[f32; 2]>,
    /// That it covers if no range is set.
    pub own_range: Option<[f32; 2]>,
    /// Of all numbers of the film.
    pub histogram: Option<Histogram>,
}

/// Runs in the current rayon pool.
pub fn present(film: &Film, display: &DisplaySettings) -> Presented {
    let image = picture(film, display);
    let own_range = effective_range(film, &DisplaySettings { range: None, ..*display });
    let size = [image.width() as usize, image.height() as usize];
    Presented {
        display: *display,
        // Opaque, so that premultiplied and not are the same.
        image: ColorImage::from_rgba_premultiplied(size, image.as_raw()).into(),
        range: own_range.map(|own| display.range.unwrap_or(own)),
        own_range,
        histogram: film.numbers().and_then(|numbers| Histogram::of(&numbers, HISTOGRAM_BINS, None)),
    }
}
