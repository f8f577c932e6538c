//! Boxes of nodes as a model, for other programs to look at: Wavefront OBJ, an object a node.

use std::fmt::Write;
use std::path::Path;

use super::{ExportError, atomic};
use crate::accel::tree::Visit;
use crate::accel::{NodeId, Tree};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// Written at a time, in bytes.
const CHUNK: usize = 1 << 20;

/// The corners of a box's sides, by the bits of a corner: x, y and z at the upper end. Counter-clockwise from outside.
const SIDES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Writes the boxes of nodes, and with `below` those of all nodes below them; each node once. Answers how many boxes. A box
/// without an extent that can be drawn (empty, or not finite) is left out.
///
/// # Errors
/// [`ExportError::Write`]; what lay there before is then untouched.
pub fn save(
    tree: &Tree,
    nodes: &[NodeId],
    below: bool,
    path: &Path,
    task: &Task,
) -> Result<usize, ExportError> {
    let mut count = 0;
    atomic::write_with(path, |file| {
        let refused = |reason: &dyn std::fmt::Display| ExportError::Write {
            path: path.to_owned(),
            reason: reason.to_string(),
        };
        let mut text = String::from("# Boxes of a tree, an object a node; written by bvhscope.\n");
        let mut failed = None;
        // The depth of the chosen node that the walk is below.
        let mut above: Option<u32> = None;
        tree.walk_nodes(|visit| {
            above = above.filter(|depth| visit.depth > *depth);
            let is_chosen = nodes.contains(&visit.id);
            if is_chosen && above.is_none() && below {
                above = Some(visit.depth);
            }
            if (is_chosen || above.is_some()) && push_box(&mut text, tree, &visit, count) {
                count += 1;
            }
            if text.len() >= CHUNK && failed.is_none() {
                failed = task.check().map_err(|Cancelled| refused(&Cancelled)).err();
                failed =
                    failed.take().or_else(|| file.write_all(text.as_bytes()).map_err(|e| refused(&e)).err());
                text.clear();
            }
            failed.is_none()
        });
        match failed {
            Some(error) => Err(error),
            None => file.write_all(text.as_bytes()).map_err(|error| refused(&error)),
        }
    })?;
    Ok(count)
}

/// Adds a box as an object; whether it can be drawn.
fn push_box(text: &mut String, tree: &Tree, visit: &Visit, boxes_before: usize) -> bool {
    let Visit { id, depth, bounds: Aabb { min, max }, .. } = *visit;
    if !(min.is_finite() && max.is_finite() && min.cmple(max).all()) {
        return false;
    }
    let kind = if tree.leaf_index(id).is_some() { "leaf" } else { "node" };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "o {kind}_{}_depth_{depth}", id.0);
    for corner in 0..8_u32 {
        let [x, y, z] = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { max[axis] } else { min[axis] });
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    let first = 8 * boxes_before as u64 + 1;
    for side in SIDES {
        let [a, b, c, d] = side.map(|corner| first + u64::from(corner));
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    }
    true
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::scene::{SceneRef, UpAxis, builtin, load};
    use crate::world::World;

    #[test]
    fn boxes_come_back_as_models_with_outward_sides() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("boxes.obj");
        let scene = Arc::new(builtin::make("soup:300").expect("a scene"));
        let world = World::build(scene, &BuildConfig::default(), &Task::new()).expect("not cancelled");
        let nodes = [NodeId(0), NodeId(1), NodeId(1)];
        let save = |below| super::save(&world.tree, &nodes, below, &path, &Task::new()).expect("written");
        assert_eq!(save(true), world.tree.node_count());
        assert_eq!(save(false), 2);
        let loaded = load::load(&SceneRef::File(path.clone()), UpAxis::Y, &Task::new()).expect("loaded");
        assert_eq!(loaded.scene.shape_count(), 2 * 12);
        assert_eq!(loaded.scene.bounds(), world.tree.bounds());
        let mesh = &loaded.scene.mesh;
        let middle = world.tree.bounds().center();
        for triangle in 0..12 {
            let [a, b, c] = loaded.scene.triangle(triangle).v;
            let out = (b - a).cross(c - a).dot((a + b + c) / 3.0 - middle);
            assert!(out > 0.0, "triangle {triangle} of {} looks inwards", mesh.triangles.len());
        }
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.contains("o node_0_depth_0\n") && text.contains("o node_1_depth_1\n"));
    }
}
