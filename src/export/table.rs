//! Figures of trees as text: JSON and CSV for programs, Markdown and aligned tables for people. All from the one table of
//! columns in [`crate::inspect::columns`].

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle, presets};
use serde::{Serialize, Serializer};

use crate::accel::build::BuildPhase;
use crate::accel::quality::{DepthLevel, SahCost};
use crate::inspect::columns::{COLUMNS, Column, DASH, Row, TreeRecord, best_rows, comparing, grouped};
use crate::inspect::compare::{ComparedFigure, Comparison};
use crate::inspect::paired_cost::{MeanInterval, PairedRayCost};
use crate::inspect::prediction::{Forecast, Prediction, agreement};
use crate::inspect::stats::TreeStats;
use crate::render::bench::RaySetKind;

/// One rule below the heading.
const STYLE: TableStyle = presets::NOTHING.header_separator(LineStyle::none().fill('─').junction('─'));

/// How figures are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TableFormat {
    /// Aligned, rounded, with units.
    #[default]
    People,
    Json,
    Csv,
    Markdown,
}

impl TableFormat {
    pub const ALL: [Self; 4] = [Self::People, Self::Json, Self::Csv, Self::Markdown];

    pub fn name(self) -> &'static str {
        match self {
            Self::People => "people",
            Self::Json => "json",
            Self::Csv => "csv",
            Self::Markdown => "markdown",
        }
    }
}

/// One tree as an object with every column, the phases of its build, its levels and leaf sizes.
pub fn json_one(stats: &TreeStats) -> String {
    #[derive(Serialize)]
    struct Whole<'a> {
        #[serde(flatten)]
        record: TreeRecord<'a>,
        threads: Option<usize>,
        ray_count: u64,
        missed_root_count: u64,
        leaf_visits_mean: Option<f64>,
        phases: &'a [BuildPhase],
        sah_cost_parts: Option<SahCost>,
        leaf_sizes: &'a [usize],
        levels: &'a [DepthLevel],
    }
    let (rays, figures) = (&stats.rays, &stats.figures);
    pretty(&Whole {
        record: TreeRecord(stats),
        threads: stats.times.map(|times| times.threads),
        ray_count: rays.ray_count,
        missed_root_count: rays.missed_root_count,
        leaf_visits_mean: rays.leaf_visits_mean,
        phases: &stats.phases,
        sah_cost_parts: figures.sah_cost,
        leaf_sizes: &figures.leaf_sizes,
        levels: &figures.levels,
    })
}

/// One object a tree.
pub fn json(rows: &[TreeStats]) -> String {
    pretty(&rows.iter().map(TreeRecord).collect::<Vec<_>>())
}

/// A line a tree under the columns' keys; nothing between commas for what is undefined.
pub fn csv(rows: &[TreeStats]) -> String {
    let lines = rows.iter().map(|row| COLUMNS.iter().map(|c| c.value(row).plain()).collect());
    csv_text(COLUMNS.iter().map(|c| c.key.to_owned()).collect(), lines)
}

/// Trees as the columns, figures as the rows; the best of each row is marked by a star.
pub fn people(rows: &[TreeStats]) -> String {
    let names = rows.iter().map(|row| row.name.clone());
    let lines = comparing().filter(|c| c.key != "name").map(|column| {
        let best = best_rows(rows, column);
        let mark = |i| if best.contains(&i) { " *" } else { "  " };
        let values = rows.iter().enumerate().map(|(i, row)| column.shown(row) + mark(i));
        std::iter::once(column.heading()).chain(values).collect()
    });
    aligned(std::iter::once(String::new()).chain(names).collect(), lines)
}

/// How well what is known in advance of these trees orders them by what rays paid; empty for fewer than three trees.
pub fn agreements(rows: &[TreeStats]) -> String {
    if rows.len() < 3 {
        return String::new();
    }
    let trees: Vec<_> = rows.iter().map(Forecast::of).collect();
    let heading = "pairs in the right order (%)".to_owned();
    let kinds = RaySetKind::ALL.map(|kind| format!("{} rays", kind.name()));
    let lines = Prediction::ALL.into_iter().map(|prediction| {
        let share = |kind| agreement(&trees, prediction, kind);
        let shown =
            |kind| share(kind).map_or_else(|| DASH.to_owned(), |share| format!("{:.0}", 100.0 * share));
        std::iter::once(prediction.label().to_owned()).chain(RaySetKind::ALL.map(shown)).collect()
    });
    aligned(std::iter::once(heading).chain(kinds).collect(), lines)
}

