//! Cameras to go back to, kept with the session; and cameras as text that people pass on.

use serde::{Deserialize, Serialize};

use super::file::{MAX_NAME, is_name};
use super::flags::find;
use super::{Session, values};
use crate::scene::Camera;

/// A camera with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    pub name: String,
    pub camera: Camera,
}

impl Bookmark {
    /// Most of a session.
    pub const MOST: usize = 100;

    /// A name as users type it, made one that a session can keep; `None` if nothing is left of it.
    pub fn tidy(name: &str) -> Option<String> {
        let name: String = name.chars().filter(|c| !c.is_control()).collect();
        let name: String = name.trim().chars().take(MAX_NAME).collect();
        Some(name).filter(|name| is_name(name))
    }
}

/// Checks what a file says of bookmarks.
pub(super) fn check(session: &Session) -> Result<(), String> {
    let count = session.bookmarks.len();
    if count > Bookmark::MOST {
        return Err(format!("bookmarks are {count}; allowed are up to {}", Bookmark::MOST));
    }
    for Bookmark { name, camera } in &session.bookmarks {
        if !is_name(name) {
            return Err(format!(
                "bookmarks have a name {name:?}; allowed are 1 to {MAX_NAME} printable characters"
            ));
        }
        values::read_camera(&values::camera_text(*camera), camera.up)
            .map_err(|reason| format!("bookmark {name}: {reason}"))?;
    }
    Ok(())
}

impl Session {
    /// Keeps a camera under the first free of the names *Camera 1*, *Camera 2* ...; `None` where there are too many.
    pub fn add_bookmark(&mut self, camera: Camera) -> Option<&Bookmark> {
        if self.bookmarks.len() >= Bookmark::MOST {
            return None;
        }
        let is_free = |name: &String| self.bookmarks.iter().all(|kept| kept.name != *name);
        let name = (1..).map(|number| format!("Camera {number}")).find(is_free)?;
        self.bookmarks.push(Bookmark { name, camera });
        self.bookmarks.last()
    }

    /// Looks through the camera of a bookmark. The axis that points up stays the session's.
    pub fn go_to_bookmark(&mut self, index: usize) {
        if let Some(bookmark) = self.bookmarks.get(index) {
            self.camera = Some(Camera { up: self.up, ..bookmark.camera });
        }
    }
}

/// A camera as the text of `--camera`.
pub fn camera_text(camera: Camera) -> String {
    values::camera_text(camera)
}

/// Sets the camera from a text that somebody passed on: the value of `--camera`, with or without the flag and quotes.
///
/// # Errors
/// One sentence with what is wrong; the session is then as before.
pub fn read_camera_text(session: &mut Session, text: &str) -> Result<(), String> {
    const SHOWN: usize = 40;
    let bare = text.trim();
    let bare = bare.strip_prefix("--camera").map_or(bare, |rest| rest.trim_start_matches(['=', ' ']));
    let bare = bare.trim_matches(['"', '\'']);
    let flag = find("camera").expect("a flag of the table");
    flag.read(session, bare).map_err(|_| {
        let mut shown: String = bare.chars().map(|c| if c.is_control() { ' ' } else { c }).take(SHOWN).collect();
        if bare.chars().count() > SHOWN {
            shown.push('…');
        }
        format!(
            "'{shown}' is no camera. A camera is the text of --camera: ex,ey,ez,tx,ty,tz,fov (eye, target, vertical field \
             of view in degrees), or scene"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::UpAxis;
    use crate::session::file;

    #[test]
    fn a_camera_goes_through_text_and_back() {
        let mut camera = Camera::default();
        camera.orbit(0.3, 0.2);
        for dressed in [
            camera_text(camera),
            format!("  --camera \"{}\"\n", camera_text(camera)),
            format!("--camera={}", camera_text(camera)),
        ] {
            let mut session = Session::default();
            read_camera_text(&mut session, &dressed).expect(&dressed);
            assert_eq!(session.camera, Some(camera));
        }
    }

    #[test]
    fn a_text_that_is_no_camera_is_named_in_short_and_changes_nothing() {
        for text in ["", "hello", "1,2,3", "1,2,3,1,2,3,45", "0,0,5,0,0,0,400", &"x\n".repeat(5000)] {
            let mut session = Session::default();
            let message = read_camera_text(&mut session, text).expect_err(text);
            assert!(
                message.contains("is no camera") && message.len() < 250 && !message.contains('\n'),
                "{message}"
            );
            assert_eq!(session, Session::default());
        }
    }

    #[test]
    fn bookmarks_get_free_names_keep_the_up_axis_and_go_through_a_file() {
        let mut session = Session { up: UpAxis::Z, ..Session::default() };
        for _ in 0..3 {
            session.add_bookmark(Camera::default()).expect("room");
        }
        session.bookmarks.remove(1);
        assert_eq!(session.add_bookmark(Camera::default()).map(|b| b.name.as_str()), Some("Camera 2"));
        session.go_to_bookmark(0);
        session.go_to_bookmark(77);
        assert_eq!(session.camera.map(|camera| camera.up), Some(UpAxis::Z));
        let read = file::from_text(&file::to_text(&session, None), None).expect("a session");
        assert_eq!(read.bookmarks, session.bookmarks);
        session.bookmarks = vec![session.bookmarks[0].clone(); Bookmark::MOST];
        assert!(session.add_bookmark(Camera::default()).is_none());
    }

    #[test]
    fn a_file_with_a_bad_bookmark_is_refused_by_its_name() {
        let bookmark = |name: &str, fov: f32| {
            format!(
                "(version: 1, bookmarks: [(name: \"{name}\", camera: (eye: (0, 0, 1), target: (0, 0, 0), \
                 fov_y_degrees: {fov:?}, up: y))])"
            )
        };
        assert!(file::from_text(&bookmark("a", 45.0), None).is_ok());
        for (text, expected) in
            [(bookmark("", 45.0), "printable"), (bookmark("b", 200.0), "bookmark b: field of view")]
        {
            let message = file::from_text(&text, None).expect_err("a bad bookmark").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn names_are_tidied() {
        assert_eq!(Bookmark::tidy("  left\near \u{7}").as_deref(), Some("leftear"));
        assert_eq!(Bookmark::tidy(" \n "), None);
    }
}
