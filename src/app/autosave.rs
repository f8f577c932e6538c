//! The session of this run, kept for the next start: written beside the window's own settings when something has changed,
//! and when the window closes.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::jobs::newest::Patience;
use super::jobs::{Context, Job, PoolKind};
use super::state::State;
use crate::export::session_file;
use crate::session::Session;

/// Least time between two writes.
const EVERY: Duration = Duration::from_secs(8);

/// Name of the file, in the folder of the window's settings.
const FILE: &str = "last-session.ron";

#[derive(Clone)]
struct Work {
    session: Session,
    path: PathBuf,
}

/// Keeps the session. Does nothing without a path.
pub struct Autosave {
    path: Option<PathBuf>,
    job: Job<Work, Result<(), String>>,
    /// What was handed over last, and when.
    kept: Option<Session>,
    last: Option<Instant>,
    failed: bool,
}

impl Autosave {
    pub fn new(path: Option<PathBuf>) -> Self {
        let job = Job::new(Patience::Within(Duration::MAX), PoolKind::Background, |run| {
            let Work { session, path } = run.request;
            run.emit(write(session, path));
        });
        Self { path, job, kept: None, last: None, failed: false }
    }

    /// Writes if it is time; when to look again.
    pub fn update(&mut self, context: &Context, state: &mut State, now: Instant) -> Option<Duration> {
        for result in self.job.poll(context) {
            if let Err(message) = result
                && !std::mem::replace(&mut self.failed, true)
            {
                state.messages.error(format!("The session cannot be kept for the next start: {message}"));
            }
        }
        let path = self.path.as_ref()?;
        // What could not be opened is not kept.
        if state.document.is_none() || self.kept.as_ref() == Some(state.session_to_keep()) {
            return None;
        }
        let waited = self.last.map_or(EVERY, |last| now.saturating_duration_since(last));
        if waited < EVERY {
            return Some(EVERY - waited);
        }
        let session = state.session_to_keep().clone();
        (self.kept, self.last) = (Some(session.clone()), Some(now));
        self.job.request(context, Work { session, path: path.clone() });
        None
    }

    /// Writes at once, when the window closes.
    pub fn finish(&mut self, state: &State) {
        let Some(path) = &self.path else { return };
        if state.document.is_some()
            && let Err(message) = write(state.session_to_keep(), path)
        {
            eprintln!("bvhscope: the session cannot be kept for the next start: {message}");
        }
    }

    pub fn is_idle(&self) -> bool {
        self.job.is_idle()
    }
}

/// Where the session is kept; `None` where the system has no place for settings.
pub fn path() -> Option<PathBuf> {
    eframe::storage_dir("bvhscope").map(|folder| folder.join(FILE))
}

/// The session that was kept, with flags of the command line over it; `None` if there is none.
///
/// # Errors
/// One sentence that says why it cannot be used, and what is shown instead.
pub fn read(path: &Path, flags: &[(&'static str, String)]) -> Result<Option<Session>, String> {
    if !path.exists() {
        return Ok(None);
    }
    let mut session = session_file::open(path)
        .map_err(|error| format!("The session of last time cannot be opened again: {error}"))?;
    for (name, text) in flags {
        let flag = crate::session::flags::find(name).map_err(|error| error.to_string())?;
        flag.read(&mut session, text).map_err(|error| error.to_string())?;
    }
    Ok(Some(session))
}

fn write(session: &Session, path: &Path) -> Result<(), String> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    session_file::save(session, path).map_err(|error| error.to_string())
}
