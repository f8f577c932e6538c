//! Small, calm charts in one look: fixed bounds, few ticks, a tooltip of our own, no zoom and no drag.

use egui::accesskit::Role;
use egui::{Color32, Rangef, Response, RichText, Sense, Ui, WidgetInfo};
use egui_plot::{Bar, BarChart, GridMark, Plot, PlotPoint, PlotUi};

use crate::app::theme::Palette;

use super::numbers;
use super::widgets::small_font;

/// An axis: what it covers, where its ticks are, and how they are written.
pub struct Axis {
    pub range: [f64; 2],
    pub ticks: Vec<f64>,
    /// What it counts; may be empty.
    pub label: &'static str,
    pub text: Box<dyn Fn(f64) -> String>,
}

impl Axis {
    /// From zero to a little above `max`.
    pub fn from_zero(max: f64) -> Self {
        let max = if max.is_finite() && max > 0.0 { max } else { 1.0 };
        Self::linear([0.0, 1.06 * max], 4)
    }

    /// Around some values with a margin; not from zero, so that small changes are seen.
    pub fn around(values: impl IntoIterator<Item = f64>) -> Self {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite()) {
            (lo, hi) = (lo.min(value), hi.max(value));
        }
        if lo > hi {
            (lo, hi) = (0.0, 1.0);
        }
        let margin = (0.1 * (hi - lo)).max(0.01 * hi.abs()).max(1e-9);
        let low = if lo >= 0.0 { (lo - margin).max(0.0) } else { lo - margin };
        Self::linear([low, hi + margin], 4)
    }

    /// With at most about `most` ticks at round numbers.
    pub fn linear(range: [f64; 2], most: usize) -> Self {
        let step = nice_step(range[1] - range[0], most);
        Self::with_step(range, step)
    }

    /// Whole numbers, each in the middle of its unit.
    pub fn integers(first: f64, last: f64, most: usize) -> Self {
        let step = nice_step(last - first + 1.0, most).max(1.0).round();
        let mut axis = Self::with_step([first, last], step);
        axis.range = [first - 0.6, last + 0.6];
        axis
    }

    fn with_step(range: [f64; 2], step: f64) -> Self {
        let first = (range[0] / step).ceil() as i64;
        let last = (range[1] / step).floor() as i64;
        let ticks = (first..=last).map(|i| i as f64 * step).collect();
        Self { range, ticks, label: "", text: Box::new(move |x| numbers::tick(x, step)) }
    }

    /// Powers of two, over the logarithm to base 2.
    pub fn powers_of_two(first: u32, last: u32) -> Self {
        Self {
            range: [f64::from(first) - 0.2, f64::from(last) + 0.2],
            ticks: (first..=last).map(f64::from).collect(),
            label: "",
            text: Box::new(|x| numbers::count(1u64 << (x.round().clamp(0.0, 62.0) as u32))),
        }
    }

    pub fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    fn marks(&self) -> Vec<GridMark> {
        let step_size = self.ticks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
        let step_size = if step_size.is_finite() { step_size } else { self.range[1] - self.range[0] };
        self.ticks.iter().map(|&value| GridMark { value, step_size }).collect()
    }
}

/// The smallest of 1, 2 or 5 times a power of ten that cuts `span` into at most `most` pieces.
fn nice_step(span: f64, most: usize) -> f64 {
    let raw = (span / most.max(1) as f64).max(1e-12);
    let power = 10f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= raw * 0.999).unwrap_or(10.0 * power)
}

/// A chart of a fixed look.
pub struct Chart<'a> {
    /// What it shows, for whoever cannot see it; unique within the panel.
    pub label: &'a str,
    pub height: f32,
    pub x: Axis,
    pub y: Axis,
    pub clickable: bool,
}

/// Where the mouse is over a drawn chart.
pub struct ChartResponse {
    pub response: Response,
    /// In the chart's coordinates.
    pub hover: Option<PlotPoint>,
}

