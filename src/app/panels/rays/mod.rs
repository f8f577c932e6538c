//! The rays of a pixel as a tree, and what each of them did in the tree, step by step.

mod steps;
mod ways;

use egui::accesskit::Role;
use egui::{Button, DragValue, Rect, ScrollArea, Sense, TextEdit, Ui, WidgetInfo, pos2, vec2};

use crate::app::commands::{Command, Commands};
use crate::app::inspection::{RayOrigin, RayView};
use crate::app::view::AppView;
use crate::inspect::ray_tree::{PixelRay, RaySource};
use crate::render::observer::RayKind;
use crate::session::ray_text::{ray_text, read_ray};
use crate::world::World;

use super::glossary::Term;
use super::numbers;
use super::widgets::{self, Figure, Side};

const LINE_HEIGHT: f32 = 18.0;
/// Rays that are seen at once.
const LINES: f32 = 7.0;
const INDENT: f32 = 10.0;

/// View state of the Rays panel.
#[derive(Default)]
pub struct RaysPanel {
    free: String,
    /// Why the text is no ray.
    refused: Option<String>,
    steps: steps::StepsView,
}

impl RaysPanel {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        source(ui, view, commands);
        self.free_ray(ui, view, commands);
        let inspection = view.inspection;
        let (Some(world), Some(found)) = (view.world, &inspection.found) else {
            widgets::section(ui, "Rays");
            let text = match inspection.view.origin {
                None => {
                    "Click a pixel in the viewport: its rays are listed here, with every step that they made."
                }
                Some(_) => "Tracing…",
            };
            widgets::caption(ui, view.palette, text);
            return;
        };
        widgets::term_section(ui, Term::PixelRays);
        heading(ui, view, found.rays.len(), commands);
        let height = LINE_HEIGHT * LINES.min(found.order.len() as f32) + 2.0;
        let list = ScrollArea::vertical().id_salt("pixel rays").max_height(height).auto_shrink([false, true]);
        ui.spacing_mut().item_spacing.y = 0.0;
        list.show_rows(ui, LINE_HEIGHT, found.order.len(), |ui, rows| {
            for &index in &found.order[rows] {
                if ray_line(ui, view, world, index, &found.rays[index]) {
                    let ray_view =
                        RayView { chosen: index, step: usize::MAX, playing: false, ..inspection.view };
                    commands.push(Command::SetRayView(ray_view));
                }
            }
        });
        widgets::set_spacing(ui);
        let Some(ray) = inspection.ray() else { return };
        facts(ui, view, world, ray);
        ways::ui(ui, view, commands);
        self.steps.ui(ui, view, world, commands);
    }

    /// A ray that is typed in, or drawn with the mouse.
    fn free_ray(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let ray_view = view.inspection.view;
        widgets::row(ui, Term::FreeRay, |ui| {
            let width = (ui.available_width() - 58.0).max(60.0);
            let field = TextEdit::singleline(&mut self.free).hint_text("0,1,3,0,0,-1");
            let response = ui.add_sized([width, widgets::ROW_HEIGHT], field);
            let response = response.accessible_name(Term::FreeRay.label());
            let entered = response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if ui.button("Trace").on_hover_text("Follows this ray").clicked() || entered {
                match read_ray(&self.free) {
                    Ok(ray) => {
                        self.refused = None;
                        let origin = Some(RayOrigin::Free(ray));
                        commands.push(Command::SetRayView(RayView { origin, ..ray_view }));
                    }
                    Err(error) => self.refused = Some(error),
                }
            }
            response
        });
        if let Some(error) = &self.refused {
            widgets::notice(ui, view.palette.error, widgets::capitalised(error));
        }
        ui.horizontal_wrapped(|ui| {
            let draw = ui.add(Button::selectable(ray_view.drawing, "Draw a ray"));
            let about = "Drag in the viewport from one surface to another; the camera stays meanwhile.";
            if draw.on_hover_text(about).clicked() {
                let drawing = !ray_view.drawing;
                commands.push(Command::SetRayView(RayView { drawing, ..ray_view }));
            }
            let chosen = view.inspection.ray();
            let take = ui.add_enabled(chosen.is_some(), Button::new("Edit the chosen ray"));
            if let Some(ray) = chosen.filter(|_| take.on_hover_text("Puts it into the field").clicked()) {
                self.free = ray_text(&ray.ray);
            }
        });
    }
}

fn source(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let ray_view = view.inspection.view;
    let describe = |s: RaySource| (s.name(), s.description());
    let current = ray_view.source.unwrap_or(RaySource::of(view.session.view));
    if let Some(source) = widgets::segmented(ui, Term::RaySource, Some(current), &RaySource::ALL, &describe) {
        commands.push(Command::SetRayView(RayView { source: Some(source), ..ray_view }));
    }
    let mut sample = ray_view.sample;
    let field = DragValue::new(&mut sample).range(0..=65_535).speed(0.05);
    if widgets::number(ui, Term::RaySample, field).changed() {
        commands.push(Command::SetRayView(RayView { sample, ..ray_view }));
    }
}

