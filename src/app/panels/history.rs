//! The builds of this run as a plot and a list, each of which brings its settings back.

use egui::accesskit::Role;
use egui::{Rect, Sense, Ui, WidgetInfo, vec2};

use crate::app::commands::Commands;
use crate::app::view::{AppView, HistoryEntry};
use crate::inspect::plot::{Axis, Ink, Mark, Plot, Series};

use super::build::summary;
use super::chart::Chart;
use super::glossary::Term;
use super::numbers;
use super::widgets;

/// Height of a build in the list.
const LINE_HEIGHT: f32 = 18.0;

/// What the history's plot shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Quantity {
    BuildTime,
    #[default]
    SahCost,
    NodesVisited,
}

impl Quantity {
    const ALL: [Self; 3] = [Self::BuildTime, Self::SahCost, Self::NodesVisited];

    fn term(self) -> Term {
        match self {
            Self::BuildTime => Term::BuildTime,
            Self::SahCost => Term::SahCost,
            Self::NodesVisited => Term::NodesVisited,
        }
    }

    fn short_name(self) -> &'static str {
        match self {
            Self::BuildTime => "Build, ms",
            Self::SahCost => "SAH cost",
            Self::NodesVisited => "Visited",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::BuildTime => "ms",
            Self::SahCost | Self::NodesVisited => "",
        }
    }

    fn of(self, entry: &HistoryEntry) -> Option<f64> {
        match self {
            // What reading a tree takes is no build.
            Self::BuildTime => entry.tree.is_none().then_some(entry.build_ms),
            Self::SahCost => entry.sah_cost,
            Self::NodesVisited => entry.nodes_visited_mean,
        }
    }
}

/// View state of the history.
#[derive(Default)]
pub struct History {
    quantity: Quantity,
}

impl History {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::History);
        if view.history.is_empty() {
            widgets::caption(ui, view.palette, "None yet.");
            return;
        }
        let describe = |q: Quantity| (q.short_name(), q.term().text());
        if let Some(quantity) =
            widgets::segments(ui, Term::History, Some(self.quantity), &Quantity::ALL, &describe)
        {
            self.quantity = quantity;
        }
        let in_plot = history_plot(ui, view, self.quantity, commands);
        let in_list = history_list(ui, view);
        if let Some(entry) = in_plot.or(in_list) {
            let (config, tree) = (entry.config, entry.tree.clone());
            commands.edit(move |s| {
                *s.build_mut() = config;
                s.variants[s.active].tree = tree;
            });
        }
    }
}

/// The build that was clicked.
fn history_plot<'a>(
    ui: &mut Ui,
    view: &AppView<'a>,
    quantity: Quantity,
    commands: &mut Commands,
) -> Option<&'a HistoryEntry> {
    let points: Vec<[f64; 2]> =
        view.history.iter().filter_map(|e| Some([e.number as f64, quantity.of(e)?])).collect();
    let (first, last) = (view.history.first()?.number as f64, view.history.last()?.number as f64);
    let current = view.history.last().and_then(|e| Some([e.number as f64, quantity.of(e)?]));
    let x = Axis::integers(first, last.max(first + 7.0), 8).labelled("build");
    let y = Axis::around(points.iter().map(|p| p[1])).labelled(quantity.term().label()).unit(quantity.unit());
    let mut plot = Plot::new(quantity.term().label(), x, y)
        .of("the builds of one run")
        .with(
            Series::new("line", Mark::Line { width: 1.0 }, Ink::Accent)
                .faint(0.6)
                .at(points.clone())
                .decoration(),
        )
        .with(Series::new("builds", Mark::Dots { radius: 2.5, filled: true }, Ink::Accent).at(points));
    if let Some(current) = current {
        plot = plot.with(
            Series::new("newest", Mark::Dots { radius: 3.5, filled: true }, Ink::Second)
                .at([current])
                .decoration(),
        );
    }
    let shown = Chart { plot, height: 124.0, clickable: true }.show(ui, view.palette, commands);
    let number = shown.hover?.x.round();
    let entry = view.history.iter().find(|e| e.number as f64 == number)?;
    let clicked = shown.response.clicked();
    shown.response.on_hover_ui_at_pointer(|ui| entry_tooltip(ui, entry));
    clicked.then_some(entry)
}

