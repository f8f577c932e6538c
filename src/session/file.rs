//! The text form (RON) of a session, and what a reader does with one from elsewhere.
//!
//! A field that is missing has its default, and one that this program does not know is passed over, so that files of
//! versions side by side open. A file of a later [`Session::VERSION`], whose fields may mean something else, is refused.
//! Every value is checked by the ranges of its flag.

use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::flags::{FlagError, flags};
use super::{MAX_VARIANTS, Session, SessionScene, Variant, bookmark};
use crate::scene::load::TreeFormat;
use crate::scene::{SceneRef, builtin};

/// Longest name of a variant or a bookmark, in characters.
pub(super) const MAX_NAME: usize = 100;
/// The flag `--time` allows as much.
const MAX_TIME: f32 = 1e6;

#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    #[error("this is not a session: {reason}")]
    Syntax { reason: String },
    #[error(
        "this session is of version {version}; this program reads up to {}. Use a newer bvhscope",
        Session::VERSION
    )]
    TooNew { version: u32 },
    #[error("this session's {what}")]
    Value { what: String },
}

fn wrong(what: impl Into<String>) -> SessionError {
    SessionError::Value { what: what.into() }
}

/// The text of a session; a scene's path is written relative to `folder` where it lies below it, and absolute where it
/// does not. Without a folder it is written as it is.
pub fn to_text(session: &Session, folder: Option<&Path>) -> String {
    let mut session = session.clone();
    session.version = Session::VERSION;
    for path in paths(&mut session) {
        if let Some(folder) = folder {
            *path = path_from(folder, path);
        }
        // RON is text: a path that is none is written as well as can be.
        *path = PathBuf::from(path.to_string_lossy().into_owned());
    }
    let pretty = ron::ser::PrettyConfig::new().new_line("\n").compact_arrays(true);
    let body = ron::ser::to_string_pretty(&session, pretty).expect("every session can be written as text");
    format!("// A session of bvhscope. Open it: bvhscope FILE\n{body}\n")
}

/// Reads what [`to_text`] wrote; every value is checked. Relative scene paths are taken from `folder`.
///
/// # Errors
/// [`SessionError`]
pub fn from_text(text: &str, folder: Option<&Path>) -> Result<Session, SessionError> {
    /// What every version has in common.
    #[derive(Deserialize)]
    struct Version {
        version: u32,
    }
    let syntax = |error: ron::error::SpannedError| SessionError::Syntax { reason: format!("line {error}") };
    let Version { version } = ron::from_str(text).map_err(syntax)?;
    if version > Session::VERSION {
        return Err(SessionError::TooNew { version });
    }
    if version == 0 {
        return Err(wrong("version is 0; the first is 1"));
    }
    let mut session: Session = ron::from_str(text).map_err(syntax)?;
    session.version = Session::VERSION;
    if let Some(camera) = &mut session.camera {
        camera.up = session.up;
    }
    check(&session)?;
    // A scene or a moment of the active state's own is the session's.
    session = session.activated(session.active);
    if let Some(folder) = folder {
        paths(&mut session).for_each(|path| *path = folder.join(&*path));
    }
    Ok(session)
}

/// The files that a session names: those of its scenes, and of its trees.
fn paths(session: &mut Session) -> impl Iterator<Item = &mut PathBuf> {
    fn of_scene(scene: &mut SessionScene) -> Option<&mut PathBuf> {
        match &mut scene.reference {
            SceneRef::File(path) => Some(path),
            SceneRef::Builtin(_) => None,
        }
    }
    let of_variants = session.variants.iter_mut().flat_map(move |variant| {
        let scene = variant.scene.as_mut().and_then(of_scene);
        scene.into_iter().chain(variant.tree.as_mut().map(|tree| &mut tree.path))
    });
    of_scene(&mut session.scene).into_iter().chain(of_variants)
}

/// Checks every value of a session: ranges, numbers that are none, an active variant that is not there.
///
/// # Errors
/// [`SessionError::Value`], which says what is allowed.
pub fn check(session: &Session) -> Result<(), SessionError> {
    check_scene(&session.scene)?;
    check_variants(session)?;
    bookmark::check(session).map_err(wrong)?;
    let mut scratch = Session::default();
    for flag in flags() {
        if let Err(FlagError::Value { flag, value, reason }) = flag.read(&mut scratch, &flag.write(session)) {
            return Err(wrong(format!("{flag} is '{value}': {reason}")));
        }
    }
    Ok(())
}

