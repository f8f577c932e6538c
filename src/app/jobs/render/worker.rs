//! The loop of the render thread.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::plan::{SlotProgress, Step, next_step};
use super::present::present;
use super::store::FilmStore;
use super::{Frame, Pace, RenderRequest, RunningStep, Shared, WantedPicture};
use crate::app::jobs::gate::OnLease;
use crate::app::jobs::job::panic_text;
use crate::app::jobs::keys::FilmKey;
use crate::app::jobs::{Context, PoolKind};
use crate::render::integrate::add_sample;
use crate::render::{CountKind, Film, RenderSettings, View};
use crate::task::{Cancelled, Task};

/// Memory for films that are not shown now.
const MOST_FILM_BYTES: usize = 256 << 20;

/// Fast samples are shown at most this often.
const SHOW_EVERY: Duration = Duration::from_millis(40);

/// Serves requests until the renderer is dropped.
pub(super) fn run(shared: &Arc<Shared>, context: &Context) {
    let mut worker = Worker {
        shared: Arc::clone(shared),
        context: context.clone(),
        store: FilmStore::new(MOST_FILM_BYTES),
        pace_ns: HashMap::new(),
        slots: Vec::new(),
        loads: Vec::new(),
    };
    let mut serial = 0;
    let mut resting = true;
    while let Some(request) = worker.next_request(&mut serial, resting) {
        worker.adopt(&request);
        let progress: Vec<_> = worker.slots.iter().map(|slot| worker.progress(slot, &request)).collect();
        let step = next_step(&progress, request.pace);
        resting = match step {
            Step::Rest => {
                worker.show_rest(&request);
                true
            }
            Step::Coarse { slot, scale } => !worker.attempt(&request, slot, scale),
            Step::Full { slot } => !worker.attempt(&request, slot, 1),
        };
    }
}

struct Worker {
    shared: Arc<Shared>,
    context: Context,
    store: FilmStore,
    /// Nanoseconds a pixel and sample, by what is rendered.
    pace_ns: HashMap<(View, CountKind), f64>,
    slots: Vec<Slot>,
    loads: Vec<u64>,
}

/// What one of the viewport's pictures has got so far.
struct Slot {
    /// Of the viewport.
    number: usize,
    key: FilmKey,
    coarse: Option<u32>,
    /// Samples of the film at full size that were shown.
    shown_samples: u32,
    shown_at: Option<Instant>,
    sample_ms: Option<f64>,
}

impl Worker {
    /// The newest request; waits for a newer one than `serial` if `wait`. `None` when it is time to end.
    fn next_request(&self, serial: &mut u64, wait: bool) -> Option<Arc<RenderRequest>> {
        let mut state = self.shared.lock();
        loop {
            if state.stop {
                return None;
            }
            if state.serial != *serial || !wait {
                *serial = state.serial;
                if let Some(request) = &state.request {
                    return Some(Arc::clone(request));
                }
            } else if !state.resting {
                state.resting = true;
                // The window may be waiting for the end, too.
                self.context.wake();
            }
            state = self.shared.changed.wait(state).expect("nothing panics while it holds the lock");
        }
    }

    /// Brings the slots in line with the request. A film that is there already is shown at once.
    fn adopt(&mut self, request: &RenderRequest) {
        let loads: Vec<u64> = request.pictures.iter().map(|picture| picture.key.scene.load).collect();
        if loads != self.loads {
            if loads.first() != self.loads.first() {
                self.pace_ns.clear();
            }
            if !loads.is_empty() {
                self.store.keep_loads(&loads);
            }
            self.loads = loads;
        }
        self.slots.truncate(request.pictures.len());
        for (i, WantedPicture { slot: number, key, .. }) in request.pictures.iter().enumerate() {
            let number = *number;
            if self.slots.get(i).is_some_and(|slot| (slot.number, slot.key) == (number, *key)) {
                continue;
            }
            let slot =
                Slot { number, key: *key, coarse: None, shown_samples: 0, shown_at: None, sample_ms: None };
            match self.slots.get_mut(i) {
                Some(old) => *old = slot,
                None => self.slots.push(slot),
            }
            if self.store.samples(key) > 0 {
                self.show_film(i, request);
            }
        }
    }

    fn progress(&self, slot: &Slot, request: &RenderRequest) -> SlotProgress {
        let key = &slot.key;
        let pixels = f64::from(key.width) * f64::from(key.height);
        SlotProgress {
            samples: self.store.samples(key),
            goal: if key.refines() { request.goal } else { Some(1) },
            coarse: slot.coarse,
            full_ms: self.pace_ns.get(&(key.subject.view, key.subject.count)).map(|ns| ns * pixels * 1e-6),
        }
    }

