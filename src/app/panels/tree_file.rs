//! A tree from another program: what the check found, each finding a click away from its box.

use egui::accesskit::Role;
use egui::{Color32, Rect, RichText, ScrollArea, Sense, Ui, WidgetInfo, vec2};

use crate::accel::validate::{Findings, Violation, ViolationKind};
use crate::app::commands::{Command, Commands, Mark};
use crate::app::view::{AppView, Marked};
use crate::export::findings::verdict;
use crate::world::Imported;

use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure, Side};

const LINE_HEIGHT: f32 = 20.0;
/// Findings that are seen at once.
const LINES: f32 = 14.0;

/// View state of the Tree file panel.
#[derive(Default)]
pub struct TreeFilePanel {
    /// The kind of findings that is listed; all kinds if there are none of it.
    kind: Option<ViolationKind>,
}

impl TreeFilePanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(imported) = view.world.and_then(|world| world.imported.as_ref()) else {
            nothing(ui, view, commands);
            return;
        };
        widgets::section(ui, &imported.file.name);
        state_of(ui, view, imported);
        ui.horizontal(|ui| {
            if ui.button("Import another…").clicked() {
                commands.push(Command::AskImport);
            }
            let back = ui.button("Build a tree instead").on_hover_text("Puts the file's tree away.");
            if back.clicked() {
                commands.push(Command::BuildOwnTree);
            }
        });
        figures(ui, view, imported);
        self.findings(ui, view, &imported.findings, commands);
    }

    fn findings(&mut self, ui: &mut Ui, view: &AppView, findings: &Findings, commands: &mut Commands) {
        widgets::term_section(ui, Term::Violations);
        if findings.violations.is_empty() {
            widgets::caption(ui, view.palette, "The check found nothing.");
            return;
        }
        self.kind = self.kind.filter(|kind| findings.count(*kind) > 0);
        for kind in ViolationKind::ALL.into_iter().filter(|kind| findings.count(*kind) > 0) {
            let selected = self.kind == Some(kind);
            if kind_line(ui, view, kind, findings.count(kind), selected) {
                self.kind = if selected { None } else { Some(kind) };
            }
        }
        ui.add_space(6.0);
        Self::marked(ui, view, commands);
        let listed: Vec<&Violation> = findings
            .violations
            .iter()
            .filter(|violation| self.kind.is_none_or(|kind| violation.kind() == kind))
            .collect();
        let height = LINE_HEIGHT * LINES.min(listed.len() as f32) + 4.0;
        let list = ScrollArea::vertical().id_salt("findings").max_height(height).auto_shrink([false, true]);
        ui.spacing_mut().item_spacing.y = 0.0;
        list.show_rows(ui, LINE_HEIGHT, listed.len(), |ui, rows| {
            for violation in &listed[rows] {
                if violation_line(ui, view, violation) {
                    commands.push(Command::Mark(Some(mark_of(violation))));
                }
            }
        });
        let most = ViolationKind::ALL.into_iter().any(|kind| findings.count(kind) > Findings::MOST_LISTED);
        if most {
            ui.add_space(4.0);
            let text =
                format!("The first {} of each kind are listed.", numbers::count(Findings::MOST_LISTED));
            widgets::caption(ui, view.palette, text);
        }
    }

    /// What stands out in the viewport now.
    fn marked(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        // The buttons are always there, so that the list below keeps its place.
        match view.marked {
            Some(marked) => widgets::caption(ui, view.palette, marked_text(marked)),
            None => widgets::caption(ui, view.palette, "Click a finding to see its box in the viewport."),
        };
        ui.horizontal(|ui| {
            let has_box = view.marked.is_some_and(|marked| marked.around().is_some());
            let frame = ui.add_enabled(has_box, egui::Button::new("Frame"));
            let frame = frame.on_hover_text("Moves the camera so that the marked boxes are seen.");
            if frame.on_disabled_hover_text("Nothing is marked that has a box to be seen.").clicked() {
                commands.push(Command::FrameMarked);
            }
            if ui.add_enabled(view.marked.is_some(), egui::Button::new("Unmark")).clicked() {
                commands.push(Command::Mark(None));
            }
            for (color, name) in [(OWN, "its box"), (PARENT, "its parent's")] {
                widgets::swatch(ui, color);
                ui.label(RichText::new(name).small().color(view.palette.muted));
            }
        });
        ui.add_space(4.0);
    }
}

