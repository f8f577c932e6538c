//! Every figure of A and of B, their difference and percentage, coloured by better or worse.

use egui::accesskit::Role;
use egui::{Color32, Rect, Sense, Ui, WidgetInfo, vec2};

use crate::app::theme::Palette;
use crate::app::view::AppView;
use crate::inspect::compare::{ComparedFigure, Comparison};
use crate::inspect::paired_cost::MeanInterval;

use super::super::glossary::Term;
use super::super::numbers;
use super::super::widgets::{self, Side};

const LINE: f32 = 17.0;
/// From here on a figure has one line with four numbers, below it two with two.
const WIDE: f32 = 470.0;
const BETWEEN: f32 = 8.0;

/// The mean ray cost of both, with its confidence.
pub fn ray_cost(ui: &mut Ui, view: &AppView, names: [&str; 2]) {
    let Some(comparison) = &view.ab.figures else { return };
    let Some(cost) = &comparison.ray_cost else { return };
    let p = view.palette;
    widgets::term_section(ui, Term::PairedRayCost);
    for (name, mean) in names.into_iter().zip([&cost.a, &cost.b]) {
        line(ui, name, &mean.shown(), ui.visuals().strong_text_color());
    }
    let is_sure = cost.difference.is_sure();
    let color = match (is_sure, cost.difference.mean < 0.0) {
        (false, _) => p.muted,
        (true, true) => p.good,
        (true, false) => p.error,
    };
    let percent = cost.percent.map_or_else(String::new, |p| format!("  {}", signed(&format!("{p:+.1} %"))));
    let shown = format!("{}{percent}", signed_mean(&cost.difference));
    let name = format!("{} - {}, ray by ray", names[1], names[0]);
    line(ui, &name, &shown, color);
    let rays = numbers::count(cost.ray_count);
    let text = match (is_sure, cost.difference.half_width_95) {
        (true, _) => format!("Of {rays} camera rays; ± is the 95 % interval. The difference is no chance."),
        (false, Some(0.0)) => format!("Of {rays} camera rays, each of which costs the same in both."),
        (false, _) => {
            format!("Of {rays} camera rays; ± is the 95 % interval. The difference may be chance.")
        }
    };
    widgets::caption(ui, p, text);
}

fn signed_mean(mean: &MeanInterval) -> String {
    let sign = if mean.mean > 0.0 { "+" } else { "" };
    signed(&format!("{sign}{}", mean.shown()))
}

/// With the minus sign that is as wide as the plus.
fn signed(text: &str) -> String {
    text.replace('-', "−")
}

/// A name and a number.
fn line(ui: &mut Ui, name: &str, value: &str, color: Color32) {
    let (rect, response) = ui.allocate_exact_size(vec2(widgets::form_width(ui), LINE), Sense::hover());
    let mono = widgets::number_font(ui);
    let width = widgets::elided(ui, value, mono.clone(), color, rect.width()).size().x;
    widgets::paint_text(ui, rect, Side::Right, value, mono, color);
    let label = rect.with_max_x(rect.right() - width - BETWEEN);
    let text = ui.visuals().text_color();
    widgets::paint_text(ui, label, Side::Left, name, widgets::body_font(ui), text);
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name}: {value}")));
}

/// The table; whether what is equal is left out from now on.
pub fn table(ui: &mut Ui, view: &AppView, names: [&str; 2], hide_equal: bool) -> bool {
    widgets::section(ui, "Figures");
    let Some(comparison) = &view.ab.figures else {
        let text = match (view.ab.ready, &view.ab.measuring) {
            ([true, true], Some(_)) => "Measuring both trees…",
            ([true, true], None) => "Not measured yet.",
            _ => "Waiting for both trees.",
        };
        widgets::caption(ui, view.palette, text);
        return hide_equal;
    };
    // One line in any case, so that what lies below keeps its place.
    let share = |share: f32| format!(" {:.0} %", 100.0 * share);
    let text = match &view.ab.measuring {
        Some(job) => format!("Measuring both trees…{}", job.fraction.map_or_else(String::new, share)),
        None if view.ab.stale => "Measured again when the picture rests.".to_owned(),
        None => {
            let stats = &comparison.a;
            let (rays, size) = (stats.count.name(), stats.settings);
            format!("Of {rays} rays at {} x {} pixels.", size.width, size.height)
        }
    };
    widgets::caption(ui, view.palette, text);
    if !comparison.has_one_unit() {
        let text =
            "The two have other costs C_t and C_i: their SAH costs and ray costs have different units.";
        widgets::notice(ui, view.palette.warning, text);
    }
    let hide = if widgets::switch(ui, Term::HideEqual, hide_equal) { !hide_equal } else { hide_equal };
    let rows: Vec<&ComparedFigure> =
        comparison.rows.iter().filter(|row| has_values(row) && !(hide && row.is_equal())).collect();
    if rows.is_empty() {
        widgets::caption(ui, view.palette, "Every figure is equal.");
        return hide;
    }
    let columns = Columns::of(ui, comparison);
    heading(ui, view, names, &columns);
    ui.spacing_mut().item_spacing.y = 0.0;
    for row in rows {
        figure(ui, view.palette, row, names, &columns);
    }
    hide
}

