//! What panels ask for. Applied in order after the panels are drawn.

use std::path::PathBuf;

use crate::accel::validate::At;
use crate::export::animation::Frames;
use crate::export::picture::Extras;
use crate::export::tree_file;
use crate::inspect::region::Region;
use crate::scene::SceneRef;
use crate::session::Session;

pub use super::asked::Asked;
use super::inspection::RayView;
use super::jobs::sweep::SweepPlan;
use super::panels::PanelKind;
use super::player::PlayerView;
use super::selection::{Go, Pick};
use super::splitting::SplitView;
use super::view::{CompareViews, TreeView};

/// One request. Nothing is lost: every command of a frame is applied, in order.
pub enum Command {
    /// Changes settings; the stages below what changed run again.
    Edit(Box<dyn FnOnce(&mut Session) + Send>),
    /// A slider of the Build panel is held (`true`) or let go: while it is held the heatmap's range stays.
    HoldRange(bool),
    OpenScene(SceneRef),
    /// A session or a PNG that carries one.
    OpenSession(PathBuf),
    SaveSession(PathBuf),
    /// Shows the system's file dialog for a scene or a session to open, off the window's thread.
    AskOpen,
    /// A tree from another program.
    ImportTree(PathBuf),
    /// Shows the system's file dialog for one, off the window's thread.
    AskImport,
    /// Goes back from the tree of a file to the one that is built.
    BuildOwnTree,
    /// Shows a node, a leaf or a shape in the viewport.
    Mark(Option<Mark>),
    /// Frames the camera to what is marked.
    FrameMarked,
    /// Selects a node; `add`: beside what is selected.
    Select {
        pick: Pick,
        add: bool,
    },
    ClearSelection,
    /// Looks at the numbers of a part of the picture.
    SetRegion(Option<Region>),
    /// Selects what a pixel of the picture shows, and looks at its rays.
    GoToPixel([u32; 2]),
    /// Hides shapes, or shows them again.
    Hide(Hide),
    /// Goes from what is selected to its parent, or through what was selected before.
    GoSelection(Go),
    /// Frames the camera to what is selected; to the whole scene if nothing is.
    FrameSelection,
    /// How the Tree panel looks at the tree.
    SetTreeView(TreeView),
    /// Which rays are looked at, and how.
    SetRayView(RayView),
    /// How the splits of the selected node are looked at.
    SetSplitView(SplitView),
    /// Which step of the tree's construction is shown.
    SetPlayerView(PlayerView),
    /// Moves the camera so that the chosen ray is seen from the side.
    LookAtRay,
    /// To another ray in the order of the outline.
    StepRay {
        forward: bool,
    },
    /// Shows the system's file dialog for a file to write, off the window's thread. The answer goes to
    /// [`Panels::path_chosen`](super::panels::Panels::path_chosen); nothing is written yet.
    AskSavePath {
        target: SaveTarget,
        suggested: PathBuf,
    },
    /// Asks for a path in the same way, and saves the session there.
    AskSaveSession {
        suggested: PathBuf,
    },
    SetAnimating(bool),
    CancelLoad,
    CancelBuild,
    /// Frames the camera to the scene / goes back to the scene's own camera.
    FrameScene,
    ResetCamera,
    SetPaused(bool),
    /// Measures the five trees anew; stops doing so.
    MeasureTable,
    CancelTable,
    /// Measures the points of a plan; holds the sweep or lets it go on; forgets it.
    StartSweep(Box<SweepPlan>),
    SetSweepPaused(bool),
    ClearSweep,
    /// Sets view, camera and scene so that the false shadow on the glossy floor is seen.
    ShadowPreset,
    /// Shows two pictures at once in the viewport; `None` goes back to the session's one.
    SetCompareViews(Option<CompareViews>),
    /// Makes another state of the session the one that is edited; opens its scene if that is another one.
    ActivateVariant(usize),
    /// Times frames with the trees of both sides, with nothing else running.
    TimeComparison,
    Export(ExportRequest),
    CancelExport,
    CopyText {
        text: String,
        what: &'static str,
    },
    /// Shows a message in the window.
    Report {
        message: String,
        error: bool,
    },
    /// Dark or light.
    SetDark(bool),
    ResetLayout,
    /// Brings a panel to the front, or hides it.
    ShowPanel {
        panel: PanelKind,
        shown: bool,
    },
    /// What has to do with the window as a whole.
    Ask(Asked),
}

