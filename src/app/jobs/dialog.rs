//! The system's file dialogs, on a thread of their own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::Context;
use crate::app::commands::SaveTarget;

/// A dialog that is gone sooner was never there: nobody closes one that fast.
const NEVER_OPENED: Duration = Duration::from_millis(250);

/// Extensions that can be opened, the models first.
pub const MODEL_EXTENSIONS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];

/// What a dialog answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DialogAnswer {
    Open(PathBuf),
    Save(SaveTarget, PathBuf),
    SaveSession(PathBuf),
    /// The system showed none.
    Unavailable(Purpose),
}

/// What a dialog was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Open,
    Save,
}

/// At most one dialog at a time.
pub struct Dialogs {
    sender: Sender<Option<DialogAnswer>>,
    receiver: Receiver<Option<DialogAnswer>>,
    is_open: bool,
}

impl Default for Dialogs {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, is_open: false }
    }
}

impl Dialogs {
    /// Asks for a model or a session to open.
    pub fn ask_open(&mut self, context: &Context) {
        self.show(context, Purpose::Open, || {
            let mut all = MODEL_EXTENSIONS.to_vec();
            all.extend(crate::export::session_file::EXTENSIONS);
            all.extend(crate::export::tree_file::EXTENSIONS);
            let dialog = rfd::FileDialog::new()
                .set_title("Open a model or a session")
                .add_filter("Models, sessions and trees", &all)
                .add_filter("Models", &MODEL_EXTENSIONS)
                .add_filter("Sessions", &crate::export::session_file::EXTENSIONS)
                .add_filter("All files", &["*"]);
            dialog.pick_file().map(DialogAnswer::Open)
        });
    }

    /// Asks for a tree from another program.
    pub fn ask_import(&mut self, context: &Context) {
        self.show(context, Purpose::Open, || {
            let dialog = rfd::FileDialog::new()
                .set_title("Import a tree")
                .add_filter("Trees", &crate::export::tree_file::EXTENSIONS)
                .add_filter("All files", &["*"]);
            dialog.pick_file().map(DialogAnswer::Open)
        });
    }

    /// Asks where to write a file.
    pub fn ask_save(&mut self, context: &Context, target: SaveTarget, suggested: &Path) {
        let dialog = save_dialog(target, suggested);
        self.show(context, Purpose::Save, move || {
            dialog.save_file().map(|path| DialogAnswer::Save(target, path))
        });
    }

    /// Asks where to save the session.
    pub fn ask_save_session(&mut self, context: &Context, suggested: &Path) {
        let dialog = save_dialog(SaveTarget::Session, suggested);
        self.show(context, Purpose::Save, move || dialog.save_file().map(DialogAnswer::SaveSession));
    }

    /// The answers since the last call.
    pub fn poll(&mut self) -> Vec<DialogAnswer> {
        let mut answers = Vec::new();
        while let Ok(answer) = self.receiver.try_recv() {
            self.is_open = false;
            answers.extend(answer);
        }
        answers
    }

    fn show(
        &mut self,
        context: &Context,
        purpose: Purpose,
        ask: impl FnOnce() -> Option<DialogAnswer> + Send + 'static,
    ) {
        if self.is_open {
            return;
        }
        self.is_open = true;
        let (sender, context) = (self.sender.clone(), context.clone());
        std::thread::spawn(move || {
            let start = Instant::now();
            let mut answer = ask();
            if answer.is_none() && start.elapsed() < NEVER_OPENED {
                answer = Some(DialogAnswer::Unavailable(purpose));
            }
            // The window may be gone; then nobody wants the answer.
            let _ = sender.send(answer);
            context.wake();
        });
    }
}

fn save_dialog(target: SaveTarget, suggested: &Path) -> rfd::FileDialog {
    let mut dialog = rfd::FileDialog::new().set_title(format!("Save {}", target.name()));
    for extension in target.extensions() {
        dialog = dialog.add_filter(extension.to_uppercase(), &[extension]);
    }
    if let Some(name) = suggested.file_name() {
        dialog = dialog.set_file_name(name.to_string_lossy());
    }
    if let Some(folder) = suggested.parent().filter(|f| !f.as_os_str().is_empty()) {
        dialog = dialog.set_directory(folder);
    }
    dialog
}
