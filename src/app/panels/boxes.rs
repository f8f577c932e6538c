//! Which boxes of the tree are drawn over the picture, and how.

use egui::{Align, Color32, DragValue, Layout, RichText, Ui};

use crate::accel::quality::DepthLevel;
use crate::app::DEFAULT_BOXES;
use crate::app::commands::Commands;
use crate::app::view::AppView;
use crate::inspect::plot::tree;
use crate::render::BoxStyle;
use crate::render::overlay::ramp;
use crate::world::NodeFigure;

use super::chart;
use super::glossary::Term;
use super::numbers;
use super::range_bars::{FreeDrag, RangeBars};
use super::widgets::{self, Figure};

const LARGEST_BUDGET: u32 = 10_000_000;

/// View state of the Boxes panel.
#[derive(Default)]
pub struct BoxesPanel {
    /// The depths that were shown when the boxes were switched off.
    last_depths: Option<[u32; 2]>,
}

impl BoxesPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let settings = view.session.overlay;
        let deepest = view.world.and_then(|w| w.figures.depth_max).unwrap_or(0);
        widgets::section(ui, "Boxes");
        if widgets::switch(ui, Term::ShowBoxes, settings.depths.is_some()) {
            let depths = if settings.depths.is_some() {
                self.last_depths = settings.depths;
                None
            } else {
                Some(self.last_depths.unwrap_or(DEFAULT_BOXES))
            };
            commands.edit(move |s| s.overlay.depths = depths);
        }
        style(ui, view, commands);
        depth_range(ui, view, deepest, commands);
        drawn(ui, view);
    }
}

fn style(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let settings = &view.session.overlay;
    let describe = |s: BoxStyle| (s.name(), s.description());
    if let Some(style) =
        widgets::segmented(ui, Term::BoxStyle, Some(settings.style), &BoxStyle::ALL, &describe)
    {
        commands.edit(move |s| s.overlay.style = style);
    }
    ui.add_enabled_ui(settings.style != BoxStyle::Density, |ui| {
        let describe = |c: NodeFigure| (c.label(), c.description());
        let (term, all) = (Term::BoxColor, &NodeFigure::ALL);
        if let Some(color) = widgets::combo(ui, term, Some(settings.color), all, &describe, "") {
            commands.edit(move |s| s.overlay.color = color);
        }
        color_legend(ui, view);
        if widgets::switch(ui, Term::Hidden, settings.show_hidden) {
            commands.edit(|s| s.overlay.show_hidden = !s.overlay.show_hidden);
        }
    });
    if widgets::switch(ui, Term::LeavesOnly, settings.leaves_only) {
        commands.edit(|s| s.overlay.leaves_only = !s.overlay.leaves_only);
    }
    let mut budget = settings.budget;
    let speed = 0.02 * f64::from(budget).max(50.0);
    let field = DragValue::new(&mut budget)
        .range(1..=LARGEST_BUDGET)
        .speed(speed)
        .custom_formatter(|n, _| numbers::count(n as u64))
        .custom_parser(|t| t.replace(',', "").parse().ok());
    if widgets::number(ui, Term::Budget, field).changed() {
        commands.edit(move |s| s.overlay.budget = budget);
    }
}

/// The bars that are the slider, and number fields for the same range.
fn depth_range(ui: &mut Ui, view: &AppView, deepest: u32, commands: &mut Commands) {
    widgets::term_section(ui, Term::DepthRange);
    let palette = view.palette;
    let Some(world) = view.world else {
        widgets::caption(ui, palette, "No tree has been built yet.");
        return;
    };
    let levels = &world.figures.levels;
    let bars: Vec<[f64; 2]> = levels.iter().map(|l| [l.inner_count as f64, l.leaf_count as f64]).collect();
    let depths = view.session.overlay.depths.map(|[lo, hi]| [lo.min(deepest), hi.min(deepest)]);
    let shown = RangeBars {
        label: "Depth range, over nodes and leaves per depth",
        bars: &bars,
        domain: [0.0, f64::from(deepest) + 1.0],
        selection: depths.map(|[lo, hi]| [f64::from(lo), f64::from(hi) + 1.0]),
        step: 1.0,
        free_drag: FreeDrag::Select,
        height: 96.0,
        colors: &|_| [palette.accent, palette.second],
        mark: None,
    }
    .show(ui, palette);
    chart::menu(ui, &shown.response, Term::DepthRange.label(), commands, || {
        tree::nodes_by_depth(&world.figures).of(chart::subject(view))
    });
    if let Some([lo, hi]) = shown.changed {
        let depths = [lo as u32, (hi as u32).saturating_sub(1).max(lo as u32)];
        commands.edit(move |s| s.overlay.depths = Some(depths));
    }
    if let Some((depth, level)) = shown.hovered.and_then(|i| Some((i, levels.get(i)?))) {
        shown.response.on_hover_ui_at_pointer(|ui| level_tooltip(ui, depth, level));
    }
    ui.horizontal(|ui| {
        widgets::legend(ui, palette, &[("inner nodes", palette.accent), ("leaves", palette.second)]);
        ui.label(RichText::new("heights: square root of nodes").small().color(palette.muted));
    });
    depth_fields(ui, depths, deepest, commands);
}

