//! A sweep: measured under the lease, given up when the user changes something, and gone on with when all is quiet. Points
//! that are there stay; those of another scene are marked.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Jobs, Now};
use crate::app::jobs::sweep::{SweepKey, SweepMessage, SweepPlan, SweepRequest};
use crate::app::state::State;
use crate::app::view::{Stale, SweepState};
use crate::export::points::Question;
use crate::inspect::sweep::{Progress, same_tree};
use crate::render::RenderSettings;
use crate::scene::Scene;
use crate::session::Session;

/// How long nothing may have changed before a measurement starts.
const QUIET: Duration = Duration::from_millis(900);

/// The sweep that was asked for last.
#[derive(Default)]
pub struct SweepMemo {
    asked: Option<Asked>,
    /// It is to go on, now or when all is quiet.
    wanted: bool,
    running: bool,
    progress: Progress,
}

/// With all that its points depend on, as it was then.
struct Asked {
    plan: SweepPlan,
    key: SweepKey,
    scene: Arc<Scene>,
    settings: RenderSettings,
    costs: [f32; 2],
}

/// Starts a sweep. Points of the same scene and view stay, and are not measured again.
pub fn begin(jobs: &mut Jobs, state: &mut State, plan: SweepPlan) {
    let (Some(key), Some(document)) = (current_key(state), &state.document) else { return };
    let settings = sized(state);
    let base = plan.base;
    let costs = [base.traversal_cost, base.intersection_cost];
    let scene = Arc::clone(&document.world.scene);
    let question = question(state, &key, settings);
    let same = state.sweep.question.as_ref() == Some(&question)
        && jobs.memo.sweep.asked.as_ref().is_some_and(|asked| asked.key == key);
    if !same {
        state.sweep = SweepState::default();
    }
    state.sweep.best = None;
    state.sweep.question = Some(question);
    stop(jobs);
    let memo = &mut jobs.memo.sweep;
    let rest = match plan.search {
        Some(_) => Vec::new(),
        None => plan.grid.points(&base),
    };
    state.sweep.total = plan.search.as_ref().map_or(rest.len(), |search| search.budget);
    state.sweep.search = plan.search.is_some();
    memo.progress = Progress::of(rest);
    memo.asked = Some(Asked { plan, key, scene, settings, costs });
    memo.wanted = true;
}

/// Holds the sweep, or lets it go on.
pub fn set_paused(jobs: &mut Jobs, paused: bool) {
    if paused {
        stop(jobs);
    }
    jobs.memo.sweep.wanted = !paused && jobs.memo.sweep.asked.is_some();
}

/// Forgets the sweep and its points.
pub fn clear(jobs: &mut Jobs, state: &mut State) {
    stop(jobs);
    jobs.memo.sweep = SweepMemo::default();
    state.sweep = SweepState::default();
}

fn stop(jobs: &mut Jobs) {
    if std::mem::take(&mut jobs.memo.sweep.running) {
        jobs.sweep.cancel();
    }
    jobs.memo.sweep.wanted = false;
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    for message in jobs.sweep.poll(&context) {
        let memo = &mut jobs.memo.sweep;
        match message {
            SweepMessage::Started { name } => memo.progress.started(&name, Instant::now()),
            SweepMessage::Point { point, took } => {
                memo.progress.finished(&point.config, took);
                match state.sweep.points.iter_mut().find(|p| same_tree(&p.config, &point.config)) {
                    Some(known) => *known = *point,
                    None => state.sweep.points.push(*point),
                }
            }
            SweepMessage::Done(best) => {
                (memo.wanted, memo.running) = (false, false);
                state.sweep.best = best.map(|best| *best);
                state.sweep.finished = true;
            }
        }
    }
    // A change of what is shown comes first; the sweep goes on when all is quiet.
    let changed = jobs.sweep.running().is_some_and(|running| state.last_change > running.since);
    if jobs.memo.sweep.running && changed {
        jobs.memo.sweep.running = false;
        jobs.sweep.cancel();
    }
}

pub fn start(jobs: &mut Jobs, state: &mut State, now: &Now) {
    let key = current_key(state);
    let Some(asked) = &jobs.memo.sweep.asked else { return };
    state.sweep.stale = match key {
        Some(key) if key.scene != asked.key.scene => Some(Stale::Scene),
        Some(key) if key != asked.key => Some(Stale::View),
        Some(_) | None => None,
    };
    if state.sweep.stale == Some(Stale::Scene) {
        stop(jobs);
    }
    let quiet = now.hold || now.time.saturating_duration_since(state.last_change) >= QUIET;
    let idle = jobs.build.is_idle() && jobs.load.is_idle() && !state.animating;
    let memo = &mut jobs.memo.sweep;
    if memo.wanted
        && !memo.running
        && quiet
        && idle
        && let Some(asked) = &memo.asked
    {
        memo.running = true;
        state.sweep.finished = false;
        let request = SweepRequest {
            plan: asked.plan.clone(),
            scene: Arc::clone(&asked.scene),
            camera: asked.key.camera,
            settings: asked.settings,
            count: asked.key.count,
            costs: asked.costs,
            known: state.sweep.points.clone(),
        };
        let context = jobs.context.clone();
        jobs.sweep.request(&context, request);
    }
    show(jobs, state, now.time);
}

/// Whether a frame is needed soon to start a sweep that waits for quiet.
pub fn waits(jobs: &Jobs) -> bool {
    jobs.memo.sweep.wanted && !jobs.memo.sweep.running
}

/// What the panel says of it.
fn show(jobs: &Jobs, state: &mut State, now: Instant) {
    let memo = &jobs.memo.sweep;
    let sweep = &mut state.sweep;
    let progress = &memo.progress;
    sweep.running = jobs.sweep.status(|_| match progress.current() {
        Some(name) => format!("sweep: {name}"),
        None => "sweep".to_owned(),
    });
    sweep.waiting = memo.wanted && !memo.running;
    sweep.can_resume =
        memo.asked.is_some() && !memo.wanted && !sweep.finished && sweep.stale != Some(Stale::Scene);
    if sweep.search {
        let fraction = sweep.running.as_ref().and_then(|job| job.fraction).unwrap_or(0.0);
        sweep.done = (fraction * sweep.total as f32).round() as usize;
        sweep.left = progress.time_for(sweep.total.saturating_sub(sweep.done));
    } else {
        sweep.done = sweep.total.saturating_sub(progress.rest());
        sweep.left = progress.time_left(now);
    }
    sweep.a_point = progress.time_for(1);
}

fn current_key(state: &State) -> Option<SweepKey> {
    let RenderSettings { width, height, max_depth, threads, .. } = sized(state);
    let (scene, camera) = (state.wanted_scene()?, state.camera()?);
    Some(SweepKey { scene, camera, width, height, max_depth, threads, count: state.session.count })
}

/// Points are measured at the size of the viewport.
fn sized(state: &State) -> RenderSettings {
    let mut settings = state.session.render;
    if let Some([width, height]) = state.measured_size() {
        (settings.width, settings.height) = (width, height);
    }
    settings
}

fn question(state: &State, key: &SweepKey, settings: RenderSettings) -> Question {
    let session = Session { render: settings, ..state.session.clone() };
    Question::new(&session, &key.camera)
}
