//! From linear light to what a display shows: tone curves and the sRGB transfer function (IEC 61966-2-1).

use std::sync::LazyLock;

use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// Largest value that a tone curve looks at; anything brighter is as white as it gets.
const BRIGHTEST: f32 = 1e6;

/// What the filmic curve multiplies light with first, so that middle grey (0.18) stays middle grey.
const FILMIC_EXPOSURE: f32 = 1.4619;

/// Cells of the table behind [`srgb8`]; fine enough that none holds two rounding thresholds.
const ENCODE_CELLS: usize = 4096;

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

    /// Maps linear light, 0 and up, to 0..=1, still linear. Negative values and NaN count as 0.
    #[inline]
    pub fn apply(self, color: Vec3) -> Vec3 {
        let color = color.map(|c| if c > 0.0 { c.min(BRIGHTEST) } else { 0.0 });
        match self {
            Self::Clamp => color.min(Vec3::ONE),
            Self::Reinhard => color / (Vec3::ONE + color),
            Self::Filmic => filmic(color),
        }
    }
}

/// Stephen Hill's fit of the ACES reference rendering and sRGB output transforms (2015, in the `BakingLab` of
/// Pettineo and Neubelt): a rational curve between two changes of primaries, which let bright colours turn white.
#[inline]
fn filmic(color: Vec3) -> Vec3 {
    const INTO: Mat3 = Mat3::from_cols(
        Vec3::new(0.59719, 0.07600, 0.02840),
        Vec3::new(0.35458, 0.90834, 0.13383),
        Vec3::new(0.04823, 0.01566, 0.83777),
    );
    const OUT_OF: Mat3 = Mat3::from_cols(
        Vec3::new(1.60475, -0.10208, -0.00327),
        Vec3::new(-0.53108, 1.10813, -0.07276),
        Vec3::new(-0.07367, -0.00605, 1.07602),
    );
    let v = INTO * (color * FILMIC_EXPOSURE);
    let curve = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    (OUT_OF * curve).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Encodes linear light in 0..=1 for a display.
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encodes linear light to 8 bits, rounded to nearest; clamps, and NaN gives 0. By table: a picture has millions.
#[inline]
pub fn srgb8(linear: Vec3) -> [u8; 3] {
    let table = &*ENCODE_TABLE;
    linear.to_array().map(|c| table.encode(c))
}

static ENCODE_TABLE: LazyLock<EncodeTable> = LazyLock::new(EncodeTable::new);

struct EncodeTable {
    /// The code of the smallest value in each cell of 0..1.
    first_code: Vec<u8>,
    /// `upper[code]`: the smallest value that is encoded as `code + 1`.
    upper: [f32; 256],
}

impl EncodeTable {
    fn new() -> Self {
        let mut upper: [f32; 256] = std::array::from_fn(|code| srgb_decode((code as f32 + 0.5) / 255.0));
        upper[255] = f32::INFINITY;
        let first_code = (0..=ENCODE_CELLS)
            .map(|cell| upper.partition_point(|&u| u <= cell as f32 / ENCODE_CELLS as f32) as u8)
            .collect();
        Self { first_code, upper }
    }

    #[inline]
    fn encode(&self, linear: f32) -> u8 {
        // NaN stays NaN, and the cast makes it 0.
        let x = linear.clamp(0.0, 1.0);
        let code = self.first_code[(x * ENCODE_CELLS as f32) as usize];
        if x >= self.upper[code as usize] { code + 1 } else { code }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_grey(tonemap: ToneMap, value: f32) -> f32 {
        let mapped = tonemap.apply(Vec3::splat(value));
        assert!(
            (mapped - Vec3::splat(mapped.x)).abs().max_element() < 2e-4,
            "{tonemap:?} tints grey: {mapped}"
        );
        mapped.x
    }

    #[test]
    fn every_curve_starts_black_rises_and_stays_within_one() {
        for tonemap in ToneMap::ALL {
            assert!(all_grey(tonemap, 0.0) < 1e-6);
            let mut last = 0.0;
            for step in 1..400 {
                let mapped = all_grey(tonemap, 0.03 * step as f32);
                assert!(mapped >= last - 1e-6 && mapped <= 1.0, "{tonemap:?} at step {step}: {mapped}");
                last = mapped;
            }
            assert!(last > 0.9, "{tonemap:?} ends at {last}");
        }
    }

    #[test]
    fn curves_have_their_known_values() {
        assert_eq!(ToneMap::Clamp.apply(Vec3::new(0.25, 1.0, 7.0)), Vec3::new(0.25, 1.0, 1.0));
        assert_eq!(ToneMap::Reinhard.apply(Vec3::new(1.0, 3.0, 0.0)), Vec3::new(0.5, 0.75, 0.0));
        assert!((all_grey(ToneMap::Filmic, 0.18) - 0.18).abs() < 1e-3);
    }

    #[test]
    fn a_bright_colour_turns_white_on_film_and_keeps_its_hue_when_clamped() {
        let red = Vec3::new(60.0, 6.0, 6.0);
        assert!(ToneMap::Filmic.apply(red).min_element() > 0.7);
        let dim = ToneMap::Filmic.apply(red / 100.0);
        assert!(dim.x > 4.0 * dim.y);
    }

    #[test]
    fn what_is_no_light_is_black_and_what_is_endless_is_white() {
        for tonemap in ToneMap::ALL {
            assert!(tonemap.apply(Vec3::new(f32::NAN, -1.0, f32::NEG_INFINITY)).max_element() < 1e-3);
            assert!(tonemap.apply(Vec3::INFINITY).min_element() > 0.999);
        }
    }

    #[test]
    fn encoding_and_decoding_are_inverse_and_meet_at_the_joint() {
        for code in 0..=255 {
            let encoded = code as f32 / 255.0;
            assert!((srgb_encode(srgb_decode(encoded)) - encoded).abs() < 1e-5);
        }
        assert!((srgb_encode(0.18) - 0.4613).abs() < 1e-3);
        assert!((srgb_encode(0.003_130_7) - srgb_encode(0.003_130_9)).abs() < 1e-5);
    }

    #[test]
    fn the_table_rounds_as_the_formula_does() {
        for i in 0..=200_000 {
            let x = i as f32 / 200_000.0;
            let exact = srgb_encode(x) * 255.0;
            let code = f32::from(srgb8(Vec3::splat(x))[0]);
            assert!((code - exact).abs() <= 0.501, "{x} became {code}, not {exact}");
        }
        assert_eq!(srgb8(Vec3::new(f32::NAN, -3.0, 9.0)), [0, 0, 255]);
    }
}
