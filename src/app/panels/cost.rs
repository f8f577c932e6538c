//! Where the cost of the tree lies, how well it predicts what rays pay, and what the number of bins does to both.

use egui::{Color32, Ui};

use crate::accel::{BuildConfig, Builder};
use crate::app::commands::Commands;
use crate::app::theme::Palette;
use crate::app::view::{AppView, BinCurve};
use crate::inspect::bin_sweep::BinPoint;
use crate::inspect::plot::{Axis, Ink, Mark, Plot, Series, tree};
use crate::world::World;

use super::chart::{self, Chart};
use super::glossary::Term;
use super::numbers;
use super::prediction;
use super::widgets::{self, Figure};

/// What a curve over the number of bins shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Curve {
    SahCost,
    NodesVisited,
    BuildTime,
}

impl Curve {
    const ALL: [Self; 3] = [Self::SahCost, Self::NodesVisited, Self::BuildTime];

    fn term(self) -> Term {
        match self {
            Self::SahCost => Term::SahCost,
            Self::NodesVisited => Term::NodesVisited,
            Self::BuildTime => Term::BuildTime,
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::SahCost | Self::NodesVisited => "",
            Self::BuildTime => "ms",
        }
    }

    fn of(self, point: &BinPoint) -> Option<f64> {
        match self {
            Self::SahCost => point.sah_cost,
            Self::NodesVisited => point.nodes_visited_mean,
            Self::BuildTime => Some(point.build_ms),
        }
    }

    /// Times taken while something else ran are marked.
    fn is_sure(self, point: &BinPoint) -> bool {
        match self {
            Self::SahCost | Self::NodesVisited => true,
            Self::BuildTime => point.timed_alone,
        }
    }

    fn ink(self) -> Ink {
        match self {
            Self::SahCost => Ink::Accent,
            Self::NodesVisited => Ink::Third,
            Self::BuildTime => Ink::Second,
        }
    }

    fn color(self, palette: &Palette) -> Color32 {
        palette.of_ink(self.ink())
    }
}

/// View state of the Cost panel.
pub struct CostPanel {
    /// Which of [`Curve::ALL`] are shown.
    curves: [bool; 3],
}

impl Default for CostPanel {
    fn default() -> Self {
        Self { curves: [true; 3] }
    }
}

impl CostPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(world) = view.world else {
            widgets::section(ui, Term::SahCost.label());
            widgets::caption(ui, view.palette, "No tree has been built yet.");
            return;
        };
        parts(ui, view.palette, world);
        prediction::ui(ui, view, world);
        per_depth(ui, view, world, commands);
        leaf_sizes(ui, view, world, commands);
        self.bins(ui, view, commands);
    }

    fn bins(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::BinCurve);
        let curve = view.bin_curve;
        ui.horizontal_wrapped(|ui| {
            for (kind, shown) in Curve::ALL.into_iter().zip(&mut self.curves) {
                ui.checkbox(shown, kind.term().label()).on_hover_text(kind.term().text());
            }
        });
        if curve.points.is_empty() {
            let text = if curve.pending > 0 { "Building…" } else { "Not measured yet." };
            widgets::caption(ui, view.palette, text);
        }
        let mut clicked = None;
        for (kind, _) in Curve::ALL.into_iter().zip(self.curves).filter(|(_, shown)| *shown) {
            if !curve.points.is_empty() {
                clicked = bin_chart(ui, view, kind, commands).or(clicked);
            }
        }
        if let Some(bins) = clicked {
            commands.edit(move |s| {
                let build = s.build_mut();
                build.bins = bins;
                build.builder = Builder::Binned;
            });
        }
        curve_notes(ui, view, curve);
    }
}

fn parts(ui: &mut Ui, palette: &Palette, world: &World) {
    widgets::term_section(ui, Term::SahCost);
    let cost = world.figures.sah_cost;
    let share = |part: Option<f64>| {
        part.zip(cost).map_or(String::new(), |(part, cost)| {
            format!("{} % of the SAH cost.", numbers::percent(part, cost.total()))
        })
    };
    Figure::new(Term::SahCost, numbers::decimal(cost.map(|c| c.total()), 2)).label("Total").show(ui, palette);
    let (inner, leaf) = (cost.map(|c| c.inner), cost.map(|c| c.leaf));
    Figure::new(Term::SahInner, numbers::decimal(inner, 2)).part().note(share(inner)).show(ui, palette);
    Figure::new(Term::SahLeaf, numbers::decimal(leaf, 2)).part().note(share(leaf)).show(ui, palette);
    if let Some(cost) = cost {
        share_bar(ui, &[(cost.inner, palette.accent), (cost.leaf, palette.second)]);
        widgets::legend(ui, palette, &[("inner nodes", palette.accent), ("leaves", palette.second)]);
    }
    boxes(ui, palette, world);
}

