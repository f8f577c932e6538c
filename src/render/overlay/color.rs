//! Colours of boxes: one ramp from cool to warm of nearly equal lightness, legible on dark and on bright pictures.
//!
//! Built in Oklch (Bjoern Ottosson, "A perceptual color space for image processing", 2020), so that equal steps look
//! equal.

use glam::Vec3;

use crate::render::tonemap::srgb8;
use crate::world::NodeFigure;

/// Boxes that the chosen colouring says nothing about.
pub const NEUTRAL_COLOR: [u8; 3] = [158, 162, 172];

/// Hue in degrees, lightness and chroma along the ramp: blue, teal, green, yellow, orange, rose.
const RAMP: [[f32; 3]; 6] = [
    [258.0, 0.66, 0.150],
    [205.0, 0.74, 0.120],
    [152.0, 0.78, 0.150],
    [100.0, 0.83, 0.155],
    [58.0, 0.76, 0.155],
    [12.0, 0.69, 0.175],
];

/// The share of the largest value at which a logarithmic ramp begins.
pub const SHARE_SPAN: f32 = 1e-4;

impl NodeFigure {
    /// Whether values lie on a logarithmic scale, since they span many orders.
    pub fn spans_decades(self) -> bool {
        matches!(self, Self::SahShare | Self::Epo | Self::Visits)
    }

    /// sRGB of a value between the two ends of `range` ([`super::Overlay::color_range`]): the figure of
    /// a node. NaN, which says nothing, is [`NEUTRAL_COLOR`].
    pub fn color(self, value: f32, range: [f32; 2]) -> [u8; 3] {
        if value.is_nan() { NEUTRAL_COLOR } else { ramp(self.position(value, range)) }
    }

    /// The values of the two ends of the colours, from those of all nodes; `None` if none has a number.
    pub fn range(self, values: &[f32]) -> Option<[f32; 2]> {
        self.range_up_to(values.iter().copied().fold(f32::NAN, f32::max))
    }

    /// [`NodeFigure::range`], from the largest value.
    pub fn range_up_to(self, most: f32) -> Option<[f32; 2]> {
        let range = match self {
            Self::Depth | Self::Overlap => [0.0, most],
            Self::LeafSize | Self::Visits => [1.0, most.max(1.0)],
            Self::SahShare | Self::Epo => [most * SHARE_SPAN, most],
            Self::EmptySpace | Self::Fill | Self::Unique => [0.0, 1.0],
        };
        let is_known = most >= 0.0 && !(self.spans_decades() && most <= 0.0);
        is_known.then_some(range)
    }

    /// Where a value lies between the two ends of `range`, in 0..=1.
    pub fn position(self, value: f32, [low, high]: [f32; 2]) -> f32 {
        let t = match self.spans_decades() {
            true => (value / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        // A range of one value, 0 / 0, is drawn in the first colour.
        if t > 0.0 { t.min(1.0) } else { 0.0 }
    }

    /// The value at `t` in 0..=1 between the two ends of `range`: for legends. The inverse of [`NodeFigure::position`].
    pub fn value_at(self, t: f32, [low, high]: [f32; 2]) -> f32 {
        match self.spans_decades() {
            true => low * (high / low).powf(t),
            false => low + t * (high - low),
        }
    }
}

/// sRGB of the boxes' ramp at `t` in 0..=1.
pub fn ramp(t: f32) -> [u8; 3] {
    let steps = (RAMP.len() - 1) as f32;
    let place = t.clamp(0.0, 1.0) * steps;
    let i = (place as usize).min(RAMP.len() - 2);
    let f = place - i as f32;
    let [hue, lightness, chroma] = std::array::from_fn(|k| RAMP[i][k] + f * (RAMP[i + 1][k] - RAMP[i][k]));
    let (sin, cos) = hue.to_radians().sin_cos();
    srgb8(linear_of_oklab(lightness, chroma * cos, chroma * sin))
}

fn linear_of_oklab(lightness: f32, a: f32, b: f32) -> Vec3 {
    let l = lightness + 0.396_337_78 * a + 0.215_803_76 * b;
    let m = lightness - 0.105_561_346 * a - 0.063_854_17 * b;
    let s = lightness - 0.089_484_18 * a - 1.291_485_5 * b;
    let (l, m, s) = (l * l * l, m * m * m, s * s * s);
    Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oklab_of_white_and_grey_is_grey() {
        assert!((linear_of_oklab(1.0, 0.0, 0.0) - Vec3::ONE).abs().max_element() < 1e-3);
        let grey = linear_of_oklab(0.5, 0.0, 0.0);
        assert!((grey - Vec3::splat(0.125)).abs().max_element() < 1e-3);
    }

    #[test]
    fn neighbours_on_the_ramp_can_be_told_apart() {
        for i in 0..20 {
            let (a, b) = (ramp(i as f32 / 20.0), ramp((i + 1) as f32 / 20.0));
            let step: i32 = a.iter().zip(b).map(|(&a, b)| (i32::from(a) - i32::from(b)).abs()).sum();
            assert!((8..140).contains(&step), "{a:?} to {b:?}");
        }
    }

    #[test]
    fn positions_and_values_are_inverse() {
        for color in NodeFigure::ALL {
            let range = [0.5, 80.0];
            for t in [0.0, 0.3, 1.0] {
                assert!((color.position(color.value_at(t, range), range) - t).abs() < 1e-5, "{color:?} {t}");
            }
            assert_eq!((color.position(0.1, range), color.position(1e9, range)), (0.0, 1.0));
            assert_eq!(color.color(3.0, [3.0, 3.0]), ramp(0.0));
        }
        assert_eq!(NodeFigure::LeafSize.color(f32::NAN, [1.0, 2.0]), NEUTRAL_COLOR);
    }
}
