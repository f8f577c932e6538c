//! Figures of camera rays: a build counts its own; here they are counted again when the camera has come to rest.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::jobs::figures::{FiguresKey, FiguresRequest};
use crate::app::state::State;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for (key, rays) in jobs.figures.poll(&context) {
        state.remember_rays(&key.tree, &rays);
        state.figures = Some((key, rays));
    }
}

pub fn start(jobs: &mut Jobs, state: &State, now: &Now) {
    let (Some(document), Some(camera), Some([width, height])) =
        (&state.document, state.camera(), state.measured_size())
    else {
        return;
    };
    if (!now.hold && state.is_moving(now.time)) || !jobs.build.is_idle() {
        return;
    }
    let key = FiguresKey { tree: document.tree, camera, width, height };
    if jobs.memo.figures == Some(key) || state.figures.as_ref().is_some_and(|(known, _)| *known == key) {
        return;
    }
    jobs.memo.figures = Some(key);
    let world = Arc::clone(&document.world);
    let settings = crate::render::RenderSettings { width, height, ..state.session.render };
    let context = jobs.context.clone();
    jobs.figures.request(&context, FiguresRequest { key, world, settings });
}
