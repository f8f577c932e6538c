//! The window. The only place that names egui. Owns its state and asks nothing of the process.
//!
//! A frame is: receive finished work, draw panels, apply commands, start work.

pub mod ab;
pub mod actions;
mod apply;
mod asked;
mod autosave;
pub mod commands;
mod dock;
pub mod inspection;
pub mod jobs;
pub mod layout;
mod menu;
pub mod messages;
pub mod panels;
pub mod player;
mod popups;
mod screenshot;
pub mod selection;
mod shell;
mod shortcuts;
pub mod splitting;
pub mod stages;
pub mod state;
mod status;
pub mod theme;
mod toolbar;
pub mod tours;
mod undo;
pub mod view;
mod viewport;

#[cfg(test)]
mod tests;

use std::time::Duration;

use anyhow::Context as _;

use crate::session::Session;

pub use screenshot::Screenshot;
pub use shell::{App, AppOptions};

/// Depths of the boxes that are shown when boxes are switched on: few enough to be read as boxes.
pub const DEFAULT_BOXES: [u32; 2] = [0, 8];

/// Size of the window at the first start, in points.
const FIRST_SIZE: [f32; 2] = [1280.0, 800.0];
const LEAST_SIZE: [f32; 2] = [720.0, 480.0];

/// How the program was started.
#[derive(Clone, Debug, Default)]
pub struct Startup {
    /// What went wrong before there was a window; shown in it until dismissed.
    pub warnings: Vec<String>,
    /// The user said nothing of boxes: show some.
    pub show_boxes: bool,
    /// Takes a picture of the window, and closes it.
    pub screenshot: Option<Screenshot>,
    /// Nothing was named to open: shows what was shown last time, with these flags over it.
    pub reopen: Option<Vec<(&'static str, String)>>,
}

/// Shows the window until it is closed.
///
/// # Errors
/// When no window can be opened.
pub fn run(session: Session, startup: Startup) -> anyhow::Result<()> {
    let screenshot = startup.screenshot.or_else(screenshot_from_environment);
    // A picture of the window is of what was asked for.
    let kept_session = if screenshot.is_none() { autosave::path() } else { None };
    let options = AppOptions {
        hold_progressive: false,
        show_boxes: startup.show_boxes,
        warnings: startup.warnings,
        screenshot,
        kept_session,
        reopen: startup.reopen,
    };
    let viewport = egui::ViewportBuilder::default()
        .with_title("bvhscope")
        .with_app_id("bvhscope")
        .with_inner_size(FIRST_SIZE)
        .with_min_inner_size(LEAST_SIZE)
        .with_icon(icon())
        .with_drag_and_drop(true);
    let native = eframe::NativeOptions {
        viewport,
        // Tests switch eframe's other renderer on, which it then prefers.
        renderer: eframe::Renderer::Glow,
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(|cc| Ok(Box::new(App::new(cc, session, options))));
    eframe::run_native("bvhscope", native, create)
        .map_err(|error| anyhow::anyhow!("{error}"))
        .context(
            "cannot open a window: it needs X11 or Wayland and OpenGL. Without one, `bvhscope render`, `stats` and \
             `table` give the same pictures and numbers",
        )
}

/// Boxes in boxes.
fn icon() -> egui::IconData {
    const SIZE: u32 = 64;
    // Left, top, right, bottom, and the colour of the frame.
    const BOXES: [([u32; 4], [u8; 3]); 4] = [
        ([3, 3, 61, 61], [94, 178, 255]),
        ([9, 9, 36, 55], [150, 220, 140]),
        ([41, 24, 55, 55], [150, 220, 140]),
        ([14, 30, 31, 50], [255, 176, 84]),
    ];
    let mut rgba = Vec::with_capacity((SIZE * SIZE * 4) as usize);
    for (y, x) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (y, x))) {
        let mut color = [29, 31, 36];
        for ([left, top, right, bottom], frame) in BOXES {
            let inside = |inset| {
                (left + inset..right - inset).contains(&x) && (top + inset..bottom - inset).contains(&y)
            };
            if inside(0) && !inside(3) {
                color = frame;
            }
        }
        rgba.extend(color);
        rgba.push(255);
    }
    egui::IconData { rgba, width: SIZE, height: SIZE }
}

/// `BVHSCOPE_SCREENSHOT=FILE` takes a picture of the window after `BVHSCOPE_SCREENSHOT_SAMPLES` samples and closes it:
/// how the window is tested from outside.
fn screenshot_from_environment() -> Option<Screenshot> {
    let path = std::env::var_os("BVHSCOPE_SCREENSHOT").filter(|path| !path.is_empty())?;
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u32>().ok());
    Some(Screenshot {
        path: path.into(),
        samples: number("BVHSCOPE_SCREENSHOT_SAMPLES").unwrap_or(4),
        patience: Duration::from_secs(number("BVHSCOPE_SCREENSHOT_SECONDS").unwrap_or(60).into()),
    })
}
