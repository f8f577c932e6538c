//! Guided tours: each step sets up scene, tree, picture and panels, and says in a few sentences what to look at.

mod lessons;
mod strip;

use super::ab::{CompareStyle, CompareViews};
use super::apply::Target;
use super::inspection::{RayView, RaysAsked};
use super::jobs::TreeKey;
use super::jobs::load::Source;
use super::panels::PanelKind;
use super::selection::Pick;
use super::splitting::SplitView;
use super::state::State;
use crate::accel::NodeId;
use crate::render::View;
use crate::scene::SceneRef;
use crate::session::flags::read_words;
use crate::session::{Session, SessionScene, Variant};
use crate::world::NodeFigure;

pub use lessons::TOURS;
pub use strip::ui;

/// A tour on a built-in scene.
#[derive(Debug)]
pub struct Tour {
    pub name: &'static str,
    /// One sentence without a full stop.
    pub about: &'static str,
    pub scene: &'static str,
    pub steps: &'static [Step],
}

/// What is set up, and what is said of it.
#[derive(Debug)]
pub struct Step {
    pub title: &'static str,
    /// A few sentences.
    pub text: &'static str,
    /// Settings that are not the defaults, as flags of the command line.
    flags: &'static str,
    beside: Option<Beside>,
    /// Brought to the front.
    panels: &'static [PanelKind],
    selects: Option<Spot>,
    /// What the colours of the icicle plot say.
    colors: NodeFigure,
}

/// The picture at the right, and how it is shown.
#[derive(Debug)]
enum Beside {
    /// A second state, A and B by name, and the flags of its tree.
    Tree { names: [&'static str; 2], flags: &'static str, style: CompareStyle },
    /// Two views of the one state.
    Views([View; 2], CompareStyle),
}

/// What a step selects.
#[derive(Clone, Copy, Debug)]
enum Spot {
    /// The root, and the axis that the panel Splits shows of it.
    Root(usize),
    /// What a pixel shows, with the second of its rays: to the right of the middle and below it, in heights of the picture.
    Pixel([f32; 2]),
}

/// What was shown before a tour.
struct Before {
    session: Session,
    compare: Option<CompareViews>,
    /// Of the icicle plot.
    colors: NodeFigure,
}

/// A tour that somebody takes.
pub struct Touring {
    tour: usize,
    step: usize,
    before: Before,
    /// The step is not set up whole: its tree is not there yet.
    pending: bool,
    /// The pixel whose second ray is to be chosen, once its rays are known.
    ray_of: Option<[u32; 2]>,
}

/// What to do about tours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Go {
    /// By the index in [`TOURS`].
    Begin(usize),
    On,
    Back,
    /// Back to what was shown before.
    End,
    /// Stays with what the step shows, without the tour.
    Leave,
}

impl Touring {
    pub fn tour(&self) -> &'static Tour {
        &TOURS[self.tour]
    }

    pub fn step(&self) -> &'static Step {
        &self.tour().steps[self.step]
    }

    pub fn is_last(&self) -> bool {
        self.step + 1 == self.tour().steps.len()
    }

    /// The step is not set up whole yet.
    pub fn is_pending(&self) -> bool {
        self.pending || self.ray_of.is_some()
    }

    pub fn is_first(&self) -> bool {
        self.step == 0
    }

    /// As in `2 of 4`.
    pub fn place(&self) -> String {
        format!("{} of {}", self.step + 1, self.tour().steps.len())
    }

    /// The session of before, which is to be kept from one run to the next.
    pub fn before(&self) -> &Session {
        &self.before.session
    }
}

impl Step {
    /// One picture, nothing selected: what a step says nothing of.
    const PLAIN: Self = Self {
        title: "",
        text: "",
        flags: "",
        beside: None,
        panels: &[],
        selects: None,
        colors: NodeFigure::Overlap,
    };

    /// The session that the step shows, in the window of another.
    fn session(&self, scene: &str, window: &Session) -> Session {
        let reference = SceneRef::Builtin(scene.to_owned());
        let mut session = Session {
            render: window.render,
            bookmarks: window.bookmarks.clone(),
            scene: SessionScene { reference, ..SessionScene::default() },
            ..Session::default()
        };
        set(&mut session, self.flags);
        if let Some(Beside::Tree { names: [a, b], flags, .. }) = &self.beside {
            let mut other = session.clone();
            set(&mut other, flags);
            session.variants[0].name = (*a).to_owned();
            session.variants.push(Variant {
                name: (*b).to_owned(),
                build: *other.build(),
                ..Variant::default()
            });
        }
        session
    }

    /// Whether two views of one tree are shown.
    pub fn compares_views(&self) -> bool {
        matches!(self.beside, Some(Beside::Views(..)))
    }

    pub fn selects_something(&self) -> bool {
        self.selects.is_some()
    }

    fn compare(&self) -> Option<CompareViews> {
        match self.beside {
            None => None,
            Some(Beside::Tree { style, .. }) => Some(CompareViews::of_states(0, 1, style)),
            Some(Beside::Views([left, right], style)) => Some(CompareViews::of_views(left, right, style)),
        }
    }
}

/// Sets flags of a tour, which a test holds to be right.
fn set(session: &mut Session, flags: &str) {
    let words: Vec<String> = flags.split_whitespace().map(str::to_owned).collect();
    if let Err(error) = read_words(session, &words) {
        debug_assert!(false, "{flags}: {error}");
    }
}

