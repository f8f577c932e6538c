//! The pieces that every panel is made of: labelled rows, aligned figures, choices, sections, progress.

use std::ops::RangeInclusive;
use std::sync::Arc;

use egui::accesskit::Role;
use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Button, Color32, ComboBox, DragValue, FontId, Galley, Layout, ProgressBar, Rect, Response,
    RichText, Sense, Slider, TextStyle, Ui, WidgetInfo, pos2, vec2,
};

use crate::app::theme::Palette;
use crate::app::view::JobStatus;
use crate::inspect::columns::Better;

use super::glossary::Term;
use super::numbers;

/// Width of the labels' column.
pub const LABEL_WIDTH: f32 = 104.0;
/// Height of a row with an input.
pub const ROW_HEIGHT: f32 = 22.0;
/// Height of a row with a figure.
pub const FIGURE_HEIGHT: f32 = 16.0;
/// Width of a number field.
pub const NUMBER_WIDTH: f32 = 58.0;
/// Inputs grow no wider than this.
const MOST_INPUT_WIDTH: f32 = 360.0;
const UNIT_WIDTH: f32 = 30.0;
const CHANGE_WIDTH: f32 = 66.0;
const GAP: f32 = 6.0;

/// How wide a list of figures is: as wide as a row with an input, so that numbers stay near their labels.
pub fn form_width(ui: &Ui) -> f32 {
    ui.available_width().min(LABEL_WIDTH + GAP + MOST_INPUT_WIDTH)
}

/// Spacing that all panels share.
pub fn set_spacing(ui: &mut Ui) {
    let spacing = ui.spacing_mut();
    spacing.item_spacing = vec2(GAP, 5.0);
    spacing.interact_size.y = ROW_HEIGHT;
    ui.style_mut().drag_value_text_style = TextStyle::Monospace;
}

pub fn small_font(ui: &Ui) -> FontId {
    TextStyle::Small.resolve(ui.style())
}

pub fn body_font(ui: &Ui) -> FontId {
    TextStyle::Body.resolve(ui.style())
}

/// The font of all numbers: every digit is as wide as the other.
pub fn number_font(ui: &Ui) -> FontId {
    TextStyle::Monospace.resolve(ui.style())
}

/// One line of text that ends in an ellipsis if it is wider than `width`.
pub fn elided(ui: &Ui, text: impl Into<String>, font: FontId, color: Color32, width: f32) -> Arc<Galley> {
    let mut job = LayoutJob::simple_singleline(text.into(), font, color);
    job.wrap = TextWrapping::truncate_at_width(width.max(0.0));
    ui.painter().layout_job(job)
}

/// Where a line of text stands in its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

/// Paints one line into a cell, vertically centred, elided to the cell's width. Says whether it was elided.
pub fn paint_text(ui: &Ui, cell: Rect, side: Side, text: &str, font: FontId, color: Color32) -> bool {
    let galley = elided(ui, text, font, color, cell.width());
    let x = match side {
        Side::Left => cell.left(),
        Side::Right => cell.right() - galley.size().x,
    };
    let elided = galley.elided;
    ui.painter().galley(pos2(x, cell.center().y - galley.size().y / 2.0), galley, color);
    elided
}

/// The ground of a line of a list that can be clicked.
pub fn paint_line(ui: &Ui, rect: Rect, response: &Response, selected: bool) {
    let fill = if selected {
        ui.visuals().selection.bg_fill.gamma_multiply(0.35)
    } else if response.hovered() || response.has_focus() {
        ui.visuals().widgets.hovered.weak_bg_fill
    } else {
        Color32::TRANSPARENT
    };
    ui.painter().rect_filled(rect, 2.0, fill);
}

/// A heading inside a panel, with a hairline to its right.
pub fn section(ui: &mut Ui, title: &str) -> Response {
    if ui.cursor().top() > ui.min_rect().top() + 1.0 {
        ui.add_space(9.0);
    }
    let response = ui
        .horizontal(|ui| {
            let response = ui.add(egui::Label::new(RichText::new(title).strong()).selectable(false).extend());
            let (_, line) = ui.allocate_space(vec2(ui.available_width(), 1.0));
            let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
            ui.painter().hline(line.x_range(), line.center().y, stroke);
            response
        })
        .inner;
    ui.add_space(1.0);
    response
}

