//! Which boxes are drawn: level by level through the tree, in parallel, and the same ones at any thread count.

use rayon::prelude::*;

use super::hidden::FarthestSurfaces;
use super::project::{Footprint, PixelRect, Projector};
use super::{NodesShown, OverlaySettings};
use crate::accel::{ChildRef, Nodes, Tree};
use crate::each_width;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};
use crate::world::NodeFigure;

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
    /// Wholly behind surfaces, and not to be drawn there.
    pub hidden: usize,
    pub over_budget: usize,
    /// Values at the two ends of the colour ramp. They do not depend on the camera.
    pub color_range: Option<[f32; 2]>,
}

/// Where boxes are drawn.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    pub projector: &'a Projector,
    /// What hides boxes; `None` if they are drawn all the same.
    pub surfaces: Option<&'a FarthestSurfaces>,
}

/// Whether anything but hidden shapes (ascending) lies below each node, by [`NodeId`](crate::accel::NodeId).
pub fn with_shapes_beside(tree: &Tree, hidden: &[u32]) -> Vec<bool> {
    let mut shown = vec![false; tree.node_count()];
    for leaf_idx in 0..tree.leaf_count() as u32 {
        let shapes = tree.leaf_shapes(leaf_idx);
        shown[tree.inner_count() + leaf_idx as usize] =
            shapes.iter().any(|shape| hidden.binary_search(shape).is_err());
    }
    // Parents come before their children.
    for node_idx in (0..tree.inner_count() as u32).rev() {
        shown[node_idx as usize] =
            each_width!(tree, t => t.children(node_idx).any(|(child, _)| shown[child.0 as usize]));
    }
    shown
}

/// Picks the boxes that `settings` ask for. The values of `nodes`: each node's figure that is the colour, in order of
/// [`NodeId`](crate::accel::NodeId); not looked at for [`NodeFigure::Depth`].
pub fn select(
    tree: &Tree,
    nodes: NodesShown,
    stage: Stage,
    settings: &OverlaySettings,
    task: &Task,
) -> Result<Selection, Cancelled> {
    let NodesShown { values, shown } = nodes;
    let Some([a, b]) = settings.depths else { return Ok(Selection::default()) };
    let depths = [a.min(b), a.max(b)];
    let mut selection =
        each_width!(tree, t => Walk { tree: t, values, shown, depths, stage, settings }.run(task)?);
    // Farthest first, so that what is nearer is drawn over it. Of a box and a box inside it that touches the same side
    // the inner one goes first: the outline of the larger stays whole.
    selection.boxes.par_sort_unstable_by(|a, b| {
        b.distance2.total_cmp(&a.distance2).then(b.depth.cmp(&a.depth)).then(a.node.cmp(&b.node))
    });
    Ok(selection)
}

impl Selection {
    /// Drops all but the `budget` boxes that are largest on screen; of equally large ones the higher in the tree stays.
    /// Returns the size of the smallest kept one if some were dropped: no smaller box has a place.
    fn keep_largest(&mut self, budget: usize) -> Option<f32> {
        if self.boxes.len() <= budget {
            return None;
        }
        self.over_budget += self.boxes.len() - budget;
        let mut smallest = f32::INFINITY;
        if budget > 0 {
            let (_, last, _) = self.boxes.select_nth_unstable_by(budget - 1, |a, b| {
                b.size.total_cmp(&a.size).then(a.depth.cmp(&b.depth)).then(a.node.cmp(&b.node))
            });
            smallest = last.size;
        }
        self.boxes.truncate(budget);
        Some(smallest)
    }
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
    Hidden,
    OverBudget,
}

/// What a step of the walk found.
#[derive(Default)]
struct Found {
    boxes: Vec<ShownBox>,
    next: Vec<Reached>,
    selected: usize,
    outside: usize,
    too_small: usize,
    hidden: usize,
    over_budget: usize,
    /// Of all selected boxes, drawn or not; 0 for none.
    value_max: f32,
}

struct Walk<'a, T> {
    tree: &'a T,
    values: &'a [f32],
    shown: Option<&'a [bool]>,
    depths: [u32; 2],
    stage: Stage<'a>,
    settings: &'a OverlaySettings,
}

