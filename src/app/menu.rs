//! The menu bar.

use std::path::PathBuf;

use egui::{Button, MenuBar, Ui};

use super::commands::{Command, Commands};
use super::layout::{Layout, Pane};
use super::panels::PanelKind;
use super::shortcuts::{key_of, show_view};
use super::view::AppView;
use crate::render::{View, ViewClass};
use crate::scene::SceneRef;
use crate::scene::builtin::SCENES;

/// Draws the bar. `help` is the page of shortcuts.
pub fn ui(ui: &mut Ui, view: &AppView, layout: &Layout, help: &mut bool, commands: &mut Commands) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(ui, view, commands));
        ui.menu_button("View", |ui| views(ui, view, layout, commands));
        ui.menu_button("Help", |ui| {
            if ui.add(Button::new("Shortcuts").shortcut_text("F1")).clicked() {
                *help = true;
            }
            ui.separator();
            ui.weak(concat!("bvhscope ", env!("CARGO_PKG_VERSION")));
        });
    });
}

/// Asks where the session is to be saved.
pub fn ask_save_session(view: &AppView) -> Command {
    let name = crate::app::jobs::load::short_name(&view.session.scene.reference);
    let stem = name.split(['.', ':']).next().unwrap_or("session");
    Command::AskSaveSession { suggested: PathBuf::from(format!("{stem}.ron")) }
}

fn file(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    if ui
        .add(Button::new("Open…").shortcut_text("Ctrl+O"))
        .on_hover_text("A model (OBJ, PLY, STL, glTF), a session, or a PNG that carries one")
        .clicked()
    {
        commands.push(Command::AskOpen);
    }
    if ui
        .button("Import tree…")
        .on_hover_text("A tree that another program built (NPZ, JSON): checked, shown, measured and compared")
        .clicked()
    {
        commands.push(Command::AskImport);
    }
    ui.menu_button("Open built-in scene", |ui| {
        for (name, about) in SCENES {
            if ui.button(name).on_hover_text(about).clicked() {
                commands.push(Command::OpenScene(SceneRef::Builtin(name.to_owned())));
            }
        }
    });
    ui.add_enabled_ui(!view.recent.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for scene in view.recent {
                let name = crate::app::jobs::load::short_name(scene);
                if ui.button(name).on_hover_text(scene.text()).clicked() {
                    commands.push(Command::OpenScene(scene.clone()));
                }
            }
        });
    });
    ui.separator();
    if ui
        .add(Button::new("Save session…").shortcut_text("Ctrl+S"))
        .on_hover_text("Scene, tree, camera, view and all settings, as a small text file")
        .clicked()
    {
        commands.push(ask_save_session(view));
    }
    if ui
        .add(Button::new("Export…").shortcut_text("Ctrl+E"))
        .on_hover_text("Pictures, raw numbers and figures as files")
        .clicked()
    {
        commands.push(Command::ShowPanel { panel: PanelKind::Export, shown: true });
    }
    ui.separator();
    if ui.add(Button::new("Quit").shortcut_text("Ctrl+Q")).clicked() {
        ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
    }
}

fn views(ui: &mut Ui, view: &AppView, layout: &Layout, commands: &mut Commands) {
    ui.menu_button("Picture", |ui| {
        for choice in View::ALL {
            let mut button = Button::selectable(view.session.view == choice, title(choice));
            if let Some(key) = key_of(choice) {
                button = button.shortcut_text(key);
            }
            if ui.add(button).on_hover_text(choice.description()).clicked() {
                commands.push(show_view(choice));
            }
        }
    });
    if ui.add(Button::new("Frame scene").shortcut_text("F")).clicked() {
        commands.push(Command::FrameScene);
    }
    if ui.add(Button::new("Reset camera").shortcut_text("R")).clicked() {
        commands.push(Command::ResetCamera);
    }
    ui.separator();
    for kind in PanelKind::ALL {
        let mut shown = layout.is_open(kind);
        if ui.checkbox(&mut shown, kind.title()).on_hover_text(Pane::Panel(kind).about()).clicked() {
            commands.push(Command::ShowPanel { panel: kind, shown });
        }
    }
    ui.separator();
    for (dark, label) in [(true, "Dark"), (false, "Light")] {
        if ui.radio(view.palette.dark == dark, label).clicked() {
            commands.push(Command::SetDark(dark));
        }
    }
    ui.separator();
    if ui
        .button("Reset layout")
        .on_hover_text("All panels back to where they were at the first start")
        .clicked()
    {
        commands.push(Command::ResetLayout);
    }
}

/// A view's name for people.
pub fn title(view: View) -> String {
    let name = view.name().replace('-', " ");
    match view.class() {
        ViewClass::Heat => format!("{name} (heatmap)"),
        ViewClass::Radiance | ViewClass::Data | ViewClass::Distance | ViewClass::Class => name,
    }
}
