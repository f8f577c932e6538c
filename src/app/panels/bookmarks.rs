//! The camera as text that can be passed on, and the cameras that the session keeps.

use egui::{Align, Button, FontId, Key, Layout, TextEdit, Ui, vec2};

use crate::app::commands::{Asked, Command, Commands};
use crate::app::view::AppView;
use crate::session::bookmark::camera_text;
use crate::session::{Bookmark, prepare};

use super::glossary::Term;
use super::widgets;

/// View state of the section.
#[derive(Default)]
pub struct Bookmarks {
    /// What is being typed as a camera.
    text: Option<String>,
    /// The name that is being typed, with its bookmark's index.
    name: Option<(usize, String)>,
}

impl Bookmarks {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "Camera");
        let Some(scene) = view.scene else {
            widgets::caption(ui, view.palette, "Nothing is open yet.");
            return;
        };
        self.text_field(ui, camera_text(prepare::camera(scene, view.session)), commands);
        ui.horizontal_wrapped(|ui| {
            let mut button = |name: &str, about: &str, command: Command| {
                if ui.button(name).on_hover_text(about).clicked() {
                    commands.push(command);
                }
            };
            button(
                "Copy",
                "The camera as text to the clipboard (Ctrl+Shift+C).",
                Command::Ask(Asked::CopyCamera),
            );
            button(
                "Paste",
                "Looks through a camera that was copied as text (Ctrl+Shift+V).",
                Command::Ask(Asked::PasteCamera),
            );
            button("Frame", "Moves the camera so that the whole scene is seen (F).", Command::FrameScene);
            button("Reset", "Goes back to the scene's own camera (R).", Command::ResetCamera);
        });
        widgets::term_section(ui, Term::Bookmarks);
        for (index, bookmark) in view.session.bookmarks.iter().enumerate() {
            self.row(ui, index, bookmark, commands);
        }
        let add = ui.button("Add bookmark").on_hover_text("Keeps this camera with the session (Ctrl+B).");
        if add.clicked() {
            commands.push(Command::Ask(Asked::AddBookmark));
        }
    }

    /// The camera that is looked through, as text that can be typed over.
    fn text_field(&mut self, ui: &mut Ui, now: String, commands: &mut Commands) {
        let mut text = self.text.clone().unwrap_or_else(|| now.clone());
        let edit =
            TextEdit::singleline(&mut text).font(FontId::monospace(11.0)).desired_width(ui.available_width());
        let field =
            ui.add(edit).accessible_name(Term::CameraText.label()).on_hover_text(Term::CameraText.text());
        if field.changed() {
            self.text = Some(text.clone());
        }
        if field.lost_focus() {
            if ui.input(|i| i.key_pressed(Key::Enter)) && text != now {
                commands.push(Command::Ask(Asked::UseCamera(text)));
            }
            self.text = None;
        }
    }

    /// A bookmark: its name to type over, and what can be done with it.
    fn row(&mut self, ui: &mut Ui, index: usize, bookmark: &Bookmark, commands: &mut Commands) {
        let size = vec2(ui.available_width(), widgets::ROW_HEIGHT);
        ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
            let named = |what: &str| format!("{what} {}", bookmark.name);
            let remove = ui.button("×").on_hover_text("Removes this bookmark.");
            if remove.accessible_name(named("Remove")).clicked() {
                commands.push(Command::Ask(Asked::RemoveBookmark(index)));
                self.name = None;
            }
            let key = if index < 9 { format!(" (Ctrl+{})", index + 1) } else { String::new() };
            let go = ui
                .add(Button::new("Go").min_size(vec2(34.0, 0.0)))
                .on_hover_text(format!("Looks through this camera{key}."));
            if go.accessible_name(named("Go to")).clicked() {
                commands.edit(move |session| session.go_to_bookmark(index));
            }
            let typed = self.name.as_ref().filter(|(typed, _)| *typed == index).map(|(_, name)| name.clone());
            let mut name = typed.unwrap_or_else(|| bookmark.name.clone());
            let edit = TextEdit::singleline(&mut name)
                .desired_width(ui.available_width())
                .align(egui::Align2::LEFT_CENTER);
            let field = ui.add(edit).accessible_name(named("Name of"));
            if field.changed() {
                self.name = Some((index, name.clone()));
            }
            if field.lost_focus() {
                if name != bookmark.name {
                    commands.push(Command::Ask(Asked::RenameBookmark { index, name }));
                }
                self.name = None;
            }
        });
    }
}
