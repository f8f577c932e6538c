//! The one list of what a user can ask for. Menus, keys, the page of shortcuts and the command palette are made from it.
//!
//! A new action is a variant, its place in [`Action::PLAIN`] (or a family in [`Action::all`]), an arm in
//! [`Action::info`] and one in [`Action::command`]. What it does stays in `apply`: an action only names a [`Command`](super::commands::Command).

mod command;
mod info;

use egui::{Key, KeyboardShortcut, Modifiers};

use super::layout::{Layout, Pane};
use super::panels::PanelKind;
use super::tours::{TOURS, Touring};
use super::undo::Undo;
use super::view::AppView;
use crate::accel::Builder;
use crate::render::{ColorMap, View, ViewClass};
use crate::scene::SceneRef;
use crate::scene::builtin::SCENES;

pub use command::{show_view, toggle_boxes};
pub use info::{Group, Info};

/// What actions look at: the state of the program, never changed by them.
pub struct Around<'a> {
    pub view: &'a AppView<'a>,
    pub layout: &'a Layout,
    pub undo: &'a Undo,
    /// What was shown last time is shown again at the next start.
    pub reopens: bool,
}

/// Something that a user can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Open,
    ImportTree,
    SaveSession,
    Export,
    Quit,
    Undo,
    Redo,
    CopyCamera,
    PasteCamera,
    FrameSelection,
    FrameScene,
    ResetCamera,
    AddBookmark,
    GoUp,
    GoDown,
    GoBack,
    GoForward,
    Deselect,
    HideSelection,
    ShowSelectionOnly,
    ShowAll,
    NextRay,
    PreviousRay,
    StepOn,
    StepBack,
    Pause,
    Boxes,
    Animate,
    EndComparison,
    FalseShadow,
    Ground,
    MeasureTable,
    TourOn,
    TourBack,
    LeaveTour,
    EndTour,
    Palette,
    Shortcuts,
    Dark,
    Light,
    ResetLayout,
    ReopenAtStart,
    /// By the index in [`SCENES`].
    OpenBuiltin(usize),
    /// By the index in the recent scenes, the newest first.
    OpenRecent(usize),
    /// By the index in [`TOURS`].
    TakeTour(usize),
    /// By the index in the session's bookmarks.
    GoToBookmark(usize),
    ShowView(View),
    UseBuilder(Builder),
    UseColors(ColorMap),
    ShowPanel(PanelKind),
}

/// Keys in a row, for the first of a family.
const DIGITS: [Key; 10] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
    Key::Num0,
];

/// Bookmarks that have a key.
const BOOKMARK_KEYS: usize = 9;

const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

const fn alt(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::ALT, key)
}

const fn ctrl_shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}

impl Action {
    /// Those that are there once, in the order of menus and lists.
    pub const PLAIN: [Self; 42] = [
        Self::Open,
        Self::ImportTree,
        Self::SaveSession,
        Self::Export,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::CopyCamera,
        Self::PasteCamera,
        Self::FrameSelection,
        Self::FrameScene,
        Self::ResetCamera,
        Self::AddBookmark,
        Self::GoUp,
        Self::GoDown,
        Self::GoBack,
        Self::GoForward,
        Self::Deselect,
        Self::HideSelection,
        Self::ShowSelectionOnly,
        Self::ShowAll,
        Self::NextRay,
        Self::PreviousRay,
        Self::StepOn,
        Self::StepBack,
        Self::Pause,
        Self::Boxes,
        Self::Animate,
        Self::EndComparison,
        Self::FalseShadow,
        Self::Ground,
        Self::MeasureTable,
        Self::TourOn,
        Self::TourBack,
        Self::LeaveTour,
        Self::EndTour,
        Self::Palette,
        Self::Shortcuts,
        Self::Dark,
        Self::Light,
        Self::ResetLayout,
        Self::ReopenAtStart,
    ];

