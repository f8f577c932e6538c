//! A against B in the window: which two sides share the viewport, where their trees are, and what they add up to.
//!
//! A side is a state of the session and a view. The active state's tree is that of the document; those of other states
//! are kept as long as they are compared, and no longer.

use std::sync::Arc;

use egui::ColorImage;

use super::jobs::TreeKey;
use super::jobs::ab_figures::AbKey;
use super::state::{Boxes, State};
use super::view::JobStatus;
use crate::accel::BuildConfig;
use crate::inspect::compare::Comparison;
use crate::inspect::difference::{DifferenceSummary, has_difference};
use crate::render::View;
use crate::render::difference::union;
use crate::render::film::FilmSubject;
use crate::scene::{Camera, Scene, SceneRef, UpAxis};
use crate::session::{TreeRef, prepare};
use crate::world::World;

/// How fast two pictures blink, in milliseconds a picture.
pub const BLINK_MS: u32 = 700;

/// Two pictures at once in the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompareViews {
    pub left: Side,
    pub right: Side,
    pub style: CompareStyle,
    /// How long each picture is seen when they blink, in milliseconds.
    pub blink_ms: u32,
    /// A side with another scene is seen through that scene's own camera.
    pub own_cameras: bool,
}

/// One of two pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Side {
    /// A state of the session by its index; `None`, or one that is not there: the active one.
    pub variant: Option<usize>,
    /// `None`: the session's view.
    pub view: Option<View>,
}

/// How two pictures share the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompareStyle {
    #[default]
    SideBySide,
    /// One over the other, with a line between them that the mouse drags.
    Wipe,
    /// One after the other.
    Blink,
    /// B - A of every pixel.
    Difference,
}

impl CompareStyle {
    pub const ALL: [Self; 4] = [Self::SideBySide, Self::Wipe, Self::Blink, Self::Difference];

    pub fn name(self) -> &'static str {
        match self {
            Self::SideBySide => "side by side",
            Self::Wipe => "wipe",
            Self::Blink => "blink",
            Self::Difference => "difference",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::SideBySide => "next to each other",
            Self::Wipe => "one over the other, with a line between them that the mouse drags",
            Self::Blink => "one after the other in the same place: what changes jumps",
            Self::Difference => {
                "right - left of every pixel: red where the right one has more, blue where it has less"
            }
        }
    }
}

impl CompareViews {
    /// Two views of the active state.
    pub fn of_views(left: View, right: View, style: CompareStyle) -> Self {
        let side = |view| Side { variant: None, view: Some(view) };
        Self { left: side(left), right: side(right), style, blink_ms: BLINK_MS, own_cameras: false }
    }

    /// The session's view of two states.
    pub fn of_states(left: usize, right: usize, style: CompareStyle) -> Self {
        let side = |variant| Side { variant: Some(variant), view: None };
        Self { left: side(left), right: side(right), style, blink_ms: BLINK_MS, own_cameras: false }
    }

    pub fn sides(&self) -> [Side; 2] {
        [self.left, self.right]
    }

    /// Whether two states are compared, not two views of one.
    pub fn is_of_states(&self) -> bool {
        self.sides().iter().any(|side| side.variant.is_some())
    }

    /// The same two sides after the state of that index is gone; `None` if it was one of them.
    pub fn without(self, removed: usize) -> Option<Self> {
        let shifted = |side: Side| match side.variant {
            Some(index) if index == removed => None,
            Some(index) => Some(Side { variant: Some(index - usize::from(index > removed)), ..side }),
            None => Some(side),
        };
        Some(Self { left: shifted(self.left)?, right: shifted(self.right)?, ..self })
    }
}

/// What has to be built for a state that is not active.
#[derive(Clone, Debug, PartialEq)]
pub struct Wanted {
    /// The load of the document that the state stands beside.
    pub document: u64,
    pub scene: SceneRef,
    pub time: f32,
    pub ground: bool,
    pub up: UpAxis,
    pub build: BuildConfig,
    pub tree: Option<TreeRef>,
}

impl Wanted {
    /// Whether the loaded scene is the same, at whatever moment.
    pub fn has_scene_of(&self, other: &Self) -> bool {
        (self.document, &self.scene, self.up) == (other.document, &other.scene, other.up)
    }
}

