//! Which tree is built, and how the build went.

use std::time::Duration;

use egui::{DragValue, Frame, Label, Margin, RichText, Slider, Ui};
use egui_plot::{Line, PlotPoints, Points};

use crate::accel::{Block, BuildConfig, Builder, Improver, Layout, Morton, StopRule, Widen, Width};
use crate::app::commands::{Command, Commands};
use crate::app::theme::Palette;
use crate::app::view::{AppView, HistoryEntry};
use crate::inspect::columns::Better;
use crate::world::World;

use super::PanelKind;
use super::chart::{Axis, Chart};
use super::glossary::Term;
use super::history::History;
use super::numbers;
use super::widgets::{self, Figure};

/// As far as the sliders of the improver go; flags and sessions go further.
const MANY_ROUNDS: usize = 100;
const SMALL_SHARE: f32 = 0.01;
/// As far as the slider goes; the flag and sessions go further.
const MUCH_PRE_SPLIT: f32 = 1.0;

/// A build that takes longer shows its progress.
const SLOW: Duration = Duration::from_millis(200);

/// View state of the Build panel.
#[derive(Default)]
pub struct BuildPanel {
    /// Whether a slider is held down.
    held: bool,
    history: History,
}

impl BuildPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Tree");
        let config = *view.session.build();
        imported(ui, view, commands);
        // Of a tree from a file with faults a picture is traced all the same, with the tree that is set here.
        let is_traced = view.session.tree().is_some() && view.world.is_none_or(|w| w.traced_file().is_some());
        ui.add_enabled_ui(!is_traced, |ui| {
            choices(ui, &config, commands);
            self.sliders(ui, &config, view.palette, commands);
        });
        costs(ui, &config, commands);
        status(ui, view, commands);
        report(ui, view);
        self.history.ui(ui, view, commands);
    }

    fn sliders(&mut self, ui: &mut Ui, config: &BuildConfig, palette: &Palette, commands: &mut Commands) {
        let (mut bins, mut leaf) = (config.bins, config.leaf);
        let bins_slider = ui
            .add_enabled_ui(config.builder.uses_bins(), |ui| {
                widgets::integer_slider(ui, Term::Bins, &mut bins, BuildConfig::BINS, true)
            })
            .inner
            .on_disabled_hover_text("Only the builders binned and spatial use bins.");
        let leaf_slider = widgets::integer_slider(ui, Term::Leaf, &mut leaf, BuildConfig::LEAF, true);
        if config.leaf_limit() < config.leaf {
            let text = format!("Compressed leaves hold {} shapes at most.", config.leaf_limit());
            widgets::caption(ui, palette, text);
        }
        let of_builder = builder_sliders(ui, config, commands);
        let mut pre_split = config.pre_split;
        let slider = Slider::new(&mut pre_split, 0.0..=MUCH_PRE_SPLIT.max(config.pre_split)).max_decimals(2);
        let of_pre_split = widgets::slider(ui, Term::PreSplit, slider.trailing_fill(true));
        if pre_split != config.pre_split {
            commands.edit(move |s| s.build_mut().pre_split = pre_split);
        }
        let (mut rounds, mut share) = (config.rounds, config.share);
        let mut improver_dragged = false;
        if config.improver != Improver::None {
            let most = *BuildConfig::ROUNDS.start()..=MANY_ROUNDS.max(rounds);
            let of_rounds = widgets::integer_slider(ui, Term::Rounds, &mut rounds, most, true);
            improver_dragged = of_rounds.dragged();
        }
        if config.improver == Improver::Reinsertion {
            let slider = Slider::new(&mut share, SMALL_SHARE.min(config.share)..=1.0).logarithmic(true);
            let of_share = widgets::slider(ui, Term::Share, slider.max_decimals(3).trailing_fill(true));
            improver_dragged |= of_share.dragged();
        }
        if rounds != config.rounds {
            commands.edit(move |s| s.build_mut().rounds = rounds);
        }
        if share != config.share {
            commands.edit(move |s| s.build_mut().share = share);
        }
        let held = bins_slider.dragged()
            || leaf_slider.dragged()
            || of_builder
            || of_pre_split.dragged()
            || improver_dragged;
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
}