    /// Every action that there is now.
    pub fn all(around: &Around) -> Vec<Self> {
        let mut all = Self::PLAIN.to_vec();
        all.extend(View::ALL.map(Self::ShowView));
        all.extend((0..around.view.session.bookmarks.len()).map(Self::GoToBookmark));
        all.extend(Builder::ALL.map(Self::UseBuilder));
        all.extend(ColorMap::ALL.map(Self::UseColors));
        all.extend(PanelKind::ALL.map(Self::ShowPanel));
        all.extend((0..TOURS.len()).map(Self::TakeTour));
        all.extend((0..SCENES.len()).map(Self::OpenBuiltin));
        all.extend((0..around.view.recent.len()).map(Self::OpenRecent));
        all
    }

    /// What menus and lists show of it.
    pub fn info(self, around: &Around) -> Info {
        use Group::{Camera, Edit, File, Learn, Picture, Rays, Select, Tree, Window};
        let Around { view, layout, undo, reopens } = around;
        let session = view.session;
        let loaded = view.scene.is_some();
        let nothing = "Nothing is open yet";
        let (selected, unselected) = (view.selections.current().is_some(), "Nothing is selected");
        let (has_rays, no_rays) = (view.inspection.found.is_some(), "No pixel's rays are looked at");
        match self {
            Self::Open => Info::new(
                File,
                "Open…",
                "A model (OBJ, PLY, STL, glTF), a session, or a PNG that carries one",
            )
            .key(ctrl(Key::O)),
            Self::ImportTree => Info::new(
                File,
                "Import tree…",
                "A tree that another program built (NPZ, JSON): checked, shown, measured and compared",
            ),
            Self::SaveSession => Info::new(
                File,
                "Save session…",
                "Scene, tree, camera, view and all settings, as a small text file",
            )
            .key(ctrl(Key::S)),
            Self::Export => {
                Info::new(File, "Export…", "Pictures, raw numbers and figures as files").key(ctrl(Key::E))
            }
            Self::Quit => Info::new(File, "Quit", "Closes the window").key(ctrl(Key::Q)),
            Self::Undo => {
                let what = undo.undo_text();
                let done = what.is_some();
                let name = what.map_or_else(|| "Undo".to_owned(), |what| format!("Undo {what}"));
                Info::new(Edit, name, "Takes the last change of a setting back")
                    .key(ctrl(Key::Z))
                    .only_if(done, "No setting was changed since the scene was opened")
            }
            Self::Redo => {
                let what = undo.redo_text();
                let undone = what.is_some();
                let name = what.map_or_else(|| "Redo".to_owned(), |what| format!("Redo {what}"));
                Info::new(Edit, name, "Makes the change again that was taken back last")
                    .key(ctrl_shift(Key::Z))
                    .key(ctrl(Key::Y))
                    .only_if(undone, "Nothing was undone")
            }
            Self::CopyCamera => Info::new(Edit, "Copy camera", "The camera as text, as --camera takes it")
                .key(ctrl_shift(Key::C))
                .only_if(loaded, nothing),
            Self::PasteCamera => {
                Info::new(Edit, "Paste camera", "Looks through a camera that was copied as text")
                    .key(ctrl_shift(Key::V))
                    .only_if(loaded, nothing)
            }
            Self::FrameSelection => Info::new(
                Camera,
                "Frame selection",
                "Moves the camera so that what is selected is seen; the whole scene if nothing is",
            )
            .key(plain(Key::F))
            .only_if(loaded, nothing),
            Self::FrameScene => {
                Info::new(Camera, "Frame scene", "Moves the camera so that the whole scene is seen")
                    .key(shift(Key::F))
                    .only_if(loaded, nothing)
            }
            Self::GoUp => {
                Info::new(Select, "Up to the parent", "Selects the node above the one that was selected last")
                    .key(plain(Key::OpenBracket))
                    .only_if(selected, unselected)
            }
            Self::GoDown => Info::new(Select, "Down again", "Towards the node from which one came up")
                .key(plain(Key::CloseBracket))
                .only_if(selected, unselected),
            Self::GoBack => Info::new(Select, "Back", "To what was selected before")
                .key(alt(Key::ArrowLeft))
                .only_if(view.selections.can_go_back(), "Nothing was selected before"),
            Self::GoForward => Info::new(Select, "Forward", "To what was selected after")
                .key(alt(Key::ArrowRight))
                .only_if(view.selections.can_go_forward(), "Nothing was selected after"),
            Self::Deselect => Info::new(Select, "Deselect", "Selects nothing")
                .key(plain(Key::Escape))
                .only_if(selected, unselected),
            Self::HideSelection => {
                Info::new(Select, "Hide", "Does not draw the shapes below what is selected, nor their boxes")
                    .key(plain(Key::H))
                    .only_if(selected, unselected)
            }
            Self::ShowSelectionOnly => {
                Info::new(Select, "Show only this", "Hides all shapes but those below what is selected")
                    .key(plain(Key::O))
                    .only_if(selected, unselected)
            }
            Self::ShowAll => Info::new(Select, "Show all", "Draws all shapes again")
                .key(plain(Key::J))
                .only_if(!view.hidden.is_empty(), "Nothing is hidden"),
            Self::NextRay => Info::new(Rays, "Next ray", "The next ray of the pixel in the panel Rays")
                .key(plain(Key::N))
                .only_if(has_rays, no_rays),
            Self::PreviousRay => {
                Info::new(Rays, "Previous ray", "The ray before of the pixel in the panel Rays")
                    .key(shift(Key::N))
                    .only_if(has_rays, no_rays)
            }
            Self::StepOn => Info::new(Rays, "Step forward", "One more step of the chosen ray")
                .key(plain(Key::Period))
                .only_if(has_rays, no_rays),
            Self::StepBack => Info::new(Rays, "Step back", "One step less of the chosen ray")
                .key(plain(Key::Comma))
                .only_if(has_rays, no_rays),
            Self::ResetCamera => Info::new(Camera, "Reset camera", "Back to the scene's own camera")
                .key(plain(Key::R))
                .only_if(loaded, nothing),
            Self::AddBookmark => Info::new(Camera, "Add bookmark", "Keeps this camera with the session")
                .key(ctrl(Key::B))
                .only_if(loaded, nothing),
            Self::Pause => Info::new(Picture, "Pause", "Stops rendering, or goes on")
                .key(plain(Key::P))
                .key(plain(Key::Space))
                .on(view.render.paused),
            Self::Boxes => Info::new(Picture, "Boxes", "The boxes of the tree over the picture")
                .key(plain(Key::B))
                .on(session.overlay.depths.is_some()),
            Self::Animate => {
                Info::new(Picture, "Animate", "Lets the scene move; the tree follows, built anew or refitted")
                    .key(plain(Key::T))
                    .only_if(
                        view.scene.is_some_and(|scene| scene.is_animated()),
                        "Nothing moves in this scene",
                    )
                    .on(view.animating)
            }
            Self::EndComparison => Info::new(Picture, "End comparison", "Back from two views to one")
                .key(plain(Key::C))
                .only_if(view.compare.is_some(), "One view is shown"),
            Self::FalseShadow => Info::new(
                Picture,
                "Show the false shadow",
                "What an early-out shadow query gets wrong, in the default scene",
            ),
            Self::Ground => {
                Info::new(Picture, "Ground", "A plane under the scene, outside every tree and figure")
                    .on(session.ground)
            }
            Self::MeasureTable => Info::new(
                Tree,
                "Measure the five trees",
                "The classic trees side by side on this scene and view",
            )
            .only_if(loaded, nothing),
            Self::TourOn => {
                let is_last = view.touring.is_some_and(Touring::is_last);
                Info::new(Learn, "Next", "The next step of the tour")
                    .key(plain(Key::PageDown))
                    .only_if(!is_last, "This is the last step")
                    .only_on_tour(view)
            }
            Self::TourBack => {
                let is_first = view.touring.is_some_and(Touring::is_first);
                Info::new(Learn, "Back", "The step of the tour before")
                    .key(plain(Key::PageUp))
                    .only_if(!is_first, "This is the first step")
                    .only_on_tour(view)
            }
            Self::LeaveTour => {
                Info::new(Learn, "Stay here", "Ends the tour, and keeps what it shows").only_on_tour(view)
            }
            Self::EndTour => {
                Info::new(Learn, "End tour", "Back to what was shown before the tour").only_on_tour(view)
            }
            Self::TakeTour(index) => {
                let tour = &TOURS[index];
                let is_taken = view.touring.is_some_and(|touring| std::ptr::eq(touring.tour(), tour));
                Info::new(Learn, tour.name, tour.about).on(is_taken)
            }
            Self::Palette => {
                Info::new(Window, "Commands…", "Every action, found by what it is called").key(ctrl(Key::P))
            }
            Self::Shortcuts => Info::new(Window, "Shortcuts", "The page of keys").key(plain(Key::F1)),
            Self::Dark => Info::new(Window, "Dark", "Light text on dark ground").on(view.palette.dark),
            Self::Light => Info::new(Window, "Light", "Dark text on light ground").on(!view.palette.dark),
            Self::ResetLayout => {
                Info::new(Window, "Reset layout", "All panels back to where they were at the first start")
            }
            Self::ReopenAtStart => Info::new(
                File,
                "Reopen last session at start",
                "Starts with what was shown last time, if nothing is named to open",
            )
            .on(*reopens),
            Self::OpenBuiltin(index) => {
                let (name, about) = SCENES[index];
                Info::new(File, format!("Open scene {name}"), about)
            }
            Self::OpenRecent(index) => {
                let scene = view.recent.get(index);
                let name = scene.map_or_else(String::new, super::jobs::load::short_name);
                let about = scene.map_or_else(String::new, SceneRef::text);
                Info::new(File, format!("Open recent {name}"), about)
            }
            Self::GoToBookmark(index) => {
                let name = session.bookmarks.get(index).map_or("", |bookmark| bookmark.name.as_str());
                let info =
                    Info::new(Camera, format!("Go to {name}"), "Looks through the camera of this bookmark")
                        .only_if(loaded, nothing);
                if index < BOOKMARK_KEYS { info.key(ctrl(DIGITS[index])) } else { info }
            }
            Self::ShowView(shown) => {
                let info = Info::new(Picture, format!("View {}", title(shown)), shown.description())
                    .on(session.view == shown);
                let place = View::ALL.iter().position(|other| *other == shown);
                match place.and_then(|place| DIGITS.get(place)) {
                    Some(key) => info.key(plain(*key)),
                    None => info,
                }
            }
            Self::UseBuilder(builder) => {
                Info::new(Tree, format!("Builder {}", builder.name()), builder.description())
                    .on(session.build().builder == builder)
            }
            Self::UseColors(map) => {
                Info::new(Picture, format!("Colour map {}", map.name()), map.description())
                    .on(session.display.colormap == map)
            }
            Self::ShowPanel(kind) => {
                Info::new(Window, format!("Panel {}", kind.title()), Pane::Panel(kind).about())
                    .on(layout.is_open(kind))
            }
        }
    }
}

impl Info {
    fn only_on_tour(self, view: &AppView) -> Self {
        if view.touring.is_some() {
            self
        } else {
            self.only_if(false, "No tour is taken: see the menu Learn")
        }
    }
}

/// A view's name for people.
pub fn title(view: View) -> String {
    let name = view.name().replace('-', " ");
    match view.class() {
        ViewClass::Heat => format!("{name} (heatmap)"),
        ViewClass::Radiance | ViewClass::Data | ViewClass::Distance | ViewClass::Leaf | ViewClass::Class => {
            name
        }
    }
}

#[cfg(test)]
mod tests;
