//! Which boxes are drawn: level by level through the tree, in parallel, and the same ones at any thread count.

use glam::Vec3;
use rayon::prelude::*;

use super::color::SHARE_SPAN;
use super::project::{Footprint, PixelRect, Projector};
use super::{BoxColor, OverlaySettings};
use crate::accel::{ChildRef, Tree, WideBvh};
use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

/// Nodes that one step of work looks at; small enough that a cancel is seen within a millisecond.
const CHUNK: usize = 4096;

/// A box to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct ShownBox {
    pub bounds: Aabb,
    pub rect: PixelRect,
    pub clipped: bool,
    pub depth: u32,
    /// Width + height on screen, in pixels.
    pub size: f32,
    /// What its colour says: a depth, a number of shapes, a share; NaN for nothing.
    pub value: f32,
    /// From the eye to the nearest point of the box, squared.
    distance2: f32,
    /// Inner nodes first, then leaves.
    node: u32,
}

/// The boxes to be drawn, the farthest first, and what was left out.
#[derive(Debug, Default)]
pub struct Selection {
    pub boxes: Vec<ShownBox>,
    pub selected: usize,
    pub outside: usize,
    pub too_small: usize,
    pub over_budget: usize,
    /// Values at the two ends of the colour ramp.
    pub color_range: Option<[f32; 2]>,
}

/// Picks the boxes that `settings` ask for. `shares`: each node's share of the SAH cost, in order of [`NodeId`](crate::accel::NodeId); looked
/// at by [`BoxColor::SahShare`] alone.
pub fn select(
    tree: &Tree,
    shares: &[f32],
    projector: &Projector,
    settings: &OverlaySettings,
    task: &Task,
) -> Result<Selection, Cancelled> {
    let Some([a, b]) = settings.depths else { return Ok(Selection::default()) };
    let depths = [a.min(b), a.max(b)];
    let mut selection = each_width!(tree, t => {
        let walk = Walk { tree: t, shares, depths, projector, settings };
        walk.run(task)?
    });
    keep_largest(&mut selection, settings.budget as usize);
    // Farthest first, so that what is nearer is drawn over it. Of a box and a box inside it that touches the same side
    // the inner one goes first: the outline of the larger stays whole.
    selection.boxes.par_sort_unstable_by(|a, b| {
        b.distance2.total_cmp(&a.distance2).then(b.depth.cmp(&a.depth)).then(a.node.cmp(&b.node))
    });
    selection.color_range = color_range(tree, depths, settings.color, &selection.boxes);
    Ok(selection)
}

/// Drops all but the `budget` boxes that are largest on screen.
fn keep_largest(selection: &mut Selection, budget: usize) {
    let boxes = &mut selection.boxes;
    if boxes.len() > budget {
        selection.over_budget = boxes.len() - budget;
        if budget > 0 {
            boxes.select_nth_unstable_by(budget - 1, |a, b| {
                b.size.total_cmp(&a.size).then(a.depth.cmp(&b.depth)).then(a.node.cmp(&b.node))
            });
        }
        boxes.truncate(budget);
    }
}

fn color_range(tree: &Tree, depths: [u32; 2], color: BoxColor, boxes: &[ShownBox]) -> Option<[f32; 2]> {
    let largest = boxes.iter().map(|b| b.value).filter(|v| !v.is_nan()).reduce(f32::max)?;
    Some(match color {
        BoxColor::Depth => [depths[0] as f32, largest.max(depths[0] as f32)],
        BoxColor::LeafSize => {
            let most = tree.leaves().iter().map(|leaf| leaf.count).max().unwrap_or(1);
            [1.0, most as f32]
        }
        BoxColor::SahShare => [largest * SHARE_SPAN, largest],
    })
}

/// A node that the walk has come to.
#[derive(Clone, Copy)]
struct Reached {
    child: ChildRef,
    bounds: Aabb,
    fate: Fate,
}

/// What is already known of a box, since it lies inside its parent's.
#[derive(Clone, Copy, PartialEq)]
enum Fate {
    Open,
    Outside,
    TooSmall,
}

/// What a step of the walk found.
#[derive(Default)]
struct Found {
    boxes: Vec<ShownBox>,
    next: Vec<Reached>,
    selected: usize,
    outside: usize,
    too_small: usize,
}

