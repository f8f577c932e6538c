//! The pictures of the viewport: asked for when what they depend on changes, and shown anew when only their display does.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::FilmKey;
use crate::app::jobs::present::PresentRequest;
use crate::app::jobs::render::{Pace, RenderRequest, WantedPicture};
use crate::app::state::{Picture, State};
use crate::render::{DisplaySettings, RenderSettings};
use crate::world::World;

/// What the renderer was last asked for.
pub struct RenderMemo {
    pictures: Vec<(usize, FilmKey, Arc<World>)>,
    display: DisplaySettings,
    goal: Option<u32>,
    pace: Pace,
    /// What was last asked to be shown anew.
    shown: Option<(u64, DisplaySettings)>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    for frame in jobs.renderer.take_frames() {
        let wanted = state.subjects();
        // A look at an older camera is welcome, one at another view is not.
        if wanted.get(frame.slot).is_none_or(|subject| subject.view != frame.key.subject.view) {
            continue;
        }
        let version = state.next_version();
        let slot = frame.slot;
        state.pictures[slot] = Some(Picture { frame, version });
    }
    let context = jobs.context.clone();
    for (slot, film, presented) in jobs.present.poll(&context) {
        let version = state.next_version();
        if let Some(picture) = &mut state.pictures[slot]
            && Arc::ptr_eq(&picture.frame.film, &film)
        {
            picture.frame.presented = presented;
            picture.version = version;
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let Some([width, height]) = state.picture_size() else { return };
    let settings = RenderSettings { width, height, ..state.session.render };
    let pictures: Vec<WantedPicture> = (0..state.subjects().len())
        .filter_map(|slot| {
            let shown = state.shown(slot)?;
            let key = FilmKey::new(&shown.tree, &shown.camera, &settings, shown.subject);
            // What is counted is counted in the tree that is looked at, hidden shapes and all.
            let (world, hidden) = match shown.subject.view.depends_on_tree() {
                true => (shown.world, 0),
                false => state.seen(slot)?,
            };
            Some(WantedPicture { slot, key: FilmKey { hidden, ..key }, world: Arc::clone(world) })
        })
        .collect();
    if pictures.is_empty() {
        return;
    }
    let goal = if now.hold { Some(1) } else { state.session.render.spp };
    let pace = state.pace(now.time, now.hold);
    let display = state.display();
    ask(jobs, RenderRequest { pictures, settings, display, goal, pace });
    show_anew(jobs, state, display);
    let count = state.subjects().len();
    for picture in &mut state.pictures[count..] {
        *picture = None;
    }
}

fn ask(jobs: &mut Jobs, request: RenderRequest) {
    let RenderRequest { pictures, display, goal, pace, .. } = &request;
    let is_same = |((slot, key, world), wanted): (&(usize, FilmKey, Arc<World>), &WantedPicture)| {
        (*slot, key) == (wanted.slot, &wanted.key) && Arc::ptr_eq(world, &wanted.world)
    };
    let same = jobs.memo.render.as_ref().is_some_and(|memo| {
        memo.pictures.len() == pictures.len()
            && memo.pictures.iter().zip(pictures).all(is_same)
            && memo.display == *display
            && memo.goal == *goal
            && memo.pace == *pace
    });
    if same {
        return;
    }
    jobs.memo.render = Some(RenderMemo {
        pictures: pictures.iter().map(|p| (p.slot, p.key, Arc::clone(&p.world))).collect(),
        display: *display,
        goal: *goal,
        pace: *pace,
        shown: jobs.memo.render.as_ref().and_then(|memo| memo.shown),
    });
    jobs.renderer.request(request);
}

/// Shows the first picture that is still shown with other settings, without waiting for its next sample.
fn show_anew(jobs: &mut Jobs, state: &State, display: DisplaySettings) {
    let old = state.pictures.iter().flatten().find(|p| p.frame.presented.display != display);
    let (Some(picture), Some(memo)) = (old, &mut jobs.memo.render) else { return };
    let wanted = (picture.version, display);
    if memo.shown == Some(wanted) {
        return;
    }
    memo.shown = Some(wanted);
    let film = Arc::clone(&picture.frame.film);
    let context = jobs.context.clone();
    jobs.present.request(&context, PresentRequest { slot: picture.frame.slot, film, display });
}
