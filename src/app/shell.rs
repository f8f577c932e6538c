//! The program behind the window: one frame is receive finished work, draw panels, apply commands, start work.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::{CentralPanel, Frame, Margin, Panel, Ui};
use serde::{Deserialize, Serialize};

use super::actions::Around;
use super::apply::Target;
use super::autosave::{self, Autosave};
use super::commands::{Asked, Command, Commands};
use super::dock::{self, Dock};
use super::jobs::load::{Source, short_name};
use super::layout::Layout;
use super::panels::Panels;
use super::popups::Popups;
use super::screenshot::{Screenshot, ScreenshotJob};
use super::stages::{self, Jobs, Now, Showing};
use super::state::{SETTLE, State};
use super::tours::Touring;
use super::undo::Undo;
use super::viewport::Viewport;
use super::{DEFAULT_BOXES, menu, shortcuts, status, theme, toolbar, tours};
use crate::scene::SceneRef;
use crate::session::Session;

/// Changes with the form of [`Settings`].
const SETTINGS_KEY: &str = "bvhscope_settings_1";

/// How the window is set up.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// Takes one sample of each picture, at full size, and starts nothing on its own that takes long: so that a test comes
    /// to rest, and sees the same on every machine.
    pub hold_progressive: bool,
    /// Shows boxes if the session has none: the first look of a user who asked for nothing else.
    pub show_boxes: bool,
    /// What went wrong before there was a window.
    pub warnings: Vec<String>,
    /// Takes a picture of the window, and closes it.
    pub screenshot: Option<Screenshot>,
    /// Where the session is kept from one run to the next; `None`: nowhere.
    pub kept_session: Option<PathBuf>,
    /// Shows the session that was kept, with these flags over it, unless the user has switched that off.
    pub reopen: Option<Vec<(&'static str, String)>>,
}

/// What is kept between runs besides the layout.
#[derive(Serialize, Deserialize)]
struct Settings {
    dark: bool,
    recent: Vec<SceneRef>,
    #[serde(default = "yes")]
    reopen: bool,
}

fn yes() -> bool {
    true
}

/// The program behind the window.
pub struct App {
    pub(super) state: State,
    jobs: Jobs,
    layout: Layout,
    panels: Panels,
    viewport: Viewport,
    commands: Commands,
    options: AppOptions,
    screenshot: Option<ScreenshotJob>,
    popups: Popups,
    undo: Undo,
    autosave: Autosave,
    title: String,
    /// When the moving scene was last moved on.
    moved_on: Option<Instant>,
}

impl App {
    /// Starts to open the session's scene. Works without a window, too.
    pub fn new(cc: &eframe::CreationContext<'_>, mut session: Session, options: AppOptions) -> Self {
        let settings: Option<Settings> = cc.storage.and_then(|s| eframe::get_value(s, SETTINGS_KEY));
        let dark = settings.as_ref().is_none_or(|s| s.dark);
        theme::apply(&cc.egui_ctx, dark);
        let reopens = settings.as_ref().is_none_or(|s| s.reopen);
        let kept = kept_session(&options, reopens);
        let reopened = matches!(kept, Ok(Some(_)));
        let trouble = match kept {
            Ok(kept) => {
                session = kept.unwrap_or(session);
                None
            }
            Err(message) => Some(message),
        };
        if options.show_boxes && !reopened && session.overlay.depths.is_none() {
            session.overlay.depths = Some(DEFAULT_BOXES);
        }
        let threads = session.render.threads;
        let autosave = Autosave::new(options.kept_session.clone());
        let mut app = Self {
            state: State::new(session, dark),
            jobs: Jobs::new(cc.egui_ctx.clone(), threads),
            layout: cc.storage.map_or_else(Layout::default, Layout::load),
            panels: Panels::default(),
            viewport: Viewport::default(),
            commands: Commands::default(),
            screenshot: options.screenshot.clone().map(ScreenshotJob::new),
            options,
            popups: Popups::default(),
            undo: Undo::default(),
            autosave,
            title: String::new(),
            moved_on: None,
        };
        app.state.hold = app.options.hold_progressive;
        app.state.recent = settings.map(|s| s.recent).unwrap_or_default();
        (app.state.reopen_at_start, app.state.reopened) = (reopens, reopened);
        for warning in app.options.warnings.clone().into_iter().chain(trouble) {
            app.state.messages.error(warning);
        }
        stages::load::open(&mut app.jobs, &app.state, Source::Current);
        app
    }

    /// What the window knows; for tests.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Where the panels lie; for tests.
    pub fn layout_mut(&mut self) -> &mut Layout {
        &mut self.layout
    }

