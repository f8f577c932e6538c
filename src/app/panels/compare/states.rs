//! The list of states, and what makes new ones: keeping the current one, another moment, another scene, our own tree.

use egui::accesskit::Role;
use egui::{Color32, DragValue, Pos2, Rect, Response, Sense, Stroke, TextEdit, Ui, WidgetInfo, pos2, vec2};

use crate::app::commands::{Command, Commands};
use crate::app::view::{AppView, CompareStyle, CompareViews};
use crate::scene::SceneRef;
use crate::session::{MAX_VARIANTS, Session, SessionScene, Variant};

use super::super::build::summary;
use super::super::glossary::Term;
use super::super::numbers;
use super::super::widgets::{self, ROW_HEIGHT, Side};

const NAME_WIDTH: f32 = 92.0;
const MOST_NAME: usize = 100;
const ICON_WIDTH: f32 = 24.0;
const LINE_HEIGHT: f32 = 14.0;

/// View state of the list.
#[derive(Default)]
pub struct States {
    /// The name that is being typed, and of which state.
    typed: Option<(usize, String)>,
}

/// View state of what makes new states.
pub struct Others {
    dt: f32,
    scene: String,
}

impl Default for Others {
    fn default() -> Self {
        Self { dt: 0.5, scene: String::new() }
    }
}

impl States {
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        view: &AppView,
        current: Option<CompareViews>,
        commands: &mut Commands,
    ) {
        widgets::term_section(ui, Term::States);
        for index in 0..view.session.variants.len() {
            self.state(ui, view, index, current, commands);
        }
        let may_keep = view.session.variants.len() < MAX_VARIANTS;
        let free = view.session.free_name();
        let text = format!("Keep {} and go on as {free}", named(view, view.session.active));
        let keep = ui.add_enabled(may_keep, egui::Button::new(text).truncate());
        let keep = keep.on_hover_text(
            "Keeps the current settings under their name. What you change from now on is the new state.",
        );
        if keep.accessible_name("Keep the current state").clicked() {
            commands.edit(|s| {
                s.keep();
            });
            // Who looks at the current state goes on looking at it.
            let (old, new) = (view.session.active, view.session.variants.len());
            if let Some(mut compare) = current {
                for side in [&mut compare.left, &mut compare.right] {
                    if side.variant == Some(old) {
                        side.variant = Some(new);
                    }
                }
                commands.push(Command::SetCompareViews(Some(compare)));
            }
        }
    }

    fn state(
        &mut self,
        ui: &mut Ui,
        view: &AppView,
        index: usize,
        current: Option<CompareViews>,
        commands: &mut Commands,
    ) {
        let session = view.session;
        let is_active = index == session.active;
        let between = ui.spacing().item_spacing.y;
        ui.horizontal(|ui| {
            self.name(ui, view, index, commands);
            let use_it = egui::Button::selectable(is_active, if is_active { "current" } else { "use" })
                .frame_when_inactive(true);
            let use_it = ui.add_sized(vec2(58.0, ROW_HEIGHT), use_it).on_hover_text(if is_active {
                "This is the state that the other panels show and change."
            } else {
                "Makes this state the one that the other panels show and change."
            });
            let name = &session.variants[index].name;
            if use_it.accessible_name(format!("Use {name}")).clicked() && !is_active {
                commands.push(Command::ActivateVariant(index));
            }
            let pin =
                icon_button(ui, &format!("Pin {name}"), Icon::Pin(is_pinned(session, index)), !is_active);
            if pin.on_hover_text(Term::PinState.text()).clicked() {
                commands.edit(move |s| pin_or_loosen(s, index));
            }
            let remove = icon_button(ui, &format!("Forget {name}"), Icon::Cross, !is_active);
            if remove.on_hover_text("Forgets this state.").clicked() {
                self.typed = None;
                commands.edit(move |s| {
                    s.remove_variant(index);
                });
                if let Some(compare) = current {
                    commands.push(Command::SetCompareViews(compare.without(index)));
                }
            }
        });
        ui.spacing_mut().item_spacing.y = 1.0;
        for line in about(view, index) {
            let (rect, response) =
                ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::hover());
            let cell = rect.with_min_x(rect.left() + 4.0);
            let (font, muted) = (widgets::small_font(ui), view.palette.muted);
            widgets::paint_text(ui, cell, Side::Left, &line, font, muted);
            response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &line));
            response.on_hover_text(line);
        }
        ui.spacing_mut().item_spacing.y = between;
    }

    /// A name that can be changed.
    fn name(&mut self, ui: &mut Ui, view: &AppView, index: usize, commands: &mut Commands) {
        let name = &view.session.variants[index].name;
        let mut text = match &self.typed {
            Some((typed, text)) if *typed == index => text.clone(),
            _ => name.clone(),
        };
        let edit = TextEdit::singleline(&mut text).char_limit(MOST_NAME).align(egui::Align2::LEFT_CENTER);
        let width = (ui.available_width() - 58.0 - 2.0 * ICON_WIDTH - 20.0).clamp(NAME_WIDTH, 200.0);
        let response = ui
            .add_sized(vec2(width, ROW_HEIGHT), edit)
            .accessible_name(format!("Name of state {}", index + 1))
            .on_hover_text("What this state is called.");
        if response.changed() {
            self.typed = Some((index, text));
        }
        if response.lost_focus()
            && let Some((index, text)) = self.typed.take()
        {
            let text: String = text.trim().chars().filter(|c| !c.is_control()).collect();
            if !text.is_empty() {
                commands.edit(move |s| s.variants[index].name = text);
            }
        }
    }
}

