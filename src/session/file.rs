//! The text form (RON) of a session, and what a reader does with one from elsewhere.

use std::path::Path;

use super::Session;

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

/// The text of a session; a scene's path is written relative to `folder` where it lies below it.
pub fn to_text(session: &Session, folder: Option<&Path>) -> String {
    let _ = (session, folder);
    todo!()
}

/// Reads what [`to_text`] wrote; every value is checked. Relative scene paths are taken from `folder`.
///
/// # Errors
/// [`SessionError`]
pub fn from_text(text: &str, folder: Option<&Path>) -> Result<Session, SessionError> {
    let _ = (text, folder);
    todo!()
}
