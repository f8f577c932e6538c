//! A small program around the panels: real data of a small scene, and commands applied as the window applies them.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use bvhscope::accel::{BuildConfig, Builder, Width};
use bvhscope::app::commands::{Command, Commands, SaveTarget};
use bvhscope::app::panels::{PanelKind, Panels};
use bvhscope::app::theme::{self, Palette};
use bvhscope::app::view::{
    AppView, BinCurve, CompareViews, HistoryEntry, Hover, JobStatus, Marked, RenderStatus, ShadowState,
    SweepState, TableState,
};
use bvhscope::export::points::Question;
use bvhscope::inspect::best::{Objective, Search};
use bvhscope::inspect::bin_sweep::measure_bins;
use bvhscope::inspect::histogram::Histogram;
use bvhscope::inspect::prediction::Forecast;
use bvhscope::inspect::shadow_difference::{ClassCounts, shadow_nodes_mean};
use bvhscope::inspect::stats::Measurement;
use bvhscope::inspect::sweep::{SweepGrid, Sweeper};
use bvhscope::inspect::table::five_trees;
use bvhscope::render::display::effective_range;
use bvhscope::render::integrate::render;
use bvhscope::render::measure::{RayFigures, count_rays};
use bvhscope::render::overlay::{draw_boxes, first_hit_distances};
use bvhscope::render::ray_costs::ray_costs;
use bvhscope::render::{CountKind, Film, Overlay, OverlaySettings, RenderSettings, View};
use bvhscope::scene::{Scene, SceneRef, builtin};
use bvhscope::session::Session;
use bvhscope::task::Task;
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
    let overlay = draw_boxes(&world, &camera, &boxes, &depth, 96, 54, &task).expect("nobody cancels");
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
    Measured {
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
    pub animating: bool,
    pub compare: Option<CompareViews>,
    pub range_locked: bool,
    pub table: TableState,
    pub sweep: SweepState,
    pub marked: Option<Marked>,
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
        Self {
            session,
            loaded: true,
            world: Some(Arc::clone(&m.world)),
            table: m.table.clone(),
            sweep: m.sweep.clone(),
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
            animating: false,
            compare: None,
            range_locked: false,
            table: TableState::default(),
            sweep: SweepState::default(),
            marked: None,
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
            overlay: m.map(|m| &m.overlay),
            rays: m.map(|m| &m.rays),
            forecast: m.and_then(|m| m.forecasts.last()),
            forecasts: m.map_or(&[], |m| &m.forecasts),
            bin_curve: m.map_or(&NO_CURVE, |m| &m.bin_curve),
            table: &self.table,
            sweep: &self.sweep,
            shadow: m.map_or(&NO_SHADOW, |m| &m.shadow),
            compare: self.compare,
            render: RenderStatus { samples: 12, size: [960, 540], ..RenderStatus::default() },
        }
    }

    fn apply(&mut self, command: Command) {
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
            Command::ShadowPreset => "shadow preset".to_owned(),
            _ => "another".to_owned(),
        };
        self.asked.push(text);
    }

    pub fn path_chosen(&mut self, target: SaveTarget, path: PathBuf) {
        self.panels.path_chosen(target, path);
    }
}