impl Others {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Against something else");
        self.moment(ui, view, commands);
        own_tree(ui, view, commands);
        self.scene(ui, view, commands);
    }

    fn moment(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let moves = view.scene.is_some_and(|scene| scene.is_animated());
        widgets::row(ui, Term::CompareMoment, |ui| {
            let field =
                DragValue::new(&mut self.dt).range(-1e3..=1e3).speed(0.01).prefix("t + ").suffix(" s");
            ui.spacing_mut().interact_size.x = 86.0;
            ui.add_enabled(moves, field)
                .accessible_name("Time step")
                .on_hover_text(Term::CompareMoment.text());
            let go = ui.add_enabled(moves, egui::Button::new("Compare"));
            let go = go.on_hover_text("Shows this moment beside the later one.");
            let go = go.on_disabled_hover_text("Nothing moves in this scene.");
            if go.accessible_name("Compare with the later moment").clicked() && self.dt != 0.0 {
                let time = view.session.time + self.dt;
                let name = format!("{} at {time} s", named(view, view.session.active));
                add(view, commands, |active| Variant { name, time: Some(time), ..active });
            }
        });
    }

    fn scene(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::row(ui, Term::CompareScene, |ui| {
            let edit = TextEdit::singleline(&mut self.scene)
                .hint_text("soup:1000")
                .align(egui::Align2::LEFT_CENTER)
                .desired_width(ui.available_width() - 78.0);
            ui.add(edit).accessible_name("Other scene").on_hover_text(Term::CompareScene.text());
            let text = self.scene.trim().to_owned();
            let go = ui.add_enabled(!text.is_empty(), egui::Button::new("Compare"));
            if go.accessible_name("Compare with the other scene").clicked() {
                let scene = SessionScene { reference: SceneRef::parse(&text), ..SessionScene::default() };
                add(view, commands, |active| Variant {
                    name: text.chars().filter(|c| !c.is_control()).take(MOST_NAME).collect(),
                    scene: Some(scene),
                    // A tree of a file is one over another scene.
                    tree: None,
                    ..active
                });
            }
        });
    }
}

fn own_tree(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::row(ui, Term::CompareOwnTree, |ui| {
        let has_file = view.session.tree().is_some();
        let go = ui.add_enabled(has_file, egui::Button::new("Compare"));
        let go = go.on_disabled_hover_text("No tree of a file is open: the panel Tree file imports one.");
        if go.accessible_name("Compare with our own tree").clicked() {
            let name = format!("{}, built here", named(view, view.session.active));
            add(view, commands, |active| Variant { name, tree: None, ..active });
        }
    });
}

/// Adds a state that differs from the active one, and compares the two.
fn add(view: &AppView, commands: &mut Commands, change: impl FnOnce(Variant) -> Variant) {
    let mut session = view.session.clone();
    let active = session.active;
    let variant = change(session.variants[active].clone());
    let Some(index) = session.add_or_find(variant) else {
        let message = format!("There are {MAX_VARIANTS} states already: forget one first.");
        commands.push(Command::Report { message, error: true });
        return;
    };
    commands.edit(move |s| s.variants = session.variants);
    let style = view.compare.map_or(CompareStyle::SideBySide, |compare| compare.style);
    commands.push(Command::SetCompareViews(Some(CompareViews::of_states(active, index, style))));
}

