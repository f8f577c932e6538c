//! Drawing the boxes over the picture. The distances that hide them are kept while the camera rests.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui::ColorImage;

use super::gate::OnLease;
use super::keys::{DepthKey, OverlayKey};
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::render::Overlay;
use crate::render::overlay::{draw_boxes, first_hit_distances};
use crate::task::Cancelled;
use crate::world::World;

/// While the camera moves, boxes are drawn coarser if they would take longer than this.
const MOVING_MS: f64 = 30.0;

/// Boxes that take longer give way to those of a newer camera; those that take less are shown, if late.
const PATIENCE: Duration = Duration::from_secs(1);

/// The coarsest boxes, in pixels of the picture.
const COARSEST: u32 = 4;

#[derive(Clone)]
pub struct OverlayRequest {
    pub key: OverlayKey,
    pub world: Arc<World>,
    /// Whose surfaces hide boxes.
    pub seen: Arc<World>,
    /// Shapes whose boxes are not drawn, ascending.
    pub hidden: Arc<Vec<u32>>,
    /// Pixels of the picture a pixel of the overlay.
    pub scale: u32,
}

pub struct OverlayDone {
    pub key: OverlayKey,
    pub scale: u32,
    pub overlay: Arc<Overlay>,
    pub image: Arc<ColorImage>,
    /// What it took.
    pub ms: f64,
}

pub type OverlayJob = Job<OverlayRequest, OverlayDone>;

type DepthCache = Mutex<Option<(DepthKey, Arc<Vec<f32>>)>>;

pub fn job() -> OverlayJob {
    let cache: DepthCache = Mutex::new(None);
    Job::new(Patience::Within(PATIENCE), PoolKind::Draw, move |run| {
        // A cancelled overlay says nothing; the next one is on its way.
        if let Ok(done) = draw(run, &cache) {
            run.emit(done);
        }
    })
}

/// How coarse the boxes are drawn while the camera moves, from what they last took (at which scale).
pub fn moving_scale(last: Option<(f64, u32)>) -> u32 {
    let Some((ms, scale)) = last else { return 2 };
    let full_ms = ms * f64::from(scale * scale);
    let mut scale = 1;
    while scale < COARSEST && full_ms / f64::from(scale * scale) > MOVING_MS {
        scale *= 2;
    }
    scale
}

fn draw(run: &Run<OverlayRequest, OverlayDone>, cache: &DepthCache) -> Result<OverlayDone, Cancelled> {
    let _pass = run.context.gate.enter(run.task, OnLease::Finish)?;
    let OverlayRequest { key, world, hidden, scale, .. } = run.request;
    let start = Instant::now();
    let (width, height) = (key.width.div_ceil(*scale).max(1), key.height.div_ceil(*scale).max(1));
    let depth = depth(run, cache, width, height)?;
    let overlay = draw_boxes(world, &key.camera, &key.settings, hidden, &depth, [width, height], run.task)?;
    let size = [width as usize, height as usize];
    let image = ColorImage::from_rgba_premultiplied(size, overlay.image.as_raw());
    Ok(OverlayDone {
        key: *key,
        scale: *scale,
        overlay: Arc::new(overlay),
        image: Arc::new(image),
        ms: start.elapsed().as_secs_f64() * 1e3,
    })
}

/// The distances to the first surfaces; infinite where nothing is to be hidden.
fn depth(
    run: &Run<OverlayRequest, OverlayDone>,
    cache: &DepthCache,
    width: u32,
    height: u32,
) -> Result<Arc<Vec<f32>>, Cancelled> {
    let OverlayRequest { key, seen, .. } = run.request;
    if key.settings.show_hidden {
        return Ok(Arc::new(vec![f32::INFINITY; width as usize * height as usize]));
    }
    let wanted = DepthKey { scene: key.tree.scene, camera: key.camera, width, height, hidden: key.hidden };
    let lock = || cache.lock().expect("nothing panics while it holds the cache");
    if let Some((found, depth)) = &*lock()
        && *found == wanted
    {
        return Ok(Arc::clone(depth));
    }
    let depth = Arc::new(first_hit_distances(seen, &key.camera, width, height, run.task)?);
    *lock() = Some((wanted, Arc::clone(&depth)));
    Ok(depth)
}

/// What was left out, in a sentence; `None` if all boxes that could be seen are there.
pub fn left_out(overlay: &Overlay) -> Option<String> {
    if overlay.too_small + overlay.over_budget == 0 {
        return None;
    }
    let reasons: Vec<String> = [
        (overlay.outside, "outside the picture"),
        (overlay.too_small, "smaller than a pixel"),
        (overlay.over_budget, "beyond the budget"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, why)| format!("{} {why}", grouped(count)))
    .collect();
    let (drawn, selected) = (grouped(overlay.drawn), grouped(overlay.selected));
    Some(format!("{drawn} of {selected} boxes drawn: {}", reasons.join(", ")))
}

/// A count with commas between the thousands.
pub fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::RgbaImage;

    fn overlay(outside: usize, too_small: usize, over_budget: usize) -> Overlay {
        let selected = 1_000_000;
        Overlay {
            image: RgbaImage::new(1, 1),
            selected,
            drawn: selected - outside - too_small - over_budget,
            outside,
            too_small,
            over_budget,
            color_range: None,
            density_range: None,
        }
    }

    #[test]
    fn boxes_left_out_are_counted_with_the_reason() {
        assert_eq!(left_out(&overlay(0, 0, 0)), None);
        assert_eq!(left_out(&overlay(7, 0, 0)), None, "nobody misses what is behind the camera");
        assert_eq!(
            left_out(&overlay(0, 900_000, 87_655)).as_deref(),
            Some("12,345 of 1,000,000 boxes drawn: 900,000 smaller than a pixel, 87,655 beyond the budget")
        );
        assert_eq!(
            [0, 7, 999, 1000, 12345, 1234567].map(grouped).join(" "),
            "0 7 999 1,000 12,345 1,234,567"
        );
    }

    #[test]
    fn slow_boxes_get_coarse_while_the_camera_moves() {
        assert_eq!(moving_scale(None), 2);
        assert_eq!(moving_scale(Some((20.0, 1))), 1);
        assert_eq!(moving_scale(Some((20.0, 2))), 2);
        assert_eq!(moving_scale(Some((4000.0, 1))), COARSEST);
    }
}
