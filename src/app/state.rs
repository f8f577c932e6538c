//! What the window knows. Plain data; changed by results of jobs and by commands, read by panels as an [`AppView`].

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ColorImage;

use super::ab::Ab;
use super::inspection::Inspection;
use super::jobs::bin_curve::CurveKey;
use super::jobs::census::VisitsKey;
use super::jobs::figures::FiguresKey;
use super::jobs::forecast::ForecastView;
use super::jobs::region::RegionFigures;
use super::jobs::render::{Frame, MOST_PICTURES, Pace};
use super::jobs::shadow::ShadowKey;
use super::jobs::table::TableKey;
use super::jobs::visible::VisibleKey;
use super::jobs::{OverlayKey, SceneKey, TreeKey};
use super::messages::Messages;
use super::player::Player;
use super::selection::{Hidden, Selections};
use super::splitting::Splitting;
use super::theme::Palette;
use super::tours::Touring;
use super::view::{
    AppView, BinCurve, CompareStyle, CompareViews, HistoryEntry, Hover, JobStatus, Marked, RenderStatus,
    ShadowState, Side, SweepState, TableState, TreeView,
};
use crate::accel::NodeId;
use crate::geometry::Aabb;
use crate::inspect::census::{Census, Visits};
use crate::inspect::overlaps::{OverlapMeasure, OverlappingPair};
use crate::inspect::plot::Plot;
use crate::inspect::prediction::Forecast;
use crate::inspect::region::Region;
use crate::render::film::FilmSubject;
use crate::render::measure::RayFigures;
use crate::render::{DisplaySettings, Overlay};
use crate::scene::{Camera, Scene, SceneRef};
use crate::session::{Session, TreeRef, prepare};
use crate::world::World;

/// The camera counts as moving for this long after it moved.
pub const SETTLE: Duration = Duration::from_millis(160);

/// Builds that are remembered.
const MOST_HISTORY: usize = 50;

/// Recent scenes that are remembered.
const MOST_RECENT: usize = 10;

/// What is open.
pub struct Document {
    /// Counts the loads of this run.
    pub load: u64,
    /// The scene as it was loaded.
    pub still: Arc<Scene>,
    /// The newest finished tree, over the scene of its moment.
    pub world: Arc<World>,
    pub tree: TreeKey,
    /// What had to be repaired.
    pub warnings: Vec<String>,
}

/// Drawn boxes.
pub struct Boxes {
    pub key: OverlayKey,
    pub overlay: Arc<Overlay>,
    pub image: Arc<ColorImage>,
    /// Counts the drawings.
    pub version: u64,
}

/// A picture of the viewport.
pub struct Picture {
    pub frame: Frame,
    /// Counts the pictures, so that textures know when to follow.
    pub version: u64,
}