    /// Asks for a change, as a panel does; it is applied in the next frame.
    pub fn push(&mut self, command: Command) {
        self.commands.push(command);
    }

    /// Nothing runs, and nothing was asked for that is not there yet.
    pub fn is_idle(&self) -> bool {
        let now = self.now();
        self.jobs.is_idle()
            && !stages::curve::waits(&self.jobs, &now)
            && !stages::table::waits(&self.jobs, &now)
            && !stages::sweep::waits(&self.jobs)
            && self.autosave.is_idle()
            && !self.state.touring.as_ref().is_some_and(Touring::is_pending)
    }

    fn now(&self) -> Now {
        Now { time: Instant::now(), showing: Showing::of(&self.layout), hold: self.options.hold_progressive }
    }

    /// Moves an animated scene on, once its last moment was built and seen.
    fn animate(&mut self, now: &Now) {
        let Some(before) = self.moved_on.filter(|_| self.state.animating) else {
            self.moved_on = self.state.animating.then_some(now.time);
            return;
        };
        // Where only other states are shown, nothing is to be waited for.
        let shown = self.state.active_slot().is_none_or(|slot| {
            self.state.picture(slot).is_some_and(|picture| {
                self.state.document.as_ref().is_some_and(|d| picture.frame.key.scene == d.tree.scene)
            })
        });
        if self.jobs.build.is_idle() && (shown || self.state.paused) {
            self.state.session.time += (now.time - before).as_secs_f32();
            self.undo.time_flows(self.state.session.time);
            self.moved_on = Some(now.time);
        }
    }

    fn read_keys(&mut self, ui: &Ui) {
        ui.input(|i| {
            self.undo.mouse(i.pointer.any_pressed(), i.pointer.any_down() || i.pointer.any_released())
        });
        match self.popups.pasted(ui.ctx()) {
            None => {}
            Some(Ok(text)) => self.commands.push(Command::Ask(Asked::UseCamera(text))),
            Some(Err(message)) => self.state.messages.error(message),
        }
        if self.popups.finder.is_some() {
            return;
        }
        let view = self.state.view();
        let around = Around {
            view: &view,
            layout: &self.layout,
            undo: &self.undo,
            reopens: self.state.reopen_at_start,
        };
        for action in shortcuts::read(ui, &around) {
            self.commands.push(action.command(&around));
        }
    }

    fn draw(&mut self, ui: &mut Ui) {
        let bar = |ui: &Ui| Frame::NONE.fill(ui.visuals().panel_fill).inner_margin(Margin::symmetric(8, 4));
        let frame = bar(ui);
        {
            let view = self.state.view();
            let commands = &mut self.commands;
            let around = Around {
                view: &view,
                layout: &self.layout,
                undo: &self.undo,
                reopens: self.state.reopen_at_start,
            };
            let menu = Panel::top("menu").frame(frame).show_separator_line(false);
            menu.show(ui, |ui| menu::ui(ui, &around, commands));
            tours::ui(ui, &around, commands);
            Panel::top("toolbar").frame(frame).show(ui, |ui| toolbar::ui(ui, &view, commands));
            Panel::bottom("status").frame(frame).show(ui, |ui| status::line(ui, &view, commands));
        }
        let central = Frame::NONE.fill(ui.visuals().panel_fill);
        let output = CentralPanel::default()
            .frame(central)
            .show(ui, |ui| {
                let dock = Dock {
                    state: &self.state,
                    viewport: &mut self.viewport,
                    panels: &mut self.panels,
                    commands: &mut self.commands,
                };
                dock::ui(ui, &mut self.layout, dock)
            })
            .inner;
        self.state.hover = output.and_then(|o| o.hover);
        if let Some(output) = output {
            self.adopt_size(output.size);
        }
        self.draw_messages(ui);
        let view = self.state.view();
        let around = Around {
            view: &view,
            layout: &self.layout,
            undo: &self.undo,
            reopens: self.state.reopen_at_start,
        };
        self.popups.ui(ui, &around, &mut self.commands);
        paint_drop_target(ui);
    }

    fn draw_messages(&mut self, ui: &Ui) {
        let mut messages = std::mem::take(&mut self.state.messages);
        let view = self.state.view();
        status::messages(ui, &view, &mut messages);
        self.state.messages = messages;
    }

    /// The picture follows the viewport, and the session says the size of the picture.
    fn adopt_size(&mut self, size: [u32; 2]) {
        if self.state.viewport != size {
            self.state.viewport = size;
            let [width, height] = size;
            if width > 0 && height > 0 {
                let render = &mut self.state.session.render;
                (render.width, render.height) = (width, height);
            }
            // A divider that is dragged is like a camera that moves.
            let now = Instant::now();
            self.state.camera_moved = Some(now);
            self.state.last_change = now;
        }
    }

