//! How the tree came about: step by step, forwards and backwards, with what stands drawn in the viewport.

use egui::{Button, Slider, Ui};

use crate::accel::build::RoundKind;
use crate::app::commands::{Command, Commands};
use crate::app::player::{PlayerView, SPEEDS};
use crate::app::selection::Pick;
use crate::app::view::AppView;
use crate::inspect::construction::{Construction, Standing};

use super::glossary::Term;
use super::numbers;
use super::tree::node_name;
use super::widgets::{self, Figure};

/// View state of the Construction panel.
#[derive(Default)]
pub struct ConstructionPanel {}

impl ConstructionPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::Construction);
        let (Some(world), Some(tree)) = (view.world, view.tree) else {
            widgets::caption(ui, view.palette, "No tree has been built yet.");
            return;
        };
        let Some(construction) = view.player.of(tree) else {
            widgets::caption(ui, view.palette, "Looking at how the tree was built…");
            return;
        };
        let text = match &**construction {
            Construction::TopDown { .. } if world.imported.is_some() => {
                "The file does not say how its tree was built: its inner nodes are shown in their order."
            }
            Construction::TopDown { .. } => "From the root down: every step splits a node, depth first.",
            Construction::Rounds(_) => "Round by round: what stood before the first round, and after each.",
        };
        widgets::caption(ui, view.palette, text);
        let (step, count) = view.player.step(tree);
        if count == 0 {
            widgets::caption(ui, view.palette, "There is no step: the tree is a single leaf.");
            return;
        }
        player(ui, view, (step, count), construction, commands);
        figures(ui, view, (step, count), construction, commands);
    }
}

fn player(
    ui: &mut Ui,
    view: &AppView,
    (step, count): (usize, usize),
    construction: &Construction,
    commands: &mut Commands,
) {
    let player_view = view.player.view;
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        let button = |ui: &mut Ui, enabled: bool, name: &str, about: &str| {
            ui.add_enabled(enabled, Button::new(name)).on_hover_text(about).clicked()
        };
        if button(ui, step > 0, "Start", "Before the first step") {
            asked = Some((0, false));
        }
        if button(ui, step > 0, "Back", "One step back") {
            asked = Some((step - 1, false));
        }
        if button(ui, step < count, "Forward", "One step forward") {
            asked = Some((step + 1, false));
        }
        if button(ui, step < count, "End", "The finished tree") {
            asked = Some((count, false));
        }
        let play = if player_view.playing { "Hold" } else { "Play" };
        if button(ui, true, play, "Plays the steps, from the first one after the last") {
            asked = Some((if step >= count { 0 } else { step }, !player_view.playing));
        }
        let selected = view.selections.current().map(|s| s.node());
        let target =
            selected.zip(view.world).and_then(|(node, world)| construction.step_of(world.shown_tree(), node));
        let to =
            button(ui, target.is_some(), "To the selected node", "The step that splits the selected node");
        if let Some(target) = target.filter(|_| to) {
            asked = Some((target, false));
        }
    });
    if let Some((step, playing)) = asked {
        commands.push(Command::SetPlayerView(PlayerView { step, playing, ..player_view }));
    }
    let mut at = step;
    let slider = Slider::new(&mut at, 0..=count).trailing_fill(true);
    if widgets::slider(ui, Term::ConstructionStep, slider).changed() {
        commands.push(Command::SetPlayerView(PlayerView { step: at, playing: false, ..player_view }));
    }
    let mut speed = player_view.speed;
    let slider = Slider::new(&mut speed, SPEEDS).logarithmic(true).max_decimals(1).trailing_fill(true);
    if widgets::slider(ui, Term::PlaySpeed, slider).changed() {
        commands.push(Command::SetPlayerView(PlayerView { speed, ..player_view }));
    }
}

fn figures(
    ui: &mut Ui,
    view: &AppView,
    (step, count): (usize, usize),
    construction: &Construction,
    commands: &mut Commands,
) {
    let Some(world) = view.world else { return };
    let palette = view.palette;
    match construction {
        Construction::TopDown { .. } => {
            let made = format!("{} of {}", numbers::count(step), numbers::count(count));
            Figure::new(Term::SplitsMade, made).show(ui, palette);
            let split = view.tree.and_then(|tree| view.player.shown(tree)?.split.as_ref());
            if let Some((node, _, children)) = split {
                ui.horizontal_wrapped(|ui| {
                    ui.label(format!("Just split into {}:", children.len()));
                    if ui.button(node_name(world, *node)).on_hover_text("Selects it").clicked() {
                        commands.push(Command::Select { pick: Pick::Node(*node), add: false });
                    }
                });
            }
        }
        Construction::Rounds(rounds) => {
            let Some(standing) = rounds.get(step) else { return };
            let made = format!("{} of {}", numbers::count(step), numbers::count(count));
            Figure::new(Term::RoundsMade, made).show(ui, palette);
            round(ui, view, standing);
        }
    }
    if step == count {
        widgets::caption(ui, palette, "The tree is finished; Play begins again.");
    }
}

fn round(ui: &mut Ui, view: &AppView, standing: &Standing) {
    let term = match standing.kind {
        RoundKind::Merge => Term::Clusters,
        RoundKind::Improve => Term::NodesStanding,
    };
    Figure::new(term, numbers::count(standing.count)).show(ui, view.palette);
    Figure::new(Term::StandingArea, numbers::decimal(standing.area, 3)).show(ui, view.palette);
}
