//! Two films of numbers held against each other: B - A of every pixel, its colours, and one range that both are shown
//! with.

use image::RgbaImage;

use super::display::{DisplaySettings, NO_NUMBER_COLOR, effective_range, fill};
use super::film::Film;
use super::rank::nearest_ranks;
use super::views::ViewClass;

/// The colours end here: a few extreme pixels shall not take the colour from all others.
const LIMIT_SHARE: f64 = 0.995;

/// Steps of the colour map on either side of zero.
const STEPS: usize = 512;

/// B - A of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    pub width: u32,
    pub height: u32,
    /// Row by row from the top left; NaN where one of the two has no number.
    pub values: Vec<f32>,
}

impl Difference {
    /// `None` unless both films hold numbers of the same thing, are of one size, and have a sample at least.
    pub fn of(a: &Film, b: &Film) -> Option<Self> {
        let measures = matches!(a.subject.view.class(), ViewClass::Heat | ViewClass::Distance);
        let same = a.subject == b.subject && (a.width, a.height) == (b.width, b.height);
        if !measures || !same || a.samples == 0 || b.samples == 0 {
            return None;
        }
        let values = a.numbers()?.into_iter().zip(b.numbers()?).map(|(a, b)| subtract(a, b)).collect();
        Some(Self { width: a.width, height: a.height, values })
    }

    /// The difference of a pixel; `None` outside, or where there is none.
    pub fn at(&self, x: u32, y: u32) -> Option<f32> {
        let inside = x < self.width && y < self.height;
        inside.then(|| self.values[(y * self.width + x) as usize]).filter(|d| d.is_finite())
    }

    /// The size of a difference that has the full colour of its side: 99.5 of 100 pixels differ by no more. Where that is
    /// nothing, the largest one, and 1 where all are equal. Always above zero.
    pub fn limit(&self) -> f32 {
        let sizes: Vec<f32> = self.values.iter().map(|d| d.abs()).collect();
        match nearest_ranks(&sizes, [LIMIT_SHARE, 1.0]) {
            Some([high, _]) if high > 0.0 => high,
            Some([_, highest]) if highest > 0.0 => highest,
            Some(_) | None => 1.0,
        }
    }

    /// The picture, opaque: no colour at zero, full colour at `limit` and beyond.
    pub fn picture(&self, limit: f32) -> RgbaImage {
        let colors: Vec<[u8; 3]> =
            (0..=2 * STEPS).map(|i| difference_color(i as f32 / STEPS as f32 - 1.0)).collect();
        let scale = STEPS as f32 / limit;
        let mut image = RgbaImage::new(self.width, self.height);
        fill(&mut image, &self.values, |d: f32| {
            if !d.is_finite() {
                return NO_NUMBER_COLOR;
            }
            let step = (d * scale).clamp(-(STEPS as f32), STEPS as f32).round();
            colors[(step + STEPS as f32) as usize]
        });
        image
    }
}

/// Endless on both sides is no difference that could be said.
fn subtract(a: f32, b: f32) -> f32 {
    let difference = b - a;
    if difference.is_finite() { difference } else { f32::NAN }
}

/// sRGB of a difference from -1 (B has less: blue) over 0 (white) to 1 (B has more: red); clamped, NaN counts as 0. The
/// map is ColorBrewer's RdBu, which the colour-blind can tell apart.
pub fn difference_color(t: f32) -> [u8; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(-1.0, 1.0) };
    // It runs from red to blue.
    colorous::RED_BLUE.eval_continuous(0.5 - 0.5 * f64::from(t)).into_array()
}

/// The range that two films are shown with so that equal colours are equal numbers: the set one, or from the lower to the
/// higher end of their own. `None` where neither has one.
pub fn shared_range(films: [&Film; 2], settings: &DisplaySettings) -> Option<[f32; 2]> {
    union(films.map(|film| effective_range(film, settings)))
}

