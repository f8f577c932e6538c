//! The picture in the middle, the boxes over it, and what the mouse and the keys do there.

mod areas;
mod blink;
mod camera_input;
mod construction_marks;
pub mod marks;
mod ray_marks;
mod readout;
pub mod split_marks;
mod textures;

use egui::{
    Align2, Color32, CursorIcon, FontId, Id, Pos2, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};

use super::commands::{Command, Commands};
use super::inspection::{RayOrigin, RayView};
use super::selection::Pick;
use super::state::State;
use super::theme::VIEWPORT_BACKGROUND;
use super::view::{CompareStyle, Hover};
use crate::geometry::Ray;
use crate::inspect::region::Region;
use areas::Areas;
use blink::Blink;
use camera_input::CameraInput;
use glam::{Vec2, Vec3};
use textures::Textures;

/// Half the width of what the mouse can take hold of at the line of a wipe, in points.
const WIPE_GRIP: f32 = 6.0;

/// The view state of the viewport.
#[derive(Default)]
pub struct Viewport {
    textures: Textures,
    camera: CameraInput,
    /// Where the line between two pictures is, as a share of the width.
    wipe: Wipe,
    /// Where a ray that is being drawn begins.
    drawn_from: Option<Vec3>,
    /// Where a part of the picture that is being marked begins.
    marked_from: Option<[u32; 2]>,
    blink: Blink,
}

struct Wipe(f32);

impl Default for Wipe {
    fn default() -> Self {
        Self(0.5)
    }
}

/// What the viewport found out while it drew.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewportOutput {
    /// Its picture area in pixels.
    pub size: [u32; 2],
    pub hover: Option<Hover>,
}

impl Viewport {
    /// Draws into all of `ui`.
    pub fn ui(&mut self, ui: &mut Ui, state: &State, commands: &mut Commands) -> ViewportOutput {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Viewport"));
        ui.painter().rect_filled(rect, 0.0, VIEWPORT_BACKGROUND);
        let areas = Areas::new(ui, rect, state.compare.map(|c| c.style));
        let wiping = self.wipe_line(ui, &areas, state);
        let drawing = state.inspection.view.drawing;
        let over_numbers = state.picture(0).is_some_and(|picture| picture.frame.film.numbers_count() > 0);
        let marking = over_numbers && self.mark_region(ui, &response, &areas, state, commands);
        if marking {
            // The camera stays meanwhile.
        } else if drawing && !wiping {
            self.draw_ray(&response, &areas, state, commands);
        } else if !wiping {
            self.camera.update(ui, &response, &areas, state, commands);
        }
        self.textures.update(ui, state);
        let in_front = self.blink.update(ui, state);
        self.paint_pictures(ui, &areas, state, in_front);
        marks::paint(ui, &areas, state);
        self.paint_region(ui, &areas, state);
        let hover = self.hover(&response, &areas, state, in_front);
        if response.clicked() && !drawing && !(over_numbers && ui.input(|i| i.modifiers.shift)) {
            pick(ui, hover.as_ref(), state, commands);
        }
        paint_labels(ui, &areas, state, self.wipe.0, in_front);
        readout::paint(ui, rect, state, hover.as_ref().map(|(slot, hover)| (*slot, hover)));
        if state.document.is_none() {
            paint_welcome(ui, rect, state);
        }
        ViewportOutput { size: areas.pixels, hover: hover.map(|(_, hover)| hover) }
    }

    /// `in_front`: the picture that is seen where one hides the other.
    fn paint_pictures(&self, ui: &Ui, areas: &Areas, state: &State, in_front: usize) {
        let style = state.compare.map(|compare| compare.style);
        for slot in 0..state.subjects().len() {
            let Some(area) = areas.slot(slot) else { continue };
            let mut painter = ui.painter().with_clip_rect(area.intersect(ui.clip_rect()));
            match style {
                None | Some(CompareStyle::SideBySide) => {}
                Some(CompareStyle::Wipe) if slot == 0 => {}
                Some(CompareStyle::Wipe) => {
                    let mut right = area;
                    right.min.x = areas.wipe_x(self.wipe.0);
                    painter.shrink_clip_rect(right);
                    // What lies below must not show through where there is nothing yet.
                    painter.rect_filled(right, 0.0, VIEWPORT_BACKGROUND);
                }
                Some(CompareStyle::Blink) if slot == in_front => {}
                Some(CompareStyle::Difference) if slot == in_front => {
                    if self.textures.paint_difference(&painter, area) {
                        continue;
                    }
                }
                Some(CompareStyle::Blink | CompareStyle::Difference) => continue,
            }
            self.textures.paint(&painter, slot, area);
        }
    }