/// A heading that is a term of the glossary.
pub fn term_section(ui: &mut Ui, term: Term) -> Response {
    section(ui, term.label()).on_hover_text(term.text())
}

/// Quiet, wrapped text.
pub fn caption(ui: &mut Ui, palette: &Palette, text: impl Into<String>) -> Response {
    ui.add(egui::Label::new(RichText::new(text).color(palette.muted)).wrap())
}

/// Wrapped text in a colour of the palette.
pub fn notice(ui: &mut Ui, color: Color32, text: impl Into<String>) -> Response {
    ui.add(egui::Label::new(RichText::new(text).color(color)).wrap())
}

/// A row of an input: the term on the left, the contents on the right. Every input in it is named by the term.
pub fn row<R>(ui: &mut Ui, term: Term, contents: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let label = ui
            .allocate_ui_with_layout(
                vec2(LABEL_WIDTH, ROW_HEIGHT),
                Layout::left_to_right(Align::Center),
                |ui| {
                    ui.set_min_size(vec2(LABEL_WIDTH, ROW_HEIGHT));
                    ui.add(egui::Label::new(term.label()).selectable(false).truncate())
                },
            )
            .inner
            .on_hover_text(term.text());
        let size = vec2(ui.available_width().min(MOST_INPUT_WIDTH), ROW_HEIGHT);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.label_inputs_by(label.id, contents)
        })
        .inner
    })
    .inner
}

/// A slider over whole numbers.
pub fn integer_slider(
    ui: &mut Ui,
    term: Term,
    value: &mut usize,
    range: RangeInclusive<usize>,
    logarithmic: bool,
) -> Response {
    slider(ui, term, Slider::new(value, range).logarithmic(logarithmic).trailing_fill(true))
}

/// A number field in a row of its own.
pub fn number(ui: &mut Ui, term: Term, field: DragValue<'_>) -> Response {
    row(ui, term, |ui| {
        ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
        ui.add(field).accessible_name(term.label()).on_hover_text(term.text())
    })
}

/// Another number field in the same row, named by its own term.
pub fn named_number(ui: &mut Ui, term: Term, field: DragValue<'_>) -> Response {
    ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
    ui.add(field).accessible_name(term.label()).on_hover_text(term.text())
}

/// A slider with its number on the right.
pub fn slider(ui: &mut Ui, term: Term, slider: Slider<'_>) -> Response {
    row(ui, term, |ui| {
        ui.spacing_mut().interact_size.x = NUMBER_WIDTH;
        ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDTH - GAP).max(40.0);
        ui.add(slider).accessible_name(term.label()).on_hover_text(term.text())
    })
}

/// A switch. True if it was flipped.
pub fn switch(ui: &mut Ui, term: Term, on: bool) -> bool {
    let mut on = on;
    ui.checkbox(&mut on, term.label()).on_hover_text(term.text()).changed()
}

/// One of a closed set: its name and a line on it.
pub type Described<'a, T> = &'a dyn Fn(T) -> (&'static str, &'static str);

/// A few choices side by side. The choice that was clicked, if it is another one.
pub fn segmented<T: Copy + PartialEq>(
    ui: &mut Ui,
    term: Term,
    current: Option<T>,
    choices: &[T],
    describe: Described<'_, T>,
) -> Option<T> {
    row(ui, term, |ui| segments(ui, term, current, choices, describe))
}

