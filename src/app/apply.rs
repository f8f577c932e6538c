//! Commands become changes: of the state, of the layout, or jobs that start.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;

use super::commands::{Command, ExportRequest, Hide, Mark, SaveTarget};
use super::inspection::{RayOrigin, RayView};
use super::jobs::dialog::{DialogAnswer, Purpose};
use super::jobs::load::Source;
use super::layout::Layout;
use super::panels::{PanelKind, Panels};
use super::popups::Popups;
use super::selection::{Go, Pick};
use super::stages::{self, Jobs};
use super::state::State;
use super::theme;
use super::theme::Palette;
use super::undo::Undo;
use super::view::Marked;
use crate::export::session_file;
use crate::export::tree_file::is_tree_path;
use crate::inspect::node::shapes_below;
use crate::render::View;
use crate::scene::{Camera, SceneRef, ShadowRule, UpAxis};
use crate::session::{Session, SessionScene};

/// Sees the glass cuboid of the default scene and all of its shadow, in a picture of any shape.
const FALSE_SHADOW: Camera = Camera {
    eye: Vec3::new(0.1, 1.75, 2.8),
    target: Vec3::new(-1.3, 0.42, 0.3),
    fov_y_degrees: 46.0,
    up: UpAxis::Y,
};

/// Everything that a command may change.
pub struct Target<'a> {
    pub state: &'a mut State,
    pub jobs: &'a mut Jobs,
    pub layout: &'a mut Layout,
    pub panels: &'a mut Panels,
    pub undo: &'a mut Undo,
    pub popups: &'a mut Popups,
    pub ctx: &'a egui::Context,
}

