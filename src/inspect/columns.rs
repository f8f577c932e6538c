//! The one table of what is said of a tree: key, title, unit, meaning, and which way is better. Printed tables, CSV,
//! JSON, Markdown and the panels all iterate it.

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::prediction::{Forecast, Prediction};
use super::stats::TreeStats;

/// What is shown for a value that is not defined.
pub const DASH: &str = "–";

/// One figure or setting of a tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Undefined, or not measured: `null`, shown as a dash.
    Missing,
    Text(String),
    Count(u64),
    Real(f64),
}

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

/// Every column, in the order of JSON and CSV.
pub static COLUMNS: &[Column] = &[
    text("scene", "scene", "the scene's name", |s| s.scene.clone().into()),
    count("shape_count", "shapes", "bounded shapes of the scene", |s| s.shape_count.into()),
    text("name", "tree", "what this tree is called here", |s| s.name.clone().into()),
    text("builder", "builder", "how splits were found", |s| match s.imported {
        Some(_) => "imported".into(),
        None => s.config.builder.name().into(),
    }),
    count("width", "width", "most children of a node", |s| match &s.imported {
        Some(imported) => imported.width.into(),
        None => s.config.width.get().into(),
    }),
    count("bins", "bins", "bins an axis; only the builders binned and spatial look at it", |s| {
        if_built(s, s.config.bins)
    }),
    count("leaf", "leaf limit", "most references in a leaf", |s| if_built(s, s.config.leaf)),
    count("node_count", "nodes", "inner nodes and leaves", |s| s.figures.node_count.into()).lower(),
    count("leaf_count", "leaves", "nodes that hold references", |s| s.figures.leaf_count.into()),
    count("reference_count", "references", "entries of all leaves; a shape may have several", |s| {
        s.figures.reference_count.into()
    }),
    count("depth_max", "max depth", "depth of the deepest leaf; the root is at 0", |s| {
        s.figures.depth_max.into()
    })
    .lower(),
    real("depth_mean", "mean depth", "mean depth of the leaves; the root is at 0", |s| {
        s.figures.depth_mean.into()
    })
    .lower(),
    real(
        "sah_cost",
        "SAH cost",
        "what a random line that hits the root's box costs: C_t for each inner node, C_i for each shape",
        |s| s.figures.sah_cost.map(|c| c.total()).into(),
    )
    .lower(),
    real(
        "epo",
        "EPO",
        "end-point overlap: surface that lies in boxes it does not belong to, times what such a box costs",
        |s| s.epo.into(),
    )
    .lower(),
    real("lcv", "LCV", "standard deviation of the number of leaves that a ray visits", |s| s.rays.lcv.into())
        .lower(),
    real("nodes_visited_mean", "nodes / ray", "mean of the inner nodes and leaves that a ray visits", |s| {
        s.rays.nodes_visited_mean.into()
    })
    .lower(),
    real(
        "inner_visits_mean",
        "inner / ray",
        "mean of the inner nodes, a ray, whose children's boxes are tested",
        |s| s.rays.inner_visits_mean.into(),
    )
    .lower(),
    real("box_tests_mean", "boxes / ray", "mean of the boxes that are tested against a ray", |s| {
        s.rays.box_tests_mean.into()
    })
    .lower(),
    real("shape_tests_mean", "shapes / ray", "mean of the shapes that are tested against a ray", |s| {
        s.rays.shape_tests_mean.into()
    })
    .lower(),
    real(
        "ray_cost_mean",
        "ray cost",
        "mean of C_t x inner visits + C_i x shape tests: what the SAH cost predicts",
        |s| s.rays.ray_cost_mean.into(),
    )
    .lower(),
    real("build_ms", "build", "wall time of the build", |s| if_built(s, s.build_ms)).unit("ms").lower(),
    real(
        "traversal_ms",
        "traversal",
        "wall time of tracing all rays of one Whitted frame, median of 5",
        |s| s.times.map(|t| t.traversal_ms).into(),
    )
    .unit("ms")
    .lower(),
    real(
        "frames_per_s",
        "frames",
        "whole Whitted frames a second, shading included, without the build",
        |s| s.times.map(|t| t.frames_per_s).into(),
    )
    .unit("1/s")
    .decimals(1)
    .higher(),
    Column {
        shown_unit: 1024.0,
        ..count("bytes", "memory", "tree and shapes, ready to trace", |s| s.bytes.into())
    }
    .unit("KiB")
    .decimals(1)
    .lower(),
    real(
        "sah_epo",
        "SAH + EPO",
        "0.29 SAH cost + 0.71 EPO, the mixture that predicts times best (Aila, Karras, Laine 2013)",
        |s| Forecast::of(s).predicted(Prediction::SahEpo).into(),
    )
    .lower(),
    real("ray_cost_primary", "primary ray cost", "mean cost of a camera ray, of every n-th pixel", |s| {
        s.ray_costs.primary.into()
    })
    .lower(),
    real(
        "ray_cost_diffuse",
        "diffuse ray cost",
        "mean cost of a cosine-weighted bounce from where the camera rays hit",
        |s| s.ray_costs.diffuse.into(),
    )
    .lower(),
    real(
        "ray_cost_shadow",
        "shadow ray cost",
        "mean cost of a ray from there to a light, asked by occluded",
        |s| s.ray_costs.shadow.into(),
    )
    .lower(),
    real(
        "overlap",
        "overlap",
        "sum over inner nodes of the area that children share in pairs, by own area",
        |s| s.figures.overlap.into(),
    )
    .lower(),
    real(
        "empty_space",
        "empty space",
        "sum over inner nodes of the share of their volume that no child covers",
        |s| s.figures.empty_space.into(),
    ),
    real("empty_space_mean", "mean empty space", "the same as a mean over inner nodes with a volume", |s| {
        s.figures.empty_space_mean.into()
    }),
    real("slot_fill", "slot fill", "share of the child slots of inner nodes that are used", |s| {
        s.figures.slot_fill.into()
    })
    .higher(),
    real("leaf_fill", "leaf fill", "share of leaf lanes with a shape, where four are tested at once", |s| {
        s.figures.leaf_fill.into()
    })
    .higher(),
    real("bytes_per_shape", "bytes / shape", "memory of tree and shapes by the number of shapes", |s| {
        (s.shape_count > 0).then(|| s.bytes as f64 / s.shape_count as f64).into()
    })
    .decimals(1)
    .lower(),
    text("widen", "wide by", "how nodes of width 4 and 8 were made", |s| if_built(s, s.config.widen.name())),
    text("stop", "stop rule", "when a node became a leaf", |s| if_built(s, s.config.stop.name())),
    count("block", "blocks", "shapes that count as one in the split cost, rounded up", |s| {
        if_built(s, s.config.block.get())
    }),
    text("improver", "improver", "what made a better tree of the one that was built", |s| {
        if_built(s, s.config.improver.name())
    }),
    text("tree_file", "file", "the file that the tree is from, if it was not built", |s| {
        s.imported.as_ref().map_or(Value::Missing, |imported| imported.file.clone().into())
    }),
    text("layout", "layout", "how nodes lie in memory", |s| if_built(s, s.config.layout.name())),
    real(
        "pre_split",
        "pre-split",
        "references that cutting before the build may add, as a share of the shapes",
        |s| if_built(s, f64::from(s.config.pre_split)),
    ),
    real("traversal_cost", "C_t", "price of visiting a node", |s| f64::from(s.config.traversal_cost).into()),
    real("intersection_cost", "C_i", "price of testing a shape", |s| {
        f64::from(s.config.intersection_cost).into()
    }),
    text("count", "rays", "which rays were counted", |s| s.count.name().into()),
];