    /// Lets the mouse drag the line between two pictures; whether it does.
    fn wipe_line(&mut self, ui: &Ui, areas: &Areas, state: &State) -> bool {
        if state.compare.is_none_or(|c| c.style != CompareStyle::Wipe) {
            return false;
        }
        let x = areas.wipe_x(self.wipe.0);
        let grip = Rect::from_x_y_ranges(x - WIPE_GRIP..=x + WIPE_GRIP, areas.whole.y_range());
        let response = ui
            .interact(grip, Id::unique("bvhscope wipe"), Sense::drag())
            .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        response.widget_info(|| {
            WidgetInfo::slider(true, f64::from(self.wipe.0), "Line between the two pictures")
        });
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.wipe.0 = ((at.x - areas.whole.left()) / areas.whole.width()).clamp(0.02, 0.98);
        }
        response.dragged()
    }

    /// A drag with Shift over a picture of numbers marks a part of it; a click ends that. Whether it does.
    fn mark_region(
        &mut self,
        ui: &Ui,
        response: &Response,
        areas: &Areas,
        state: &State,
        commands: &mut Commands,
    ) -> bool {
        let shift = ui.input(|i| i.modifiers.shift);
        let wipe = self.wipe.0;
        let pixel = |at: Pos2| pixel_at(at, areas, state, wipe, 0).map(|(_, pixel)| pixel);
        if shift && response.drag_started_by(egui::PointerButton::Primary) {
            let from = ui.input(|i| i.pointer.press_origin()).and_then(pixel);
            self.marked_from = from;
        }
        if shift && response.clicked() {
            commands.push(Command::SetRegion(None));
        }
        let (Some(from), Some(size)) = (self.marked_from, state.picture_size()) else { return false };
        if let Some(to) = response.interact_pointer_pos().and_then(pixel)
            && response.dragged()
        {
            commands.push(Command::SetRegion(Region::between(from, to, size)));
        }
        if !response.dragged() {
            self.marked_from = None;
        }
        true
    }

    /// The part of the picture whose numbers are looked at, in every picture.
    fn paint_region(&self, ui: &Ui, areas: &Areas, state: &State) {
        let Some(region) = state.region else { return };
        for slot in 0..state.subjects().len() {
            let Some(area) = areas.slot(slot) else { continue };
            let share = |pixel: [u32; 2]| {
                let [x, y] = std::array::from_fn(|i| pixel[i] as f32 / region.size[i].max(1) as f32);
                area.min + vec2(x, y) * area.size()
            };
            let rect = Rect::from_min_max(share(region.from), share(region.to));
            let painter = ui.painter().with_clip_rect(area.intersect(ui.clip_rect()));
            for (width, color) in [(3.0, Color32::from_black_alpha(150)), (1.25, Color32::WHITE)] {
                painter.rect_stroke(rect, 0.0, Stroke::new(width, color), egui::StrokeKind::Middle);
            }
        }
    }

    /// A drag from one surface to another is a ray.
    fn draw_ray(&mut self, response: &Response, areas: &Areas, state: &State, commands: &mut Commands) {
        let hit = |at: Pos2| {
            let (_, pixel) = pixel_at(at, areas, state, self.wipe.0, 0)?;
            surface_at(state, pixel)
        };
        let Some(at) = response.interact_pointer_pos() else { return };
        if response.drag_started() {
            self.drawn_from = response.ctx.input(|i| i.pointer.press_origin()).and_then(hit);
        } else if response.dragged()
            && let (Some(from), Some(to)) = (self.drawn_from, hit(at))
            && let Some(direction) = (to - from).try_normalize()
        {
            // Not from inside the surface that it begins on.
            let reach = 1e-4 * (from.abs().max_element() + (to - from).length());
            let origin = Some(RayOrigin::Free(Ray::new(from + reach * direction, direction)));
            commands.push(Command::SetRayView(RayView { origin, ..state.inspection.view }));
        }
    }

    /// What is under the mouse, and in which of the pictures.
    fn hover(
        &self,
        response: &Response,
        areas: &Areas,
        state: &State,
        in_front: usize,
    ) -> Option<(usize, Hover)> {
        let at = response.hover_pos().filter(|_| !response.dragged())?;
        let (slot, [x, y]) = pixel_at(at, areas, state, self.wipe.0, in_front)?;
        Some((slot, readout::hover(state, slot, x, y)))
    }
}