impl Chart<'_> {
    pub fn show<'b>(
        self,
        ui: &mut Ui,
        palette: &Palette,
        draw: impl FnOnce(&mut PlotUi<'b>) + 'b,
    ) -> ChartResponse {
        let (x_marks, y_marks) = (self.x.marks(), self.y.marks());
        let (x_range, y_range) = (self.x.range, self.y.range);
        let (x_text, y_text) = (self.x.text, self.y.text);
        let font = small_font(ui);
        let x_label = RichText::new(self.x.label).font(font.clone()).color(palette.muted);
        let mut plot = Plot::new(self.label)
            .height(self.height)
            .allow_zoom(false)
            .allow_drag(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_axis_zoom_drag(false)
            .allow_double_click_reset(false)
            .show_crosshair(false)
            .label_formatter(|_| None)
            .sense(if self.clickable { Sense::click() } else { Sense::hover() })
            .grid_spacing(Rangef::new(1.0, 2.0))
            .grid_color(palette.muted.gamma_multiply(0.22))
            .x_grid_spacer(move |_| x_marks.clone())
            .y_grid_spacer(move |_| y_marks.clone());
        let style = |axis: egui_plot::AxisHints<'static>| {
            axis.label_spacing(Rangef::new(1.0, 2.0))
                .tick_label_color(palette.muted)
                .tick_label_font(font.clone())
        };
        plot = plot
            .custom_x_axes(vec![
                style(egui_plot::AxisHints::new_x())
                    .label(x_label)
                    .formatter(move |mark, _| x_text(mark.value)),
            ])
            .custom_y_axes(vec![
                style(egui_plot::AxisHints::new_y())
                    .min_thickness(42.0)
                    .formatter(move |mark, _| y_text(mark.value)),
            ]);
        let shown = plot.show(ui, move |plot_ui| {
            plot_ui.set_plot_bounds_x(x_range[0]..=x_range[1]);
            plot_ui.set_plot_bounds_y(y_range[0]..=y_range[1]);
            draw(plot_ui);
        });
        shown.response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, self.label));
        let hover = shown.response.hover_pos().map(|p| shown.transform.value_from_position(p));
        ChartResponse { response: shown.response, hover }
    }
}

/// Bars at whole numbers, in parts stacked from the bottom: `heights[part][i]` at `first + i`.
pub fn stacked_bars<const PARTS: usize>(
    plot: &mut PlotUi<'_>,
    first: f64,
    series: [(&'static str, Color32, Vec<f64>); PARTS],
) {
    let mut floor = vec![0.0; series.iter().map(|s| s.2.len()).max().unwrap_or(0)];
    for (name, color, heights) in series {
        let bars = heights
            .iter()
            .zip(&mut floor)
            .enumerate()
            .filter(|(_, (height, _))| **height > 0.0)
            .map(|(i, (height, floor))| {
                let bar = Bar::new(first + i as f64, *height).width(0.8).base_offset(*floor).fill(color);
                *floor += height;
                bar
            })
            .collect();
        plot.bar_chart(BarChart::new(name, bars).color(color).allow_hover(false));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_stand_at_round_numbers_within_the_range() {
        for (range, expected) in
            [([0.0, 10.0], vec![0.0, 5.0, 10.0]), ([0.13, 0.31], vec![0.15, 0.2, 0.25, 0.3])]
        {
            let ticks = Axis::linear(range, 4).ticks;
            assert_eq!(ticks.len(), expected.len(), "{ticks:?}");
            assert!(ticks.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{ticks:?}");
        }
    }

    #[test]
    fn one_value_or_none_still_makes_an_axis() {
        for axis in [Axis::around([3.0]), Axis::around([]), Axis::around([0.0]), Axis::from_zero(f64::NAN)] {
            assert!(axis.range[0] < axis.range[1] && axis.ticks.len() < 8, "{:?}", axis.range);
        }
        let axis = Axis::integers(0.0, 0.0, 6);
        assert_eq!((axis.range, axis.ticks), ([-0.6, 0.6], vec![0.0]));
    }
}