/// What is missing on both sides says nothing.
fn has_values(row: &ComparedFigure) -> bool {
    let is_known = |value| row.column.show(value) != numbers::DASH;
    is_known(&row.a) || is_known(&row.b)
}

/// How wide each number's column is.
struct Columns {
    wide: bool,
    value: f32,
}

impl Columns {
    fn of(ui: &Ui, comparison: &Comparison) -> Self {
        let wide = ui.available_width() >= WIDE;
        let mono = widgets::number_font(ui);
        let width = |text: &str| widgets::elided(ui, text, mono.clone(), Color32::WHITE, 1e4).size().x;
        let texts = comparison.rows.iter().filter(|row| row.difference.is_some()).flat_map(|row| {
            [row.column.show(&row.a), row.column.show(&row.b), row.shown_difference(), row.shown_percent()]
        });
        let widest = texts.map(|text| width(&text)).fold(40.0, f32::max);
        let share = if wide { 0.17 } else { 0.3 };
        Self { wide, value: widest.min(share * ui.available_width()) }
    }

    /// The cell of a number, counted from the right.
    fn cell(&self, rect: Rect, from_right: usize) -> Rect {
        let right = rect.right() - from_right as f32 * (self.value + BETWEEN);
        Rect::from_x_y_ranges(right - self.value..=right, rect.y_range())
    }
}

fn heading(ui: &mut Ui, view: &AppView, [a, b]: [&str; 2], columns: &Columns) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), LINE), Sense::hover());
    let names: &[&str] = if columns.wide { &["percent", "difference", b, a] } else { &[b, a] };
    for (i, name) in names.iter().enumerate() {
        let cell = columns.cell(rect, i);
        widgets::paint_text(ui, cell, Side::Right, name, widgets::small_font(ui), view.palette.muted);
    }
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().hline(rect.x_range(), rect.bottom(), stroke);
}

fn figure(ui: &mut Ui, palette: &Palette, row: &ComparedFigure, names: [&str; 2], columns: &Columns) {
    let has_difference = row.difference.is_some_and(|d| d != 0.0);
    let lines = if columns.wide || !has_difference { 1.0 } else { 2.0 };
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), lines * LINE + 2.0), Sense::hover());
    let first = Rect::from_min_size(rect.min, vec2(rect.width(), LINE));
    let second = first.translate(vec2(0.0, if columns.wide { 0.0 } else { LINE }));
    let (a, b) = (row.column.show(&row.a), row.column.show(&row.b));
    let (difference, percent) = (signed(&row.shown_difference()), signed(&row.shown_percent()));
    let color = match row.better {
        Some(true) => palette.good,
        Some(false) => palette.error,
        None => palette.muted,
    };
    let mono = widgets::number_font(ui);
    let text = ui.visuals().text_color();
    let ahead = if columns.wide { 2 } else { 0 };
    widgets::paint_text(ui, columns.cell(first, ahead), Side::Right, &b, mono.clone(), text);
    widgets::paint_text(ui, columns.cell(first, ahead + 1), Side::Right, &a, mono.clone(), text);
    if has_difference {
        widgets::paint_text(ui, columns.cell(second, 0), Side::Right, &percent, mono.clone(), color);
        widgets::paint_text(ui, columns.cell(second, 1), Side::Right, &difference, mono, color);
    }
    let numbers = if columns.wide { 4 } else { 2 };
    let label = first.with_max_x(columns.cell(first, numbers - 1).left() - BETWEEN);
    let name = widgets::capitalised(&row.column.heading());
    widgets::paint_text(ui, label, Side::Left, &name, widgets::body_font(ui), text);
    let verdict = row.better.map_or("", |better| if better { ", better" } else { ", worse" });
    let said = format!("{name}: {} {a}, {} {b}, {difference} {percent}{verdict}", names[0], names[1]);
    response.widget_info(|| WidgetInfo::labeled(Role::Row, true, &said));
    response.on_hover_ui(|ui| {
        ui.set_max_width(280.0);
        ui.strong(&name);
        ui.label(format!("{}.", widgets::capitalised(row.column.meaning)));
        ui.label(format!("{} {a}, {} {b}{verdict}", names[0], names[1]));
    });
}