fn heading(ui: &mut Ui, view: &AppView, count: usize, commands: &mut Commands) {
    let ray_view = view.inspection.view;
    let what = match ray_view.origin {
        Some(RayOrigin::Pixel { pixel: [x, y], .. }) => format!("pixel {x}, {y}"),
        Some(RayOrigin::Free(_)) | None => "free ray".to_owned(),
    };
    let rays = if count == 1 { "ray" } else { "rays" };
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{what}: {} {rays}", numbers::count(count)));
        for (name, forward) in [("Previous", false), ("Next", true)] {
            let about = if forward { "The next ray (N)" } else { "The ray before (Shift+N)" };
            if ui.add_enabled(count > 1, Button::new(name).small()).on_hover_text(about).clicked() {
                commands.push(Command::StepRay { forward });
            }
        }
        let mut drawn = ray_view.drawn;
        if ui.checkbox(&mut drawn, "Drawn").on_hover_text("Draws the steps in the viewport").changed() {
            commands.push(Command::SetRayView(RayView { drawn, ..ray_view }));
        }
        outside(ui, view, commands);
    });
}

/// A look at the ray from the side, and back through the camera that it was traced by.
fn outside(ui: &mut Ui, view: &AppView, commands: &mut Commands) {
    let Some(RayOrigin::Pixel { camera, .. }) = view.inspection.view.origin else { return };
    if view.camera == Some(camera) {
        let look = ui.button("From outside");
        if look.on_hover_text("Moves the camera aside; that of the rays is drawn.").clicked() {
            commands.push(Command::LookAtRay);
        }
    } else {
        let back = ui.button("Its camera");
        if back.on_hover_text("Back through the camera that these rays were traced by.").clicked() {
            commands.edit(move |session| session.camera = Some(camera));
        }
    }
}

/// Whether it was clicked.
fn ray_line(ui: &mut Ui, view: &AppView, world: &World, index: usize, ray: &PixelRay) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LINE_HEIGHT), Sense::click());
    let selected = view.inspection.view.chosen == index;
    widgets::paint_line(ui, rect, &response, selected);
    let left = rect.left() + 6.0 + INDENT * ray.depth.min(12) as f32;
    let dot = Rect::from_center_size(pos2(left + 4.0, rect.center().y), vec2(8.0, 8.0));
    ui.painter().rect_filled(dot, 2.0, kind_color(view, ray.kind));
    let cell = Rect::from_x_y_ranges(left + 13.0..=rect.right() - 4.0, rect.y_range());
    let (first, second) = cell.split_left_right_at_x((rect.right() - 64.0).max(cell.left()));
    let text = format!("{} {}", kind_name(ray), found_words(world, ray));
    let cost = format!("{} nodes", numbers::count(ray.counters.nodes_visited()));
    let color = if selected { view.palette.accent } else { ui.visuals().text_color() };
    widgets::paint_text(ui, first, Side::Left, &text, widgets::body_font(ui), color);
    widgets::paint_text(ui, second, Side::Right, &cost, widgets::small_font(ui), view.palette.muted);
    response.widget_info(|| WidgetInfo::selected(Role::TreeItem, true, selected, text.clone()));
    let clicked = response.clicked();
    response.on_hover_text(format!("{text}; {cost} visited, {} shapes tested", ray.counters.shape_tests));
    clicked
}

fn kind_color(view: &AppView, kind: RayKind) -> egui::Color32 {
    match kind {
        RayKind::Camera => view.palette.accent,
        RayKind::Bounce => view.palette.third,
        RayKind::Shadow => view.palette.second,
    }
}

fn kind_name(ray: &PixelRay) -> &'static str {
    match ray.kind {
        RayKind::Camera => "camera",
        RayKind::Bounce => "bounce",
        RayKind::Shadow => "shadow",
    }
}

/// What a ray met.
fn found_words(world: &World, ray: &PixelRay) -> String {
    match (ray.shape, ray.kind) {
        (None, RayKind::Shadow) => "free way".to_owned(),
        (None, RayKind::Camera | RayKind::Bounce) => "nothing".to_owned(),
        (Some(shape), RayKind::Shadow) => format!("blocked by {}", shape_name(world, shape)),
        (Some(shape), RayKind::Camera | RayKind::Bounce) => format!("to {}", shape_name(world, shape)),
    }
}

/// A shape with its kind.
pub fn shape_name(world: &World, shape: u32) -> String {
    let kind = if (shape as usize) < world.scene.shape_count() {
        world.scene.shape(shape).kind().name()
    } else {
        "plane"
    };
    format!("{kind} {shape}")
}

fn facts(ui: &mut Ui, view: &AppView, world: &World, ray: &PixelRay) {
    let palette = view.palette;
    let point = |v: glam::Vec3| v.to_array().map(|x| numbers::short(f64::from(x))).join(", ");
    let exact = format!("As text: {}", ray_text(&ray.ray));
    Figure::new(Term::RayFrom, point(ray.ray.origin)).note(exact).show(ui, palette);
    Figure::new(Term::RayTowards, point(ray.ray.direction)).show(ui, palette);
    let end = if ray.ray.t_max.is_finite() {
        numbers::short(f64::from(ray.ray.t_max))
    } else {
        "no end".to_owned()
    };
    let ends = format!("{} and {end}", numbers::short(f64::from(ray.ray.t_min)));
    Figure::new(Term::RayEnds, ends).show(ui, palette);
    let found = match (ray.shape, ray.t) {
        (Some(shape), Some(t)) => format!("{} at {}", shape_name(world, shape), numbers::short(f64::from(t))),
        _ => "nothing".to_owned(),
    };
    Figure::new(Term::RayFound, found).note(format!("Asked: {}.", ray.query.description())).show(ui, palette);
    let config = &world.report.config;
    let cost = ray.counters.ray_cost(config.traversal_cost, config.intersection_cost);
    Figure::new(Term::RayCost, numbers::decimal(cost, 1)).show(ui, palette);
}
