//! The camera under mouse and keys: left orbits, middle or Shift and left pans, the wheel dollies, WASD and QE fly.

use std::time::Instant;

use egui::{Key, PointerButton, Response, Ui};
use glam::{Vec2, Vec3};

use super::areas::Areas;
use crate::app::commands::Commands;
use crate::app::state::State;
use crate::scene::Camera;

/// Radians a point of the mouse.
const ORBIT_SPEED: f32 = 0.008;

/// Steps of the dolly a point of scrolling.
const DOLLY_SPEED: f32 = 0.02;

/// Seconds that it takes to fly through the whole scene, and with Shift.
const FLY_SECONDS: f32 = 4.0;
const FAST_FLY_SECONDS: f32 = 1.0;

/// A frame that took longer than this moves no further, in seconds.
const LONGEST_STEP: f32 = 0.1;

/// Keys, and the directions that they fly to: right, up, forward.
const FLY_KEYS: [(Key, Vec3); 6] = [
    (Key::W, Vec3::Z),
    (Key::S, Vec3::NEG_Z),
    (Key::D, Vec3::X),
    (Key::A, Vec3::NEG_X),
    (Key::E, Vec3::Y),
    (Key::Q, Vec3::NEG_Y),
];

/// What lasts longer than a frame.
#[derive(Default)]
pub struct CameraInput {
    flying_since: Option<Instant>,
}

impl CameraInput {
    /// Moves the camera as the user asks.
    pub fn update(
        &mut self,
        ui: &Ui,
        response: &Response,
        areas: &Areas,
        state: &State,
        commands: &mut Commands,
    ) {
        let Some(before) = state.camera() else { return };
        let mut camera = before;
        drag(&mut camera, ui, response, areas);
        scroll(&mut camera, ui, response);
        self.fly(&mut camera, ui, state);
        if camera != before {
            commands.edit(move |session| session.camera = Some(camera));
        }
    }

    fn fly(&mut self, camera: &mut Camera, ui: &Ui, state: &State) {
        let direction = if ui.ctx().text_edit_focused() { Vec3::ZERO } else { fly_direction(ui) };
        if direction == Vec3::ZERO {
            self.flying_since = None;
            return;
        }
        let now = Instant::now();
        let seconds =
            self.flying_since.replace(now).map_or(1.0 / 60.0, |before| (now - before).as_secs_f32());
        let size = state.document.as_ref().map_or(1.0, |d| d.world.tree.bounds().extent().length());
        let crossing = if ui.input(|i| i.modifiers.shift) { FAST_FLY_SECONDS } else { FLY_SECONDS };
        camera.fly(direction.normalize() * size * seconds.min(LONGEST_STEP) / crossing);
        // As long as the key is down.
        ui.ctx().request_repaint();
    }
}

fn drag(camera: &mut Camera, ui: &Ui, response: &Response, areas: &Areas) {
    let delta = response.drag_delta();
    if delta == egui::Vec2::ZERO {
        return;
    }
    let shift = ui.input(|i| i.modifiers.shift);
    let left = response.dragged_by(PointerButton::Primary);
    if response.dragged_by(PointerButton::Middle) || (left && shift) {
        camera.pan(Vec2::new(delta.x, delta.y), areas.whole.height());
    } else if left {
        // The scene turns with the mouse, so the eye goes the other way.
        camera.orbit(-delta.x * ORBIT_SPEED, delta.y * ORBIT_SPEED);
    }
}

fn scroll(camera: &mut Camera, ui: &Ui, response: &Response) {
    if !response.contains_pointer() {
        return;
    }
    let (scroll, zoom) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
    let steps = scroll * DOLLY_SPEED + zoom.ln() * 10.0;
    if steps != 0.0 && steps.is_finite() {
        camera.dolly(steps);
    }
}

fn fly_direction(ui: &Ui) -> Vec3 {
    ui.input(|i| {
        // With Ctrl or Alt the same keys mean something else.
        if i.modifiers.ctrl || i.modifiers.alt || i.modifiers.command {
            return Vec3::ZERO;
        }
        FLY_KEYS.iter().filter(|(key, _)| i.key_down(*key)).map(|(_, direction)| *direction).sum()
    })
}
