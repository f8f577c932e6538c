//! A part of the picture, and its most expensive pixels, while the Heatmap panel is looked at.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::region::RegionRequest;
use crate::app::state::State;
use crate::inspect::region::Region;

/// What was last asked for.
pub type RegionMemo = Option<(u64, Option<Region>)>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for figures in jobs.region.poll(&context) {
        state.region_figures = Some(figures);
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let Some(size) = state.picture_size() else { return };
    // Of a picture of another size the pixels are others.
    state.region = state.region.filter(|region| region.size == size);
    let wanted = state.picture(0).filter(|picture| picture.frame.film.numbers_count() > 0);
    let Some(picture) = wanted.filter(|_| now.showing.heatmap && !state.is_moving(now.time)) else { return };
    let asked = (picture.version, state.region);
    let is_known = state.region_figures.as_ref().is_some_and(|f| (f.version, f.region) == asked);
    if is_known || jobs.memo.region == Some(asked) {
        return;
    }
    jobs.memo.region = Some(asked);
    let film = Arc::clone(&picture.frame.film);
    let request = RegionRequest { version: picture.version, film, region: state.region, size };
    let context = jobs.context.clone();
    jobs.region.request(&context, request);
}