/// Everything that the window knows.
pub struct State {
    pub session: Session,
    pub document: Option<Document>,
    pub dark: bool,
    pub palette: Palette,
    pub recent: Vec<SceneRef>,
    /// Starts with what was shown last time, if nothing is named to open.
    pub reopen_at_start: bool,
    /// The session is that of last time, and its scene is not there yet.
    pub reopened: bool,
    pub messages: Messages,
    pub pictures: [Option<Picture>; MOST_PICTURES],
    pub boxes: Option<Boxes>,
    pub history: Vec<HistoryEntry>,
    /// The trees of `history`.
    pub history_keys: Vec<TreeKey>,
    pub figures: Option<(FiguresKey, RayFigures)>,
    /// Of trees of one scene, from where `forecast_view` says.
    pub forecasts: Vec<Forecast>,
    /// The trees of `forecasts`.
    pub forecast_keys: Vec<TreeKey>,
    pub forecast_view: Option<(SceneKey, ForecastView)>,
    pub curve: BinCurve,
    pub curve_key: Option<CurveKey>,
    pub table: TableState,
    pub table_key: Option<TableKey>,
    pub sweep: SweepState,
    pub shadow: ShadowState,
    pub shadow_key: Option<ShadowKey>,
    pub compare: Option<CompareViews>,
    /// What the window has of the two sides.
    pub ab: Ab,
    /// Nothing moves by itself; for tests.
    pub hold: bool,
    pub hover: Option<Hover>,
    pub marked: Option<Marked>,
    pub selections: Selections,
    pub hidden: Hidden,
    /// A part of the picture whose numbers are looked at.
    pub region: Option<Region>,
    pub region_figures: Option<RegionFigures>,
    /// The scene without what is hidden.
    pub visible: Option<(VisibleKey, Arc<World>)>,
    pub tree_view: TreeView,
    pub inspection: Inspection,
    pub splitting: Splitting,
    pub player: Player,
    /// The guided tour that is taken.
    pub touring: Option<Touring>,
    pub census: Option<(TreeKey, Arc<Census>)>,
    pub visits: Option<(VisitsKey, Arc<Visits>)>,
    pub overlaps: Option<(TreeKey, OverlapMeasure, Arc<Vec<OverlappingPair>>)>,
    pub animating: bool,
    pub paused: bool,
    /// The range of the colour map, held while a slider of the Build panel is.
    pub held_range: Option<[f32; 2]>,
    pub measuring: bool,
    /// The picture area of the viewport in pixels; zero until it was drawn.
    pub viewport: [u32; 2],
    pub camera_moved: Option<Instant>,
    /// When a command last changed what is shown.
    pub last_change: Instant,
    pub loading: Option<JobStatus>,
    pub building: Option<JobStatus>,
    pub exporting: Option<JobStatus>,
    /// The plot that was chosen last to be saved.
    pub plot: Option<Arc<Plot>>,
    last_version: u64,
    last_number: usize,
}

impl State {
    pub fn new(session: Session, dark: bool) -> Self {
        Self {
            session,
            document: None,
            dark,
            palette: Palette::of(dark),
            recent: Vec::new(),
            reopen_at_start: true,
            reopened: false,
            messages: Messages::default(),
            pictures: Default::default(),
            boxes: None,
            history: Vec::new(),
            history_keys: Vec::new(),
            figures: None,
            forecasts: Vec::new(),
            forecast_keys: Vec::new(),
            forecast_view: None,
            curve: BinCurve::default(),
            curve_key: None,
            table: TableState::default(),
            table_key: None,
            sweep: SweepState::default(),
            shadow: ShadowState::default(),
            shadow_key: None,
            compare: None,
            ab: Ab::default(),
            hold: false,
            hover: None,
            marked: None,
            selections: Selections::default(),
            hidden: Hidden::default(),
            region: None,
            region_figures: None,
            visible: None,
            tree_view: TreeView::default(),
            inspection: Inspection::default(),
            splitting: Splitting::default(),
            player: Player::default(),
            touring: None,
            census: None,
            visits: None,
            overlaps: None,
            animating: false,
            paused: false,
            held_range: None,
            measuring: false,
            viewport: [0, 0],
            camera_moved: None,
            last_change: Instant::now(),
            loading: None,
            building: None,
            exporting: None,
            plot: None,
            last_version: 0,
            last_number: 0,
        }
    }

    /// The camera that is looked through.
    pub fn camera(&self) -> Option<Camera> {
        self.document.as_ref().map(|d| prepare::camera(&d.world.scene, &self.session))
    }

    /// The session's moment of what is open.
    pub fn wanted_scene(&self) -> Option<SceneKey> {
        self.document.as_ref().map(|d| SceneKey::of(d.load, &d.still, &self.session))
    }

    /// What the pictures of the viewport show, one or two.
    pub fn subjects(&self) -> Vec<FilmSubject> {
        let subject = self.session.film_subject();
        match self.compare {
            None => vec![subject],
            Some(compare) => {
                let view = |side: Side| FilmSubject { view: side.view.unwrap_or(subject.view), ..subject };
                compare.sides().map(view).to_vec()
            }
        }
    }

    /// The size of each of the viewport's pictures, in pixels; `None` until the viewport was drawn.
    pub fn picture_size(&self) -> Option<[u32; 2]> {
        let [width, height] = self.viewport;
        let side_by_side = self.compare.is_some_and(|c| c.style == CompareStyle::SideBySide);
        let width = if side_by_side { width / 2 } else { width };
        (width > 0 && height > 0).then_some([width, height])
    }

