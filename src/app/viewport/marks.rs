//! A node of the tree of a file, or a shape, that stands out: its box and its parent's, over everything else.

use egui::{Color32, Pos2, Rect, Stroke, Ui, pos2};
use glam::Vec3;

use super::areas::Areas;
use crate::app::state::State;
use crate::geometry::Aabb;
use crate::scene::camera::CameraFrame;

/// Of a box's twelve edges, the corners by their bits: x, y, z.
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

pub const OWN: Color32 = Color32::from_rgb(255, 74, 60);
pub const PARENT: Color32 = Color32::from_rgb(255, 214, 64);

pub fn paint(ui: &Ui, areas: &Areas, state: &State) {
    let (Some(marked), Some(camera), Some([width, height])) =
        (&state.marked, state.camera(), state.picture_size())
    else {
        return;
    };
    let frame = camera.frame(width, height);
    for slot in 0..state.subjects().len() {
        let Some(area) = areas.slot(slot) else { continue };
        let painter = ui.painter().with_clip_rect(area.intersect(ui.clip_rect()));
        for (bounds, color, width) in [(marked.parent_bounds, PARENT, 1.5), (marked.bounds, OWN, 2.5)] {
            let Some(bounds) = bounds else { continue };
            for line in outline(&frame, &bounds, area) {
                painter.line_segment(line, Stroke::new(width + 2.0, Color32::from_black_alpha(140)));
                painter.line_segment(line, Stroke::new(width, color));
            }
        }
    }
}

/// The edges of a box that lie before the camera, in the area of a picture.
fn outline(frame: &CameraFrame, bounds: &Aabb, area: Rect) -> Vec<[Pos2; 2]> {
    let corners: [Vec3; 8] = std::array::from_fn(|i| {
        Vec3::from_array(std::array::from_fn(|axis| {
            if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] }
        }))
    });
    let nearest = 1e-3 * (bounds.extent().length() + (bounds.center() - frame.eye).length());
    let depth = |p: Vec3| (p - frame.eye).dot(frame.forward);
    let lines = EDGES.iter().filter_map(|&[a, b]| {
        let (mut a, mut b) = (corners[a], corners[b]);
        let (depth_a, depth_b) = (depth(a) - nearest, depth(b) - nearest);
        if depth_a <= 0.0 && depth_b <= 0.0 {
            return None;
        }
        let cut = a + (b - a) * (depth_a / (depth_a - depth_b));
        if depth_a <= 0.0 {
            a = cut;
        } else if depth_b <= 0.0 {
            b = cut;
        }
        let on_screen = |p: Vec3| {
            let pixel = frame.project(p);
            pos2(
                area.left() + pixel.x / frame.size.x * area.width(),
                area.top() + pixel.y / frame.size.y * area.height(),
            )
        };
        Some([on_screen(a), on_screen(b)])
    });
    lines.filter(|line| line.iter().all(|p| p.x.is_finite() && p.y.is_finite())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Camera;

    #[test]
    fn a_box_in_front_has_twelve_edges_and_one_behind_none() {
        let camera = Camera { eye: Vec3::Z * 5.0, target: Vec3::ZERO, ..Camera::default() };
        let frame = camera.frame(200, 100);
        let area = Rect::from_min_max(pos2(10.0, 20.0), pos2(210.0, 120.0));
        let cube = |at: f32| Aabb::new(Vec3::Z * at - Vec3::ONE, Vec3::Z * at + Vec3::ONE);
        let lines = outline(&frame, &cube(0.0), area);
        assert_eq!(lines.len(), 12);
        assert!(lines.iter().flatten().all(|p| area.contains(*p)), "{lines:?}");
        assert!(outline(&frame, &cube(20.0), area).is_empty());
        // Around the camera: those before it are left, those beside it are cut.
        let around = outline(&frame, &cube(5.0), area);
        assert_eq!(around.len(), 8);
    }
}