/// The choices of [`segmented`] without a label in front, as wide as there is room, in as many lines as they need.
pub fn segments<T: Copy + PartialEq>(
    ui: &mut Ui,
    term: Term,
    current: Option<T>,
    choices: &[T],
    describe: Described<'_, T>,
) -> Option<T> {
    const BETWEEN: f32 = 2.0;
    let font = TextStyle::Button.resolve(ui.style());
    let widths: Vec<f32> = choices
        .iter()
        .map(|&c| {
            ui.painter().layout_no_wrap(describe(c).0.to_owned(), font.clone(), Color32::WHITE).size().x
        })
        .collect();
    const LEAST_PAD: f32 = 2.0;
    let room = ui.available_width().min(MOST_INPUT_WIDTH);
    // What is left for each choice of a line, beside its text.
    let pad = |widths: &[f32]| {
        let between = BETWEEN * (widths.len() - 1) as f32;
        (room - between - widths.iter().sum::<f32>()) / widths.len() as f32
    };
    let fits = |&a_line: &usize| widths.chunks(a_line).all(|line| pad(line) >= LEAST_PAD);
    let lines = (1..=choices.len()).map(|lines| choices.len().div_ceil(lines));
    let a_line = lines.into_iter().find(fits).unwrap_or(1).max(1);
    let mut clicked = None;
    let mut line = |ui: &mut Ui, choices: &[T], widths: &[f32]| {
        let pad = pad(widths).max(LEAST_PAD);
        ui.spacing_mut().item_spacing.x = BETWEEN;
        ui.spacing_mut().button_padding.x = 0.0;
        for (&choice, width) in choices.iter().zip(widths) {
            let (name, description) = describe(choice);
            let selected = current == Some(choice);
            let button = Button::selectable(selected, name).frame_when_inactive(true);
            let response = ui
                .add_sized(vec2(width + pad, ROW_HEIGHT), button)
                .on_hover_text(format!("{name}: {description}"))
                .accessible_name(format!("{} {name}", term.label()));
            if response.clicked() && !selected {
                clicked = Some(choice);
            }
        }
    };
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = BETWEEN;
        for (choices, widths) in choices.chunks(a_line).zip(widths.chunks(a_line)) {
            ui.horizontal(|ui| line(ui, choices, widths));
        }
    });
    clicked
}

/// One of many choices. The choice that was clicked, if it is another one; `none` is shown where there is no current one.
pub fn combo<T: Copy + PartialEq>(
    ui: &mut Ui,
    term: Term,
    current: Option<T>,
    choices: &[T],
    describe: Described<'_, T>,
    none: &str,
) -> Option<T> {
    row(ui, term, |ui| {
        let shown = current.map_or(none, |c| describe(c).0);
        let mut clicked = None;
        ComboBox::from_id_salt(term.label())
            .width(ui.available_width())
            .selected_text(shown)
            .truncate()
            .show_ui(ui, |ui| {
                for &choice in choices {
                    let (name, description) = describe(choice);
                    let selected = current == Some(choice);
                    if ui.selectable_label(selected, name).on_hover_text(description).clicked() && !selected {
                        clicked = Some(choice);
                    }
                }
            })
            .response
            .accessible_name(term.label())
            .on_hover_text(current.map_or(term.text(), |c| describe(c).1));
        clicked
    })
}

/// One figure: its term on the left, its number right-aligned, its unit muted beside it.
pub struct Figure<'a> {
    term: Term,
    label: &'a str,
    value: String,
    /// `None`: no column for units is kept free.
    unit: Option<&'a str>,
    /// `None`: no column for changes is kept free.
    change: Option<(Option<String>, Better)>,
    color: Option<Color32>,
    indent: f32,
    note: Option<String>,
}

impl<'a> Figure<'a> {
    pub fn new(term: Term, value: String) -> Self {
        Self {
            term,
            label: term.label(),
            value,
            unit: None,
            change: None,
            color: None,
            indent: 0.0,
            note: None,
        }
    }

    /// Empty for a figure without a unit in a list of figures with units.
    pub fn unit(self, unit: &'a str) -> Self {
        Self { unit: Some(unit), ..self }
    }

    /// Another label than the term's own.
    pub fn label(self, label: &'a str) -> Self {
        Self { label, ..self }
    }

    /// Keeps a column for the change against `before` and shows it there, coloured by whether it is for the better.
    pub fn change(self, now: Option<f64>, before: Option<f64>, better: Better) -> Self {
        let change = now.zip(before).and_then(|(now, before)| numbers::change(now, before));
        Self { change: Some((change, better)), ..self }
    }

    /// The value's colour.
    pub fn color(self, color: Color32) -> Self {
        Self { color: Some(color), ..self }
    }

    /// Belongs to the figure above.
    pub fn part(self) -> Self {
        Self { indent: 12.0, ..self }
    }

    /// A line below the term's sentence in the tooltip.
    pub fn note(self, note: String) -> Self {
        Self { note: Some(note), ..self }
    }

