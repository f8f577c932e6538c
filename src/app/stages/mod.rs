//! The stages of a frame that have to do with jobs, one file a kind of work: each receives what has finished, and starts
//! what the state asks for and has not got.

pub mod ab;
mod build;
mod census;
mod construction;
pub mod curve;
pub mod export;
mod figures;
mod forecast;
pub mod load;
mod overlay;
mod picture;
mod rays;
mod region;
mod shadow;
mod splits;
pub mod sweep;
pub mod table;
mod visible;

use std::time::Instant;

use super::jobs::ab_build::AbBuildJob;
use super::jobs::ab_figures::AbFiguresJob;
use super::jobs::bin_curve::{self, CurveJob};
use super::jobs::build::BuildJob;
use super::jobs::census::CensusJob;
use super::jobs::construction::ConstructionJob;
use super::jobs::dialog::Dialogs;
use super::jobs::difference::DifferenceJob;
use super::jobs::export::ExportJob;
use super::jobs::figures::FiguresJob;
use super::jobs::forecast::ForecastJob;
use super::jobs::load::LoadJob;
use super::jobs::overlay::OverlayJob;
use super::jobs::pixel_rays::RaysJob;
use super::jobs::present::PresentJob;
use super::jobs::region::RegionJob;
use super::jobs::render::Renderer;
use super::jobs::shadow::ShadowJob;
use super::jobs::splits::SplitJob;
use super::jobs::sweep::SweepJob;
use super::jobs::table::TableJob;
use super::jobs::visible::VisibleJob;
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
    /// Of the right one of two pictures.
    pub right_overlay: OverlayJob,
    pub ab_build: AbBuildJob,
    pub ab_figures: AbFiguresJob,
    pub difference: DifferenceJob,
    pub figures: FiguresJob,
    pub forecast: ForecastJob,
    pub curve: CurveJob,
    pub table: TableJob,
    pub sweep: SweepJob,
    pub shadow: ShadowJob,
    pub census: CensusJob,
    pub rays: RaysJob,
    pub splits: SplitJob,
    pub visible: VisibleJob,
    pub region: RegionJob,
    pub construction: ConstructionJob,
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
    right_overlay: overlay::OverlayMemo,
    ab: ab::AbMemo,
    pub figures: Option<super::jobs::figures::FiguresKey>,
    forecast: forecast::ForecastMemo,
    pub curve: curve::CurveMemo,
    pub table: table::TableMemo,
    pub sweep: sweep::SweepMemo,
    pub shadow: Option<super::jobs::shadow::ShadowKey>,
    pub census: census::CensusMemo,
    pub rays: rays::RaysMemo,
    pub splits: splits::SplitMemo,
    pub visible: visible::VisibleMemo,
    pub region: region::RegionMemo,
    pub construction: construction::ConstructionMemo,
    pub export: export::ExportMemo,
}

/// Which panels are drawn: what nobody looks at is not computed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Showing {
    pub compare: bool,
    pub cost: bool,
    pub table: bool,
    pub shadows: bool,
    pub tree: bool,
    pub rays: bool,
    pub splits: bool,
    pub heatmap: bool,
    pub construction: bool,
}

impl Showing {
    pub fn of(layout: &Layout) -> Self {
        Self {
            compare: layout.is_showing(PanelKind::Compare),
            cost: layout.is_showing(PanelKind::Cost),
            table: layout.is_showing(PanelKind::Table),
            shadows: layout.is_showing(PanelKind::Shadows),
            tree: layout.is_showing(PanelKind::Tree),
            rays: layout.is_showing(PanelKind::Rays),
            splits: layout.is_showing(PanelKind::Splits),
            heatmap: layout.is_showing(PanelKind::Heatmap),
            construction: layout.is_showing(PanelKind::Construction),
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
            right_overlay: super::jobs::overlay::job(),
            ab_build: super::jobs::ab_build::job(),
            ab_figures: super::jobs::ab_figures::job(),
            difference: super::jobs::difference::job(),
            figures: super::jobs::figures::job(),
            forecast: super::jobs::forecast::job(),
            curve: bin_curve::job(),
            table: super::jobs::table::job(),
            sweep: super::jobs::sweep::job(),
            shadow: super::jobs::shadow::job(),
            census: super::jobs::census::job(),
            rays: super::jobs::pixel_rays::job(),
            splits: super::jobs::splits::job(),
            visible: super::jobs::visible::job(),
            region: super::jobs::region::job(),
            construction: super::jobs::construction::job(),
            export: super::jobs::export::job(),
            dialogs: Dialogs::default(),
            memo: Memo::default(),
        }
    }

    /// Receives finished work.
    pub fn receive(&mut self, state: &mut State, now: &Now) {
        load::receive(self, state);
        build::receive(self, state);
        ab::receive(self, state);
        picture::receive(self, state);
        overlay::receive(self, state);
        figures::receive(self, state);
        forecast::receive(self, state);
        curve::receive(self, state);
        table::receive(self, state, now);
        sweep::receive(self, state);
        shadow::receive(self, state);
        census::receive(self, state);
        rays::receive(self, state);
        splits::receive(self, state);
        visible::receive(self, state);
        region::receive(self, state);
        construction::receive(self, state);
        export::receive(self, state);
        self.report_bugs(state);
        state.measuring = self.context.gate.is_leased();
    }

    /// Starts what the state asks for and has not got, or has not asked for yet.
    pub fn start(&mut self, state: &mut State, now: &Now) {
        self.context.set_threads(state.session.render.threads);
        build::start(self, state);
        ab::start(self, state, now);
        visible::start(self, state);
        picture::start(self, state, now);
        overlay::start(self, state, now);
        figures::start(self, state, now);
        forecast::start(self, state, now);
        curve::start(self, state, now);
        table::start(self, state, now);
        sweep::start(self, state, now);
        shadow::start(self, state, now);
        census::start(self, state, now);
        rays::start(self, state, now);
        region::start(self, state, now);
        splits::start(self, state, now);
        construction::start(self, state, now);
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
            && self.right_overlay.is_idle()
            && self.ab_build.is_idle()
            && self.ab_figures.is_idle()
            && self.difference.is_idle()
            && self.figures.is_idle()
            && self.forecast.is_idle()
            && self.curve.is_idle()
            && self.table.is_idle()
            && self.sweep.is_idle()
            && self.shadow.is_idle()
            && self.census.is_idle()
            && self.rays.is_idle()
            && self.splits.is_idle()
            && self.visible.is_idle()
            && self.region.is_idle()
            && self.construction.is_idle()
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
            ("drawing the boxes of the right picture", self.right_overlay.take_failure()),
            ("building the other tree", self.ab_build.take_failure()),
            ("measuring both trees", self.ab_figures.take_failure()),
            ("subtracting the pictures", self.difference.take_failure()),
            ("counting rays", self.figures.take_failure()),
            ("measuring predictions", self.forecast.take_failure()),
            ("measuring the bins", self.curve.take_failure()),
            ("measuring the table", self.table.take_failure()),
            ("sweeping", self.sweep.take_failure()),
            ("counting shadows", self.shadow.take_failure()),
            ("looking at the nodes", self.census.take_failure()),
            ("finding the rays of a pixel", self.rays.take_failure()),
            ("weighing splits", self.splits.take_failure()),
            ("hiding shapes", self.visible.take_failure()),
            ("looking for expensive pixels", self.region.take_failure()),
            ("looking at how the tree was built", self.construction.take_failure()),
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