    /// The size that figures are measured at: of the whole viewport, also while two pictures share it.
    pub fn measured_size(&self) -> Option<[u32; 2]> {
        let [width, height] = self.viewport;
        (width > 0 && height > 0).then_some(self.viewport)
    }

    /// How pictures are to be shown now.
    pub fn display(&self) -> DisplaySettings {
        let display = self.session.display;
        let range = display.range.or(self.held_range).or_else(|| self.shared_range());
        DisplaySettings { range, ..display }
    }

    /// Whether the camera or the scene is moving.
    pub fn is_moving(&self, now: Instant) -> bool {
        self.animating || self.camera_moved.is_some_and(|moved| now.saturating_duration_since(moved) < SETTLE)
    }

    /// How the pictures are to be refined now.
    pub fn pace(&self, now: Instant, hold: bool) -> Pace {
        if self.paused {
            Pace::Paused
        } else if hold {
            Pace::Direct
        } else if self.is_moving(now) {
            Pace::Moving
        } else {
            Pace::Refine
        }
    }

    /// The picture of a slot, if it is one of what is open.
    pub fn picture(&self, slot: usize) -> Option<&Picture> {
        let load = self.shown(slot)?.tree.scene.load;
        self.pictures.get(slot)?.as_ref().filter(|p| p.frame.key.scene.load == load)
    }

    /// A number for a new picture or overlay.
    pub fn next_version(&mut self) -> u64 {
        self.last_version += 1;
        self.last_version
    }

    /// Puts a finished build into the history, unless it is the one that stands there last.
    pub fn remember_build(&mut self, key: TreeKey, world: &World) {
        if self.history_keys.last() == Some(&key) {
            return;
        }
        self.last_number += 1;
        let figures = &world.figures;
        self.history.push(HistoryEntry {
            number: self.last_number,
            config: key.config,
            tree: world
                .traced_file()
                .map(|file| TreeRef { path: file.path.clone(), content_hash: file.content_hash.clone() }),
            scene: world.scene.name.clone(),
            time: world.scene.time,
            build_ms: world.report.build_ms,
            sah_cost: figures.sah_cost.map(|c| c.total()),
            nodes_visited_mean: None,
            node_count: figures.node_count,
            leaf_count: figures.leaf_count,
            depth_max: figures.depth_max,
            depth_mean: figures.depth_mean,
            bytes: world.bytes(),
        });
        self.history_keys.push(key);
        if self.history.len() > MOST_HISTORY {
            self.history.remove(0);
            self.history_keys.remove(0);
        }
    }

    /// Fills in what was counted for a tree of the history.
    pub fn remember_rays(&mut self, key: &TreeKey, rays: &RayFigures) {
        if let Some(i) = self.history_keys.iter().rposition(|k| k == key) {
            self.history[i].nodes_visited_mean = rays.nodes_visited_mean;
        }
    }

    /// Puts a scene at the front of the recent ones.
    pub fn remember_recent(&mut self, scene: &SceneRef) {
        self.recent.retain(|s| s != scene);
        self.recent.insert(0, scene.clone());
        self.recent.truncate(MOST_RECENT);
    }

    /// The session that the next start shows again: that of before a tour, while one is taken.
    pub fn session_to_keep(&self) -> &Session {
        self.touring.as_ref().map_or(&self.session, Touring::before)
    }

