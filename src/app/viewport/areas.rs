//! Where the viewport's pictures lie, in points and in whole pixels.

use egui::{Rect, Ui, pos2, vec2};

use crate::app::view::CompareStyle;

/// The parts of the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Areas {
    /// On whole pixels.
    pub whole: Rect,
    /// Its size in pixels.
    pub pixels: [u32; 2],
    style: Option<CompareStyle>,
    pixels_per_point: f32,
}

impl Areas {
    pub fn new(ui: &Ui, rect: Rect, style: Option<CompareStyle>) -> Self {
        let most = ui.input(|i| i.max_texture_side).min(16_384) as f32;
        Self::in_pixels(rect, style, ui.pixels_per_point(), most)
    }

    fn in_pixels(rect: Rect, style: Option<CompareStyle>, pixels_per_point: f32, most: f32) -> Self {
        let scale = pixels_per_point;
        let min = pos2((rect.min.x * scale).ceil() / scale, (rect.min.y * scale).ceil() / scale);
        // A little less than a whole pixel is a rounding error, not a missing pixel.
        let count = |points: f32| (points * scale + 1e-3).floor().clamp(0.0, most);
        let (width, height) = (count(rect.max.x - min.x), count(rect.max.y - min.y));
        let whole = Rect::from_min_size(min, vec2(width, height) / scale);
        Self { whole, pixels: [width as u32, height as u32], style, pixels_per_point }
    }

    /// Where the picture of a slot lies; `None` for one that there is not.
    pub fn slot(&self, slot: usize) -> Option<Rect> {
        match (self.style, slot) {
            (None, 0) => Some(self.whole),
            (Some(CompareStyle::Wipe | CompareStyle::Blink | CompareStyle::Difference), 0 | 1) => {
                Some(self.whole)
            }
            (Some(CompareStyle::SideBySide), 0 | 1) => {
                let width = (self.pixels[0] / 2) as f32 / self.pixels_per_point;
                let x = if slot == 0 { self.whole.left() } else { self.whole.right() - width };
                Some(Rect::from_min_size(pos2(x, self.whole.top()), vec2(width, self.whole.height())))
            }
            _ => None,
        }
    }

    /// Where the line of a wipe is, in points, on a whole pixel.
    pub fn wipe_x(&self, share: f32) -> f32 {
        let pixel = (share * self.pixels[0] as f32).round();
        self.whole.left() + pixel / self.pixels_per_point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_on_whole_pixels() {
        let rect = Rect::from_min_max(pos2(10.3, 20.0), pos2(411.0, 300.9));
        let areas = Areas::in_pixels(rect, None, 1.0, 16384.0);
        assert_eq!((areas.pixels, areas.whole.min), ([400, 280], pos2(11.0, 20.0)));
        let fine = Areas::in_pixels(rect, None, 1.5, 16384.0);
        assert_eq!(fine.whole.size() * 1.5, vec2(fine.pixels[0] as f32, fine.pixels[1] as f32));
        assert!(rect.contains_rect(fine.whole));
        assert_eq!(Areas::in_pixels(rect, None, 1.0, 64.0).pixels, [64, 64]);
    }

    #[test]
    fn two_pictures_side_by_side_are_equally_wide() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(401.0, 100.0));
        let areas = Areas::in_pixels(rect, Some(CompareStyle::SideBySide), 1.0, 16384.0);
        let (left, right) = (areas.slot(0).expect("left"), areas.slot(1).expect("right"));
        assert_eq!((left.width(), right.width()), (200.0, 200.0));
        assert!(left.right() <= right.left() && right.right() == 401.0);
        assert_eq!(areas.slot(2), None);
        let one = Areas::in_pixels(rect, None, 1.0, 16384.0);
        assert_eq!((one.slot(0), one.slot(1)), (Some(rect), None));
    }
}
