//! From a film to a picture of 8-bit sRGB: exposure and tone mapping, or a colour map over a range.

use glam::Vec3;
use image::RgbaImage;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::film::{Film, FilmContent};
use super::rank::nearest_ranks;
use super::shadow::ShadowClass;
use super::tonemap::{ToneMap, srgb8};
use super::views::ViewClass;

/// sRGB of a pixel of a film of numbers that has none: a miss.
pub const NO_NUMBER_COLOR: [u8; 3] = [24, 25, 29];

/// sRGB of heat values at or above the threshold.
pub const THRESHOLD_COLOR: [u8; 3] = [255, 122, 61];

/// The automatic range ends here: a few extreme pixels shall not darken all others.
const AUTO_RANGE_SHARE: f64 = 0.995;

/// Steps of the colour map that a picture is shown with; more than a display has shades.
const MAP_STEPS: usize = 1024;

/// Greys of heat values below a threshold, from the bottom of the range to its top.
const DIMMED: [f32; 2] = [34.0, 124.0];

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

    /// sRGB of `t` in 0..=1 (clamped; NaN counts as 0).
    pub fn color(self, t: f32) -> [u8; 3] {
        let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
        let gradient = match self {
            Self::Inferno => colorous::INFERNO,
            Self::Magma => colorous::MAGMA,
            Self::Plasma => colorous::PLASMA,
            Self::Viridis => colorous::VIRIDIS,
            Self::Cividis => colorous::CIVIDIS,
            Self::Turbo => colorous::TURBO,
            // Equal steps of the encoded value already look about equal; colorous has it from white to black.
            Self::Greys => return [(t * 255.0).round() as u8; 3],
        };
        gradient.eval_continuous(f64::from(t)).into_array()
    }
}

/// Where a number stands between the ends of the colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorScale {
    #[default]
    Linear,
    Log,
}

impl ColorScale {
    pub const ALL: [Self; 2] = [Self::Linear, Self::Log];

    /// The range over the number up to which the logarithmic scale is nearly linear: two decades. With three, what is a tenth
    /// of the range stands at two thirds, and heatmaps of small counts are bright all over.
    const SPAN: f32 = 100.0;

    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Log => "log",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Linear => "equal steps of the number are equal steps of colour",
            Self::Log => {
                "logarithmic over two decades of the range: small numbers stand apart beside a few large ones"
            }
        }
    }

    /// Where a number stands: 0 at the lower end of the range, 1 at the upper. Logarithmic it is
    /// `ln(1 + 100 s) / ln 101` with s the linear place, so that a range may begin at 0 or below.
    #[inline]
    pub fn place(self, value: f32, [low, high]: [f32; 2]) -> f32 {
        let share = (value - low) / (high - low).max(f32::MIN_POSITIVE);
        match self {
            Self::Linear => share,
            Self::Log => (Self::SPAN * share.max(0.0)).ln_1p() / Self::SPAN.ln_1p(),
        }
    }

    /// The number that stands at a place from 0 to 1.
    pub fn value_at(self, place: f32, [low, high]: [f32; 2]) -> f32 {
        let share = match self {
            Self::Linear => place,
            Self::Log => (place * Self::SPAN.ln_1p()).exp_m1() / Self::SPAN,
        };
        low + share * (high - low)
    }
}

/// How a film is shown. Changing it never renders again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DisplaySettings {
    pub colormap: ColorMap,
    pub scale: ColorScale,
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
            scale: ColorScale::default(),
            range: None,
            threshold: None,
            exposure: 0.0,
            tonemap: ToneMap::default(),
        }
    }
}

/// The range that a film of numbers is shown with: the set one, or the automatic one, which always has an extent. `None`
/// for a film of colours or classes, and for one without any number.
pub fn effective_range(film: &Film, settings: &DisplaySettings) -> Option<[f32; 2]> {
    let FilmContent::Number(sums) = &film.content else { return None };
    let class = film.subject.view.class();
    if class == ViewClass::Class || film.samples == 0 {
        return None;
    }
    let [lowest, high, highest] =
        nearest_ranks(sums, [0.0, AUTO_RANGE_SHARE, 1.0])?.map(|sum| sum / film.samples as f32);
    if settings.range.is_some() {
        return settings.range;
    }
    // Counts start at nothing; a difference of counts may lie below it.
    let low = if class == ViewClass::Heat { lowest.min(0.0) } else { lowest };
    let top = if high > low { high } else { highest };
    Some([low, if top > low { top } else { low + low.abs().max(1.0) }])
}

