//! The picture in the middle, the boxes over it, and what the mouse and the keys do there.

mod areas;
mod camera_input;
pub mod marks;
mod readout;
mod textures;

use egui::{
    Align2, Color32, CursorIcon, FontId, Id, Rect, Response, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use super::commands::Commands;
use super::state::State;
use super::theme::VIEWPORT_BACKGROUND;
use super::view::{CompareStyle, Hover};
use areas::Areas;
use camera_input::CameraInput;
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
        if !wiping {
            self.camera.update(ui, &response, &areas, state, commands);
        }
        self.textures.update(ui, state);
        self.paint_pictures(ui, &areas, state);
        marks::paint(ui, &areas, state);
        let hover = self.hover(&response, &areas, state);
        paint_labels(ui, &areas, state, self.wipe.0);
        let shown = hover.as_ref().map(|(slot, hover)| (hover, state.subjects()[*slot].view));
        readout::paint(ui, rect, state, shown);
        if state.document.is_none() {
            paint_welcome(ui, rect, state);
        }
        ViewportOutput { size: areas.pixels, hover: hover.map(|(_, hover)| hover) }
    }

    fn paint_pictures(&self, ui: &Ui, areas: &Areas, state: &State) {
        for slot in 0..state.subjects().len() {
            let Some(area) = areas.slot(slot) else { continue };
            let mut painter = ui.painter().with_clip_rect(area.intersect(ui.clip_rect()));
            if state.compare.is_some_and(|c| c.style == CompareStyle::Wipe) && slot == 1 {
                let mut right = area;
                right.min.x = areas.wipe_x(self.wipe.0);
                painter.shrink_clip_rect(right);
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

    /// What is under the mouse, and in which of the pictures.
    fn hover(&self, response: &Response, areas: &Areas, state: &State) -> Option<(usize, Hover)> {
        let at = response.hover_pos().filter(|_| !response.dragged())?;
        let slot = if state.compare.is_some_and(|c| c.style == CompareStyle::Wipe) {
            usize::from(at.x > areas.wipe_x(self.wipe.0))
        } else {
            (0..state.subjects().len())
                .find(|slot| areas.slot(*slot).is_some_and(|area| area.contains(at)))?
        };
        let [width, height] = state.picture_size()?;
        let area = areas.slot(slot)?;
        let share = (at - area.min) / area.size();
        let pixel = |share: f32, size: u32| ((share * size as f32).max(0.0) as u32).min(size - 1);
        Some((slot, readout::hover(state, slot, pixel(share.x, width), pixel(share.y, height))))
    }
}

/// Names two pictures, and draws the line between them.
fn paint_labels(ui: &Ui, areas: &Areas, state: &State, wipe: f32) {
    let Some(compare) = state.compare else { return };
    if compare.style == CompareStyle::Wipe {
        let x = areas.wipe_x(wipe);
        let line = Stroke::new(1.5, Color32::from_white_alpha(220));
        ui.painter().vline(x, areas.whole.y_range(), line);
        ui.painter().circle_filled(pos2(x, areas.whole.center().y), 4.0, line.color);
    }
    for (slot, view) in [compare.left, compare.right].into_iter().enumerate() {
        let Some(area) = areas.slot(slot) else { continue };
        let (anchor, corner) = match (compare.style, slot) {
            (CompareStyle::Wipe, 1) => (Align2::RIGHT_TOP, area.right_top() + vec2(-8.0, 8.0)),
            _ => (Align2::LEFT_TOP, area.left_top() + vec2(8.0, 8.0)),
        };
        readout::boxed_text(ui, anchor, corner, view.name(), FontId::proportional(12.0));
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
