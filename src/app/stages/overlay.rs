//! The boxes over the picture: drawn when camera, tree, size or settings change; coarser while the camera moves.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::OverlayKey;
use crate::app::jobs::overlay::{OverlayRequest, moving_scale};
use crate::app::state::{Boxes, State};

/// What was last asked for, and what it took.
#[derive(Default)]
pub struct OverlayMemo {
    asked: Option<(OverlayKey, u32)>,
    took: Option<(f64, u32)>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for done in jobs.overlay.poll(&context) {
        jobs.memo.overlay.took = Some((done.ms, done.scale));
        let current = state.document.as_ref().is_some_and(|d| d.load == done.key.tree.scene.load);
        if current && state.session.overlay.depths.is_some() {
            let version = state.next_version();
            state.boxes = Some(Boxes { key: done.key, overlay: done.overlay, image: done.image, version });
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    if state.session.overlay.depths.is_none() {
        state.boxes = None;
        jobs.memo.overlay.asked = None;
        jobs.overlay.cancel();
        return;
    }
    let (Some(document), Some(camera), Some([width, height])) =
        (&state.document, state.camera(), state.picture_size())
    else {
        return;
    };
    let key = OverlayKey { tree: document.tree, camera, settings: state.session.overlay, width, height };
    let coarse = !now.hold && state.is_moving(now.time);
    let scale = if coarse { moving_scale(jobs.memo.overlay.took) } else { 1 };
    // What is there in finer pixels is not drawn again.
    if jobs.memo.overlay.asked.is_some_and(|(asked, at)| asked == key && at <= scale) {
        return;
    }
    jobs.memo.overlay.asked = Some((key, scale));
    let world = Arc::clone(&document.world);
    let context = jobs.context.clone();
    jobs.overlay.request(&context, OverlayRequest { key, world, scale });
}
