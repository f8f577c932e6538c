//! One value that says everything that is shown. The command line parses one, the window edits one, a file and a
//! screenshot carry one.

pub mod bookmark;
pub mod file;
mod flag_table;
pub mod flags;
pub mod prepare;
pub mod ray_text;
mod values;
mod variants;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::accel::BuildConfig;
use crate::render::film::FilmSubject;
use crate::render::{CountKind, DisplaySettings, OverlaySettings, RenderSettings, View};
use crate::scene::{Camera, SceneRef, ShadowRule, UpAxis};

pub use bookmark::Bookmark;
pub use variants::{MAX_VARIANTS, Variant};

/// Scene, builds, camera, view, render and overlay settings. A picture is a function of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Session {
    /// [`Session::VERSION`] of the program that wrote it.
    pub version: u32,
    pub scene: SessionScene,
    /// The moment, in seconds; 0 is the still scene.
    pub time: f32,
    /// A ground under the scene, outside every tree and figure.
    pub ground: bool,
    pub up: UpAxis,
    /// `None`: the camera that the scene came with.
    pub camera: Option<Camera>,
    /// Build settings side by side; never empty.
    pub variants: Vec<Variant>,
    /// Index into `variants`, in range.
    pub active: usize,
    pub view: View,
    pub count: CountKind,
    pub shadow_rule: ShadowRule,
    pub render: RenderSettings,
    pub display: DisplaySettings,
    pub overlay: OverlaySettings,
    /// Cameras to go back to.
    pub bookmarks: Vec<Bookmark>,
}

/// Which scene, and how to tell that it is still the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SessionScene {
    /// In a file: relative to the file.
    pub reference: SceneRef,
    /// SHA-256 of a model's file; empty for built-in scenes and while nothing is loaded.
    pub content_hash: String,
    pub shape_count: Option<usize>,
}

/// The file of a tree from another program, and how to tell that it is still the same.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TreeRef {
    /// In a session's file: relative to it.
    pub path: PathBuf,
    /// SHA-256 of the tree's file; empty while nothing is loaded.
    #[serde(default)]
    pub content_hash: String,
}

impl Default for Session {
    fn default() -> Self {
        Self {
            version: Self::VERSION,
            scene: SessionScene::default(),
            time: 0.0,
            ground: false,
            up: UpAxis::default(),
            camera: None,
            variants: vec![Variant::default()],
            active: 0,
            view: View::default(),
            count: CountKind::default(),
            shadow_rule: ShadowRule::default(),
            render: RenderSettings::default(),
            display: DisplaySettings::default(),
            overlay: OverlaySettings::default(),
            bookmarks: Vec::new(),
        }
    }
}

impl Session {
    /// The version of the form that this program writes.
    pub const VERSION: u32 = 1;

    /// The active build settings.
    pub fn build(&self) -> &BuildConfig {
        &self.variants[self.active].build
    }

    pub fn build_mut(&mut self) -> &mut BuildConfig {
        &mut self.variants[self.active].build
    }

    /// The file whose tree is shown instead of one that is built.
    pub fn tree(&self) -> Option<&TreeRef> {
        self.variants[self.active].tree.as_ref()
    }

    /// Shows the tree of a file, or (`None`) one that is built.
    pub fn set_tree(&mut self, path: Option<PathBuf>) {
        if self.tree().map(|tree| &tree.path) != path.as_ref() {
            let tree = path.map(|path| TreeRef { path, content_hash: String::new() });
            self.variants[self.active].tree = tree;
        }
    }

    /// What a film shows under this session.
    pub fn film_subject(&self) -> FilmSubject {
        FilmSubject { view: self.view, count: self.count, shadow_rule: self.shadow_rule }
    }
}