    pub fn show(self, ui: &mut Ui, palette: &Palette) -> Response {
        let (rect, response) = ui.allocate_exact_size(vec2(form_width(ui), FIGURE_HEIGHT), Sense::hover());
        let (small, body, mono) = (small_font(ui), body_font(ui), number_font(ui));
        let mut right = rect.right();
        if let Some((change, better)) = &self.change {
            let cell = Rect::from_x_y_ranges(right - CHANGE_WIDTH..=right, rect.y_range());
            let color = change.as_deref().map_or(palette.muted, |c| change_color(c, *better, palette));
            paint_text(ui, cell, Side::Right, change.as_deref().unwrap_or(""), small.clone(), color);
            right -= CHANGE_WIDTH;
        }
        if let Some(unit) = self.unit {
            let cell = Rect::from_x_y_ranges(right - UNIT_WIDTH + 4.0..=right, rect.y_range());
            paint_text(ui, cell, Side::Left, unit, small, palette.muted);
            right -= UNIT_WIDTH;
        }
        let color = self.color.unwrap_or_else(|| ui.visuals().strong_text_color());
        let width = elided(ui, self.value.clone(), mono.clone(), color, rect.width()).size().x;
        let value = Rect::from_x_y_ranges(right - width - 1.0..=right, rect.y_range());
        paint_text(ui, value, Side::Right, &self.value, mono, color);
        let label = Rect::from_x_y_ranges(rect.left() + self.indent..=value.left() - GAP, rect.y_range());
        let shortened = paint_text(ui, label, Side::Left, self.label, body, ui.visuals().text_color());

        let change = self.change.as_ref().and_then(|(c, _)| c.as_deref()).unwrap_or("");
        let text = format!("{}: {} {} {change}", self.label, self.value, self.unit.unwrap_or(""));
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text.trim_end()));
        response.on_hover_ui(|ui| {
            ui.set_max_width(280.0);
            if shortened || self.label != self.term.label() {
                ui.strong(self.label);
            }
            ui.label(self.term.text());
            if let Some(note) = &self.note {
                ui.label(note);
            }
        })
    }
}

fn change_color(change: &str, better: Better, palette: &Palette) -> Color32 {
    let less = change.starts_with('−');
    match better {
        Better::Neither => palette.muted,
        Better::Lower if less => palette.good,
        Better::Higher if !less => palette.good,
        Better::Lower | Better::Higher => palette.error,
    }
}

/// A running job with its progress. True if it was asked to stop by the button of that name.
pub fn progress(ui: &mut Ui, palette: &Palette, job: &JobStatus, stop: &str) -> bool {
    let mut stopped = false;
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            stopped = ui.button(stop).clicked();
            let bar = ProgressBar::new(job.fraction.unwrap_or(0.0))
                .desired_width(ui.available_width())
                .desired_height(8.0)
                .fill(palette.accent)
                .animate(job.fraction.is_none());
            ui.add(bar);
        });
    });
    let share = job.fraction.map_or(String::new(), |f| format!("{:.0} %, ", 100.0 * f));
    caption(ui, palette, format!("{} · {share}{}", job.what, numbers::elapsed(job.elapsed)));
    stopped
}

/// The same text with a capital first letter.
pub fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |c| c.to_uppercase().chain(chars).collect())
}

/// A small filled square that stands for a series or a class.
pub fn swatch(ui: &mut Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, color);
}

/// Series of a chart with their colours, in one wrapped line.
/// A bar of colours from 0 on the left to 1 on the right.
pub fn color_bar(ui: &mut Ui, color: &dyn Fn(f32) -> Color32) -> Response {
    const STEPS: usize = 64;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 10.0), Sense::hover());
    let mut mesh = egui::Mesh::default();
    for i in 0..=STEPS {
        let t = i as f32 / STEPS as f32;
        let x = rect.left() + t * rect.width();
        let color = color(t);
        mesh.colored_vertex(egui::pos2(x, rect.top()), color);
        mesh.colored_vertex(egui::pos2(x, rect.bottom()), color);
        if i > 0 {
            let last = 2 * i as u32;
            mesh.add_triangle(last - 2, last - 1, last);
            mesh.add_triangle(last - 1, last, last + 1);
        }
    }
    ui.painter().add(mesh);
    response
}

pub fn legend(ui: &mut Ui, palette: &Palette, series: &[(&str, Color32)]) {
    ui.horizontal_wrapped(|ui| {
        for (name, color) in series {
            swatch(ui, *color);
            ui.label(RichText::new(*name).small().color(palette.muted));
            ui.add_space(4.0);
        }
    });
}
