//! What each action asks for.

use super::{Action, Around};
use crate::app::commands::{Asked, Command, Hide};
use crate::app::inspection::RayView;
use crate::app::panels::PanelKind;
use crate::app::selection::Go;
use crate::app::view::AppView;
use crate::app::{menu, tours};
use crate::render::View;
use crate::scene::SceneRef;
use crate::scene::builtin::SCENES;

impl Action {
    /// What it asks for, as things stand.
    pub fn command(self, around: &Around) -> Command {
        let Around { view, .. } = around;
        match self {
            Self::Open => Command::AskOpen,
            Self::ImportTree => Command::AskImport,
            Self::SaveSession => menu::ask_save_session(view),
            Self::Export => Command::ShowPanel { panel: PanelKind::Export, shown: true },
            Self::Quit => Command::Ask(Asked::Quit),
            Self::Undo => Command::Ask(Asked::Undo),
            Self::Redo => Command::Ask(Asked::Redo),
            Self::CopyCamera => Command::Ask(Asked::CopyCamera),
            Self::PasteCamera => Command::Ask(Asked::PasteCamera),
            Self::FrameSelection => Command::FrameSelection,
            Self::FrameScene => Command::FrameScene,
            Self::GoUp => Command::GoSelection(Go::Up),
            Self::GoDown => Command::GoSelection(Go::Down),
            Self::GoBack => Command::GoSelection(Go::Back),
            Self::GoForward => Command::GoSelection(Go::Forward),
            Self::Deselect => Command::ClearSelection,
            Self::HideSelection => Command::Hide(Hide::Selected),
            Self::ShowSelectionOnly => Command::Hide(Hide::Others),
            Self::ShowAll => Command::Hide(Hide::Nothing),
            Self::NextRay => Command::StepRay { forward: true },
            Self::PreviousRay => Command::StepRay { forward: false },
            Self::StepOn => step_to(view, |step, count| (step + 1).min(count)),
            Self::StepBack => step_to(view, |step, _| step.saturating_sub(1)),
            Self::ResetCamera => Command::ResetCamera,
            Self::AddBookmark => Command::Ask(Asked::AddBookmark),
            Self::Pause => Command::SetPaused(!view.render.paused),
            Self::Boxes => toggle_boxes(),
            Self::Animate => Command::SetAnimating(!view.animating),
            Self::EndComparison => Command::SetCompareViews(None),
            Self::FalseShadow => Command::ShadowPreset,
            Self::Ground => Command::Edit(Box::new(|session| session.ground = !session.ground)),
            Self::MeasureTable => Command::Ask(Asked::MeasureTable),
            Self::TourOn => Command::Ask(Asked::Tour(tours::Go::On)),
            Self::TourBack => Command::Ask(Asked::Tour(tours::Go::Back)),
            Self::LeaveTour => Command::Ask(Asked::Tour(tours::Go::Leave)),
            Self::EndTour => Command::Ask(Asked::Tour(tours::Go::End)),
            Self::TakeTour(index) => Command::Ask(Asked::Tour(tours::Go::Begin(index))),
            Self::Palette => Command::Ask(Asked::Palette),
            Self::Shortcuts => Command::Ask(Asked::Shortcuts),
            Self::Dark => Command::SetDark(true),
            Self::Light => Command::SetDark(false),
            Self::ResetLayout => Command::ResetLayout,
            Self::ReopenAtStart => Command::Ask(Asked::ReopenAtStart(!around.reopens)),
            Self::OpenBuiltin(index) => Command::OpenScene(SceneRef::Builtin(SCENES[index].0.to_owned())),
            // The list may have become shorter meanwhile; then what is open is opened again.
            Self::OpenRecent(index) => {
                Command::OpenScene(view.recent.get(index).unwrap_or(&view.session.scene.reference).clone())
            }
            Self::GoToBookmark(index) => {
                Command::Edit(Box::new(move |session| session.go_to_bookmark(index)))
            }
            Self::ShowView(shown) => show_view(shown),
            Self::UseBuilder(builder) => Command::Edit(Box::new(move |session| {
                session.set_tree(None);
                session.build_mut().builder = builder;
            })),
            Self::UseColors(map) => Command::Edit(Box::new(move |session| session.display.colormap = map)),
            Self::ShowPanel(panel) => Command::ShowPanel { panel, shown: !around.layout.is_showing(panel) },
        }
    }
}

/// Another step of the ray that is looked at.
fn step_to(view: &AppView, next: fn(usize, usize) -> usize) -> Command {
    let (step, count) = view.inspection.step();
    let ray_view = RayView { step: next(step, count), playing: false, ..view.inspection.view };
    Command::SetRayView(ray_view)
}

/// Boxes on, as they were, or off.
pub fn toggle_boxes() -> Command {
    Command::Edit(Box::new(|session| {
        session.overlay.depths = match session.overlay.depths {
            Some(_) => None,
            None => Some(crate::app::DEFAULT_BOXES),
        };
    }))
}

/// One view in the viewport.
pub fn show_view(view: View) -> Command {
    Command::Edit(Box::new(move |session| session.view = view))
}
