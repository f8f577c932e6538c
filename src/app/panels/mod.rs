//! The panels, one file each. A panel owns only its own view state: it reads an [`AppView`] and pushes commands.

mod animation;
mod bookmarks;
mod boxes;
mod build;
mod chart;
mod compare;
mod construction;
mod cost;
mod export;
mod glossary;
mod heatmap;
mod history;
mod prediction;
mod range_bars;
mod rays;
mod scene;
mod shadows;
mod splits;
mod sweep;
mod table;
mod tree;
mod tree_file;
mod widgets;

use std::path::PathBuf;

use egui::{Frame, Margin, ScrollArea, Ui};
use serde::{Deserialize, Serialize};

use super::commands::{Commands, SaveTarget};
use super::view::AppView;
use crate::inspect::numbers;

/// Every panel around the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PanelKind {
    Scene,
    Build,
    Boxes,
    Heatmap,
    Cost,
    Compare,
    Shadows,
    Table,
    Sweep,
    TreeFile,
    Export,
    Tree,
    Rays,
    Splits,
    Construction,
}

impl PanelKind {
    pub const ALL: [Self; 15] = [
        Self::Scene,
        Self::Build,
        Self::Boxes,
        Self::Heatmap,
        Self::Cost,
        Self::Compare,
        Self::Shadows,
        Self::Table,
        Self::Sweep,
        Self::TreeFile,
        Self::Export,
        Self::Tree,
        Self::Rays,
        Self::Splits,
        Self::Construction,
    ];

    pub fn title(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Build => "Build",
            Self::Boxes => "Boxes",
            Self::Heatmap => "Heatmap",
            Self::Cost => "Cost",
            Self::Compare => "Compare",
            Self::Shadows => "Shadows",
            Self::Table => "Table",
            Self::Sweep => "Sweep",
            Self::TreeFile => "Tree file",
            Self::Export => "Export",
            Self::Tree => "Tree",
            Self::Rays => "Rays",
            Self::Splits => "Splits",
            Self::Construction => "Steps",
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
    compare: compare::ComparePanel,
    shadows: shadows::ShadowsPanel,
    table: table::TablePanel,
    sweep: sweep::SweepPanel,
    tree_file: tree_file::TreeFilePanel,
    export: export::ExportPanel,
    tree: tree::TreePanel,
    rays: rays::RaysPanel,
    splits: splits::SplitsPanel,
    construction: construction::ConstructionPanel,
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
                    PanelKind::Compare => self.compare.ui(ui, view, commands),
                    PanelKind::Shadows => self.shadows.ui(ui, view, commands),
                    PanelKind::Table => self.table.ui(ui, view, commands),
                    PanelKind::Sweep => self.sweep.ui(ui, view, commands),
                    PanelKind::TreeFile => self.tree_file.ui(ui, view, commands),
                    PanelKind::Export => self.export.ui(ui, view, commands),
                    PanelKind::Tree => self.tree.ui(ui, view, commands),
                    PanelKind::Rays => self.rays.ui(ui, view, commands),
                    PanelKind::Splits => self.splits.ui(ui, view, commands),
                    PanelKind::Construction => self.construction.ui(ui, view, commands),
                }
            });
        });
    }

    /// Takes the answer to [`Command::AskSavePath`](super::commands::Command::AskSavePath).
    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        self.export.path_chosen(target, path);
    }
}
