//! Which tree is built, how the build went, and the builds before it.

use egui::accesskit::Role;
use egui::{Color32, DragValue, Rect, Sense, Ui, WidgetInfo, vec2};
use egui_plot::{Line, PlotPoints, Points};
use std::time::Duration;

use crate::accel::{BuildConfig, Builder, StopRule, Widen, Width};
use crate::app::commands::{Command, Commands};
use crate::app::view::{AppView, HistoryEntry};
use crate::inspect::columns::Better;
use crate::world::World;

use super::chart::{Axis, Chart};
use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure};

/// A build that takes longer shows its progress.
const SLOW: Duration = Duration::from_millis(200);

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

    fn of(self, entry: &HistoryEntry) -> Option<f64> {
        match self {
            Self::BuildTime => Some(entry.build_ms),
            Self::SahCost => entry.sah_cost,
            Self::NodesVisited => entry.nodes_visited_mean,
        }
    }
}

/// View state of the Build panel.
#[derive(Default)]
pub struct BuildPanel {
    /// Whether a slider is held down.
    held: bool,
    quantity: Quantity,
}

impl BuildPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Tree");
        let config = *view.session.build();
        choices(ui, &config, commands);
        self.sliders(ui, &config, commands);
        costs(ui, &config, commands);
        status(ui, view, commands);
        report(ui, view);
        self.history(ui, view, commands);
    }

    fn sliders(&mut self, ui: &mut Ui, config: &BuildConfig, commands: &mut Commands) {
        let (mut bins, mut leaf) = (config.bins, config.leaf);
        let bins_slider = ui
            .add_enabled_ui(config.builder.uses_bins(), |ui| {
                widgets::integer_slider(ui, Term::Bins, &mut bins, BuildConfig::BINS, true)
            })
            .inner
            .on_disabled_hover_text("Only the binned builder uses bins.");
        let leaf_slider = widgets::integer_slider(ui, Term::Leaf, &mut leaf, BuildConfig::LEAF, true);
        let held = bins_slider.dragged() || leaf_slider.dragged();
        if held && !self.held {
            commands.push(Command::HoldRange(true));
        }
        if bins != config.bins {
            commands.edit(move |s| s.build_mut().bins = bins);
        }
        if leaf != config.leaf {
            commands.edit(move |s| s.build_mut().leaf = leaf);
        }
        if !held && self.held {
            commands.push(Command::HoldRange(false));
        }
        self.held = held;
    }

    fn history(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
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
        let clicked = history_plot(ui, view, self.quantity).or_else(|| history_list(ui, view));
        if let Some(config) = clicked {
            commands.edit(move |s| *s.build_mut() = config);
        }
    }
}

fn choices(ui: &mut Ui, config: &BuildConfig, commands: &mut Commands) {
    let describe = |b: Builder| (b.name(), b.description());
    if let Some(builder) =
        widgets::segmented(ui, Term::Builder, Some(config.builder), &Builder::ALL, &describe)
    {
        commands.edit(move |s| s.build_mut().builder = builder);
    }
    let describe = |w: Width| match w {
        Width::W2 => (w.name(), "a binary tree"),
        Width::W4 => (w.name(), "up to four children a node, tested together"),
        Width::W8 => (w.name(), "up to eight children a node, tested together"),
    };
    if let Some(width) = widgets::segmented(ui, Term::Width, Some(config.width), &Width::ALL, &describe) {
        commands.edit(move |s| s.build_mut().width = width);
    }
    if config.width != Width::W2 {
        let describe = |w: Widen| (w.name(), w.description());
        if let Some(widen) = widgets::segmented(ui, Term::Widen, Some(config.widen), &Widen::ALL, &describe) {
            commands.edit(move |s| s.build_mut().widen = widen);
        }
    }
    let median = config.builder == Builder::Median;
    let describe = |r: StopRule| (r.name(), r.description());
    let shown = if median { StopRule::Limit } else { config.stop };
    let stop = ui.add_enabled_ui(!median, |ui| {
        widgets::segmented(ui, Term::Stop, Some(shown), &StopRule::ALL, &describe)
    });
    stop.response.on_disabled_hover_text("The median builder always stops at the leaf limit.");
    if let Some(stop) = stop.inner {
        commands.edit(move |s| s.build_mut().stop = stop);
    }
}

fn costs(ui: &mut Ui, config: &BuildConfig, commands: &mut Commands) {
    let mut traversal = config.traversal_cost;
    if widgets::number(ui, Term::TraversalCost, cost_field(&mut traversal)).changed() {
        commands.edit(move |s| s.build_mut().traversal_cost = traversal);
    }
    let mut intersection = config.intersection_cost;
    if widgets::number(ui, Term::IntersectionCost, cost_field(&mut intersection)).changed() {
        commands.edit(move |s| s.build_mut().intersection_cost = intersection);
    }
}