/// Says that the tree is from a file, and brings ours back.
fn imported(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let Some(tree) = view.session.tree() else { return };
    let name = tree.path.file_name().unwrap_or_default().to_string_lossy();
    let broken = view.world.is_some_and(|w| w.imported.is_some() && w.traced_file().is_none());
    let (color, text) = if broken {
        let text =
            format!("{name} has faults: its boxes are shown, and the picture is traced with the tree below.");
        (view.palette.warning, text)
    } else {
        (view.palette.accent, format!("The tree is imported from {name}."))
    };
    widgets::notice(ui, color, text);
    ui.horizontal(|ui| {
        let build = ui.button("Build a tree instead").on_hover_text("Puts the file's tree away.");
        if build.clicked() {
            commands.push(Command::BuildOwnTree);
        }
        if ui.button("Show the findings").on_hover_text("Opens the panel Tree file.").clicked() {
            commands.push(Command::ShowPanel { panel: PanelKind::TreeFile, shown: true });
        }
    });
    ui.add_space(4.0);
}

/// The sliders that one builder alone has. Whether one is dragged.
fn builder_sliders(ui: &mut Ui, config: &BuildConfig, commands: &mut Commands) -> bool {
    match config.builder {
        Builder::Ploc => {
            let mut radius = config.radius;
            let slider = widgets::integer_slider(ui, Term::Radius, &mut radius, BuildConfig::RADIUS, true);
            if radius != config.radius {
                commands.edit(move |s| s.build_mut().radius = radius);
            }
            slider.dragged()
        }
        Builder::Spatial => {
            let (mut alpha, mut budget) = (config.split_alpha, config.split_budget);
            let slider = Slider::new(&mut alpha, 0.0..=1.0).logarithmic(true).smallest_positive(1e-7);
            let slider = slider.custom_formatter(|alpha, _| format!("{alpha:.1e}"));
            let of_alpha = widgets::slider(ui, Term::SplitAlpha, slider.trailing_fill(true));
            let slider = Slider::new(&mut budget, 0.0..=BuildConfig::MAX_BUDGET).max_decimals(2);
            let of_budget = widgets::slider(ui, Term::SplitBudget, slider.trailing_fill(true));
            if alpha != config.split_alpha {
                commands.edit(move |s| s.build_mut().split_alpha = alpha);
            }
            if budget != config.split_budget {
                commands.edit(move |s| s.build_mut().split_budget = budget);
            }
            of_alpha.dragged() || of_budget.dragged()
        }
        _ => false,
    }
}

