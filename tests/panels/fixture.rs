//! A small program around the panels: real data of a small scene, and commands applied as the window applies them.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use bvhscope::accel::{BuildConfig, Builder, Width};
use bvhscope::app::commands::{Command, Commands, SaveTarget};
use bvhscope::app::inspection::{FoundRays, Inspection, RayOrigin, RaysAsked, RaysKey, Recorded};
use bvhscope::app::jobs::census::VisitsKey;
use bvhscope::app::jobs::region::RegionFigures;
use bvhscope::app::jobs::{SceneKey, TreeKey};
use bvhscope::app::panels::{PanelKind, Panels};
use bvhscope::app::player::Player;
use bvhscope::app::selection::{Hidden, Selections};
use bvhscope::app::splitting::{FoundSplits, Splitting};
use bvhscope::app::theme::{self, Palette};
use bvhscope::app::view::{
    AbState, AppView, BinCurve, CompareStyle, CompareViews, HistoryEntry, Hover, JobStatus, Marked,
    RenderStatus, ShadowState, SweepState, TableState, TreeView,
};
use bvhscope::export::points::Question;
use bvhscope::inspect::best::{Objective, Search};
use bvhscope::inspect::bin_sweep::measure_bins;
use bvhscope::inspect::census::{Census, Visits};
use bvhscope::inspect::compare::Comparison;
use bvhscope::inspect::construction::Construction;
use bvhscope::inspect::difference::DifferenceSummary;
use bvhscope::inspect::histogram::Histogram;
use bvhscope::inspect::overlaps::{OverlappingPair, worst_pairs};
use bvhscope::inspect::paired_cost::PairedRayCost;
use bvhscope::inspect::prediction::Forecast;
use bvhscope::inspect::ray_tree::{PixelQuestion, RaySource, pixel_rays};
use bvhscope::inspect::region::Region;
use bvhscope::inspect::shadow_difference::{ClassCounts, shadow_nodes_mean};
use bvhscope::inspect::split_curve::SplitCurve;
use bvhscope::inspect::stats::{Measurement, tree_stats};
use bvhscope::inspect::sweep::{SweepGrid, Sweeper};
use bvhscope::inspect::table::five_trees;
use bvhscope::render::difference::Difference;
use bvhscope::render::display::effective_range;
use bvhscope::render::integrate::render;
use bvhscope::render::measure::{RayFigures, count_rays};
use bvhscope::render::overlay::{draw_boxes, first_hit_distances};
use bvhscope::render::ray_costs::ray_costs;
use bvhscope::render::visits::node_visits;
use bvhscope::render::{CountKind, Film, Overlay, OverlaySettings, RenderSettings, View};
use bvhscope::scene::{Camera, Scene, SceneRef, builtin};
use bvhscope::session::Session;
use bvhscope::task::Task;
use bvhscope::world::NodeFigure;
use bvhscope::world::World;
use egui_kittest::Harness;

/// What was measured once, for all tests.
pub struct Measured {
    scene: Arc<Scene>,
    world: Arc<World>,
    rays: RayFigures,
    film: Film,
    histogram: Histogram,
    overlay: Overlay,
    history: Vec<HistoryEntry>,
    bin_curve: BinCurve,
    /// Of `history`.
    forecasts: Vec<Forecast>,
    table: TableState,
    sweep: SweepState,
    shadow: ShadowState,
    census: Arc<Census>,
    visits: (VisitsKey, Visits),
    overlaps: Vec<OverlappingPair>,
    rays_of_pixel: (RayOrigin, FoundRays, Recorded),
    region: RegionFigures,
    /// Of two states.
    ab: AbState,
}

/// The tree of the panels.
pub fn tree_key(world: &World) -> TreeKey {
    let scene = SceneKey::of(1, &world.scene, &Session::default());
    TreeKey { scene, config: world.report.config, file: None }
}

/// What the window finds out in the background of every node.
fn census(world: &World, task: &Task) -> Arc<Census> {
    let census = Census::of(world, task).expect("nobody cancels");
    for figure in NodeFigure::ALL {
        census.values(world, figure, task).expect("nobody cancels");
    }
    census.find_sah_below(world, task).expect("nobody cancels");
    Arc::new(census)
}

