//! What lies under the mouse, and what is missing from the picture, in words over it.

use egui::{Align2, Color32, FontId, Pos2, Rect, Ui, vec2};
use glam::Vec2;

use crate::app::jobs::overlay::left_out;
use crate::app::state::State;
use crate::app::view::Hover;
use crate::render::shadow::ShadowClass;
use crate::render::{View, ViewClass};

/// Asks the scene with one ray, and the film of that slot, about a pixel.
pub fn hover(state: &State, slot: usize, x: u32, y: u32) -> Hover {
    let value = state.picture(slot).and_then(|picture| {
        let scale = picture.frame.scale;
        picture.frame.film.number(x / scale, y / scale)
    });
    let hit = state.picture_size().zip(state.camera()).zip(state.document.as_ref()).and_then(
        |(([width, height], camera), document)| {
            let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            document.world.intersect(&camera.frame(width, height).ray(pixel), &mut ())
        },
    );
    Hover { x, y, value, shape: hit.map(|h| h.shape), distance: hit.map(|h| h.t) }
}

/// Paints the words. `hover`: with the view of the picture that it is over.
pub fn paint(ui: &Ui, rect: Rect, state: &State, hover: Option<(&Hover, View)>) {
    if state.document.is_none() {
        return;
    }
    let margin = vec2(8.0, 8.0);
    if let Some((hover, view)) = hover {
        let at = rect.left_bottom() + vec2(margin.x, -margin.y);
        boxed_text(ui, Align2::LEFT_BOTTOM, at, &words(state, hover, view), FontId::monospace(11.5));
    }
    if let Some(text) = state.boxes.as_ref().and_then(|b| left_out(&b.overlay)) {
        // Two pictures have their names in the corners.
        let (anchor, at) = match state.compare {
            None => (Align2::RIGHT_TOP, rect.right_top() + vec2(-margin.x, margin.y)),
            Some(_) => (Align2::CENTER_TOP, rect.center_top() + vec2(0.0, margin.y + 26.0)),
        };
        boxed_text(ui, anchor, at, &text, FontId::proportional(11.5));
    }
}

/// Text on a dark ground, so that it can be read over any picture. Wraps where the viewport is narrow.
pub fn boxed_text(ui: &Ui, anchor: Align2, at: Pos2, text: &str, font: FontId) {
    let width = (ui.max_rect().width() - 32.0).max(80.0);
    let galley = ui.painter().layout(text.to_owned(), font, Color32::from_gray(228), width);
    let rect = anchor.anchor_size(at, galley.size() + vec2(12.0, 6.0));
    ui.painter().rect_filled(rect, 3.0, Color32::from_black_alpha(170));
    ui.painter().galley(rect.min + vec2(6.0, 3.0), galley, Color32::WHITE);
}

fn words(state: &State, hover: &Hover, view: View) -> String {
    let mut words = format!("{:>4}, {:<4}", hover.x, hover.y);
    match (hover.shape, &state.document) {
        (Some(shape), Some(document)) => {
            let scene = &document.world.scene;
            let kind = if (shape as usize) < scene.shape_count() {
                scene.shape(shape).kind().name()
            } else {
                "plane"
            };
            words += &format!("  {kind} {shape}");
            let material = &scene.material(shape).name;
            if !material.is_empty() {
                words += &format!(" ({material})");
            }
        }
        _ => words += "  nothing",
    }
    if let Some(distance) = hover.distance {
        words += &format!("  {distance:.4} away");
    }
    if let Some(value) = hover.value {
        words += &format!("  {}", value_words(view, value));
    }
    words
}

fn value_words(view: View, value: f32) -> String {
    match view.class() {
        ViewClass::Class => ShadowClass::from_number(value).map_or_else(String::new, |c| c.name().to_owned()),
        ViewClass::Distance => String::new(),
        ViewClass::Heat | ViewClass::Radiance | ViewClass::Data => {
            let number = if value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.2}") };
            format!("{number} {}", view.name().replace('-', " "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_said_in_words() {
        assert_eq!(value_words(View::NodesVisited, 41.0), "41 nodes visited");
        assert_eq!(value_words(View::RayCost, 12.25), "12.25 ray cost");
        assert_eq!(value_words(View::ShadowDifference, 1.0), "lit in both");
    }
}
