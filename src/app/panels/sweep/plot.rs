//! Points of a sweep as a plot: two figures across and up, a third as colour, and the front that no tree beats.

use egui::{Color32, ComboBox, Rect, Sense, Ui, vec2};

use crate::accel::BuildConfig;
use crate::app::commands::Commands;
use crate::app::theme::Palette;
use crate::app::view::AppView;
use crate::inspect::columns::{COLUMNS, Column, Row};
use crate::inspect::plot::ColorKey;
use crate::inspect::sweep::SweepPoint;
use crate::inspect::sweep::plot::{SweepPlot, spans_a_decade};

use super::super::build::summary;
use super::super::chart::Chart;
use super::super::glossary::Term;
use super::super::widgets;

/// The mouse points at what is no farther away than this, in points.
const REACH: f32 = 14.0;
/// Which figures are plotted.
#[derive(Default)]
pub struct PlotForm {
    figures: SweepPlot,
}

impl PlotForm {
    pub fn columns(&self) -> [&'static Column; 2] {
        self.figures.columns()
    }

    /// The points on the front of the two figures.
    pub fn front(&self, points: &[SweepPoint]) -> Vec<usize> {
        self.figures.front(points)
    }

    /// Draws it. The settings of the point that was clicked.
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) -> Option<BuildConfig> {
        widgets::term_section(ui, Term::SweepPlot);
        let points = &view.sweep.points;
        let SweepPlot { x, y, color, log } = &mut self.figures;
        choose(ui, Term::PlotX, x, points);
        choose(ui, Term::PlotY, y, points);
        choose(ui, Term::PlotColor, color, points);
        ui.horizontal(|ui| {
            for (log, (axis, column)) in log.iter_mut().zip([("across", *x), ("up", *y)]) {
                // Over less than a decade a logarithm hides more than it shows.
                if *log || spans_a_decade(points, column) {
                    ui.checkbox(log, format!("logarithmic {axis}"));
                }
            }
        });
        self.chart(ui, view, commands)
    }

    fn chart(&self, ui: &mut Ui, view: &AppView, commands: &mut Commands) -> Option<BuildConfig> {
        let points = &view.sweep.points;
        let mut plot = self.figures.plot(points, Some(view.session.build()));
        plot.title = Term::SweepPlot.label().to_owned();
        plot.subject = view.scene.map_or_else(String::new, |scene| scene.name.clone());
        let axes = [plot.x.clone(), plot.y.clone()];
        let key = plot.key.clone();
        let chart = Chart { plot, height: 240.0, clickable: true };
        let shown = chart.show(ui, view.palette, commands);
        if let Some(key) = key {
            color_legend(ui, view, &key);
        }
        let Palette { accent, second, .. } = *view.palette;
        widgets::legend(ui, view.palette, &[("Pareto front", second), ("current settings", accent)]);
        let hover = shown.hover?;
        let size = shown.response.rect.size();
        let distance = |values: [f64; 2]| {
            let apart = |i: usize, at: f64, length: f32| {
                let [low, high] = axes[i].range;
                ((axes[i].scale.place(values[i]) - at) / (high - low)) as f32 * length
            };
            vec2(apart(0, hover.x, size.x), apart(1, hover.y, size.y)).length()
        };
        let placed = points.iter().filter_map(|point| Some((point, distance(self.figures.place(point)?))));
        let nearest = placed.min_by(|a, b| a.1.total_cmp(&b.1));
        let (point, _) = nearest.filter(|(_, distance)| *distance <= REACH)?;
        let clicked = shown.response.clicked();
        shown.response.on_hover_ui_at_pointer(|ui| self.tooltip(ui, point));
        clicked.then_some(point.config)
    }

    fn tooltip(&self, ui: &mut Ui, point: &SweepPoint) {
        ui.strong(summary(&point.config));
        let mut said = Vec::new();
        for column in [self.figures.x, self.figures.y, self.figures.color] {
            if !said.contains(&column.key) {
                said.push(column.key);
                ui.label(format!("{} {}", column.heading(), column.shown(point)));
            }
        }
        ui.label("Click to build with it.");
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

/// The bar of colours with its ends.
fn color_legend(ui: &mut Ui, view: &AppView, key: &ColorKey) {
    ui.horizontal(|ui| {
        let muted = |text: &str| egui::RichText::new(text).small().color(view.palette.muted);
        ui.label(muted(&key.label));
        ui.label(muted(&key.ends[0]));
        let width = (ui.available_width() - 60.0).clamp(40.0, 140.0);
        let (rect, _) = ui.allocate_exact_size(vec2(width, 8.0), Sense::hover());
        let count = key.colors.len();
        for (i, [r, g, b]) in key.colors.iter().enumerate() {
            let edge = |k: usize| rect.left() + rect.width() * k as f32 / count as f32;
            let piece = Rect::from_x_y_ranges(edge(i)..=edge(i + 1) + 0.5, rect.y_range());
            ui.painter().rect_filled(piece, 0.0, Color32::from_rgb(*r, *g, *b));
        }
        ui.label(muted(&key.ends[1]));
    });
}
