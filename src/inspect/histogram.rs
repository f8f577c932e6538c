//! A histogram with order statistics.

use rayon::prelude::*;
use serde::Serialize;

use crate::render::rank::nearest_ranks;

/// Values summed at a time: few enough that the sum is exact enough, and always the same ones, at any thread count.
const CHUNK: usize = 1 << 16;

/// Counts in equal bins, and what is asked of a heatmap. Percentiles by nearest rank.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Values at the two ends.
    pub range: [f32; 2],
    pub counts: Vec<u64>,
    /// Finite values seen.
    pub value_count: u64,
    pub min: f32,
    pub max: f32,
    pub mean: f64,
    pub median: f32,
    pub p95: f32,
    pub p99: f32,
}

impl Histogram {
    /// Over the finite values; `None` if there is none. `range`: `None` for min to max; values outside fall into the
    /// first or the last bin. At least one bin.
    pub fn of(values: &[f32], bins: usize, range: Option<[f32; 2]>) -> Option<Self> {
        let [min, median, p95, p99, max] = nearest_ranks(values, [0.0, 0.5, 0.95, 0.99, 1.0])?;
        let range = range.unwrap_or([min, max]);
        let binning = Binning::new(range, bins.max(1));
        let parts: Vec<Part> = values.par_chunks(CHUNK).map(|chunk| binning.count(chunk)).collect();
        let mut counts = vec![0; binning.bins];
        for part in &parts {
            counts.iter_mut().zip(&part.counts).for_each(|(sum, &n)| *sum += u64::from(n));
        }
        let value_count: u64 = counts.iter().sum();
        let mean = parts.iter().map(|part| part.sum).sum::<f64>() / value_count as f64;
        Some(Self { range, counts, value_count, min, max, mean, median, p95, p99 })
    }

    /// The values at the two ends of a bin.
    pub fn bin_range(&self, bin: usize) -> [f64; 2] {
        let [low, high] = self.range.map(f64::from);
        let at = |i: usize| low + (high - low) * i as f64 / self.counts.len() as f64;
        [at(bin), at(bin + 1)]
    }
}

struct Binning {
    bins: usize,
    low: f64,
    /// Bins a unit; 0 where the range has no extent, which puts everything into the first bin.
    scale: f64,
}

struct Part {
    counts: Vec<u32>,
    sum: f64,
}

impl Binning {
    fn new([low, high]: [f32; 2], bins: usize) -> Self {
        let (low, high) = (f64::from(low), f64::from(high));
        let scale = if high > low { bins as f64 / (high - low) } else { 0.0 };
        Self { bins, low, scale }
    }

    fn count(&self, values: &[f32]) -> Part {
        let mut part = Part { counts: vec![0; self.bins], sum: 0.0 };
        for value in values.iter().filter(|v| v.is_finite()).map(|&v| f64::from(v)) {
            // The cast takes everything below the range to 0.
            let bin = ((value - self.low) * self.scale) as usize;
            part.counts[bin.min(self.bins - 1)] += 1;
            part.sum += value;
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_means_and_ranks_of_known_values() {
        let values: Vec<f32> = (1..=100).map(|i| i as f32).chain([f32::NAN, f32::INFINITY]).collect();
        let h = Histogram::of(&values, 10, Some([0.0, 100.0])).expect("finite values");
        assert_eq!((h.value_count, h.min, h.max, h.mean), (100, 1.0, 100.0, 50.5));
        assert_eq!((h.median, h.p95, h.p99), (50.0, 95.0, 99.0));
        // 1..=9, then tens; 100 belongs to the last bin.
        assert_eq!(h.counts, [9, 10, 10, 10, 10, 10, 10, 10, 10, 11]);
        assert_eq!(h.bin_range(9), [90.0, 100.0]);
    }

    #[test]
    fn what_lies_outside_falls_into_the_end_bins() {
        let h = Histogram::of(&[-5.0, 0.5, 1.5, 9.0, 3e38], 2, Some([0.0, 2.0])).expect("finite values");
        assert_eq!(h.counts, [2, 3]);
    }

    #[test]
    fn one_value_and_no_value() {
        let h = Histogram::of(&[4.0; 7], 8, None).expect("finite values");
        assert_eq!((h.range, h.counts[0], h.mean, h.p99), ([4.0, 4.0], 7, 4.0, 4.0));
        assert_eq!(Histogram::of(&[f32::NAN], 8, None), None);
        assert_eq!(Histogram::of(&[], 8, None), None);
    }

    #[test]
    fn a_huge_range_does_not_overflow() {
        let h = Histogram::of(&[-3e38, 3e38, 0.0], 2, None).expect("finite values");
        assert_eq!((h.counts, h.mean), (vec![1, 2], 0.0));
    }
}