/// What stands for a build: its settings, or the file of its tree.
fn title(entry: &HistoryEntry) -> String {
    match &entry.tree {
        Some(tree) => format!("imported {}", tree.path.file_name().unwrap_or_default().to_string_lossy()),
        None => summary(&entry.config),
    }
}

fn entry_tooltip(ui: &mut Ui, entry: &HistoryEntry) {
    ui.strong(format!("Build {}", entry.number));
    ui.label(title(entry));
    ui.label(format!("{}, {} ms", entry.scene, numbers::decimal(entry.build_ms, 2)));
    ui.label(format!(
        "SAH cost {}, nodes visited {}",
        numbers::decimal(entry.sah_cost, 2),
        numbers::decimal(entry.nodes_visited_mean, 2)
    ));
    ui.label("Click to return to these settings.");
}

/// Newest first. The build that was clicked.
fn history_list<'a>(ui: &mut Ui, view: &AppView<'a>) -> Option<&'a HistoryEntry> {
    let mut clicked = None;
    let width = ui.available_width();
    let columns = list_columns(width);
    list_line(ui, view, Sense::hover(), columns, None);
    let rows = view.history.len();
    egui::ScrollArea::vertical().id_salt("history").max_height(8.0 * LINE_HEIGHT).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for i in (0..rows).rev() {
            let entry = &view.history[i];
            if list_line(ui, view, Sense::click(), columns, Some(entry)) {
                clicked = Some(entry);
            }
        }
    });
    clicked
}

/// Right edges of the three figures' columns, from the right.
fn list_columns(width: f32) -> [f32; 3] {
    let each = (0.17 * width).clamp(46.0, 80.0);
    [8.0, 8.0 + each, 8.0 + 2.0 * each]
}

/// The heading (`None`) or a build. True if it was clicked.
fn list_line(
    ui: &mut Ui,
    view: &AppView,
    sense: Sense,
    columns: [f32; 3],
    entry: Option<&HistoryEntry>,
) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), sense);
    let muted = view.palette.muted;
    let cell = |right: f32, width: f32| {
        Rect::from_x_y_ranges(rect.right() - right - width..=rect.right() - right, rect.y_range())
    };
    let width = columns[1] - columns[0] - 4.0;
    let left =
        Rect::from_x_y_ranges(rect.left() + 4.0..=rect.right() - columns[2] - width - 6.0, rect.y_range());
    let Some(entry) = entry else {
        let font = widgets::small_font(ui);
        widgets::paint_text(ui, left, widgets::Side::Left, "Settings", font.clone(), muted);
        for (quantity, right) in Quantity::ALL.into_iter().rev().zip(columns) {
            let name = quantity.short_name();
            widgets::paint_text(ui, cell(right, width), widgets::Side::Right, name, font.clone(), muted);
        }
        return false;
    };
    let current = view.history.last().is_some_and(|e| e.number == entry.number);
    widgets::paint_line(ui, rect, &response, current);
    let color = if current { view.palette.accent } else { ui.visuals().text_color() };
    let text = title(entry);
    widgets::paint_text(ui, left, widgets::Side::Left, &text, widgets::body_font(ui), color);
    let mut font = widgets::number_font(ui);
    font.size -= 1.0;
    for (quantity, right) in Quantity::ALL.into_iter().rev().zip(columns) {
        let value = quantity.of(entry).map_or(numbers::DASH.to_owned(), compact);
        widgets::paint_text(ui, cell(right, width), widgets::Side::Right, &value, font.clone(), color);
    }
    response.widget_info(|| {
        WidgetInfo::selected(Role::Button, true, current, format!("Build {}: {text}", entry.number))
    });
    let clicked = response.clicked();
    response.on_hover_ui(|ui| entry_tooltip(ui, entry));
    clicked
}

/// Five digits at most, so that it fits a narrow column.
fn compact(x: f64) -> String {
    let decimals = if x.abs() >= 1000.0 {
        0
    } else if x.abs() >= 100.0 {
        1
    } else {
        2
    };
    numbers::decimal(x, decimals)
}