/// The picture, opaque. A film without samples is black.
pub fn picture(film: &Film, settings: &DisplaySettings) -> RgbaImage {
    let mut image = RgbaImage::from_pixel(film.width, film.height, image::Rgba([0, 0, 0, 255]));
    if film.samples == 0 {
        return image;
    }
    let mean = 1.0 / film.samples as f32;
    let class = film.subject.view.class();
    match &film.content {
        FilmContent::Color(sums) if class == ViewClass::Radiance => {
            let scale = mean * settings.exposure.exp2();
            fill(&mut image, sums, |sum: Vec3| srgb8(settings.tonemap.apply(sum * scale)));
        }
        FilmContent::Color(sums) => fill(&mut image, sums, |sum: Vec3| srgb8(sum * mean)),
        FilmContent::Number(sums) if class == ViewClass::Class => fill(&mut image, sums, |sum: f32| {
            ShadowClass::from_number(sum * mean).unwrap_or(ShadowClass::NotAsked).color()
        }),
        FilmContent::Number(sums) => {
            let range = effective_range(film, settings).unwrap_or([0.0, 1.0]);
            let threshold = settings.threshold.filter(|_| matches!(class, ViewClass::Heat | ViewClass::Leaf));
            let shades = Shades::new(settings, range, threshold);
            let samples = film.samples as f32;
            // Divided, not scaled: the same number that the film answers with, so that a threshold cuts exactly.
            fill(&mut image, sums, |sum: f32| shades.color(sum / samples));
        }
    }
    image
}

/// Colours every pixel from its sum, in parallel.
pub(super) fn fill<T: Copy + Sync>(image: &mut RgbaImage, sums: &[T], color: impl Fn(T) -> [u8; 3] + Sync) {
    const CHUNK: usize = 4096;
    let pixels: &mut [[u8; 4]] = bytemuck::cast_slice_mut(image.as_mut());
    pixels.par_chunks_mut(CHUNK).zip(sums.par_chunks(CHUNK)).for_each(|(pixels, sums)| {
        for (pixel, &sum) in pixels.iter_mut().zip(sums) {
            let [r, g, b] = color(sum);
            *pixel = [r, g, b, 255];
        }
    });
}

/// A colour map over a range, tabulated.
struct Shades {
    range: [f32; 2],
    scale: ColorScale,
    threshold: f32,
    colors: Vec<[u8; 3]>,
}

impl Shades {
    fn new(settings: &DisplaySettings, range: [f32; 2], threshold: Option<f32>) -> Self {
        let shade = |t: f32| match threshold {
            Some(_) => [(DIMMED[0] + t * (DIMMED[1] - DIMMED[0])) as u8; 3],
            None => settings.colormap.color(t),
        };
        Self {
            range,
            scale: settings.scale,
            threshold: threshold.unwrap_or(f32::INFINITY),
            colors: (0..MAP_STEPS).map(|i| shade(i as f32 / (MAP_STEPS - 1) as f32)).collect(),
        }
    }

