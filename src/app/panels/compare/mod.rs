//! A against B: states that were kept, two of them at once in the viewport, and every figure of both.

mod difference;
mod figures;
mod states;

use egui::{DragValue, Ui};

use crate::app::commands::{Command, Commands};
use crate::app::view::{AppView, CompareStyle, CompareViews, Side};
use crate::export::table as text;
use crate::inspect::compare::Comparison;
use crate::inspect::difference::has_difference;
use crate::render::View;

use super::glossary::Term;
use super::heatmap::view_name;
use super::widgets;

/// Of a picture that blinks, in milliseconds.
const BLINKS: std::ops::RangeInclusive<u32> = 100..=5000;

/// Views that a difference says most in.
const OFFERED: [View; 2] = [View::NodesVisited, View::RayCost];

/// View state of the Compare panel.
pub struct ComparePanel {
    /// The states that are compared next, by their index.
    sides: [usize; 2],
    states: states::States,
    others: states::Others,
    hide_equal: bool,
}

impl Default for ComparePanel {
    fn default() -> Self {
        Self {
            sides: [0, 1],
            states: states::States::default(),
            others: states::Others::default(),
            hide_equal: true,
        }
    }
}

impl ComparePanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let current = view.compare.filter(|compare| compare.is_of_states());
        self.follow(view, current);
        self.states.ui(ui, view, current, commands);
        self.pair(ui, view, current, commands);
        self.others.ui(ui, view, commands);
        let Some(compare) = current else {
            let text = if view.session.variants.len() < 2 {
                "Keep the current state, change a setting, and compare the two here."
            } else {
                "Choose above how the two share the picture: their figures appear here."
            };
            widgets::caption(ui, view.palette, text);
            return;
        };
        progress(ui, view, commands);
        // As they are called now, not when they were measured.
        let names = compare.sides().map(|side| states::named(view, state_of(view, side)));
        let names = names.each_ref().map(String::as_str);
        difference::ui(ui, view, compare, names[1]);
        figures::ray_cost(ui, view, names);
        self.hide_equal = figures::table(ui, view, names, self.hide_equal);
        actions(ui, view, commands);
    }

    /// The sides are those of the comparison; without one, they are states that there are.
    fn follow(&mut self, view: &AppView, current: Option<CompareViews>) {
        let count = view.session.variants.len();
        if let Some(compare) = current {
            self.sides = compare.sides().map(|side| state_of(view, side));
        }
        let [left, right] = &mut self.sides;
        *left = (*left).min(count - 1);
        *right = (*right).min(count - 1);
        if current.is_none() && left == right && count > 1 {
            // Something that was kept against what is worked on.
            *right = view.session.active;
            *left = (0..count).rev().find(|i| *i != *right).unwrap_or(0);
        }
    }

    /// Which two, and how.
    fn pair(&mut self, ui: &mut Ui, view: &AppView, current: Option<CompareViews>, commands: &mut Commands) {
        widgets::section(ui, "Two at once");
        let count = view.session.variants.len();
        let mut wanted = current;
        ui.add_enabled_ui(count > 1, |ui| {
            self.choose(ui, view);
            if let Some(compare) = &mut wanted {
                (compare.left.variant, compare.right.variant) = (Some(self.sides[0]), Some(self.sides[1]));
            }
            let mode = current.map(|compare| compare.style);
            let choices: Vec<_> = std::iter::once(None).chain(CompareStyle::ALL.map(Some)).collect();
            let describe = |style: Option<CompareStyle>| match style {
                None => ("off", "the one picture of the active state"),
                Some(style) => (style.name(), style.description()),
            };
            if let Some(style) = widgets::segmented(ui, Term::CompareStates, Some(mode), &choices, &describe)
            {
                let [left, right] = self.sides;
                wanted = style.map(|style| match wanted {
                    Some(compare) => CompareViews { style, ..compare },
                    None => CompareViews::of_states(left, right, style),
                });
            }
        });
        if let Some(compare) = &mut wanted {
            blink(ui, compare);
            own_cameras(ui, view, compare);
        }
        if wanted != current {
            commands.push(Command::SetCompareViews(wanted));
        }
        if wanted.is_some() {
            offer_numbers(ui, view, commands);
        }
    }

    fn choose(&mut self, ui: &mut Ui, view: &AppView) {
        let states: Vec<usize> = (0..view.session.variants.len()).collect();
        for (term, side) in [Term::CompareA, Term::CompareB].into_iter().zip(0..) {
            let shown = states::title(view, self.sides[side]);
            let chosen = widgets::row(ui, term, |ui| {
                let mut chosen = None;
                let swap_width = 24.0;
                egui::ComboBox::from_id_salt(term.label())
                    .width(ui.available_width() - swap_width - 6.0)
                    .selected_text(shown)
                    .truncate()
                    .show_ui(ui, |ui| {
                        for &state in &states {
                            let selected = self.sides[side] == state;
                            if ui.selectable_label(selected, states::title(view, state)).clicked() {
                                chosen = Some(state);
                            }
                        }
                    })
                    .response
                    .accessible_name(term.label())
                    .on_hover_text(term.text());
                if side == 0 {
                    let swap = states::icon_button(ui, "Swap left and right", states::Icon::Swap, true);
                    if swap.on_hover_text("Changes left and right over.").clicked() {
                        self.sides.swap(0, 1);
                    }
                }
                chosen
            });
            if let Some(state) = chosen {
                self.sides[side] = state;
            }
        }
    }
}

