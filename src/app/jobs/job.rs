//! A kind of work with its queue: runs requests on a pool, newest next, and hands what they say to the window's thread.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use super::newest::{NewestNext, Patience, Running, Ticket};
use super::{Context, PoolKind};
use crate::app::view::JobStatus;
use crate::task::Task;

/// What a piece of work gets: its request, its cancel flag, where its messages go, and the job's surroundings.
pub struct Run<'a, R, M> {
    pub request: &'a R,
    pub task: &'a Task,
    pub context: &'a Context,
    sender: &'a Sender<(Ticket, Event<M>)>,
    ticket: Ticket,
}

impl<R, M> Run<'_, R, M> {
    /// Sends a message to the window, which wakes up.
    pub fn emit(&self, message: M) {
        // The window may be gone; then nobody wants the message.
        let _ = self.sender.send((self.ticket, Event::Message(message)));
        self.context.wake();
    }
}

enum Event<M> {
    Message(M),
    Ended,
    Panicked(String),
}

type Work<R, M> = dyn Fn(&Run<R, M>) + Send + Sync;

/// One kind of work. Lives on the window's thread and never blocks it.
pub struct Job<R, M> {
    queue: NewestNext<R>,
    pool: PoolKind,
    work: Arc<Work<R, M>>,
    sender: Sender<(Ticket, Event<M>)>,
    receiver: Receiver<(Ticket, Event<M>)>,
    /// The last request that ran into a bug of the program, in words.
    failure: Option<String>,
}

impl<R: Clone + Send + 'static, M: Send + 'static> Job<R, M> {
    pub fn new(
        patience: Patience,
        pool: PoolKind,
        work: impl Fn(&Run<R, M>) + Send + Sync + 'static,
    ) -> Self {
        let (sender, receiver) = channel();
        let queue = NewestNext::new(patience);
        Self { queue, pool, work: Arc::new(work), sender, receiver, failure: None }
    }

    pub fn request(&mut self, context: &Context, request: R) {
        if let Some(running) = self.queue.request(request, Instant::now()) {
            self.spawn(context, running);
        }
    }

    /// The messages of jobs that still count, oldest first; starts the waiting request when the running one has ended.
    pub fn poll(&mut self, context: &Context) -> Vec<M> {
        let mut messages = Vec::new();
        self.queue.tick(Instant::now());
        while let Ok((ticket, event)) = self.receiver.try_recv() {
            match event {
                Event::Message(message) => {
                    if self.queue.accepts(ticket) {
                        messages.push(message);
                    }
                    continue;
                }
                Event::Panicked(what) => self.failure = Some(what),
                Event::Ended => {}
            }
            if let Some(running) = self.queue.ended(ticket, Instant::now()) {
                self.spawn(context, running);
            }
        }
        messages
    }

    pub fn cancel(&mut self) {
        self.queue.cancel();
    }

    pub fn is_idle(&self) -> bool {
        self.queue.is_idle()
    }

    /// The job that runs, unless it was asked to stop.
    pub fn running(&self) -> Option<&Running<R>> {
        self.queue.running()
    }

    /// The job that runs, for the screen.
    pub fn status(&self, what: impl FnOnce(&R) -> String) -> Option<JobStatus> {
        self.queue.running().map(|running| JobStatus {
            what: what(&running.request),
            elapsed: running.since.elapsed(),
            fraction: running.task.fraction(),
        })
    }

    /// How long the running job has been at it.
    pub fn elapsed(&self) -> Option<Duration> {
        self.queue.running().map(|running| running.since.elapsed())
    }

    /// Takes the text of a bug that stopped a job.
    pub fn take_failure(&mut self) -> Option<String> {
        self.failure.take()
    }

    fn spawn(&self, context: &Context, running: Running<R>) {
        let (work, sender, context) = (Arc::clone(&self.work), self.sender.clone(), context.clone());
        context.pools().get(self.pool).spawn(move || {
            let Running { ticket, request, task, .. } = running;
            let run = Run { request: &request, task: &task, context: &context, sender: &sender, ticket };
            // A bug in one job must not take the window, and the user's work, with it.
            let event = match catch_unwind(AssertUnwindSafe(|| work(&run))) {
                Ok(()) => Event::Ended,
                Err(panic) => Event::Panicked(panic_text(&*panic)),
            };
            let _ = sender.send((ticket, event));
            context.wake();
        });
    }
}

impl<R, M> Drop for Job<R, M> {
    fn drop(&mut self) {
        self.queue.cancel();
    }
}

/// What a panic said.
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    panic
        .downcast_ref::<String>()
        .cloned()
        .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()))
        .unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    fn drain(job: &mut Job<u32, u32>, context: &Context) -> Vec<u32> {
        let start = Instant::now();
        let mut messages = Vec::new();
        while !job.is_idle() {
            messages.extend(job.poll(context));
            assert!(start.elapsed() < Duration::from_secs(20), "the job does not end");
            thread::sleep(Duration::from_millis(1));
        }
        messages
    }

    #[test]
    fn the_first_and_the_newest_of_many_requests_are_answered() {
        let context = Context::for_tests();
        let mut job = Job::new(Patience::Within(Duration::from_secs(60)), PoolKind::Work, |run| {
            thread::sleep(Duration::from_millis(20));
            run.emit(*run.request);
        });
        for i in 0..50 {
            job.request(&context, i);
        }
        assert_eq!(drain(&mut job, &context), [0, 49]);
    }

    #[test]
    fn a_bug_in_a_job_is_reported_and_the_next_request_runs() {
        let context = Context::for_tests();
        let mut job = Job::new(Patience::None, PoolKind::Work, |run: &Run<u32, u32>| {
            assert!(*run.request != 1, "one is bad");
            run.emit(*run.request);
        });
        job.request(&context, 1);
        assert!(drain(&mut job, &context).is_empty());
        assert_eq!(job.take_failure().as_deref(), Some("one is bad"));
        job.request(&context, 2);
        assert_eq!(drain(&mut job, &context), [2]);
        assert_eq!(job.take_failure(), None);
    }

    #[test]
    fn a_cancelled_job_says_nothing_more() {
        let context = Context::for_tests();
        let mut job = Job::new(Patience::Within(Duration::from_secs(60)), PoolKind::Work, |run| {
            while !run.task.is_cancelled() {
                thread::yield_now();
            }
            run.emit(*run.request);
        });
        job.request(&context, 7);
        assert!(job.status(|r| r.to_string()).is_some_and(|s| s.what == "7"));
        job.cancel();
        assert!(job.status(|r| r.to_string()).is_none());
        assert!(drain(&mut job, &context).is_empty());
    }
}
