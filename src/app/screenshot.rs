//! A picture of the whole window on demand, for tests and for the handbook: waits for the picture, then closes.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use egui::ColorImage;

use super::state::State;
use crate::export::{atomic, png};

/// A picture of the window to take.
#[derive(Clone, Debug, PartialEq)]
pub struct Screenshot {
    pub path: PathBuf,
    /// Samples a pixel that the viewport must have.
    pub samples: u32,
    /// The window is closed after this, picture or not.
    pub patience: Duration,
}

/// Takes the picture when it is time.
pub struct ScreenshotJob {
    wanted: Screenshot,
    started: Instant,
    asked: bool,
    sender: Sender<Arc<ColorImage>>,
    receiver: Receiver<Arc<ColorImage>>,
    /// Frames since everything was there: what came last must be drawn, too.
    ready_frames: u32,
}

impl ScreenshotJob {
    pub fn new(wanted: Screenshot) -> Self {
        let (sender, receiver) = channel();
        Self { wanted, started: Instant::now(), asked: false, sender, receiver, ready_frames: 0 }
    }

    pub fn update(&mut self, ctx: &egui::Context, state: &State) {
        if let Ok(image) = self.receiver.try_recv() {
            if let Err(message) = write(&image, &self.wanted.path) {
                eprintln!("bvhscope: {message}");
            }
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        let out_of_patience = self.started.elapsed() > self.wanted.patience;
        self.ready_frames = if self.is_ready(state) { self.ready_frames + 1 } else { 0 };
        if !self.asked && (self.ready_frames > 3 || out_of_patience) {
            self.asked = true;
            let sender = self.sender.clone();
            // The receiver lives as long as the window.
            ctx.request_screenshot(move |image| drop(sender.send(image)));
        }
        ctx.request_repaint_after(Duration::from_millis(20));
    }

    fn is_ready(&self, state: &State) -> bool {
        let needed = if state.session.view.refines(state.session.count) { self.wanted.samples } else { 1 };
        let samples = state.picture(0).filter(|p| p.frame.scale == 1).map_or(0, |p| p.frame.film.samples);
        let boxes = state.session.overlay.depths.is_none() || state.boxes.is_some();
        samples >= needed && boxes
    }
}

fn write(image: &ColorImage, path: &std::path::Path) -> Result<(), String> {
    let [width, height] = image.size.map(|n| n as u32);
    let bytes = image.pixels.iter().flat_map(|p| p.to_array()).collect();
    let picture =
        image::RgbaImage::from_raw(width, height, bytes).expect("a colour image has all its pixels");
    let bytes = png::encode(&picture, None).map_err(|e| e.to_string())?;
    atomic::write_bytes(path, &bytes).map_err(|e| e.to_string())
}