/// The rays of a pixel that sees glass.
fn rays_of_pixel(world: &World, task: &Task) -> (RayOrigin, FoundRays, Recorded) {
    let session = Session::default();
    let (camera, pixel) = (world.scene.camera, [70, 38]);
    let shadow_rule = session.shadow_rule;
    let question = PixelQuestion {
        camera,
        settings: SETTINGS,
        shadow_rule,
        source: RaySource::Whitted,
        sample: 0,
        pixel,
    };
    let key = RaysKey { tree: tree_key(world), asked: RaysAsked::Pixel(question) };
    let rays = pixel_rays(world, &question, task).expect("nobody cancels");
    let recorded = Recorded::new(world, key, 0, &rays[0], Default::default(), shadow_rule);
    (RayOrigin::Pixel { camera, pixel }, FoundRays::new(key, rays), recorded)
}

const SETTINGS: RenderSettings =
    RenderSettings { width: 96, height: 54, spp: None, seed: 0, max_depth: 10, threads: 0 };

pub fn build(scene: &Arc<Scene>, config: &BuildConfig) -> Arc<World> {
    Arc::new(World::build(Arc::clone(scene), config, &Task::new()).expect("nobody cancels"))
}

fn entry(number: usize, world: &World, rays: &RayFigures) -> HistoryEntry {
    HistoryEntry {
        number,
        config: world.report.config,
        tree: None,
        scene: world.scene.name.clone(),
        time: world.scene.time,
        build_ms: world.report.build_ms,
        sah_cost: world.figures.sah_cost.map(|c| c.total()),
        nodes_visited_mean: rays.nodes_visited_mean,
        node_count: world.figures.node_count,
        leaf_count: world.figures.leaf_count,
        depth_max: world.figures.depth_max,
        depth_mean: world.figures.depth_mean,
        bytes: world.bytes(),
    }
}

/// Of the tree that is shown: a binary one, which has the most levels.
fn config() -> BuildConfig {
    BuildConfig { width: Width::W2, ..BuildConfig::default() }
}

