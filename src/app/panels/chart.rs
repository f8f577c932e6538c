//! Small, calm charts in one look: fixed bounds, few ticks, a tooltip of our own, no zoom and no drag. They draw a
//! [`Plot`], and offer to save it.

use egui::accesskit::Role;
use egui::{
    Align, Button, Layout, Popup, Rangef, Rect, Response, RichText, Sense, Ui, UiBuilder, WidgetInfo, vec2,
};
use egui_plot::{
    Bar, BarChart, GridMark, HLine, Line, LineStyle, MarkerShape, PlotPoint, PlotPoints, PlotUi, Points,
    VLine,
};

use crate::app::commands::{Asked, Command, Commands};
use crate::app::theme::Palette;
use crate::app::view::AppView;
use crate::export::plot::PlotFormat;
use crate::inspect::plot::{Axis, Ink, Mark, Plot, Point, Series};

use super::build::summary;
use super::widgets::small_font;

/// Size of the button that opens the menu, in points.
const MENU_BUTTON: [f32; 2] = [22.0, 16.0];

/// A chart of a fixed look.
pub struct Chart {
    pub plot: Plot,
    pub height: f32,
    pub clickable: bool,
}

/// Where the mouse is over a drawn chart.
pub struct ChartResponse {
    pub response: Response,
    /// In the chart's coordinates: places along its axes.
    pub hover: Option<PlotPoint>,
}

impl Chart {
    pub fn show(self, ui: &mut Ui, palette: &Palette, commands: &mut Commands) -> ChartResponse {
        let Self { plot, height, clickable } = self;
        let font = small_font(ui);
        let x_label = RichText::new(plot.x.label.as_str()).font(font.clone()).color(palette.muted);
        let style = |axis: egui_plot::AxisHints<'static>| {
            axis.label_spacing(Rangef::new(1.0, 2.0))
                .tick_label_color(palette.muted)
                .tick_label_font(font.clone())
        };
        let (x_marks, y_marks) = (marks(&plot.x), marks(&plot.y));
        let (x_text, y_text) = (tick_text(&plot.x), tick_text(&plot.y));
        let drawn = egui_plot::Plot::new(plot.title.as_str())
            .height(height)
            .allow_zoom(false)
            .allow_drag(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_axis_zoom_drag(false)
            .allow_double_click_reset(false)
            .show_crosshair(false)
            .label_formatter(|_| None)
            // The second button of the mouse opens the menu of every chart; keys go to its button.
            .sense(if clickable { Sense::click() } else { Sense::CLICK | Sense::HOVER })
            .grid_spacing(Rangef::new(1.0, 2.0))
            .grid_color(palette.muted.gamma_multiply(0.22))
            .x_grid_spacer(move |_| x_marks.clone())
            .y_grid_spacer(move |_| y_marks.clone())
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
        let shown = drawn.show(ui, |plot_ui| {
            plot_ui.set_plot_bounds_x(plot.x.range[0]..=plot.x.range[1]);
            plot_ui.set_plot_bounds_y(plot.y.range[0]..=plot.y.range[1]);
            for series in &plot.series {
                draw(plot_ui, &plot, series, palette);
            }
        });
        shown.response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, &plot.title));
        let hover = shown.response.hover_pos().map(|p| shown.transform.value_from_position(p));
        let over_button = menu(ui, &shown.response, &plot.title, commands, || plot.clone());
        ChartResponse { response: shown.response, hover: hover.filter(|_| !over_button) }
    }
}

/// What a plot of the tree is of: scene and settings.
pub fn subject(view: &AppView) -> String {
    match (view.scene, view.world) {
        (Some(scene), Some(world)) => format!("{}: {}", scene.name, summary(&world.report.config)),
        (scene, _) => scene.map_or_else(String::new, |scene| scene.name.clone()),
    }
}

