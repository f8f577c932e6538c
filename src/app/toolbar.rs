//! The bar below the menus: what is shown, and how the picture is coming on.

use egui::{Align, Button, ComboBox, Layout, RichText, TextWrapMode, Ui, vec2};

use super::actions::{show_view, title, toggle_boxes};
use super::commands::{Command, Commands};
use super::view::AppView;
use crate::render::{CountKind, View};

/// Points for the figures and a word beside them.
const FIGURES_WIDTH: f32 = 400.0;

/// As high whatever its figures say, for the reason that the line at the bottom is: only a change of the window's width
/// or of what can be set begins another row.
pub fn ui(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        view_combo(ui, view, commands);
        let counts = view.session.view.counts_rays();
        if counts {
            count_combo(ui, view, commands);
        }
        ui.separator();
        toggles(ui, view, commands);
        ui.separator();
        let size = vec2(FIGURES_WIDTH.min(ui.max_rect().width()), ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_size(size);
            ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
            figures(ui, view);
        });
    });
}

fn view_combo(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let label = ui.label("View");
    let selected = view.session.view;
    ComboBox::from_id_salt("view")
        .width(178.0)
        .height(480.0)
        .selected_text(title(selected))
        .show_ui(ui, |ui| {
            for choice in View::ALL {
                let response = ui.selectable_label(choice == selected, title(choice));
                if response.on_hover_text(choice.description()).clicked() {
                    commands.push(show_view(choice));
                }
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text(selected.description());
}

fn count_combo(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let label = ui.label("Rays");
    let selected = view.session.count;
    ComboBox::from_id_salt("count")
        .width(76.0)
        .selected_text(selected.name())
        .show_ui(ui, |ui| {
            for choice in CountKind::ALL {
                let response = ui.selectable_label(choice == selected, choice.name());
                if response.on_hover_text(choice.description()).clicked() {
                    commands.edit(move |session| session.count = choice);
                }
            }
        })
        .response
        .labelled_by(label.id)
        .on_hover_text(format!("Which rays are counted: {}", selected.description()));
}

fn toggles(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let paused = view.render.paused;
    let (text, about) =
        if paused { ("Resume", "Go on rendering (Space)") } else { ("Pause", "Stop rendering (Space)") };
    if ui.add(Button::new(text).min_size(vec2(64.0, 0.0))).on_hover_text(about).clicked() {
        commands.push(Command::SetPaused(!paused));
    }
    let boxes = view.session.overlay.depths.is_some();
    if ui
        .add(Button::selectable(boxes, "Boxes"))
        .on_hover_text("The boxes of the tree over the picture (B)")
        .clicked()
    {
        commands.push(toggle_boxes());
    }
    let moves = view.scene.is_some_and(|scene| scene.is_animated());
    let animate = ui.add_enabled(moves, Button::selectable(view.animating, "Animate"));
    if animate
        .on_hover_text("Lets the scene move; the tree follows, built anew or refitted (T)")
        .on_disabled_hover_text("Nothing moves in this scene")
        .clicked()
    {
        commands.push(Command::SetAnimating(!view.animating));
    }
}

fn figures(ui: &mut Ui, view: &AppView) {
    let render = &view.render;
    let goal = render.goal.filter(|goal| *goal > 1).map_or_else(String::new, |goal| format!(" of {goal}"));
    let unit = if render.samples == 1 && goal.is_empty() { "sample " } else { "samples" };
    figure(ui, format!("{:>5}{goal} {unit}", render.samples), "Samples a pixel so far.");
    let speed = render.msamples_per_s.map_or_else(|| "   –".to_owned(), |m| format!("{m:>5.2}"));
    figure(ui, format!("{speed} M/s"), "Million samples of single pixels a second.");
    let time = match render.sample_ms {
        None => "    – ms".to_owned(),
        Some(ms) if ms < 1000.0 => format!("{ms:>5.1} ms"),
        Some(ms) => format!("{:>6.2} s", ms * 1e-3),
    };
    figure(ui, format!("{time}/frame"), "Wall time of the last sample over the whole picture.");
    if render.measuring {
        ui.label(RichText::new("measuring").color(view.palette.warning)).on_hover_text(
            "A timed measurement runs with nothing beside it: the picture waits, and goes on when you change anything.",
        );
    } else if render.paused {
        ui.label(RichText::new("paused").color(view.palette.warning));
    }
}

fn figure(ui: &mut Ui, text: String, about: &str) {
    ui.label(RichText::new(text).monospace().color(ui.visuals().text_color())).on_hover_text(about);
    ui.add_space(8.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::state::State;
    use crate::session::Session;
    use egui_kittest::Harness;

    #[test]
    fn the_bar_is_as_high_whatever_its_figures_say() {
        let height = |width: f32, change: &dyn Fn(&mut AppView)| {
            let state = State::new(Session::default(), true);
            let mut view = state.view();
            change(&mut view);
            let mut height = 0.0;
            let mut harness = Harness::builder().with_size([width, 400.0]).build_ui(|ui| {
                let bar =
                    egui::Panel::top("toolbar").show(ui, |ui| super::ui(ui, &view, &mut Commands::default()));
                height = bar.response.rect.height();
            });
            harness.step();
            drop(harness);
            height
        };
        for width in [1280.0, 1000.0, 900.0, 760.0, 500.0, 300.0] {
            let idle = height(width, &|_| ());
            assert_eq!(height(width, &|view| view.render.measuring = true), idle, "measuring at {width}");
            assert_eq!(height(width, &|view| view.render.paused = true), idle, "paused at {width}");
            let long = |view: &mut AppView| {
                view.render.samples = 12_345_678;
                view.render.goal = Some(100_000_000);
                view.render.msamples_per_s = Some(1234.5);
                view.render.sample_ms = Some(1.0e8);
                view.render.measuring = true;
            };
            assert_eq!(height(width, &long), idle, "long figures at {width}");
        }
    }
}