    #[inline]
    fn color(&self, value: f32) -> [u8; 3] {
        if !value.is_finite() {
            return NO_NUMBER_COLOR;
        }
        if value >= self.threshold {
            return THRESHOLD_COLOR;
        }
        // A cast to an integer saturates, and takes NaN (an empty range) to 0.
        let step = (self.scale.place(value, self.range) * (MAP_STEPS - 1) as f32 + 0.5) as usize;
        self.colors[step.min(MAP_STEPS - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::FilmSubject;
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    fn film(view: View, samples: u32, content: FilmContent) -> Film {
        let width = match &content {
            FilmContent::Color(c) => c.len(),
            FilmContent::Number(n) => n.len(),
        } as u32;
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
        Film { width, height: 1, subject, samples, content }
    }

    fn numbers(view: View, values: &[f32]) -> Film {
        film(view, 1, FilmContent::Number(values.to_vec()))
    }

    fn pixels(film: &Film, settings: &DisplaySettings) -> Vec<[u8; 3]> {
        picture(film, settings)
            .pixels()
            .map(|p| {
                assert_eq!(p[3], 255);
                [p[0], p[1], p[2]]
            })
            .collect()
    }

    #[test]
    fn every_map_runs_from_dark_or_cool_to_light_and_clamps() {
        for map in ColorMap::ALL {
            let (low, high) = (map.color(0.0), map.color(1.0));
            assert_ne!(low, high, "{map:?}");
            assert_eq!((map.color(-3.0), map.color(f32::NAN), map.color(9.0)), (low, low, high), "{map:?}");
        }
        assert_eq!((ColorMap::Greys.color(0.0), ColorMap::Greys.color(1.0)), ([0; 3], [255; 3]));
        assert!(ColorMap::Inferno.color(0.0).iter().all(|&c| c < 10));
    }

    #[test]
    fn without_samples_it_is_black() {
        let empty = film(View::Path, 0, FilmContent::Color(vec![Vec3::ONE; 2]));
        assert_eq!(pixels(&empty, &DisplaySettings::default()), [[0; 3]; 2]);
    }

    #[test]
    fn exposure_and_tone_curve_touch_light_only() {
        let light = vec![Vec3::splat(0.25)];
        let brighter = DisplaySettings { exposure: 1.0, tonemap: ToneMap::Clamp, ..Default::default() };
        let radiance = film(View::Whitted, 2, FilmContent::Color(light.clone()));
        assert_eq!(pixels(&radiance, &brighter), [srgb8(Vec3::splat(0.25))]);
        let albedo = film(View::Albedo, 1, FilmContent::Color(light));
        assert_eq!(pixels(&albedo, &brighter), [srgb8(Vec3::splat(0.25))]);
    }

    #[test]
    fn heat_starts_at_zero_and_distance_at_the_nearest() {
        let settings = DisplaySettings::default();
        let values: Vec<f32> = (1..=1000).map(|i| i as f32).chain([f32::NAN, f32::INFINITY]).collect();
        assert_eq!(effective_range(&numbers(View::NodesVisited, &values), &settings), Some([0.0, 995.0]));
        assert_eq!(effective_range(&numbers(View::Depth, &values), &settings), Some([1.0, 995.0]));
        let twice = film(View::Depth, 2, FilmContent::Number(values));
        assert_eq!(effective_range(&twice, &settings), Some([0.5, 497.5]));
    }

    #[test]
    fn a_range_has_an_extent_even_where_values_do_not() {
        let settings = DisplaySettings::default();
        assert_eq!(effective_range(&numbers(View::NodesVisited, &[0.0; 3]), &settings), Some([0.0, 1.0]));
        assert_eq!(effective_range(&numbers(View::Depth, &[7.0; 3]), &settings), Some([7.0, 14.0]));
        let mut values = vec![0.0; 1000];
        values[3] = 5.0;
        assert_eq!(effective_range(&numbers(View::LeafVisits, &values), &settings), Some([0.0, 5.0]));
    }

    #[test]
    fn only_films_of_numbers_have_a_range() {
        let set = DisplaySettings { range: Some([2.0, 3.0]), ..Default::default() };
        assert_eq!(effective_range(&numbers(View::Depth, &[1.0]), &set), Some([2.0, 3.0]));
        assert_eq!(effective_range(&numbers(View::Depth, &[f32::NAN]), &set), None);
        assert_eq!(effective_range(&numbers(View::ShadowDifference, &[1.0]), &set), None);
        assert_eq!(effective_range(&film(View::Path, 1, FilmContent::Color(vec![Vec3::ONE])), &set), None);
    }

    #[test]
    fn numbers_go_through_the_map_and_misses_do_not() {
        let settings = DisplaySettings { range: Some([0.0, 2.0]), ..Default::default() };
        let heat = numbers(View::BoxTests, &[0.0, 1.0, 2.0, 50.0, -4.0, f32::NAN]);
        let map = |t| settings.colormap.color(t);
        let shown = pixels(&heat, &settings);
        assert_eq!((shown[0], shown[2], shown[3], shown[4]), (map(0.0), map(1.0), map(1.0), map(0.0)));
        assert!(shown[1].iter().zip(map(0.5)).all(|(a, b)| a.abs_diff(b) <= 2));
        assert_eq!(shown[5], NO_NUMBER_COLOR);
    }

    #[test]
    fn a_logarithmic_scale_tells_small_numbers_apart() {
        let range = [0.0, 1000.0];
        for scale in ColorScale::ALL {
            assert_eq!((scale.place(0.0, range), scale.place(1000.0, range)), (0.0, 1.0), "{scale:?}");
            for place in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let there = scale.place(scale.value_at(place, [-3.0, 40.0]), [-3.0, 40.0]);
                assert!((there - place).abs() < 1e-4, "{scale:?} {place} {there}");
            }
        }
        // At a tenth: ln(11) / ln(101).
        assert!((ColorScale::Log.place(100.0, range) - 0.51957).abs() < 1e-4);
        let settings = DisplaySettings { range: Some(range), scale: ColorScale::Log, ..Default::default() };
        let shown = pixels(&numbers(View::BoxTests, &[0.0, 100.0, 1000.0, -5.0, 5000.0]), &settings);
        let map = |t| settings.colormap.color(t);
        assert_eq!((shown[0], shown[2], shown[3], shown[4]), (map(0.0), map(1.0), map(0.0), map(1.0)));
        assert!(shown[1].iter().zip(map(0.51957)).all(|(a, b)| a.abs_diff(b) <= 2));
    }

    #[test]
    fn a_threshold_marks_from_its_value_on_and_greys_the_rest() {
        let settings =
            DisplaySettings { range: Some([0.0, 2.0]), threshold: Some(1.0), ..Default::default() };
        let shown = pixels(&numbers(View::BoxTests, &[0.0, 0.999, 1.0, 2.0, f32::NAN]), &settings);
        assert!(shown[..2].iter().all(|c| c[0] == c[1] && c[1] == c[2] && c[0] < 130));
        assert_eq!(shown[2..], [THRESHOLD_COLOR, THRESHOLD_COLOR, NO_NUMBER_COLOR]);
        let depth = pixels(&numbers(View::Depth, &[0.0, 2.0]), &settings);
        assert_eq!(depth[1], settings.colormap.color(1.0));
    }

    #[test]
    fn classes_have_their_own_colours() {
        let all = ShadowClass::ALL.map(|c| f32::from(c as u8));
        let shown = pixels(&numbers(View::ShadowDifference, &all), &DisplaySettings::default());
        assert_eq!(shown, ShadowClass::ALL.map(ShadowClass::color));
    }
}
