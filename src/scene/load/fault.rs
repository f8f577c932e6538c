//! What the readers of single formats report: a fault without the path, which only [`super::load`] knows.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::Place;
use crate::task::{Cancelled, Task};

/// Why a file's content could not be read.
#[derive(Debug)]
pub(super) enum Fault {
    Cancelled,
    Content { place: Place, reason: String },
}

impl From<Cancelled> for Fault {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl Fault {
    /// A fault of the file as a whole.
    pub fn of_file(reason: impl Into<String>) -> Self {
        Self::Content { place: Place::File, reason: one_line(&reason.into()) }
    }

    pub fn at_line(line: usize, reason: impl Into<String>) -> Self {
        Self::Content { place: Place::Line(line), reason: one_line(&reason.into()) }
    }

    pub fn at_byte(byte: usize, reason: impl Into<String>) -> Self {
        Self::Content { place: Place::Byte(byte), reason: one_line(&reason.into()) }
    }
}

/// Runs a reader of another crate. Those promise nothing about damaged files, and some are known to panic on them, which
/// must not take the program down.
pub(super) fn guarded<T>(format: &str, read: impl FnOnce() -> T) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(read)).map_err(|_| {
        Fault::of_file(format!(
            "the {format} data is damaged in a way that its reader cannot tell; export it again"
        ))
    })
}

/// A text in one line, so that a message stays one.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The beginning of a piece of a file, fit for a message.
pub(super) fn excerpt(text: &str) -> String {
    const LENGTH: usize = 40;
    let text = one_line(text);
    let shown: String =
        text.chars().take(LENGTH).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().count() > LENGTH { format!("{shown}...") } else { shown }
}

/// `1 face`, `2 faces`: a count with its noun.
pub(super) fn counted(count: usize, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{count} vertices"),
        _ => format!("{count} {noun}s"),
    }
}

/// A reader over bytes that reports progress and fails once the task is cancelled, so that the readers of other crates can
/// be stopped. Wrap it in a `BufReader`.
pub(super) struct Watched<'a> {
    bytes: &'a [u8],
    task: &'a Task,
}

impl<'a> Watched<'a> {
    pub fn new(bytes: &'a [u8], task: &'a Task) -> Self {
        Self { bytes, task }
    }
}

impl std::io::Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.task.check().map_err(std::io::Error::other)?;
        let read = self.bytes.read(buffer)?;
        self.task.advance(read as u64);
        Ok(read)
    }
}
