//! The menu bar, made from the list of actions.

use std::path::PathBuf;

use egui::{Button, MenuBar, Ui};

use super::actions::{Action, Around};
use super::commands::{Command, Commands};
use super::panels::PanelKind;
use super::tours::TOURS;
use super::view::AppView;
use crate::render::View;
use crate::scene::builtin::SCENES;

/// Draws the bar.
pub fn ui(ui: &mut Ui, around: &Around, commands: &mut Commands) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(ui, around, commands));
        ui.menu_button("Edit", |ui| {
            items(ui, around, commands, [Action::Undo, Action::Redo]);
            ui.separator();
            items(ui, around, commands, [Action::CopyCamera, Action::PasteCamera]);
        });
        ui.menu_button("View", |ui| views(ui, around, commands));
        ui.menu_button("Learn", |ui| {
            for index in 0..TOURS.len() {
                items(ui, around, commands, [Action::TakeTour(index)]);
            }
            ui.separator();
            items(
                ui,
                around,
                commands,
                [Action::TourOn, Action::TourBack, Action::LeaveTour, Action::EndTour],
            );
        });
        ui.menu_button("Help", |ui| {
            items(ui, around, commands, [Action::Palette, Action::Shortcuts]);
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

fn file(ui: &mut Ui, around: &Around, commands: &mut Commands) {
    items(ui, around, commands, [Action::Open, Action::ImportTree]);
    ui.menu_button("Open built-in scene", |ui| {
        for (index, (name, _)) in SCENES.iter().enumerate() {
            item_called(ui, around, commands, Action::OpenBuiltin(index), name);
        }
    });
    ui.add_enabled_ui(!around.view.recent.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for (index, scene) in around.view.recent.iter().enumerate() {
                let name = crate::app::jobs::load::short_name(scene);
                item_called(ui, around, commands, Action::OpenRecent(index), &name);
            }
        });
    });
    ui.separator();
    items(ui, around, commands, [Action::SaveSession, Action::Export]);
    let info = Action::ReopenAtStart.info(around);
    let mut reopens = around.reopens;
    if ui.checkbox(&mut reopens, info.name.as_ref()).on_hover_text(info.about).clicked() {
        commands.push(Action::ReopenAtStart.command(around));
    }
    ui.separator();
    items(ui, around, commands, [Action::Quit]);
}

fn views(ui: &mut Ui, around: &Around, commands: &mut Commands) {
    ui.menu_button("Picture", |ui| {
        for view in View::ALL {
            item_called(ui, around, commands, Action::ShowView(view), &super::actions::title(view));
        }
    });
    items(ui, around, commands, [Action::FrameScene, Action::ResetCamera]);
    ui.menu_button("Bookmarks", |ui| {
        items(ui, around, commands, [Action::AddBookmark]);
        let bookmarks = &around.view.session.bookmarks;
        if !bookmarks.is_empty() {
            ui.separator();
        }
        for (index, bookmark) in bookmarks.iter().enumerate() {
            item_called(ui, around, commands, Action::GoToBookmark(index), &bookmark.name);
        }
    });
    ui.separator();
    for kind in PanelKind::ALL {
        let info = Action::ShowPanel(kind).info(around);
        let mut shown = around.layout.is_open(kind);
        if ui.checkbox(&mut shown, kind.title()).on_hover_text(info.about).clicked() {
            commands.push(Command::ShowPanel { panel: kind, shown });
        }
    }
    ui.separator();
    for look in [Action::Dark, Action::Light] {
        let info = look.info(around);
        if ui.radio(info.on == Some(true), info.name.as_ref()).on_hover_text(info.about).clicked() {
            commands.push(look.command(around));
        }
    }
    ui.separator();
    items(ui, around, commands, [Action::ResetLayout]);
}

fn items<const N: usize>(ui: &mut Ui, around: &Around, commands: &mut Commands, actions: [Action; N]) {
    for action in actions {
        let name = action.info(around).name;
        item_called(ui, around, commands, action, &name);
    }
}

/// An action under a name that its menu makes clear.
fn item_called(ui: &mut Ui, around: &Around, commands: &mut Commands, action: Action, name: &str) {
    let info = action.info(around);
    let mut button = match info.on {
        Some(on) => Button::selectable(on, name),
        None => Button::new(name),
    };
    let key = info.key_text(ui);
    if !key.is_empty() {
        button = button.shortcut_text(key);
    }
    let response = ui.add_enabled(info.obstacle.is_none(), button).on_hover_text(info.about);
    let response = match info.obstacle {
        Some(obstacle) => response.on_disabled_hover_text(obstacle),
        None => response,
    };
    if response.clicked() {
        commands.push(action.command(around));
    }
}