impl Target<'_> {
    pub(super) fn tour(&mut self, go: Go) {
        match go {
            Go::Begin(tour) => {
                if tour >= TOURS.len() {
                    return;
                }
                // From one tour to another what was shown before the first is kept.
                let before = match self.state.touring.take() {
                    Some(touring) => touring.before,
                    None => Before {
                        session: self.state.session.clone(),
                        compare: self.state.compare,
                        colors: self.state.tree_view.figure,
                    },
                };
                self.state.touring = Some(Touring { tour, step: 0, before, pending: true, ray_of: None });
                self.set_up();
            }
            Go::On | Go::Back => {
                let Some(touring) = &mut self.state.touring else { return };
                let next = match go {
                    Go::Back => touring.step.checked_sub(1),
                    _ => Some(touring.step + 1).filter(|step| *step < touring.tour().steps.len()),
                };
                let Some(step) = next else { return };
                (touring.step, touring.pending, touring.ray_of) = (step, true, None);
                self.set_up();
            }
            Go::Leave => self.state.touring = None,
            Go::End => {
                let Some(Touring { before, .. }) = self.state.touring.take() else { return };
                self.show_session(before.session);
                self.state.compare = before.compare;
                self.state.tree_view.figure = before.colors;
            }
        }
    }

    /// Shows what the step is about, as far as it can be shown before its tree is there.
    fn set_up(&mut self) {
        let Some(touring) = &self.state.touring else { return };
        let (tour, step) = (touring.tour(), touring.step());
        self.state.paused = false;
        self.state.compare = None;
        self.state.region = None;
        self.state.selections.clear();
        self.state.hidden.show_all();
        self.state.inspection.view = RayView { origin: None, ..self.state.inspection.view };
        self.state.tree_view.figure = step.colors;
        for panel in step.panels {
            self.layout.show(*panel, true);
        }
        let session = step.session(tour.scene, &self.state.session);
        self.show_session(session);
    }

    /// Shows a session whole, in the window's size; opens its scene if that is another one.
    fn show_session(&mut self, mut session: Session) {
        self.state.animating = false;
        let now = &self.state.session;
        (session.render.width, session.render.height) = (now.render.width, now.render.height);
        if self.state.document.is_some() && now.scene.reference == session.scene.reference {
            session.scene = now.scene.clone();
            self.edit(Box::new(move |target| *target = session));
        } else {
            self.open_quietly(Source::Session(Box::new(session)));
        }
    }

    /// Sets up the rest of a step once its tree is there.
    pub(super) fn go_on_with_tour(&mut self) {
        self.choose_ray();
        let Some(touring) = self.state.touring.as_ref().filter(|touring| touring.pending) else { return };
        let (tour, step) = (touring.tour(), touring.step());
        if !has_tree_of(self.state, tour.scene) {
            return;
        }
        if let Some(touring) = &mut self.state.touring {
            touring.pending = false;
        }
        self.state.compare = step.compare();
        match step.selects {
            None => {}
            Some(Spot::Root(axis)) => {
                self.select(Pick::Node(NodeId(0)), false);
                let splitting = &mut self.state.splitting;
                splitting.set(SplitView { axis, hovered: None, ..splitting.view });
            }
            Some(Spot::Pixel([x, y])) => {
                let size = self.state.picture_size().unwrap_or([0, 0]);
                let height = size[1] as f32;
                let pixel = |from_middle: f32, size: u32| {
                    ((0.5 * size as f32 + from_middle * height) as u32).min(size.saturating_sub(1))
                };
                let pixel = [pixel(x, size[0]), pixel(y, size[1])];
                self.go_to_pixel(pixel);
                if let Some(touring) = &mut self.state.touring {
                    touring.ray_of = Some(pixel);
                }
            }
        }
        self.changed();
    }
}

impl Target<'_> {
    /// Chooses the ray that a step is about, once the rays of its pixel are known.
    fn choose_ray(&mut self) {
        let Some(touring) = &mut self.state.touring else { return };
        let inspection = &mut self.state.inspection;
        let (Some(wanted), Some(found)) = (touring.ray_of, &inspection.found) else { return };
        if matches!(found.key.asked, RaysAsked::Pixel(question) if question.pixel == wanted) {
            let last = found.rays.len().saturating_sub(1);
            inspection.view = RayView { chosen: last.min(1), step: 0, ..inspection.view };
            touring.ray_of = None;
        }
    }
}

/// Whether the tree that the session asks for is there, over a built-in scene.
fn has_tree_of(state: &State, scene: &str) -> bool {
    let (Some(document), Some(wanted)) = (&state.document, state.wanted_scene()) else { return false };
    let is_scene = matches!(&state.session.scene.reference, SceneRef::Builtin(name) if name == scene);
    is_scene && document.tree == TreeKey::wanted(wanted, &state.session)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn every_step_sets_what_it_says_and_speaks_in_sentences() {
        assert_eq!(TOURS.len(), 6);
        for tour in &TOURS {
            assert!(builtin::is_name(tour.scene) && tour.steps.len() >= 3, "{}", tour.name);
            assert!(!tour.about.ends_with('.'), "{}", tour.name);
            for step in tour.steps {
                let session = step.session(tour.scene, &Session::default());
                session.build().check().expect("a configuration in range");
                let mut flags = vec![step.flags];
                if let Some(Beside::Tree { flags: more, .. }) = &step.beside {
                    flags.push(more);
                    assert_eq!(session.variants.len(), 2);
                    assert_ne!(session.variants[0].build, session.variants[1].build, "{}", step.title);
                }
                for flags in flags {
                    let words: Vec<String> = flags.split_whitespace().map(str::to_owned).collect();
                    read_words(&mut Session::default(), &words).expect(step.title);
                }
                assert!(step.text.ends_with('.') && step.text.len() > 80, "{}", step.title);
                assert!(step.text.len() < 520, "{} is too long to be read: {}", step.title, step.text.len());
            }
        }
    }
}