fn cost_field(cost: &mut f32) -> DragValue<'_> {
    DragValue::new(cost).range(0.01..=BuildConfig::MAX_COST).speed(0.02).max_decimals(2)
}

/// What runs now, or what the tree in the viewport was built with where that is not what is set.
fn status(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    if let Some(job) = view.building.as_ref().filter(|job| job.elapsed >= SLOW) {
        ui.add_space(4.0);
        if widgets::progress(ui, view.palette, job, "Cancel") {
            commands.push(Command::CancelBuild);
        }
    } else if let Some(world) = view.world
        && view.building.is_none()
        && world.report.config != *view.session.build()
    {
        let text = format!("The tree that is shown was built with: {}.", summary(&world.report.config));
        widgets::notice(ui, view.palette.warning, text);
    }
}

/// Settings in a few words, as in `binned 16 · leaf 2 · width 4 split`.
pub fn summary(config: &BuildConfig) -> String {
    let mut text = config.builder.name().to_owned();
    if config.builder.uses_bins() {
        text += &format!(" {}", config.bins);
    }
    text += &format!(" · leaf {}", config.leaf);
    if config.width != Width::W2 {
        text += &format!(" · width {} {}", config.width.name(), config.widen.name());
    }
    if config.stop != StopRule::Limit && config.builder != Builder::Median {
        text += &format!(" · stop {}", config.stop.name());
    }
    let costs = (config.traversal_cost, config.intersection_cost);
    if costs != (1.0, 1.0) {
        text += &format!(" · costs {} {}", costs.0, costs.1);
    }
    text
}

fn report(ui: &mut Ui, view: &AppView) {
    widgets::section(ui, "Report");
    let Some(world) = view.world else {
        widgets::caption(ui, view.palette, "No tree has been built yet.");
        return;
    };
    let before = before(view.history);
    let change = |now: Option<f64>, was: fn(&HistoryEntry) -> Option<f64>| (now, before.and_then(was));
    let figure = |term, value, (now, was): (Option<f64>, Option<f64>), better| {
        Figure::new(term, value).unit("").change(now, was, better)
    };
    let figures = &world.figures;
    let report = &world.report;
    let sah = figures.sah_cost.map(|c| c.total());
    let (bytes, bytes_unit) = numbers::bytes(world.bytes());
    let threads = format!("{} threads.", report.threads);
    let p = view.palette;
    figure(
        Term::BuildTime,
        numbers::decimal(report.build_ms, 2),
        change(Some(report.build_ms), |e| Some(e.build_ms)),
        Better::Lower,
    )
    .unit("ms")
    .note(threads)
    .show(ui, p);
    phases(ui, view, world);
    figure(Term::SahCost, numbers::decimal(sah, 2), change(sah, |e| e.sah_cost), Better::Lower).show(ui, p);
    let visited = view.rays.and_then(|r| r.nodes_visited_mean);
    figure(
        Term::NodesVisited,
        numbers::decimal(visited, 2),
        change(visited, |e| e.nodes_visited_mean),
        Better::Lower,
    )
    .show(ui, p);
    let nodes = Some(figures.node_count as f64);
    figure(
        Term::Nodes,
        numbers::count(figures.node_count as u64),
        change(nodes, |e| Some(e.node_count as f64)),
        Better::Lower,
    )
    .show(ui, p);
    let leaves = Some(figures.leaf_count as f64);
    figure(
        Term::Leaves,
        numbers::count(figures.leaf_count as u64),
        change(leaves, |e| Some(e.leaf_count as f64)),
        Better::Neither,
    )
    .show(ui, p);
    let references = numbers::count(figures.reference_count as u64);
    Figure::new(Term::References, references).unit("").change(None, None, Better::Neither).show(ui, p);
    let deepest = figures.depth_max.map(f64::from);
    figure(
        Term::DepthMax,
        numbers::decimal(deepest, 0),
        change(deepest, |e| e.depth_max.map(f64::from)),
        Better::Lower,
    )
    .show(ui, p);
    figure(
        Term::DepthMean,
        numbers::decimal(figures.depth_mean, 2),
        change(figures.depth_mean, |e| e.depth_mean),
        Better::Lower,
    )
    .show(ui, p);
    figure(Term::Bytes, bytes, change(Some(world.bytes() as f64), |e| Some(e.bytes as f64)), Better::Lower)
        .unit(bytes_unit)
        .show(ui, p);
}

fn phases(ui: &mut Ui, view: &AppView, world: &World) {
    for phase in &world.report.phases {
        Figure::new(Term::BuildPhase, numbers::decimal(phase.ms, 2))
            .label(phase.name)
            .unit("ms")
            .change(None, None, Better::Neither)
            .color(view.palette.muted)
            .part()
            .show(ui, view.palette);
    }
}

/// The build before the newest one, if it was of the same scene.
fn before(history: &[HistoryEntry]) -> Option<&HistoryEntry> {
    let [.., before, newest] = history else { return None };
    (before.scene == newest.scene).then_some(before)
}

