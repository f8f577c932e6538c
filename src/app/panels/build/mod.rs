//! Which tree is built, and how the build went.

mod report;
mod summary;

use egui::{DragValue, Slider, Ui};

use crate::accel::{Block, BuildConfig, Builder, Improver, Layout, Morton, StopRule, Widen, Width};
use crate::app::commands::{Command, Commands};
use crate::app::theme::Palette;
use crate::app::view::AppView;

use super::PanelKind;
use super::glossary::Term;
use super::history::History;
use super::widgets;

pub use summary::summary;

/// As far as the sliders of the improver go; flags and sessions go further.
const MANY_ROUNDS: usize = 100;
const SMALL_SHARE: f32 = 0.01;
/// As far as the slider goes; the flag and sessions go further.
const MUCH_PRE_SPLIT: f32 = 1.0;

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
        report::status(ui, view, commands);
        report::report(ui, view, commands);
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
