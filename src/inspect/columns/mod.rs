//! The one table of what is said of a tree: key, title, unit, meaning, and which way is better. Printed tables, CSV,
//! JSON, Markdown and the panels all iterate it.

mod table;
mod value;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::stats::TreeStats;

pub use table::COLUMNS;
pub use value::{DASH, Value, grouped};

/// Which of two values is the better one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    Lower,
    Higher,
    /// Neither: a name, a setting, or a size of the question.
    Neither,
}

/// What has a value in every column: a tree that was measured, or what was kept of one.
pub trait Row {
    fn value(&self, column: &Column) -> Value;
}

impl Row for TreeStats {
    fn value(&self, column: &Column) -> Value {
        (column.value)(self)
    }
}

/// One column of every table of trees.
#[derive(Debug)]
pub struct Column {
    /// In JSON and CSV.
    pub key: &'static str,
    /// In tables for people.
    pub title: &'static str,
    /// Of the shown number; empty for plain counts.
    pub unit: &'static str,
    /// What it means, in one sentence.
    pub meaning: &'static str,
    pub better: Better,
    /// Decimals of the shown number.
    pub decimals: usize,
    /// The shown number is the value divided by this (1024 for KiB).
    pub shown_unit: f64,
    value: fn(&TreeStats) -> Value,
}

/// The columns of a table for people that compares trees on one scene, in order.
pub fn comparing() -> impl Iterator<Item = &'static Column> {
    const KEYS: [&str; 20] = [
        "name",
        "node_count",
        "leaf_count",
        "depth_max",
        "sah_cost",
        "epo",
        "sah_epo",
        "ray_cost_primary",
        "ray_cost_diffuse",
        "ray_cost_shadow",
        "nodes_visited_mean",
        "inner_visits_mean",
        "box_tests_mean",
        "shape_tests_mean",
        "ray_cost_mean",
        "lcv",
        "build_ms",
        "traversal_ms",
        "frames_per_s",
        "bytes",
    ];
    KEYS.into_iter().map(|key| Column::of(key).expect("the key of a column"))
}

/// The rows that are best in a column: several if they are equal; none where no value is better than another, or only
/// one row has a value.
pub fn best_rows<R: Row>(rows: &[R], column: &Column) -> Vec<usize> {
    let values: Vec<Option<f64>> = rows.iter().map(|row| column.value(row).number()).collect();
    let known = || values.iter().copied().flatten();
    let lowest = known().reduce(f64::min);
    let highest = known().reduce(f64::max);
    let best = match column.better {
        Better::Lower => lowest,
        Better::Higher => highest,
        Better::Neither => None,
    };
    match best {
        Some(_) if lowest != highest => (0..rows.len()).filter(|&i| values[i] == best).collect(),
        _ => Vec::new(),
    }
}

impl Column {
    /// The column of that key.
    pub fn of(key: &str) -> Option<&'static Self> {
        COLUMNS.iter().find(|c| c.key == key)
    }

    pub fn value(&self, row: &impl Row) -> Value {
        row.value(self)
    }

    /// Whether it holds words, not numbers: set flush left.
    pub fn is_text(&self) -> bool {
        self.better == Better::Neither
            && matches!(
                self.key,
                "scene"
                    | "name"
                    | "builder"
                    | "widen"
                    | "stop"
                    | "improver"
                    | "layout"
                    | "update"
                    | "tree_file"
                    | "count"
            )
    }

    /// The title with the unit, as in `build (ms)`.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.title.to_owned() } else { format!("{} ({})", self.title, self.unit) }
    }

    /// The value for people: rounded, with thousands set apart by a comma, in the unit of the heading.
    pub fn shown(&self, row: &impl Row) -> String {
        self.show(&self.value(row))
    }

    /// A value of this column for people.
    pub fn show(&self, value: &Value) -> String {
        match value {
            Value::Text(text) => text.clone(),
            _ => value.number().map_or_else(|| DASH.to_owned(), |n| self.show_number(n)),
        }
    }

    /// A number in the unit of this column's values, for people: a difference of two values, for example.
    pub fn show_number(&self, number: f64) -> String {
        grouped(number / self.shown_unit, self.decimals)
    }

    const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    const fn decimals(mut self, decimals: usize) -> Self {
        self.decimals = decimals;
        self
    }

    const fn lower(mut self) -> Self {
        self.better = Better::Lower;
        self
    }

    const fn higher(mut self) -> Self {
        self.better = Better::Higher;
        self
    }
}

/// One tree as a flat object: every column under its key, then the render settings and the camera that gave the figures.
#[derive(Clone, Copy, Debug)]
pub struct TreeRecord<'a>(pub &'a TreeStats);