/// The name of a state, short enough for a button.
pub fn named(view: &AppView, index: usize) -> String {
    crate::app::ab::shortened(&view.session.variants[index].name)
}

/// A state in a list of choices.
pub fn title(view: &AppView, index: usize) -> String {
    let current = if index == view.session.active { " (current)" } else { "" };
    format!("{}{current}", named(view, index))
}

/// Whether scene and moment are its own.
fn is_pinned(session: &Session, index: usize) -> bool {
    let state = &session.variants[index];
    state.scene.is_some() || state.time.is_some()
}

/// Keeps scene and moment of now, or follows the session's.
fn pin_or_loosen(session: &mut Session, index: usize) {
    let (scene, time) = (session.scene_of(index).clone(), session.time_of(index));
    let pinned = is_pinned(session, index);
    let Some(state) = session.variants.get_mut(index) else { return };
    (state.scene, state.time) = if pinned { (None, None) } else { (Some(scene), Some(time)) };
}

/// Settings, scene and moment, and what is known of its tree.
fn about(view: &AppView, index: usize) -> Vec<String> {
    let state = &view.session.variants[index];
    let mut what = match &state.tree {
        Some(tree) => {
            format!("imported {}", tree.path.file_name().unwrap_or_default().to_string_lossy())
        }
        None => summary(&state.build),
    };
    if let Some(scene) = &state.scene {
        what += &format!(" · {}", scene.reference.text());
    }
    if let Some(time) = state.time {
        what += &format!(" · at {time} s");
    }
    let scene = view.scene.map_or("", |scene| &*scene.name);
    let known = view.history.iter().rev().find(|entry| {
        !is_pinned(view.session, index)
            && (entry.config, &entry.tree, &*entry.scene, entry.time)
                == (state.build, &state.tree, scene, view.session.time)
    });
    let figures = known.map(|entry| {
        let (bytes, unit) = numbers::bytes(entry.bytes);
        format!(
            "SAH cost {}, {} nodes visited, {bytes} {unit}",
            numbers::decimal(entry.sah_cost, 2),
            numbers::decimal(entry.nodes_visited_mean, 2)
        )
    });
    std::iter::once(what).chain(figures).collect()
}

/// What a small button shows.
#[derive(Clone, Copy)]
pub enum Icon {
    Cross,
    Swap,
    /// Whether it is in.
    Pin(bool),
}

/// A small button with a painted sign.
pub fn icon_button(ui: &mut Ui, name: &str, icon: Icon, enabled: bool) -> Response {
    let sense = if enabled { Sense::click() } else { Sense::hover() };
    let (rect, response) = ui.allocate_exact_size(vec2(ICON_WIDTH, ROW_HEIGHT), sense);
    let visuals = if enabled { ui.style().interact(&response) } else { ui.visuals().noninteractive() };
    let fill = if enabled { visuals.weak_bg_fill } else { Color32::TRANSPARENT };
    ui.painter().rect_filled(rect, visuals.corner_radius, fill);
    let color = if enabled { visuals.text_color() } else { visuals.text_color().gamma_multiply(0.35) };
    paint_icon(ui, rect, icon, Stroke::new(1.5, color));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, name));
    response
}

fn paint_icon(ui: &Ui, rect: Rect, icon: Icon, stroke: Stroke) {
    let at = |x: f32, y: f32| -> Pos2 { rect.center() + vec2(x, y) };
    let line = |a: Pos2, b: Pos2| {
        ui.painter().line_segment([a, b], stroke);
    };
    match icon {
        Icon::Cross => {
            line(at(-4.0, -4.0), at(4.0, 4.0));
            line(at(-4.0, 4.0), at(4.0, -4.0));
        }
        Icon::Swap => {
            for (x, tip) in [(-3.0, -1.0), (3.0, 1.0)] {
                line(at(x, -5.0), at(x, 5.0));
                let end = at(x, 5.0 * tip);
                line(end, pos2(end.x - 3.0, end.y - 3.0 * tip));
                line(end, pos2(end.x + 3.0, end.y - 3.0 * tip));
            }
        }
        Icon::Pin(is_in) => {
            if is_in {
                ui.painter().circle_filled(at(0.0, -2.0), 4.0, stroke.color);
            } else {
                ui.painter().circle_stroke(at(0.0, -2.0), 3.5, stroke);
            }
            line(at(0.0, 2.0), at(0.0, 7.0));
        }
    }
}
