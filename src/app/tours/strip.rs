//! The strip above the picture that a tour speaks in.

use egui::{Align, Frame, Layout, Margin, Panel, RichText, Stroke, Ui};

use crate::app::actions::{Action, Around};
use crate::app::commands::Commands;

/// Room for the buttons at the right, in points.
const BUTTONS_WIDTH: f32 = 330.0;

/// Draws it, if a tour is taken.
pub fn ui(ui: &mut Ui, around: &Around, commands: &mut Commands) {
    let Some(touring) = around.view.touring else { return };
    let palette = around.view.palette;
    let frame = Frame::NONE
        .fill(ui.visuals().extreme_bg_color)
        .stroke(Stroke::new(1.0, palette.accent.gamma_multiply(0.5)))
        .inner_margin(Margin::symmetric(12, 8));
    Panel::top("tour").frame(frame).show(ui, |ui| {
        let (tour, step) = (touring.tour(), touring.step());
        ui.horizontal(|ui| {
            let room = (ui.available_width() - BUTTONS_WIDTH).max(120.0);
            ui.allocate_ui_with_layout(
                egui::vec2(room, ui.spacing().interact_size.y),
                Layout::left_to_right(Align::Center),
                |ui| {
                    ui.set_min_width(room);
                    ui.weak(format!("{} · {}", tour.name, touring.place()));
                    ui.label(RichText::new(step.title).strong().color(palette.accent));
                },
            );
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                for action in [Action::EndTour, Action::LeaveTour, Action::TourOn, Action::TourBack] {
                    button(ui, around, commands, action);
                }
            });
        });
        // As high for all steps of a tour: the picture keeps its size, and its pixels their places.
        let width = ui.available_width();
        let font = egui::TextStyle::Body.resolve(ui.style());
        let color = ui.visuals().text_color();
        let height = |text: &str| ui.painter().layout(text.to_owned(), font.clone(), color, width).size().y;
        let highest = tour.steps.iter().map(|step| height(step.text)).fold(0.0, f32::max);
        ui.allocate_ui(egui::vec2(width, highest), |ui| {
            ui.set_min_height(highest);
            ui.label(step.text);
        });
    });
}

fn button(ui: &mut Ui, around: &Around, commands: &mut Commands, action: Action) {
    let info = action.info(around);
    let button = ui.add_enabled(info.obstacle.is_none(), egui::Button::new(info.name.as_ref()));
    let keys = info.keys_text(ui);
    let about = if keys.is_empty() { info.about.to_string() } else { format!("{} ({keys})", info.about) };
    let button = button.on_hover_text(about);
    let button = match info.obstacle {
        Some(obstacle) => button.on_disabled_hover_text(obstacle),
        None => button,
    };
    if button.clicked() {
        commands.push(action.command(around));
    }
}
