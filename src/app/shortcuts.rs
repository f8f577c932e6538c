//! The keys of the actions, and the page that lists them. No key does anything while a text field has the focus.

use egui::{Event, Key, KeyboardShortcut, ScrollArea, Ui};

use super::actions::{Action, Around, Group, Info};

/// What the mouse does in the viewport, and the keys that are held there.
const IN_THE_VIEWPORT: [(&str, &str); 6] = [
    ("click, Ctrl + click", "select the leaf under the mouse; add it"),
    ("left drag", "orbit around the target"),
    ("middle drag, Shift + left drag", "pan"),
    ("Shift + left drag in a heatmap", "mark a part of it; Shift + click ends that"),
    ("wheel", "move towards the target, or away"),
    ("W A S D, Q E", "fly; with Shift faster"),
];

/// What the keys of this frame ask for.
pub fn read(ui: &Ui, around: &Around) -> Vec<Action> {
    if ui.ctx().text_edit_focused() {
        return Vec::new();
    }
    let any = ui.input(|i| i.events.iter().any(|event| matches!(event, Event::Key { pressed: true, .. })));
    if !any {
        return Vec::new();
    }
    // A focused button takes the space bar for itself.
    let space_is_free = !ui.ctx().egui_wants_keyboard_input();
    let mut keys: Vec<(KeyboardShortcut, Action, bool)> = Vec::new();
    for action in Action::all(around) {
        let Info { keys: own, obstacle, .. } = action.info(around);
        keys.extend(own.into_iter().map(|key| (key, action, obstacle.is_none())));
    }
    // egui lets a key with more modifiers than were asked for pass: ask for most of them first.
    keys.sort_by_key(|(key, ..)| {
        let held = key.modifiers;
        std::cmp::Reverse([held.command, held.shift, held.alt].into_iter().filter(|held| *held).count())
    });
    let mut asked = Vec::new();
    ui.input_mut(|input| {
        for (key, action, enabled) in keys {
            let is_free = key.logical_key != Key::Space || space_is_free;
            if is_free && input.consume_shortcut(&key) && enabled {
                asked.push(action);
            }
        }
    });
    asked
}

/// The page, in a window of its own.
pub fn page(ui: &Ui, around: &Around, open: &mut bool) {
    let room = ui.ctx().content_rect();
    egui::Window::new("Shortcuts")
        .open(open)
        .pivot(egui::Align2::CENTER_CENTER)
        .default_pos(room.center())
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            // A low window scrolls.
            ScrollArea::vertical().max_height(room.height() - 90.0).show(ui, |ui| {
                ui.horizontal_top(|ui| halves(ui, around));
            });
            ui.weak("Ctrl + P finds every action by its name, also those without a key.");
        });
}

/// All keys, in two columns of about the same height.
fn halves(ui: &mut Ui, around: &Around) {
    let halves: [&[Group]; 2] = [
        &[Group::File, Group::Edit, Group::Window, Group::Tree, Group::Learn, Group::Rays],
        &[Group::Camera, Group::Select, Group::Picture],
    ];
    for (half, groups) in halves.into_iter().enumerate() {
        let grid = egui::Grid::new(("shortcuts", half)).num_columns(2);
        grid.min_row_height(16.0).spacing([20.0, 3.0]).show(ui, |ui| {
            if half == 1 {
                let mouse = IN_THE_VIEWPORT.map(|(key, what)| (key.into(), what.into()));
                section(ui, "In the viewport", mouse.to_vec());
            }
            for group in groups {
                section(ui, group.name(), lines(ui, around, *group));
            }
        });
        ui.add_space(18.0);
    }
}

fn section(ui: &mut Ui, heading: &str, lines: Vec<(String, String)>) {
    if lines.is_empty() {
        return;
    }
    ui.strong(heading);
    ui.end_row();
    for (keys, what) in lines {
        ui.monospace(keys);
        ui.label(what);
        ui.end_row();
    }
    ui.end_row();
}

/// Keys with what they do. A family whose keys stand in a row takes one line.
fn lines(ui: &Ui, around: &Around, group: Group) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    for action in Action::PLAIN {
        let info = action.info(around);
        if info.group == group && !info.keys.is_empty() {
            // What would be undone is of no interest here.
            let name = match action {
                Action::Undo => "Undo".into(),
                Action::Redo => "Redo".into(),
                Action::Shortcuts => "this page".into(),
                _ => info.name.trim_end_matches('…').to_owned(),
            };
            lines.push((info.keys_text(ui), name));
        }
    }
    match group {
        Group::Picture => {
            lines.push(("1 to 9, 0".to_owned(), "the views, in the order of the list".to_owned()))
        }
        Group::Camera => lines.push(("Ctrl+1 to Ctrl+9".to_owned(), "the bookmarks".to_owned())),
        Group::File
        | Group::Edit
        | Group::Select
        | Group::Rays
        | Group::Tree
        | Group::Learn
        | Group::Window => {}
    }
    lines
}
