//! The line at the bottom, and the messages above it.

use egui::{
    Align, Button, Frame, Label, Layout, Margin, ProgressBar, RichText, Stroke, TextWrapMode, Ui, vec2,
};

use super::commands::{Command, Commands};
use super::jobs::overlay::grouped;
use super::messages::{Message, Messages};
use super::view::{AppView, JobStatus};

/// Work that is done sooner than this is not spoken of, in seconds.
const WORTH_SAYING: f32 = 0.2;

/// Sizes of a message, in points.
const MESSAGE_WIDTH: f32 = 720.0;
const DISMISS_WIDTH: f32 = 76.0;
const ABOVE_STATUS: f32 = 38.0;

/// What is open, and what is being done: one row, whatever it says. Were it to grow, the picture above would change its
/// size, and with it all that is measured at that size.
pub fn line(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
    let row = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(row, Layout::right_to_left(Align::Center), |ui| {
        ui.set_min_size(row);
        let [width, height] = view.render.size;
        if width > 0 {
            ui.weak(format!("{width} x {height}"))
                .on_hover_text("Pixels of the picture, which is coarser while the camera moves.");
        }
        job(ui, view.loading.as_ref(), "Cancel loading", commands, || Command::CancelLoad);
        job(ui, view.building.as_ref(), "Cancel building", commands, || Command::CancelBuild);
        job(ui, view.exporting.as_ref(), "Cancel exporting", commands, || Command::CancelExport);
        job(ui, view.table.running.as_ref(), "Cancel measuring", commands, || Command::CancelTable);
        let pause = || Command::SetSweepPaused(true);
        job(ui, view.sweep.running.as_ref(), "Pause the sweep", commands, pause);
        // Last, as what it says can do without its end.
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| open(ui, view));
    });
}

/// The scene, and its tree.
fn open(ui: &mut Ui, view: &AppView) {
    if let Some(scene) = view.scene {
        let shapes = if scene.shape_count() == 1 { "shape" } else { "shapes" };
        ui.label(format!("{}  ·  {} {shapes}", scene.name, grouped(scene.shape_count())));
    }
    if let Some(world) = view.world {
        let figures = &world.figures;
        let depth = figures.depth_max.map_or_else(String::new, |d| format!(", depth {d}"));
        let tree = format!("{} nodes{depth}", grouped(figures.node_count));
        ui.weak(format!("·  {tree}  ·  built in {}", milliseconds(world.report.build_ms)));
    }
}

/// The messages, newest last, over the lower edge of the window: they must not move what is looked at. An error stays
/// until it is dismissed.
pub fn messages(ui: &Ui, view: &AppView, messages: &mut Messages) {
    if messages.iter().next().is_none() {
        return;
    }
    let mut dismissed = None;
    let width = (ui.ctx().content_rect().width() - 80.0).min(MESSAGE_WIDTH);
    egui::Area::new(egui::Id::unique("bvhscope messages"))
        .order(egui::Order::Foreground)
        .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -ABOVE_STATUS])
        .show(ui.ctx(), |ui| {
            ui.set_width(width);
            for (i, message) in messages.iter().enumerate() {
                if message_ui(ui, view, message) {
                    dismissed = Some(i);
                }
            }
        });
    if let Some(i) = dismissed {
        messages.dismiss(i);
    }
}

/// One message; whether it was dismissed.
fn message_ui(ui: &mut Ui, view: &AppView, message: &Message) -> bool {
    let color = if message.error { view.palette.error } else { view.palette.good };
    let mut dismissed = false;
    Frame::popup(ui.style()).stroke(Stroke::new(1.0, color)).inner_margin(Margin::symmetric(12, 7)).show(
        ui,
        |ui| {
            ui.horizontal(|ui| {
                let count =
                    if message.count > 1 { format!(" ({} times)", message.count) } else { String::new() };
                let text =
                    RichText::new(format!("{}{count}", message.text)).color(ui.visuals().strong_text_color());
                let room = ui.available_width() - DISMISS_WIDTH;
                ui.scope(|ui| {
                    ui.set_width(room);
                    ui.add(Label::new(text).wrap());
                });
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    dismissed = ui.button("Dismiss").clicked();
                });
            });
        },
    );
    dismissed
}

fn job(
    ui: &mut Ui,
    status: Option<&JobStatus>,
    cancel: &str,
    commands: &mut Commands,
    command: impl FnOnce() -> Command,
) {
    let Some(status) = status.filter(|s| s.elapsed.as_secs_f32() >= WORTH_SAYING) else { return };
    if ui.add(Button::new("Cancel").small()).on_hover_text(cancel).clicked() {
        commands.push(command());
    }
    match status.fraction {
        Some(fraction) => {
            ui.add(ProgressBar::new(fraction).desired_width(110.0).desired_height(10.0));
        }
        None => {
            ui.spinner();
        }
    }
    ui.label(format!("{}, {:.1} s", status.what, status.elapsed.as_secs_f32()));
}

/// A time with three digits and its unit.
fn milliseconds(ms: f64) -> String {
    if ms < 10.0 {
        format!("{ms:.2} ms")
    } else if ms < 1000.0 {
        format!("{ms:.0} ms")
    } else {
        format!("{:.2} s", ms * 1e-3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::state::State;
    use crate::session::Session;
    use egui_kittest::Harness;
    use std::time::Duration;

    #[test]
    fn the_row_is_as_high_when_something_is_being_done() {
        let mut state = State::new(Session::default(), true);
        state.viewport = [1280, 720];
        let height = |state: &State, width: f32| {
            let mut height = 0.0;
            let mut harness = Harness::builder().with_size([width, 400.0]).build_ui(|ui| {
                let row = egui::Panel::bottom("status")
                    .show(ui, |ui| line(ui, &state.view(), &mut Commands::default()));
                height = row.response.rect.height();
            });
            harness.step();
            drop(harness);
            height
        };
        let idle = height(&state, 1000.0);
        for width in [1000.0, 500.0, 240.0, 90.0] {
            let job = |what: &str, fraction| {
                Some(JobStatus { what: what.to_owned(), elapsed: Duration::from_secs(12), fraction })
            };
            assert_eq!(height(&state, width), idle, "at {width}");
            state.building = job("building binned, 32 bins", None);
            assert_eq!(height(&state, width), idle, "building at {width}");
            state.table.running = job("measuring the five trees", Some(0.3));
            assert_eq!(height(&state, width), idle, "both at {width}");
            (state.building, state.table.running) = (None, None);
        }
    }

    #[test]
    fn times_have_three_digits() {
        assert_eq!(
            [3.456, 45.6, 456.0, 4567.0].map(milliseconds).join(", "),
            "3.46 ms, 46 ms, 456 ms, 4.57 s"
        );
    }
}