/// The state that a side shows, by its index.
fn state_of(view: &AppView, side: Side) -> usize {
    side.variant.filter(|i| *i < view.session.variants.len()).unwrap_or(view.session.active)
}

fn blink(ui: &mut Ui, compare: &mut CompareViews) {
    if compare.style != CompareStyle::Blink {
        return;
    }
    let field = DragValue::new(&mut compare.blink_ms).range(BLINKS).speed(10.0).suffix(" ms");
    widgets::number(ui, Term::BlinkInterval, field);
}

fn own_cameras(ui: &mut Ui, view: &AppView, compare: &mut CompareViews) {
    let session = view.session;
    let scenes = compare.sides().map(|side| &session.scene_of(state_of(view, side)).reference);
    if scenes[0] != scenes[1] && widgets::switch(ui, Term::OwnCameras, compare.own_cameras) {
        compare.own_cameras = !compare.own_cameras;
    }
}

/// What to look at where pictures have no numbers, or do not depend on the tree.
fn offer_numbers(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let shown = view.session.view;
    if has_difference(shown) && shown.depends_on_tree() {
        return;
    }
    let text = if has_difference(shown) {
        format!("The picture {} is the same for every tree of a scene.", view_name(shown))
    } else {
        format!("The picture {} has no numbers to subtract.", view_name(shown))
    };
    widgets::caption(ui, view.palette, text);
    ui.horizontal(|ui| {
        for offered in OFFERED {
            let button = ui.button(format!("Show {}", view_name(offered)));
            if button.on_hover_text(offered.description()).clicked() {
                commands.edit(move |s| s.view = offered);
            }
        }
    });
}

/// While a tree is built.
fn progress(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    if let Some(job) = &view.ab.building
        && widgets::progress(ui, view.palette, job, "Stop")
    {
        commands.push(Command::SetCompareViews(None));
    }
}

/// What can be done with the figures.
fn actions(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let Some(comparison) = &view.ab.figures else { return };
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        let time = ui.add_enabled(view.ab.can_time, egui::Button::new("Time frames"));
        let time = time.on_hover_text(Term::TimeBoth.text());
        if time.on_disabled_hover_text("They are timed, or something else is measured now.").clicked() {
            commands.push(Command::TimeComparison);
        }
        let mut copy = |label: &str, hover: &str, write: fn(&Comparison) -> String| {
            if ui.button(label).on_hover_text(hover).clicked() {
                commands.push(Command::CopyText { text: write(comparison), what: "comparison" });
            }
        };
        copy("Copy as CSV", "All figures with all digits, for programs.", text::compared_csv);
        copy("Copy as Markdown", "A table for people.", text::compared_markdown);
    });
}
