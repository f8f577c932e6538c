//! How the tree came about, while the panel Construction is looked at.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::TreeKey;
use crate::app::jobs::construction::ConstructionRequest;
use crate::app::state::State;

/// What was last asked for.
pub type ConstructionMemo = Option<TreeKey>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for (tree, construction) in jobs.construction.poll(&context) {
        state.player.construction = Some((tree, Arc::new(construction)));
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let Some(document) = &state.document else { return };
    if !now.showing.construction || state.animating {
        state.player.view.playing = false;
        return;
    }
    let tree = document.tree;
    if state.player.of(tree).is_some() {
        state.player.play(tree, now.time);
        state.player.show(tree, document.world.shown_tree());
    } else if jobs.memo.construction != Some(tree) {
        jobs.memo.construction = Some(tree);
        let world = Arc::clone(&document.world);
        let context = jobs.context.clone();
        jobs.construction.request(&context, ConstructionRequest { tree, world });
    }
}