    fn apply_commands(&mut self, ctx: &egui::Context) {
        let commands = self.commands.take();
        let dropped: Vec<_> =
            ctx.input(|i| i.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let mut target = Target {
            state: &mut self.state,
            jobs: &mut self.jobs,
            layout: &mut self.layout,
            panels: &mut self.panels,
            undo: &mut self.undo,
            popups: &mut self.popups,
            ctx,
        };
        for command in commands {
            target.apply(command);
        }
        target.go_on_with_tour();
        target.take_dialog_answers();
        // Of several files at once the last one would stay anyway.
        if let Some(path) = dropped.into_iter().next_back() {
            target.open_path(path);
        }
        self.undo.observe(&self.state, Instant::now());
    }

    /// Asks for the frames that nothing else will ask for.
    fn schedule(&mut self, ctx: &egui::Context, now: &Now) {
        let after = |delay: Duration| ctx.request_repaint_after(delay);
        if let Some(delay) = self.state.messages.expire(now.time) {
            after(delay);
        }
        if self.state.animating {
            after(Duration::from_millis(15));
        } else if self.state.is_moving(now.time) {
            after(SETTLE);
        }
        let state = &self.state;
        let statuses =
            [&state.loading, &state.building, &state.exporting, &state.table.running, &state.sweep.running];
        let ab = [&state.ab.panel.building, &state.ab.panel.measuring];
        if statuses.into_iter().chain(ab).any(Option::is_some) {
            after(Duration::from_millis(100));
        }
        let waits = stages::table::waits(&self.jobs, now)
            || stages::curve::waits(&self.jobs, now)
            || stages::sweep::waits(&self.jobs);
        if waits {
            after(Duration::from_millis(200));
        }
        if self.state.player.view.playing {
            after(Duration::from_secs_f32((0.5 / self.state.player.view.speed).clamp(0.015, 0.5)));
        }
        if self.state.inspection.view.playing {
            after(Duration::from_secs_f32(0.5 / self.state.inspection.view.speed.max(1.0)));
        }
    }

    fn set_title(&mut self, ctx: &egui::Context) {
        let title = match &self.state.document {
            Some(_) => format!("{} - bvhscope", short_name(&self.state.session.scene.reference)),
            None => "bvhscope".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, _: &egui::Context, _: &mut eframe::Frame) {
        let now = self.now();
        self.jobs.receive(&mut self.state, &now);
        self.animate(&now);
        self.jobs.start(&mut self.state, &now);
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.read_keys(ui);
        self.draw(ui);
        let ctx = ui.ctx().clone();
        self.apply_commands(&ctx);
        let now = self.now();
        self.jobs.start(&mut self.state, &now);
        self.set_title(&ctx);
        self.schedule(&ctx, &now);
        if let Some(delay) = self.autosave.update(&self.jobs.context, &mut self.state, now.time) {
            ctx.request_repaint_after(delay);
        }
        if let Some(screenshot) = &mut self.screenshot {
            screenshot.update(&ctx, &self.state);
        }
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.layout.save(storage);
        let settings = Settings {
            dark: self.state.dark,
            recent: self.state.recent.clone(),
            reopen: self.state.reopen_at_start,
        };
        eframe::set_value(storage, SETTINGS_KEY, &settings);
    }

    fn on_exit(&mut self, _: Option<&eframe::glow::Context>) {
        self.autosave.finish(&self.state);
    }
}

/// The session of last time, if it is wanted and there is one.
fn kept_session(options: &AppOptions, reopens: bool) -> Result<Option<Session>, String> {
    match (&options.kept_session, &options.reopen) {
        (Some(path), Some(flags)) if reopens => autosave::read(path, flags),
        _ => Ok(None),
    }
}

/// Says that a file which is dragged over the window can be dropped.
fn paint_drop_target(ui: &Ui) {
    if ui.input(|i| i.raw.hovered_files.is_empty()) {
        return;
    }
    let rect = ui.ctx().content_rect();
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("bvhscope drop target"));
    let painter = ui.ctx().layer_painter(layer);
    painter.rect_filled(rect, 0.0, egui::Color32::from_black_alpha(170));
    painter.text(
        rect.center(),
        egui::Align2::CENTER_CENTER,
        "Drop to open: a model, a session, a PNG that carries one, or a tree",
        egui::FontId::proportional(18.0),
        egui::Color32::WHITE,
    );
}
