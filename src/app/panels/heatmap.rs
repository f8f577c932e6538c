//! What is counted for each pixel, how the counts are coloured, and what they add up to.

use egui::accesskit::Role;
use egui::{
    Color32, ComboBox, DragValue, Mesh, Rect, Sense, Shape, Slider, SliderClamping, Ui, WidgetInfo, pos2,
    vec2,
};

use crate::app::commands::{Command, Commands};
use crate::app::view::AppView;
use crate::inspect::histogram::Histogram;
use crate::inspect::plot::{Plot, tree};
use crate::inspect::region::PixelNumber;
use crate::render::{ColorMap, ColorScale, CountKind, DisplaySettings, ToneMap, View, ViewClass};

use super::chart::{self, Chart};
use super::glossary::Term;
use super::numbers;
use super::range_bars::{FreeDrag, RangeBars};
use super::widgets::{self, Figure};

/// Most bars that are drawn; the histogram's bins are added up to them.
const MOST_BARS: usize = 96;
const EXPOSURES: std::ops::RangeInclusive<f32> = -8.0..=8.0;

/// Where the range comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RangeMode {
    Auto,
    Manual,
}

impl RangeMode {
    const ALL: [Self; 2] = [Self::Auto, Self::Manual];
}

/// View state of the Heatmap panel.
#[derive(Default)]
pub struct HeatmapPanel {
    /// The picture that was shown before a counter was chosen here.
    picture: Option<View>,
    /// The histogram's ends while the range is held, so that the bars do not move under the hand.
    held_domain: Option<[f64; 2]>,
}

impl HeatmapPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::section(ui, "What is counted");
        self.counter(ui, view, commands);
        count_kind(ui, view, commands);
        if !is_numeric(view.session.view) {
            let text = format!(
                "The picture is {} now. Choose a counter to see a heatmap.",
                view.session.view.name()
            );
            widgets::caption(ui, view.palette, text);
            development(ui, view, commands);
            under_mouse(ui, view);
            return;
        }
        widgets::section(ui, "Colours");
        color_map(ui, view, commands);
        scale(ui, view, commands);
        self.range(ui, view, commands);
        threshold(ui, view, commands);
        under_mouse(ui, view);
        statistics(ui, view);
        region(ui, view, commands);
        largest(ui, view, commands);
    }

    fn counter(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let choices: Vec<View> = View::ALL.into_iter().filter(|v| is_numeric(*v)).collect();
        let current = Some(view.session.view).filter(|v| is_numeric(*v));
        let describe = |v: View| (view_name(v), v.description());
        if let Some(chosen) = widgets::combo(ui, Term::Counter, current, &choices, &describe, "none") {
            if current.is_none() {
                self.picture = Some(view.session.view);
            }
            commands.edit(move |s| s.view = chosen);
        }
        if current.is_some() {
            let picture = self.picture.unwrap_or_default();
            let text = format!("Back to {}", picture.name());
            if ui.button(text).on_hover_text(picture.description()).clicked() {
                commands.edit(move |s| s.view = picture);
            }
        }
    }

    fn range(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let manual = view.session.display.range;
        let mode = if manual.is_some() { RangeMode::Manual } else { RangeMode::Auto };
        let describe = |m: RangeMode| match m {
            RangeMode::Auto => ("auto", "follows the picture, from 0 to the 99.5th percentile"),
            RangeMode::Manual => ("manual", "stays as it is"),
        };
        let shown = manual.or(view.range);
        if let Some(mode) = widgets::segmented(ui, Term::Range, Some(mode), &RangeMode::ALL, &describe) {
            let range = if mode == RangeMode::Manual { shown } else { None };
            commands.edit(move |s| s.display.range = range);
        }
        range_fields(ui, view, shown, commands);
        if view.range_locked {
            let text = "Held while you drag, so that the colours stay comparable.";
            widgets::notice(ui, view.palette.accent, text);
        }
        self.histogram(ui, view, shown, commands);
    }

    fn histogram(&mut self, ui: &mut Ui, view: &AppView, range: Option<[f32; 2]>, commands: &mut Commands) {
        let Some((histogram, [lo, hi])) = view.histogram.zip(range) else {
            widgets::caption(ui, view.palette, "No pixel has a number yet.");
            return;
        };
        let domain = self.domain(view, histogram, [lo, hi]);
        let bars = rebinned(histogram, domain);
        let DisplaySettings { colormap: map, scale, .. } = view.session.display;
        let (low, high) = (f64::from(lo), f64::from(hi));
        let colors = |value: f64| {
            let [r, g, b] = map.color(scale.place(value as f32, [lo, hi]));
            [visible(Color32::from_rgb(r, g, b), ui_is_dark(view)); 2]
        };
        let shown = RangeBars {
            label: "Range of the colour map, over the histogram",
            bars: &bars,
            domain,
            selection: Some([low, high]),
            step: 0.0,
            free_drag: FreeDrag::NearerEnd,
            height: 96.0,
            colors: &colors,
            mark: view.session.display.threshold.map(f64::from),
        }
        .show(ui, view.palette);
        let name = view.session.view.name().replace('-', " ");
        let plot = || tree::histogram(histogram, &name, [low, high]).of(chart::subject(view));
        chart::menu(ui, &shown.response, "Histogram", commands, plot);
        ends(ui, view, domain);
        if let Some([a, b]) = shown.changed {
            let range = [a.min(b) as f32, a.max(b) as f32];
            commands.edit(move |s| s.display.range = Some(range));
        }
        if let Some(i) = shown.hovered {
            let width = (domain[1] - domain[0]) / bars.len() as f64;
            let from = domain[0] + i as f64 * width;
            let text = format!(
                "{} to {}: {} pixels",
                numbers::short(from),
                numbers::short(from + width),
                numbers::count(bars[i][0] as u64)
            );
            shown.response.on_hover_text_at_pointer(text);
        }
    }

    /// What the bars cover: all numbers, and the range. Stays while the range is held or dragged.
    fn domain(&mut self, view: &AppView, histogram: &Histogram, range: [f32; 2]) -> [f64; 2] {
        let lo = f64::from(histogram.range[0].min(range[0]));
        let hi = f64::from(histogram.range[1].max(range[1]));
        let now = [lo, if hi > lo { hi } else { lo + 1.0 }];
        if !view.range_locked {
            self.held_domain = Some(now);
        }
        self.held_domain.unwrap_or(now)
    }
}

