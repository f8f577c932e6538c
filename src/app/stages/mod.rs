//! The stages of a frame that have to do with jobs, one file a kind of work: each receives what has finished, and starts
//! what the state asks for and has not got.

mod build;
pub mod curve;
pub mod export;
mod figures;
mod forecast;
pub mod load;
mod overlay;
mod picture;
mod shadow;
pub mod sweep;
pub mod table;

use std::time::Instant;

use super::jobs::bin_curve::{self, CurveJob};
use super::jobs::build::BuildJob;
use super::jobs::dialog::Dialogs;
use super::jobs::export::ExportJob;
use super::jobs::figures::FiguresJob;
use super::jobs::forecast::ForecastJob;
use super::jobs::load::LoadJob;
use super::jobs::overlay::OverlayJob;
use super::jobs::present::PresentJob;
use super::jobs::render::Renderer;
use super::jobs::shadow::ShadowJob;
use super::jobs::sweep::SweepJob;
use super::jobs::table::TableJob;
use super::jobs::{Context, TreeKey};
use super::layout::Layout;
use super::panels::PanelKind;
use super::state::State;

pub use picture::RenderMemo;

/// Every job of the window, and what each was last asked for, so that nothing is asked for twice.
pub struct Jobs {
    pub context: Context,
    pub load: LoadJob,
    pub build: BuildJob,
    pub renderer: Renderer,
    pub present: PresentJob,
    pub overlay: OverlayJob,
    pub figures: FiguresJob,
    pub forecast: ForecastJob,
    pub curve: CurveJob,
    pub table: TableJob,
    pub sweep: SweepJob,
    pub shadow: ShadowJob,
    pub export: ExportJob,
    pub dialogs: Dialogs,
    pub memo: Memo,
}

/// What was last asked for.
#[derive(Default)]
pub struct Memo {
    pub loads: u64,
    /// The tree that was last asked for. After a cancel it stays, so that the build is not started again.
    pub build: Option<TreeKey>,
    pub render: Option<RenderMemo>,
    pub overlay: overlay::OverlayMemo,
    pub figures: Option<super::jobs::figures::FiguresKey>,
    forecast: forecast::ForecastMemo,
    pub curve: curve::CurveMemo,
    pub table: table::TableMemo,
    pub sweep: sweep::SweepMemo,
    pub shadow: Option<super::jobs::shadow::ShadowKey>,
    pub export: export::ExportMemo,
}

/// Which panels are drawn: what nobody looks at is not computed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Showing {
    pub cost: bool,
    pub table: bool,
    pub shadows: bool,
}

impl Showing {
    pub fn of(layout: &Layout) -> Self {
        Self {
            cost: layout.is_showing(PanelKind::Cost),
            table: layout.is_showing(PanelKind::Table),
            shadows: layout.is_showing(PanelKind::Shadows),
        }
    }
}

/// The circumstances of one frame.
#[derive(Clone, Copy, Debug)]
pub struct Now {
    pub time: Instant,
    pub showing: Showing,
    /// Takes one sample a picture and starts nothing on its own that takes long.
    pub hold: bool,
}

impl Jobs {
    pub fn new(window: egui::Context, threads: usize) -> Self {
        let context = Context::new(window, threads);
        let renderer = Renderer::start(&context);
        Self {
            context,
            renderer,
            load: super::jobs::load::job(),
            build: super::jobs::build::job(),
            present: super::jobs::present::job(),
            overlay: super::jobs::overlay::job(),
            figures: super::jobs::figures::job(),
            forecast: super::jobs::forecast::job(),
            curve: bin_curve::job(),
            table: super::jobs::table::job(),
            sweep: super::jobs::sweep::job(),
            shadow: super::jobs::shadow::job(),
            export: super::jobs::export::job(),
            dialogs: Dialogs::default(),
            memo: Memo::default(),
        }
    }

    /// Receives finished work.
    pub fn receive(&mut self, state: &mut State, now: &Now) {
        load::receive(self, state);
        build::receive(self, state);
        picture::receive(self, state);
        overlay::receive(self, state);
        figures::receive(self, state);
        forecast::receive(self, state);
        curve::receive(self, state);
        table::receive(self, state, now);
        sweep::receive(self, state);
        shadow::receive(self, state);
        export::receive(self, state);
        self.report_bugs(state);
        state.measuring = self.context.gate.is_leased();
    }

    /// Starts what the state asks for and has not got, or has not asked for yet.
    pub fn start(&mut self, state: &mut State, now: &Now) {
        self.context.set_threads(state.session.render.threads);
        build::start(self, state);
        picture::start(self, state, now);
        overlay::start(self, state, now);
        figures::start(self, state, now);
        forecast::start(self, state, now);
        curve::start(self, state, now);
        table::start(self, state, now);
        sweep::start(self, state, now);
        shadow::start(self, state, now);
        state.loading = self.load.status(|r| r.what());
        state.building = self.build.status(|r| super::jobs::build::what(&r.session));
        state.exporting = self.export.status(|r| r.what());
    }

    /// Nothing runs, waits, or was asked for and not delivered.
    pub fn is_idle(&self) -> bool {
        self.load.is_idle()
            && self.build.is_idle()
            && self.renderer.is_idle()
            && self.present.is_idle()
            && self.overlay.is_idle()
            && self.figures.is_idle()
            && self.forecast.is_idle()
            && self.curve.is_idle()
            && self.table.is_idle()
            && self.sweep.is_idle()
            && self.shadow.is_idle()
            && self.export.is_idle()
            && self.memo.export.is_empty()
    }

    /// A job that ran into a bug of the program says so in the window; the others go on.
    fn report_bugs(&mut self, state: &mut State) {
        let failures = [
            ("opening", self.load.take_failure()),
            ("building the tree", self.build.take_failure()),
            ("rendering", self.renderer.take_failure()),
            ("showing the picture", self.present.take_failure()),
            ("drawing the boxes", self.overlay.take_failure()),
            ("counting rays", self.figures.take_failure()),
            ("measuring predictions", self.forecast.take_failure()),
            ("measuring the bins", self.curve.take_failure()),
            ("measuring the table", self.table.take_failure()),
            ("sweeping", self.sweep.take_failure()),
            ("counting shadows", self.shadow.take_failure()),
            ("exporting", self.export.take_failure()),
        ];
        for (what, failure) in failures {
            if let Some(failure) = failure {
                eprintln!("bvhscope: {what}: {failure}");
                state.messages.error(format!(
                    "A bug in bvhscope stopped {what}. What is open stays; please report it with the scene and what the \
                     terminal says."
                ));
            }
        }
    }
}