/// Which shapes are hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hide {
    /// Those below the selected nodes, too.
    Selected,
    /// All others.
    Others,
    /// None.
    Nothing,
}

/// What can be marked in the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// By the index in the tree's file.
    Item(At),
    Shape(u32),
}

/// What a path to write to was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SaveTarget {
    Picture,
    Window,
    Raw,
    Figures,
    Sweep,
    Session,
    Tree,
    Boxes,
    Plot,
    Animation,
    Report,
}

impl SaveTarget {
    pub const ALL: [Self; 11] = [
        Self::Picture,
        Self::Window,
        Self::Raw,
        Self::Figures,
        Self::Sweep,
        Self::Session,
        Self::Tree,
        Self::Boxes,
        Self::Plot,
        Self::Animation,
        Self::Report,
    ];

    /// What the file is, as in a dialog's title.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Window => "window",
            Self::Raw => "raw film",
            Self::Figures => "figures",
            Self::Sweep => "points of the sweep",
            Self::Session => "session",
            Self::Tree => "tree",
            Self::Boxes => "boxes",
            Self::Plot => "plot",
            Self::Animation => "animation",
            Self::Report => "report",
        }
    }

    /// The extensions that the file may have, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Picture | Self::Window => &["png"],
            Self::Raw => &["exr", "csv"],
            Self::Figures => &["json", "csv"],
            Self::Sweep => &["csv", "json"],
            Self::Session => &["ron"],
            Self::Tree => &tree_file::EXTENSIONS,
            Self::Boxes => &["obj"],
            Self::Plot => &["svg", "png", "csv"],
            Self::Animation => &["png", "gif"],
            Self::Report => &["html"],
        }
    }
}

/// A file to write.
#[derive(Clone, Debug, PartialEq)]
pub enum ExportRequest {
    /// The viewport, rendered at this size with this many samples.
    Picture { path: PathBuf, width: u32, height: u32, samples: u32, overlay: bool, legend: bool },
    /// Pictures in a row, rendered at this size with this many samples: `.png` (animated, or a file a frame where the name
    /// has a `#`) or `.gif`.
    Animation { path: PathBuf, size: [u32; 2], samples: u32, extras: Extras, frames: Frames },
    /// The whole window as it is.
    Window { path: PathBuf },
    /// The raw numbers or linear colours of the viewport's film: `.exr` or `.csv`.
    Raw { path: PathBuf },
    /// The figures of the current tree: `.json` or `.csv`.
    Figures { path: PathBuf },
    /// Pictures, figures, plots and settings as one page: `.html`.
    Report { path: PathBuf, size: [u32; 2], samples: u32 },
    /// The points of the sweep: `.csv` or `.json`.
    Sweep { path: PathBuf },
    /// The plot that was chosen last: `.png`, `.svg` or `.csv`.
    Plot { path: PathBuf },
    /// The boxes of the selected nodes, perhaps with all below: `.obj`.
    Boxes { path: PathBuf, below: bool },
    /// The tree that is traced, for other programs: `.npz` or `.json`.
    Tree { path: PathBuf },
}

/// The commands of one frame.
#[derive(Default)]
pub struct Commands {
    queue: Vec<Command>,
}

impl Commands {
    pub fn push(&mut self, command: Command) {
        self.queue.push(command);
    }

    /// Changes the session.
    pub fn edit(&mut self, change: impl FnOnce(&mut Session) + Send + 'static) {
        self.push(Command::Edit(Box::new(change)));
    }

    /// Takes all commands, oldest first.
    pub fn take(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.queue)
    }
}