/// The colours of the boxes in the viewport.
const OWN: Color32 = crate::app::viewport::marks::OWN;
const PARENT: Color32 = crate::app::viewport::marks::PARENT;

fn mark_of(violation: &Violation) -> Mark {
    match (violation.at(), violation.shape()) {
        (Some(at), _) => Mark::Item(at),
        (None, shape) => Mark::Shape(shape.unwrap_or_default()),
    }
}

fn marked_text(marked: &Marked) -> String {
    let what = match marked.mark {
        Mark::Item(at) => at.to_string(),
        Mark::Shape(shape) => format!("shape {shape}"),
    };
    let place = match (marked.bounds, marked.parent) {
        (None, _) => ": no box that could be shown".to_owned(),
        (Some(_), Some(parent)) => format!(" in {parent}"),
        (Some(_), None) => String::new(),
    };
    format!("Marked: {what}{place}")
}

/// While no tree is imported.
fn nothing(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::section(ui, "Tree file");
    widgets::caption(
        ui,
        view.palette,
        "A tree that another program built (NPZ or JSON) can be shown, measured and compared like any other. It is \
         checked first: what is wrong with it is listed here.",
    );
    ui.add_space(4.0);
    if ui.button("Import a tree…").clicked() {
        commands.push(Command::AskImport);
    }
    widgets::caption(
        ui,
        view.palette,
        "Or drop one on the window. docs/tree-format.md says how to write one.",
    );
}

fn state_of(ui: &mut Ui, view: &AppView, imported: &Imported) {
    let text = widgets::capitalised(&verdict(&imported.findings));
    if imported.findings.is_valid() {
        widgets::notice(ui, view.palette.good, format!("{text}. The picture is traced with it."));
    } else {
        widgets::notice(
            ui,
            view.palette.error,
            format!("{text}. Its boxes are drawn; the picture is traced with a tree that was built here."),
        );
    }
}

fn figures(ui: &mut Ui, view: &AppView, imported: &Imported) {
    let (raw, findings) = (&imported.file.raw, &imported.findings);
    for (term, value) in [
        (Term::FileNodes, raw.node_count()),
        (Term::FileWidth, raw.width),
        (Term::FileLeaves, raw.leaf_count()),
        (Term::FileReferences, raw.shape_index.len()),
        (Term::InSeveral, findings.shapes_in_several),
        (Term::ExtraReferences, findings.extra_references),
    ] {
        Figure::new(term, numbers::count(value)).show(ui, view.palette);
    }
}

/// A kind of findings with their number. True if it was clicked.
fn kind_line(ui: &mut Ui, view: &AppView, kind: ViolationKind, count: usize, selected: bool) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    widgets::paint_line(ui, rect, &response, selected);
    let color = if kind.is_fault() { view.palette.error } else { view.palette.muted };
    let dot = Rect::from_center_size(rect.left_center() + vec2(9.0, 0.0), vec2(8.0, 8.0));
    ui.painter().rect_filled(dot, 2.0, color);
    let name = kind.name().replace('-', " ");
    let (left, right) = rect.shrink2(vec2(4.0, 0.0)).split_left_right_at_fraction(0.75);
    let left = left.with_min_x(rect.left() + 20.0);
    widgets::paint_text(ui, left, Side::Left, &name, widgets::body_font(ui), ui.visuals().text_color());
    let number = numbers::count(count);
    widgets::paint_text(ui, right, Side::Right, &number, widgets::number_font(ui), ui.visuals().text_color());
    let what = if kind.is_fault() { "Fault" } else { "Remark" };
    response.widget_info(|| {
        WidgetInfo::selected(Role::Button, true, selected, format!("{what} {name}: {number}"))
    });
    let clicked = response.clicked();
    response.on_hover_text(format!("{what}: {}. Click to list these alone.", kind.description()));
    clicked
}

/// True if it was clicked.
fn violation_line(ui: &mut Ui, view: &AppView, violation: &Violation) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    let selected = view.marked.is_some_and(|marked| marked.mark == mark_of(violation));
    widgets::paint_line(ui, rect, &response, selected);
    let color = if violation.kind().is_fault() { ui.visuals().text_color() } else { view.palette.muted };
    let text = violation.to_string();
    let cell = rect.shrink2(vec2(4.0, 0.0));
    widgets::paint_text(ui, cell, Side::Left, &text, widgets::small_font(ui), color);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, selected, text.clone()));
    let clicked = response.clicked();
    response.on_hover_text(text);
    clicked
}