/// What else the boxes say.
fn boxes(ui: &mut Ui, palette: &Palette, world: &World) {
    let figures = &world.figures;
    Figure::new(Term::Overlap, numbers::decimal(figures.overlap, 2)).unit("").show(ui, palette);
    let share = |x: Option<f64>| x.map_or(numbers::DASH.to_owned(), |x| numbers::percent(x, 1.0));
    let empty_sum = format!("Summed over all inner nodes: {}.", numbers::decimal(figures.empty_space, 2));
    let empty = Figure::new(Term::EmptySpace, share(figures.empty_space_mean)).unit("%");
    empty.note(empty_sum).show(ui, palette);
    Figure::new(Term::SlotFill, share(figures.slot_fill)).unit("%").show(ui, palette);
    Figure::new(Term::LeafFill, share(figures.leaf_fill)).unit("%").show(ui, palette);
    let count = world.scene.shape_count();
    let bytes = (count > 0).then(|| world.bytes() as f64 / count as f64);
    Figure::new(Term::BytesPerShape, numbers::decimal(bytes, 1)).unit("B").show(ui, palette);
}

/// Shares of a whole as one bar.
pub fn share_bar(ui: &mut Ui, parts: &[(f64, Color32)]) {
    let size = egui::vec2(ui.available_width(), 8.0);
    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let total: f64 = parts.iter().map(|p| p.0).sum();
    if total <= 0.0 {
        return;
    }
    let mut left = rect.left();
    for (part, color) in parts.iter().filter(|p| p.0 > 0.0) {
        let right = left + rect.width() * (part / total) as f32;
        let piece = egui::Rect::from_x_y_ranges(left..=right, rect.y_range());
        ui.painter().rect_filled(piece, 0.0, *color);
        left = right;
    }
}

fn per_depth(ui: &mut Ui, view: &AppView, world: &World, commands: &mut Commands) {
    let palette = view.palette;
    widgets::term_section(ui, Term::PerDepth);
    let levels = &world.figures.levels;
    let plot = tree::sah_by_depth(&world.figures).of(chart::subject(view));
    let shown = Chart { plot, height: 134.0, clickable: false }.show(ui, palette, commands);
    if let Some((depth, level)) = bar_under(shown.hover, 0).and_then(|i| Some((i, levels.get(i)?))) {
        shown.response.on_hover_ui_at_pointer(|ui| {
            ui.strong(format!("Depth {depth}"));
            ui.label(format!("inner nodes {}", numbers::decimal(level.sah_inner, 3)));
            ui.label(format!("leaves {}", numbers::decimal(level.sah_leaf, 3)));
        });
    }
    widgets::legend(ui, palette, &[("inner nodes", palette.accent), ("leaves", palette.second)]);
}

/// The index of the bar at the mouse, where the first stands at `first`.
fn bar_under(hover: Option<egui_plot::PlotPoint>, first: usize) -> Option<usize> {
    let x = hover?.x.round();
    (x >= first as f64).then(|| x as usize - first)
}

fn leaf_sizes(ui: &mut Ui, view: &AppView, world: &World, commands: &mut Commands) {
    let palette = view.palette;
    widgets::term_section(ui, Term::LeafSizes);
    let sizes = &world.figures.leaf_sizes;
    if sizes.len() < 2 {
        widgets::caption(ui, palette, "This tree has no leaves.");
        return;
    }
    let plot = tree::leaf_sizes(&world.figures).of(chart::subject(view));
    let shown = Chart { plot, height: 114.0, clickable: false }.show(ui, palette, commands);
    if let Some((i, n)) = bar_under(shown.hover, 1).and_then(|i| Some((i, sizes.get(i + 1)?))) {
        let text = format!(
            "{} of {} leaves hold {}",
            numbers::count(*n),
            numbers::count(world.figures.leaf_count),
            if i == 0 { "1 shape".to_owned() } else { format!("{} shapes", i + 1) }
        );
        shown.response.on_hover_text_at_pointer(text);
    }
}