    /// Takes one sample and shows it. `false` if it ran into a bug: then nothing is tried again until the request
    /// changes.
    fn attempt(&mut self, request: &Arc<RenderRequest>, slot: usize, scale: u32) -> bool {
        let task = Task::new();
        let key = self.slots[slot].key;
        let first_look = self.slots[slot].shown_at.is_none();
        let refines = scale == 1 && self.store.samples(&key) > 0;
        if !self.begin(request, RunningStep { key, first_look, refines, task: task.clone() }) {
            return true;
        }
        let pool = self.context.pools().get(PoolKind::Render);
        let result =
            catch_unwind(AssertUnwindSafe(|| pool.install(|| self.sample(request, slot, scale, &task))));
        self.shared.lock().running = None;
        match result {
            // A cancelled step is planned anew: the request, or the lease, says how to go on.
            Ok(Ok(()) | Err(Cancelled)) => true,
            Err(panic) => {
                self.shared.lock().failure = Some(panic_text(&*panic));
                self.context.wake();
                false
            }
        }
    }

    /// Announces the step; `false` if the request has changed since it was planned.
    fn begin(&self, request: &Arc<RenderRequest>, step: RunningStep) -> bool {
        let mut state = self.shared.lock();
        if state.stop || !state.request.as_ref().is_some_and(|current| Arc::ptr_eq(current, request)) {
            return false;
        }
        state.running = Some(step);
        true
    }

    fn sample(
        &mut self,
        request: &RenderRequest,
        slot: usize,
        scale: u32,
        task: &Task,
    ) -> Result<(), Cancelled> {
        let pass = self.context.gate.enter(task, OnLease::Stop)?;
        let key = self.slots[slot].key;
        let film = if scale == 1 { self.store.take(&key) } else { Arc::new(coarse_film(&key, scale)) };
        let (film, ms) = add(film, request, slot, task);
        drop(pass);
        let Some(ms) = ms else {
            if scale == 1 {
                self.store.put(key, film);
            }
            return Err(Cancelled);
        };
        self.learn(&key, &film, ms);
        self.slots[slot].sample_ms = Some(ms);
        if scale == 1 {
            self.store.put(key, film);
            if self.is_due(slot, request) {
                // Two pictures that are the same for every tree share a film.
                for same in (0..self.slots.len()).filter(|i| self.slots[*i].key == key).collect::<Vec<_>>() {
                    self.show_film(same, request);
                }
            }
        } else {
            self.slots[slot].coarse = Some(scale);
            self.show(slot, scale, film, request);
        }
        Ok(())
    }

    /// Remembers how long a pixel takes.
    fn learn(&mut self, key: &FilmKey, film: &Film, ms: f64) {
        let ns = ms * 1e6 / (f64::from(film.width) * f64::from(film.height)).max(1.0);
        let known = self.pace_ns.entry((key.subject.view, key.subject.count)).or_insert(ns);
        *known = 0.5 * (*known + ns);
    }

    /// Whether the newest sample of a film is worth showing now.
    fn is_due(&self, slot: usize, request: &RenderRequest) -> bool {
        let slot = &self.slots[slot];
        let samples = self.store.samples(&slot.key);
        samples <= 2
            || self.progress(slot, request).goal.is_some_and(|goal| samples >= goal)
            || slot.shown_at.is_none_or(|at| at.elapsed() >= SHOW_EVERY)
    }

    /// Shows what was left out for being too fast.
    fn show_rest(&mut self, request: &RenderRequest) {
        for i in 0..self.slots.len() {
            if self.store.samples(&self.slots[i].key) != self.slots[i].shown_samples
                && request.pace != Pace::Moving
            {
                self.show_film(i, request);
            }
        }
    }

    fn show_film(&mut self, slot: usize, request: &RenderRequest) {
        if let Some(film) = self.store.get(&self.slots[slot].key).cloned() {
            self.slots[slot].shown_samples = film.samples;
            self.show(slot, 1, film, request);
        }
    }

    fn show(&mut self, slot: usize, scale: u32, film: Arc<Film>, request: &RenderRequest) {
        // The settings may have changed while the sample was taken.
        let display = self.shared.lock().request.as_ref().map_or(request.display, |newest| newest.display);
        let pool = self.context.pools().get(PoolKind::Render);
        let presented = pool.install(|| present(&film, &display));
        let state = &mut self.slots[slot];
        state.shown_at = Some(Instant::now());
        let (slot, key, sample_ms) = (state.number, state.key, state.sample_ms);
        self.shared.lock().frames[slot] = Some(Frame { slot, key, scale, film, presented, sample_ms });
        self.context.wake();
    }
}

/// Adds a sample; the time it took, or `None` if it was cancelled and the film is as before.
fn add(mut film: Arc<Film>, request: &RenderRequest, slot: usize, task: &Task) -> (Arc<Film>, Option<f64>) {
    let WantedPicture { key, world, .. } = &request.pictures[slot];
    let settings = RenderSettings { width: film.width, height: film.height, ..request.settings };
    let start = Instant::now();
    // Copies the film if the window still shows it.
    let target = Arc::make_mut(&mut film);
    let done = add_sample(target, world, &key.camera, &settings, task).is_ok();
    (film, done.then(|| start.elapsed().as_secs_f64() * 1e3))
}

fn coarse_film(key: &FilmKey, scale: u32) -> Film {
    Film::new(key.width.div_ceil(scale).max(1), key.height.div_ceil(scale).max(1), key.subject)
}
