//! Files written whole or not at all: into a temporary file of the same folder, which then takes the file's name.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use super::ExportError;

/// What a writer of whole files can do; some formats go back to fill in a table.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// Writes bytes to a file, whole or not at all. A name that stands for a device or a pipe is written to directly.
///
/// # Errors
/// [`ExportError::Write`]; what lay there before is then untouched.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    if is_stream(path) {
        let written = OpenOptions::new().write(true).open(path).and_then(|mut file| file.write_all(bytes));
        return written.map_err(|error| refusal(path, &error));
    }
    write_with(path, |file| file.write_all(bytes).map_err(|error| refusal(path, &error)))
}

/// Lets `write` fill a file, whole or not at all.
///
/// # Errors
/// [`ExportError::Write`], or what `write` answers; what lay there before is then untouched.
pub fn write_with(
    path: &Path,
    write: impl FnOnce(&mut dyn WriteSeek) -> Result<(), ExportError>,
) -> Result<(), ExportError> {
    if is_stream(path) {
        // A stream cannot be sought: the file is made in memory first.
        let mut bytes = io::Cursor::new(Vec::new());
        write(&mut bytes)?;
        return write_bytes(path, bytes.get_ref());
    }
    let mut file = Unfinished::create(path)?;
    write(&mut file.writer)?;
    file.finish()
}

/// Whether a file can be written there, asked before long work: makes and removes an empty file beside it.
///
/// # Errors
/// [`ExportError::Write`] that says what is in the way.
pub fn check_writable(path: &Path) -> Result<(), ExportError> {
    if is_stream(path) {
        return Ok(());
    }
    Unfinished::create(path).map(drop)
}

/// A device or a pipe, as `/dev/stdout`: it is written to, never replaced.
fn is_stream(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// A temporary file that vanishes unless it is finished.
struct Unfinished {
    /// Where the file goes in the end, links followed.
    target: PathBuf,
    temporary: PathBuf,
    writer: BufWriter<File>,
    finished: bool,
}

impl Unfinished {
    fn create(path: &Path) -> Result<Self, ExportError> {
        let fail = |reason: &str| ExportError::Write { path: path.to_owned(), reason: reason.to_owned() };
        if path.is_dir() {
            return Err(fail("this is a folder; name a file in it"));
        }
        let Some(name) = path.file_name() else { return Err(fail("this is not the name of a file")) };
        // Through a link: the file it points to is replaced, not the link.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let folder = target.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            let reason = format!("there is no folder {}; make it first", folder.display());
            return Err(fail(&reason));
        }
        if fs::metadata(&target).is_ok_and(|found| found.permissions().readonly()) {
            return Err(fail("the file is write-protected"));
        }
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{number}.part", std::process::id()));
        let temporary = folder.join(hidden);
        let file = OpenOptions::new().write(true).create_new(true).open(&temporary);
        let file = file.map_err(|error| refusal(path, &error))?;
        Ok(Self { target, temporary, writer: BufWriter::new(file), finished: false })
    }

    fn finish(mut self) -> Result<(), ExportError> {
        let done = self.writer.flush().and_then(|()| fs::rename(&self.temporary, &self.target));
        done.map_err(|error| refusal(&self.target, &error))?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if !self.finished {
            // Nothing can be done about a failure here, and the error that led here is the one to show.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// The operating system's refusal in plain words, with what to do.
pub(super) fn refusal(path: &Path, error: &io::Error) -> ExportError {
    let reason = match error.kind() {
        ErrorKind::PermissionDenied => "permission denied; choose a folder that you may write to".to_owned(),
        ErrorKind::StorageFull => "the disk is full".to_owned(),
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only; choose another folder".to_owned(),
        ErrorKind::NotFound => "there is no such folder; make it first".to_owned(),
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
        ErrorKind::InvalidFilename => "the file name is too long or not allowed here".to_owned(),
        _ => error.to_string(),
    };
    ExportError::Write { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_there_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_bytes(&path, b"one").expect("written");
        write_bytes(&path, b"two").expect("written over");
        assert_eq!(fs::read(&path).expect("a file"), b"two");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failure_half_way_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_bytes(&path, b"before").expect("written");
        let failed = write_with(&path, |file| {
            file.write_all(b"half").expect("room");
            Err(ExportError::Encode { reason: "a test".to_owned() })
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).expect("a file"), b"before");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn the_check_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        check_writable(&folder.path().join("a.png")).expect("writable");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn what_cannot_be_written_says_why() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, b"x").expect("written");
        let cases = [
            (folder.path().to_owned(), "this is a folder"),
            (folder.path().join("missing/a.png"), "there is no folder"),
            (file.join("a.png"), "there is no folder"),
        ];
        for (path, expected) in cases {
            let message = check_writable(&path).expect_err(expected).to_string();
            assert!(message.starts_with("cannot write ") && message.contains(expected), "{message}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_a_device_stays_a_device() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").expect("written");
        std::os::unix::fs::symlink(&file, &link).expect("linked");
        write_bytes(&link, b"new").expect("written");
        assert!(fs::symlink_metadata(&link).expect("a link").is_symlink());
        assert_eq!(fs::read(&file).expect("a file"), b"new");
        write_with(Path::new("/dev/null"), |out| out.write_all(b"x").map_err(|_| unreachable!()))
            .expect("swallowed");
        assert!(is_stream(Path::new("/dev/null")));
    }
}