fn level_tooltip(ui: &mut Ui, depth: usize, level: &DepthLevel) {
    ui.strong(format!("Depth {depth}"));
    ui.label(format!("{} inner nodes", numbers::count(level.inner_count)));
    ui.label(format!(
        "{} leaves with {} references",
        numbers::count(level.leaf_count),
        numbers::count(level.reference_count)
    ));
}

fn depth_fields(ui: &mut Ui, depths: Option<[u32; 2]>, deepest: u32, commands: &mut Commands) {
    ui.add_enabled_ui(depths.is_some(), |ui| {
        let [mut lo, mut hi] = depths.unwrap_or([0, deepest]);
        let mut changed = false;
        ui.horizontal(|ui| {
            ui.spacing_mut().interact_size.x = widgets::NUMBER_WIDTH;
            let low = DragValue::new(&mut lo).range(0..=hi).speed(0.1);
            changed |= ui
                .add(low)
                .on_hover_text("The least depth that is drawn.")
                .accessible_name("Least depth")
                .changed();
            ui.label("to");
            let high = DragValue::new(&mut hi).range(lo..=deepest).speed(0.1);
            changed |= ui
                .add(high)
                .on_hover_text("The greatest depth that is drawn.")
                .accessible_name("Greatest depth")
                .changed();
            if ui.button("All").on_hover_text("Draws the boxes of every depth.").clicked() {
                [lo, hi] = [0, deepest];
                changed = true;
            }
        });
        if changed {
            commands.edit(move |s| s.overlay.depths = Some([lo, hi]));
        }
    });
}

/// What became of the selected boxes.
fn drawn(ui: &mut Ui, view: &AppView) {
    let Some(overlay) = view.overlay.filter(|_| view.session.overlay.depths.is_some()) else { return };
    widgets::section(ui, "In the picture");
    let count = |n: usize| numbers::count(n);
    Figure::new(Term::Selected, count(overlay.selected)).show(ui, view.palette);
    Figure::new(Term::Drawn, count(overlay.drawn)).show(ui, view.palette);
    for (term, n) in [(Term::Outside, overlay.outside), (Term::TooSmall, overlay.too_small)] {
        Figure::new(term, count(n)).part().show(ui, view.palette);
    }
    let mut figure = Figure::new(Term::OverBudget, count(overlay.over_budget)).part();
    if overlay.over_budget > 0 {
        figure = figure.color(view.palette.warning);
    }
    figure.show(ui, view.palette);
    if overlay.over_budget > 0 {
        let text = format!(
            "{} boxes are left out: raise the budget or narrow the depths.",
            count(overlay.over_budget)
        );
        widgets::notice(ui, view.palette.warning, text);
    }
}

/// What the colours of the drawn boxes mean, below their name.
fn color_legend(ui: &mut Ui, view: &AppView) {
    let color = view.session.overlay.color;
    let drawn = view.overlay.filter(|_| view.session.overlay.depths.is_some());
    let Some(range) = drawn.and_then(|overlay| overlay.color_range) else { return };
    let shade = |t: f32| {
        let [r, g, b] = ramp(t);
        Color32::from_rgb(r, g, b)
    };
    let scale = if color.spans_decades() { ", on a logarithmic scale" } else { "" };
    let text = format!("{}{scale}.", widgets::capitalised(color.description()));
    widgets::row(ui, Term::ColorScale, |ui| {
        ui.vertical(|ui| {
            widgets::color_bar(ui, &shade).on_hover_text(text);
            let ends = range.map(|end| match color {
                NodeFigure::Depth | NodeFigure::LeafSize => numbers::decimal(f64::from(end), 0),
                _ => numbers::short(f64::from(end)),
            });
            ui.horizontal(|ui| {
                let [low, high] = ends.map(|text| RichText::new(text).small().color(view.palette.muted));
                ui.label(low);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(high));
            });
        });
    });
}
