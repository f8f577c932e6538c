//! What the check of a tree found, as text: for people, as JSON, as CSV.

use serde::Serialize;

use super::table;
use crate::accel::validate::{Findings, Violation, ViolationKind};
use crate::inspect::columns::{TreeRecord, grouped};
use crate::inspect::stats::TreeStats;
use crate::world::{Imported, TreeFile};

/// Violations of a kind that are listed for people; programs get as many as [`Findings`] lists.
const SHOWN: usize = 10;

/// One line: `valid`, or how many faults there are, and what else was noticed.
pub fn verdict(findings: &Findings) -> String {
    let counted = |count: usize, noun: &str| {
        format!("{} {noun}{}", grouped(count as f64, 0), if count == 1 { "" } else { "s" })
    };
    let mut text = match findings.fault_count() {
        0 => "valid".to_owned(),
        faults => counted(faults, "fault"),
    };
    if findings.remark_count() > 0 {
        text += &format!(", {}", counted(findings.remark_count(), "remark"));
    }
    text
}

/// A report for people.
pub fn people(imported: &Imported) -> String {
    let Imported { file, findings, .. } = imported;
    let mut text = format!(
        "{}: {}\n{} nodes of {} slots, {} leaves, {} references; {} shapes in several leaves, {} references more than \
         shapes\n",
        file.name,
        verdict(findings),
        grouped(file.raw.node_count() as f64, 0),
        file.raw.width,
        grouped(file.raw.leaf_count() as f64, 0),
        grouped(file.raw.shape_index.len() as f64, 0),
        grouped(findings.shapes_in_several as f64, 0),
        grouped(findings.extra_references as f64, 0),
    );
    for kind in ViolationKind::ALL.into_iter().filter(|kind| findings.count(*kind) > 0) {
        let count = findings.count(kind);
        let what = if kind.is_fault() { "fault" } else { "remark" };
        text += &format!("\n{what} {}, {}: {}\n", kind.name(), grouped(count as f64, 0), kind.description());
        let of_kind = findings.violations.iter().filter(|violation| violation.kind() == kind);
        of_kind.take(SHOWN).for_each(|violation| text += &format!("  {violation}\n"));
        if count > SHOWN {
            text += &format!("  and {} more\n", grouped((count - SHOWN) as f64, 0));
        }
    }
    text
}

#[derive(Serialize)]
struct JsonViolation<'a> {
    kind: &'a str,
    fault: bool,
    /// Index in the file; `null` if it is about something else.
    node: Option<u32>,
    leaf: Option<u32>,
    shape: Option<u32>,
    message: String,
}

impl JsonViolation<'_> {
    fn of(violation: &Violation) -> Self {
        use crate::accel::validate::At;
        let kind = violation.kind();
        let (node, leaf) = match violation.at() {
            Some(At::Node(node)) => (Some(node), None),
            Some(At::Leaf(leaf)) => (None, Some(leaf)),
            None => (None, None),
        };
        Self {
            kind: kind.name(),
            fault: kind.is_fault(),
            node,
            leaf,
            shape: violation.shape(),
            message: violation.to_string(),
        }
    }
}

/// The findings as data, and the figures of a tree without a fault.
pub fn json(imported: &Imported, figures: Option<&TreeStats>) -> String {
    #[derive(Serialize)]
    struct Whole<'a> {
        file: &'a str,
        content_hash: &'a str,
        valid: bool,
        width: usize,
        node_count: usize,
        leaf_count: usize,
        reference_count: usize,
        fault_count: usize,
        remark_count: usize,
        shapes_in_several: usize,
        extra_references: usize,
        counts: serde_json::Map<String, serde_json::Value>,
        violations: Vec<JsonViolation<'a>>,
        figures: Option<TreeRecord<'a>>,
    }
    let Imported { file, findings, .. } = imported;
    let TreeFile { name, raw, content_hash, .. } = &**file;
    let counted = ViolationKind::ALL.into_iter().filter(|kind| findings.count(*kind) > 0);
    table::pretty(&Whole {
        file: name,
        content_hash,
        valid: findings.is_valid(),
        width: raw.width,
        node_count: raw.node_count(),
        leaf_count: raw.leaf_count(),
        reference_count: raw.shape_index.len(),
        fault_count: findings.fault_count(),
        remark_count: findings.remark_count(),
        shapes_in_several: findings.shapes_in_several,
        extra_references: findings.extra_references,
        counts: counted.map(|kind| (kind.name().to_owned(), findings.count(kind).into())).collect(),
        violations: findings.violations.iter().map(JsonViolation::of).collect(),
        figures: figures.map(TreeRecord),
    })
}

/// The violations, a line each.
pub fn csv(findings: &Findings) -> String {
    let number = |n: Option<u32>| n.map_or_else(String::new, |n| n.to_string());
    let lines = findings.violations.iter().map(|violation| {
        let JsonViolation { kind, fault, node, leaf, shape, message } = JsonViolation::of(violation);
        vec![kind.to_owned(), fault.to_string(), number(node), number(leaf), number(shape), message]
    });
    let heads = ["kind", "fault", "node", "leaf", "shape", "message"].map(str::to_owned);
    table::csv_text(heads.to_vec(), lines)
}
