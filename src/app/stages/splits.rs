//! The split costs of the node that is selected, while the Splits panel is looked at.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::accel::NodeId;
use crate::app::jobs::TreeKey;
use crate::app::jobs::splits::SplitRequest;
use crate::app::state::State;

/// What was last asked for.
pub type SplitMemo = Option<(TreeKey, NodeId, [usize; 2])>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for found in jobs.splits.poll(&context) {
        let other = state.splitting.found.as_ref().is_none_or(|f| f.curve.node != found.curve.node);
        state.splitting.found = Some(found);
        if other {
            state.splitting.view.hovered = None;
            state.splitting.sides = None;
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let (Some(document), Some(selection), Some(census)) =
        (&state.document, state.selections.current(), state.census())
    else {
        return;
    };
    if !now.showing.splits || selection.tree != document.tree {
        return;
    }
    let (tree, node) = (document.tree, selection.node());
    let bins = [tree.config.bins, state.splitting.view.bins];
    let found = state.splitting.of(tree, node);
    let is_known = found.is_some_and(|found| found.planes.each_ref().map(|p| p.bins) == bins);
    if is_known || jobs.memo.splits == Some((tree, node, bins)) {
        return;
    }
    jobs.memo.splits = Some((tree, node, bins));
    let request = SplitRequest {
        tree,
        world: Arc::clone(&document.world),
        census: Arc::clone(census),
        node,
        bins,
        known: found.map(|found| Arc::clone(&found.curve)),
    };
    let context = jobs.context.clone();
    jobs.splits.request(&context, request);
}
