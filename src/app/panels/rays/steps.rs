//! The player of a ray's steps: a list, the stack beside it, forwards and backwards.

use egui::accesskit::Role;
use egui::{Button, RichText, ScrollArea, Sense, Slider, Ui, WidgetInfo, vec2};

use super::shape_name;
use crate::app::commands::{Command, Commands};
use crate::app::inspection::{RayView, SPEEDS};
use crate::app::panels::glossary::Term;
use crate::app::panels::numbers;
use crate::app::panels::tree::node_name;
use crate::app::panels::widgets::{self, Side};
use crate::app::selection::Pick;
use crate::app::view::AppView;
use crate::inspect::ray_history::{Outcome, RayHistory, RayStep};
use crate::world::World;

const LINE_HEIGHT: f32 = 17.0;
/// Steps that are seen at once.
const LINES: f32 = 14.0;
/// Side by side, as soon as each has this much room.
const COLUMN_WIDTH: f32 = 210.0;

/// What the list shows.
#[derive(Default)]
pub struct StepsView {
    /// The step that was last brought into view.
    shown: usize,
}

impl StepsView {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, world: &World, commands: &mut Commands) {
        widgets::term_section(ui, Term::RaySteps);
        let Some(recorded) = &view.inspection.recorded else { return };
        player(ui, view, commands);
        let (step, _) = view.inspection.step();
        let scroll = (self.shown != step).then_some(step);
        self.shown = step;
        if ui.available_width() >= 3.0 * COLUMN_WIDTH {
            ui.columns(3, |columns| {
                for (i, (column, way)) in columns.iter_mut().zip(&recorded.ways).enumerate() {
                    column.label(RichText::new(way.query.name()).small().color(view.palette.muted));
                    list(column, view, world, way, i, scroll, commands);
                }
            });
        } else {
            list(ui, view, world, &recorded.history, 3, scroll, commands);
        }
        stack(ui, view, world, &recorded.history, commands);
    }
}

/// Buttons, the slider of steps, and the speed.
fn player(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let ray_view = view.inspection.view;
    let (step, count) = view.inspection.step();
    let mut asked = None;
    ui.horizontal_wrapped(|ui| {
        let button = |ui: &mut Ui, enabled: bool, name: &str, about: &str| {
            ui.add_enabled(enabled, Button::new(name)).on_hover_text(about).clicked()
        };
        if button(ui, step > 0, "First", "Before the first step") {
            asked = Some((0, false));
        }
        if button(ui, step > 0, "Step back", "One step back (,)") {
            asked = Some((step - 1, false));
        }
        if button(ui, step < count, "Step", "One step forward (.)") {
            asked = Some((step + 1, false));
        }
        if button(ui, step < count, "Last", "After the last step") {
            asked = Some((count, false));
        }
        let play = if ray_view.playing { "Hold" } else { "Play" };
        if button(ui, count > 0, play, "Plays the steps, from the first one after the last") {
            asked = Some((if step >= count { 0 } else { step }, !ray_view.playing));
        }
    });
    if let Some((step, playing)) = asked {
        commands.push(Command::SetRayView(RayView { step, playing, ..ray_view }));
    }
    let mut at = step;
    let slider = Slider::new(&mut at, 0..=count).trailing_fill(true);
    if widgets::slider(ui, Term::RaySteps, slider).changed() {
        commands.push(Command::SetRayView(RayView { step: at, playing: false, ..ray_view }));
    }
    let mut speeds = SPEEDS;
    speeds.sort_by(f32::total_cmp);
    widgets::row(ui, Term::PlaySpeed, |ui| {
        for speed in speeds {
            if ui.selectable_label(ray_view.speed == speed, format!("{speed}")).clicked() {
                commands.push(Command::SetRayView(RayView { speed, ..ray_view }));
            }
        }
    });
}

fn list(
    ui: &mut Ui,
    view: &AppView,
    world: &World,
    history: &RayHistory,
    salt: usize,
    scroll: Option<usize>,
    commands: &mut Commands,
) {
    if history.missed_root {
        widgets::caption(ui, view.palette, "The ray misses the root's box: it visits nothing.");
    }
    let (step, _) = view.inspection.step();
    let count = history.steps.len();
    let height = LINE_HEIGHT * LINES.min(count as f32) + 2.0;
    let mut area =
        ScrollArea::vertical().id_salt(("ray steps", salt)).max_height(height).auto_shrink([false, true]);
    if let Some(step) = scroll {
        let top = (step.min(count) as f32 - 0.6 * LINES).max(0.0) * LINE_HEIGHT;
        area = area.vertical_scroll_offset(top);
    }
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        area.show_rows(ui, LINE_HEIGHT, count, |ui, rows| {
            for index in rows {
                if step_line(ui, view, world, &history.steps[index], index, index + 1 == step) {
                    let ray_view = RayView { step: index + 1, playing: false, ..view.inspection.view };
                    commands.push(Command::SetRayView(ray_view));
                }
            }
        });
    });
}

