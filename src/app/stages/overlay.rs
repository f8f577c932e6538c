//! The boxes over the pictures: drawn when camera, tree, size or settings change; coarser while the camera moves.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::overlay::{OverlayJob, OverlayRequest, moving_scale};
use crate::app::jobs::{Context, OverlayKey};
use crate::app::state::{Boxes, State};

/// What was last asked for, and what it took.
#[derive(Default)]
pub struct OverlayMemo {
    asked: Option<(OverlayKey, u32)>,
    took: Option<(f64, u32)>,
}

impl Jobs {
    /// What draws the boxes over a picture.
    fn overlay_of(&mut self, slot: usize) -> (&mut OverlayJob, &mut OverlayMemo) {
        match slot {
            0 => (&mut self.overlay, &mut self.memo.overlay),
            _ => (&mut self.right_overlay, &mut self.memo.right_overlay),
        }
    }
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for slot in [0, 1] {
        let (job, memo) = jobs.overlay_of(slot);
        for done in job.poll(&context) {
            memo.took = Some((done.ms, done.scale));
            let load = done.key.tree.scene.load;
            let is_current = state.shown(slot).is_some_and(|shown| shown.tree.scene.load == load);
            if is_current && state.session.overlay.depths.is_some() {
                let version = state.next_version();
                let boxes = Boxes { key: done.key, overlay: done.overlay, image: done.image, version };
                *boxes_of(state, slot) = Some(boxes);
            }
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let context = jobs.context.clone();
    for slot in [0, 1] {
        start_slot(jobs, &context, state, now, slot);
    }
}

fn boxes_of(state: &mut State, slot: usize) -> &mut Option<Boxes> {
    if slot == 0 { &mut state.boxes } else { &mut state.ab.boxes }
}

fn start_slot(jobs: &mut Jobs, context: &Context, state: &mut State, now: &Now, slot: usize) {
    let (job, memo) = jobs.overlay_of(slot);
    let Some(key) = wanted(state, slot) else {
        if state.session.overlay.depths.is_none() || slot > 0 {
            *boxes_of(state, slot) = None;
            memo.asked = None;
            job.cancel();
        }
        return;
    };
    let coarse = !now.hold && state.is_moving(now.time);
    let scale = if coarse { moving_scale(memo.took) } else { 1 };
    // What is there in finer pixels is not drawn again.
    if memo.asked.is_some_and(|(asked, at)| asked == key && at <= scale) {
        return;
    }
    let Some(shown) = state.shown(slot) else { return };
    memo.asked = Some((key, scale));
    let Some((seen, hidden)) = state.seen(slot) else { return };
    let hidden = if hidden > 0 { Arc::clone(&state.hidden.shapes) } else { Arc::default() };
    let (world, seen) = (Arc::clone(shown.world), Arc::clone(seen));
    job.request(context, OverlayRequest { key, world, seen, hidden, scale });
}

/// `None` while nothing is to be drawn. The boxes of the right picture are drawn only if they are others than those of the
/// left.
fn wanted(state: &State, slot: usize) -> Option<OverlayKey> {
    state.session.overlay.depths?;
    let [width, height] = state.picture_size()?;
    let of = |slot| {
        let shown = state.shown(slot)?;
        let settings = state.session.overlay;
        let (_, hidden) = state.seen(slot)?;
        Some(OverlayKey { tree: shown.tree, camera: shown.camera, settings, width, height, hidden })
    };
    let key = of(slot)?;
    (slot == 0 || of(0) != Some(key)).then_some(key)
}