struct Walk<'a, const N: usize> {
    tree: &'a WideBvh<N>,
    shares: &'a [f32],
    depths: [u32; 2],
    projector: &'a Projector,
    settings: &'a OverlaySettings,
}

impl<const N: usize> Walk<'_, N> {
    fn run(&self, task: &Task) -> Result<Selection, Cancelled> {
        let mut selection = Selection::default();
        let mut level = Vec::new();
        if !self.tree.root.is_empty() {
            level.push(Reached { child: self.tree.root, bounds: self.tree.bounds, fate: Fate::Open });
        }
        let mut depth = 0;
        while !level.is_empty() && depth <= self.depths[1] {
            let steps: Vec<Found> = level
                .par_chunks(CHUNK)
                .map(|nodes| task.check().map(|()| self.step(nodes, depth)))
                .collect::<Result<_, _>>()?;
            level.clear();
            for mut found in steps {
                selection.boxes.append(&mut found.boxes);
                level.append(&mut found.next);
                selection.selected += found.selected;
                selection.outside += found.outside;
                selection.too_small += found.too_small;
            }
            depth += 1;
        }
        Ok(selection)
    }

    /// Looks at some nodes of one level.
    fn step(&self, nodes: &[Reached], depth: u32) -> Found {
        let mut found = Found::default();
        for &node in nodes {
            let shown =
                depth >= self.depths[0] && (!self.settings.leaves_only || node.child.as_leaf().is_some());
            let fate = self.look_at(node, depth, shown, &mut found);
            if depth < self.depths[1]
                && let Some(node_idx) = node.child.as_inner()
            {
                self.descend(node_idx, fate, &mut found);
            }
        }
        found
    }

    /// Counts the node and keeps its box if it is to be drawn; says what that means for the boxes inside it.
    fn look_at(&self, node: Reached, depth: u32, shown: bool, found: &mut Found) -> Fate {
        let footprint = match node.fate {
            Fate::Open => self.projector.footprint(&node.bounds),
            Fate::Outside => Footprint::Outside,
            Fate::TooSmall => Footprint::TooSmall,
        };
        found.selected += usize::from(shown);
        match footprint {
            Footprint::Outside => {
                found.outside += usize::from(shown);
                Fate::Outside
            }
            Footprint::TooSmall => {
                found.too_small += usize::from(shown);
                Fate::TooSmall
            }
            Footprint::Seen { rect, size, clipped } => {
                if shown {
                    let Reached { child, bounds, .. } = node;
                    let eye = self.projector.frame.eye;
                    found.boxes.push(ShownBox {
                        bounds,
                        rect,
                        clipped,
                        depth,
                        size,
                        value: self.value(child, depth),
                        distance2: eye.clamp(bounds.min, bounds.max).distance_squared(eye),
                        node: self.node_id(child),
                    });
                }
                Fate::Open
            }
        }
    }

    fn descend(&self, node_idx: u32, fate: Fate, found: &mut Found) {
        let node = &self.tree.nodes[node_idx as usize];
        for (slot, &child) in node.children.iter().enumerate().take_while(|(_, c)| !c.is_empty()) {
            let bounds = Aabb::new(
                Vec3::from_array(node.child_min.map(|axis| axis[slot])),
                Vec3::from_array(node.child_max.map(|axis| axis[slot])),
            );
            found.next.push(Reached { child, bounds, fate });
        }
    }

    fn value(&self, child: ChildRef, depth: u32) -> f32 {
        match self.settings.color {
            BoxColor::Depth => depth as f32,
            BoxColor::LeafSize => {
                child.as_leaf().map_or(f32::NAN, |leaf_idx| self.tree.leaves[leaf_idx as usize].count as f32)
            }
            BoxColor::SahShare => {
                let share = self.shares.get(self.node_id(child) as usize).copied().unwrap_or(0.0);
                // A box without area has no place on a logarithmic scale.
                if share > 0.0 { share } else { f32::NAN }
            }
        }
    }

    /// The number of [`NodeId`](crate::accel::NodeId).
    fn node_id(&self, child: ChildRef) -> u32 {
        let first_leaf = self.tree.nodes.len() as u32;
        child.as_inner().or(child.as_leaf().map(|leaf_idx| first_leaf + leaf_idx)).unwrap_or(u32::MAX)
    }
}
