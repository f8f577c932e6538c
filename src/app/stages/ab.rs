//! Two states against each other: their trees, built when they are compared and dropped when they are not; their figures;
//! and the difference of their pictures.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::ab::{Kept, Wanted};
use crate::app::jobs::ab_build::{AbBuildMessage, AbBuildRequest};
use crate::app::jobs::ab_figures::{AbFiguresRequest, AbKey};
use crate::app::jobs::difference::DifferenceRequest;
use crate::app::jobs::{SceneKey, TreeKey};
use crate::app::state::State;
use crate::render::{Film, RenderSettings};

/// What was asked for.
#[derive(Default)]
pub struct AbMemo {
    build: Option<Wanted>,
    /// What could not be built; not tried again until it is asked for anew.
    failed: Vec<Wanted>,
    figures: Option<AbKey>,
    difference: Option<[Arc<Film>; 2]>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.ab_build.poll(&context) {
        match message {
            AbBuildMessage::Built(kept) => keep(state, *kept),
            AbBuildMessage::Failed { wanted, message } => {
                state.messages.error(message);
                jobs.memo.ab.failed.push(*wanted);
            }
        }
    }
    for (key, comparison) in jobs.ab_figures.poll(&context) {
        state.ab.figures_key = Some(key);
        state.ab.panel.figures = Some(comparison.into());
    }
    // Times are taken with the picture standing still, so a change of what is shown comes first.
    let running = jobs.ab_figures.running();
    if running.is_some_and(|running| running.request.key.timed && state.last_change > running.since) {
        jobs.ab_figures.cancel();
        jobs.memo.ab.figures = None;
        state.ab.timed_beside = None;
    }
    for picture in jobs.difference.poll(&context) {
        state.ab.panel.difference.clone_from(&picture.summary);
        state.ab.difference = Some(picture);
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    trees(jobs, state);
    figures(jobs, state, now);
    difference(jobs, state);
    let panel = &mut state.ab.panel;
    panel.building = jobs.ab_build.status(AbBuildRequest::what);
    panel.measuring = jobs.ab_figures.status(|_| "measuring both trees".to_owned());
}

/// Replaces the tree of the same state.
fn keep(state: &mut State, kept: Kept) {
    state.ab.kept.retain(|old| old.variant != kept.variant && old.wanted != kept.wanted);
    state.ab.kept.push(kept);
}

fn trees(jobs: &mut Jobs, state: &mut State) {
    if state.compare.is_none() {
        state.ab.kept.clear();
        jobs.memo.ab.failed.clear();
        if jobs.memo.ab.build.take().is_some() {
            jobs.ab_build.cancel();
        }
        state.ab.panel.ready = [false; 2];
        return;
    }
    let rivals = state.rivals();
    let wanted: Vec<(usize, Wanted)> =
        rivals.iter().filter_map(|&i| state.wanted_of(i).map(|wanted| (i, wanted))).collect();
    // Older trees stay only while a newer one of their state is built.
    state
        .ab
        .kept
        .retain(|kept| wanted.iter().any(|(i, wanted)| kept.wanted == *wanted || kept.variant == *i));
    let mut missing = None;
    for (variant, wanted) in wanted {
        if let Some(kept) = state.ab.kept.iter_mut().find(|kept| kept.wanted == wanted) {
            kept.variant = variant;
        } else if let Some(kept) = at_hand(state, variant, &wanted) {
            keep(state, kept);
        } else if !jobs.memo.ab.failed.contains(&wanted) {
            missing = missing.or(Some((variant, wanted)));
        }
    }
    state.ab.panel.ready = [0, 1].map(|slot| state.shown(slot).is_some());
    let Some((variant, wanted)) = missing else {
        // What runs is no longer wanted.
        if jobs.memo.ab.build.take().is_some() {
            jobs.ab_build.cancel();
        }
        return;
    };
    if jobs.memo.ab.build.as_ref() != Some(&wanted) {
        jobs.memo.ab.build = Some(wanted.clone());
        build(jobs, state, variant, wanted);
    }
}

/// The tree of the active state, where it is the same: so that it is still there when the active one is changed.
fn at_hand(state: &State, variant: usize, wanted: &Wanted) -> Option<Kept> {
    let document = state.document.as_ref()?;
    if wanted.scene != state.session.scene.reference {
        return None;
    }
    let session = state.session.activated(variant);
    let tree = TreeKey::wanted(SceneKey::of(document.load, &document.still, &session), &session);
    (tree == document.tree).then(|| Kept {
        wanted: wanted.clone(),
        variant,
        tree,
        world: Arc::clone(&document.world),
        still: Arc::clone(&document.still),
    })
}

fn build(jobs: &mut Jobs, state: &State, variant: usize, wanted: Wanted) {
    let Some(document) = &state.document else { return };
    let session = state.session.activated(variant);
    let (load, still) = if wanted.scene == state.session.scene.reference {
        (document.load, Some(Arc::clone(&document.still)))
    } else if let Some(kept) = state.ab.kept.iter().find(|kept| kept.wanted.has_scene_of(&wanted)) {
        (kept.tree.scene.load, Some(Arc::clone(&kept.still)))
    } else {
        jobs.memo.loads += 1;
        (jobs.memo.loads, None)
    };
    let context = jobs.context.clone();
    jobs.ab_build.request(&context, AbBuildRequest { wanted, variant, session, load, still });
}

/// While the panel is looked at.
fn figures(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let key = figures_key(state).filter(|_| now.showing.compare);
    let known = state.ab.figures_key;
    // Times that are still to come make no figure wrong.
    state.ab.panel.stale =
        known.zip(key).is_some_and(|(known, key)| AbKey { timed: key.timed, ..known } != key);
    state.ab.panel.can_time = state.ab.figures_key.is_some_and(|known| Some(known) == key && !known.timed);
    let Some(key) = key else {
        if jobs.memo.ab.figures.take().is_some() {
            jobs.ab_figures.cancel();
        }
        if state.compare.is_none() {
            state.ab.figures_key = None;
            state.ab.panel.figures = None;
        }
        return;
    };
    if (!now.hold && state.is_moving(now.time)) || jobs.memo.ab.figures == Some(key) {
        return;
    }
    if state.ab.figures_key == Some(key) {
        jobs.memo.ab.figures = Some(key);
        return;
    }
    let (Some(a), Some(b), Some(compare)) = (state.shown(0), state.shown(1), state.compare) else { return };
    let names = compare.sides().map(|side| state.session.variants[state.variant_of(side)].name.clone());
    let settings = RenderSettings { width: key.width, height: key.height, ..state.session.render };
    let worlds = [Arc::clone(a.world), Arc::clone(b.world)];
    jobs.memo.ab.figures = Some(key);
    let context = jobs.context.clone();
    jobs.ab_figures.request(&context, AbFiguresRequest { key, names, worlds, settings });
}

/// `None` unless two states are compared, and both trees are there and are the newest.
fn figures_key(state: &State) -> Option<AbKey> {
    let compare = state.compare.filter(|compare| compare.is_of_states())?;
    let [width, height] = state.measured_size()?;
    let (a, b) = (state.shown(0)?, state.shown(1)?);
    let is_new = |side| {
        let variant = state.variant_of(side);
        let document = state.document.as_ref();
        let active = || {
            let wanted = state.wanted_scene().map(|scene| TreeKey::wanted(scene, &state.session));
            document.map(|d| d.tree) == wanted
        };
        let kept = || {
            let wanted = state.wanted_of(variant);
            state.ab.kept.iter().any(|kept| Some(&kept.wanted) == wanted.as_ref())
        };
        if variant == state.session.active { active() } else { kept() }
    };
    if !compare.sides().into_iter().all(is_new) {
        return None;
    }
    let render = &state.session.render;
    let key = AbKey {
        trees: [a.tree, b.tree],
        cameras: [a.camera, b.camera],
        width,
        height,
        seed: render.seed,
        max_depth: render.max_depth,
        count: state.session.count,
        timed: false,
    };
    Some(AbKey { timed: state.ab.timed_beside == Some(key), ..key })
}

/// Times frames with both trees, too, for as long as nothing changes.
pub fn time_frames(state: &mut State) {
    state.ab.timed_beside = state.ab.figures_key.filter(|key| !key.timed);
}

fn difference(jobs: &mut Jobs, state: &mut State) {
    if !state.compares_numbers() {
        state.ab.difference = None;
        state.ab.panel.difference = None;
        jobs.memo.ab.difference = None;
        jobs.difference.cancel();
        return;
    }
    let film = |slot| state.picture(slot).map(|picture| Arc::clone(&picture.frame.film));
    let (Some(a), Some(b)) = (film(0), film(1)) else { return };
    let asked = jobs.memo.ab.difference.as_ref();
    let is_asked = asked.is_some_and(|[x, y]| Arc::ptr_eq(x, &a) && Arc::ptr_eq(y, &b));
    if is_asked || (a.width, a.height) != (b.width, b.height) || a.subject != b.subject {
        return;
    }
    let films = [a, b];
    jobs.memo.ab.difference = Some(films.clone());
    let version = state.next_version();
    let context = jobs.context.clone();
    jobs.difference.request(&context, DifferenceRequest { films, version });
}
