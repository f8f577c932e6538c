//! Where the selected node could be split, what that would cost, and what bins miss.

use egui::{RichText, Ui};

use crate::accel::split_costs::SplitCandidate;
use crate::app::commands::{Command, Commands};
use crate::app::splitting::{FoundSplits, SplitView};
use crate::app::view::AppView;
use crate::inspect::columns::Better;
use crate::inspect::plot::splits::split_costs;

use super::chart::{self, Chart};
use super::glossary::Term;
use super::numbers;
use super::tree::node_name;
use super::widgets::{self, Figure};

/// Bins that can be held beside those of the build.
const BINS: std::ops::RangeInclusive<usize> = crate::accel::BuildConfig::BINS;

/// The names of the axes.
const AXES: [usize; 3] = [0, 1, 2];
const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// View state of the Splits panel.
#[derive(Default)]
pub struct SplitsPanel {}

impl SplitsPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let (Some(world), Some(tree), Some(selection)) = (view.world, view.tree, view.selections.current())
        else {
            widgets::section(ui, Term::SplitCurve.label());
            let text = "Select a node: in the viewport ([ goes up to its parent), in the outline or in the plot of the \
                        panel Tree. Here is where it could have been split, and at what cost.";
            widgets::caption(ui, view.palette, text);
            return;
        };
        let node = selection.node();
        widgets::term_section(ui, Term::SplitCurve);
        settings(ui, view, commands);
        let Some(found) = view.splitting.of(tree, node) else {
            widgets::caption(ui, view.palette, format!("Weighing the splits of {}…", node_name(world, node)));
            return;
        };
        let count = found.curve.costs.len();
        let text = format!("{}: {} references", node_name(world, node), numbers::count(count));
        ui.label(RichText::new(text).color(view.palette.accent));
        curve(ui, view, found, commands);
        figures(ui, view, found);
    }
}

fn settings(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let split_view = view.splitting.view;
    let describe = |axis: usize| (AXIS_NAMES[axis], "the curve that stands out, and its planes");
    if let Some(axis) = widgets::segmented(ui, Term::SplitAxis, Some(split_view.axis), &AXES, &describe) {
        commands.push(Command::SetSplitView(SplitView { axis, hovered: None, ..split_view }));
    }
    let mut bins = split_view.bins;
    widgets::integer_slider(ui, Term::OtherBins, &mut bins, BINS, true);
    if bins != split_view.bins {
        commands.push(Command::SetSplitView(SplitView { bins, ..split_view }));
    }
    if widgets::switch(ui, Term::PlanesDrawn, split_view.drawn) {
        let drawn = !split_view.drawn;
        commands.push(Command::SetSplitView(SplitView { drawn, ..split_view }));
    }
}

fn figures(ui: &mut Ui, view: &AppView, found: &FoundSplits) {
    let palette = view.palette;
    let curve = &found.curve;
    let cost = |term: Term, cost: Option<f32>, at: Option<SplitCandidate>| {
        let best = curve.best.map(|best| f64::from(best.cost));
        let now = cost.map(f64::from);
        let figure = Figure::new(term, numbers::decimal(now, 3)).unit("").change(now, best, Better::Lower);
        match at {
            Some(at) => figure.note(words(at)),
            None => figure,
        }
    };
    let [build, beside] = &found.planes;
    cost(Term::BestSplit, curve.best.map(|b| b.cost), curve.best).show(ui, palette);
    cost(Term::MadeSplit, curve.made_cost, curve.made).show(ui, palette);
    cost(Term::BestOfBuild, build.best.map(|b| b.cost), build.best).show(ui, palette);
    cost(Term::BestBeside, beside.best.map(|b| b.cost), beside.best).show(ui, palette);
    cost(Term::LeafCost, Some(curve.leaf_cost), None).show(ui, palette);
    if curve.best.is_none() {
        let text = "No plane can tell its references apart: all centroids are the same.";
        widgets::caption(ui, palette, text);
    }
}

/// A split in words.
fn words(candidate: SplitCandidate) -> String {
    format!(
        "Across {} at {}, {} references on the left.",
        AXIS_NAMES[candidate.axis],
        numbers::short(f64::from(candidate.position)),
        numbers::count(candidate.left_count)
    )
}

/// The curve of the axis, with the planes between bins over it. What is pointed at is drawn in the viewport.
fn curve(ui: &mut Ui, view: &AppView, found: &FoundSplits, commands: &mut Commands) {
    let split_view = view.splitting.view;
    let axis = split_view.axis;
    if found.curve.curves[axis].is_empty() {
        let text = format!("Along {} all centroids are the same.", AXIS_NAMES[axis]);
        widgets::caption(ui, view.palette, text);
        return;
    }
    let plot = split_costs(&found.curve, &found.planes, axis).of(chart::subject(view));
    let shown = Chart { plot, height: 190.0, clickable: false }.show(ui, view.palette, commands);
    let hovered = shown.hover.map(|at| (axis, at.x as f32));
    if hovered != split_view.hovered {
        commands.push(Command::SetSplitView(SplitView { hovered, ..split_view }));
    }
    legend(ui, view, found);
    let Some((_, position)) = hovered else { return };
    let exact = nearest(&found.curve.curves[axis], position);
    shown.response.on_hover_ui_at_pointer(|ui| {
        ui.strong(format!("{} = {}", AXIS_NAMES[axis], numbers::short(f64::from(position))));
        if let Some([left, right]) = view.splitting.sides.map(|sides| sides.map(|(n, _)| numbers::count(n))) {
            ui.label(format!("{left} references on the left, {right} on the right"));
        }
        if let Some(exact) = exact {
            ui.label(format!("exact cost there {}", numbers::decimal(f64::from(exact.cost), 3)));
        }
        for (planes, whose) in found.planes.iter().zip(["the build's", "the other"]) {
            if let Some(plane) = nearest(&planes.axes[axis], position).filter(|plane| plane.cost.is_finite())
            {
                let cost = numbers::decimal(f64::from(plane.cost), 3);
                ui.label(format!("nearest of {whose} {} bins {cost}", planes.bins));
            }
        }
    });
}

/// The candidate nearest to a position; they stand in order of it.
fn nearest(candidates: &[SplitCandidate], position: f32) -> Option<SplitCandidate> {
    let after = candidates.partition_point(|candidate| candidate.position < position);
    let around = [after.checked_sub(1), Some(after)].into_iter().flatten();
    let away = |candidate: &SplitCandidate| (candidate.position - position).abs();
    let around = around.filter_map(|i| candidates.get(i).copied());
    around.min_by(|a, b| away(a).total_cmp(&away(b)))
}

fn legend(ui: &mut Ui, view: &AppView, found: &FoundSplits) {
    let palette = view.palette;
    let [build, beside] = found.planes.each_ref().map(|planes| format!("{} bins", planes.bins));
    let mut series = vec![("exact", palette.accent), (build.as_str(), palette.second)];
    if beside != build {
        series.push((beside.as_str(), palette.third));
    }
    series.push(("as a leaf, as split", palette.muted));
    widgets::legend(ui, palette, &series);
}
