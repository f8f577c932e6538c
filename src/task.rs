//! What a long-running function shares with whoever started it: a cancel flag and a progress count.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A cancel flag and a progress count, shared by clones. Costs one relaxed load to look at.
///
/// Long functions take `&Task`, look at it at least every millisecond, and return
/// [`Cancelled`] as soon as they see that they were asked to stop.
#[derive(Clone, Debug, Default)]
pub struct Task {
    cancelled: Arc<AtomicBool>,
    progress: Arc<Progress>,
}

#[derive(Debug, Default)]
struct Progress {
    done: AtomicU64,
    total: AtomicU64,
}

/// The answer of a function that was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl Task {
    /// A task that nobody has cancelled, with no known amount of work.
    pub fn new() -> Self {
        Self::default()
    }

    /// A task for one step of this one's work: cancelled with it, but with a progress of its own, so that a step that
    /// announces its amount of work does not overwrite the whole's.
    #[must_use]
    pub fn step(&self) -> Self {
        Self { cancelled: Arc::clone(&self.cancelled), progress: Arc::default() }
    }

    /// Asks every function that holds a clone of this task to stop.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether somebody called [`Task::cancel`].
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// `Err(Cancelled)` once the task is cancelled: `task.check()?` in loops.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Announces the amount of work, in any unit, and sets what is done to zero.
    pub fn start(&self, total: u64) {
        self.progress.done.store(0, Ordering::Relaxed);
        self.progress.total.store(total, Ordering::Relaxed);
    }

    /// Adds finished work, in the unit of [`Task::start`].
    pub fn advance(&self, amount: u64) {
        self.progress.done.fetch_add(amount, Ordering::Relaxed);
    }

    /// The finished share in `0..=1`, or `None` while the amount of work is unknown.
    pub fn fraction(&self) -> Option<f32> {
        let total = self.progress.total.load(Ordering::Relaxed);
        let done = self.progress.done.load(Ordering::Relaxed);
        (total > 0).then(|| (done as f32 / total as f32).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clone_sees_the_cancel() {
        let task = Task::new();
        let clone = task.clone();
        assert_eq!(clone.check(), Ok(()));
        task.cancel();
        assert_eq!(clone.check(), Err(Cancelled));
    }

    #[test]
    fn a_step_is_cancelled_with_the_whole_and_counts_for_itself() {
        let task = Task::new();
        task.start(10);
        let step = task.step();
        step.start(1);
        step.advance(1);
        assert_eq!((task.fraction(), step.fraction()), (Some(0.0), Some(1.0)));
        task.cancel();
        assert!(step.is_cancelled());
    }

    #[test]
    fn fraction_is_unknown_until_started_and_never_above_one() {
        let task = Task::new();
        assert_eq!(task.fraction(), None);
        task.start(4);
        task.advance(3);
        assert_eq!(task.fraction(), Some(0.75));
        task.advance(3);
        assert_eq!(task.fraction(), Some(1.0));
    }
}