/// The numbers of a part of the picture.
fn region(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    widgets::term_section(ui, Term::Region);
    let found = view.region.and_then(|figures| Some((figures.region?, figures.histogram.as_ref()?)));
    let Some((region, histogram)) = found else {
        widgets::caption(ui, view.palette, "Shift + drag in the viewport marks a part of the picture.");
        return;
    };
    let ([x, y], [to_x, to_y]) = (region.from, region.to);
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{x}, {y} to {}, {}", to_x - 1, to_y - 1));
        if ui.button("Clear").on_hover_text("Shift + click in the viewport does the same").clicked() {
            commands.push(Command::SetRegion(None));
        }
    });
    let name = view.session.view.name().replace('-', " ");
    let ends = histogram.range.map(f64::from);
    let plot = Plot { title: "Region".to_owned(), ..tree::histogram(histogram, &name, ends) };
    let plot = plot.of(chart::subject(view));
    Chart { plot, height: 96.0, clickable: false }.show(ui, view.palette, commands);
    for (term, value) in [
        (Term::RegionPixels, histogram.value_count as f64),
        (Term::Mean, histogram.mean),
        (Term::Median, f64::from(histogram.median)),
        (Term::P95, f64::from(histogram.p95)),
        (Term::Maximum, f64::from(histogram.max)),
    ] {
        Figure::new(term, numbers::short(value)).show(ui, view.palette);
    }
}

