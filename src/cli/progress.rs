//! Progress on standard error for whatever takes longer than a second: a bar on a terminal, now and then a line elsewhere.

use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::inspect::sweep::rough_time;
use crate::task::Task;

/// Nothing is said of what is done sooner.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two looks at a task, for a bar. Rare, so that timed measurements are not disturbed.
const GLANCE: Duration = Duration::from_millis(200);
/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Steps of a bar.
const STEPS: u64 = 1000;

/// What is said of work that is being done.
pub struct Said {
    pub what: String,
    /// In 0..=1, where it is known.
    pub fraction: Option<f32>,
    /// `None`: what the fraction and the time so far let expect.
    pub left: Option<Duration>,
}

/// Does some work while its progress is shown.
pub fn watch<T>(what: &str, task: &Task, work: impl FnOnce() -> T) -> T {
    watch_saying(&|| Said { what: what.to_owned(), fraction: task.fraction(), left: None }, work)
}

/// Does some work that says itself how far it is.
pub fn watch_saying<T>(say: &(dyn Fn() -> Said + Sync), work: impl FnOnce() -> T) -> T {
    let (done, stop) = channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || show(say, &stop));
        let result = work();
        drop(done);
        result
    })
}

fn show(say: &dyn Fn() -> Said, stop: &Receiver<()>) {
    if stopped(stop, PATIENCE) {
        return;
    }
    if io::stderr().is_terminal() { show_bar(say, stop) } else { show_lines(say, stop) }
}

/// Whether the work ends within a time.
fn stopped(stop: &Receiver<()>, within: Duration) -> bool {
    stop.recv_timeout(within) != Err(RecvTimeoutError::Timeout)
}

fn show_bar(say: &dyn Fn() -> Said, stop: &Receiver<()>) {
    let bar = ProgressBar::new(STEPS);
    let style = |template: &str| {
        ProgressStyle::with_template(template).expect("a constant template").progress_chars("=> ")
    };
    let known = style("{msg} [{bar:32}] {percent:>3} %, {elapsed}, {eta} left");
    let own_time = style("{msg} [{bar:32}] {percent:>3} %, {elapsed}, about {prefix} left");
    let unknown = style("{spinner} {msg}, {elapsed}");
    loop {
        let Said { what, fraction, left } = say();
        bar.set_message(what);
        match fraction {
            Some(fraction) => {
                bar.set_style(if left.is_some() { own_time.clone() } else { known.clone() });
                bar.set_prefix(left.map(rough_time).unwrap_or_default());
                bar.set_position((f64::from(fraction) * STEPS as f64) as u64);
            }
            None => {
                bar.set_style(unknown.clone());
                bar.tick();
            }
        }
        if stopped(stop, GLANCE) {
            break;
        }
    }
    bar.finish_and_clear();
}

fn show_lines(say: &dyn Fn() -> Said, stop: &Receiver<()>) {
    let start = Instant::now();
    loop {
        let Said { what, fraction, left } = say();
        let seconds = (start.elapsed() + PATIENCE).as_secs();
        let share = fraction.map_or_else(String::new, |f| format!(", {:.0} %", 100.0 * f));
        let left = left.map_or_else(String::new, |left| format!(", about {} left", rough_time(left)));
        let _ = writeln!(io::stderr(), "{what}{share}, {seconds} s{left}");
        if stopped(stop, LINE_EVERY) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_work_is_done_without_waiting() {
        let start = Instant::now();
        assert_eq!(watch("counting", &Task::new(), || 7), 7);
        assert!(start.elapsed() < PATIENCE / 2);
    }
}
