//! What the bins do, while the Cost panel is looked at: a few points at once, their times when all is quiet, the rest
//! after that.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Jobs, Now};
use crate::app::jobs::bin_curve::{CurveKey, CurveMessage, CurveRequest, Stretch, worth_timing};
use crate::app::state::State;
use crate::app::view::BinCurve;
use crate::inspect::bin_sweep::BinPoint;

/// A curve is started when what it depends on has not changed for this long.
const DEBOUNCE: Duration = Duration::from_millis(350);

/// Times are taken, and the rest of the curve, when nothing has changed for this long.
const QUIET: Duration = Duration::from_millis(1500);

/// Where the curve stands.
#[derive(Default)]
pub struct CurveMemo {
    wanted: Option<(CurveKey, Instant)>,
    running: Option<Stretch>,
    finished: Vec<Stretch>,
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.curve.poll(&context) {
        match message {
            CurveMessage::Point(point) => insert(&mut state.curve, point),
            CurveMessage::Done => jobs.memo.curve.finished.extend(jobs.memo.curve.running.take()),
        }
    }
    // Times are taken with the picture standing still, so a change of what is shown comes first.
    let memo = &mut jobs.memo.curve;
    if memo.running == Some(Stretch::Timed)
        && jobs.curve.running().is_some_and(|running| state.last_change > running.since)
    {
        memo.running = None;
        jobs.curve.cancel();
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    if !now.showing.cost || state.animating {
        stop(jobs);
        state.curve.pending = 0;
        return;
    }
    let Some(key) = wanted_key(state) else { return };
    let memo = &mut jobs.memo.curve;
    if memo.wanted.is_none_or(|(wanted, _)| wanted != key) {
        memo.wanted = Some((key, now.time));
        stop(jobs);
        if !now.hold {
            return;
        }
    }
    let memo = &mut jobs.memo.curve;
    let since = memo.wanted.map_or(Duration::ZERO, |(_, at)| now.time.saturating_duration_since(at));
    let up_to_date =
        jobs.build.is_idle() && state.document.as_ref().is_some_and(|d| d.tree.scene == key.scene);
    if memo.running.is_some() || !up_to_date || (!now.hold && since < DEBOUNCE) {
        state.curve.pending = pending(jobs, state);
        return;
    }
    if state.curve_key != Some(key) {
        state.curve_key = Some(key);
        state.curve = BinCurve::default();
        memo.finished.clear();
    }
    let quiet = now.time.saturating_duration_since(state.last_change) >= QUIET;
    if let Some(stretch) = next_stretch(&memo.finished, &state.curve, quiet, now.hold) {
        request(jobs, state, key, stretch);
    }
    state.curve.pending = pending(jobs, state);
}

/// Whether a frame is needed later for a curve that waits.
pub fn waits(jobs: &Jobs, now: &Now) -> bool {
    let memo = &jobs.memo.curve;
    let last = if now.hold { Stretch::Coarse } else { Stretch::Rest };
    now.showing.cost && memo.wanted.is_some() && memo.running.is_none() && !memo.finished.contains(&last)
}

fn next_stretch(finished: &[Stretch], curve: &BinCurve, quiet: bool, hold: bool) -> Option<Stretch> {
    if !finished.contains(&Stretch::Coarse) {
        return Some(Stretch::Coarse);
    }
    if hold || !quiet {
        return None;
    }
    let known: Vec<BinPoint> = curve.points.iter().chain(&curve.sweep).copied().collect();
    if !finished.contains(&Stretch::Timed) && worth_timing(&known) {
        return Some(Stretch::Timed);
    }
    (!finished.contains(&Stretch::Rest)).then_some(Stretch::Rest)
}

fn request(jobs: &mut Jobs, state: &State, key: CurveKey, stretch: Stretch) {
    let Some(document) = &state.document else { return };
    jobs.memo.curve.running = Some(stretch);
    let known = |timed: bool| {
        let points = state.curve.points.iter().chain(&state.curve.sweep);
        points.filter(|p| p.timed_alone || !timed).map(|p| p.bins).collect()
    };
    let request = CurveRequest {
        key,
        scene: Arc::clone(&document.world.scene),
        settings: state.session.render,
        stretch,
        skip: known(stretch == Stretch::Timed),
    };
    let context = jobs.context.clone();
    jobs.curve.request(&context, request);
}

fn stop(jobs: &mut Jobs) {
    if jobs.memo.curve.running.take().is_some() {
        jobs.curve.cancel();
    }
}

fn wanted_key(state: &State) -> Option<CurveKey> {
    let [width, height] = state.measured_size()?;
    let settings = crate::render::RenderSettings { width, height, ..state.session.render };
    Some(CurveKey::new(state.wanted_scene()?, &state.camera()?, &settings, state.session.build()))
}

/// Points of the running stretch that are still to come.
fn pending(jobs: &Jobs, state: &State) -> usize {
    let Some(stretch) = jobs.memo.curve.running else { return 0 };
    let known = |bins: &Option<usize>| {
        let timed_only = stretch == Stretch::Timed;
        let mut points = state.curve.points.iter().chain(&state.curve.sweep);
        points.any(|p| p.bins == *bins && (p.timed_alone || !timed_only))
    };
    stretch.bins().iter().filter(|bins| !known(bins)).count()
}

/// Puts a point in its place; a time taken alone is never replaced by one that was not.
fn insert(curve: &mut BinCurve, point: BinPoint) {
    let Some(bins) = point.bins else {
        if curve.sweep.is_none_or(|old| point.timed_alone || !old.timed_alone) {
            curve.sweep = Some(point);
        }
        return;
    };
    match curve.points.binary_search_by_key(&Some(bins), |p| p.bins) {
        Ok(i) if curve.points[i].timed_alone && !point.timed_alone => {}
        Ok(i) => curve.points[i] = point,
        Err(i) => curve.points.insert(i, point),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(bins: Option<usize>, build_ms: f64, timed_alone: bool) -> BinPoint {
        BinPoint { bins, sah_cost: None, nodes_visited_mean: None, build_ms, timed_alone }
    }

    #[test]
    fn points_stand_in_order_and_keep_the_better_time() {
        let mut curve = BinCurve::default();
        for (bins, ms, alone) in [(8, 1.0, false), (2, 2.0, false), (8, 3.0, true), (8, 4.0, false)] {
            insert(&mut curve, point(Some(bins), ms, alone));
        }
        insert(&mut curve, point(None, 5.0, true));
        insert(&mut curve, point(None, 6.0, false));
        let seen: Vec<_> = curve.points.iter().map(|p| (p.bins, p.build_ms)).collect();
        assert_eq!(seen, [(Some(2), 2.0), (Some(8), 3.0)]);
        assert_eq!(curve.sweep.map(|p| p.build_ms), Some(5.0));
    }

    #[test]
    fn the_curve_goes_coarse_timed_rest_and_waits_for_quiet() {
        let quick = BinCurve { points: vec![point(Some(2), 5.0, false)], ..BinCurve::default() };
        assert_eq!(next_stretch(&[], &quick, false, true), Some(Stretch::Coarse));
        assert_eq!(next_stretch(&[Stretch::Coarse], &quick, false, false), None);
        assert_eq!(next_stretch(&[Stretch::Coarse], &quick, true, false), Some(Stretch::Timed));
        let both = [Stretch::Coarse, Stretch::Timed];
        assert_eq!(next_stretch(&both, &quick, true, false), Some(Stretch::Rest));
        assert_eq!(next_stretch(&both, &quick, true, true), None);
        let slow = BinCurve { points: vec![point(Some(2), 60_000.0, false)], ..BinCurve::default() };
        assert_eq!(next_stretch(&[Stretch::Coarse], &slow, true, false), Some(Stretch::Rest));
    }
}
