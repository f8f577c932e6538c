//! Bars that are also a slider for a range: dragging over them selects, handles move the ends, arrow keys work too.

use egui::accesskit::Role;
use egui::{
    Color32, CursorIcon, EventFilter, Key, Modifiers, Painter, Pos2, Rect, Response, Sense, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};

use crate::app::theme::Palette;

/// How close to an end, in points, the mouse takes hold of it.
const GRAB: f32 = 7.0;

/// What a drag does that does not start at an end of the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeDrag {
    /// Selects a new range from where it started.
    Select,
    /// Moves the nearer end.
    NearerEnd,
}

/// The bars: bar `i` of `n` covers the `i`-th part of `domain`. Its height is the square root of its sum, so that small
/// ones can be seen beside large ones; its two parts stand for their shares of the sum.
pub struct RangeBars<'a> {
    pub label: &'a str,
    pub bars: &'a [[f64; 2]],
    pub domain: [f64; 2],
    /// `None`: nothing is selected, and all bars are dim.
    pub selection: Option<[f64; 2]>,
    /// Ends lie on multiples of this above the domain's start, and at least this far apart; 0 for anywhere.
    pub step: f64,
    pub free_drag: FreeDrag,
    pub height: f32,
    /// Colours of the two parts of a bar, given the middle of its part of the domain.
    pub colors: &'a dyn Fn(f64) -> [Color32; 2],
    /// A further line, not draggable.
    pub mark: Option<f64>,
}

/// What came of a frame.
pub struct RangeBarsResponse {
    pub response: Response,
    /// A new range.
    pub changed: Option<[f64; 2]>,
    /// The bar under the mouse.
    pub hovered: Option<usize>,
}

/// What is being dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    Low,
    High,
    From(f64),
}

