//! Five trees side by side: one column a tree, one row a figure, the best of each row marked.

use egui::accesskit::Role;
use egui::{
    Align, Button, Color32, FontId, Layout, Rect, RichText, ScrollArea, Sense, TextWrapMode, Ui, WidgetInfo,
    vec2,
};
use egui_extras::{Column as Cell, TableBuilder};

use crate::accel::BuildConfig;
use crate::app::commands::{Command, Commands};
use crate::app::view::AppView;
use crate::export::table as text;
use crate::inspect::columns::{self, COLUMNS, Column, Value};
use crate::inspect::stats::TreeStats;

use super::build::summary;
use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Side};

const ROW_HEIGHT: f32 = 20.0;
const LABEL_WIDTH: f32 = 116.0;
const MOST_WIDTH: f32 = 130.0;
/// Between two columns.
const BETWEEN: f32 = 4.0;
/// What a row of the table is not made of: the same for all trees, or the heading.
const NOT_ROWS: [&str; 3] = ["scene", "shape_count", "name"];

/// View state of the Table panel.
#[derive(Default)]
pub struct TablePanel {}

impl TablePanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::FiveTrees);
        let table = view.table;
        match &table.running {
            Some(job) => {
                if widgets::progress(ui, view.palette, job, "Stop") {
                    commands.push(Command::CancelTable);
                }
            }
            None => measure(ui, view, commands),
        }
        if table.rows.is_empty() {
            introduction(ui, view);
            return;
        }
        if table.stale {
            let text = "Measured before the scene, the camera or the settings changed. Measure again.";
            widgets::notice(ui, view.palette.warning, text);
        }
        what_was_measured(ui, view, &table.rows);
        figures(ui, view, &table.rows, commands);
        copy(ui, &table.rows, commands);
    }
}

fn measure(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let button = ui.add_enabled(view.scene.is_some(), Button::new("Measure")).on_hover_text(
        "Builds and traces the five trees with nothing else running: the picture waits meanwhile.",
    );
    if button.clicked() {
        commands.push(Command::MeasureTable);
    }
}

fn introduction(ui: &mut Ui, view: &AppView) {
    widgets::caption(ui, view.palette, "Not measured yet. These are the trees:");
    for (name, config) in view.session.build().five_trees() {
        let size = vec2(ui.available_width(), widgets::FIGURE_HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let (left, right) = rect.split_left_right_at_x(rect.left() + 84.0);
        let (font, strong) = (widgets::body_font(ui), ui.visuals().strong_text_color());
        widgets::paint_text(ui, left, Side::Left, name, font.clone(), strong);
        let settings = summary(&config);
        widgets::paint_text(ui, right, Side::Left, &settings, font, view.palette.muted);
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name}: {settings}")));
    }
}

fn what_was_measured(ui: &mut Ui, view: &AppView, rows: &[TreeStats]) {
    let Some(first) = rows.first() else { return };
    let text = format!(
        "{}, {} shapes, {} × {} pixels, {} rays of a Whitted frame",
        first.scene,
        numbers::count(first.shape_count),
        first.settings.width,
        first.settings.height,
        numbers::count(first.rays.ray_count)
    );
    widgets::caption(ui, view.palette, text);
}

/// The columns that become rows: all in which some tree has a value.
fn shown_columns(rows: &[TreeStats]) -> Vec<&'static Column> {
    COLUMNS
        .iter()
        .filter(|c| !NOT_ROWS.contains(&c.key))
        .filter(|c| rows.iter().any(|row| c.value(row) != Value::Missing))
        .collect()
}

fn figures(ui: &mut Ui, view: &AppView, rows: &[TreeStats], commands: &mut Commands) {
    let columns = shown_columns(rows);
    let room = ui.available_width() - LABEL_WIDTH;
    let least = widest(ui, rows, &columns);
    let width = (room / rows.len().max(1) as f32 - BETWEEN).min(MOST_WIDTH).max(least);
    let mut chosen = None;
    ui.add_space(4.0);
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing = vec2(BETWEEN, 0.0);
        ui.vertical(|ui| {
            ui.set_width(LABEL_WIDTH);
            ui.allocate_space(vec2(LABEL_WIDTH, ROW_HEIGHT + 4.0));
            for column in &columns {
                label(ui, view, column);
            }
        });
        ScrollArea::horizontal().id_salt("trees").show(ui, |ui| {
            // The scroll area would lay the heading and the rows side by side otherwise.
            ui.vertical(|ui| chosen = trees(ui, view, rows, &columns, width));
        });
    });
    if let Some(config) = chosen {
        use_tree(config, commands);
    }
}