fn measure() -> Measured {
    let task = Task::new();
    let scene = Arc::new(builtin::make("bunny").expect("the default scene"));
    let camera = scene.camera;
    let settings = SETTINGS;
    let count = |world: &World| {
        count_rays(world, &camera, &settings, CountKind::Camera, 1, &task).expect("nobody cancels")
    };
    let configs = [4, 8, 12, 64, 16].map(|bins| BuildConfig { bins, ..config() });
    let worlds = configs.map(|config| build(&scene, &config));
    let history = worlds.iter().enumerate().map(|(i, w)| entry(i + 1, w, &count(w))).collect();
    let world = Arc::clone(worlds.last().expect("five worlds"));
    let subject = Session { view: View::NodesVisited, ..Session::default() }.film_subject();
    let film = render(subject, &world, &camera, &settings, 1, &task).expect("nobody cancels");
    let numbers = film.numbers().expect("a heatmap");
    let histogram = Histogram::of(&numbers, 128, None).expect("some pixels hit");
    let depth = first_hit_distances(&world, &camera, 96, 54, &task).expect("nobody cancels");
    let boxes = OverlaySettings { depths: Some([0, 6]), budget: 40, ..OverlaySettings::default() };
    let overlay = draw_boxes(&world, &camera, &boxes, &[], &depth, [96, 54], &task).expect("nobody cancels");
    let forecast = |world: &Arc<World>| Forecast {
        sah_cost: world.figures.sah_cost.map(|cost| cost.total()),
        epo: world.epo(&task).expect("nobody cancels").map(|epo| epo.total),
        ray_costs: ray_costs(world, &camera, &settings, &task).expect("nobody cancels"),
    };
    let forecasts = worlds.iter().map(forecast).collect();
    let points = [2, 4, 8, 16, 32, 64, 128, 256].map(|bins| {
        let base = config();
        measure_bins(&scene, &camera, &base, Some(bins), &settings, 4, bins < 64, &task).expect("no cancel")
    });
    let sweep = measure_bins(&scene, &camera, &config(), None, &settings, 4, true, &task).ok();
    let bin_curve = BinCurve { points: points.to_vec(), sweep, pending: 16 };
    let soup = Arc::new(builtin::make("soup:300").expect("a built-in scene"));
    let rows = five_trees(&soup, &soup.camera, &BuildConfig::default(), &settings, &task, &mut |_| ());
    let table = TableState { rows: rows.expect("nobody cancels"), running: None, stale: true };
    let sweep = swept(&soup, &settings, &task);
    let rule = Session::default().shadow_rule;
    let subject = Session { view: View::ShadowDifference, ..Session::default() }.film_subject();
    let classes = render(subject, &world, &camera, &settings, 1, &task).expect("nobody cancels");
    let nodes_mean = shadow_nodes_mean(&world, &camera, &settings, rule, 1, &task).expect("nobody cancels");
    let shadow = ShadowState { counts: ClassCounts::of(&classes), nodes_mean, running: false };
    let rays = count(&world);
    let census = census(&world, &task);
    let key = VisitsKey { tree: tree_key(&world), camera, width: 96, height: 54, count: CountKind::Camera };
    let visits = node_visits(&world, &camera, &settings, CountKind::Camera, &task).expect("nobody cancels");
    let visits = (key, Visits::new(&census, &visits));
    let measure = TreeView::default().measure;
    let overlaps = worst_pairs(&world.tree, measure, 100, &task).expect("nobody cancels");
    let rays_of_pixel = rays_of_pixel(&world, &task);
    let part = Region::between([20, 10], [70, 40], [96, 54]).expect("large enough");
    let region = RegionFigures {
        version: 1,
        region: Some(part),
        histogram: part.histogram(&film, 48),
        largest: part.largest(&film, 8, 4),
    };
    let ab = compared([&worlds[0], &world], &camera, &settings, &task);
    Measured {
        census,
        visits,
        overlaps,
        rays_of_pixel,
        region,
        scene,
        world,
        rays,
        film,
        histogram,
        overlay,
        history,
        bin_curve,
        forecasts,
        table,
        sweep,
        shadow,
        ab,
    }
}

/// Two trees against each other, and two films of them.
fn compared(worlds: [&Arc<World>; 2], camera: &Camera, settings: &RenderSettings, task: &Task) -> AbState {
    let stats = |name: &str, world: &World| {
        tree_stats(name, world, camera, settings, CountKind::Camera, false, task).expect("nobody cancels")
    };
    let mut comparison = Comparison::of(stats("A", worlds[0]), stats("B", worlds[1]));
    comparison.ray_cost =
        PairedRayCost::measure([worlds[0], worlds[1]], [camera; 2], settings, task).expect("nobody cancels");
    let subject = Session { view: View::NodesVisited, ..Session::default() }.film_subject();
    let film = |world: &World| render(subject, world, camera, settings, 1, task).expect("nobody cancels");
    let difference = Difference::of(&film(worlds[0]), &film(worlds[1])).expect("two heatmaps");
    AbState {
        ready: [true; 2],
        figures: Some(Arc::new(comparison)),
        difference: DifferenceSummary::of(&difference, View::NodesVisited),
        can_time: true,
        ..AbState::default()
    }
}

/// A finished search over a small scene.
fn swept(scene: &Arc<Scene>, settings: &RenderSettings, task: &Task) -> SweepState {
    let (camera, count) = (&scene.camera, CountKind::Camera);
    let measurement = Measurement { scene, camera, settings, count, timed: false, builds: 1 };
    let sweeper = Sweeper { measurement, costs: [1.0, 1.0], known: &[] };
    let base = BuildConfig::default();
    let builders = vec![Builder::Binned, Builder::Lbvh, Builder::Median];
    let grid = SweepGrid { builders, bins: vec![4, 16, 64], ..SweepGrid::around(&base) };
    let points = sweeper.grid(&grid, &base, task, &mut |_| ()).expect("nobody cancels");
    let search = Search { budget: 20, ..Search::around(&base, Objective::RayCost) };
    let measure = &mut |name: &str, config: &BuildConfig, fresh: bool| {
        sweeper.point(name, config, fresh, task, &mut |_| ())
    };
    let best = search.run(&base, task, measure).expect("nobody cancels");
    SweepState {
        total: points.len(),
        done: points.len(),
        points,
        question: Some(Question::new(&Session::default(), camera)),
        best: Some(best),
        finished: true,
        ..SweepState::default()
    }
}

