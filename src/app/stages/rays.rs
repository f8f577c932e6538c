//! The rays that are looked at: found in the background when what they depend on changes, their steps at once.

use std::sync::Arc;

use super::{Jobs, Now};
use crate::app::inspection::{RayOrigin, RayView, RaysAsked, RaysKey, Recorded};
use crate::app::jobs::pixel_rays::RaysRequest;
use crate::app::state::State;
use crate::inspect::ray_tree::{PixelQuestion, RaySource};
use crate::render::RenderSettings;

/// What was last asked for.
pub type RaysMemo = Option<RaysKey>;

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for found in jobs.rays.poll(&context) {
        let view = &mut state.inspection.view;
        let others = state.inspection.found.as_ref().is_none_or(|f| f.key.asked != found.key.asked);
        view.chosen = if others { 0 } else { view.chosen.min(found.rays.len().saturating_sub(1)) };
        if others {
            view.step = usize::MAX;
            view.playing = false;
        }
        state.inspection.found = Some(found);
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    if !now.showing.rays {
        state.inspection.view.playing = false;
        return;
    }
    let Some(key) = wanted(state) else {
        state.inspection.found = None;
        state.inspection.recorded = None;
        jobs.memo.rays = None;
        return;
    };
    let is_known = state.inspection.found.as_ref().is_some_and(|found| found.key == key);
    if !is_known && jobs.memo.rays != Some(key) {
        jobs.memo.rays = Some(key);
        if let Some(document) = &state.document {
            let world = Arc::clone(&document.world);
            let context = jobs.context.clone();
            jobs.rays.request(&context, RaysRequest { key, world });
        }
    }
    if is_known {
        record(state);
        state.inspection.play(now.time);
    }
}

/// A single ray takes far less than a frame.
fn record(state: &mut State) {
    let rule = state.session.shadow_rule;
    let inspection = &mut state.inspection;
    let (Some(document), Some(found)) = (&state.document, &inspection.found) else { return };
    let RayView { chosen, asked_as, .. } = inspection.view;
    let Some(ray) = found.rays.get(chosen) else { return };
    let of = (found.key, chosen, asked_as.query(ray.query, ray.kind, rule));
    if document.tree == found.key.tree && inspection.recorded.as_ref().is_none_or(|r| r.of != of) {
        let recorded = Recorded::new(&document.world, found.key, chosen, ray, asked_as, rule);
        inspection.recorded = Some(recorded);
    }
}

fn wanted(state: &State) -> Option<RaysKey> {
    let tree = state.document.as_ref()?.tree;
    let [width, height] = state.picture_size()?;
    let RayView { origin, source, sample, .. } = state.inspection.view;
    let asked = match origin? {
        RayOrigin::Free(ray) => RaysAsked::Free(ray),
        RayOrigin::Pixel { camera, pixel } => RaysAsked::Pixel(PixelQuestion {
            camera,
            settings: RenderSettings { width, height, ..state.session.render },
            shadow_rule: state.session.shadow_rule,
            source: source.unwrap_or(RaySource::of(state.session.view)),
            sample,
            pixel: [pixel[0].min(width - 1), pixel[1].min(height - 1)],
        }),
    };
    Some(RaysKey { tree, asked })
}
