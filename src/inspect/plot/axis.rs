//! What an axis of a plot covers, where its ticks are, and how they are written.

use crate::inspect::numbers;

/// How values become places along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    #[default]
    Linear,
    Log2,
    Log10,
    /// Places are square roots, so that small heights can be seen beside large ones.
    Root,
}

impl Scale {
    pub fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log2 => value.log2(),
            Self::Log10 => value.log10(),
            Self::Root => value.max(0.0).sqrt(),
        }
    }

    /// The value at a place.
    pub fn value(self, place: f64) -> f64 {
        match self {
            Self::Linear => place,
            Self::Log2 => place.exp2(),
            Self::Log10 => 10f64.powf(place),
            Self::Root => place * place,
        }
    }
}

/// A mark along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// A place, not a value.
    pub at: f64,
    pub text: String,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What it counts; may be empty.
    pub label: String,
    /// Empty for plain counts.
    pub unit: String,
    pub scale: Scale,
    /// Its two ends, as places.
    pub range: [f64; 2],
    pub ticks: Vec<Tick>,
}

impl Axis {
    /// From zero to a little above `max`.
    pub fn from_zero(max: f64) -> Self {
        let max = if max.is_finite() && max > 0.0 { max } else { 1.0 };
        Self::linear([0.0, 1.06 * max], 4)
    }

    /// From zero to a little above `max`, by square roots.
    pub fn root_from_zero(max: f64) -> Self {
        let max = if max.is_finite() && max > 0.0 { max } else { 1.0 };
        let step = nice_step(max, 4);
        let ticks = [0.0, 0.25 * step].into_iter().chain((1..=4).map(|i| f64::from(i) * step));
        let ticks = ticks.filter(|value| *value <= max * 1.001);
        let ticks = ticks.map(|value| Tick { at: value.sqrt(), text: numbers::tick(value, 0.25 * step) });
        Self { scale: Scale::Root, ticks: ticks.collect(), ..Self::bare([0.0, (1.06 * max).sqrt()]) }
    }

    /// Around some values with a margin; not from zero, so that small changes are seen.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite()) {
            (lo, hi) = (lo.min(value), hi.max(value));
        }
        if lo > hi {
            (lo, hi) = (0.0, 1.0);
        }
        let margin = (0.1 * (hi - lo)).max(0.01 * hi.abs()).max(1e-9);
        let low = if lo >= 0.0 { (lo - margin).max(0.0) } else { lo - margin };
        Self::linear([low, hi + margin], 4)
    }

    /// Around positive values by their logarithm, with ticks at 1, 2 and 5 of each decade.
    pub fn log10_around(values: impl IntoIterator<Item = f64>) -> Self {
        let places = values.into_iter().filter(|value| *value > 0.0).map(f64::log10);
        let [low, high] =
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
        let [low, high] = if low <= high { [low, high] } else { [0.0, 1.0] };
        let margin = (0.1 * (high - low)).max(0.01);
        let range = [low - margin, high + margin];
        let (first, last) = (range[0].floor() as i32, range[1].ceil() as i32);
        let steps =
            (first..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|m: f64| m.log10() + f64::from(power)));
        let ticks = steps.filter(|at| (range[0]..=range[1]).contains(at));
        let ticks = ticks.map(|at| Tick { at, text: numbers::short(10f64.powf(at)) }).collect();
        Self { scale: Scale::Log10, ticks, ..Self::bare(range) }
    }

    /// With at most about `most` ticks at round numbers.
    pub fn linear(range: [f64; 2], most: usize) -> Self {
        let step = nice_step(range[1] - range[0], most);
        Self::with_step(range, step)
    }

    /// Whole numbers, each in the middle of its unit.
    pub fn integers(first: f64, last: f64, most: usize) -> Self {
        let step = nice_step(last - first + 1.0, most).max(1.0).round();
        let mut axis = Self::with_step([first, last], step);
        axis.range = [first - 0.6, last + 0.6];
        axis
    }

    /// Powers of two, over the logarithm to base 2.
    pub fn powers_of_two(first: u32, last: u32) -> Self {
        let ticks = (first..=last.min(62))
            .map(|power| Tick { at: f64::from(power), text: numbers::count(1u64 << power) });
        Self {
            scale: Scale::Log2,
            ticks: ticks.collect(),
            ..Self::bare([f64::from(first) - 0.2, f64::from(last) + 0.2])
        }
    }

    pub fn labelled(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }

    pub fn unit(self, unit: impl Into<String>) -> Self {
        Self { unit: unit.into(), ..self }
    }

    /// Label and unit, as in `build time (ms)`.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.label.clone() } else { format!("{} ({})", self.label, self.unit) }
    }

    fn bare(range: [f64; 2]) -> Self {
        Self { label: String::new(), unit: String::new(), scale: Scale::Linear, range, ticks: Vec::new() }
    }

    fn with_step(range: [f64; 2], step: f64) -> Self {
        let first = (range[0] / step).ceil() as i64;
        let last = (range[1] / step).floor() as i64;
        let ticks = (first..=last).map(|i| i as f64 * step);
        Self {
            ticks: ticks.map(|at| Tick { at, text: numbers::tick(at, step) }).collect(),
            ..Self::bare(range)
        }
    }
}

/// The smallest of 1, 2 or 5 times a power of ten that cuts `span` into at most `most` pieces.
fn nice_step(span: f64, most: usize) -> f64 {
    let raw = (span / most.max(1) as f64).max(1e-12);
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= raw * 0.999).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(axis: &Axis) -> Vec<f64> {
        axis.ticks.iter().map(|tick| tick.at).collect()
    }

    #[test]
    fn ticks_stand_at_round_numbers_within_the_range() {
        for (range, expected) in
            [([0.0, 10.0], vec![0.0, 5.0, 10.0]), ([0.13, 0.31], vec![0.15, 0.2, 0.25, 0.3])]
        {
            let ticks = places(&Axis::linear(range, 4));
            assert_eq!(ticks.len(), expected.len(), "{ticks:?}");
            assert!(ticks.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{ticks:?}");
        }
    }

    #[test]
    fn one_value_or_none_still_makes_an_axis() {
        let axes = [
            Axis::around([3.0]),
            Axis::around([]),
            Axis::around([0.0]),
            Axis::from_zero(f64::NAN),
            Axis::root_from_zero(0.0),
            Axis::log10_around([]),
            Axis::log10_around([5.0]),
        ];
        for axis in axes {
            assert!(axis.range[0] < axis.range[1] && axis.ticks.len() < 8, "{:?}", axis.range);
        }
        let axis = Axis::integers(0.0, 0.0, 6);
        assert_eq!((axis.range, places(&axis)), ([-0.6, 0.6], vec![0.0]));
    }

    #[test]
    fn scales_go_back_and_forth_and_ticks_say_values() {
        for scale in [Scale::Linear, Scale::Log2, Scale::Log10, Scale::Root] {
            assert!((scale.value(scale.place(7.5)) - 7.5).abs() < 1e-9, "{scale:?}");
        }
        let texts = |axis: Axis| axis.ticks.into_iter().map(|tick| tick.text).collect::<Vec<_>>();
        assert_eq!(texts(Axis::powers_of_two(1, 4)), ["2", "4", "8", "16"]);
        assert_eq!(
            texts(Axis::log10_around([1.0, 100.0])),
            ["1.00", "2.00", "5.00", "10.00", "20.00", "50.00", "100.0"]
        );
        assert_eq!(texts(Axis::root_from_zero(4000.0)), ["0", "250", "1,000", "2,000", "3,000", "4,000"]);
    }
}
