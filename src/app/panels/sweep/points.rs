//! Points of a sweep as a table: sorted by the heading that was clicked, as many rows drawn as are seen.

use egui::accesskit::Role;
use egui::{Button, RichText, Sense, Ui, WidgetInfo};
use egui_extras::{Column as Cell, TableBuilder};

use crate::accel::BuildConfig;
use crate::app::view::AppView;
use crate::inspect::columns::{Column, Value};
use crate::inspect::sweep::{SweepPoint, same_tree};

use super::super::glossary::Term;
use super::super::widgets::{self, Side};

const ROW_HEIGHT: f32 = 19.0;
const HEIGHT: f32 = 260.0;
const NUMBER_WIDTH: f32 = 66.0;
const LEAST_NAME: f32 = 118.0;

/// The columns in the order of their worth: what has no room is left out.
const SHOWN: [&str; 7] = ["name", "ray_cost_mean", "build_ms", "sah_cost", "bytes", "epo", "traversal_ms"];

/// By which column, and whether the other way round.
pub struct PointTable {
    by: &'static str,
    reversed: bool,
}

impl Default for PointTable {
    fn default() -> Self {
        Self { by: "ray_cost_mean", reversed: false }
    }
}

impl PointTable {
    /// Draws it. The settings of the row that was clicked.
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, front: &[usize]) -> Option<BuildConfig> {
        widgets::term_section(ui, Term::SweepPoints);
        let points = &view.sweep.points;
        let order = self.order(points);
        let columns = columns(points, ui.available_width());
        let mut chosen = None;
        ui.spacing_mut().item_spacing.x = 2.0;
        let name_width =
            (ui.available_width() - NUMBER_WIDTH * (columns.len() - 1) as f32 - 16.0).max(LEAST_NAME);
        let table = TableBuilder::new(ui)
            .id_salt("sweep points")
            .striped(false)
            .sense(Sense::click())
            .max_scroll_height(HEIGHT)
            .auto_shrink([false, true])
            .column(Cell::exact(name_width))
            .columns(Cell::exact(NUMBER_WIDTH), columns.len() - 1);
        let table = table.header(ROW_HEIGHT + 3.0, |mut header| {
            for column in &columns {
                header.col(|ui| self.heading(ui, column));
            }
        });
        table.body(|body| {
            body.rows(ROW_HEIGHT, order.len(), |mut row| {
                let i = order[row.index()];
                let point = &points[i];
                row.set_selected(same_tree(&point.config, view.session.build()));
                for column in &columns {
                    row.col(|ui| cell(ui, view, column, point, front.contains(&i)));
                }
                let response = row.response();
                response
                    .widget_info(|| WidgetInfo::labeled(Role::Row, true, format!("Point {}", point.name())));
                if response.on_hover_text("Click to build with it.").clicked() {
                    chosen = Some(point.config);
                }
            });
        });
        chosen
    }

    fn heading(&mut self, ui: &mut Ui, column: &'static Column) {
        let sorted = self.by == column.key;
        let text = RichText::new(column.heading()).small().strong();
        ui.spacing_mut().button_padding.x = 2.0;
        let button = Button::new(text).frame_when_inactive(false).truncate();
        let response = ui.add_sized(ui.available_size(), button);
        let response = response.accessible_name(format!("Sort by {}", column.heading()));
        if sorted {
            sort_mark(ui, response.rect, self.reversed);
        }
        if response.on_hover_text(format!("{}.", widgets::capitalised(column.meaning))).clicked() {
            self.reversed = sorted && !self.reversed;
            self.by = column.key;
        }
    }

    /// Points without a value come last, whichever way.
    fn order(&self, points: &[SweepPoint]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let Some(column) = Column::of(self.by) else { return order };
        let values: Vec<Value> = points.iter().map(|p| column.value(p)).collect();
        order.sort_by(|&a, &b| {
            let by = match (&values[a], &values[b]) {
                (Value::Text(a), Value::Text(b)) => a.cmp(b),
                (a, b) => match (a.number(), b.number()) {
                    (Some(a), Some(b)) => a.total_cmp(&b),
                    (a, b) => return b.is_some().cmp(&a.is_some()),
                },
            };
            if self.reversed { by.reverse() } else { by }
        });
        order
    }
}

/// A small triangle at the upper edge of a heading: up for ascending values.
fn sort_mark(ui: &Ui, heading: egui::Rect, reversed: bool) {
    let (middle, up) = (heading.center_top() + egui::vec2(0.0, 3.0), if reversed { 1.0 } else { -1.0 });
    let corners = [[-3.5, -2.0], [3.5, -2.0], [0.0, 2.0]].map(|[x, y]| middle + egui::vec2(x, up * y));
    let color = ui.visuals().strong_text_color();
    ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), color, egui::Stroke::NONE));
}

fn columns(points: &[SweepPoint], width: f32) -> Vec<&'static Column> {
    let room = ((width - LEAST_NAME - 16.0) / NUMBER_WIDTH).max(1.0) as usize;
    let has = |c: &&Column| points.iter().any(|p| c.value(p) != Value::Missing);
    SHOWN.iter().filter_map(|key| Column::of(key)).filter(has).take(1 + room).collect()
}

fn cell(ui: &mut Ui, view: &AppView, column: &Column, point: &SweepPoint, on_front: bool) {
    let rect = ui.max_rect().shrink2(egui::vec2(3.0, 0.0));
    let text = column.shown(point);
    let color = if on_front { view.palette.second } else { ui.visuals().text_color() };
    if column.is_text() {
        widgets::paint_text(ui, rect, Side::Left, &text, widgets::small_font(ui), color);
    } else {
        widgets::paint_text(ui, rect, Side::Right, &text, widgets::number_font(ui), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::stats::TreeStats;

    #[test]
    fn rows_are_sorted_both_ways_and_what_is_missing_comes_last() {
        let point = |name: &str, cost| {
            let mut stats = TreeStats::example(name);
            stats.rays.ray_cost_mean = cost;
            SweepPoint::of(&stats)
        };
        let points = [point("a", Some(3.0)), point("b", None), point("c", Some(1.0)), point("d", Some(2.0))];
        let mut table = PointTable::default();
        assert_eq!(table.order(&points), [2, 3, 0, 1]);
        table.reversed = true;
        assert_eq!(table.order(&points), [0, 3, 2, 1]);
        table.by = "name";
        assert_eq!(table.order(&points), [3, 2, 1, 0]);
    }
}
