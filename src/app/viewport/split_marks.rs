//! The planes at which the selected node could be split, and the two boxes that one of them would make.

use egui::Color32;
use glam::Vec3;

use super::marks::{Line, edges};
use crate::app::state::State;
use crate::geometry::Aabb;

const PLANE: Color32 = Color32::from_rgb(190, 160, 255);
const HOVERED: Color32 = Color32::WHITE;
/// The two sides of a plane.
pub const LEFT: Color32 = Color32::from_rgb(94, 178, 255);
pub const RIGHT: Color32 = Color32::from_rgb(255, 176, 84);

/// Planes that are drawn at once; of more only every n-th.
const MOST_PLANES: usize = 64;

pub fn lines(state: &State, lines: &mut Vec<Line>) {
    let (Some(document), Some(selection)) = (&state.document, state.selections.current()) else { return };
    let splitting = &state.splitting;
    let Some(found) = splitting.of(document.tree, selection.node()).filter(|_| splitting.view.drawn) else {
        return;
    };
    let bounds = &found.curve.bounds;
    let planes = &found.planes[1].axes[splitting.view.axis];
    let step = planes.len().div_ceil(MOST_PLANES).max(1);
    for plane in planes.iter().step_by(step) {
        lines.extend(outline(bounds, plane.axis, plane.position, PLANE, 0.75));
    }
    if let Some((axis, position)) = splitting.view.hovered {
        lines.extend(outline(bounds, axis, position, HOVERED, 2.0));
        for ((_, side), color) in splitting.sides.into_iter().flatten().zip([LEFT, RIGHT]) {
            if !side.is_empty() {
                lines.extend(edges(&side, color, 2.0));
            }
        }
    }
}

/// Where a plane cuts a box.
fn outline(bounds: &Aabb, axis: usize, position: f32, color: Color32, width: f32) -> [Line; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |high_u: bool, high_v: bool| {
        let mut point = Vec3::ZERO;
        point[axis] = position;
        point[u] = if high_u { bounds.max[u] } else { bounds.min[u] };
        point[v] = if high_v { bounds.max[v] } else { bounds.min[v] };
        point
    };
    let corners = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
    std::array::from_fn(|i| Line { from: corners[i], to: corners[(i + 1) % 4], color, width })
}