/// Whether it was clicked.
fn step_line(
    ui: &mut Ui,
    view: &AppView,
    world: &World,
    step: &RayStep,
    index: usize,
    current: bool,
) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    widgets::paint_line(ui, rect, &response, current);
    let text = words(world, step);
    let color = match step {
        _ if current => view.palette.accent,
        RayStep::Shape { outcome: Outcome::Nearest { .. } | Outcome::Stops { .. }, .. }
        | RayStep::Stop { .. }
        | RayStep::Nearest { .. } => view.palette.good,
        RayStep::Drop { .. }
        | RayStep::Shape { outcome: Outcome::Skipped | Outcome::NotReached | Outcome::Missed, .. } => {
            view.palette.muted
        }
        _ => ui.visuals().text_color(),
    };
    let indent = match step {
        RayStep::Push { .. } | RayStep::Shape { .. } => 16.0,
        _ => 4.0,
    };
    let cell = egui::Rect::from_min_max(rect.min + vec2(indent, 0.0), rect.max - vec2(4.0, 0.0));
    widgets::paint_text(ui, cell, Side::Left, &text, widgets::small_font(ui), color);
    response.widget_info(|| {
        WidgetInfo::selected(Role::ListItem, true, current, format!("Step {}: {text}", index + 1))
    });
    let clicked = response.clicked();
    response.on_hover_text(text);
    clicked
}

/// A step in words.
pub fn words(world: &World, step: &RayStep) -> String {
    let t = |t: f32| numbers::short(f64::from(t));
    let node = |node| node_name(world, node);
    match step {
        RayStep::Begin { t_min } if *t_min > 0.0 => format!("walk from t {} on", t(*t_min)),
        RayStep::Begin { .. } => "walk from the root".to_owned(),
        RayStep::Outside { shape, outcome } => {
            format!("outside the tree: {} {}", shape_name(world, *shape), outcome_words(*outcome))
        }
        RayStep::Boxes { node: at, children, .. } => {
            let entered = children.iter().filter(|child| child.entry.is_some()).count();
            format!("{}: {entered} of {} boxes entered", node(*at), children.len())
        }
        RayStep::Push { node: at, entry } => format!("{} waits, from t {}", node(*at), t(*entry)),
        RayStep::Pop { node: at, entry } => format!("back to {}, from t {}", node(*at), t(*entry)),
        RayStep::Drop { node: at, entry, t_max } => {
            format!("{} dropped: begins at t {}, behind {}", node(*at), t(*entry), t(*t_max))
        }
        RayStep::Leaf { node: at } => node(*at),
        RayStep::Shape { shape, outcome } => {
            format!("{} {}", shape_name(world, *shape), outcome_words(*outcome))
        }
        RayStep::Stop { shape } => format!("stops early at {}", shape_name(world, *shape)),
        RayStep::Nearest { shape, t: at } => {
            format!("nearest hit: {} at t {}", shape_name(world, *shape), t(*at))
        }
        RayStep::Miss => "nothing was hit".to_owned(),
    }
}

fn outcome_words(outcome: Outcome) -> String {
    let t = |t: f32| numbers::short(f64::from(t));
    match outcome {
        Outcome::Missed => "missed".to_owned(),
        Outcome::Behind { t: at } => format!("hit at t {}, behind the nearest", t(at)),
        Outcome::Nearest { t: at } => format!("hit at t {}: the nearest so far", t(at)),
        Outcome::Stops { t: at } => format!("hit at t {}: stops the ray", t(at)),
        Outcome::LetsPass { t: at } => format!("hit at t {}, lets light pass", t(at)),
        Outcome::Skipped => "not tested: lets light pass".to_owned(),
        Outcome::NotReached => "not tested: the ray had stopped".to_owned(),
    }
}

/// What waits after this step.
fn stack(ui: &mut Ui, view: &AppView, world: &World, history: &RayHistory, commands: &mut Commands) {
    let (step, _) = view.inspection.step();
    let moment = history.after(step);
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(Term::RayStack.label()).small().color(view.palette.muted))
            .on_hover_text(Term::RayStack.text());
        if moment.stack.is_empty() {
            ui.label(RichText::new("nothing").small());
        }
        for (node, entry) in moment.stack.iter().rev().take(24) {
            let text = format!("{} {}", node_name(world, *node), numbers::short(f64::from(*entry)));
            if ui.add(Button::new(RichText::new(text).small()).small()).clicked() {
                commands.push(Command::Select { pick: Pick::Node(*node), add: false });
            }
        }
        let more = moment.stack.len().saturating_sub(24);
        if more > 0 {
            ui.label(RichText::new(format!("and {more} more")).small().color(view.palette.muted));
        }
    });
    if let Some((shape, t)) = moment.nearest {
        let text =
            format!("Nearest so far: {} at t {}", shape_name(world, shape), numbers::short(f64::from(t)));
        ui.label(RichText::new(text).small().color(view.palette.muted));
    }
}