/// The picture under a point of the screen, and its pixel there.
fn pixel_at(at: Pos2, areas: &Areas, state: &State, wipe: f32, in_front: usize) -> Option<(usize, [u32; 2])> {
    let slot = match state.compare.map(|compare| compare.style) {
        Some(CompareStyle::Wipe) => usize::from(at.x > areas.wipe_x(wipe)),
        Some(CompareStyle::Blink | CompareStyle::Difference) => in_front,
        None | Some(CompareStyle::SideBySide) => (0..state.subjects().len())
            .find(|slot| areas.slot(*slot).is_some_and(|area| area.contains(at)))?,
    };
    let [width, height] = state.picture_size()?;
    let area = areas.slot(slot)?;
    let share = (at - area.min) / area.size();
    let pixel = |share: f32, size: u32| ((share * size as f32).max(0.0) as u32).min(size - 1);
    Some((slot, [pixel(share.x, width), pixel(share.y, height)]))
}

/// Where the first surface behind a pixel is; where there is none, a point as far away as the scene is.
fn surface_at(state: &State, [x, y]: [u32; 2]) -> Option<Vec3> {
    let (document, camera, [width, height]) =
        (state.document.as_ref()?, state.camera()?, state.picture_size()?);
    let ray = camera.frame(width, height).ray(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
    let seen = state.visible_world().unwrap_or(&document.world);
    let t = seen.intersect(&ray, &mut ()).map(|hit| hit.t);
    Some(ray.at(t.unwrap_or_else(|| (document.world.tree.bounds().center() - ray.origin).length())))
}

/// Selects what lies under the mouse; nothing where nothing does.
fn pick(ui: &Ui, hover: Option<&(usize, Hover)>, state: &State, commands: &mut Commands) {
    let (Some((slot, Hover { x, y, .. })), Some(document)) = (hover, &state.document) else { return };
    let (Some(shown), Some(size)) = (state.shown(*slot), state.picture_size()) else { return };
    if shown.tree != document.tree {
        let message = "This is not the active state: make it active to select in its tree.".to_owned();
        commands.push(Command::Report { message, error: false });
        return;
    }
    let add = ui.input(|i| i.modifiers.command);
    let pick = Pick::Pixel { camera: shown.camera, size, pixel: [*x, *y] };
    commands.push(Command::Select { pick, add });
}

/// Names two pictures, and draws the line between them.
fn paint_labels(ui: &Ui, areas: &Areas, state: &State, wipe: f32, in_front: usize) {
    let (Some(compare), Some([left, right])) = (state.compare, state.side_names()) else { return };
    if compare.style == CompareStyle::Wipe {
        let x = areas.wipe_x(wipe);
        let line = Stroke::new(1.5, Color32::from_white_alpha(220));
        ui.painter().vline(x, areas.whole.y_range(), line);
        ui.painter().circle_filled(pos2(x, areas.whole.center().y), 4.0, line.color);
    }
    if let (CompareStyle::SideBySide, Some(right)) = (compare.style, areas.slot(1)) {
        // Two dark pictures would run together.
        let line = Stroke::new(1.0, Color32::from_gray(120));
        ui.painter().vline(right.left(), right.y_range(), line);
    }
    let label = |anchor: Align2, area: Rect, text: &str| {
        let corner = match anchor {
            Align2::RIGHT_TOP => area.right_top() + vec2(-8.0, 8.0),
            _ => area.left_top() + vec2(8.0, 8.0),
        };
        readout::boxed_text(ui, anchor, corner, text, FontId::proportional(12.0));
    };
    let named = |slot: usize, name: &str| match state.shown(slot) {
        Some(_) => name.to_owned(),
        None => format!("{name}: no tree yet"),
    };
    let names = [named(0, &left), named(1, &right)];
    match compare.style {
        CompareStyle::SideBySide | CompareStyle::Wipe => {
            for (slot, name) in names.iter().enumerate() {
                let Some(area) = areas.slot(slot) else { continue };
                let is_right = compare.style == CompareStyle::Wipe && slot == 1;
                label(if is_right { Align2::RIGHT_TOP } else { Align2::LEFT_TOP }, area, name);
            }
        }
        CompareStyle::Blink => label(Align2::LEFT_TOP, areas.whole, &names[in_front]),
        CompareStyle::Difference if !state.compares_numbers() => {
            let text = format!("{}: this picture has no numbers to subtract", names[in_front]);
            label(Align2::LEFT_TOP, areas.whole, &text);
        }
        CompareStyle::Difference => {
            label(Align2::LEFT_TOP, areas.whole, &format!("{right} - {left}"));
        }
    }
}

/// What to do while nothing is open.
fn paint_welcome(ui: &Ui, rect: Rect, state: &State) {
    let text = match &state.loading {
        Some(job) => format!("{}…", capitalized(&job.what)),
        None => "Open a model with File > Open, or drop one here: OBJ, PLY, STL, glTF".to_owned(),
    };
    let color = Color32::from_gray(170);
    ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(15.0), color);
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
