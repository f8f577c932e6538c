//! The thread that owns the films and refines what the viewport shows, sample by sample.

pub mod plan;
pub mod present;
pub mod store;
mod worker;

use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;

use super::Context;
use super::keys::FilmKey;
use crate::render::{DisplaySettings, Film, RenderSettings};
use crate::task::Task;
use crate::world::World;

pub use plan::Pace;
pub use present::Presented;

/// Pictures that the viewport shows at once, at most.
pub const MOST_PICTURES: usize = 2;

/// What the viewport wants to see.
#[derive(Clone)]
pub struct RenderRequest {
    /// One, or two to compare.
    pub pictures: Vec<WantedPicture>,
    pub settings: RenderSettings,
    pub display: DisplaySettings,
    /// Samples a pixel; `None` for no end.
    pub goal: Option<u32>,
    pub pace: Pace,
}

/// A picture of the viewport.
#[derive(Clone)]
pub struct WantedPicture {
    pub slot: usize,
    pub key: FilmKey,
    pub world: Arc<World>,
}

/// A finished step.
#[derive(Clone)]
pub struct Frame {
    pub slot: usize,
    pub key: FilmKey,
    /// In pixels of the full picture; 1 for a film at full size.
    pub scale: u32,
    pub film: Arc<Film>,
    pub presented: Presented,
    /// Wall time of the last sample; `None` if the film was there already.
    pub sample_ms: Option<f64>,
}

/// The window's end of the render thread.
pub struct Renderer {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    request: Option<Arc<RenderRequest>>,
    /// Counts the requests.
    serial: u64,
    stop: bool,
    running: Option<RunningStep>,
    /// The newest of each slot.
    frames: [Option<Frame>; MOST_PICTURES],
    failure: Option<String>,
    resting: bool,
}

/// The sample that is being taken.
struct RunningStep {
    key: FilmKey,
    /// Nothing of this key is shown yet.
    first_look: bool,
    /// There are samples of this key at full size already.
    refines: bool,
    task: Task,
}

impl Renderer {
    pub fn start(context: &Context) -> Self {
        let shared = Arc::new(Shared::default());
        let thread = std::thread::Builder::new()
            .name("render".to_owned())
            .spawn({
                let (shared, context) = (Arc::clone(&shared), context.clone());
                move || worker::run(&shared, &context)
            })
            .expect("the system gives a thread");
        Self { shared, thread: Some(thread) }
    }

    /// Asks for other pictures. The running sample is stopped if nobody will look at it; a first look is finished, so that a
    /// moving camera always shows something.
    pub fn request(&self, request: RenderRequest) {
        let mut state = self.shared.lock();
        if let Some(running) = &state.running
            && !worth_finishing(running, &request)
        {
            running.task.cancel();
        }
        state.request = Some(Arc::new(request));
        state.serial += 1;
        state.resting = false;
        drop(state);
        self.shared.changed.notify_all();
    }

    /// Asks for nothing: the scene is gone.
    pub fn clear(&self) {
        let mut state = self.shared.lock();
        if let Some(running) = &state.running {
            running.task.cancel();
        }
        state.request = None;
        state.serial += 1;
        state.frames = Default::default();
        drop(state);
        self.shared.changed.notify_all();
    }

    /// The newest frame of each slot since the last call.
    pub fn take_frames(&self) -> Vec<Frame> {
        self.shared.lock().frames.iter_mut().filter_map(Option::take).collect()
    }

    /// Takes the text of a bug that stopped a sample.
    pub fn take_failure(&self) -> Option<String> {
        self.shared.lock().failure.take()
    }

    /// Whether nothing is left to do for the last request, and all frames were taken.
    pub fn is_idle(&self) -> bool {
        let state = self.shared.lock();
        (state.request.is_none() || state.resting) && state.frames.iter().all(Option::is_none)
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.stop = true;
        if let Some(running) = &state.running {
            running.task.cancel();
        }
        drop(state);
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was reported when it happened.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("nothing panics while it holds the renderer's lock")
    }
}

/// Whether the running step is still wanted under a new request.
fn worth_finishing(running: &RunningStep, request: &RenderRequest) -> bool {
    if running.refines && request.pace == Pace::Paused {
        return false;
    }
    if running.first_look {
        // A look at an older moment, camera or tree of the same scene is better than none: else a picture that is slower
        // than the hand that drags would never be seen.
        return request.pictures.iter().any(|WantedPicture { key, .. }| {
            key.scene.load == running.key.scene.load && key.subject.view == running.key.subject.view
        });
    }
    request.pictures.iter().any(|picture| picture.key == running.key)
}

#[cfg(test)]
mod tests;