/// Trees as the rows, the given columns as the columns, with a dot before the rows of a front.
pub fn people_with_front<R: Row>(rows: &[R], columns: &[&Column], front: &[usize]) -> String {
    let lines = rows.iter().enumerate().map(|(i, row)| {
        let cell = |column: &&Column| {
            let mark = if best_rows(rows, column).contains(&i) { " *" } else { "  " };
            let shown = column.shown(row);
            if column.key == "name" {
                format!("{} {shown}", if front.contains(&i) { "•" } else { " " })
            } else if column.is_text() {
                shown
            } else {
                shown + mark
            }
        };
        columns.iter().map(cell).collect()
    });
    aligned(columns.iter().map(|c| c.heading()).collect(), lines)
}

/// Trees as the rows of a Markdown table, best values in bold.
pub fn markdown<R: Row>(rows: &[R]) -> String {
    let columns: Vec<_> = comparing().collect();
    let lines = rows.iter().enumerate().map(|(i, row)| {
        let cell = |column: &&Column| {
            let shown = column.shown(row);
            if best_rows(rows, column).contains(&i) { format!("**{shown}**") } else { shown }
        };
        columns.iter().map(cell).collect()
    });
    let is_text: Vec<_> = columns.iter().map(|c| c.is_text()).collect();
    markdown_text(&columns.iter().map(|c| c.heading()).collect::<Vec<_>>(), &is_text, lines)
}

/// Everything of one tree, a line a figure, with its meaning.
pub fn people_one(stats: &TreeStats) -> String {
    let lines = COLUMNS.iter().map(|c| vec![c.heading(), c.shown(stats), c.meaning.to_owned()]);
    let mut table = table(vec![String::new(), stats.name.clone(), "meaning".to_owned()], lines);
    right_align(&mut table, 1..2);
    format!("{table}\n\n{}\n\n{}", phases(stats), levels(stats))
}

/// A against B, a line a figure; equal settings are left out.
pub fn compared(comparison: &Comparison) -> String {
    let mut page = compared_figures(&comparison.rows, ["A", "B", "B - A"]);
    if let Some(cost) = &comparison.ray_cost {
        page += &format!(
            "\n\nmean ray cost of {} camera rays (± is the 95 % interval; B - A ray by ray):\n{}",
            grouped(cost.ray_count as f64, 0),
            cost.shown()
        );
    }
    page
}

/// The same under other headings of the two and their difference.
pub fn compared_figures(rows: &[ComparedFigure], [a, b, difference]: [&str; 3]) -> String {
    let heading = ["", a, b, difference, "percent", ""].map(str::to_owned).to_vec();
    let shown = |row: &&ComparedFigure| !(row.is_equal() && row.difference.is_none_or(|d| d == 0.0));
    let lines = rows.iter().filter(shown).map(|row| {
        let verdict = row.better.map_or("", |better| if better { "better" } else { "worse" });
        vec![
            row.column.heading(),
            row.column.show(&row.a),
            row.column.show(&row.b),
            row.shown_difference(),
            row.shown_percent(),
            verdict.to_owned(),
        ]
    });
    let mut table = table(heading, lines);
    right_align(&mut table, 1..5);
    table.to_string()
}

/// A, B and every difference as an object.
pub fn compared_json(comparison: &Comparison) -> String {
    /// Differences under their figures' keys, in the order of the columns.
    struct Differences<'a>(&'a [ComparedFigure]);
    impl Serialize for Differences<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_map(self.0.iter().map(|row| (row.column.key, row)))
        }
    }
    #[derive(Serialize)]
    struct Whole<'a> {
        a: TreeRecord<'a>,
        b: TreeRecord<'a>,
        differences: Differences<'a>,
        camera_ray_cost: Option<&'a PairedRayCost>,
    }
    pretty(&Whole {
        a: TreeRecord(&comparison.a),
        b: TreeRecord(&comparison.b),
        differences: Differences(&comparison.rows),
        camera_ray_cost: comparison.ray_cost.as_ref(),
    })
}

/// A line a figure: key, A, B, difference, percent.
pub fn compared_csv(comparison: &Comparison) -> String {
    let heading = ["figure", "a", "b", "difference", "percent"].map(str::to_owned).to_vec();
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let lines = comparison.rows.iter().map(|row| {
        let figure = row.column.key.to_owned();
        vec![figure, row.a.plain(), row.b.plain(), number(row.difference), number(row.percent)]
    });
    let lines = lines.chain(comparison.ray_cost.iter().flat_map(|cost| {
        let line = |figure: &str, of: fn(&MeanInterval) -> Option<f64>, percent| {
            let [a, b, difference] = [&cost.a, &cost.b, &cost.difference].map(|mean| number(of(mean)));
            vec![figure.to_owned(), a, b, difference, number(percent)]
        };
        [
            line("camera_ray_cost_mean", |mean| Some(mean.mean), cost.percent),
            line("camera_ray_cost_half_width_95", |mean| mean.half_width_95, None),
        ]
    }));
    csv_text(heading, lines)
}