/// A button in the corner of a plot, and the second button of the mouse anywhere over it: a menu that saves the plot.
/// Whether the mouse is over the button.
pub fn menu(
    ui: &mut Ui,
    over: &Response,
    title: &str,
    commands: &mut Commands,
    plot: impl Fn() -> Plot,
) -> bool {
    let size = vec2(MENU_BUTTON[0], MENU_BUTTON[1]);
    let corner = Rect::from_min_size(over.rect.right_top() + vec2(-size.x - 2.0, 2.0), size);
    let hovered = ui.rect_contains_pointer(over.rect);
    let id = over.id.with("menu");
    let mut button_ui = ui
        .new_child(UiBuilder::new().scope_id(id).max_rect(corner).layout(Layout::right_to_left(Align::Min)));
    let quiet = if hovered { ui.visuals().text_color() } else { ui.visuals().weak_text_color() };
    let text = RichText::new("…").color(quiet).size(13.0);
    let button = button_ui.add(Button::new(text).frame_when_inactive(false).small().min_size(size));
    let button = button.on_hover_text("Saves this plot as a picture, or its data.");
    let button = button.accessible_name(format!("Save plot {title}"));
    let mut items = |ui: &mut Ui| {
        ui.weak(title);
        for format in PlotFormat::ALL {
            if ui.button(format!("Save {}…", format.name())).on_hover_text(format.about()).clicked() {
                commands.push(Command::Ask(Asked::SavePlot { plot: Box::new(plot()), format }));
            }
        }
        if ui.button("Copy data").on_hover_text("The values as CSV to the clipboard.").clicked() {
            let text = crate::export::plot::csv(&plot());
            commands.push(Command::CopyText { text, what: "data of the plot" });
        }
    };
    Popup::menu(&button).show(&mut items);
    Popup::context_menu(over).show(&mut items);
    button.hovered()
}

fn marks(axis: &Axis) -> Vec<GridMark> {
    let steps = axis.ticks.windows(2).map(|w| w[1].at - w[0].at);
    let step_size = steps.fold(f64::INFINITY, f64::min);
    let step_size = if step_size.is_finite() { step_size } else { axis.range[1] - axis.range[0] };
    axis.ticks.iter().map(|tick| GridMark { value: tick.at, step_size }).collect()
}

/// The text of the tick at a place.
fn tick_text(axis: &Axis) -> impl Fn(f64) -> String + use<> {
    let ticks = axis.ticks.clone();
    move |at| {
        let nearest = ticks.iter().min_by(|a, b| (a.at - at).abs().total_cmp(&(b.at - at).abs()));
        nearest.map_or_else(String::new, |tick| tick.text.clone())
    }
}

fn draw(ui: &mut PlotUi<'_>, plot: &Plot, series: &Series, palette: &Palette) {
    let color = |ink| palette.of_ink(ink).gamma_multiply(series.opacity);
    let ink = color(series.ink);
    let place = |p: &Point| [plot.x.scale.place(p.x), plot.y.scale.place(p.y)];
    let places = || PlotPoints::from(series.points.iter().map(place).collect::<Vec<_>>());
    let name = series.name.clone();
    match series.mark {
        Mark::Line { width } => ui.line(Line::new(name, places()).color(ink).width(width).allow_hover(false)),
        Mark::Dots { radius, filled } => {
            if series.points.iter().any(|p| p.color.is_some()) {
                for point in &series.points {
                    let own = point.color.map_or(ink, |rgb| color(Ink::Color(rgb)));
                    let dot = Points::new(name.clone(), PlotPoints::from(vec![place(point)])).color(own);
                    ui.points(dot.radius(radius).filled(filled).allow_hover(false));
                }
            } else {
                ui.points(
                    Points::new(name, places()).color(ink).radius(radius).filled(filled).allow_hover(false),
                );
            }
        }
        Mark::Squares { radius } => ui.points(
            Points::new(name, places())
                .color(ink)
                .radius(radius)
                .shape(MarkerShape::Square)
                .filled(false)
                .allow_hover(false),
        ),
        Mark::Bars { width } => {
            let bars = series.points.iter().filter(|p| p.y > p.base).map(|p| {
                let base = plot.y.scale.place(p.base);
                Bar::new(p.x, plot.y.scale.place(p.y) - base).width(width).base_offset(base).fill(ink)
            });
            ui.bar_chart(BarChart::new(name, bars.collect()).color(ink).allow_hover(false));
        }
        Mark::Across => {
            for point in &series.points {
                let line = HLine::new(name.clone(), plot.y.scale.place(point.y)).color(ink).width(1.0);
                ui.hline(line.style(LineStyle::dashed_dense()).allow_hover(false));
            }
        }
        Mark::Upright => {
            for point in &series.points {
                let line = VLine::new(name.clone(), plot.x.scale.place(point.x)).color(ink).width(1.5);
                ui.vline(line.allow_hover(false));
            }
        }
    }
}
