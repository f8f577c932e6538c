//! Where pictures and figures leave the program: PNG with its session, EXR, CSV, JSON, Markdown. Every file is written
//! whole or not at all.

pub mod animation;
pub mod atomic;
pub mod boxes;
pub mod comparison;
pub mod exr;
pub mod findings;
pub mod legend;
pub mod picture;
pub mod plot;
pub mod png;
pub mod points;
pub mod raw_csv;
pub mod ray_file;
pub mod report;
pub mod session_file;
pub mod table;
pub mod text;
pub mod tree_file;

use std::path::PathBuf;

/// Why a file could not be written or read. Every message says what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error("cannot write {path}: {reason}")]
    Write { path: PathBuf, reason: String },
    #[error("cannot read {path}: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path}: {reason}")]
    Session { path: PathBuf, reason: crate::session::file::SessionError },
    #[error("{path} carries no session; only PNG files that bvhscope wrote do")]
    NoSession { path: PathBuf },
    #[error("cannot encode the picture: {reason}")]
    Encode { reason: String },
}