/// A against B as a Markdown table.
pub fn compared_markdown(comparison: &Comparison) -> String {
    let heading = ["figure", "A", "B", "B - A", "percent"].map(str::to_owned);
    let lines = comparison.rows.iter().map(|row| {
        let (a, b) = (row.column.show(&row.a), row.column.show(&row.b));
        vec![row.column.heading(), a, b, row.shown_difference(), row.shown_percent()]
    });
    let lines = lines.chain(comparison.ray_cost.iter().map(|cost| {
        let [a, b, difference] = [&cost.a, &cost.b, &cost.difference].map(MeanInterval::shown);
        let percent = cost.percent.map_or_else(String::new, |p| format!("{p:+.1} %"));
        vec!["camera ray cost, 95 % interval".to_owned(), a, b, difference, percent]
    }));
    markdown_text(&heading, &[true, false, false, false, false], lines)
}

/// A table for people: words flush left in the first column, everything else flush right.
pub fn aligned(heading: Vec<String>, lines: impl Iterator<Item = Vec<String>>) -> String {
    let columns = heading.len();
    let mut table = table(heading, lines);
    right_align(&mut table, 1..columns);
    table.to_string()
}

/// CSV with a heading line.
pub fn csv_text(heading: Vec<String>, lines: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    for line in std::iter::once(heading).chain(lines) {
        writer.write_record(line).expect("lines of one length, written to memory");
    }
    let bytes = writer.into_inner().expect("memory can be written to");
    String::from_utf8(bytes).expect("text in, text out")
}

/// A Markdown table; `is_text` columns are flush left.
pub fn markdown_text(
    heading: &[String],
    is_text: &[bool],
    lines: impl Iterator<Item = Vec<String>>,
) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule: Vec<_> = is_text.iter().map(|&t| if t { "---" } else { "---:" }.to_owned()).collect();
    let mut out = line(heading) + &line(&rule);
    for cells in lines {
        out += &line(&cells.iter().map(|cell| cell.replace('|', "\\|")).collect::<Vec<_>>());
    }
    out
}

/// JSON with line breaks.
pub fn pretty(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("plain data") + "\n"
}

fn phases(stats: &TreeStats) -> String {
    let lines = stats.phases.iter().map(|phase| vec![phase.name.to_owned(), format!("{:.2}", phase.ms)]);
    aligned(["build phase", "ms"].map(str::to_owned).to_vec(), lines)
}

fn levels(stats: &TreeStats) -> String {
    let heading = ["depth", "inner nodes", "leaves", "shapes in leaves", "SAH inner", "SAH leaf"];
    let lines = stats.figures.levels.iter().enumerate().map(|(depth, level)| {
        vec![
            depth.to_string(),
            level.inner_count.to_string(),
            level.leaf_count.to_string(),
            level.reference_count.to_string(),
            format!("{:.3}", level.sah_inner),
            format!("{:.3}", level.sah_leaf),
        ]
    });
    aligned(heading.map(str::to_owned).to_vec(), lines)
}

fn table(heading: Vec<String>, lines: impl Iterator<Item = Vec<String>>) -> Table {
    let mut table = Table::new();
    // The same text on a terminal and in a file.
    table.force_no_tty().load_style(STYLE).set_header(heading).add_rows(lines);
    table
}