impl<T: Nodes> Walk<'_, T> {
    fn run(&self, task: &Task) -> Result<Selection, Cancelled> {
        let mut selection = Selection::default();
        let mut level = Vec::new();
        if !self.tree.root().is_empty() && self.is_shown(self.tree.root()) {
            level.push(Reached { child: self.tree.root(), bounds: self.tree.bounds(), fate: Fate::Open });
        }
        let budget = self.settings.budget as usize;
        let (mut depth, mut smallest, mut value_max) = (0, 0.0, 0.0_f32);
        while !level.is_empty() && depth <= self.depths[1] {
            let steps: Vec<Found> = level
                .par_chunks(CHUNK)
                .map(|nodes| task.check().map(|()| self.step(nodes, depth, smallest)))
                .collect::<Result<_, _>>()?;
            level.clear();
            for mut found in steps {
                selection.boxes.append(&mut found.boxes);
                level.append(&mut found.next);
                selection.selected += found.selected;
                selection.outside += found.outside;
                selection.too_small += found.too_small;
                selection.hidden += found.hidden;
                selection.over_budget += found.over_budget;
                value_max = value_max.max(found.value_max);
            }
            smallest = selection.keep_largest(budget).unwrap_or(smallest);
            depth += 1;
        }
        if selection.selected > 0 {
            selection.color_range = self.color_range(value_max);
        }
        Ok(selection)
    }

    /// Looks at some nodes of one level. Boxes below `smallest` on screen have no place in the budget any more.
    fn step(&self, nodes: &[Reached], depth: u32, smallest: f32) -> Found {
        let mut found = Found::default();
        for &node in nodes {
            let shown =
                depth >= self.depths[0] && (!self.settings.leaves_only || node.child.as_leaf().is_some());
            let fate = self.look_at(node, depth, smallest, shown, &mut found);
            if shown {
                found.count(fate);
            }
            if depth < self.depths[1]
                && let Some(node_idx) = node.child.as_inner()
            {
                self.descend(node_idx, fate, &mut found);
            }
        }
        found
    }

    /// Keeps the node's box if it is to be drawn; says what is so known of it and of the boxes inside it.
    fn look_at(&self, node: Reached, depth: u32, smallest: f32, shown: bool, found: &mut Found) -> Fate {
        let value = if shown { self.value(node.child, depth) } else { f32::NAN };
        found.value_max = found.value_max.max(value);
        if node.fate != Fate::Open {
            return node.fate;
        }
        let (rect, size, near_depth, clipped) = match self.stage.projector.footprint(&node.bounds) {
            Footprint::Outside => return Fate::Outside,
            Footprint::TooSmall => return Fate::TooSmall,
            Footprint::Seen { rect, size, depth, clipped } => (rect, size, depth, clipped),
        };
        if self.stage.surfaces.is_some_and(|surfaces| surfaces.hide(&rect, near_depth)) {
            return Fate::Hidden;
        }
        if size < smallest {
            return Fate::OverBudget;
        }
        if shown {
            let Reached { child, bounds, .. } = node;
            let eye = self.stage.projector.frame.eye;
            let distance2 = eye.max(bounds.min).min(bounds.max).distance_squared(eye);
            let node = self.node_id(child);
            found.boxes.push(ShownBox { bounds, rect, clipped, depth, size, value, distance2, node });
        }
        Fate::Open
    }

    fn descend(&self, node_idx: u32, fate: Fate, found: &mut Found) {
        let slots = (0..T::WIDTH).map(|slot| self.tree.slot(node_idx, slot));
        for (child, bounds) in slots.take_while(|(child, _)| !child.is_empty()) {
            if self.is_shown(child) {
                found.next.push(Reached { child, bounds, fate });
            }
        }
    }

    fn is_shown(&self, child: ChildRef) -> bool {
        self.shown.is_none_or(|shown| shown[self.node_id(child) as usize])
    }

    fn value(&self, child: ChildRef, depth: u32) -> f32 {
        let color = self.settings.color;
        if color == NodeFigure::Depth {
            return depth as f32;
        }
        let value = self.values.get(self.node_id(child) as usize).copied().unwrap_or(f32::NAN);
        // Zero has no place on a logarithmic scale.
        if color.spans_decades() && value <= 0.0 { f32::NAN } else { value }
    }

    /// The number of [`NodeId`](crate::accel::NodeId).
    fn node_id(&self, child: ChildRef) -> u32 {
        let first_leaf = self.tree.inner_count() as u32;
        child.as_inner().or(child.as_leaf().map(|leaf_idx| first_leaf + leaf_idx)).unwrap_or(u32::MAX)
    }

    fn color_range(&self, value_max: f32) -> Option<[f32; 2]> {
        // Of the whole tree, so that a colour keeps its meaning when the range of depths moves.
        match self.settings.color {
            NodeFigure::Depth => {
                (value_max >= self.depths[0] as f32).then_some([self.depths[0] as f32, value_max])
            }
            color @ (NodeFigure::SahShare | NodeFigure::Epo) => color.range_up_to(value_max),
            color => color.range(self.values),
        }
    }
}

impl Found {
    fn count(&mut self, fate: Fate) {
        self.selected += 1;
        match fate {
            Fate::Open => {}
            Fate::Outside => self.outside += 1,
            Fate::TooSmall => self.too_small += 1,
            Fate::Hidden => self.hidden += 1,
            Fate::OverBudget => self.over_budget += 1,
        }
    }
}
