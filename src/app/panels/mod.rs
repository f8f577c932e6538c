//! The panels, one file each. A panel owns only its own view state: it reads an [`AppView`] and pushes commands.

mod boxes;
mod build;
mod chart;
mod cost;
mod export;
mod glossary;
mod heatmap;
mod history;
mod numbers;
mod prediction;
mod range_bars;
mod scene;
mod shadows;
mod sweep;
mod table;
mod tree_file;
mod widgets;

use std::path::PathBuf;

use egui::{Frame, Margin, ScrollArea, Ui};
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
    Sweep,
    TreeFile,
    Export,
}

impl PanelKind {
    pub const ALL: [Self; 10] = [
        Self::Scene,
        Self::Build,
        Self::Boxes,
        Self::Heatmap,
        Self::Cost,
        Self::Shadows,
        Self::Table,
        Self::Sweep,
        Self::TreeFile,
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
            Self::Sweep => "Sweep",
            Self::TreeFile => "Tree file",
            Self::Export => "Export",
        }
    }
}

/// The view state of all panels.
#[derive(Default)]
pub struct Panels {
    scene: scene::ScenePanel,
    build: build::BuildPanel,
    boxes: boxes::BoxesPanel,
    heatmap: heatmap::HeatmapPanel,
    cost: cost::CostPanel,
    shadows: shadows::ShadowsPanel,
    table: table::TablePanel,
    sweep: sweep::SweepPanel,
    tree_file: tree_file::TreeFilePanel,
    export: export::ExportPanel,
}

impl Panels {
    /// Draws one panel into all of `ui`, with margins, scrolled where it does not fit.
    pub fn ui(&mut self, kind: PanelKind, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        ScrollArea::vertical().id_salt(kind.title()).auto_shrink(false).show(ui, |ui| {
            Frame::NONE.inner_margin(Margin { left: 10, right: 12, top: 8, bottom: 12 }).show(ui, |ui| {
                ui.set_width(ui.available_width());
                widgets::set_spacing(ui);
                match kind {
                    PanelKind::Scene => self.scene.ui(ui, view, commands),
                    PanelKind::Build => self.build.ui(ui, view, commands),
                    PanelKind::Boxes => self.boxes.ui(ui, view, commands),
                    PanelKind::Heatmap => self.heatmap.ui(ui, view, commands),
                    PanelKind::Cost => self.cost.ui(ui, view, commands),
                    PanelKind::Shadows => self.shadows.ui(ui, view, commands),
                    PanelKind::Table => self.table.ui(ui, view, commands),
                    PanelKind::Sweep => self.sweep.ui(ui, view, commands),
                    PanelKind::TreeFile => self.tree_file.ui(ui, view, commands),
                    PanelKind::Export => self.export.ui(ui, view, commands),
                }
            });
        });
    }

    /// Takes the answer to [`Command::AskSavePath`](super::commands::Command::AskSavePath).
    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        self.export.path_chosen(target, path);
    }
}