impl Target<'_> {
    pub fn apply(&mut self, command: Command) {
        match command {
            Command::Edit(change) => self.edit(change),
            Command::HoldRange(held) => self.hold_range(held),
            Command::OpenScene(scene) => self.open(Source::Scene(scene)),
            Command::OpenSession(path) => self.open(Source::SessionFile(path)),
            Command::SaveSession(path) => self.save_session(path),
            Command::ImportTree(path) => self.open(Source::Tree(path)),
            Command::AskImport => self.jobs.dialogs.ask_import(&self.jobs.context),
            Command::BuildOwnTree => self.edit(Box::new(|session| session.set_tree(None))),
            Command::Mark(mark) => self.mark(mark),
            Command::FrameMarked => self.frame_marked(),
            Command::Select { pick, add } => self.select(pick, add),
            Command::SetRegion(region) => self.state.region = region,
            Command::GoToPixel(pixel) => self.go_to_pixel(pixel),
            Command::Hide(what) => self.hide(what),
            Command::ClearSelection => self.state.selections.clear(),
            Command::GoSelection(way) => self.go(way),
            Command::FrameSelection => self.frame_selection(),
            Command::SetTreeView(view) => self.state.tree_view = view,
            Command::SetRayView(view) => self.state.inspection.view = view,
            Command::SetSplitView(view) => self.state.splitting.set(view),
            Command::SetPlayerView(view) => self.state.player.view = view,
            Command::StepRay { forward } => self.step_ray(forward),
            Command::LookAtRay => self.look_at_ray(),
            Command::AskOpen => self.jobs.dialogs.ask_open(&self.jobs.context),
            Command::AskSavePath { target, suggested } => {
                self.jobs.dialogs.ask_save(&self.jobs.context, target, &suggested);
            }
            Command::AskSaveSession { suggested } => {
                self.jobs.dialogs.ask_save_session(&self.jobs.context, &suggested);
            }
            Command::SetAnimating(animating) => self.set_animating(animating),
            Command::CancelLoad => self.jobs.load.cancel(),
            Command::CancelBuild => self.cancel_build(),
            Command::FrameScene => self.frame_scene(),
            Command::ResetCamera => self.reset_camera(),
            Command::SetPaused(paused) => self.state.paused = paused,
            Command::MeasureTable => self.jobs.memo.table.wanted = true,
            Command::CancelTable => stages::table::cancel(self.jobs, self.state),
            Command::StartSweep(plan) => stages::sweep::begin(self.jobs, self.state, *plan),
            Command::SetSweepPaused(paused) => stages::sweep::set_paused(self.jobs, paused),
            Command::ClearSweep => stages::sweep::clear(self.jobs, self.state),
            Command::ShadowPreset => self.shadow_preset(),
            Command::SetCompareViews(compare) => {
                self.changed();
                self.state.compare = compare;
            }
            Command::ActivateVariant(index) => self.activate_variant(index),
            Command::TimeComparison => stages::ab::time_frames(self.state),
            Command::Export(request) => self.export(request),
            Command::CancelExport => stages::export::cancel(self.jobs, self.state),
            Command::CopyText { text, what } => {
                self.ctx.copy_text(text);
                self.state.messages.say(format!("Copied: {what}"));
            }
            Command::Report { message, error: true } => self.state.messages.error(message),
            Command::Report { message, error: false } => self.state.messages.say(message),
            Command::SetDark(dark) => self.set_dark(dark),
            Command::ResetLayout => *self.layout = Layout::default(),
            Command::ShowPanel { panel, shown } => self.layout.show(panel, shown),
            Command::Ask(asked) => self.ask(asked),
        }
    }

    /// Opens a file by what it is: a session, or a model.
    pub fn open_path(&mut self, path: PathBuf) {
        if session_file::is_session_path(&path) {
            self.open(Source::SessionFile(path));
        } else if is_tree_path(&path) {
            self.open(Source::Tree(path));
        } else {
            self.open(Source::Scene(SceneRef::File(path)));
        }
    }

    pub fn take_dialog_answers(&mut self) {
        for answer in self.jobs.dialogs.poll() {
            match answer {
                DialogAnswer::Open(path) => self.open_path(path),
                // It was asked for by the plot's own menu.
                DialogAnswer::Save(SaveTarget::Plot, path) => {
                    self.export(ExportRequest::Plot { path: with_extension(path, "svg") });
                }
                DialogAnswer::Save(target, path) => {
                    let path = with_extension(path, target.extensions()[0]);
                    self.panels.path_chosen(target, path);
                }
                DialogAnswer::SaveSession(path) => self.save_session(path),
                DialogAnswer::Unavailable(purpose) => self.go_without_dialog(purpose),
            }
        }
    }

    /// There are fields for paths, too.
    fn go_without_dialog(&mut self, purpose: Purpose) {
        let (panel, what) = match purpose {
            Purpose::Open => {
                (PanelKind::Scene, "Type the path into the Scene panel, or drop the file on the window.")
            }
            Purpose::Save => (PanelKind::Export, "Type the path into the Export panel."),
        };
        self.layout.show(panel, true);
        self.state.messages.error(format!(
            "The system has no file dialog to show: it needs an XDG desktop portal, or zenity. {what}"
        ));
    }

    fn save_session(&mut self, path: PathBuf) {
        self.changed();
        stages::export::save_session(self.jobs, self.state, with_extension(path, "ron"));
    }

    pub(super) fn edit(&mut self, change: Box<dyn FnOnce(&mut Session) + Send>) {
        let before = self.state.session.clone();
        let camera = self.state.camera();
        change(&mut self.state.session);
        if self.state.session == before {
            return;
        }
        if let Err(error) = self.state.session.build().check() {
            self.state.messages.error(format!("{error}; the setting stays as it was."));
            self.state.session = before;
            return;
        }
        // A camera that the user has placed only tilts.
        if self.state.session.up != before.up && before.camera.is_none() {
            self.state.session.camera = self.own_camera();
        }
        if self.state.camera() != camera {
            self.state.camera_moved = Some(Instant::now());
        }
        self.changed();
    }

    pub(super) fn changed(&mut self) {
        self.state.last_change = Instant::now();
    }

    fn reset_camera(&mut self) {
        let camera = self.own_camera();
        self.edit(Box::new(move |session| session.camera = camera));
    }

    /// The camera that the scene came with (`None`), or for a model that was told another axis to point up, one that
    /// frames it anew.
    fn own_camera(&self) -> Option<Camera> {
        let document = self.state.document.as_ref()?;
        let up = self.state.session.up;
        let is_file = matches!(self.state.session.scene.reference, SceneRef::File(_));
        (is_file && document.still.camera.up != up)
            .then(|| Camera::framing(&document.world.tree.bounds(), up))
    }

    fn hold_range(&mut self, held: bool) {
        if !held {
            self.state.held_range = None;
        } else if self.state.held_range.is_none() {
            self.state.held_range = self.state.picture(0).and_then(|p| p.frame.presented.range);
        }
    }

    /// Opens what somebody asked for, which ends a tour.
    fn open(&mut self, source: Source) {
        self.state.touring = None;
        self.open_quietly(source);
    }

    pub(super) fn open_quietly(&mut self, source: Source) {
        self.changed();
        stages::load::open(self.jobs, self.state, source);
    }

    fn set_animating(&mut self, animating: bool) {
        self.state.animating = animating;
        self.changed();
    }

    fn frame_scene(&mut self) {
        let Some(document) = &self.state.document else { return };
        let camera = Camera::framing(&document.world.tree.bounds(), self.state.session.up);
        self.edit(Box::new(move |session| session.camera = Some(camera)));
    }

    fn mark(&mut self, mark: Option<Mark>) {
        let world = self.state.document.as_ref().map(|document| &document.world);
        self.state.marked = mark.and_then(|mark| Marked::of(mark, world?));
        self.changed();
    }

    pub(super) fn select(&mut self, pick: Pick, add: bool) {
        let Some(document) = &self.state.document else { return };
        let seen = self.state.visible_world().unwrap_or(&document.world);
        let seen = Arc::clone(seen);
        self.state.selections.pick(&document.world, &seen, document.tree, pick, add);
        // Nothing under the mouse has no rays worth a look, but for the camera ray itself.
        if let Pick::Pixel { camera, pixel, .. } = pick {
            let origin = Some(RayOrigin::Pixel { camera, pixel });
            self.state.inspection.view = RayView { origin, ..self.state.inspection.view };
        }
    }

    pub(super) fn go_to_pixel(&mut self, pixel: [u32; 2]) {
        if let (Some(camera), Some(size)) = (self.state.camera(), self.state.picture_size()) {
            self.select(Pick::Pixel { camera, size, pixel }, false);
        }
    }

    fn hide(&mut self, what: Hide) {
        let Some(document) = &self.state.document else { return };
        let nodes = self.state.selections.current().map_or(&[][..], |selection| &selection.nodes);
        let shapes = shapes_below(document.world.shown_tree(), nodes);
        match what {
            Hide::Selected => self.state.hidden.hide(&shapes),
            Hide::Others => self.state.hidden.show_only(&shapes, document.world.scene.shape_count()),
            Hide::Nothing => self.state.hidden.show_all(),
        }
        self.changed();
    }

    fn go(&mut self, way: Go) {
        let census = self.state.census().map(Arc::clone);
        self.state.selections.go(way, census.as_ref().map(|census| &census.family));
    }

    fn step_ray(&mut self, forward: bool) {
        let inspection = &mut self.state.inspection;
        if let Some(found) = &inspection.found {
            let chosen = found.neighbour(inspection.view.chosen, forward);
            inspection.view = RayView { chosen, step: usize::MAX, playing: false, ..inspection.view };
        }
    }

    fn look_at_ray(&mut self) {
        let Some(document) = &self.state.document else { return };
        let Some(ray) = self.state.inspection.ray() else { return };
        let size = document.world.tree.bounds().extent().length();
        let end = ray.ray.at(ray.t.unwrap_or(size / ray.ray.direction.length()));
        let camera = Camera::aside(ray.ray.origin, end, self.state.session.up);
        self.edit(Box::new(move |session| session.camera = Some(camera)));
    }

    fn frame_selection(&mut self) {
        let bounds = self.state.selected_bounds().into_iter().map(|(_, bounds)| bounds);
        match bounds.reduce(|a, b| a.union(b)) {
            Some(bounds) => {
                let camera = Camera::framing(&bounds, self.state.session.up);
                self.edit(Box::new(move |session| session.camera = Some(camera)));
            }
            None => self.frame_scene(),
        }
    }

    fn frame_marked(&mut self) {
        let Some(bounds) = self.state.marked.as_ref().and_then(Marked::around) else { return };
        let camera = Camera::framing(&bounds, self.state.session.up);
        self.edit(Box::new(move |session| session.camera = Some(camera)));
    }

    /// The false shadow: the glass of the default scene on its glossy floor, and where the two answers differ.
    fn shadow_preset(&mut self) {
        self.state.animating = false;
        self.state.compare = None;
        if self.state.session.scene.reference == SceneRef::default() {
            self.edit(Box::new(show_false_shadow));
        } else {
            let mut session = self.state.session.clone();
            session.scene = SessionScene::default();
            show_false_shadow(&mut session);
            self.open(Source::Session(Box::new(session)));
        }
    }

    fn activate_variant(&mut self, index: usize) {
        if index >= self.state.session.variants.len() {
            return;
        }
        let session = self.state.session.activated(index);
        if session.scene.reference == self.state.session.scene.reference {
            self.edit(Box::new(move |target| *target = session));
        } else {
            self.open(Source::Session(Box::new(Session { camera: None, ..session })));
        }
    }

    fn cancel_build(&mut self) {
        if self.jobs.build.running().is_some() {
            self.jobs.build.cancel();
            self.state.messages.say("The build was cancelled; picture and figures show the tree before.");
        }
    }

    /// What is asked for comes before what is measured in the background.
    fn export(&mut self, request: ExportRequest) {
        self.changed();
        stages::export::export(self.jobs, self.state, self.ctx, request);
    }

    fn set_dark(&mut self, dark: bool) {
        self.state.dark = dark;
        self.state.palette = Palette::of(dark);
        theme::apply(self.ctx, dark);
    }
}

/// Settings of the default scene that show the false shadow.
fn show_false_shadow(session: &mut Session) {
    session.view = View::ShadowDifference;
    session.shadow_rule = ShadowRule::Glass;
    session.camera = Some(FALSE_SHADOW);
    session.up = UpAxis::Y;
    session.ground = false;
    session.time = 0.0;
    session.overlay.depths = None;
}

/// The path with an extension if it has none.
fn with_extension(path: PathBuf, extension: &str) -> PathBuf {
    if path.extension().is_none() { path.with_extension(extension) } else { path }
}