fn right_align(table: &mut Table, columns: std::ops::Range<usize>) {
    for i in columns {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value as Json, json};

    use super::*;

    fn two() -> [TreeStats; 2] {
        let mut better = TreeStats::example("B, the better");
        better.figures.node_count = 5857;
        better.build_ms = 3.25;
        [TreeStats::example("A"), better]
    }

    #[test]
    fn json_is_one_object_a_tree_with_null_for_the_undefined() {
        let rows: Json = serde_json::from_str(&super::json(&two())).expect("JSON");
        assert_eq!(rows.as_array().map(Vec::len), Some(2));
        assert_eq!((&rows[1]["node_count"], &rows[1]["build_ms"]), (&json!(5857), &json!(3.25)));
        assert!(
            super::json(&two()).find("\"scene\"") < super::json(&two()).find("\"shape_count\""),
            "in order"
        );
        assert!(rows[0]["epo"].is_null() && rows[0].get("epo").is_some());
        let one: Json = serde_json::from_str(&json_one(&TreeStats::example("A"))).expect("JSON");
        assert_eq!((&one["name"], &one["leaf_sizes"]), (&json!("A"), &json!([0, 961, 2008])));
    }

    #[test]
    fn csv_reads_back_with_a_column_a_key() {
        let text = csv(&two());
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let keys: Vec<_> = reader.headers().expect("a heading").iter().map(str::to_owned).collect();
        assert_eq!(keys, COLUMNS.iter().map(|c| c.key).collect::<Vec<_>>());
        let rows: Vec<_> = reader.records().map(|r| r.expect("a line")).collect();
        let cell =
            |row: usize, key: &str| rows[row][keys.iter().position(|k| k == key).expect(key)].to_owned();
        assert_eq!((cell(1, "name"), cell(1, "node_count")), ("B, the better".to_owned(), "5857".to_owned()));
        assert_eq!((cell(0, "epo"), cell(0, "sah_cost")), (String::new(), "12.5".to_owned()));
    }

    #[test]
    fn people_see_units_and_the_best_marked() {
        let text = people(&two());
        let line = |start: &str| text.lines().find(|l| l.trim().starts_with(start)).expect(start);
        assert!(line("nodes ").contains("5,857 *") && !line("nodes ").contains("5,937 *"), "{text}");
        assert!(line("build (ms)").contains("3.25 *"));
        assert!(line("traversal (ms)").contains('–'));
        let lengths: Vec<_> = text.lines().map(|l| l.chars().count()).collect();
        assert!(lengths.windows(2).all(|w| w[0] == w[1]), "every line is as long: {lengths:?}");
    }

    #[test]
    fn markdown_has_a_rule_and_as_many_cells_in_every_line() {
        let text = markdown(&two());
        let cells: Vec<_> = text.lines().map(|l| l.matches('|').count()).collect();
        assert_eq!(cells.len(), 4);
        assert!(cells.windows(2).all(|w| w[0] == w[1]), "{text}");
        assert!(text.contains("**5,857**"), "{text}");
    }

    #[test]
    fn predictions_are_held_against_what_rays_paid() {
        let mut rows = [TreeStats::example("A"), TreeStats::example("B"), TreeStats::example("C")];
        assert_eq!(agreements(&rows[..2]), "");
        for (i, row) in rows.iter_mut().enumerate() {
            row.figures.sah_cost = Some(SahCost { inner: 9.0 - i as f64, leaf: 0.0 });
            row.ray_costs.primary = Some(5.0 + [0.0, 2.0, 1.0][i]);
        }
        let text = agreements(&rows);
        let line = text.lines().find(|line| line.trim().starts_with("SAH cost")).expect("a line");
        assert_eq!(line.split_whitespace().skip(2).collect::<Vec<_>>(), ["33", DASH, DASH], "{text}");
    }

    #[test]
    fn one_tree_is_explained_figure_by_figure() {
        let text = people_one(&TreeStats::example("A"));
        for column in COLUMNS {
            assert!(text.contains(&column.heading()) && text.contains(column.meaning), "{}", column.key);
        }
    }

    #[test]
    fn a_comparison_leaves_out_what_is_equal_for_people_only() {
        let [a, b] = two();
        let mut comparison = Comparison::of(a, b);
        assert!(compared_json(&comparison).contains("\"camera_ray_cost\": null"));
        comparison.ray_cost = PairedRayCost::of(&[2.0, 6.0, 4.0], &[1.0, 3.0, 2.0]);
        let text = compared(&comparison);
        assert!(text.contains("build (ms)") && text.contains("-18.8 %") && text.contains("better"), "{text}");
        assert!(!text.contains("leaf limit"), "{text}");
        let json: Json = serde_json::from_str(&compared_json(&comparison)).expect("JSON");
        assert_eq!(json["differences"]["node_count"]["difference"], json!(-80.0));
        assert_eq!((&json["a"]["leaf"], &json["b"]["leaf"]), (&json!(2), &json!(2)));
        let csv = compared_csv(&comparison);
        assert!(csv.contains("build_ms,4,3.25,-0.75,-18.75"), "{csv}");
        assert!(csv.contains("camera_ray_cost_mean,4,2,-2,-50\n"), "{csv}");
        assert!(csv.contains("camera_ray_cost_half_width_95,2.26"), "{csv}");
        assert_eq!(json["camera_ray_cost"]["difference"]["mean"], json!(-2.0));
        let said = "mean ray cost of 3 camera rays";
        assert!(text.contains(said) && text.contains("B - A -2.0 ± 1.1 (-50.0 %)"), "{text}");
        assert!(compared_markdown(&comparison).contains("| 4.0 ± 2.3 | 2.0 ± 1.1 | -2.0 ± 1.1 | -50.0 % |"));
        assert!(compared_markdown(&comparison).lines().nth(1) == Some("| --- | ---: | ---: | ---: | ---: |"));
    }
}