fn player(world: &Arc<World>) -> Player {
    let construction = Construction::of(world, &Task::new()).expect("nobody cancels");
    let mut player = Player::default();
    player.construction = Some((tree_key(world), Arc::new(construction)));
    player
}

fn inspection(m: &Measured) -> Inspection {
    let (origin, found, recorded) = m.rays_of_pixel.clone();
    let mut inspection = Inspection::default();
    inspection.view.origin = Some(origin);
    inspection.found = Some(found);
    inspection.recorded = Some(recorded);
    inspection
}

fn measured() -> &'static Measured {
    static MEASURED: OnceLock<Measured> = OnceLock::new();
    MEASURED.get_or_init(measure)
}

/// The program around one panel.
pub struct Program {
    panels: Panels,
    pub kind: PanelKind,
    pub session: Session,
    palette: Palette,
    /// Whether anything has been loaded and built.
    loaded: bool,
    pub world: Option<Arc<World>>,
    pub building: Option<JobStatus>,
    pub exporting: Option<JobStatus>,
    pub plot: Option<bvhscope::inspect::plot::Plot>,
    pub animating: bool,
    pub compare: Option<CompareViews>,
    pub ab: AbState,
    pub range_locked: bool,
    pub table: TableState,
    pub sweep: SweepState,
    pub marked: Option<Marked>,
    pub selections: Selections,
    pub hidden: Hidden,
    pub tree_view: TreeView,
    pub inspection: Inspection,
    pub splitting: Splitting,
    pub player: Player,
    warnings: Vec<String>,
    recent: Vec<SceneRef>,
    /// All commands that were not edits, in order, in words.
    pub asked: Vec<String>,
    pub edits: usize,
    /// The next export, a text to copy.
    pub copied: String,
}

pub fn job(what: &str, fraction: Option<f32>) -> JobStatus {
    JobStatus { what: what.to_owned(), elapsed: Duration::from_millis(1234), fraction }
}

impl Program {
    /// With everything that there is to show.
    pub fn full(kind: PanelKind, dark: bool) -> Self {
        let m = measured();
        let mut session = Session { view: View::NodesVisited, ..Session::default() };
        *session.build_mut() = config();
        session.overlay.depths = Some([0, 6]);
        session.overlay.budget = 40;
        session.display.threshold = Some(m.histogram.p95);
        let compares = kind == PanelKind::Compare;
        if compares {
            session.build_mut().bins = 4;
            session.keep();
            *session.build_mut() = config();
        }
        Self {
            session,
            compare: compares.then(|| CompareViews::of_states(0, 1, CompareStyle::Difference)),
            ab: if compares { m.ab.clone() } else { AbState::default() },
            loaded: true,
            world: Some(Arc::clone(&m.world)),
            table: m.table.clone(),
            sweep: m.sweep.clone(),
            inspection: inspection(m),
            player: player(&m.world),
            warnings: vec!["12 faces with fewer than three corners were left out".to_owned()],
            recent: vec![
                SceneRef::File("/home/someone/models/a long folder name/sponza.obj".into()),
                SceneRef::File("dragon.ply".into()),
            ],
            ..Self::empty(kind, dark)
        }
    }

    /// Before anything was loaded.
    pub fn empty(kind: PanelKind, dark: bool) -> Self {
        Self {
            panels: Panels::default(),
            kind,
            session: Session::default(),
            palette: Palette::of(dark),
            loaded: false,
            world: None,
            building: None,
            exporting: None,
            plot: None,
            animating: false,
            compare: None,
            ab: AbState::default(),
            range_locked: false,
            table: TableState::default(),
            sweep: SweepState::default(),
            marked: None,
            selections: Selections::default(),
            hidden: Hidden::default(),
            tree_view: TreeView::default(),
            inspection: Inspection::default(),
            splitting: Splitting::default(),
            player: Player::default(),
            warnings: Vec::new(),
            recent: Vec::new(),
            asked: Vec::new(),
            edits: 0,
            copied: String::new(),
        }
    }

