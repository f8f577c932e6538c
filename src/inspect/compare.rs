//! Two settings side by side: every figure of A, of B, their difference and its percentage.

use serde::{Serialize, Serializer};

use super::columns::{Better, COLUMNS, Column, Row, Value};
use super::paired_cost::PairedRayCost;
use super::stats::TreeStats;

/// A, B, and what differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    pub a: TreeStats,
    pub b: TreeStats,
    pub rows: Vec<ComparedFigure>,
    /// Of the camera rays, ray by ray; `None` where it was not measured.
    pub ray_cost: Option<PairedRayCost>,
}

/// One figure or setting of both.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedFigure {
    #[serde(serialize_with = "key_of")]
    pub column: &'static Column,
    pub a: Value,
    pub b: Value,
    /// B - A; `None` unless both are numbers.
    pub difference: Option<f64>,
    /// Of A; `None` where A is zero.
    pub percent: Option<f64>,
    /// Whether B is better than A; `None` where they are equal, or neither direction is better.
    pub better: Option<bool>,
}

impl PartialEq for ComparedFigure {
    fn eq(&self, other: &Self) -> bool {
        self.column.key == other.column.key && self.a == other.a && self.b == other.b
    }
}

impl Comparison {
    /// Holds two trees against each other, column by column (all but their names).
    pub fn of(a: TreeStats, b: TreeStats) -> Self {
        let rows = ComparedFigure::all(&a, &b);
        Self { a, b, rows, ray_cost: None }
    }

    /// Whether A and B weigh visits and tests by the same costs. If not, SAH costs and ray costs have different units.
    pub fn has_one_unit(&self) -> bool {
        let costs = |stats: &TreeStats| [stats.config.traversal_cost, stats.config.intersection_cost];
        costs(&self.a) == costs(&self.b)
    }
}

impl ComparedFigure {
    /// Every column of both but their names.
    pub fn all(a: &impl Row, b: &impl Row) -> Vec<Self> {
        COLUMNS.iter().filter(|c| c.key != "name").map(|c| Self::of(c, a, b)).collect()
    }

    fn of(column: &'static Column, a: &impl Row, b: &impl Row) -> Self {
        let (a, b) = (column.value(a), column.value(b));
        let numbers = a.number().zip(b.number());
        let difference = numbers.map(|(a, b)| b - a);
        let percent = numbers.filter(|(a, _)| *a != 0.0).map(|(a, b)| 100.0 * (b - a) / a.abs());
        let better = difference.filter(|&d| d != 0.0).and_then(|d| match column.better {
            Better::Lower => Some(d < 0.0),
            Better::Higher => Some(d > 0.0),
            Better::Neither => None,
        });
        Self { column, a, b, difference, percent, better }
    }

    /// Whether A and B say the same.
    pub fn is_equal(&self) -> bool {
        self.a == self.b
    }

    /// The percentage for people, with its sign, as in `+12.5 %`; empty where there is none.
    pub fn shown_percent(&self) -> String {
        self.percent.map_or_else(String::new, |p| format!("{p:+.1} %"))
    }

    /// The difference for people, with its sign, in the unit of the column's heading; empty where there is none.
    pub fn shown_difference(&self) -> String {
        self.difference.map_or_else(String::new, |d| {
            let sign = if d > 0.0 { "+" } else { "" };
            format!("{sign}{}", self.column.show_number(d))
        })
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn key_of<S: Serializer>(column: &&'static Column, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(column.key)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row<'a>(comparison: &'a Comparison, key: &str) -> &'a ComparedFigure {
        comparison.rows.iter().find(|r| r.column.key == key).expect("a column")
    }

    #[test]
    fn differences_have_a_sign_and_a_judgement() {
        let (a, mut b) = (TreeStats::example("A"), TreeStats::example("B"));
        b.build_ms = 3.0;
        b.figures.node_count = 6000;
        b.config.bins = 8;
        let c = Comparison::of(a, b);
        let build = row(&c, "build_ms");
        assert_eq!((build.difference, build.percent, build.better), (Some(-1.0), Some(-25.0), Some(true)));
        assert_eq!((build.shown_difference(), build.shown_percent()), ("-1.00".into(), "-25.0 %".into()));
        let nodes = row(&c, "node_count");
        assert_eq!((nodes.difference, nodes.better), (Some(63.0), Some(false)));
        assert_eq!(nodes.shown_difference(), "+63");
        let bins = row(&c, "bins");
        assert_eq!((bins.percent, bins.better), (Some(-50.0), None));
    }

    #[test]
    fn what_is_missing_or_a_word_has_no_difference() {
        let c = Comparison::of(TreeStats::example("A"), TreeStats::example("B"));
        let epo = row(&c, "epo");
        assert_eq!((epo.difference, epo.better, epo.shown_percent()), (None, None, String::new()));
        let builder = row(&c, "builder");
        assert!(builder.difference.is_none() && builder.is_equal());
        assert!(row(&c, "sah_cost").better.is_none());
        assert!(c.rows.iter().all(|r| r.column.key != "name"));
    }

    #[test]
    fn it_is_plain_data() {
        let c = Comparison::of(TreeStats::example("A"), TreeStats::example("B"));
        let json = serde_json::to_value(&c.rows).expect("plain data");
        assert_eq!(json[0]["column"], "scene");
    }
}
