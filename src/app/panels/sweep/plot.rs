//! Points of a sweep as a plot: two figures across and up, a third as colour, and the front that no tree beats.

use egui::{Color32, ComboBox, Rect, Sense, Ui, vec2};
use egui_plot::{Line, PlotPoints, Points};

use crate::accel::BuildConfig;
use crate::app::view::AppView;
use crate::inspect::columns::{COLUMNS, Column, Row};
use crate::inspect::pareto;
use crate::inspect::sweep::{SweepPoint, same_tree};
use crate::render::ColorMap;

use super::super::build::summary;
use super::super::chart::{Axis, Chart};
use super::super::glossary::Term;
use super::super::{numbers, widgets};

/// The mouse points at what is no farther away than this, in points.
const REACH: f32 = 14.0;
/// Steps of the legend's bar.
const STEPS: usize = 48;

/// Which figures, and whether their logarithms.
pub struct PlotForm {
    x: &'static Column,
    y: &'static Column,
    color: &'static Column,
    log: [bool; 2],
}

impl Default for PlotForm {
    fn default() -> Self {
        let of = |key| Column::of(key).expect("the key of a column");
        Self { x: of("build_ms"), y: of("ray_cost_mean"), color: of("leaf"), log: [false; 2] }
    }
}

impl PlotForm {
    pub fn columns(&self) -> [&'static Column; 2] {
        [self.x, self.y]
    }

    /// The points on the front of the two figures.
    pub fn front(&self, points: &[SweepPoint]) -> Vec<usize> {
        pareto::front(points, &self.columns())
    }

    /// Draws it. The settings of the point that was clicked.
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView) -> Option<BuildConfig> {
        widgets::term_section(ui, Term::SweepPlot);
        let points = &view.sweep.points;
        choose(ui, Term::PlotX, &mut self.x, points);
        choose(ui, Term::PlotY, &mut self.y, points);
        choose(ui, Term::PlotColor, &mut self.color, points);
        ui.horizontal(|ui| {
            for (log, (axis, column)) in self.log.iter_mut().zip([("across", self.x), ("up", self.y)]) {
                // Over less than a decade a logarithm hides more than it shows.
                if *log || spans_a_decade(points, column) {
                    ui.checkbox(log, format!("logarithmic {axis}"));
                }
            }
        });
        self.chart(ui, view)
    }

    fn chart(&self, ui: &mut Ui, view: &AppView) -> Option<BuildConfig> {
        let points = &view.sweep.points;
        let places: Vec<Option<[f64; 2]>> = points.iter().map(|p| self.place(p)).collect();
        let span = |axis: usize| places.iter().flatten().map(move |p| p[axis]);
        let axes = [0, 1].map(|i| axis(span(i), self.log[i], self.columns()[i]));
        let ranges = [axes[0].range, axes[1].range];
        let colors = Colors::of(points, self.color);
        let current = points.iter().position(|p| same_tree(&p.config, view.session.build()));
        let mut front: Vec<[f64; 2]> = self.front(points).into_iter().filter_map(|i| places[i]).collect();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let marks: Vec<(usize, [f64; 2], Color32)> = places
            .iter()
            .enumerate()
            .filter_map(|(i, place)| Some((i, (*place)?, colors.color(&points[i], view.palette.muted))))
            .collect();
        let here = current.and_then(|i| places[i]);
        let [x, y] = axes;
        let chart = Chart { label: Term::SweepPlot.label(), height: 240.0, x, y, clickable: true };
        let (accent, line) = (view.palette.accent, view.palette.second);
        let drawn = marks.clone();
        let shown = chart.show(ui, view.palette, move |plot| {
            plot.line(
                Line::new("front", PlotPoints::from(front.clone())).color(line).width(1.5).allow_hover(false),
            );
            let ring = Points::new("front points", PlotPoints::from(front)).color(line).radius(5.5);
            plot.points(ring.filled(false).allow_hover(false));
            for (_, place, color) in drawn {
                let point = Points::new("point", PlotPoints::from(vec![place])).color(color).radius(3.0);
                plot.points(point.allow_hover(false));
            }
            if let Some(place) = here {
                let mark = Points::new("current", PlotPoints::from(vec![place])).color(accent).radius(7.0);
                let mark = mark.shape(egui_plot::MarkerShape::Square).filled(false);
                plot.points(mark.allow_hover(false));
            }
        });
        colors.legend(ui, view);
        widgets::legend(ui, view.palette, &[("Pareto front", line), ("current settings", accent)]);
        let hover = shown.hover?;
        let size = shown.response.rect.size();
        let distance = |place: &[f64; 2]| {
            let apart = |i: usize, at: f64, length: f32| {
                ((place[i] - at) / (ranges[i][1] - ranges[i][0])) as f32 * length
            };
            vec2(apart(0, hover.x, size.x), apart(1, hover.y, size.y)).length()
        };
        let nearest = marks.iter().min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
        let (i, ..) = nearest.filter(|(_, place, _)| distance(place) <= REACH)?;
        let point = &points[*i];
        let clicked = shown.response.clicked();
        shown.response.on_hover_ui_at_pointer(|ui| self.tooltip(ui, point));
        clicked.then_some(point.config)
    }

    fn tooltip(&self, ui: &mut Ui, point: &SweepPoint) {
        ui.strong(summary(&point.config));
        let mut said = Vec::new();
        for column in [self.x, self.y, self.color] {
            if !said.contains(&column.key) {
                said.push(column.key);
                ui.label(format!("{} {}", column.heading(), column.shown(point)));
            }
        }
        ui.label("Click to build with it.");
    }

    fn place(&self, point: &SweepPoint) -> Option<[f64; 2]> {
        let of = |column: &Column, log: bool| {
            let value = point.value(column).number()? / column.shown_unit;
            if !log { Some(value) } else { (value > 0.0).then(|| value.log10()) }
        };
        Some([of(self.x, self.log[0])?, of(self.y, self.log[1])?])
    }
}

