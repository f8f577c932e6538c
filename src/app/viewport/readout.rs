//! What lies under the mouse, and what is missing from the picture, in words over it.

use egui::{Align2, Color32, FontId, Pos2, Rect, Ui, vec2};
use glam::Vec2;

use crate::app::jobs::overlay::{grouped, left_out};
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
    let hit = state.picture_size().zip(state.shown(slot)).and_then(|([width, height], shown)| {
        let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let ray = shown.camera.frame(width, height).ray(pixel);
        state.seen(slot)?.0.intersect(&ray, &mut ())
    });
    Hover { x, y, value, shape: hit.map(|h| h.shape), distance: hit.map(|h| h.t) }
}

/// Paints the words. `hover`: with the slot of the picture that it is over.
pub fn paint(ui: &Ui, rect: Rect, state: &State, hover: Option<(usize, &Hover)>) {
    if state.document.is_none() {
        return;
    }
    let margin = vec2(8.0, 8.0);
    if let Some((slot, hover)) = hover {
        let at = rect.left_bottom() + vec2(margin.x, -margin.y);
        boxed_text(ui, Align2::LEFT_BOTTOM, at, &words(state, slot, hover), FontId::monospace(11.5));
    }
    if !state.hidden.is_empty() && state.compare.is_none() {
        let count = grouped(state.hidden.shapes.len());
        let counts = if state.session.view.depends_on_tree() { ", but counted" } else { "" };
        let text = format!("{count} shapes hidden{counts}; J shows all");
        boxed_text(ui, Align2::LEFT_TOP, rect.left_top() + margin, &text, FontId::proportional(11.5));
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

fn words(state: &State, slot: usize, hover: &Hover) -> String {
    let view = state.subjects()[slot].view;
    let mut words = format!("{:>4}, {:<4}", hover.x, hover.y);
    match (hover.shape, state.shown(slot)) {
        (Some(shape), Some(shown)) => {
            let scene = &shown.world.scene;
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
    if let Some(both) = both_words(state, hover) {
        words += &format!("  {both}");
    } else if let Some(value) = hover.value {
        words += &format!("  {}", value_words(view, value));
    }
    words
}

/// The numbers of both pictures and their difference, where there are two with numbers of the same thing.
fn both_words(state: &State, hover: &Hover) -> Option<String> {
    let [left, right] = state.side_names().filter(|_| state.compares_numbers())?;
    let value = |slot: usize| {
        let frame = &state.picture(slot)?.frame;
        frame.film.number(hover.x / frame.scale, hover.y / frame.scale)
    };
    let (a, b) = (value(0)?, value(1)?);
    let sign = if b > a { "+" } else { "" };
    Some(format!("{left} {}  {right} {}  difference {sign}{}", plain(a), plain(b), plain(b - a)))
}

fn plain(value: f32) -> String {
    if value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.2}") }
}

fn value_words(view: View, value: f32) -> String {
    match view.class() {
        ViewClass::Class => ShadowClass::from_number(value).map_or_else(String::new, |c| c.name().to_owned()),
        ViewClass::Distance => String::new(),
        ViewClass::Heat | ViewClass::Leaf | ViewClass::Radiance | ViewClass::Data => {
            format!("{} {}", plain(value), view.name().replace('-', " "))
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
