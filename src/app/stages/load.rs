//! Opening scenes and sessions: until the new one is there whole, the old one stays.

use std::sync::Arc;

use super::Jobs;
use crate::app::ab::Ab;
use crate::app::jobs::load::{LoadMessage, LoadRequest, Opened, Source, short_name};
use crate::app::splitting::{SplitView, Splitting};
use crate::app::state::{Document, State};
use crate::app::view::{BinCurve, ShadowState, TableState};
use crate::export::findings::verdict;
use crate::scene::SceneRef;
use crate::session::Session;
use crate::world::World;

/// Starts to open something. A load that runs is stopped.
pub fn open(jobs: &mut Jobs, state: &State, source: Source) {
    jobs.memo.loads += 1;
    let still = state.document.as_ref().map(|document| Arc::clone(&document.still));
    let request = LoadRequest::new(jobs.memo.loads, source, state.session.clone(), still);
    let context = jobs.context.clone();
    jobs.load.request(&context, request);
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.load.poll(&context) {
        match message {
            LoadMessage::Failed { message } if state.reopened => {
                state.reopened = false;
                state.messages.error(format!(
                    "What was open last time cannot be opened again, so this is the default scene. {message}"
                ));
                open(jobs, state, Source::Scene(SceneRef::default()));
            }
            LoadMessage::Failed { message } => state.messages.error(message),
            LoadMessage::Opened(opened) => adopt(jobs, state, *opened),
        }
    }
}

/// Replaces what is open.
fn adopt(jobs: &mut Jobs, state: &mut State, opened: Opened) {
    let Opened { source, session, still, world, key, warnings } = opened;
    state.reopened = false;
    jobs.build.cancel();
    jobs.curve.cancel();
    jobs.table.cancel();
    jobs.memo.build = Some(key);
    jobs.memo.curve = Default::default();
    jobs.memo.table = Default::default();
    adopt_session(state, &source, session);
    if !warnings.is_empty() {
        let name = short_name(&state.session.scene.reference);
        let count = warnings.len();
        let more = if count == 1 { String::new() } else { format!(" (and {} more, in Scene)", count - 1) };
        state.messages.say(format!("{name}: {}{more}", warnings[0]));
    }
    if let Some(message) = broken_tree(&world) {
        state.messages.error(message);
    }
    state.remember_recent(&state.session.scene.reference.clone());
    state.remember_build(key, &world);
    state.document = Some(Document { load: key.scene.load, still, world, tree: key, warnings });
    state.pictures = Default::default();
    state.boxes = None;
    state.ab = Ab::default();
    state.figures = None;
    state.curve = BinCurve::default();
    state.curve_key = None;
    state.table = TableState::default();
    state.table_key = None;
    state.shadow = ShadowState::default();
    state.shadow_key = None;
    state.hover = None;
    state.marked = None;
    state.selections.forget();
    state.hidden.show_all();
    state.region = None;
    state.region_figures = None;
    state.visible = None;
    state.inspection.forget();
    state.player.forget();
    state.splitting =
        Splitting { view: SplitView { hovered: None, ..state.splitting.view }, ..Splitting::default() };
    state.census = None;
    state.visits = None;
    state.overlaps = None;
    state.held_range = None;
    state.last_change = std::time::Instant::now();
}

/// What to say of a tree from a file that is not traced.
pub fn broken_tree(world: &World) -> Option<String> {
    let imported = world.imported.as_ref().filter(|imported| !imported.findings.is_valid())?;
    Some(format!(
        "{}: {}. The picture is traced with a tree that was built here; the panel Tree file lists what is wrong.",
        imported.file.name,
        verdict(&imported.findings)
    ))
}

/// For a scene alone, settings that were changed while it was loaded stay.
fn adopt_session(state: &mut State, source: &Source, opened: Session) {
    match source {
        Source::SessionFile(_) => {
            state.compare = None;
            state.animating = false;
            state.session = opened;
        }
        Source::Session(_) => {
            state.animating = false;
            state.session = opened;
        }
        Source::Scene(_) | Source::Tree(_) => {
            state.animating = false;
            let tree = opened.tree().cloned();
            let session = &mut state.session;
            session.variants[session.active].tree = tree;
            session.scene = opened.scene;
            session.camera = opened.camera;
            session.time = opened.time;
            session.up = opened.up;
            session.ground = opened.ground;
            session.display.range = opened.display.range;
            session.display.threshold = opened.display.threshold;
        }
        Source::Current => {
            let tree = opened.tree().cloned();
            state.session.scene = opened.scene;
            let active = state.session.active;
            state.session.variants[active].tree = tree;
        }
    }
}
