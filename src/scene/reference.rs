//! How a scene is named: a built-in name, or a file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A built-in scene by its name (with its parameter, as in `soup:1000000`), or a file.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SceneRef {
    Builtin(String),
    File(PathBuf),
}

impl Default for SceneRef {
    fn default() -> Self {
        Self::Builtin("bunny".to_owned())
    }
}

impl SceneRef {
    /// A built-in name if `text` is one, else a path.
    pub fn parse(text: &str) -> Self {
        if super::builtin::is_name(text) {
            Self::Builtin(text.to_owned())
        } else {
            Self::File(PathBuf::from(text))
        }
    }

    /// What [`SceneRef::parse`] reads back.
    pub fn text(&self) -> String {
        match self {
            Self::Builtin(name) => name.clone(),
            Self::File(path) => path.display().to_string(),
        }
    }
}