/// What a tree from a file does not tell.
fn if_built(stats: &TreeStats, value: impl Into<Value>) -> Value {
    if stats.imported.is_some() { Value::Missing } else { value.into() }
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

impl Value {
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Missing | Self::Text(_) => None,
            Self::Count(n) => Some(*n as f64),
            Self::Real(x) => Some(*x),
        }
    }

    /// The value for programs: all digits, nothing for a missing one.
    pub fn plain(&self) -> String {
        match self {
            Self::Missing => String::new(),
            Self::Text(text) => text.clone(),
            Self::Count(n) => n.to_string(),
            Self::Real(x) => x.to_string(),
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Missing => serializer.serialize_none(),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Count(n) => serializer.serialize_u64(*n),
            Self::Real(x) => serializer.serialize_f64(*x),
        }
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

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<usize> for Value {
    fn from(n: usize) -> Self {
        Self::Count(n as u64)
    }
}

impl From<Option<u32>> for Value {
    fn from(n: Option<u32>) -> Self {
        n.map_or(Self::Missing, |n| Self::Count(u64::from(n)))
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Self {
        if x.is_finite() { Self::Real(x) } else { Self::Missing }
    }
}

impl From<Option<f64>> for Value {
    fn from(x: Option<f64>) -> Self {
        x.map_or(Self::Missing, Self::from)
    }
}

const fn text(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    Column { key, title, unit: "", meaning, better: Better::Neither, decimals: 0, shown_unit: 1.0, value }
}

const fn count(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    text(key, title, meaning, value)
}

const fn real(
    key: &'static str,
    title: &'static str,
    meaning: &'static str,
    value: fn(&TreeStats) -> Value,
) -> Column {
    text(key, title, meaning, value).decimals(2)
}

/// A number with commas between thousands.
pub fn grouped(number: f64, decimals: usize) -> String {
    let plain = format!("{:.decimals$}", number.abs());
    let (whole, fraction) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    let mut out = String::with_capacity(plain.len() + whole.len() / 3 + 1);
    if number < 0.0 && plain.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        out.push('-');
    }
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out + fraction
}

#[cfg(test)]
mod tests {
    use super::super::stats::ImportedTree;
    use super::super::stats::tests::example;
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
        let mut stats = example("A");
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
        let stats = example("BVH_BIN");
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
        let mut stats = example("A");
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
        let mut rows = [example("A"), example("B"), example("C")];
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