    /// What panels read.
    pub fn view(&self) -> AppView<'_> {
        let picture = self.picture(0);
        let rays = self
            .figures
            .as_ref()
            .filter(|(key, _)| self.document.as_ref().is_some_and(|d| d.tree == key.tree));
        AppView {
            session: &self.session,
            palette: &self.palette,
            scene: self.document.as_ref().map(|d| &d.world.scene),
            scene_warnings: self.document.as_ref().map_or(&[], |d| &d.warnings),
            world: self.document.as_ref().map(|d| &d.world),
            recent: &self.recent,
            animating: self.animating,
            loading: self.loading.clone(),
            building: self.building.clone(),
            exporting: self.exporting.clone(),
            plot: self.plot.as_deref(),
            history: &self.history,
            film: picture.map(|p| &*p.frame.film),
            histogram: picture.and_then(|p| p.frame.presented.histogram.as_ref()),
            range: picture.and_then(|p| p.frame.presented.range),
            range_locked: self.held_range.is_some(),
            hover: self.hover,
            marked: self.marked.as_ref(),
            selections: &self.selections,
            hidden: &self.hidden,
            region: self.region_figures.as_ref(),
            census: self.census(),
            visits: self.visits(),
            overlaps: self.overlaps(),
            tree_view: &self.tree_view,
            inspection: &self.inspection,
            splitting: &self.splitting,
            player: &self.player,
            touring: self.touring.as_ref(),
            tree: self.document.as_ref().map(|d| d.tree),
            camera: self.camera(),
            overlay: self.own_boxes().map(|b| &*b.overlay),
            rays: rays.map(|(_, rays)| rays),
            forecast: self.forecast(),
            forecasts: &self.forecasts,
            bin_curve: &self.curve,
            table: &self.table,
            sweep: &self.sweep,
            shadow: &self.shadow,
            compare: self.compare,
            ab: &self.ab.panel,
            render: self.render_status(),
        }
    }

    /// Of the tree at hand.
    pub fn census(&self) -> Option<&Arc<Census>> {
        let tree = self.document.as_ref()?.tree;
        self.census.as_ref().filter(|(key, _)| *key == tree).map(|(_, census)| census)
    }

    /// The active state's scene without what is hidden, if something is, and it is there.
    pub fn visible_world(&self) -> Option<&Arc<World>> {
        let scene = self.document.as_ref()?.tree.scene;
        let wanted = VisibleKey { scene, hidden: self.hidden.version };
        let (key, world) = self.visible.as_ref()?;
        (*key == wanted && !self.hidden.is_empty()).then_some(world)
    }

    /// What is seen in a slot: the world itself, or that without what is hidden. The second number counts what was hidden, and
    /// is 0 where nothing is.
    pub fn seen(&self, slot: usize) -> Option<(&Arc<World>, u64)> {
        let shown = self.shown(slot)?;
        let is_active = self.document.as_ref().is_some_and(|document| document.tree == shown.tree);
        match self.visible_world().filter(|_| is_active) {
            Some(world) => Some((world, self.hidden.version)),
            None => Some((shown.world, 0)),
        }
    }

    /// The boxes of the selected nodes, once they are known.
    pub fn selected_bounds(&self) -> Vec<(NodeId, Aabb)> {
        let (Some(document), Some(census), Some(selection)) =
            (&self.document, self.census(), self.selections.current())
        else {
            return Vec::new();
        };
        let tree = document.world.shown_tree();
        selection.nodes.iter().map(|node| (*node, census.family.bounds(tree, *node))).collect()
    }

    /// Of the tree at hand.
    fn visits(&self) -> Option<(&VisitsKey, &Visits)> {
        let tree = self.document.as_ref()?.tree;
        self.visits.as_ref().filter(|(key, _)| key.tree == tree).map(|(key, visits)| (key, &**visits))
    }

    /// Of the tree at hand, by the measure that is asked for.
    fn overlaps(&self) -> Option<&[OverlappingPair]> {
        let tree = self.document.as_ref()?.tree;
        let (key, measure, pairs) = self.overlaps.as_ref()?;
        (*key == tree && *measure == self.tree_view.measure).then_some(&pairs[..])
    }

    /// Of the tree at hand.
    fn forecast(&self) -> Option<&Forecast> {
        let tree = self.document.as_ref()?.tree;
        self.forecasts.get(self.forecast_keys.iter().position(|key| *key == tree)?)
    }

    fn render_status(&self) -> RenderStatus {
        let frame = self.picture(0).map(|p| &p.frame);
        let sample_ms = frame.and_then(|f| f.sample_ms);
        let size = frame.map_or([0, 0], |f| [f.film.width, f.film.height]);
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        RenderStatus {
            samples: frame.map_or(0, |f| if f.scale == 1 { f.film.samples } else { 0 }),
            goal: match frame {
                Some(frame) if !frame.key.refines() => Some(1),
                _ => self.session.render.spp,
            },
            msamples_per_s: sample_ms.filter(|ms| *ms > 0.0).map(|ms| pixels / ms * 1e-3),
            sample_ms,
            paused: self.paused,
            measuring: self.measuring,
            size,
        }
    }
}
