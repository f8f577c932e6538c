//! What panels read: one frame's state of the program, borrowed, never changed by a panel.

use std::sync::Arc;
use std::time::Duration;

use crate::accel::BuildConfig;
use crate::accel::exchange::Place;
use crate::accel::validate::At;
use crate::export::points::Question;
use crate::geometry::Aabb;
use crate::inspect::best::Best;
use crate::inspect::bin_sweep::BinPoint;
use crate::inspect::census::{Census, Visits, Weight};
use crate::inspect::histogram::Histogram;
use crate::inspect::overlaps::{OverlapMeasure, OverlappingPair};
use crate::inspect::plot::Plot;
use crate::inspect::prediction::Forecast;
use crate::inspect::shadow_difference::ClassCounts;
use crate::inspect::stats::TreeStats;
use crate::inspect::sweep::SweepPoint;
use crate::render::measure::RayFigures;
use crate::render::{Film, Overlay};
use crate::scene::{Camera, Scene, SceneRef};
use crate::session::{Session, TreeRef};
use crate::world::{NodeFigure, World};

use super::commands::Mark;
use super::inspection::Inspection;
use super::jobs::TreeKey;
use super::jobs::census::VisitsKey;
use super::jobs::region::RegionFigures;
use super::player::Player;
use super::selection::{Hidden, Selections};
use super::splitting::Splitting;
use super::theme::Palette;
use super::tours::Touring;

pub use super::ab::{AbState, CompareStyle, CompareViews, Side};

/// Everything a panel may look at while it draws.
pub struct AppView<'a> {
    pub session: &'a Session,
    pub palette: &'a Palette,
    /// The scene at the session's time; `None` until the first one is loaded.
    pub scene: Option<&'a Arc<Scene>>,
    /// What had to be repaired to load it.
    pub scene_warnings: &'a [String],
    /// The newest finished tree. May lag behind `session.build()` while a build runs.
    pub world: Option<&'a Arc<World>>,
    pub recent: &'a [SceneRef],
    pub animating: bool,
    /// Jobs that run now.
    pub loading: Option<JobStatus>,
    pub building: Option<JobStatus>,
    pub exporting: Option<JobStatus>,
    /// The plot that was chosen last to be saved.
    pub plot: Option<&'a Plot>,
    /// Newest last, at most 50.
    pub history: &'a [HistoryEntry],
    /// The raw content of the picture in the viewport.
    pub film: Option<&'a Film>,
    /// Of the film's numbers, over all of them (not only those in `range`); `None` on a film of colours.
    pub histogram: Option<&'a Histogram>,
    /// The range that the colour map covers now.
    pub range: Option<[f32; 2]>,
    /// Whether the range is held because a slider of the Build panel is being dragged.
    pub range_locked: bool,
    pub hover: Option<Hover>,
    /// A node, leaf or shape that stands out in the viewport.
    pub marked: Option<&'a Marked>,
    /// What is selected in the tree, and what was.
    pub selections: &'a Selections,
    /// Shapes that are not drawn.
    pub hidden: &'a Hidden,
    /// The numbers of a part of the picture, and its most expensive pixels; perhaps of an older picture.
    pub region: Option<&'a RegionFigures>,
    /// What is known of every node of the tree at hand; `None` until it was looked at.
    pub census: Option<&'a Arc<Census>>,
    /// How often the rays of the newest frame visited each node, which may be one that was seen before the camera moved.
    pub visits: Option<(&'a VisitsKey, &'a Visits)>,
    /// The pairs of siblings that overlap most, by the measure of `tree_view`.
    pub overlaps: Option<&'a [OverlappingPair]>,
    pub tree_view: &'a TreeView,
    /// The rays that are looked at.
    pub inspection: &'a Inspection,
    /// The split costs of the node that is selected.
    pub splitting: &'a Splitting,
    /// How the tree came about.
    pub player: &'a Player,
    /// The guided tour that is taken.
    pub touring: Option<&'a Touring>,
    /// Which tree `world` is.
    pub tree: Option<TreeKey>,
    /// That is looked through now.
    pub camera: Option<Camera>,
    pub overlay: Option<&'a Overlay>,
    /// Camera rays of the newest tree, counted.
    pub rays: Option<&'a RayFigures>,
    /// What is predicted of the tree, and what its rays pay; while the Cost panel is open.
    pub forecast: Option<&'a Forecast>,
    /// The same of all trees of this scene that are known, seen from where the camera stands.
    pub forecasts: &'a [Forecast],
    pub bin_curve: &'a BinCurve,
    pub table: &'a TableState,
    pub sweep: &'a SweepState,
    pub shadow: &'a ShadowState,
    /// Two pictures at once in the viewport; `None`: the session's one.
    pub compare: Option<CompareViews>,
    /// Of the two.
    pub ab: &'a AbState,
    pub render: RenderStatus,
}

/// How the Tree panel looks at the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeView {
    /// Of the icicle plot's widths.
    pub weight: Weight,
    /// Of the icicle plot's colours.
    pub figure: NodeFigure,
    pub order: SiblingKey,
    pub measure: OverlapMeasure,
}

impl Default for TreeView {
    fn default() -> Self {
        Self {
            weight: Weight::default(),
            figure: NodeFigure::Overlap,
            order: SiblingKey::default(),
            measure: OverlapMeasure::default(),
        }
    }
}

/// In which order siblings stand in the outline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SiblingKey {
    /// As they lie in their node.
    #[default]
    Slot,
    /// The heaviest first.
    Weight(Weight),
    /// Those with the largest value of the icicle plot's colours first.
    Figure,
}