/// The most expensive pixels, each a click away.
fn largest(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    const LINE: f32 = 17.0;
    widgets::term_section(ui, Term::LargestPixels);
    let pixels = view.region.map_or(&[][..], |figures| &figures.largest);
    if pixels.is_empty() {
        widgets::caption(ui, view.palette, "No pixel has a number yet.");
        return;
    }
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for PixelNumber { pixel: [x, y], number } in pixels {
            let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE), Sense::click());
            widgets::paint_line(ui, rect, &response, false);
            let (left, right) = rect.shrink2(vec2(4.0, 0.0)).split_left_right_at_fraction(0.5);
            let (place, value) = (format!("{x}, {y}"), numbers::short(f64::from(*number)));
            let (text, font) = (ui.visuals().text_color(), widgets::number_font(ui));
            widgets::paint_text(ui, left, widgets::Side::Left, &place, font.clone(), text);
            widgets::paint_text(ui, right, widgets::Side::Right, &value, font, text);
            response.widget_info(|| WidgetInfo::labeled(Role::Link, true, format!("Pixel {place}: {value}")));
            if response.on_hover_text("Selects what this pixel shows, and looks at its rays").clicked() {
                commands.push(Command::GoToPixel([*x, *y]));
            }
        }
    });
}

fn is_numeric(view: View) -> bool {
    matches!(view.class(), ViewClass::Heat | ViewClass::Leaf | ViewClass::Distance)
}

/// The name for people: `nodes visited` for `nodes-visited`.
pub fn view_name(view: View) -> &'static str {
    match view {
        View::Path => "path",
        View::Whitted => "whitted",
        View::Albedo => "albedo",
        View::Normal => "normal",
        View::Depth => "depth",
        View::ShapeId => "shape id",
        View::NodesVisited => "nodes visited",
        View::BoxTests => "box tests",
        View::ShapeTests => "shape tests",
        View::LeafVisits => "leaf visits",
        View::RayCost => "ray cost",
        View::ShadowIntersect => "shadow: intersect",
        View::ShadowOccluded => "shadow: occluded",
        View::ShadowFiltered => "shadow: filtered",
        View::ShadowDifference => "shadow: difference",
        View::ShadowSaving => "shadow: nodes saved",
        View::LeafDepth => "leaf depth",
        View::LeafSize => "leaf size",
        View::LeafSahShare => "leaf SAH share",
        View::LeafEpo => "leaf EPO",
        View::LeafFill => "leaf fill",
        View::LeafRays => "rays in the leaf",
        View::ParentOverlap => "overlap above the leaf",
        View::ParentEmptySpace => "empty space above the leaf",
        View::LeafId => "leaf id",
        View::Material => "material",
    }
}

fn ui_is_dark(view: &AppView) -> bool {
    view.palette.dark
}

/// The darkest colours of a map would vanish on a dark panel, the lightest on a light one.
fn visible(color: Color32, dark: bool) -> Color32 {
    let towards = if dark { Color32::from_gray(120) } else { Color32::from_gray(90) };
    color.lerp_to_gamma(towards, 0.25)
}

fn count_kind(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let counts = view.session.view.counts_rays();
    let describe = |c: CountKind| (c.name(), c.description());
    let chosen = ui.add_enabled_ui(counts, |ui| {
        widgets::segmented(ui, Term::Count, Some(view.session.count), &CountKind::ALL, &describe)
    });
    chosen.response.on_disabled_hover_text("This picture does not count rays of a kind.");
    if let Some(count) = chosen.inner {
        commands.edit(move |s| s.count = count);
    }
}

fn color_map(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let current = view.session.display.colormap;
    widgets::row(ui, Term::ColorMap, |ui| {
        let shown = ComboBox::from_id_salt("colormap")
            .width(ui.available_width())
            .selected_text(current.name())
            .show_ui(ui, |ui| {
                for map in ColorMap::ALL {
                    if map_choice(ui, map, map == current) {
                        commands.edit(move |s| s.display.colormap = map);
                    }
                }
            });
        shown.response.accessible_name(Term::ColorMap.label()).on_hover_text(current.description());
    });
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 12.0), Sense::hover());
    paint_gradient(ui, rect, current);
    response.on_hover_text(current.description());
}

