//! A histogram with order statistics.

use serde::Serialize;

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
    /// first or the last bin.
    pub fn of(values: &[f32], bins: usize, range: Option<[f32; 2]>) -> Option<Self> {
        let _ = (values, bins, range);
        todo!()
    }
}
