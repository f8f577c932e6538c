//! What the Shadows panel counts, while it is looked at.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::shadow::{ShadowKey, ShadowRequest};
use crate::app::state::State;
use crate::app::view::ShadowState;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for (key, figures) in jobs.shadow.poll(&context) {
        state.shadow_key = Some(key);
        state.shadow =
            ShadowState { counts: Some(figures.counts), nodes_mean: figures.nodes_mean, running: false };
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    state.shadow.running = !jobs.shadow.is_idle();
    if !now.showing.shadows {
        if !jobs.shadow.is_idle() {
            jobs.shadow.cancel();
            jobs.memo.shadow = None;
        }
        return;
    }
    let (Some(document), Some(camera), Some([width, height])) =
        (&state.document, state.camera(), state.measured_size())
    else {
        return;
    };
    if !now.hold && state.is_moving(now.time) {
        return;
    }
    let rule = state.session.shadow_rule;
    let key = ShadowKey { tree: document.tree, camera, width, height, rule };
    if jobs.memo.shadow == Some(key) || state.shadow_key == Some(key) {
        return;
    }
    jobs.memo.shadow = Some(key);
    state.shadow.running = true;
    let world = Arc::clone(&document.world);
    let context = jobs.context.clone();
    jobs.shadow.request(&context, ShadowRequest { key, world, settings: state.session.render });
}
