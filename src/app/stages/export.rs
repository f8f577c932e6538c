//! Files: what is asked for is put together here and written by a job.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use egui::ColorImage;

use super::Jobs;
use crate::app::commands::ExportRequest;
use crate::app::jobs::export::{ExportContent, ExportWork, sized};
use crate::app::state::State;
use crate::export::picture::Extras;
use crate::export::plot::Look;
use crate::export::report::Measured;
use crate::inspect::sweep::plot::SweepPlot;
use crate::session::Session;

/// Files that wait to be written: one after the other, and none is forgotten.
pub struct ExportMemo {
    queue: VecDeque<ExportWork>,
    /// Pictures of the whole window that were asked for.
    sender: Sender<(PathBuf, Arc<ColorImage>)>,
    receiver: Receiver<(PathBuf, Arc<ColorImage>)>,
}

impl Default for ExportMemo {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { queue: VecDeque::new(), sender, receiver }
    }
}

impl ExportMemo {
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }
}

/// Puts a file into the queue.
pub fn export(jobs: &mut Jobs, state: &mut State, ctx: &egui::Context, request: ExportRequest) {
    if let ExportRequest::Window { path } = request {
        let sender = jobs.memo.export.sender.clone();
        // The receiver lives as long as the window.
        ctx.request_screenshot(move |image| drop(sender.send((path, image))));
        ctx.request_repaint();
        return;
    }
    let (Some(document), Some(camera)) = (&state.document, state.camera()) else {
        state.messages.error("There is nothing to export yet: open a scene first.");
        return;
    };
    let session = shown_session(state);
    let world = Arc::clone(&document.world);
    let (path, session, content) = match request {
        ExportRequest::Picture { path, width, height, samples, overlay, legend } => {
            let content = ExportContent::Picture { world, camera, extras: Extras { overlay, legend } };
            (path, sized(&session, width, height, samples), content)
        }
        ExportRequest::Animation { path, size: [width, height], samples, extras, frames } => {
            let still = Arc::clone(&document.still);
            let tree = document.world.imported.as_ref().map(|imported| Arc::clone(&imported.file));
            let content = ExportContent::Animation { still, tree, camera, extras, frames };
            (path, sized(&session, width, height, samples), content)
        }
        ExportRequest::Report { path, size: [width, height], samples } => {
            let question = state.sweep.question.as_ref().filter(|_| !state.sweep.points.is_empty());
            let sweep = question.map(|_| {
                let mut plot = SweepPlot::default().plot(&state.sweep.points, Some(session.build()));
                plot.title = "Sweep".to_owned();
                plot
            });
            let table = if state.table.stale { Vec::new() } else { state.table.rows.clone() };
            let measured = Measured { table, plots: sweep.into_iter().collect() };
            let content = ExportContent::Report { world, camera, measured: Arc::new(measured) };
            (path, sized(&session, width, height, samples), content)
        }
        ExportRequest::Raw { path } => {
            let Some(slot) = state.session_slot() else {
                let message =
                    "The picture of the current settings is not shown: end the comparison, then try again.";
                state.messages.error(message);
                return;
            };
            let Some(picture) = state.picture(slot).filter(|p| p.frame.scale == 1) else {
                state
                    .messages
                    .error("The picture is not there yet: wait for its first sample, then try again.");
                return;
            };
            let film = Arc::clone(&picture.frame.film);
            let session = sized(&session, film.width, film.height, film.samples);
            (path, session, ExportContent::Raw { film })
        }
        ExportRequest::Sweep { path } => {
            let Some(question) = state.sweep.question.clone() else {
                state.messages.error("There are no points yet: start a sweep first.");
                return;
            };
            let points = Arc::new(state.sweep.points.clone());
            (path, session, ExportContent::Sweep { points, question: Box::new(question) })
        }
        ExportRequest::Plot { path } => {
            let Some(plot) = state.plot.clone() else {
                state.messages.error("No plot was chosen yet: use the button in its corner.");
                return;
            };
            (path, session, ExportContent::Plot { plot, look: Look::of(state.dark) })
        }
        ExportRequest::Figures { path } => (path, session, ExportContent::Figures { world, camera }),
        ExportRequest::Boxes { path, below } => {
            let nodes = state.selections.current().map_or_else(Vec::new, |s| s.nodes.clone());
            if nodes.is_empty() {
                state.messages.error("Nothing is selected: click in the picture or in the Tree panel first.");
                return;
            }
            (path, session, ExportContent::Boxes { world, nodes, below })
        }
        ExportRequest::Tree { path } => (path, session, ExportContent::Tree { world }),
        ExportRequest::Window { .. } => unreachable!("handled above"),
    };
    write(jobs, ExportWork { path, session, content });
}

/// Starts to write the session.
pub fn save_session(jobs: &mut Jobs, state: &State, path: PathBuf) {
    let session = shown_session(state);
    write(jobs, ExportWork { path, session, content: ExportContent::Session });
}

pub fn receive(jobs: &mut Jobs, state: &mut State) {
    let context = jobs.context.clone();
    while let Ok((path, image)) = jobs.memo.export.receiver.try_recv() {
        let session = shown_session(state);
        write(jobs, ExportWork { path, session, content: ExportContent::Window { image } });
    }
    for done in jobs.export.poll(&context) {
        match done {
            Ok(path) => state.messages.say(format!("Written: {}", path.display())),
            Err(message) => state.messages.error(message),
        }
    }
    if jobs.export.is_idle()
        && let Some(work) = jobs.memo.export.queue.pop_front()
    {
        jobs.export.request(&context, work);
    }
}

/// Gives up the file that is being written. What lay at its path before stays.
pub fn cancel(jobs: &mut Jobs, state: &mut State) {
    let Some(running) = jobs.export.running() else { return };
    let what = if running.request.comes_in_parts() {
        "The export was cancelled; the frames that were finished stay."
    } else {
        "The export was cancelled; nothing was written."
    };
    jobs.export.cancel();
    state.messages.say(what);
}

/// The session with what is on the screen: the camera, and the tree that is finished.
fn shown_session(state: &State) -> Session {
    let mut session = state.session.clone();
    session.camera = state.camera().or(session.camera);
    if let Some(document) = &state.document {
        *session.build_mut() = document.tree.config;
    }
    session
}

fn write(jobs: &mut Jobs, work: ExportWork) {
    jobs.memo.export.queue.push_back(work);
    jobs.context.wake();
}
