//! Everything that is known of the node that was selected last.

use egui::accesskit::Role;
use egui::{RichText, ScrollArea, Sense, Ui, WidgetInfo, vec2};

use super::{node_name, select};
use crate::app::commands::{Command, Commands};
use crate::app::panels::glossary::Term;
use crate::app::panels::numbers;
use crate::app::panels::widgets::{self, Figure, Side};
use crate::app::selection::Pick;
use crate::app::view::AppView;
use crate::inspect::node::{Child, NodeFacts};
use crate::world::World;

const LINE_HEIGHT: f32 = 18.0;
/// Shapes of a leaf that are seen at once.
const LINES: f32 = 8.0;

pub fn ui(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::term_section(ui, Term::SelectedNode);
    let (Some(world), Some(selection)) = (view.world, view.selections.current()) else {
        let text = "Nothing is selected. Click in the viewport, in the plot or in the outline; Ctrl adds.";
        widgets::caption(ui, view.palette, text);
        return;
    };
    let Some(facts) = view.census.and_then(|census| NodeFacts::of(world, &census.family, selection.node()))
    else {
        widgets::caption(ui, view.palette, "Looking at the nodes…");
        return;
    };
    heading(ui, view, world, &facts);
    figures(ui, view, &facts);
    family(ui, view, world, &facts, commands);
    if facts.is_leaf() {
        shapes(ui, view, world, &facts, commands);
    }
}

fn heading(ui: &mut Ui, view: &AppView, world: &World, facts: &NodeFacts) {
    let selection = view.selections.current();
    let name = widgets::capitalised(&node_name(world, facts.node));
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(name).strong().color(view.palette.accent));
        if let Some(shape) = selection.and_then(|s| s.shape) {
            ui.label(format!("with {} {shape}", world.scene.shape(shape).kind().name()));
        }
        let count = selection.map_or(0, |s| s.nodes.len());
        if count > 1 {
            ui.label(RichText::new(format!("and {} more", count - 1)).color(view.palette.muted));
        }
    });
}

fn figures(ui: &mut Ui, view: &AppView, facts: &NodeFacts) {
    let palette = view.palette;
    let percent = |share: Option<f64>| numbers::decimal(share.map(|s| 100.0 * s), 3);
    Figure::new(Term::NodeDepth, numbers::count(facts.depth)).unit("").show(ui, palette);
    Figure::new(Term::NodeReferences, numbers::count(facts.references)).unit("").show(ui, palette);
    let size = facts.bounds.extent().to_array().map(|x| numbers::short(f64::from(x)));
    let corners = format!("From {:?} to {:?}.", facts.bounds.min.to_array(), facts.bounds.max.to_array());
    Figure::new(Term::NodeSize, size.join(" x ")).unit("").note(corners).show(ui, palette);
    Figure::new(Term::AreaShare, percent(facts.area_share)).unit("%").show(ui, palette);
    Figure::new(Term::OwnSah, numbers::decimal(facts.sah_cost, 5)).unit("").show(ui, palette);
    let below = view.census.and_then(|census| census.known_sah_below(facts.node)).map(f64::from);
    Figure::new(Term::SahBelow, percent(below)).unit("%").show(ui, palette);
    if !facts.is_leaf() {
        Figure::new(Term::NodeOverlap, percent(facts.overlap)).unit("%").show(ui, palette);
        Figure::new(Term::NodeEmpty, percent(facts.empty_space)).unit("%").show(ui, palette);
    }
    let visits = view.visits.and_then(|(key, visits)| {
        let count = *visits.own.of_nodes.get(facts.node.0 as usize)?;
        Some((key.count, count))
    });
    let shown = visits.map_or(numbers::DASH.to_owned(), |(_, count)| numbers::count(count as u64));
    let mut figure = Figure::new(Term::NodeVisits, shown).unit("");
    if let Some((count, _)) = visits {
        figure = figure.note(format!("Rays that count: {}.", count.description()));
    }
    figure.show(ui, palette);
}

fn family(ui: &mut Ui, view: &AppView, world: &World, facts: &NodeFacts, commands: &mut Commands) {
    if let Some(parent) = facts.parent {
        widgets::row(ui, Term::NodeParent, |ui| {
            let button = ui.button(node_name(world, parent));
            if button.clicked() {
                select(commands, parent, false);
            }
            button
        });
    }
    if facts.is_leaf() {
        return;
    }
    ui.label(RichText::new(Term::Children.label()).small().color(view.palette.muted))
        .on_hover_text(Term::Children.text());
    ui.spacing_mut().item_spacing.y = 0.0;
    let own = f64::from(facts.bounds.area());
    for child in &facts.children {
        if child_line(ui, view, world, child, own) {
            select(commands, child.node, false);
        }
    }
    widgets::set_spacing(ui);
}

fn child_line(ui: &mut Ui, view: &AppView, world: &World, child: &Child, parent_area: f64) -> bool {
    let name = node_name(world, child.node);
    let shapes = if child.references == 1 { "shape" } else { "shapes" };
    let text = format!("{name} · {} {shapes}", numbers::count(child.references));
    let area = (parent_area > 0.0).then(|| 100.0 * f64::from(child.bounds.area()) / parent_area);
    let right = format!("{} % area", numbers::decimal(area, 1));
    line(ui, view, &text, &right, &name).on_hover_text("Its area as a share of its parent's").clicked()
}

/// A line that can be clicked.
fn line(ui: &mut Ui, view: &AppView, left: &str, right: &str, name: &str) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    widgets::paint_line(ui, rect, &response, false);
    let cell = rect.shrink2(vec2(4.0, 0.0));
    let (text, muted) = (ui.visuals().text_color(), view.palette.muted);
    let (first, second) = cell.split_left_right_at_fraction(0.62);
    widgets::paint_text(ui, first, Side::Left, left, widgets::body_font(ui), text);
    widgets::paint_text(ui, second, Side::Right, right, widgets::small_font(ui), muted);
    let name = name.to_owned();
    response.widget_info(|| WidgetInfo::labeled(Role::Link, true, &name));
    response
}

fn shapes(ui: &mut Ui, view: &AppView, world: &World, facts: &NodeFacts, commands: &mut Commands) {
    ui.label(RichText::new(Term::LeafShapes.label()).small().color(view.palette.muted))
        .on_hover_text(Term::LeafShapes.text());
    let selected = view.selections.current().and_then(|s| s.shape);
    let height = LINE_HEIGHT * LINES.min(facts.shapes.len() as f32) + 2.0;
    let list = ScrollArea::vertical().id_salt("shapes").max_height(height).auto_shrink([false, true]);
    ui.spacing_mut().item_spacing.y = 0.0;
    list.show_rows(ui, LINE_HEIGHT, facts.shapes.len(), |ui, rows| {
        for &shape in &facts.shapes[rows] {
            let geometry = world.scene.shape(shape);
            let kind = geometry.kind().name();
            let mark = if selected == Some(shape) { " (selected)" } else { "" };
            let material = &world.scene.material(shape).name;
            let size = numbers::short(f64::from(geometry.bounds().extent().max_element()));
            let response =
                line(ui, view, &format!("{kind} {shape}{mark}"), &format!("{material} · {size}"), "shape");
            if response.on_hover_text("Its material, and the longest side of its box").clicked() {
                commands.push(Command::Select { pick: Pick::Shape(shape), add: false });
            }
        }
    });
    widgets::set_spacing(ui);
}
