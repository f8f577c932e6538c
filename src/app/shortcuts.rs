//! The keys, what they do, and the page that lists them. No key does anything while a text field has the focus.

use egui::{Key, Modifiers, Ui};

use super::commands::Command;
use super::panels::PanelKind;
use super::view::AppView;
use crate::render::View;

/// What a key asks for.
pub enum Asked {
    Command(Command),
    ToggleHelp,
    SaveSession,
    Quit,
}

/// The page of the help window: headings with keys and what they do.
pub const PAGE: [(&str, &[(&str, &str)]); 3] = [
    (
        "In the viewport",
        &[
            ("left drag", "orbit around the target"),
            ("middle drag, Shift + left drag", "pan"),
            ("wheel", "move towards the target, or away"),
            ("W A S D, Q E", "fly; with Shift faster"),
            ("F", "frame the whole scene"),
            ("R", "back to the scene's own camera"),
        ],
    ),
    (
        "Everywhere",
        &[
            ("Space, P", "pause or go on rendering"),
            ("B", "boxes on or off"),
            ("T", "animate, or stop"),
            ("1 to 9, 0", "the views, in the order of the list"),
            ("C", "end a comparison of two views"),
        ],
    ),
    (
        "Files and windows",
        &[
            ("Ctrl + O", "open a model or a session"),
            ("Ctrl + S", "save the session"),
            ("Ctrl + E", "the Export panel"),
            ("F1", "this page"),
            ("Ctrl + Q", "quit"),
        ],
    ),
];

/// Views of the keys 1 to 9 and 0.
const NUMBER_KEYS: [Key; 10] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
    Key::Num0,
];

/// The key of a view, for menus.
pub fn key_of(view: View) -> Option<&'static str> {
    const NAMES: [&str; 10] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0"];
    View::ALL.iter().position(|v| *v == view).and_then(|i| NAMES.get(i).copied())
}

/// What the keys of this frame ask for.
pub fn read(ui: &Ui, view: &AppView) -> Vec<Asked> {
    if ui.ctx().text_edit_focused() {
        return Vec::new();
    }
    // A focused button takes the space bar for itself.
    let space_is_free = !ui.ctx().egui_wants_keyboard_input();
    let mut asked = Vec::new();
    ui.input_mut(|input| {
        let mut pressed = |modifiers, key| input.consume_key(modifiers, key);
        let (none, ctrl) = (Modifiers::NONE, Modifiers::COMMAND);
        if pressed(ctrl, Key::O) {
            asked.push(Asked::Command(Command::AskOpen));
        }
        if pressed(ctrl, Key::S) {
            asked.push(Asked::SaveSession);
        }
        if pressed(ctrl, Key::E) {
            asked.push(Asked::Command(Command::ShowPanel { panel: PanelKind::Export, shown: true }));
        }
        if pressed(ctrl, Key::Q) {
            asked.push(Asked::Quit);
        }
        if pressed(none, Key::F1) {
            asked.push(Asked::ToggleHelp);
        }
        if pressed(none, Key::P) || (space_is_free && pressed(none, Key::Space)) {
            asked.push(Asked::Command(Command::SetPaused(!view.render.paused)));
        }
        if pressed(none, Key::F) {
            asked.push(Asked::Command(Command::FrameScene));
        }
        if pressed(none, Key::R) {
            asked.push(Asked::Command(Command::ResetCamera));
        }
        if pressed(none, Key::B) {
            asked.push(Asked::Command(toggle_boxes()));
        }
        if pressed(none, Key::T) {
            asked.push(Asked::Command(Command::SetAnimating(!view.animating)));
        }
        if pressed(none, Key::C) && view.compare.is_some() {
            asked.push(Asked::Command(Command::SetCompareViews(None)));
        }
        for (key, wanted) in NUMBER_KEYS.into_iter().zip(View::ALL) {
            if pressed(none, key) {
                asked.push(Asked::Command(show_view(wanted)));
            }
        }
    });
    asked
}

/// Boxes on, as they were, or off.
pub fn toggle_boxes() -> Command {
    Command::Edit(Box::new(|session| {
        session.overlay.depths = match session.overlay.depths {
            Some(_) => None,
            None => Some(super::DEFAULT_BOXES),
        };
    }))
}

/// One view in the viewport.
pub fn show_view(view: View) -> Command {
    Command::Edit(Box::new(move |session| session.view = view))
}

/// The page, in a window of its own.
pub fn help_window(ui: &Ui, open: &mut bool) {
    let middle = ui.ctx().content_rect().center();
    egui::Window::new("Shortcuts")
        .open(open)
        .default_pos(middle - egui::vec2(230.0, 270.0))
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            egui::Grid::new("shortcuts").num_columns(2).spacing([28.0, 5.0]).show(ui, |ui| {
                for (heading, lines) in PAGE {
                    ui.strong(heading);
                    ui.end_row();
                    for (keys, what) in lines {
                        ui.monospace(*keys);
                        ui.label(*what);
                        ui.end_row();
                    }
                    ui.end_row();
                }
            });
        });
}