/// The tree of a state that is compared.
#[derive(Clone)]
pub struct Kept {
    pub wanted: Wanted,
    /// Index of the state.
    pub variant: usize,
    pub tree: TreeKey,
    pub world: Arc<World>,
    /// Its scene as it was loaded.
    pub still: Arc<Scene>,
}

/// B - A of the two pictures.
#[derive(Clone)]
pub struct DifferencePicture {
    pub image: Arc<ColorImage>,
    pub summary: Option<DifferenceSummary>,
    /// Counts the pictures, so that textures know when to follow.
    pub version: u64,
}

/// What the window has of the two sides.
#[derive(Default)]
pub struct Ab {
    /// Trees of compared states; of each at most one.
    pub kept: Vec<Kept>,
    /// The boxes of the right picture, if they are others than those of the left.
    pub boxes: Option<Boxes>,
    pub difference: Option<DifferencePicture>,
    pub figures_key: Option<AbKey>,
    /// The figures, without times, beside which times were asked for.
    pub timed_beside: Option<AbKey>,
    pub panel: AbState,
}

/// What the Compare panel reads.
#[derive(Clone, Debug, Default)]
pub struct AbState {
    /// Whether the trees of the two sides are there.
    pub ready: [bool; 2],
    pub building: Option<JobStatus>,
    pub figures: Option<Arc<Comparison>>,
    pub measuring: Option<JobStatus>,
    /// Whether `figures` are those of something else by now.
    pub stale: bool,
    /// Whether frames can be timed beside the figures.
    pub can_time: bool,
    pub difference: Option<DifferenceSummary>,
}

/// What one of the viewport's pictures shows.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    pub world: &'a Arc<World>,
    pub tree: TreeKey,
    pub camera: Camera,
    pub subject: FilmSubject,
}

impl State {
    /// The side that a slot of the viewport shows; `None` for a slot that there is not.
    fn side(&self, slot: usize) -> Option<Side> {
        match (&self.compare, slot) {
            (None, 0) => Some(Side::default()),
            (Some(compare), 0 | 1) => Some(compare.sides()[slot]),
            _ => None,
        }
    }

    /// The state that a side shows.
    pub fn variant_of(&self, side: Side) -> usize {
        side.variant.filter(|index| *index < self.session.variants.len()).unwrap_or(self.session.active)
    }

    /// The states that are compared and are not the active one.
    pub fn rivals(&self) -> Vec<usize> {
        let sides = self.compare.map_or_else(Vec::new, |compare| compare.sides().to_vec());
        let mut rivals: Vec<usize> = sides.into_iter().map(|side| self.variant_of(side)).collect();
        rivals.retain(|index| *index != self.session.active);
        rivals.dedup();
        rivals
    }

    /// What has to be built for a state; `None` while nothing is open.
    pub fn wanted_of(&self, variant: usize) -> Option<Wanted> {
        let session = &self.session;
        let state = session.variants.get(variant)?;
        Some(Wanted {
            document: self.document.as_ref()?.load,
            scene: session.scene_of(variant).reference.clone(),
            time: session.time_of(variant),
            ground: session.ground,
            up: session.up,
            build: state.build,
            tree: state.tree.clone(),
        })
    }

    /// The tree of a state that is not active: the one that is wanted, or an older one while that is built.
    fn kept_of(&self, variant: usize) -> Option<&Kept> {
        let wanted = self.wanted_of(variant)?;
        let kept = &self.ab.kept;
        kept.iter()
            .find(|kept| kept.wanted == wanted)
            .or_else(|| kept.iter().find(|kept| kept.variant == variant && kept.wanted.has_scene_of(&wanted)))
    }

