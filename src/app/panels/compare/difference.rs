//! What B - A of the pictures adds up to: its histogram in the colours of the picture, and the shares of the pixels.

use egui::accesskit::Role;
use egui::{Color32, Rect, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::app::view::{AppView, CompareViews};
use crate::inspect::columns::Better;
use crate::inspect::difference::DifferenceSummary;
use crate::render::difference::difference_color;

use super::super::cost::share_bar;
use super::super::glossary::Term;
use super::super::numbers;
use super::super::widgets::{self, Side};

const HEIGHT: f32 = 84.0;

/// `right`: the name of the state on the right.
pub fn ui(ui: &mut Ui, view: &AppView, compare: CompareViews, right: &str) {
    if compare.left.view != compare.right.view {
        return;
    }
    let Some(summary) = &view.ab.difference else { return };
    widgets::term_section(ui, Term::DifferencePixels);
    histogram(ui, view, summary);
    shares(ui, view, summary, right);
}

fn histogram(ui: &mut Ui, view: &AppView, summary: &DifferenceSummary) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let histogram = &summary.histogram;
    let counts = &histogram.counts;
    // The square root, so that what is rare is seen beside what is equal.
    let height = |count: u64| (count as f32).sqrt();
    let most = counts.iter().copied().map(height).fold(1.0, f32::max);
    let width = rect.width() / counts.len() as f32;
    let mut hovered = None;
    for (i, &count) in counts.iter().enumerate() {
        let left = rect.left() + i as f32 * width;
        let bar = Rect::from_min_max(
            pos2(left, rect.bottom() - height(count) / most * (rect.height() - 4.0)),
            pos2(left + (width - 0.5).max(1.0), rect.bottom()),
        );
        let [from, to] = histogram.bin_range(i);
        let color = visible((from + to) as f32 / 2.0 / summary.limit, view.palette.dark);
        ui.painter().rect_filled(bar, 0.0, color);
        let at = response.hover_pos().filter(|at| (left..left + width).contains(&at.x));
        hovered = hovered.or(at.map(|_| i));
    }
    let zero = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().vline(rect.center().x, rect.y_range(), zero);
    let name = "Histogram of the differences of the pixels";
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    if let Some(i) = hovered {
        let [from, to] = histogram.bin_range(i);
        let which = if to - from == 1.0 {
            numbers::decimal(from + 0.5, 0)
        } else {
            format!("{} to {}", numbers::short(from), numbers::short(to))
        };
        let text = format!("{which}: {} pixels", numbers::count(counts[i]));
        response.on_hover_text_at_pointer(text);
    }
    ends(ui, view, summary);
}

/// The colour of the picture, moved away from the ground where it would vanish on it.
fn visible(t: f32, dark: bool) -> Color32 {
    let [r, g, b] = difference_color(t);
    let color = Color32::from_rgb(r, g, b);
    if dark { color } else { color.lerp_to_gamma(Color32::from_gray(110), 0.3) }
}

fn ends(ui: &mut Ui, view: &AppView, summary: &DifferenceSummary) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 14.0), Sense::hover());
    let (font, muted) = (widgets::small_font(ui), view.palette.muted);
    let [low, high] = [-summary.limit, summary.limit].map(|end| numbers::short(f64::from(end)));
    widgets::paint_text(ui, rect, Side::Left, &low, font.clone(), muted);
    widgets::paint_text(ui, rect, Side::Right, &format!("+{high}"), font.clone(), muted);
    let text = "heights: square root of pixels";
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font, muted);
}

fn shares(ui: &mut Ui, view: &AppView, summary: &DifferenceSummary, right: &str) {
    let p = view.palette;
    let named = |verdict: &str| format!("{verdict} in {right}");
    let [lower, higher] = match summary.better {
        Better::Lower => [(named("better"), p.good), (named("worse"), p.error)],
        Better::Higher => [(named("worse"), p.error), (named("better"), p.good)],
        Better::Neither => [(named("less"), p.accent), (named("more"), p.second)],
    };
    let parts = [
        (lower, summary.lower_count),
        (("equal".to_owned(), p.muted), summary.equal_count),
        (higher, summary.higher_count),
    ];
    let bar: Vec<(f64, Color32)> = parts.iter().map(|((_, color), count)| (*count as f64, *color)).collect();
    share_bar(ui, &bar);
    let total = summary.pixel_count() as f64;
    for ((name, color), count) in parts {
        let (rect, response) =
            ui.allocate_exact_size(vec2(widgets::form_width(ui), widgets::FIGURE_HEIGHT), Sense::hover());
        let swatch = Rect::from_center_size(rect.left_center() + vec2(5.0, 0.0), vec2(10.0, 10.0));
        ui.painter().rect_filled(swatch, 2.0, color);
        let share = format!("{} %", numbers::percent(count as f64, total));
        let text = ui.visuals().text_color();
        let label = Rect::from_x_y_ranges(rect.left() + 18.0..=rect.right() - 140.0, rect.y_range());
        widgets::paint_text(ui, label, Side::Left, &name, widgets::body_font(ui), text);
        let mono = widgets::number_font(ui);
        widgets::paint_text(ui, rect, Side::Right, &share, mono.clone(), p.muted);
        let number = rect.with_max_x(rect.right() - 66.0);
        let strong = ui.visuals().strong_text_color();
        widgets::paint_text(ui, number, Side::Right, &numbers::count(count), mono, strong);
        let said = format!("{name}: {} pixels, {share}", numbers::count(count));
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &said));
    }
    let mean = summary.histogram.mean;
    let sign = if mean > 0.0 { "+" } else { "" };
    widgets::Figure::new(Term::DifferenceMean, format!("{sign}{}", numbers::decimal(mean, 3))).show(ui, p);
    if summary.missing_count > 0 {
        let text =
            format!("{} pixels have a number on one side only.", numbers::count(summary.missing_count));
        widgets::caption(ui, p, text);
    }
}
