//! How the build goes or went, and what it came to.

use std::time::Duration;

use egui::{Frame, Label, Margin, RichText, Ui};

use super::summary;
use crate::app::commands::{Command, Commands};
use crate::app::panels::chart::{self, Chart};
use crate::app::panels::glossary::Term;
use crate::app::panels::numbers;
use crate::app::panels::widgets::{self, Figure};
use crate::app::view::{AppView, HistoryEntry};
use crate::inspect::columns::Better;
use crate::inspect::plot::tree;
use crate::world::World;

/// A build that takes longer shows its progress.
const SLOW: Duration = Duration::from_millis(200);

/// What runs now, or what the tree in the viewport was built with where that is not what is set.
pub(super) fn status(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
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

pub(super) fn report(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
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
    let threads = format!("{} threads, {} instructions.", report.threads, world.simd_level().name());
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
    rounds(ui, view, world, commands);
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
        numbers::count(figures.node_count),
        change(nodes, |e| Some(e.node_count as f64)),
        Better::Lower,
    )
    .show(ui, p);
    let leaves = Some(figures.leaf_count as f64);
    figure(
        Term::Leaves,
        numbers::count(figures.leaf_count),
        change(leaves, |e| Some(e.leaf_count as f64)),
        Better::Neither,
    )
    .show(ui, p);
    let references = numbers::count(figures.reference_count);
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

/// The build time's parts, in a line.
fn phases(ui: &mut Ui, view: &AppView, world: &World) {
    let parts: Vec<String> = world
        .report
        .phases
        .iter()
        .map(|phase| format!("{} {}", phase.name, numbers::decimal(phase.ms, 2)))
        .collect();
    let text = RichText::new(parts.join(" · ")).small().color(view.palette.muted);
    Frame::NONE.inner_margin(Margin { left: 12, ..Margin::ZERO }).show(ui, |ui| {
        ui.add(Label::new(text).wrap()).on_hover_text(Term::BuildPhase.text());
    });
}

/// What each round of the improver made of the tree.
fn rounds(ui: &mut Ui, view: &AppView, world: &World, commands: &mut Commands) {
    let palette = view.palette;
    let costs: Vec<f64> = world.report.rounds.iter().map_while(|cost| *cost).collect();
    let [first, .., last] = costs[..] else { return };
    let count = costs.len() - 1;
    widgets::row(ui, Term::RoundCosts, |ui| {
        let rounds = if count == 1 { "round" } else { "rounds" };
        let text = format!("{:.2} % less in {count} {rounds}", 100.0 * (1.0 - last / first));
        ui.label(RichText::new(text).small().color(palette.muted));
    });
    let plot = tree::round_costs(&costs).of(chart::subject(view));
    let shown = Chart { plot, height: 96.0, clickable: false }.show(ui, palette, commands);
    if let Some(hover) = shown.hover {
        let round = (hover.x.round().max(0.0) as usize).min(count);
        let cost = numbers::decimal(costs[round], 3);
        let when =
            if round == 0 { "before the first round".to_owned() } else { format!("after round {round}") };
        shown.response.on_hover_text_at_pointer(format!("SAH cost {cost} {when}, of the binary tree"));
    }
}

/// The build before the newest one, if it was of the same scene.
fn before(history: &[HistoryEntry]) -> Option<&HistoryEntry> {
    let [.., before, newest] = history else { return None };
    (before.scene == newest.scene).then_some(before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;

    fn entry(number: usize, scene: &str) -> HistoryEntry {
        HistoryEntry {
            number,
            tree: None,
            config: BuildConfig::default(),
            time: 0.0,
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
}