impl SiblingKey {
    pub const ALL: [Self; 5] = [
        Self::Slot,
        Self::Weight(Weight::Shapes),
        Self::Weight(Weight::SahCost),
        Self::Weight(Weight::Visits),
        Self::Figure,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Slot => "slot",
            Self::Weight(weight) => weight.name(),
            Self::Figure => "colour",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::Slot => "as the children lie in their node",
            Self::Weight(Weight::Shapes) => "the child with the most references below it first",
            Self::Weight(Weight::SahCost) => {
                "the child with the largest SAH cost first, all below it included"
            }
            Self::Weight(Weight::Visits) => "the child that rays visit most first, all below it included",
            Self::Figure => "the child with the largest value of what the plot's colours say first",
        }
    }
}

/// A running job.
#[derive(Clone, Debug, PartialEq)]
pub struct JobStatus {
    /// What it does, as in "building binned, 32 bins".
    pub what: String,
    pub elapsed: Duration,
    /// In 0..=1, where it is known.
    pub fraction: Option<f32>,
}

/// One finished build of this run of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryEntry {
    /// Counts up from 1.
    pub number: usize,
    pub config: BuildConfig,
    /// The file that the tree is from, if it was not built.
    pub tree: Option<TreeRef>,
    pub scene: String,
    /// The moment of the scene, in seconds.
    pub time: f32,
    pub build_ms: f64,
    pub sah_cost: Option<f64>,
    /// Mean of the camera rays; `None` until counted.
    pub nodes_visited_mean: Option<f64>,
    pub node_count: usize,
    pub leaf_count: usize,
    pub depth_max: Option<u32>,
    pub depth_mean: Option<f64>,
    /// Tree and shapes ready to trace.
    pub bytes: usize,
}

/// A node or a leaf of the tree of a file, or a shape, with the boxes that stand out in the viewport.
#[derive(Clone, Debug, PartialEq)]
pub struct Marked {
    pub mark: Mark,
    /// Its box; `None` where it has none that can be shown.
    pub bounds: Option<Aabb>,
    pub parent: Option<At>,
    pub parent_bounds: Option<Aabb>,
}

impl Marked {
    /// `None` for what does not exist.
    pub fn of(mark: Mark, world: &World) -> Option<Self> {
        let shown = |bounds: Aabb| (bounds.is_finite() && !bounds.is_empty()).then_some(bounds);
        let nothing = Self { mark, bounds: None, parent: None, parent_bounds: None };
        match mark {
            Mark::Shape(shape) => {
                let exists = (shape as usize) < world.scene.shape_count();
                exists.then(|| Self { bounds: shown(world.scene.shape(shape).bounds()), ..nothing })
            }
            Mark::Item(at) => {
                let Place { bounds, parent } = world.imported.as_ref()?.file.raw.place_of(at)?;
                Some(Self {
                    bounds: bounds.and_then(shown),
                    parent: parent.map(|(at, _)| at),
                    parent_bounds: parent.and_then(|(_, bounds)| bounds).and_then(shown),
                    ..nothing
                })
            }
        }
    }

    /// What the camera is framed to.
    pub fn around(&self) -> Option<Aabb> {
        let boxes = [self.bounds, self.parent_bounds].into_iter().flatten();
        boxes.reduce(|a, b| a.union(b))
    }
}

/// What lies under the mouse in the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hover {
    /// Film pixel.
    pub x: u32,
    pub y: u32,
    /// The film's number there.
    pub value: Option<f32>,
    pub shape: Option<u32>,
    /// Along the camera ray.
    pub distance: Option<f32>,
}

/// What the bins do, for one scene, camera and base configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinCurve {
    /// In order of bins.
    pub points: Vec<BinPoint>,
    /// The full sweep.
    pub sweep: Option<BinPoint>,
    /// Points still to come.
    pub pending: usize,
}

/// The five trees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableState {
    pub rows: Vec<TreeStats>,
    pub running: Option<JobStatus>,
    /// Whether scene, camera or settings have changed since the rows were measured.
    pub stale: bool,
}

/// Points of a sweep, and how it comes on.
#[derive(Clone, Debug, Default)]
pub struct SweepState {
    pub points: Vec<SweepPoint>,
    /// What they were measured on.
    pub question: Option<Question>,
    pub best: Option<Best>,
    pub running: Option<JobStatus>,
    /// It goes on as soon as nothing changes any more.
    pub waiting: bool,
    /// It was held before its end.
    pub can_resume: bool,
    pub finished: bool,
    /// A search, which ends when it has found something; `total` is then its limit.
    pub search: bool,
    pub done: usize,
    pub total: usize,
    /// Of the sweep that is on.
    pub left: Option<Duration>,
    /// What a point took so far, in the mean.
    pub a_point: Option<Duration>,
    pub stale: Option<Stale>,
}

/// What has changed since points were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stale {
    /// Another scene, or another moment of it.
    Scene,
    /// Camera, size or rays.
    View,
}

/// What the shadow views say of the current picture; filled while the Shadows panel is open.
#[derive(Clone, Debug, Default)]
pub struct ShadowState {
    pub counts: Option<ClassCounts>,
    /// Nodes visited per asked shadow ray by `intersect`, by plain `occluded`, by the filtered one.
    pub nodes_mean: Option<[f64; 3]>,
    pub running: bool,
}

/// How the picture is coming on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStatus {
    /// Samples a pixel so far, and the goal if there is one.
    pub samples: u32,
    pub goal: Option<u32>,
    /// Samples of single pixels, a second, in millions.
    pub msamples_per_s: Option<f64>,
    /// Wall time of the last sample over the whole picture.
    pub sample_ms: Option<f64>,
    pub paused: bool,
    /// A timed measurement holds the lease.
    pub measuring: bool,
    /// Width and height of the film, which is coarser than the viewport while the camera moves.
    pub size: [u32; 2],
}