/// Numbers of which some point has one.
fn choose(ui: &mut Ui, term: Term, column: &mut &'static Column, points: &[SweepPoint]) {
    widgets::row(ui, term, |ui| {
        let has = |c: &&Column| points.iter().any(|p| p.value(c).number().is_some());
        let shown = widgets::capitalised(&column.heading());
        ComboBox::from_id_salt(term.label())
            .width(ui.available_width())
            .selected_text(shown)
            .truncate()
            .show_ui(ui, |ui| {
                for choice in COLUMNS.iter().filter(|c| !c.is_text()).filter(has) {
                    let name = widgets::capitalised(&choice.heading());
                    let about = format!("{}.", widgets::capitalised(choice.meaning));
                    let selected = choice.key == column.key;
                    if ui.selectable_label(selected, name).on_hover_text(about).clicked() {
                        *column = choice;
                    }
                }
            })
            .response
            .accessible_name(term.label())
            .on_hover_text(term.text());
    });
}

fn ends(points: &[SweepPoint], column: &Column) -> Option<[f64; 2]> {
    let values = || points.iter().filter_map(|p| p.value(column).number());
    Some([values().reduce(f64::min)?, values().reduce(f64::max)?])
}

fn spans_a_decade(points: &[SweepPoint], column: &Column) -> bool {
    ends(points, column).is_some_and(|[low, high]| low > 0.0 && high >= 10.0 * low)
}

fn axis(values: impl Iterator<Item = f64>, log: bool, column: &'static Column) -> Axis {
    let mut axis = Axis::around(values);
    if log {
        let [low, high] = axis.range;
        let (first, last) = (low.floor() as i32, high.ceil() as i32);
        let steps =
            (first..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|m: f64| m.log10() + f64::from(power)));
        axis.ticks = steps.filter(|t| (low..=high).contains(t)).collect();
        axis.text = Box::new(|t| numbers::short(10f64.powf(t)));
    }
    axis.labelled(column.title)
}

/// Colours of a figure from its least to its highest value.
struct Colors {
    column: &'static Column,
    ends: Option<[f64; 2]>,
}

impl Colors {
    fn of(points: &[SweepPoint], column: &'static Column) -> Self {
        Self { column, ends: ends(points, column) }
    }

    fn color(&self, point: &SweepPoint, none: Color32) -> Color32 {
        match (self.ends, point.value(self.column).number()) {
            (Some([low, high]), Some(value)) => at((value - low) / (high - low).max(f64::MIN_POSITIVE)),
            _ => none,
        }
    }

    /// The bar with its ends.
    fn legend(&self, ui: &mut Ui, view: &AppView) {
        let Some([low, high]) = self.ends else { return };
        let [low, high] = [low, high].map(|value| self.column.show_number(value));
        ui.horizontal(|ui| {
            let muted = |text: String| egui::RichText::new(text).small().color(view.palette.muted);
            ui.label(muted(self.column.heading()));
            ui.label(muted(low));
            let width = (ui.available_width() - 60.0).clamp(40.0, 140.0);
            let (rect, _) = ui.allocate_exact_size(vec2(width, 8.0), Sense::hover());
            for i in 0..STEPS {
                let edge = |k: usize| rect.left() + rect.width() * k as f32 / STEPS as f32;
                let piece = Rect::from_x_y_ranges(edge(i)..=edge(i + 1) + 0.5, rect.y_range());
                ui.painter().rect_filled(piece, 0.0, at((i as f64 + 0.5) / STEPS as f64));
            }
            ui.label(muted(high));
        });
    }
}

/// Neither end of the map, which one of the looks would swallow.
fn at(t: f64) -> Color32 {
    let [r, g, b] = ColorMap::Viridis.color((0.12 + 0.8 * t.clamp(0.0, 1.0)) as f32);
    Color32::from_rgb(r, g, b)
}