    pub fn harness(self, size: [f32; 2]) -> Harness<'static, Self> {
        let dark = self.palette.dark;
        Harness::builder()
            .with_size(size)
            .with_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light })
            .with_context_setup(move |ctx| theme::apply(ctx, dark))
            .build_ui_state(|ui, program: &mut Self| program.frame(ui), self)
    }

    fn frame(&mut self, ui: &mut egui::Ui) {
        let mut commands = Commands::default();
        let mut panels = std::mem::take(&mut self.panels);
        egui::CentralPanel::default()
            .frame(egui::Frame::NONE.fill(ui.visuals().panel_fill))
            .show(ui, |ui| panels.ui(self.kind, ui, &self.view(), &mut commands));
        self.panels = panels;
        for command in commands.take() {
            self.apply(command);
        }
    }

    fn view(&self) -> AppView<'_> {
        static NO_CURVE: BinCurve = BinCurve { points: Vec::new(), sweep: None, pending: 0 };
        static NO_SHADOW: ShadowState = ShadowState { counts: None, nodes_mean: None, running: false };
        let m = self.loaded.then(measured);
        AppView {
            session: &self.session,
            palette: &self.palette,
            scene: m.map(|m| &m.scene),
            scene_warnings: &self.warnings,
            world: self.world.as_ref(),
            recent: &self.recent,
            animating: self.animating,
            loading: None,
            building: self.building.clone(),
            exporting: self.exporting.clone(),
            plot: self.plot.as_ref(),
            history: m.map_or(&[], |m| &m.history),
            film: m.map(|m| &m.film),
            histogram: m.map(|m| &m.histogram),
            range: m.and_then(|m| effective_range(&m.film, &self.session.display)),
            range_locked: self.range_locked,
            hover: m.map(|m| Hover {
                x: 40,
                y: 30,
                value: m.film.number(40, 30),
                shape: Some(17),
                distance: Some(2.5),
            }),
            marked: self.marked.as_ref(),
            selections: &self.selections,
            hidden: &self.hidden,
            region: m.map(|m| &m.region),
            census: m.map(|m| &m.census),
            visits: m.map(|m| (&m.visits.0, &m.visits.1)),
            overlaps: m.map(|m| &m.overlaps[..]),
            tree_view: &self.tree_view,
            inspection: &self.inspection,
            splitting: &self.splitting,
            player: &self.player,
            touring: None,
            tree: self.world.as_ref().map(|world| tree_key(world)),
            camera: m.map(|m| m.scene.camera),
            overlay: m.map(|m| &m.overlay),
            rays: m.map(|m| &m.rays),
            forecast: m.and_then(|m| m.forecasts.last()),
            forecasts: m.map_or(&[], |m| &m.forecasts),
            bin_curve: m.map_or(&NO_CURVE, |m| &m.bin_curve),
            table: &self.table,
            sweep: &self.sweep,
            shadow: m.map_or(&NO_SHADOW, |m| &m.shadow),
            compare: self.compare,
            ab: &self.ab,
            render: RenderStatus { samples: 12, size: [960, 540], ..RenderStatus::default() },
        }
    }

    pub fn apply(&mut self, command: Command) {
        let text = match command {
            Command::Edit(change) => {
                change(&mut self.session);
                self.edits += 1;
                return;
            }
            Command::HoldRange(held) => {
                self.range_locked = held;
                format!("hold range {held}")
            }
            Command::SetCompareViews(views) => {
                self.compare = views;
                "compare".to_owned()
            }
            Command::ActivateVariant(index) => {
                self.session = self.session.activated(index);
                format!("use state {index}")
            }
            Command::TimeComparison => "time comparison".to_owned(),
            Command::SetAnimating(on) => {
                self.animating = on;
                format!("animate {on}")
            }
            Command::CopyText { text, what } => {
                self.copied = text;
                format!("copy {what}")
            }
            Command::Mark(mark) => {
                self.marked = mark.and_then(|mark| Marked::of(mark, self.world.as_ref()?));
                format!("mark {mark:?}")
            }
            Command::Select { pick, add } => {
                if let Some(world) = &self.world {
                    self.selections.pick(world, world, tree_key(world), pick, add);
                }
                self.weigh_splits();
                format!("select {pick:?}")
            }
            Command::SetPlayerView(view) => {
                self.player.view = view;
                if let Some(world) = &self.world {
                    self.player.show(tree_key(world), &world.tree);
                }
                "player view".to_owned()
            }
            Command::SetSplitView(view) => {
                self.splitting.set(view);
                "split view".to_owned()
            }
            Command::Hide(what) => format!("hide {what:?}"),
            Command::SetRegion(region) => format!("region {region:?}"),
            Command::GoToPixel(pixel) => format!("go to {pixel:?}"),
            Command::GoSelection(way) => {
                self.selections.go(way, Some(&measured().census.family));
                format!("go {way:?}")
            }
            Command::ClearSelection => {
                self.selections.clear();
                "deselect".to_owned()
            }
            Command::FrameSelection => "frame selection".to_owned(),
            Command::SetTreeView(view) => {
                self.tree_view = view;
                "tree view".to_owned()
            }
            Command::SetRayView(view) => {
                self.inspection.view = view;
                self.record_ray();
                "ray view".to_owned()
            }
            Command::StepRay { forward } => {
                if let Some(found) = &self.inspection.found {
                    self.inspection.view.chosen = found.neighbour(self.inspection.view.chosen, forward);
                }
                self.record_ray();
                format!("next ray {forward}")
            }
            Command::LookAtRay => "look at the ray".to_owned(),
            Command::FrameMarked => "frame marked".to_owned(),
            Command::BuildOwnTree => {
                self.session.set_tree(None);
                "build own tree".to_owned()
            }
            Command::AskImport => "ask import".to_owned(),
            Command::ImportTree(path) => format!("import {}", path.display()),
            Command::OpenScene(scene) => format!("open {}", scene.text()),
            Command::OpenSession(path) => format!("open session {}", path.display()),
            Command::SaveSession(path) => format!("save session {}", path.display()),
            Command::AskSavePath { target, suggested } => {
                format!("ask {} {}", target.name(), suggested.display())
            }
            Command::Export(request) => format!("{request:?}"),
            Command::CancelBuild => "cancel build".to_owned(),
            Command::CancelExport => "cancel export".to_owned(),
            Command::MeasureTable => "measure table".to_owned(),
            Command::CancelTable => "cancel table".to_owned(),
            Command::StartSweep(plan) => {
                let what = if plan.search.is_some() { "search" } else { "sweep" };
                format!("{what} of {} trees", plan.grid.count(&plan.base))
            }
            Command::SetSweepPaused(paused) => format!("pause sweep {paused}"),
            Command::ClearSweep => "clear sweep".to_owned(),
            Command::Ask(asked) => format!("{asked:?}"),
            Command::ShadowPreset => "shadow preset".to_owned(),
            _ => "another".to_owned(),
        };
        self.asked.push(text);
    }

    /// As the window does it in the background.
    pub fn weigh_splits(&mut self) {
        let (Some(world), Some(selection)) = (&self.world, self.selections.current()) else { return };
        let node = selection.node();
        let curve = SplitCurve::of(world, &measured().census.family, node, &Task::new());
        let curve = Arc::new(curve.expect("nobody cancels"));
        let bins = [world.report.config.bins, self.splitting.view.bins];
        let planes = bins.map(|bins| curve.binned(bins));
        self.splitting.found = Some(FoundSplits { tree: tree_key(world), curve, planes });
    }

    /// As the window does it between two frames.
    fn record_ray(&mut self) {
        let (Some(world), Some(found)) = (&self.world, &self.inspection.found) else { return };
        let view = self.inspection.view;
        let ray = &found.rays[view.chosen];
        let rule = self.session.shadow_rule;
        self.inspection.recorded =
            Some(Recorded::new(world, found.key, view.chosen, ray, view.asked_as, rule));
    }

    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        self.panels.path_chosen(target, path);
    }
}
