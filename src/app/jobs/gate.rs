//! The lease of timed measurements: while one is held, nothing else computes.

use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::time::Duration;

use crate::task::{Cancelled, Task};

/// What every computing thread passes. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Gate {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// Leases held or asked for.
    leases: usize,
    held: bool,
    /// Jobs that are inside, each with the task that stops it if it may be stopped for a lease.
    inside: Vec<(u64, Option<Task>)>,
    last_id: u64,
}

/// Leave to compute, until dropped.
#[derive(Debug)]
pub struct Pass {
    gate: Gate,
    id: u64,
}

/// The exclusive right to compute, until dropped.
#[derive(Debug)]
pub struct Lease {
    gate: Gate,
    /// Not yet, while it waits for others to leave.
    held: bool,
}

/// What a lease does to a job that is inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnLease {
    /// The lease waits until it is done.
    Finish,
    /// Its task is cancelled; it tries again after the lease.
    Stop,
}

impl Gate {
    /// Waits while a lease is held or asked for, then counts as computing. `task` is looked at while waiting, and
    /// cancelled for a lease that comes later if `on_lease` says so.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn enter(&self, task: &Task, on_lease: OnLease) -> Result<Pass, Cancelled> {
        let mut state = self.lock();
        while state.leases > 0 {
            task.check()?;
            state = self.wait(state);
        }
        task.check()?;
        state.last_id += 1;
        let id = state.last_id;
        state.inside.push((id, (on_lease == OnLease::Stop).then(|| task.clone())));
        Ok(Pass { gate: self.clone(), id })
    }

    /// Keeps new jobs out, stops those that may be stopped, and waits for the others.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was while it waited.
    pub fn lease(&self, task: &Task) -> Result<Lease, Cancelled> {
        let mut state = self.lock();
        state.leases += 1;
        // From here on the drop of `lease` takes the request back, also when it never was held.
        let mut lease = Lease { gate: self.clone(), held: false };
        for stoppable in state.inside.iter().filter_map(|(_, task)| task.as_ref()) {
            stoppable.cancel();
        }
        while !state.inside.is_empty() || state.held {
            if let Err(cancelled) = task.check() {
                // The drop of the lease locks.
                drop(state);
                return Err(cancelled);
            }
            state = self.wait(state);
        }
        state.held = true;
        lease.held = true;
        Ok(lease)
    }

    /// Whether a lease is held or asked for.
    pub fn is_leased(&self) -> bool {
        self.lock().leases > 0
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().expect("nothing panics while it holds the gate's lock")
    }

    /// Sleeps until something changes; a few milliseconds at most, so that a cancel is seen.
    fn wait<'a>(&self, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        let (state, _) = self
            .shared
            .changed
            .wait_timeout(state, Duration::from_millis(5))
            .expect("nothing panics while it holds the gate's lock");
        state
    }
}

impl Drop for Pass {
    fn drop(&mut self) {
        self.gate.lock().inside.retain(|(id, _)| *id != self.id);
        self.gate.shared.changed.notify_all();
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let mut state = self.gate.lock();
        state.leases -= 1;
        if self.held {
            state.held = false;
        }
        drop(state);
        self.gate.shared.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread;

    #[test]
    fn a_lease_stops_what_may_be_stopped_and_waits_for_the_rest() {
        let gate = Gate::default();
        let (stoppable, lasting) = (Task::new(), Task::new());
        let first = gate.enter(&stoppable, OnLease::Stop).expect("free");
        let second = gate.enter(&lasting, OnLease::Finish).expect("free");
        let done = Arc::new(AtomicBool::new(false));
        let measuring = thread::spawn({
            let (gate, done) = (gate.clone(), Arc::clone(&done));
            move || {
                let lease = gate.lease(&Task::new()).expect("not cancelled");
                done.store(true, Ordering::SeqCst);
                drop(lease);
            }
        });
        while !stoppable.is_cancelled() {
            thread::yield_now();
        }
        assert!(!lasting.is_cancelled());
        drop(first);
        thread::sleep(Duration::from_millis(15));
        assert!(!done.load(Ordering::SeqCst), "one is still inside");
        drop(second);
        measuring.join().expect("no panic");
        assert!(done.load(Ordering::SeqCst) && !gate.is_leased());
    }

    #[test]
    fn while_a_lease_is_held_nobody_enters() {
        let gate = Gate::default();
        let lease = gate.lease(&Task::new()).expect("free");
        let task = Task::new();
        let waiting = thread::spawn({
            let (gate, task) = (gate.clone(), task.clone());
            move || gate.enter(&task, OnLease::Stop).map(drop)
        });
        thread::sleep(Duration::from_millis(15));
        task.cancel();
        assert_eq!(waiting.join().expect("no panic"), Err(Cancelled));
        drop(lease);
        assert!(gate.enter(&Task::new(), OnLease::Stop).is_ok());
    }

    #[test]
    fn a_lease_that_was_given_up_before_it_was_held_does_not_end_another() {
        let gate = Gate::default();
        let first = gate.lease(&Task::new()).expect("free");
        let impatient = Task::new();
        impatient.cancel();
        assert_eq!(gate.lease(&impatient).map(drop), Err(Cancelled));
        assert_eq!(gate.lease(&impatient).map(drop), Err(Cancelled), "the first one is still held");
        assert!(gate.is_leased());
        drop(first);
        assert!(!gate.is_leased() && gate.lease(&Task::new()).is_ok());
    }

    #[test]
    fn a_cancelled_request_for_a_lease_lets_others_in_again() {
        let gate = Gate::default();
        let pass = gate.enter(&Task::new(), OnLease::Finish).expect("free");
        let task = Task::new();
        task.cancel();
        assert_eq!(gate.lease(&task).map(drop), Err(Cancelled));
        assert!(gate.enter(&Task::new(), OnLease::Finish).is_ok());
        drop(pass);
    }
}
