//! Session files, written and opened: RON, or a PNG that carries one.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;

use image::RgbaImage;

use super::{ExportError, atomic, png};
use crate::session::{Session, file};

/// Extensions of files that hold a session.
pub const EXTENSIONS: [&str; 2] = ["ron", "png"];
/// Larger files are no sessions.
const MAX_BYTES: u64 = 16 << 20;

/// Whether a file of that name is opened as a session rather than as a model.
pub fn is_session_path(path: &Path) -> bool {
    extension(path).is_some_and(|found| EXTENSIONS.contains(&found.as_str()))
}

/// Opens a session from its RON file, or from a PNG that carries one.
///
/// # Errors
/// [`ExportError`] that names the file and says what is wrong with it.
pub fn open(path: &Path) -> Result<Session, ExportError> {
    let fail = |reason: String| ExportError::Read { path: path.to_owned(), reason };
    let opened = File::open(path).and_then(|opened| {
        let is_folder = opened.metadata()?.is_dir();
        if is_folder { Err(ErrorKind::IsADirectory.into()) } else { Ok(opened) }
    });
    let opened = opened.map_err(|error| match error.kind() {
        ErrorKind::NotFound => fail("there is no such file".to_owned()),
        ErrorKind::IsADirectory => fail("this is a folder".to_owned()),
        _ => fail(error.to_string()),
    })?;
    let text = if extension(path).is_some_and(|e| e == "png") {
        let carried = png::session_text(BufReader::new(opened)).map_err(fail)?;
        carried.ok_or_else(|| ExportError::NoSession { path: path.to_owned() })?
    } else {
        read_text(opened).map_err(fail)?
    };
    file::from_text(&text, path.parent())
        .map_err(|reason| ExportError::Session { path: path.to_owned(), reason })
}

/// Writes a session as RON; its scene is named relative to the file where it lies below the file's folder.
///
/// # Errors
/// [`ExportError::Write`]
pub fn save(session: &Session, path: &Path) -> Result<(), ExportError> {
    atomic::write_bytes(path, file::to_text(session, path.parent()).as_bytes())
}

/// Writes a picture that carries the session it shows.
///
/// # Errors
/// [`ExportError`]
pub fn save_picture(picture: &RgbaImage, session: &Session, path: &Path) -> Result<(), ExportError> {
    let bytes = png::encode(picture, Some(&file::to_text(session, path.parent())))?;
    atomic::write_bytes(path, &bytes)
}

fn read_text(opened: File) -> Result<String, String> {
    let mut bytes = Vec::new();
    opened.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err("it is too large for a session".to_owned());
    }
    String::from_utf8(bytes).map_err(|_| "it is not text (UTF-8), so no session".to_owned())
}

fn extension(path: &Path) -> Option<String> {
    path.extension().map(|found| found.to_string_lossy().to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_comes_back_from_both_kinds_of_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut session = Session { time: 1.25, ..Session::default() };
        session.build_mut().bins = 77;
        let (ron, picture) = (folder.path().join("a.ron"), folder.path().join("a.PNG"));
        save(&session, &ron).expect("saved");
        save_picture(&RgbaImage::new(2, 2), &session, &picture).expect("saved");
        assert_eq!(open(&ron).expect("opened"), session);
        assert_eq!(open(&picture).expect("opened"), session);
    }

    #[test]
    fn what_is_no_session_is_refused_with_the_file_s_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let cases: [(&str, &[u8], &str); 6] = [
            ("empty.ron", b"", "this is not a session"),
            ("binary.ron", &[0xff, 0xfe, 0], "not text"),
            ("garbage.png", b"hello", "cannot read"),
            ("version.ron", b"(version: 99)", "is of version 99"),
            ("value.ron", b"(version: 1, active: 4)", "active is 4"),
            ("plain.png", &png::encode(&RgbaImage::new(1, 1), None).expect("encoded"), "carries no session"),
        ];
        for (name, bytes, expected) in cases {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            let message = open(&path).expect_err(name).to_string();
            assert!(message.contains(expected) && message.contains(name), "{name}: {message}");
        }
        let missing = open(&folder.path().join("none.ron")).expect_err("missing").to_string();
        assert!(missing.ends_with("there is no such file"), "{missing}");
        assert!(open(folder.path()).expect_err("a folder").to_string().ends_with("this is a folder"));
    }
}