fn scale(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let current = Some(view.session.display.scale);
    let describe = |s: ColorScale| (s.name(), s.description());
    if let Some(scale) = widgets::segmented(ui, Term::NumberScale, current, &ColorScale::ALL, &describe) {
        commands.edit(move |s| s.display.scale = scale);
    }
}

/// How light becomes colour, for pictures of light.
fn development(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    if view.session.view.class() != ViewClass::Radiance {
        return;
    }
    widgets::section(ui, "Light");
    let display = view.session.display;
    let mut exposure = display.exposure;
    let slider = Slider::new(&mut exposure, EXPOSURES)
        .clamping(SliderClamping::Edits)
        .fixed_decimals(1)
        .suffix(" EV")
        .trailing_fill(false);
    if widgets::slider(ui, Term::Exposure, slider).changed() {
        commands.edit(move |s| s.display.exposure = exposure);
    }
    let describe = |t: ToneMap| (t.name(), t.description());
    if let Some(tonemap) =
        widgets::segmented(ui, Term::ToneCurve, Some(display.tonemap), &ToneMap::ALL, &describe)
    {
        commands.edit(move |s| s.display.tonemap = tonemap);
    }
}

/// A colour map's name beside its colours. True if it was clicked.
fn map_choice(ui: &mut Ui, map: ColorMap, selected: bool) -> bool {
    ui.horizontal(|ui| {
        let (rect, strip) = ui.allocate_exact_size(vec2(72.0, 14.0), Sense::click());
        paint_gradient(ui, rect, map);
        strip
            .widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Image, true, map.description()));
        let name = ui.selectable_label(selected, map.name()).on_hover_text(map.description());
        strip.clicked() || name.clicked()
    })
    .inner
}

fn paint_gradient(ui: &Ui, rect: Rect, map: ColorMap) {
    const STEPS: u32 = 48;
    let mut mesh = Mesh::default();
    for i in 0..=STEPS {
        let t = i as f32 / STEPS as f32;
        let [r, g, b] = map.color(t);
        let x = rect.left() + t * rect.width();
        mesh.colored_vertex(pos2(x, rect.top()), Color32::from_rgb(r, g, b));
        mesh.colored_vertex(pos2(x, rect.bottom()), Color32::from_rgb(r, g, b));
        if i > 0 {
            let k = 2 * i;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k, k + 1);
        }
    }
    ui.painter().add(Shape::mesh(mesh));
}

fn range_fields(ui: &mut Ui, view: &AppView, shown: Option<[f32; 2]>, commands: &mut Commands) {
    let [mut lo, mut hi] = shown.unwrap_or([0.0, 1.0]);
    let speed = (f64::from(hi - lo) / 200.0).max(0.001);
    let mut changed = false;
    ui.add_enabled_ui(shown.is_some(), |ui| {
        ui.horizontal(|ui| {
            let low = DragValue::new(&mut lo).speed(speed).range(f32::MIN..=hi).max_decimals(2);
            changed |= widgets::named_number(ui, Term::RangeLow, low).changed();
            ui.label("to");
            let high = DragValue::new(&mut hi).speed(speed).range(lo..=f32::MAX).max_decimals(2);
            changed |= widgets::named_number(ui, Term::RangeHigh, high).changed();
            let fit = ui
                .button("Fit")
                .on_hover_text("Sets the range from the lowest to the highest number of the picture.");
            if let (true, Some(histogram)) = (fit.clicked(), view.histogram) {
                [lo, hi] = [histogram.min, histogram.max];
                changed = true;
            }
        });
    });
    if changed {
        commands.edit(move |s| s.display.range = Some([lo, hi]));
    }
}

/// The histogram's counts over another domain that covers its own.
fn rebinned(histogram: &Histogram, domain: [f64; 2]) -> Vec<[f64; 2]> {
    let n = histogram.counts.len().clamp(1, MOST_BARS);
    let mut bars = vec![[0.0; 2]; n];
    let [lo, hi] = histogram.range.map(f64::from);
    let width = (hi - lo) / histogram.counts.len().max(1) as f64;
    for (i, &count) in histogram.counts.iter().enumerate() {
        let middle = lo + (i as f64 + 0.5) * width;
        let t = (middle - domain[0]) / (domain[1] - domain[0]);
        bars[((t * n as f64).max(0.0) as usize).min(n - 1)][0] += count as f64;
    }
    bars
}