fn check_scene(scene: &SessionScene) -> Result<(), SessionError> {
    match &scene.reference {
        SceneRef::Builtin(name) if !builtin::is_name(name) => {
            return Err(wrong(format!("scene '{name}' is none of the built-in ones")));
        }
        SceneRef::File(path) if path.as_os_str().is_empty() => {
            return Err(wrong("scene is a file without a name"));
        }
        SceneRef::Builtin(_) | SceneRef::File(_) => {}
    }
    check_hash(&scene.content_hash)
}

/// Whether something in a session can be called so.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().count() <= MAX_NAME && !name.chars().any(char::is_control)
}

fn check_hash(hash: &str) -> Result<(), SessionError> {
    let is_hash = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
    if hash.is_empty() || is_hash {
        return Ok(());
    }
    Err(wrong("content_hash is not the 64 hexadecimal digits of a SHA-256"))
}

fn check_variants(session: &Session) -> Result<(), SessionError> {
    let count = session.variants.len();
    if !(1..=MAX_VARIANTS).contains(&count) {
        return Err(wrong(format!("variants are {count}; allowed are 1 to {MAX_VARIANTS}")));
    }
    if session.active >= count {
        return Err(wrong(format!("active is {}, but its variants are 0 to {}", session.active, count - 1)));
    }
    for Variant { name, build, tree, scene, time } in &session.variants {
        if !is_name(name) {
            return Err(wrong(format!(
                "variants have a name {name:?}; allowed are 1 to {MAX_NAME} printable characters"
            )));
        }
        build.check().map_err(|error| wrong(format!("variant {name}: {error}")))?;
        scene.as_ref().map_or(Ok(()), check_scene)?;
        if let Some(time) = time.filter(|time| !(-MAX_TIME..=MAX_TIME).contains(time)) {
            return Err(wrong(format!(
                "variant {name} has the time {time}: allowed is a number from -{MAX_TIME} to {MAX_TIME}"
            )));
        }
        let Some(tree) = tree else { continue };
        if TreeFormat::of(&tree.path).is_none() {
            return Err(wrong(format!(
                "variant {name} has the tree '{}', no .npz or .json",
                tree.path.display()
            )));
        }
        check_hash(&tree.content_hash)?;
    }
    Ok(())
}

