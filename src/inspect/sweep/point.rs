//! One point of a sweep: settings, and a value in every column.

use crate::accel::BuildConfig;
use crate::inspect::columns::{COLUMNS, Column, Row, Value};
use crate::inspect::stats::TreeStats;

/// What is kept of a tree that was measured, by hundreds, in memory and in files.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// All settings that made the tree.
    pub config: BuildConfig,
    /// In the order of [`COLUMNS`].
    values: Vec<Value>,
}

impl SweepPoint {
    pub fn of(stats: &TreeStats) -> Self {
        Self::from_values(stats.config, |column| column.value(stats))
    }

    /// A point of values that were kept.
    pub fn from_values(config: BuildConfig, value: impl Fn(&'static Column) -> Value) -> Self {
        Self { config, values: COLUMNS.iter().map(value).collect() }
    }

    /// The number in the column of that key.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.value(Column::of(key)?).number()
    }

    pub fn name(&self) -> String {
        Column::of("name").map_or_else(String::new, |column| self.value(column).plain())
    }

    /// The same point under another name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        if let Some(i) = COLUMNS.iter().position(|c| c.key == "name") {
            self.values[i] = name.into();
        }
        self
    }

    /// Whether a frame was timed.
    pub fn is_timed(&self) -> bool {
        self.number("traversal_ms").is_some()
    }
}

impl Row for SweepPoint {
    fn value(&self, column: &Column) -> Value {
        let i = COLUMNS.iter().position(|c| c.key == column.key);
        i.map_or(Value::Missing, |i| self.values[i].clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_says_what_its_tree_says() {
        let stats = TreeStats::example("A");
        let point = SweepPoint::of(&stats);
        for column in COLUMNS {
            assert_eq!(column.value(&point), column.value(&stats), "{}", column.key);
        }
        assert_eq!((point.number("sah_cost"), point.is_timed()), (Some(12.5), false));
        assert_eq!(point.named("B").name(), "B");
    }
}