    /// What a slot of the viewport shows; `None` for a slot that there is not, and while there is no tree for it.
    pub fn shown(&self, slot: usize) -> Option<Shown<'_>> {
        let side = self.side(slot)?;
        let document = self.document.as_ref()?;
        let session = &self.session;
        let subject = FilmSubject { view: side.view.unwrap_or(session.view), ..session.film_subject() };
        let camera = prepare::camera(&document.world.scene, session);
        let variant = self.variant_of(side);
        if variant == session.active {
            return Some(Shown { world: &document.world, tree: document.tree, camera, subject });
        }
        let kept = self.kept_of(variant)?;
        let own = self.compare.is_some_and(|compare| compare.own_cameras)
            && kept.wanted.scene != session.scene.reference;
        let camera = if own { Camera { up: session.up, ..kept.world.scene.camera } } else { camera };
        Some(Shown { world: &kept.world, tree: kept.tree, camera, subject })
    }

    /// Whether both pictures hold numbers of the same thing, and can be shown on one range and be subtracted.
    pub fn compares_numbers(&self) -> bool {
        match &self.subjects()[..] {
            [left, right] => left == right && has_difference(left.view),
            _ => false,
        }
    }

    /// The range of both pictures' numbers, so that equal colours are equal numbers.
    pub fn shared_range(&self) -> Option<[f32; 2]> {
        if !self.compares_numbers() {
            return None;
        }
        let own = |slot| self.picture(slot).map(|picture| picture.frame.presented.own_range);
        union([own(0)?, own(1)?])
    }

    /// The boxes over a picture.
    pub fn boxes_of(&self, slot: usize) -> Option<&Boxes> {
        let left = self.boxes.as_ref();
        match slot {
            0 => left,
            _ => self.ab.boxes.as_ref().or_else(|| {
                let shown = self.shown(slot)?;
                left.filter(|boxes| (boxes.key.tree, boxes.key.camera) == (shown.tree, shown.camera))
            }),
        }
    }

    /// The slot that shows the active state, whatever its view.
    pub fn active_slot(&self) -> Option<usize> {
        let is_active =
            |slot: &usize| self.side(*slot).is_some_and(|side| self.variant_of(side) == self.session.active);
        [0, 1].into_iter().find(is_active)
    }

    /// The slot that shows the active state in the session's view.
    pub fn session_slot(&self) -> Option<usize> {
        let is_it = |slot: &usize| {
            self.side(*slot).is_some_and(|side| {
                let view = side.view.unwrap_or(self.session.view);
                self.variant_of(side) == self.session.active && view == self.session.view
            })
        };
        [0, 1].into_iter().find(is_it)
    }

    /// The boxes of the active state.
    pub fn own_boxes(&self) -> Option<&Boxes> {
        self.active_slot().and_then(|slot| self.boxes_of(slot))
    }

    /// What the two pictures are called, where there are two.
    pub fn side_names(&self) -> Option<[String; 2]> {
        let compare = self.compare?;
        let [left, right] = compare.sides();
        let states = [left, right].map(|side| self.variant_of(side));
        let views = [left, right].map(|side| side.view.unwrap_or(self.session.view));
        Some([0, 1].map(|i| {
            let state = shortened(&self.session.variants[states[i]].name);
            match (states[0] != states[1], views[0] != views[1]) {
                (true, true) => format!("{state}: {}", views[i].name()),
                (true, false) => state,
                (false, _) => views[i].name().to_owned(),
            }
        }))
    }
}

/// A name that has room beside another one.
pub fn shortened(name: &str) -> String {
    const MOST: usize = 28;
    if name.chars().count() <= MOST {
        return name.to_owned();
    }
    name.chars().take(MOST - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_follow_when_a_state_is_removed() {
        let compare = CompareViews::of_states(1, 3, CompareStyle::Wipe);
        let indices = |compare: Option<CompareViews>| {
            compare.map(|c| c.sides().map(|side| side.variant.expect("a state")))
        };
        assert_eq!(indices(compare.without(0)), Some([0, 2]));
        assert_eq!(indices(compare.without(2)), Some([1, 2]));
        assert_eq!(indices(compare.without(4)), Some([1, 3]));
        assert_eq!((compare.without(1), compare.without(3)), (None, None));
        let views = CompareViews::of_views(View::Path, View::Depth, CompareStyle::Blink);
        assert_eq!(views.without(0), Some(views));
        assert!(compare.is_of_states() && !views.is_of_states());
    }

    #[test]
    fn long_names_are_cut() {
        assert_eq!(shortened("short"), "short");
        assert_eq!(shortened(&"x".repeat(40)).chars().count(), 28);
    }

    #[test]
    fn styles_have_names_of_their_own() {
        for (i, style) in CompareStyle::ALL.into_iter().enumerate() {
            assert!(CompareStyle::ALL[..i].iter().all(|other| other.name() != style.name()));
            assert!(!style.description().is_empty());
        }
    }
}