/// `path` as seen from `folder`, with forward slashes, if it lies below it; else as an absolute path.
fn path_from(folder: &Path, path: &Path) -> PathBuf {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(folder), Ok(path)) = (std::path::absolute(here), std::path::absolute(path)) else {
        return path.to_path_buf();
    };
    let Ok(below) = path.strip_prefix(&folder) else { return path };
    let parts: Vec<_> = below
        .components()
        .filter(|part| *part != Component::CurDir)
        .map(|part| part.as_os_str().to_string_lossy())
        .collect();
    PathBuf::from(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Camera;

    fn message(text: &str) -> String {
        from_text(text, None).expect_err(text).to_string()
    }

    #[test]
    fn the_default_comes_back() {
        let session = Session::default();
        assert_eq!(from_text(&to_text(&session, None), None).expect("a session"), session);
    }

    #[test]
    fn a_file_of_little_has_defaults_for_the_rest_and_unknown_fields_are_passed_over() {
        let text = r#"(version: 1, time: 2.5, later: Some((a: [1, 2], b: Other("x"))), view: whitted)"#;
        let session = from_text(text, None).expect("a session");
        let mut expected = Session { time: 2.5, ..Session::default() };
        expected.view = crate::render::View::Whitted;
        assert_eq!(session, expected);
    }

    #[test]
    fn a_newer_version_is_refused_before_its_fields_are_read() {
        assert_eq!(
            message("(version: 7, view: r#not-known-yet)"),
            "this session is of version 7; this program reads up to 1. Use a newer bvhscope"
        );
        assert!(message("(version: 0)").contains("version is 0"));
    }

    #[test]
    fn what_is_no_session_says_where_it_goes_wrong() {
        for text in ["", "hello", "\0\u{1}garbage", "(version: 1, view: )", "{}", "(view: path)"] {
            let message = message(text);
            assert!(message.starts_with("this is not a session: line "), "{text:?}: {message}");
        }
        assert!(message(&"(".repeat(100_000)).starts_with("this is not a session"));
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let cases = [
            ("active: 1", "active is 1, but its variants are 0 to 0"),
            ("variants: []", "variants are 0; allowed are 1 to 64"),
            (r#"variants: [(name: "A", build: (bins: 1))]"#, "variant A: bins 1 is outside 2 to 256"),
            (r#"variants: [(name: "", build: ())]"#, "printable"),
            ("time: NaN", "time is 'NaN'"),
            ("render: (width: 0)", "size is '0x720': allowed is WIDTHxHEIGHT"),
            ("render: (spp: Some(0))", "spp is '0'"),
            ("display: (range: Some((3.0, 2.0)))", "range is '3..2'"),
            ("display: (exposure: inf)", "exposure is 'inf'"),
            ("overlay: (depths: Some((5, 2)))", "boxes is '5..2'"),
            (r#"scene: (reference: builtin("nowhere"))"#, "scene 'nowhere' is none of the built-in ones"),
            (r#"scene: (reference: file(""))"#, "file without a name"),
            (r#"scene: (content_hash: "abc")"#, "64 hexadecimal digits"),
            (
                r#"variants: [(name: "A", build: (), tree: Some((path: "a.obj")))]"#,
                "variant A has the tree 'a.obj', no .npz or .json",
            ),
            (
                r#"variants: [(name: "A", build: (), scene: Some((reference: builtin("nowhere"))))]"#,
                "scene 'nowhere' is none of the built-in ones",
            ),
            (r#"variants: [(name: "A", build: (), time: Some(NaN))]"#, "variant A has the time NaN"),
            (
                r#"variants: [(name: "A", build: (), tree: Some((path: "a.npz", content_hash: "x")))]"#,
                "64 hexadecimal digits",
            ),
            (
                "camera: Some((eye: (0, 0, 0), target: (0, 0, 0), fov_y_degrees: 45, up: y))",
                "eye and target must be two points",
            ),
        ];
        for (fields, expected) in cases {
            let message = message(&format!("(version: 1, {fields})"));
            assert!(message.starts_with("this session's "), "{fields}: {message}");
            assert!(message.contains(expected), "{fields}: {message}");
        }
    }

    #[test]
    fn a_scene_below_the_folder_is_written_relative_and_read_from_where_the_file_lies() {
        let mut session = Session::default();
        session.scene.reference = SceneRef::File(PathBuf::from("/work/models/teapot.obj"));
        let text = to_text(&session, Some(Path::new("/work")));
        assert!(text.contains(r#"file("models/teapot.obj")"#), "{text}");
        session.set_tree(Some(PathBuf::from("/work/trees/t.npz")));
        let text = to_text(&session, Some(Path::new("/work")));
        assert!(text.contains(r#"path: "trees/t.npz""#), "{text}");
        let moved = from_text(&text, Some(Path::new("/elsewhere"))).expect("a session");
        assert_eq!(moved.tree().map(|tree| &*tree.path), Some(Path::new("/elsewhere/trees/t.npz")));
        assert_eq!(moved.scene.reference, SceneRef::File(PathBuf::from("/elsewhere/models/teapot.obj")));
        let outside = to_text(&session, Some(Path::new("/home")));
        assert!(outside.contains(r#"file("/work/models/teapot.obj")"#), "{outside}");
    }

    #[test]
    fn a_state_may_have_a_scene_and_a_moment_of_its_own() {
        let text = r#"(version: 1, time: 1.0, active: 1, variants: [
            (name: "A", build: (), scene: Some((reference: file("m/a.obj"))), time: Some(2.5)),
            (name: "B", build: (), time: Some(3.0)),
            (name: "C", build: ())])"#;
        let session = from_text(text, Some(Path::new("/work"))).expect("a session");
        assert_eq!(session.scene_of(0).reference, SceneRef::File(PathBuf::from("/work/m/a.obj")));
        let times: Vec<f32> = (0..3).map(|i| session.time_of(i)).collect();
        assert_eq!(times, [2.5, 3.0, 1.0]);
        assert_eq!((session.time, session.variants[1].time), (3.0, None), "the active one is the session's");
        let written = to_text(&session, Some(Path::new("/work")));
        assert!(written.contains(r#"file("m/a.obj")"#), "{written}");
        assert_eq!(from_text(&written, Some(Path::new("/work"))).expect("a session"), session);
    }

    #[test]
    fn a_camera_has_the_session_s_up_axis() {
        let text = "(version: 1, up: z, camera: Some((eye: (1, 2, 3), target: (0, 0, 0), fov_y_degrees: 45, up: y)))";
        let session = from_text(text, None).expect("a session");
        assert_eq!(session.camera.map(|camera: Camera| camera.up), Some(session.up));
    }
}
