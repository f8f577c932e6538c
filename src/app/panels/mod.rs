//! The panels, one file each. A panel owns only its own view state: it reads an [`AppView`] and pushes commands.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::commands::{Commands, SaveTarget};
use super::view::AppView;

/// Every panel around the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PanelKind {
    Scene,
    Build,
    Boxes,
    Heatmap,
    Cost,
    Shadows,
    Table,
    Export,
}

impl PanelKind {
    pub const ALL: [Self; 8] = [
        Self::Scene,
        Self::Build,
        Self::Boxes,
        Self::Heatmap,
        Self::Cost,
        Self::Shadows,
        Self::Table,
        Self::Export,
    ];

    pub fn title(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Build => "Build",
            Self::Boxes => "Boxes",
            Self::Heatmap => "Heatmap",
            Self::Cost => "Cost",
            Self::Shadows => "Shadows",
            Self::Table => "Table",
            Self::Export => "Export",
        }
    }
}

/// The view state of all panels.
#[derive(Default)]
pub struct Panels {}

impl Panels {
    /// Draws one panel.
    pub fn ui(&mut self, kind: PanelKind, ui: &mut egui::Ui, view: &AppView, commands: &mut Commands) {
        let _ = (kind, ui, view, commands);
        todo!()
    }

    /// Takes the answer to [`Command::AskSavePath`](super::commands::Command::AskSavePath).
    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        let _ = (target, path);
        todo!()
    }
}
