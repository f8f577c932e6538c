//! The rays of a pixel in space, the camera that they were traced by, and what the current step is about.

use egui::Color32;
use glam::{Vec2, Vec3};

use super::marks::{CHILD, Line, OWN, PARENT, edges, shape_edges};
use crate::accel::{Family, NodeId, Tree};
use crate::app::inspection::RayOrigin;
use crate::app::state::State;
use crate::inspect::ray_history::{Outcome, RayHistory, RayStep};
use crate::inspect::ray_tree::PixelRay;
use crate::render::observer::RayKind;

const CAMERA_RAY: Color32 = Color32::from_rgb(94, 178, 255);
const BOUNCE_RAY: Color32 = Color32::from_rgb(150, 220, 140);
const SHADOW_RAY: Color32 = Color32::from_rgb(255, 176, 84);
const ENTERED: Color32 = Color32::from_rgb(122, 224, 130);
const MISSED: Color32 = Color32::from_gray(120);
const FRUSTUM: Color32 = Color32::from_gray(205);

/// Rays of a pixel that are drawn besides the chosen one.
const MOST_RAYS: usize = 400;
/// Waiting boxes that are drawn, the next ones.
const MOST_WAITING: usize = 32;

/// Everything that is drawn of the rays that are looked at.
pub fn lines(state: &State, lines: &mut Vec<Line>) {
    let inspection = &state.inspection;
    let (Some(document), Some(found)) = (&state.document, &inspection.found) else { return };
    if !inspection.view.drawn || found.key.tree != document.tree {
        return;
    }
    let bounds = document.world.tree.bounds();
    let size = if bounds.is_finite() { bounds.extent().length().max(1e-6) } else { 1.0 };
    frustum(state, size, lines);
    // A ray from the eye that is looked through is a point.
    let eye = state.camera().map(|camera| camera.eye);
    let is_seen = |ray: &PixelRay| eye != Some(ray.ray.origin);
    for (index, ray) in found.rays.iter().enumerate().take(MOST_RAYS) {
        if index != inspection.view.chosen && is_seen(ray) {
            lines.push(ray_line(ray, size, 1.0));
        }
    }
    if let Some(census) = state.census()
        && let Some(recorded) = &inspection.recorded
    {
        let (step, count) = inspection.step();
        let draw = StepDrawer { tree: &document.world.tree, family: &census.family, lines };
        draw.step(&recorded.history, step, count, &document.world.scene);
    }
    lines.extend(inspection.ray().filter(|ray| is_seen(ray)).map(|ray| ray_line(ray, size, 2.5)));
}

/// From the origin to the hit, or a good way further.
fn ray_line(ray: &PixelRay, size: f32, width: f32) -> Line {
    let color = match ray.kind {
        RayKind::Camera => CAMERA_RAY,
        RayKind::Bounce => BOUNCE_RAY,
        RayKind::Shadow => SHADOW_RAY,
    };
    let far = 2.0 * size / ray.ray.direction.length().max(f32::MIN_POSITIVE);
    let end = ray.t.unwrap_or(ray.ray.t_max.min(far));
    Line { from: ray.ray.at(ray.ray.t_min), to: ray.ray.at(end), color, width }
}

/// The camera of the rays, once it is looked at from elsewhere.
fn frustum(state: &State, size: f32, lines: &mut Vec<Line>) {
    let (Some(RayOrigin::Pixel { camera, .. }), Some([width, height])) =
        (state.inspection.view.origin, state.picture_size())
    else {
        return;
    };
    if state.camera() == Some(camera) {
        return;
    }
    let frame = camera.frame(width, height);
    let corner = |x: f32, y: f32| frame.ray(Vec2::new(x, y)).at(0.12 * size);
    let (w, h) = (width as f32, height as f32);
    let corners = [corner(0.0, 0.0), corner(w, 0.0), corner(w, h), corner(0.0, h)];
    let line = |from: Vec3, to: Vec3| Line { from, to, color: FRUSTUM, width: 1.0 };
    for i in 0..4 {
        lines.push(line(frame.eye, corners[i]));
        lines.push(line(corners[i], corners[(i + 1) % 4]));
    }
}

struct StepDrawer<'s> {
    tree: &'s Tree,
    family: &'s Family,
    lines: &'s mut Vec<Line>,
}

impl StepDrawer<'_> {
    fn step(mut self, history: &RayHistory, step: usize, count: usize, scene: &crate::scene::Scene) {
        if step == count {
            // All leaves that were visited.
            for step in &history.steps {
                if let RayStep::Leaf { node } = step {
                    self.node(*node, CHILD, 1.0);
                }
            }
            return;
        }
        let moment = history.after(step);
        for (node, _) in moment.stack.iter().rev().take(MOST_WAITING) {
            self.node(*node, CHILD, 0.75);
        }
        let Some(current) = step.checked_sub(1).and_then(|i| history.steps.get(i)) else { return };
        match current {
            RayStep::Boxes { node, children, .. } => {
                for child in children {
                    let color = if child.entry.is_some() { ENTERED } else { MISSED };
                    self.lines.extend(edges(&child.bounds, color, 1.0));
                }
                self.node(*node, OWN, 2.0);
            }
            RayStep::Push { node, .. } | RayStep::Pop { node, .. } => self.node(*node, ENTERED, 2.0),
            RayStep::Drop { node, .. } => self.node(*node, MISSED, 2.0),
            RayStep::Leaf { node } => self.node(*node, OWN, 2.0),
            RayStep::Shape { shape, outcome } => {
                if let Some(node) = moment.node {
                    self.node(node, PARENT, 1.0);
                }
                let color = match outcome {
                    Outcome::Nearest { .. } | Outcome::Stops { .. } => ENTERED,
                    Outcome::Behind { .. } | Outcome::LetsPass { .. } => SHADOW_RAY,
                    Outcome::Missed | Outcome::Skipped | Outcome::NotReached => MISSED,
                };
                self.lines.extend(shape_edges(scene, *shape, color, 2.0));
            }
            RayStep::Stop { shape } | RayStep::Nearest { shape, .. } => {
                self.lines.extend(shape_edges(scene, *shape, ENTERED, 2.0));
            }
            RayStep::Begin { .. } => self.node(NodeId(0), OWN, 1.0),
            RayStep::Outside { .. } | RayStep::Miss => {}
        }
    }

    fn node(&mut self, node: NodeId, color: Color32, width: f32) {
        if (node.0 as usize) < self.family.len() {
            self.lines.extend(edges(&self.family.bounds(self.tree, node), color, width));
        }
    }
}