/// From the lower to the higher end of both ranges.
pub fn union(ranges: [Option<[f32; 2]>; 2]) -> Option<[f32; 2]> {
    ranges.into_iter().flatten().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::{FilmContent, FilmSubject};
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    fn film(view: View, samples: u32, sums: &[f32]) -> Film {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
        let content = FilmContent::Number(sums.to_vec());
        Film { width: sums.len() as u32, height: 1, subject, samples, content }
    }

    #[test]
    fn every_pixel_is_b_minus_a_of_the_means() {
        let a = film(View::NodesVisited, 2, &[2.0, 8.0, 6.0, f32::NAN, f32::INFINITY]);
        let b = film(View::NodesVisited, 1, &[4.0, 1.0, 3.0, 5.0, f32::INFINITY]);
        let difference = Difference::of(&a, &b).expect("two heatmaps");
        assert_eq!(difference.values[..3], [3.0, -3.0, 0.0]);
        assert_eq!((difference.at(0, 0), difference.at(3, 0), difference.at(4, 0)), (Some(3.0), None, None));
        assert_eq!((difference.at(5, 0), difference.at(0, 1)), (None, None));
        let back = Difference::of(&b, &a).expect("two heatmaps");
        assert!(back.values.iter().zip(&difference.values).take(3).all(|(b, d)| *b == -d));
    }

    #[test]
    fn only_numbers_of_the_same_thing_can_be_subtracted() {
        let heat = film(View::NodesVisited, 1, &[1.0, 2.0]);
        for other in [
            film(View::BoxTests, 1, &[1.0, 2.0]),
            film(View::NodesVisited, 1, &[1.0]),
            film(View::NodesVisited, 0, &[1.0, 2.0]),
        ] {
            assert_eq!(Difference::of(&heat, &other), None);
            assert_eq!(Difference::of(&other, &heat), None);
        }
        let classes = film(View::ShadowDifference, 1, &[1.0, 2.0]);
        assert_eq!(Difference::of(&classes, &classes), None);
        let light = Film::new(2, 1, FilmSubject { view: View::Path, ..heat.subject });
        assert_eq!(Difference::of(&light, &light), None);
    }

    #[test]
    fn colours_are_symmetric_around_white_and_red_is_more() {
        let (less, none, more) = (difference_color(-1.0), difference_color(0.0), difference_color(1.0));
        assert!(none.iter().all(|c| *c > 235), "{none:?}");
        assert!(more[0] > 2 * more[2] && less[2] > 2 * less[0], "{more:?} {less:?}");
        assert_eq!(
            (difference_color(7.0), difference_color(-7.0), difference_color(f32::NAN)),
            (more, less, none)
        );
        let values = vec![-4.0, -2.0, 0.0, 2.0, 4.0, 100.0, f32::NAN];
        let picture = Difference { width: 7, height: 1, values }.picture(4.0);
        let shown: Vec<[u8; 3]> = picture.pixels().map(|p| [p[0], p[1], p[2]]).collect();
        let half = [difference_color(-0.5), difference_color(0.5)];
        assert_eq!(shown, [less, half[0], none, half[1], more, more, NO_NUMBER_COLOR]);
    }

    #[test]
    fn the_limit_leaves_out_extremes_and_is_never_zero() {
        let of = |values: Vec<f32>| Difference { width: values.len() as u32, height: 1, values }.limit();
        let mut values: Vec<f32> = (1..=1000).map(|i| -(i as f32)).collect();
        assert_eq!(of(values.clone()), 995.0);
        values.fill(0.0);
        assert_eq!(of(values.clone()), 1.0);
        values[7] = -3.0;
        assert_eq!(of(values), 3.0);
        assert_eq!(of(vec![f32::NAN]), 1.0);
    }

    #[test]
    fn both_sides_are_shown_on_the_union_of_their_ranges_or_on_the_set_one() {
        let (a, b) = (film(View::Depth, 1, &[3.0, 8.0]), film(View::Depth, 1, &[5.0, 20.0]));
        let none = film(View::Depth, 1, &[f32::NAN]);
        let auto = DisplaySettings::default();
        assert_eq!(shared_range([&a, &b], &auto), Some([3.0, 20.0]));
        assert_eq!(shared_range([&b, &none], &auto), Some([5.0, 20.0]));
        assert_eq!(shared_range([&none, &none], &auto), None);
        let set = DisplaySettings { range: Some([1.0, 2.0]), ..auto };
        assert_eq!(shared_range([&a, &b], &set), Some([1.0, 2.0]));
    }
}
