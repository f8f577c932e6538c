//! Progress on standard error for whatever takes longer than a second: a bar on a terminal, now and then a line elsewhere.

use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::task::Task;

/// Nothing is said of what is done sooner.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two looks at a task, for a bar. Rare, so that timed measurements are not disturbed.
const GLANCE: Duration = Duration::from_millis(200);
/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Steps of a bar.
const STEPS: u64 = 1000;

/// Does some work while its progress is shown.
pub fn watch<T>(what: &str, task: &Task, work: impl FnOnce() -> T) -> T {
    let (done, stop) = channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || show(what, task, &stop));
        let result = work();
        drop(done);
        result
    })
}

fn show(what: &str, task: &Task, stop: &Receiver<()>) {
    if stopped(stop, PATIENCE) {
        return;
    }
    if io::stderr().is_terminal() { show_bar(what, task, stop) } else { show_lines(what, task, stop) }
}

/// Whether the work ends within a time.
fn stopped(stop: &Receiver<()>, within: Duration) -> bool {
    stop.recv_timeout(within) != Err(RecvTimeoutError::Timeout)
}

fn show_bar(what: &str, task: &Task, stop: &Receiver<()>) {
    let bar = ProgressBar::new(STEPS);
    let known = ProgressStyle::with_template("{msg} [{bar:32}] {percent:>3} %, {elapsed}, {eta} left");
    let unknown = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
    let styles = known.and_then(|known| Ok((known.progress_chars("=> "), unknown?)));
    let (known, unknown) = styles.expect("templates that are constant");
    bar.set_message(what.to_owned());
    loop {
        match task.fraction() {
            Some(fraction) => {
                bar.set_style(known.clone());
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

fn show_lines(what: &str, task: &Task, stop: &Receiver<()>) {
    let start = Instant::now();
    loop {
        let seconds = (start.elapsed() + PATIENCE).as_secs();
        let share = task.fraction().map_or_else(String::new, |f| format!(", {:.0} %", 100.0 * f));
        let _ = writeln!(io::stderr(), "{what}{share}, {seconds} s");
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
