//! The table of five trees: measured under the lease when it is first looked at or asked for, given up when the user
//! changes something or looks elsewhere, and tried again when all is quiet.

use std::sync::Arc;
use std::time::Duration;

use super::{Jobs, Now};
use crate::app::jobs::table::{TableKey, TableMessage, TableRequest};
use crate::app::state::State;

/// How long nothing may have changed before a measurement starts.
const QUIET: Duration = Duration::from_millis(900);

/// What was asked for.
#[derive(Default)]
pub struct TableMemo {
    /// A measurement is wanted, now or when all is quiet.
    pub wanted: bool,
    /// The first look at the panel asks for one by itself, once a scene.
    asked_by_itself: bool,
    running: Option<TableKey>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let context = jobs.context.clone();
    for message in jobs.table.poll(&context) {
        match message {
            TableMessage::Row(row) => {
                if state.table_key != jobs.memo.table.running {
                    state.table_key = jobs.memo.table.running;
                    state.table.rows.clear();
                }
                state.table.rows.push(*row);
            }
            TableMessage::Done => {
                jobs.memo.table.wanted = false;
                jobs.memo.table.running = None;
            }
        }
    }
    // A change of what is shown, and whatever another panel needs, comes first: give the measurement up, and try again
    // later.
    let changed = jobs.table.running().is_some_and(|running| state.last_change > running.since);
    if jobs.memo.table.running.is_some() && (changed || !now.showing.table) {
        jobs.table.cancel();
        jobs.memo.table.running = None;
        drop_unfinished(state);
    }
}

/// Stops measuring for good.
pub fn cancel(jobs: &mut Jobs, state: &mut State) {
    jobs.memo.table.wanted = false;
    if jobs.memo.table.running.take().is_some() {
        jobs.table.cancel();
        drop_unfinished(state);
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let key = wanted_key(state);
    state.table.stale = state.table_key.is_some() && state.table_key != key;
    state.table.running = jobs.table.status(|_| "measuring the five trees".to_owned());
    let (Some(key), Some(document)) = (key, &state.document) else { return };
    let memo = &mut jobs.memo.table;
    if now.showing.table && state.table.rows.is_empty() && !memo.asked_by_itself && !now.hold {
        memo.asked_by_itself = true;
        memo.wanted = true;
    }
    let quiet = now.hold || now.time.saturating_duration_since(state.last_change) >= QUIET;
    let up_to_date = jobs.build.is_idle() && jobs.load.is_idle() && document.tree.scene == key.scene;
    let may_start = quiet && up_to_date && now.showing.table && !state.animating;
    if !memo.wanted || memo.running.is_some() || !may_start {
        return;
    }
    memo.running = Some(key);
    let scene = Arc::clone(&document.world.scene);
    let settings = sized(state);
    let context = jobs.context.clone();
    // The rows of an earlier measurement stay until the first new one is there.
    state.table_key = None;
    jobs.table.request(&context, TableRequest { key, scene, settings });
    state.table.running = jobs.table.status(|_| "measuring the five trees".to_owned());
}

/// Whether a frame is needed soon to start a measurement that waits for quiet.
pub fn waits(jobs: &Jobs, now: &Now) -> bool {
    now.showing.table && jobs.memo.table.wanted && jobs.memo.table.running.is_none()
}

fn wanted_key(state: &State) -> Option<TableKey> {
    let scene = state.wanted_scene()?;
    Some(TableKey::new(scene, &state.camera()?, &sized(state), state.session.build()))
}

/// The table is measured at the size of the viewport.
fn sized(state: &State) -> crate::render::RenderSettings {
    let mut settings = state.session.render;
    if let Some([width, height]) = state.measured_size() {
        (settings.width, settings.height) = (width, height);
    }
    settings
}

/// Half a table would compare what was measured with what was not.
fn drop_unfinished(state: &mut State) {
    const ROWS: usize = 5;
    if state.table.rows.len() < ROWS {
        state.table.rows.clear();
        state.table_key = None;
    }
}
