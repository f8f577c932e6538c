//! What a film of differences adds up to: its histogram around zero, and how many pixels are better in B.

use rayon::prelude::*;
use serde::Serialize;

use super::columns::Better;
use super::histogram::Histogram;
use crate::render::difference::Difference;
use crate::render::{View, ViewClass};

/// Bars of the histogram of numbers that are not whole; odd, so that the one in the middle is around zero.
const BARS: usize = 65;

/// Counts that differ by no more than this have a bar for each difference.
const MOST_WHOLE: f32 = 100.0;

/// B - A over all pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceSummary {
    /// Around zero, as far as the colours go; what lies outside falls into the outer bars.
    pub histogram: Histogram,
    /// The size of a difference that has the full colour of its side ([`Difference::limit`]).
    pub limit: f32,
    /// Which side of zero is better for B.
    #[serde(skip)]
    pub better: Better,
    /// Pixels where B has less than A, as much, and more.
    pub lower_count: u64,
    pub equal_count: u64,
    pub higher_count: u64,
    /// Pixels where one of the two has no number.
    pub missing_count: u64,
}

impl DifferenceSummary {
    /// `None` where no pixel has a difference.
    pub fn of(difference: &Difference, view: View) -> Option<Self> {
        let limit = difference.limit();
        // Where differences are whole numbers, bars of another width would hold now one, now two of them.
        let is_whole = view != View::Depth && limit.fract() == 0.0 && limit <= MOST_WHOLE;
        let (bars, end) = if is_whole { (2 * limit as usize + 1, limit + 0.5) } else { (BARS, limit) };
        let histogram = Histogram::of(&difference.values, bars, Some([-end, end]))?;
        let count = |is: fn(f32) -> bool| difference.values.par_iter().filter(|d| is(**d)).count() as u64;
        Some(Self {
            histogram,
            limit,
            better: better(view),
            lower_count: count(|d| d < 0.0),
            equal_count: count(|d| d == 0.0),
            higher_count: count(|d| d > 0.0),
            missing_count: count(f32::is_nan),
        })
    }

    /// Pixels where B is better, and where it is worse; `None` where neither direction is.
    pub fn better_and_worse(&self) -> Option<[u64; 2]> {
        match self.better {
            Better::Lower => Some([self.lower_count, self.higher_count]),
            Better::Higher => Some([self.higher_count, self.lower_count]),
            Better::Neither => None,
        }
    }

    /// Pixels with a difference.
    pub fn pixel_count(&self) -> u64 {
        self.lower_count + self.equal_count + self.higher_count
    }

    /// What is said of the pixels, in words.
    pub fn shares(&self) -> String {
        let share = |count: u64| format!("{:.1} %", 100.0 * count as f64 / self.pixel_count().max(1) as f64);
        let [first, second] = match self.better {
            Better::Lower => [("better", self.lower_count), ("worse", self.higher_count)],
            Better::Higher => [("better", self.higher_count), ("worse", self.lower_count)],
            Better::Neither => [("less", self.lower_count), ("more", self.higher_count)],
        };
        format!(
            "of the pixels {} are {} in B, {} equal, {} {}",
            share(first.1),
            first.0,
            share(self.equal_count),
            share(second.1),
            second.0
        )
    }
}

/// Which of two values of a pixel is the better one.
pub fn better(view: View) -> Better {
    match (view.class(), view) {
        (ViewClass::Heat, View::ShadowSaving) => Better::Higher,
        (ViewClass::Heat, _) => Better::Lower,
        (
            ViewClass::Radiance | ViewClass::Data | ViewClass::Distance | ViewClass::Leaf | ViewClass::Class,
            _,
        ) => Better::Neither,
    }
}

/// Views whose pixels can be subtracted.
pub fn has_difference(view: View) -> bool {
    matches!(view.class(), ViewClass::Heat | ViewClass::Leaf | ViewClass::Distance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(values: &[f32], view: View) -> Option<DifferenceSummary> {
        let difference = Difference { width: values.len() as u32, height: 1, values: values.to_vec() };
        DifferenceSummary::of(&difference, view)
    }

    #[test]
    fn pixels_are_counted_on_either_side_of_zero() {
        let values = [-2.0, -1.0, -1.0, 0.0, 0.0, 5.0, f32::NAN];
        let s = summary(&values, View::NodesVisited).expect("differences");
        assert_eq!((s.lower_count, s.equal_count, s.higher_count, s.missing_count), (3, 2, 1, 1));
        assert_eq!(s.better_and_worse(), Some([3, 1]));
        assert_eq!(s.pixel_count(), 6);
        assert_eq!(s.shares(), "of the pixels 50.0 % are better in B, 33.3 % equal, 16.7 % worse");
        assert_eq!(summary(&values, View::ShadowSaving).and_then(|s| s.better_and_worse()), Some([1, 3]));
        assert_eq!(summary(&values, View::Depth).and_then(|s| s.better_and_worse()), None);
    }

    #[test]
    fn the_histogram_lies_around_zero() {
        let s = summary(&[-4.0, 0.0, 0.0, 1.0], View::RayCost).expect("differences");
        assert_eq!((s.limit, s.histogram.range), (4.0, [-4.5, 4.5]));
        assert_eq!(s.histogram.counts, [1, 0, 0, 0, 2, 1, 0, 0, 0], "a bar for each whole number");
        assert_eq!((s.histogram.value_count, s.histogram.mean), (4, -0.75));
        let s = summary(&[-4.25, 0.0, 0.0, 1.0], View::RayCost).expect("differences");
        assert_eq!((s.limit, s.histogram.range), (4.25, [-4.25, 4.25]));
        assert_eq!((s.histogram.counts[BARS / 2], s.histogram.counts[0]), (2, 1));
    }

    #[test]
    fn without_a_difference_there_is_nothing_to_say_and_equal_films_are_equal() {
        assert_eq!(summary(&[f32::NAN], View::Depth), None);
        let s = summary(&[0.0; 5], View::RayCost).expect("differences");
        assert_eq!((s.equal_count, s.limit, &s.histogram.counts[..]), (5, 1.0, &[0, 5, 0][..]));
    }
}
