//! The scene without what is hidden, as soon as something is.

use std::sync::Arc;

use super::Jobs;
use crate::app::jobs::visible::{VisibleKey, VisibleRequest};
use crate::app::state::State;

/// What was last asked for.
pub type VisibleMemo = Option<VisibleKey>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for (key, world) in jobs.visible.poll(&context) {
        state.visible = Some((key, Arc::new(world)));
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State) {
    let Some(document) = &state.document else { return };
    if state.hidden.is_empty() {
        state.visible = None;
        if jobs.memo.visible.take().is_some() {
            jobs.visible.cancel();
        }
        return;
    }
    let key = VisibleKey { scene: document.tree.scene, hidden: state.hidden.version };
    if jobs.memo.visible == Some(key) || state.visible.as_ref().is_some_and(|(known, _)| *known == key) {
        return;
    }
    jobs.memo.visible = Some(key);
    let (scene, hidden) = (Arc::clone(&document.world.scene), Arc::clone(&state.hidden.shapes));
    let context = jobs.context.clone();
    jobs.visible.request(&context, VisibleRequest { key, scene, hidden });
}
