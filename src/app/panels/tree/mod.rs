//! The nodes of the tree: an outline, a plot of all of it, and what is known of the node that is selected.

mod details;
mod icicle;
mod outline;
mod overlaps;

use egui::{Button, TextEdit, Ui};

use crate::accel::NodeId;
use crate::app::commands::{Command, Commands, Hide};
use crate::app::selection::{Go, Pick};
use crate::app::view::{AppView, SiblingKey, TreeView};
use crate::inspect::census::Weight;
use crate::inspect::outline::Sought;
use crate::world::NodeFigure;

use super::glossary::Term;
use super::widgets;

/// View state of the Tree panel.
#[derive(Default)]
pub struct TreePanel {
    outline: outline::OutlineView,
    icicle: icicle::IcicleView,
    search: String,
    /// Why nothing was found.
    not_found: Option<String>,
}

impl TreePanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(world) = view.world else {
            widgets::caption(ui, view.palette, "No tree has been built yet.");
            return;
        };
        self.find(ui, view, commands);
        ways(ui, view, commands);
        if world.shown_tree().node_count() == 0 {
            widgets::caption(ui, view.palette, "The tree is empty: the scene has no bounded shape.");
            return;
        }
        self.plot(ui, view, commands);
        self.outline.ui(ui, view, commands);
        details::ui(ui, view, commands);
        overlaps::ui(ui, view, commands);
    }

    /// The field that goes to a number.
    fn find(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(world) = view.world else { return };
        widgets::row(ui, Term::Find, |ui| {
            let field = TextEdit::singleline(&mut self.search).hint_text("12, leaf 3, shape 589");
            let response = ui.add_sized([ui.available_width(), widgets::ROW_HEIGHT], field);
            let response = response.accessible_name(Term::Find.label());
            if response.changed() {
                self.not_found = None;
            }
            if response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) {
                let tree = world.shown_tree();
                match Sought::parse(&self.search, tree, world.scene.shape_count()) {
                    Ok(Sought::Node(node)) => select(commands, node, false),
                    Ok(Sought::Shape(shape)) => {
                        commands.push(Command::Select { pick: Pick::Shape(shape), add: false });
                    }
                    Err(error) => self.not_found = Some(error),
                }
            }
            response
        });
        if let Some(error) = &self.not_found {
            widgets::notice(ui, view.palette.error, widgets::capitalised(error));
        }
    }

    fn plot(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::Icicle);
        let tree_view = *view.tree_view;
        let describe = |w: Weight| (w.name(), w.description());
        let weight =
            widgets::segmented(ui, Term::IcicleWeight, Some(tree_view.weight), &Weight::ALL, &describe);
        if let Some(weight) = weight {
            commands.push(Command::SetTreeView(TreeView { weight, ..tree_view }));
        }
        let describe = |f: NodeFigure| (f.label(), f.description());
        let figure =
            widgets::combo(ui, Term::IcicleColor, Some(tree_view.figure), &NodeFigure::ALL, &describe, "");
        if let Some(figure) = figure {
            commands.push(Command::SetTreeView(TreeView { figure, ..tree_view }));
        }
        self.icicle.ui(ui, view, commands);
    }
}

/// Buttons that lead from what is selected to something else.
fn ways(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let selections = view.selections;
    let selected = selections.current();
    let family = view.census.map(|census| &census.family);
    let above = selected.zip(family).and_then(|(selected, family)| family.parent(selected.node()));
    let below = selected.is_some_and(|selected| selected.node() != selected.tip);
    ui.horizontal_wrapped(|ui| {
        for (enabled, name, way, about) in [
            (selections.can_go_back(), "Back", Go::Back, "To what was selected before (Alt+Left)"),
            (selections.can_go_forward(), "Forward", Go::Forward, "To what was selected after (Alt+Right)"),
            (above.is_some(), "Up", Go::Up, "To the parent ([)"),
            (below, "Down", Go::Down, "Towards the node that one came from (])"),
        ] {
            if ui.add_enabled(enabled, Button::new(name)).on_hover_text(about).clicked() {
                commands.push(Command::GoSelection(way));
            }
        }
        let frame = ui.add_enabled(selected.is_some(), Button::new("Frame"));
        if frame.on_hover_text("Moves the camera so that the selected boxes are seen (F)").clicked() {
            commands.push(Command::FrameSelection);
        }
        let clear = ui.add_enabled(selected.is_some(), Button::new("Deselect"));
        if clear.on_hover_text("Selects nothing (Esc)").clicked() {
            commands.push(Command::ClearSelection);
        }
        let hidden = view.hidden.shapes.len();
        for (enabled, name, what, about) in [
            (selected.is_some(), "Hide", Hide::Selected, "Does not draw what lies below it (H)"),
            (selected.is_some(), "Only this", Hide::Others, "Hides all else (O)"),
            (hidden > 0, "Show all", Hide::Nothing, "Draws all shapes again (J)"),
        ] {
            if ui.add_enabled(enabled, Button::new(name)).on_hover_text(about).clicked() {
                commands.push(Command::Hide(what));
            }
        }
        if hidden > 0 {
            let text = format!("{} shapes are hidden", super::numbers::count(hidden));
            ui.label(egui::RichText::new(text).small().color(view.palette.warning));
        }
    });
}

fn select(commands: &mut Commands, node: NodeId, add: bool) {
    commands.push(Command::Select { pick: Pick::Node(node), add });
}

/// The weight of a node and all below it; `None` while it is not known.
fn weight_of<'v>(view: &'v AppView, weight: Weight) -> Option<Box<dyn Fn(NodeId) -> f64 + 'v>> {
    let census = view.census?;
    match weight {
        Weight::Shapes => Some(Box::new(|node| f64::from(census.family.references(node)))),
        Weight::SahCost => census
            .knows_sah_below()
            .then(|| Box::new(|node| census.known_sah_below(node).map_or(0.0, f64::from)) as _),
        Weight::Visits => {
            let (_, visits) = view.visits?;
            Some(Box::new(|node| visits.below.get(node.0 as usize).map_or(0.0, |v| f64::from(*v))))
        }
    }
}

/// What the colours of the plot tell of every node, once it is known.
fn color_values<'v>(view: &'v AppView) -> Option<&'v crate::inspect::census::Values> {
    match view.tree_view.figure {
        NodeFigure::Visits => view.visits.map(|(_, visits)| &visits.own),
        figure => view.census?.known_values(figure),
    }
}

/// The value by which siblings are put in order; `None` for none, or while it is not known.
fn sibling_value<'v>(view: &'v AppView) -> Option<Box<dyn Fn(NodeId) -> f64 + 'v>> {
    match view.tree_view.order {
        SiblingKey::Slot => None,
        SiblingKey::Weight(weight) => weight_of(view, weight),
        SiblingKey::Figure => {
            let values = color_values(view)?;
            Some(Box::new(|node| values.of_nodes.get(node.0 as usize).map_or(f64::NAN, |v| f64::from(*v))))
        }
    }
}

/// What a node is called: leaves by their number among all nodes, too, so that every node has one number.
pub fn node_name(world: &crate::world::World, node: NodeId) -> String {
    match world.shown_tree().leaf_index(node) {
        Some(leaf_idx) => format!("leaf {leaf_idx}"),
        None => format!("node {}", node.0),
    }
}
