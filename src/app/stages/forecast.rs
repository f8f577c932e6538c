//! Predictions beside ray costs, while the Cost panel is looked at: of the tree at hand first, then of those built before
//! it, so that they can be compared from where the camera stands now.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::TreeKey;
use crate::app::jobs::forecast::{ForecastRequest, ForecastView};
use crate::app::state::State;

/// Builds before the newest that are measured again from another place.
const MOST_EARLIER: usize = 12;

/// What was last asked for.
#[derive(Default)]
pub struct ForecastMemo {
    asked: Option<(TreeKey, ForecastView)>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for (tree, view, forecast) in jobs.forecast.poll(&context) {
        // The old ones stay until there is something to show instead.
        if state.forecast_view != Some((tree.scene, view)) {
            state.forecast_view = Some((tree.scene, view));
            state.forecasts.clear();
            state.forecast_keys.clear();
        }
        match state.forecast_keys.iter().position(|known| *known == tree) {
            Some(i) => state.forecasts[i] = forecast,
            None => {
                state.forecast_keys.push(tree);
                state.forecasts.push(forecast);
            }
        }
    }
}

pub fn start(jobs: &mut Jobs, state: &State, now: &Now) {
    let (Some(document), Some(camera), Some([width, height])) =
        (&state.document, state.camera(), state.measured_size())
    else {
        return;
    };
    let quiet = now.hold || !state.is_moving(now.time);
    if !now.showing.cost || state.animating || !quiet || !jobs.build.is_idle() {
        if jobs.memo.forecast.asked.take().is_some() {
            jobs.forecast.cancel();
        }
        return;
    }
    let view = ForecastView { camera, width, height };
    let current = document.tree;
    let is_known = |tree: &TreeKey| {
        state.forecast_view == Some((tree.scene, view)) && state.forecast_keys.contains(tree)
    };
    let earlier =
        state.history_keys.iter().rev().filter(|key| key.scene == current.scene && key.file.is_none());
    let earlier = earlier.take(if now.hold { 0 } else { MOST_EARLIER });
    let Some(tree) = std::iter::once(&current).chain(earlier).find(|key| !is_known(key)) else { return };
    let waits_for_epo =
        jobs.memo.forecast.asked.is_some_and(|(_, asked)| asked == view) && !jobs.forecast.is_idle();
    let is_asked = jobs.memo.forecast.asked == Some((*tree, view));
    if is_asked || (waits_for_epo && *tree != current) {
        return;
    }
    jobs.memo.forecast.asked = Some((*tree, view));
    let request = ForecastRequest {
        tree: *tree,
        view,
        scene: Arc::clone(&document.world.scene),
        world: (*tree == current).then(|| Arc::clone(&document.world)),
        settings: state.session.render,
    };
    let context = jobs.context.clone();
    jobs.forecast.request(&context, request);
}
