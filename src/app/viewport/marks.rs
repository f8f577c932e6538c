//! What stands out over everything else: a node of the tree of a file, or a shape, that is marked, and what is selected.

use egui::{Color32, Pos2, Rect, Stroke, Ui, pos2};
use glam::Vec3;

use super::areas::Areas;
use super::{construction_marks, ray_marks, split_marks};
use crate::accel::NodeKind;
use crate::app::state::State;
use crate::geometry::{Aabb, Shape, Triangle};
use crate::inspect::node::kind_of;
use crate::scene::Scene;
use crate::scene::camera::CameraFrame;

/// Of a box's twelve edges, the corners by their bits: x, y, z.
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

pub const OWN: Color32 = Color32::from_rgb(255, 74, 60);
pub const PARENT: Color32 = Color32::from_rgb(255, 214, 64);

/// Of what a selected inner node's box holds.
pub const CHILD: Color32 = Color32::from_rgb(120, 214, 255);

/// A line in space.
pub struct Line {
    pub from: Vec3,
    pub to: Vec3,
    pub color: Color32,
    pub width: f32,
}

/// Paints what is marked and what is selected.
pub fn paint(ui: &Ui, areas: &Areas, state: &State) {
    let (Some(camera), Some([width, height])) = (state.camera(), state.picture_size()) else { return };
    let mut lines = Vec::new();
    if let Some(marked) = &state.marked {
        for (bounds, color, width) in [(marked.parent_bounds, PARENT, 1.5), (marked.bounds, OWN, 2.5)] {
            lines.extend(bounds.into_iter().flat_map(|bounds| edges(&bounds, color, width)));
        }
    }
    selected(state, &mut lines);
    ray_marks::lines(state, &mut lines);
    split_marks::lines(state, &mut lines);
    construction_marks::lines(state, &mut lines);
    if lines.is_empty() {
        return;
    }
    let frame = camera.frame(width, height);
    for slot in 0..state.subjects().len() {
        let Some(area) = areas.slot(slot) else { continue };
        let painter = ui.painter().with_clip_rect(area.intersect(ui.clip_rect()));
        for line in &lines {
            let Some(on_screen) = projected(&frame, line.from, line.to, area) else { continue };
            painter.line_segment(on_screen, Stroke::new(line.width + 2.0, Color32::from_black_alpha(140)));
            painter.line_segment(on_screen, Stroke::new(line.width, line.color));
        }
    }
}

/// The boxes of the selected nodes, of the last one's parent and children, and the edges of the selected shape.
fn selected(state: &State, lines: &mut Vec<Line>) {
    let (Some(document), Some(census), Some(selection)) =
        (&state.document, state.census(), state.selections.current())
    else {
        return;
    };
    let (tree, family) = (document.world.shown_tree(), &census.family);
    let node = selection.node();
    if let Some(parent) = family.parent(node) {
        lines.extend(edges(&family.bounds(tree, parent), PARENT, 1.0));
    }
    if let NodeKind::Inner(children) = kind_of(tree, node) {
        lines.extend(children.iter().flat_map(|(_, bounds)| edges(bounds, CHILD, 1.0)));
    }
    for (_, bounds) in state.selected_bounds() {
        lines.extend(edges(&bounds, OWN, 2.0));
    }
    if let Some(shape) = selection.shape {
        lines.extend(shape_edges(&document.world.scene, shape, Color32::WHITE, 1.5));
    }
}

/// The sides of a triangle; of any other shape the edges of its box. Nothing for what has none.
pub fn shape_edges(scene: &Scene, shape: u32, color: Color32, width: f32) -> Vec<Line> {
    if shape as usize >= scene.shape_count() {
        return Vec::new();
    }
    match scene.shape(shape) {
        Shape::Triangle(Triangle { v: [a, b, c] }) => {
            [(a, b), (b, c), (c, a)].map(|(from, to)| Line { from, to, color, width }).into()
        }
        other @ (Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Quad(_) | Shape::Torus(_)) => {
            edges(&other.bounds(), color, width).collect()
        }
    }
}

/// The twelve edges of a box.
pub fn edges(bounds: &Aabb, color: Color32, width: f32) -> impl Iterator<Item = Line> + use<> {
    let Aabb { min, max } = *bounds;
    let corner = move |i: usize| {
        Vec3::from_array(std::array::from_fn(|axis| if i >> axis & 1 == 0 { min[axis] } else { max[axis] }))
    };
    EDGES.into_iter().map(move |[a, b]| Line { from: corner(a), to: corner(b), color, width })
}

/// The part of a line that lies before the camera, in the area of a picture.
fn projected(frame: &CameraFrame, mut a: Vec3, mut b: Vec3, area: Rect) -> Option<[Pos2; 2]> {
    let nearest = 1e-3 * ((b - a).length() + (0.5 * (a + b) - frame.eye).length());
    let depth = |p: Vec3| (p - frame.eye).dot(frame.forward) - nearest;
    let (depth_a, depth_b) = (depth(a), depth(b));
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
    let line = [on_screen(a), on_screen(b)];
    line.iter().all(|p| p.x.is_finite() && p.y.is_finite()).then_some(line)
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
        let cube = |at: f32| {
            let bounds = Aabb::new(Vec3::Z * at - Vec3::ONE, Vec3::Z * at + Vec3::ONE);
            let lines = edges(&bounds, OWN, 1.0).filter_map(|l| projected(&frame, l.from, l.to, area));
            lines.collect::<Vec<_>>()
        };
        let lines = cube(0.0);
        assert_eq!(lines.len(), 12);
        assert!(lines.iter().flatten().all(|p| area.contains(*p)), "{lines:?}");
        assert!(cube(20.0).is_empty());
        // Around the camera: those before it are left, those beside it are cut.
        let around = cube(5.0);
        assert_eq!(around.len(), 8);
    }
}