/// One curve. The number of bins that was clicked.
fn bin_chart(ui: &mut Ui, view: &AppView, kind: Curve, commands: &mut Commands) -> Option<usize> {
    let palette = view.palette;
    let curve = view.bin_curve;
    let at = |p: &BinPoint| Some([p.bins? as f64, kind.of(p)?]);
    let all: Vec<[f64; 2]> = curve.points.iter().filter_map(at).collect();
    let of = |sure: bool| {
        curve.points.iter().filter(move |p| kind.is_sure(p) == sure).filter_map(at).collect::<Vec<_>>()
    };
    let (sure, unsure) = (of(true), of(false));
    let sweep = curve.sweep.as_ref().and_then(|p| kind.of(p));
    let current = view.session.build();
    let current = current.builder.uses_bins().then_some(current.bins as f64);
    ui.horizontal(|ui| {
        widgets::swatch(ui, kind.color(palette));
        ui.label(egui::RichText::new(kind.term().label()).small());
        ui.label(egui::RichText::new(kind.unit()).small().color(palette.muted));
    });
    let title = match kind {
        Curve::SahCost => "SAH cost over bins",
        Curve::NodesVisited => "Nodes visited over bins",
        Curve::BuildTime => "Build time over bins",
    };
    let x = Axis::powers_of_two(1, 8).labelled("bins");
    let y = Axis::around(all.iter().map(|p| p[1]).chain(sweep));
    let mut plot = Plot::new(title, x, y.labelled(kind.term().label()).unit(kind.unit()))
        .of(view.scene.map_or_else(String::new, |scene| scene.name.clone()));
    let ink = kind.ink();
    if let Some(sweep) = sweep {
        plot = plot.with(Series::new("full sweep", Mark::Across, Ink::Muted).at([[0.0, sweep]]));
    }
    if let Some(bins) = current {
        plot = plot.with(Series::new("now", Mark::Upright, Ink::Accent).at([[bins, 0.0]]));
    }
    let dots = |filled| Mark::Dots { radius: 2.5, filled };
    plot = plot
        .with(Series::new("curve", Mark::Line { width: 1.5 }, ink).faint(0.6).at(all).decoration())
        .with(Series::new("measured", dots(true), ink).at(sure));
    if !unsure.is_empty() {
        plot = plot.with(Series::new("timed while something else ran", dots(false), ink).at(unsure));
    }
    let shown = Chart { plot, height: 116.0, clickable: true }.show(ui, palette, commands);
    let bins = shown.hover?.x.exp2().round();
    let bins = (bins as usize).clamp(*BuildConfig::BINS.start(), *BuildConfig::BINS.end());
    let clicked = shown.response.clicked();
    shown.response.on_hover_ui_at_pointer(|ui| bin_tooltip(ui, curve, bins));
    clicked.then_some(bins)
}

fn bin_tooltip(ui: &mut Ui, curve: &BinCurve, bins: usize) {
    ui.strong(format!("{bins} bins"));
    let nearest = curve
        .points
        .iter()
        .filter_map(|p| Some((p.bins?, p)))
        .min_by(|a, b| octaves(a.0, bins).total_cmp(&octaves(b.0, bins)));
    if let Some((measured, point)) = nearest.filter(|(n, _)| octaves(*n, bins) < 0.15) {
        if measured != bins {
            ui.label(format!("nearest measured: {measured} bins"));
        }
        ui.label(format!("SAH cost {}", numbers::decimal(point.sah_cost, 3)));
        ui.label(format!("nodes visited {}", numbers::decimal(point.nodes_visited_mean, 3)));
        let alone = if point.timed_alone { "" } else { ", while something else ran" };
        ui.label(format!("build {} ms{alone}", numbers::decimal(point.build_ms, 2)));
    }
    ui.label("Click to build with it.");
}

/// How far apart two numbers of bins are, in doublings.
fn octaves(a: usize, b: usize) -> f64 {
    (a as f64 / b.max(1) as f64).log2().abs()
}

fn curve_notes(ui: &mut Ui, view: &AppView, curve: &BinCurve) {
    let palette = view.palette;
    if let Some(sweep) = &curve.sweep {
        ui.horizontal_wrapped(|ui| {
            let text = format!(
                "Dashed line, {}: SAH cost {}, nodes visited {}, {} ms",
                Term::FullSweep.label().to_lowercase(),
                numbers::decimal(sweep.sah_cost, 2),
                numbers::decimal(sweep.nodes_visited_mean, 2),
                numbers::decimal(sweep.build_ms, 1)
            );
            widgets::caption(ui, palette, text).on_hover_text(Term::FullSweep.text());
        });
    }
    if curve.points.iter().any(|p| !p.timed_alone) {
        widgets::caption(ui, palette, "Hollow points: the time was taken while something else ran.");
    }
    if curve.pending > 0 {
        let text = format!("{} numbers of bins still to come, when the program is idle.", curve.pending);
        widgets::caption(ui, palette, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_bins_are_compared_by_doublings() {
        assert_eq!(octaves(32, 16), 1.0);
        assert!(octaves(250, 256) < 0.15 && octaves(2, 3) > 0.15);
    }
}