impl RangeBars<'_> {
    pub fn show(self, ui: &mut Ui, palette: &Palette) -> RangeBarsResponse {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), self.height), Sense::drag());
        let plot = rect.shrink2(vec2(4.0, 2.0));
        let changed = self
            .drag(ui, &response, plot)
            .or_else(|| self.keys(ui, &response))
            .filter(|r| Some(*r) != self.selection && r[0].is_finite() && r[1].is_finite());
        let hovered = response.hover_pos().filter(|_| !self.bars.is_empty()).map(|p| {
            let t = ((p.x - plot.left()) / plot.width()).clamp(0.0, 1.0);
            ((t * self.bars.len() as f32) as usize).min(self.bars.len() - 1)
        });
        self.paint(ui, rect, plot, &response, hovered, palette);
        let value = self.selection.map_or_else(
            || "nothing selected".to_owned(),
            |[lo, hi]| format!("{} to {}", super::numbers::short(lo), super::numbers::short(hi)),
        );
        response.widget_info(|| {
            let mut info = WidgetInfo::labeled(Role::Slider, ui.is_enabled(), self.label);
            info.current_text_value = Some(value.clone());
            info
        });
        RangeBarsResponse {
            response: response.on_hover_cursor(CursorIcon::ResizeHorizontal),
            changed,
            hovered,
        }
    }

    fn span(&self) -> f64 {
        (self.domain[1] - self.domain[0]).max(f64::MIN_POSITIVE)
    }

    fn x(&self, plot: Rect, value: f64) -> f32 {
        let t = ((value - self.domain[0]) / self.span()).clamp(0.0, 1.0);
        plot.left() + t as f32 * plot.width()
    }

    fn value(&self, plot: Rect, x: f32) -> f64 {
        let t = f64::from((x - plot.left()) / plot.width()).clamp(0.0, 1.0);
        self.domain[0] + t * self.span()
    }

    fn snapped(&self, value: f64) -> f64 {
        if self.step == 0.0 {
            return value;
        }
        self.domain[0] + ((value - self.domain[0]) / self.step).round() * self.step
    }

    /// The bar-wide range around a value, for a selection that starts there.
    fn cell(&self, value: f64) -> [f64; 2] {
        if self.step == 0.0 {
            return [value, value];
        }
        let last = self.domain[1] - self.step;
        let low = (self.domain[0] + ((value - self.domain[0]) / self.step).floor() * self.step).min(last);
        [low, low + self.step]
    }

    fn drag(&self, ui: &Ui, response: &Response, plot: Rect) -> Option<[f64; 2]> {
        let pointer = response.interact_pointer_pos()?;
        let id = response.id.with("grip");
        if response.drag_started() {
            let grip = self.grip_at(plot, pointer);
            ui.data_mut(|d| d.insert_temp(id, grip));
        }
        if !response.dragged() {
            return None;
        }
        let grip: Grip = ui.data(|d| d.get_temp(id))?;
        let value = self.value(plot, pointer.x);
        let current = self.selection.unwrap_or(self.domain);
        Some(match grip {
            Grip::From(start) => {
                let (a, b) = (self.cell(start), self.cell(value));
                [a[0].min(b[0]), a[1].max(b[1])]
            }
            Grip::Low => [self.snapped(value).min(current[1] - self.step), current[1]],
            Grip::High => [current[0], self.snapped(value).max(current[0] + self.step)],
        })
    }

    fn grip_at(&self, plot: Rect, pointer: Pos2) -> Grip {
        let Some([low, high]) = self.selection else {
            return Grip::From(self.value(plot, pointer.x));
        };
        let to_low = (pointer.x - self.x(plot, low)).abs();
        let to_high = (pointer.x - self.x(plot, high)).abs();
        let near = to_low.min(to_high);
        match self.free_drag {
            FreeDrag::Select if near > GRAB => Grip::From(self.value(plot, pointer.x)),
            FreeDrag::Select | FreeDrag::NearerEnd if to_low < to_high => Grip::Low,
            FreeDrag::Select | FreeDrag::NearerEnd => Grip::High,
        }
    }

    /// Left and right move the range; with shift they move its upper end.
    fn keys(&self, ui: &Ui, response: &Response) -> Option<[f64; 2]> {
        if !response.has_focus() {
            return None;
        }
        let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        let presses = |modifiers: Modifiers| {
            ui.input_mut(|i| {
                i.count_and_consume_key(modifiers, Key::ArrowRight) as f64
                    - i.count_and_consume_key(modifiers, Key::ArrowLeft) as f64
            })
        };
        let (grow, step) = (presses(Modifiers::SHIFT), presses(Modifiers::NONE));
        if grow == 0.0 && step == 0.0 {
            return None;
        }
        let unit = if self.step > 0.0 { self.step } else { self.span() / 100.0 };
        let [low, high] = self.selection.unwrap_or(self.domain);
        let shift = (step * unit).clamp(self.domain[0] - low, (self.domain[1] - high).max(0.0));
        let high = (high + shift + grow * unit).clamp(low + shift + self.step, self.domain[1].max(high));
        Some([low + shift, high])
    }

    fn paint(
        &self,
        ui: &Ui,
        rect: Rect,
        plot: Rect,
        response: &Response,
        hovered: Option<usize>,
        palette: &Palette,
    ) {
        if !ui.is_rect_visible(rect) {
            return;
        }
        let painter = ui.painter_at(rect);
        let outline = if response.has_focus() {
            Stroke::new(1.0, palette.accent)
        } else {
            ui.visuals().widgets.noninteractive.bg_stroke
        };
        painter.rect(rect, 3.0, ui.visuals().extreme_bg_color, outline, egui::StrokeKind::Inside);
        if let Some([low, high]) = self.selection {
            let band = Rect::from_x_y_ranges(self.x(plot, low)..=self.x(plot, high), rect.y_range());
            painter.rect_filled(band, 0.0, palette.accent.gamma_multiply(0.12));
        }
        self.paint_bars(&painter, plot, hovered);
        if let Some(mark) = self.mark {
            painter.vline(self.x(plot, mark), rect.y_range(), Stroke::new(1.0, palette.second));
        }
        if let Some(range) = self.selection {
            for end in range {
                paint_handle(&painter, self.x(plot, end), rect, palette.accent);
            }
        }
    }

    fn paint_bars(&self, painter: &Painter, plot: Rect, hovered: Option<usize>) {
        let highest = self.bars.iter().map(|b| b[0] + b[1]).fold(0.0, f64::max);
        if highest <= 0.0 {
            return;
        }
        let width = plot.width() / self.bars.len() as f32;
        let gap = if width > 4.0 { 1.0 } else { 0.0 };
        for (i, bar) in self.bars.iter().enumerate() {
            let total = bar[0] + bar[1];
            if total <= 0.0 {
                continue;
            }
            let middle = self.domain[0] + (i as f64 + 0.5) / self.bars.len() as f64 * self.span();
            let inside = self.selection.is_some_and(|[lo, hi]| lo <= middle && middle <= hi);
            let strength = if hovered == Some(i) || inside { 1.0 } else { 0.35 };
            let left = plot.left() + i as f32 * width;
            let height = (plot.height() * (total / highest).sqrt() as f32).max(2.0);
            let lower = height * (bar[0] / total) as f32;
            let bottom = plot.bottom();
            let parts = [(bottom - lower, bottom), (bottom - height, bottom - lower)];
            for ((top, bottom), color) in parts.into_iter().zip((self.colors)(middle)) {
                let part = Rect::from_min_max(pos2(left, top), pos2(left + width - gap, bottom));
                painter.rect_filled(part, 0.0, color.gamma_multiply(strength));
            }
        }
    }
}

fn paint_handle(painter: &Painter, x: f32, rect: Rect, color: Color32) {
    painter.vline(x, rect.y_range(), Stroke::new(1.5, color));
    let knob = Rect::from_center_size(pos2(x, rect.center().y), vec2(5.0, 16.0));
    painter.rect_filled(knob, 2.0, color);
}