/// How wide a tree's column must be for none of its texts to be cut.
fn widest(ui: &Ui, rows: &[TreeStats], columns: &[&'static Column]) -> f32 {
    let width = |text: String, font: &FontId| {
        ui.painter().layout_no_wrap(text, font.clone(), Color32::WHITE).size().x
    };
    let (mono, body) = (widgets::number_font(ui), widgets::body_font(ui));
    let cells = columns.iter().flat_map(|c| rows.iter().map(|row| width(c.shown(row), &mono)));
    let names = rows.iter().map(|row| width(row.name.clone(), &body));
    cells.chain(names).fold(0.0, f32::max) + 10.0
}

/// The columns of numbers. The settings of the tree whose name was clicked.
fn trees(
    ui: &mut Ui,
    view: &AppView,
    rows: &[TreeStats],
    columns: &[&'static Column],
    width: f32,
) -> Option<BuildConfig> {
    let mut chosen = None;
    ui.spacing_mut().item_spacing = vec2(BETWEEN, 0.0);
    let table = TableBuilder::new(ui)
        .vscroll(false)
        .striped(false)
        .columns(Cell::exact(width), rows.len())
        .cell_layout(Layout::right_to_left(Align::Center));
    let table = table.header(ROW_HEIGHT + 4.0, |mut header| {
        for row in rows {
            header.col(|ui| {
                if heading(ui, view, row) {
                    chosen = Some(row.config);
                }
            });
        }
    });
    table.body(|mut body| {
        for column in columns {
            let best = columns::best_rows(rows, column);
            body.row(ROW_HEIGHT, |mut line| {
                for (i, row) in rows.iter().enumerate() {
                    line.col(|ui| cell(ui, view, column, row, best.contains(&i)));
                }
            });
        }
    });
    chosen
}

fn use_tree(config: BuildConfig, commands: &mut Commands) {
    commands.edit(move |s| *s.build_mut() = config);
}

/// A figure's name with its unit.
fn label(ui: &mut Ui, view: &AppView, column: &Column) {
    let (rect, response) = ui.allocate_exact_size(vec2(LABEL_WIDTH, ROW_HEIGHT), Sense::hover());
    let text = widgets::capitalised(column.title);
    let unit_width = if column.unit.is_empty() { 0.0 } else { 28.0 };
    let name = Rect::from_x_y_ranges(rect.left()..=rect.right() - unit_width, rect.y_range());
    let unit = Rect::from_x_y_ranges(rect.right() - unit_width..=rect.right() - 2.0, rect.y_range());
    widgets::paint_text(ui, name, Side::Left, &text, widgets::body_font(ui), ui.visuals().text_color());
    widgets::paint_text(ui, unit, Side::Right, column.unit, widgets::small_font(ui), view.palette.muted);
    response.widget_info(|| WidgetInfo::labeled(Role::RowHeader, true, column.heading()));
    response.on_hover_text(format!("{}.", widgets::capitalised(column.meaning)));
}

/// A tree's name. True if it was clicked.
fn heading(ui: &mut Ui, view: &AppView, row: &TreeStats) -> bool {
    let current = row.config == *view.session.build();
    let color = if current { view.palette.accent } else { ui.visuals().strong_text_color() };
    ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
    ui.spacing_mut().button_padding.x = 3.0;
    let text = RichText::new(&row.name).strong().color(color);
    let hover = format!("{}. Click to use this tree.", summary(&row.config));
    ui.add(Button::new(text).frame_when_inactive(false)).on_hover_text(hover).clicked()
}

fn cell(ui: &mut Ui, view: &AppView, column: &Column, row: &TreeStats, best: bool) {
    let rect = ui.max_rect();
    let text = column.shown(row);
    if best {
        let fill = view.palette.good.gamma_multiply(0.16);
        ui.painter().rect_filled(rect.shrink2(vec2(0.0, 1.0)), 3.0, fill);
    }
    let color = if best { view.palette.good } else { ui.visuals().text_color() };
    let inner = rect.shrink2(vec2(4.0, 0.0));
    widgets::paint_text(ui, inner, Side::Right, &text, widgets::number_font(ui), color);
    let response = ui.allocate_rect(rect, Sense::hover());
    let mark = if best { ", the best" } else { "" };
    response.widget_info(|| {
        WidgetInfo::labeled(Role::Cell, true, format!("{} {}: {text}{mark}", row.name, column.heading()))
    });
}

fn copy(ui: &mut Ui, rows: &[TreeStats], commands: &mut Commands) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        if ui.button("Copy as CSV").on_hover_text("All columns with all digits, for programs.").clicked() {
            commands.push(Command::CopyText { text: text::csv(rows), what: "table" });
        }
        if ui.button("Copy as Markdown").on_hover_text("A table for people.").clicked() {
            commands.push(Command::CopyText { text: text::markdown(rows), what: "table" });
        }
    });
}