/// The numbers at the two ends of the bars.
fn ends(ui: &mut Ui, view: &AppView, domain: [f64; 2]) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 14.0), Sense::hover());
    let font = widgets::small_font(ui);
    let muted = view.palette.muted;
    widgets::paint_text(ui, rect, widgets::Side::Left, &numbers::short(domain[0]), font.clone(), muted);
    widgets::paint_text(ui, rect, widgets::Side::Right, &numbers::short(domain[1]), font.clone(), muted);
    let text = "heights: square root of pixels";
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, text, font, muted);
}

fn threshold(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let current = view.session.display.threshold;
    let suggested = view.histogram.map_or(1.0, |h| h.p95);
    ui.horizontal(|ui| {
        if widgets::switch(ui, Term::Threshold, current.is_some()) {
            let threshold = if current.is_some() { None } else { Some(suggested) };
            commands.edit(move |s| s.display.threshold = threshold);
        }
        if let Some(mut value) = current {
            let speed = (f64::from(value.abs()) / 100.0).max(0.01);
            let field = DragValue::new(&mut value).speed(speed).max_decimals(2);
            if widgets::named_number(ui, Term::Threshold, field).changed() {
                commands.edit(move |s| s.display.threshold = Some(value));
            }
        }
    });
}

fn under_mouse(ui: &mut Ui, view: &AppView) {
    widgets::term_section(ui, Term::UnderMouse);
    let hover = view.hover;
    let p = view.palette;
    if is_numeric(view.session.view) {
        let value = hover.and_then(|h| h.value).map(f64::from);
        let name = widgets::capitalised(view_name(view.session.view));
        Figure::new(Term::Counter, numbers::short(value)).label(&name).show(ui, p);
    }
    let pixel = hover.map_or(numbers::DASH.to_owned(), |h| format!("{}, {}", h.x, h.y));
    Figure::new(Term::Pixel, pixel).show(ui, p);
    let shape = hover.and_then(|h| h.shape).map_or(numbers::DASH.to_owned(), numbers::count);
    Figure::new(Term::HoverShape, shape).show(ui, p);
    let distance = hover.and_then(|h| h.distance).map(f64::from);
    Figure::new(Term::HoverDistance, numbers::short(distance)).show(ui, p);
}

fn statistics(ui: &mut Ui, view: &AppView) {
    widgets::section(ui, "All pixels");
    let h = view.histogram;
    let figures = [
        (Term::Mean, h.map(|h| h.mean)),
        (Term::Median, h.map(|h| f64::from(h.median))),
        (Term::P95, h.map(|h| f64::from(h.p95))),
        (Term::P99, h.map(|h| f64::from(h.p99))),
        (Term::Maximum, h.map(|h| f64::from(h.max))),
    ];
    for (term, value) in figures {
        Figure::new(term, numbers::decimal(value, 2)).show(ui, view.palette);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histogram(counts: Vec<u64>, range: [f32; 2]) -> Histogram {
        let value_count = counts.iter().sum();
        Histogram {
            range,
            counts,
            value_count,
            min: range[0],
            max: range[1],
            mean: 0.0,
            median: 0.0,
            p95: 0.0,
            p99: 0.0,
        }
    }

    #[test]
    fn no_pixel_is_lost_when_bars_cover_more_than_the_numbers() {
        let h = histogram((1..=256).collect(), [0.0, 64.0]);
        for domain in [[0.0, 64.0], [0.0, 100.0], [-10.0, 64.0]] {
            let bars = rebinned(&h, domain);
            assert_eq!(bars.iter().map(|b| b[0]).sum::<f64>(), h.value_count as f64);
            assert!(bars.len() <= MOST_BARS);
        }
        let half = rebinned(&h, [0.0, 128.0]);
        assert!(half[half.len() / 2 + 1..].iter().all(|b| b[0] == 0.0));
    }
}
