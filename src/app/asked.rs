//! What has to do with the window as a whole, and how it is done: undo, cameras as text, bookmarks, popups.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::apply::Target;
use super::commands::{Command, SaveTarget};
use super::panels::PanelKind;
use super::popups::Finder;
use super::tours;
use crate::export::plot::PlotFormat;
use crate::inspect::plot::Plot;
use crate::session::bookmark::{Bookmark, camera_text, read_camera_text};

/// One request.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    Undo,
    Redo,
    /// The camera as text, to the clipboard.
    CopyCamera,
    /// Asks the clipboard for a camera; its text comes later.
    PasteCamera,
    /// Looks through a camera that somebody passed on as text.
    UseCamera(String),
    AddBookmark,
    RenameBookmark {
        index: usize,
        name: String,
    },
    RemoveBookmark(usize),
    /// Shows the table and measures it anew.
    MeasureTable,
    /// Keeps a plot, and asks where to save it.
    SavePlot {
        plot: Box<Plot>,
        format: PlotFormat,
    },
    /// Whether the next start shows what is shown now.
    ReopenAtStart(bool),
    /// Begins a guided tour, goes through it, or ends it.
    Tour(tours::Go),
    /// Opens the command palette.
    Palette,
    /// Shows or hides the page of shortcuts.
    Shortcuts,
    Quit,
}

impl Target<'_> {
    pub(super) fn ask(&mut self, asked: Asked) {
        match asked {
            Asked::Undo => self.step(true),
            Asked::Redo => self.step(false),
            Asked::CopyCamera => {
                if let Some(camera) = self.state.camera() {
                    self.apply(Command::CopyText { text: camera_text(camera), what: "camera" });
                }
            }
            Asked::PasteCamera => {
                self.ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste);
                self.ctx.request_repaint();
                self.popups.wait_for_paste();
            }
            Asked::UseCamera(text) => self.use_camera(&text),
            Asked::AddBookmark => self.add_bookmark(),
            Asked::RenameBookmark { index, name } => {
                let Some(name) = Bookmark::tidy(&name) else { return };
                self.edit(Box::new(move |session| {
                    if let Some(bookmark) = session.bookmarks.get_mut(index) {
                        bookmark.name = name;
                    }
                }));
            }
            Asked::RemoveBookmark(index) => self.edit(Box::new(move |session| {
                if index < session.bookmarks.len() {
                    session.bookmarks.remove(index);
                }
            })),
            Asked::MeasureTable => {
                self.layout.show(PanelKind::Table, true);
                self.apply(Command::MeasureTable);
            }
            Asked::SavePlot { plot, format } => self.save_plot(*plot, format),
            Asked::ReopenAtStart(reopen) => self.state.reopen_at_start = reopen,
            Asked::Tour(go) => self.tour(go),
            Asked::Palette => self.popups.finder = Some(Finder::default()),
            Asked::Shortcuts => self.popups.shortcuts = !self.popups.shortcuts,
            Asked::Quit => self.ctx.send_viewport_cmd(egui::ViewportCommand::Close),
        }
    }

    /// The path comes from the system's dialog, or from the Export panel.
    fn save_plot(&mut self, plot: Plot, format: PlotFormat) {
        let suggested = PathBuf::from(format!("{}.{}", file_stem(&plot), format.extension()));
        self.panels.path_chosen(SaveTarget::Plot, suggested.clone());
        self.state.plot = Some(Arc::new(plot));
        self.apply(Command::AskSavePath { target: SaveTarget::Plot, suggested });
    }

    /// Goes one step back in the history of settings, or forward.
    fn step(&mut self, back: bool) {
        // What other commands of this frame changed is a step, too.
        self.undo.observe(self.state, Instant::now());
        let camera = self.state.camera();
        let (word, done) = if back {
            ("Undone", self.undo.undo(self.state))
        } else {
            ("Done again", self.undo.redo(self.state))
        };
        let Some(what) = done else { return };
        if self.state.camera() != camera {
            self.state.camera_moved = Some(Instant::now());
        }
        self.changed();
        self.state.messages.say(format!("{word}: {what}"));
    }

    fn use_camera(&mut self, text: &str) {
        let mut session = self.state.session.clone();
        match read_camera_text(&mut session, text) {
            Ok(()) => self.edit(Box::new(move |now| now.camera = session.camera)),
            Err(message) => self.state.messages.error(message),
        }
    }

    fn add_bookmark(&mut self) {
        let Some(camera) = self.state.camera() else { return };
        if self.state.session.bookmarks.len() >= Bookmark::MOST {
            let message = format!("There are {} bookmarks already: remove one first.", Bookmark::MOST);
            self.state.messages.error(message);
            return;
        }
        self.edit(Box::new(move |session| {
            session.add_bookmark(camera);
        }));
        if let Some(bookmark) = self.state.session.bookmarks.last() {
            self.state.messages.say(format!("Bookmark added: {}", bookmark.name));
        }
    }
}

/// A file's name that says what a plot shows.
fn file_stem(plot: &Plot) -> String {
    let scene = plot.subject.split(':').next().unwrap_or_default();
    let words = format!("{scene} {}", plot.title).to_lowercase();
    let words: Vec<&str> = words.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
    words.join("-")
}