impl Serialize for TreeRecord<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(COLUMNS.len() + 2))?;
        for column in COLUMNS {
            map.serialize_entry(column.key, &column.value(self.0))?;
        }
        map.serialize_entry("settings", &self.0.settings)?;
        map.serialize_entry("camera", &self.0.camera)?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::super::stats::ImportedTree;
    use super::*;

    #[test]
    fn keys_are_those_of_the_design_in_its_order() {
        let keys: Vec<&str> = COLUMNS.iter().map(|c| c.key).collect();
        let design = "scene shape_count name builder width bins leaf node_count leaf_count reference_count depth_max \
                      depth_mean sah_cost epo lcv nodes_visited_mean inner_visits_mean box_tests_mean \
                      shape_tests_mean ray_cost_mean build_ms traversal_ms frames_per_s bytes";
        let expected: Vec<&str> = design.split_whitespace().collect();
        assert_eq!(keys[..expected.len()], expected);
        assert_eq!(
            keys[expected.len()..],
            [
                "sah_epo",
                "ray_cost_primary",
                "ray_cost_diffuse",
                "ray_cost_shadow",
                "overlap",
                "empty_space",
                "empty_space_mean",
                "slot_fill",
                "leaf_fill",
                "bytes_per_shape",
                "widen",
                "stop",
                "block",
                "improver",
                "tree_file",
                "layout",
                "pre_split",
                "update",
                "traversal_cost",
                "intersection_cost",
                "count"
            ]
        );
    }

    #[test]
    fn every_column_explains_itself() {
        for column in COLUMNS {
            assert!(!column.title.is_empty() && column.meaning.len() > 10, "{}", column.key);
        }
        assert_eq!(comparing().count(), 20);
    }

    #[test]
    fn is_text_tells_what_values_are() {
        let mut stats = TreeStats::example("A");
        for column in COLUMNS.iter().filter(|c| c.key != "tree_file") {
            assert_eq!(column.is_text(), matches!(column.value(&stats), Value::Text(_)), "{}", column.key);
        }
        // Of a tree from a file much is not known.
        stats.imported = Some(ImportedTree { file: "t.npz".to_owned(), width: 5 });
        let shown = |key| Column::of(key).expect("a column").shown(&stats);
        assert_eq!(
            (shown("builder"), shown("width"), shown("tree_file")),
            ("imported".into(), "5".into(), "t.npz".into())
        );
        for key in ["bins", "leaf", "build_ms", "widen", "stop", "block", "improver"] {
            assert_eq!(shown(key), DASH, "{key}");
        }
    }

    #[test]
    fn a_record_has_every_key_and_null_for_the_undefined() {
        let stats = TreeStats::example("BVH_BIN");
        let json = serde_json::to_value(TreeRecord(&stats)).expect("a record is plain data");
        let object = json.as_object().expect("an object");
        assert_eq!(object.len(), COLUMNS.len() + 2);
        for column in COLUMNS {
            assert!(object.contains_key(column.key), "{}", column.key);
        }
        assert_eq!(object["name"], "BVH_BIN");
        assert_eq!(object["width"], 8);
        assert_eq!(object["node_count"], 5937);
        assert_eq!(object["sah_cost"], 12.5);
        assert!(object["epo"].is_null() && object["traversal_ms"].is_null());
        assert_eq!(object["settings"]["width"], 1280);
    }

    #[test]
    fn numbers_for_people() {
        let mut stats = TreeStats::example("A");
        stats.bytes = 3_355_443;
        let shown = |key| Column::of(key).expect("a column").shown(&stats);
        assert_eq!(shown("node_count"), "5,937");
        assert_eq!(shown("sah_cost"), "12.50");
        assert_eq!(shown("bytes"), "3,276.8");
        assert_eq!(shown("traversal_ms"), DASH);
        assert_eq!(Column::of("bytes").expect("a column").heading(), "memory (KiB)");
        assert_eq!(grouped(-1_234_567.891, 1), "-1,234,567.9");
        assert_eq!(
            (grouped(-0.001, 2), grouped(999.0, 0), grouped(1000.0, 0)),
            ("0.00".into(), "999".into(), "1,000".into())
        );
    }

    #[test]
    fn the_best_row_is_marked_and_ties_share_the_mark() {
        let mut rows = [TreeStats::example("A"), TreeStats::example("B"), TreeStats::example("C")];
        let best = |rows: &[TreeStats], key| best_rows(rows, Column::of(key).expect("a column"));
        assert!(best(&rows, "build_ms").is_empty());
        rows[0].build_ms = 50.0;
        assert_eq!(best(&rows, "build_ms"), [1, 2]);
        assert!(best(&rows, "frames_per_s").is_empty());
        for (row, fps) in rows.iter_mut().zip([28.0, 39.0]) {
            row.times =
                Some(crate::render::measure::FrameTimes { traversal_ms: 1.0, frames_per_s: fps, threads: 2 });
        }
        assert_eq!(best(&rows, "frames_per_s"), [1]);
        rows[1].config.bins = 4;
        assert!(best(&rows, "bins").is_empty());
    }
}