/// The settings of the build that was clicked.
fn history_plot(ui: &mut Ui, view: &AppView, quantity: Quantity) -> Option<BuildConfig> {
    let points: Vec<[f64; 2]> =
        view.history.iter().filter_map(|e| Some([e.number as f64, quantity.of(e)?])).collect();
    let (first, last) = (view.history.first()?.number as f64, view.history.last()?.number as f64);
    let current = view.history.last().and_then(|e| Some([e.number as f64, quantity.of(e)?]));
    let chart = Chart {
        label: quantity.term().label(),
        height: 124.0,
        x: Axis::integers(first, last.max(first + 7.0), 8).labelled("build"),
        y: Axis::around(points.iter().map(|p| p[1])),
        clickable: true,
    };
    let (accent, second) = (view.palette.accent, view.palette.second);
    let shown = chart.show(ui, view.palette, move |plot| {
        plot.line(
            Line::new("builds", PlotPoints::from(points.clone()))
                .color(accent.gamma_multiply(0.6))
                .width(1.0)
                .allow_hover(false),
        );
        plot.points(
            Points::new("build", PlotPoints::from(points)).color(accent).radius(2.5).allow_hover(false),
        );
        if let Some(current) = current {
            plot.points(
                Points::new("newest", PlotPoints::from(vec![current]))
                    .color(second)
                    .radius(3.5)
                    .allow_hover(false),
            );
        }
    });
    let number = shown.hover?.x.round();
    let entry = view.history.iter().find(|e| e.number as f64 == number)?;
    let clicked = shown.response.clicked();
    shown.response.on_hover_ui_at_pointer(|ui| entry_tooltip(ui, entry));
    clicked.then_some(entry.config)
}

fn entry_tooltip(ui: &mut Ui, entry: &HistoryEntry) {
    ui.strong(format!("Build {}", entry.number));
    ui.label(summary(&entry.config));
    ui.label(format!("{}, {} ms", entry.scene, numbers::decimal(entry.build_ms, 2)));
    ui.label(format!(
        "SAH cost {}, nodes visited {}",
        numbers::decimal(entry.sah_cost, 2),
        numbers::decimal(entry.nodes_visited_mean, 2)
    ));
    ui.label("Click to return to these settings.");
}

/// Newest first. The settings of the build that was clicked.
fn history_list(ui: &mut Ui, view: &AppView) -> Option<BuildConfig> {
    let mut clicked = None;
    let width = ui.available_width();
    let columns = list_columns(width);
    list_line(ui, view, Sense::hover(), columns, None);
    let rows = view.history.len();
    let height = widgets::FIGURE_HEIGHT;
    egui::ScrollArea::vertical().id_salt("history").max_height(8.0 * height).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for i in (0..rows).rev() {
            let entry = &view.history[i];
            if list_line(ui, view, Sense::click(), columns, Some(entry)) {
                clicked = Some(entry.config);
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
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), widgets::FIGURE_HEIGHT), sense);
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
    paint_row(ui, rect, &response, current);
    let color = if current { view.palette.accent } else { ui.visuals().text_color() };
    let text = summary(&entry.config);
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

fn paint_row(ui: &Ui, rect: Rect, response: &egui::Response, selected: bool) {
    let fill = if selected {
        ui.visuals().selection.bg_fill.gamma_multiply(0.35)
    } else if response.hovered() || response.has_focus() {
        ui.visuals().widgets.hovered.weak_bg_fill
    } else {
        Color32::TRANSPARENT
    };
    ui.painter().rect_filled(rect, 2.0, fill);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(number: usize, scene: &str) -> HistoryEntry {
        HistoryEntry {
            number,
            config: BuildConfig::default(),
            scene: scene.to_owned(),
            build_ms: 1.0,
            sah_cost: None,
            nodes_visited_mean: None,
            node_count: 1,
            leaf_count: 1,
            depth_max: None,
            depth_mean: None,
            bytes: 1,
        }
    }

    #[test]
    fn a_build_is_held_against_the_one_before_of_the_same_scene() {
        let history = [entry(1, "a"), entry(2, "a"), entry(3, "b"), entry(4, "b")];
        assert_eq!(before(&history).map(|e| e.number), Some(3));
        assert_eq!(before(&history[..3]), None);
        assert_eq!(before(&history[..1]), None);
    }

    #[test]
    fn a_summary_says_what_differs_and_nothing_else() {
        let config = BuildConfig::default();
        assert_eq!(summary(&config), "binned 16 · leaf 2");
        let config =
            BuildConfig { builder: Builder::Sweep, width: Width::W8, widen: Widen::Collapse, ..config };
        assert_eq!(summary(&config), "sweep · leaf 2 · width 8 collapse");
        let config = BuildConfig { stop: StopRule::Cost, traversal_cost: 1.5, ..BuildConfig::default() };
        assert_eq!(summary(&config), "binned 16 · leaf 2 · stop cost · costs 1.5 1");
    }
}
