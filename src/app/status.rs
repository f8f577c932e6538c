//! The line at the bottom, and the messages above it.

use egui::{Button, Frame, Label, Layout, Margin, ProgressBar, RichText, Stroke, Ui};

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

/// What is open, and what is being done.
pub fn line(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    ui.horizontal(|ui| {
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
        ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
            let [width, height] = view.render.size;
            if width > 0 {
                ui.weak(format!("{width} x {height}"))
                    .on_hover_text("Pixels of the picture, which is coarser while the camera moves.");
            }
            job(ui, view.loading.as_ref(), "Cancel loading", commands, || Command::CancelLoad);
            job(ui, view.building.as_ref(), "Cancel building", commands, || Command::CancelBuild);
            job(ui, view.exporting.as_ref(), "Cancel exporting", commands, || Command::CancelExport);
            job(ui, view.table.running.as_ref(), "Cancel measuring", commands, || Command::CancelTable);
        });
    });
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
                ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
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

    #[test]
    fn times_have_three_digits() {
        assert_eq!(
            [3.456, 45.6, 456.0, 4567.0].map(milliseconds).join(", "),
            "3.46 ms, 46 ms, 456 ms, 4.57 s"
        );
    }
}
