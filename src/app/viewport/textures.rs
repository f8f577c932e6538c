//! The pictures on the graphics card: each is sent once, when it is a new one.

use std::sync::Arc;

use egui::{Color32, ColorImage, Painter, Rect, TextureFilter, TextureHandle, TextureOptions, Ui, pos2};

use crate::app::jobs::render::MOST_PICTURES;
use crate::app::state::State;

/// Pixels stay pixels when they are larger than the screen's: they are what is inspected.
const PIXELS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    wrap_mode: egui::TextureWrapMode::ClampToEdge,
    mipmap_mode: None,
};

/// The textures of the viewport.
#[derive(Default)]
pub struct Textures {
    pictures: [Option<Sent>; MOST_PICTURES],
    boxes: [Option<Sent>; MOST_PICTURES],
    difference: Option<Sent>,
}

/// A picture on the card.
struct Sent {
    version: u64,
    texture: TextureHandle,
}

impl Textures {
    /// Sends what is new.
    pub fn update(&mut self, ui: &Ui, state: &State) {
        for slot in 0..MOST_PICTURES {
            let picture = state.picture(slot).map(|p| (p.version, &p.frame.presented.image));
            send(ui, &mut self.pictures[slot], picture, "picture");
        }
        for slot in 0..MOST_PICTURES {
            let boxes = state.boxes_of(slot).map(|b| (b.version, &b.image));
            send(ui, &mut self.boxes[slot], boxes, "boxes");
        }
        let difference = state.ab.difference.as_ref().map(|d| (d.version, &d.image));
        send(ui, &mut self.difference, difference, "difference");
    }

    /// Paints a picture with the boxes over it.
    pub fn paint(&self, painter: &Painter, slot: usize, area: Rect) {
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        for sent in [&self.pictures[slot], &self.boxes[slot]].into_iter().flatten() {
            painter.image(sent.texture.id(), area, all, Color32::WHITE);
        }
    }

    /// Paints B - A with the boxes of B over it; whether there is such a picture.
    pub fn paint_difference(&self, painter: &Painter, area: Rect) -> bool {
        let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        for sent in [&self.difference, &self.boxes[1]].into_iter().flatten() {
            painter.image(sent.texture.id(), area, all, Color32::WHITE);
        }
        self.difference.is_some()
    }
}

fn send(ui: &Ui, sent: &mut Option<Sent>, image: Option<(u64, &Arc<ColorImage>)>, name: &str) {
    let Some((version, image)) = image else {
        *sent = None;
        return;
    };
    match sent {
        Some(sent) if sent.version == version => {}
        Some(sent) => {
            sent.texture.set(Arc::clone(image), PIXELS);
            sent.version = version;
        }
        None => {
            let texture = ui.ctx().load_texture(name, Arc::clone(image), PIXELS);
            *sent = Some(Sent { version, texture });
        }
    }
}