fn choices(ui: &mut Ui, config: &BuildConfig, commands: &mut Commands) {
    let describe = |b: Builder| (b.name(), b.description());
    // With those of other libraries there are too many for buttons.
    let chosen = if Builder::ALL.iter().any(|builder| builder.is_peer()) {
        widgets::combo(ui, Term::Builder, Some(config.builder), &Builder::ALL, &describe, "")
    } else {
        widgets::segmented(ui, Term::Builder, Some(config.builder), &Builder::ALL, &describe)
    };
    if let Some(builder) = chosen {
        commands.edit(move |s| s.build_mut().builder = builder);
    }
    let describe = |w: Width| match w {
        Width::W2 => (w.name(), "a binary tree"),
        Width::W4 => (w.name(), "up to four children a node, tested together"),
        Width::W8 => (w.name(), "up to eight children a node, tested together"),
    };
    if let Some(width) = widgets::segmented(ui, Term::Width, Some(config.width), &Width::ALL, &describe) {
        commands.edit(move |s| {
            let build = s.build_mut();
            build.width = width;
            if !BuildConfig::NODES.contains(&(width, build.layout)) {
                build.layout = Layout::Full;
            }
        });
    }
    let describe = |l: Layout| (l.name(), l.description());
    let layout = ui.add_enabled_ui(config.width == Width::W8, |ui| {
        widgets::segmented(ui, Term::Layout, Some(config.layout), &Layout::ALL, &describe)
    });
    layout.response.on_disabled_hover_text("Only nodes of width 8 can be compressed.");
    if let Some(layout) = layout.inner {
        commands.edit(move |s| s.build_mut().layout = layout);
    }
    if config.width != Width::W2 {
        let describe = |w: Widen| (w.name(), w.description());
        if let Some(widen) = widgets::segmented(ui, Term::Widen, Some(config.widen), &Widen::ALL, &describe) {
            commands.edit(move |s| s.build_mut().widen = widen);
        }
    }
    if config.builder.uses_morton() {
        let describe = |m: Morton| (m.name(), m.description());
        if let Some(morton) =
            widgets::segmented(ui, Term::Morton, Some(config.morton), &Morton::ALL, &describe)
        {
            commands.edit(move |s| s.build_mut().morton = morton);
        }
    }
    let median = !config.builder.weighs_cost();
    let describe = |b: Block| (b.name(), b.description());
    let block = ui.add_enabled_ui(!median, |ui| {
        widgets::segmented(ui, Term::Block, Some(config.block), &Block::ALL, &describe)
    });
    block.response.on_disabled_hover_text("The median builder looks at no cost.");
    if let Some(block) = block.inner {
        commands.edit(move |s| s.build_mut().block = block);
    }
    let describe = |r: StopRule| (r.name(), r.description());
    let shown = if median { StopRule::Limit } else { config.stop };
    let stop = ui.add_enabled_ui(!median && !config.is_optimal(), |ui| {
        widgets::segmented(ui, Term::Stop, Some(shown), &StopRule::ALL, &describe)
    });
    stop.response.on_disabled_hover_text(if median {
        "The median builder always stops at the leaf limit."
    } else {
        "Optimal widening finds the leaves itself."
    });
    if let Some(stop) = stop.inner {
        commands.edit(move |s| s.build_mut().stop = stop);
    }
    let describe = |i: Improver| (i.name(), i.description());
    if let Some(improver) =
        widgets::segmented(ui, Term::Improver, Some(config.improver), &Improver::ALL, &describe)
    {
        commands.edit(move |s| s.build_mut().improver = improver);
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
    if config.builder == Builder::Ploc {
        text += &format!(" {}", config.radius);
    }
    if config.builder.uses_morton() && config.morton != Morton::default() {
        text += &format!(" · {} bits", config.morton.name());
    }
    if config.builder == Builder::Spatial {
        let default = BuildConfig::default();
        if config.split_alpha != default.split_alpha {
            text += &format!(" · alpha {:.1e}", config.split_alpha);
        }
        if config.split_budget != default.split_budget {
            text += &format!(" · budget {}", config.split_budget);
        }
    }
    if config.pre_split > 0.0 {
        text += &format!(" · pre-split {}", config.pre_split);
    }
    text += &format!(" · leaf {}", config.leaf_limit());
    if config.block != Block::default() {
        text += &format!(" · blocks of {}", config.block.name());
    }
    text += &match config.width {
        Width::W2 => " · binary".to_owned(),
        width => format!(" · {}-wide {}", width.name(), config.widen.name()),
    };
    if config.layout == Layout::Compressed {
        text += " · compressed";
    }
    if config.improver != Improver::None {
        text += &format!(" · {} {}", config.improver.name(), config.rounds);
    }
    if config.improver == Improver::Reinsertion {
        text += &format!(" x {}", config.share);
    }
    if config.stop != StopRule::Limit && !config.is_optimal() && config.builder.weighs_cost() {
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
    rounds(ui, view.palette, world);
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
fn rounds(ui: &mut Ui, palette: &Palette, world: &World) {
    let costs: Vec<f64> = world.report.rounds.iter().map_while(|cost| *cost).collect();
    let [first, .., last] = costs[..] else { return };
    let count = costs.len() - 1;
    widgets::row(ui, Term::RoundCosts, |ui| {
        let rounds = if count == 1 { "round" } else { "rounds" };
        let text = format!("{:.2} % less in {count} {rounds}", 100.0 * (1.0 - last / first));
        ui.label(RichText::new(text).small().color(palette.muted));
    });
    let chart = Chart {
        label: Term::RoundCosts.label(),
        height: 96.0,
        x: Axis::integers(0.0, count as f64, 8).labelled("rounds"),
        y: Axis::around(costs.iter().copied()),
        clickable: false,
    };
    let points: Vec<[f64; 2]> = costs.iter().enumerate().map(|(i, cost)| [i as f64, *cost]).collect();
    let color = palette.accent;
    let shown = chart.show(ui, palette, move |plot| {
        let line = Line::new("cost", PlotPoints::from(points.clone())).color(color).width(1.5);
        plot.line(line.allow_hover(false));
        plot.points(
            Points::new("rounds", PlotPoints::from(points)).color(color).radius(2.5).allow_hover(false),
        );
    });
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

    fn entry(number: usize, scene: &str) -> HistoryEntry {
        HistoryEntry {
            number,
            tree: None,
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
        assert_eq!(summary(&config), "binned 16 · leaf 2 · 8-wide split");
        let config =
            BuildConfig { builder: Builder::Sweep, width: Width::W4, widen: Widen::Collapse, ..config };
        assert_eq!(summary(&config), "sweep · leaf 2 · 4-wide collapse");
        let config = BuildConfig {
            improver: Improver::Reinsertion,
            width: Width::W4,
            widen: Widen::Optimal,
            stop: StopRule::Cost,
            ..BuildConfig::default()
        };
        assert_eq!(summary(&config), "binned 16 · leaf 2 · 4-wide optimal · reinsertion 10 x 0.1");
        let config = BuildConfig {
            width: Width::W2,
            stop: StopRule::Cost,
            traversal_cost: 1.5,
            ..BuildConfig::default()
        };
        assert_eq!(summary(&config), "binned 16 · leaf 2 · binary · stop cost · costs 1.5 1");
    }
}
