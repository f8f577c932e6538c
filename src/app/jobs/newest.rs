//! Newest next: one job running, one waiting; a newer request replaces the waiting one. No threads in here.

use std::time::{Duration, Instant};

use crate::task::Task;

/// How long a job may run while a newer request waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// It is finished and shown, unless it takes longer than this.
    Within(Duration),
    /// It is stopped at once.
    None,
}

/// Names one started job; later ones are larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Ticket(u64);

/// A job that was started.
#[derive(Clone, Debug)]
pub struct Running<R> {
    pub ticket: Ticket,
    pub request: R,
    pub task: Task,
    pub since: Instant,
}

/// One running job and one waiting request.
#[derive(Debug)]
pub struct NewestNext<R> {
    patience: Patience,
    running: Option<Running<R>>,
    waiting: Option<R>,
    last_ticket: u64,
}

impl<R> NewestNext<R> {
    /// Forgets the waiting request and asks the running job to stop; its results no longer count.
    pub fn cancel(&mut self) {
        self.waiting = None;
        if let Some(running) = &self.running {
            running.task.cancel();
        }
    }
}

impl<R: Clone> NewestNext<R> {
    pub fn new(patience: Patience) -> Self {
        Self { patience, running: None, waiting: None, last_ticket: 0 }
    }

    /// Takes a request. `Some` is a job to start now; else the request waits for the running one.
    #[must_use]
    pub fn request(&mut self, request: R, now: Instant) -> Option<Running<R>> {
        if self.running.is_some() {
            self.waiting = Some(request);
            self.tick(now);
            None
        } else {
            Some(self.start(request, now))
        }
    }

    /// Stops a job that has outlived the patience with a request waiting. Call it now and then.
    pub fn tick(&mut self, now: Instant) {
        if self.waiting.is_none() {
            return;
        }
        if let Some(running) = &self.running {
            let expired = match self.patience {
                Patience::None => true,
                Patience::Within(limit) => now.saturating_duration_since(running.since) > limit,
            };
            if expired {
                running.task.cancel();
            }
        }
    }

    /// A job has come to its end, finished or not. `Some` is the next one to start.
    #[must_use]
    pub fn ended(&mut self, ticket: Ticket, now: Instant) -> Option<Running<R>> {
        if self.running.as_ref().is_none_or(|r| r.ticket != ticket) {
            return None;
        }
        self.running = None;
        self.waiting.take().map(|request| self.start(request, now))
    }

    /// Whether a result of this job is still wanted.
    pub fn accepts(&self, ticket: Ticket) -> bool {
        self.running.as_ref().is_some_and(|r| r.ticket == ticket && !r.task.is_cancelled())
    }

    /// The running job, unless it was asked to stop.
    pub fn running(&self) -> Option<&Running<R>> {
        self.running.as_ref().filter(|r| !r.task.is_cancelled())
    }

    pub fn has_waiting(&self) -> bool {
        self.waiting.is_some()
    }

    /// Nothing runs (not even a job that was asked to stop) and nothing waits.
    pub fn is_idle(&self) -> bool {
        self.running.is_none() && self.waiting.is_none()
    }

    fn start(&mut self, request: R, now: Instant) -> Running<R> {
        self.last_ticket += 1;
        let running = Running { ticket: Ticket(self.last_ticket), request, task: Task::new(), since: now };
        self.running = Some(running.clone());
        running
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_millis(200);

    fn queue() -> (NewestNext<u32>, Instant) {
        (NewestNext::new(Patience::Within(LIMIT)), Instant::now())
    }

    #[test]
    fn the_newest_request_replaces_the_waiting_one() {
        let (mut queue, now) = queue();
        let first = queue.request(1, now).expect("starts at once");
        assert!(queue.request(2, now).is_none());
        assert!(queue.request(3, now).is_none());
        assert!(!first.task.is_cancelled(), "a build in a drag is finished and shown");
        assert!(queue.accepts(first.ticket));
        let next = queue.ended(first.ticket, now).expect("the waiting one starts");
        assert_eq!(next.request, 3);
        assert!(next.ticket > first.ticket);
        assert!(queue.ended(next.ticket, now).is_none());
        assert!(queue.is_idle());
    }

    #[test]
    fn a_slow_job_is_stopped_only_when_a_request_waits() {
        let (mut queue, now) = queue();
        let first = queue.request(1, now).expect("starts at once");
        queue.tick(now + 10 * LIMIT);
        assert!(!first.task.is_cancelled());
        assert!(queue.request(2, now + LIMIT / 2).is_none());
        assert!(!first.task.is_cancelled());
        queue.tick(now + LIMIT + Duration::from_millis(1));
        assert!(first.task.is_cancelled());
        assert!(!queue.accepts(first.ticket));
        assert!(queue.running().is_none());
        assert_eq!(queue.ended(first.ticket, now).map(|r| r.request), Some(2));
    }

    #[test]
    fn without_patience_a_newer_request_stops_the_running_job() {
        let mut queue = NewestNext::new(Patience::None);
        let now = Instant::now();
        let first = queue.request('a', now).expect("starts at once");
        assert!(queue.request('b', now).is_none());
        assert!(first.task.is_cancelled());
    }

    #[test]
    fn a_cancelled_job_is_waited_for_and_its_results_are_dropped() {
        let (mut queue, now) = queue();
        let first = queue.request(1, now).expect("starts at once");
        let _ = queue.request(2, now);
        queue.cancel();
        assert!(first.task.is_cancelled() && !queue.accepts(first.ticket) && !queue.is_idle());
        assert!(queue.request(3, now).is_none(), "two never run at once");
        let next = queue.ended(first.ticket, now).expect("starts when the stopped one is gone");
        assert_eq!(next.request, 3);
        assert!(queue.ended(first.ticket, now).is_none(), "a stale end changes nothing");
        assert!(queue.accepts(next.ticket));
    }
}
