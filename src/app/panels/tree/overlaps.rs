//! The pairs of siblings that overlap most, each a click away from its boxes.

use egui::accesskit::Role;
use egui::{ScrollArea, Sense, Ui, WidgetInfo, vec2};

use super::node_name;
use crate::app::commands::{Command, Commands};
use crate::app::panels::glossary::Term;
use crate::app::panels::numbers;
use crate::app::panels::widgets::{self, Side};
use crate::app::selection::Pick;
use crate::app::view::{AppView, TreeView};
use crate::inspect::overlaps::{OverlapMeasure, OverlappingPair};

const LINE_HEIGHT: f32 = 18.0;
const LINES: f32 = 8.0;

pub fn ui(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::term_section(ui, Term::Overlaps);
    let tree_view = *view.tree_view;
    let describe = |m: OverlapMeasure| (m.name(), m.description());
    let measure = widgets::segmented(
        ui,
        Term::OverlapMeasure,
        Some(tree_view.measure),
        &OverlapMeasure::ALL,
        &describe,
    );
    if let Some(measure) = measure {
        commands.push(Command::SetTreeView(TreeView { measure, ..tree_view }));
    }
    let Some(pairs) = view.overlaps else {
        widgets::caption(ui, view.palette, "Looking for overlaps…");
        return;
    };
    if pairs.is_empty() {
        widgets::caption(ui, view.palette, "No two siblings overlap.");
        return;
    }
    let height = LINE_HEIGHT * LINES.min(pairs.len() as f32) + 2.0;
    let list = ScrollArea::vertical().id_salt("overlaps").max_height(height).auto_shrink([false, true]);
    ui.spacing_mut().item_spacing.y = 0.0;
    list.show_rows(ui, LINE_HEIGHT, pairs.len(), |ui, rows| {
        for (rank, pair) in pairs.iter().enumerate().take(rows.end).skip(rows.start) {
            if line(ui, view, rank, pair) {
                commands.push(Command::Select { pick: Pick::Node(pair.a), add: false });
                commands.push(Command::Select { pick: Pick::Node(pair.b), add: true });
            }
        }
    });
    widgets::set_spacing(ui);
}

/// Whether it was clicked.
fn line(ui: &mut Ui, view: &AppView, rank: usize, pair: &OverlappingPair) -> bool {
    let Some(world) = view.world else { return false };
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    let nodes = view.selections.current().map_or(&[][..], |s| &s.nodes[..]);
    let selected = nodes == [pair.a, pair.b];
    widgets::paint_line(ui, rect, &response, selected);
    let cell = rect.shrink2(vec2(4.0, 0.0));
    let (first, second) = cell.split_left_right_at_fraction(0.78);
    let text = format!("{}. {} and {}", rank + 1, node_name(world, pair.a), node_name(world, pair.b));
    let share = format!("{} %", numbers::decimal(100.0 * view.tree_view.measure.of(pair), 2));
    let (color, muted) = (ui.visuals().text_color(), view.palette.muted);
    widgets::paint_text(ui, first, Side::Left, &text, widgets::body_font(ui), color);
    widgets::paint_text(ui, second, Side::Right, &share, widgets::number_font(ui), muted);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, selected, text.clone()));
    let clicked = response.clicked();
    response.on_hover_text(format!(
        "Below node {}: {} % of the root's area, {} % of the parent's. Click selects both.",
        pair.parent.0,
        numbers::decimal(100.0 * pair.of_root, 3),
        numbers::decimal(100.0 * pair.of_parent, 1)
    ));
    clicked
}
