//! Spatial splits: a plane may also cut references in two, so that the boxes on both sides do not overlap.
//!
//! Stich, Friedrich, Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009. Of every node the best object
//! split is found by the binned search. Where its two boxes overlap, planes between bins over the node's box are tried
//! as well; a reference that reaches across one is cut, its parts bounded tightly, unless keeping it whole on one side is
//! cheaper (the paper's reference unsplitting).

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::{BuildConfig, StopRule};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::Shapes;
use super::binned::Binned;
use super::bound::{BlockCount, Bound};
use super::order::{BuildRef, Order, RefSlice};
use super::top_down::{CHECK_MIN, Splitter, fits_depth, pays};

/// Planes that are tried along an axis, at most: each reference is clipped between all that it reaches across.
const MOST_PLANES: usize = 32;
/// Below this many references the two sides of a node are not shared among threads.
const FORK_MIN: usize = 1024;

/// What stays the same over a build.
struct Context<'a, B: ?Sized> {
    shapes: &'a B,
    binned: Binned<'a>,
    config: &'a BuildConfig,
    task: &'a Task,
    blocks: BlockCount,
    /// Half area of an overlap from which on spatial splits are tried.
    overlap_min: f32,
}

/// A subtree, before its nodes are put side by side.
enum Grown {
    Leaf { bounds: Aabb, shapes: Vec<u32> },
    Inner { bounds: Aabb, children: Box<[Grown; 2]> },
}

/// A node's references, on the way down.
struct Member {
    /// Of the references, also once they were handed on.
    count: usize,
    refs: Vec<BuildRef>,
    bounds: Bound,
    depth: usize,
    /// References that cuts may still add below.
    budget: usize,
    /// Of the shapes, what is reported as progress once all below is built.
    progress: u64,
}

/// A plane that cuts what reaches across it.
#[derive(Clone, Copy, Debug)]
struct Cut {
    cost: f32,
    axis: usize,
    at: f32,
    left: Bound,
    right: Bound,
    left_count: usize,
    right_count: usize,
}

/// What lies in a bin along an axis.
#[derive(Clone, Copy)]
struct Slot {
    bounds: Bound,
    /// References that begin, and that end, in it.
    begins: usize,
    ends: usize,
}

/// Builds the binary tree. It is the same at any thread count.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn build<B: Shapes + ?Sized>(
    refs: Vec<BuildRef>,
    shapes: &B,
    config: &BuildConfig,
    task: &Task,
) -> Result<Bvh2, Cancelled> {
    let mut bvh = Bvh2::default();
    if refs.is_empty() {
        return Ok(bvh);
    }
    let bounds = refs.iter().fold(Bound::EMPTY, |all, r| all.union(r.bound));
    let context = Context {
        shapes,
        binned: Binned::new(config, task),
        config,
        task,
        blocks: BlockCount::new(config.block),
        overlap_min: bounds.half_area() * config.split_alpha,
    };
    let budget = (shapes.count() as f64 * f64::from(config.split_budget)) as usize;
    let progress = refs.len() as u64;
    let root = context.grow(Member { count: refs.len(), refs, bounds, depth: 0, budget, progress })?;
    bvh.nodes.push(Bvh2Node { bounds: Aabb::EMPTY, first: 0, count: 0 });
    let mut open = vec![(root, 0)];
    while let Some((grown, node_idx)) = open.pop() {
        bvh.nodes[node_idx] = match grown {
            Grown::Leaf { bounds, mut shapes } => {
                shapes.sort_unstable();
                let (first, count) = (bvh.refs.len() as u32, shapes.len() as u32);
                bvh.refs.append(&mut shapes);
                Bvh2Node { bounds, first, count }
            }
            Grown::Inner { bounds, children } => {
                let first = bvh.nodes.len();
                bvh.nodes.extend([Bvh2Node { bounds: Aabb::EMPTY, first: 0, count: 0 }; 2]);
                let [left, right] = *children;
                open.extend([(right, first + 1), (left, first)]);
                Bvh2Node { bounds, first: first as u32, count: 0 }
            }
        };
    }
    Ok(bvh)
}

impl<B: Shapes + ?Sized> Context<'_, B> {
    fn grow(&self, mut node: Member) -> Result<Grown, Cancelled> {
        let (count, bounds) = (node.count, node.bounds.aabb());
        if count >= CHECK_MIN {
            self.task.check()?;
        } else if node.progress > 0 {
            self.task.advance(std::mem::take(&mut node.progress));
        }
        let Some([left, right]) = self.split(&mut node) else {
            self.task.advance(node.progress);
            let shapes = node.refs.iter().map(BuildRef::shape).collect();
            return Ok(Grown::Leaf { bounds, shapes });
        };
        let (left, right) = if count >= FORK_MIN {
            rayon::join(|| self.grow(left), || self.grow(right))
        } else {
            (self.grow(left), self.grow(right))
        };
        Ok(Grown::Inner { bounds, children: Box::new([left?, right?]) })
    }

    /// Both sides of the cheaper split; `None` for a leaf.
    fn split(&self, node: &mut Member) -> Option<[Member; 2]> {
        let (config, count) = (self.config, node.count);
        let fits_leaf = count <= config.leaf;
        if count == 1 || (fits_leaf && config.stop == StopRule::Limit) {
            return None;
        }
        let object = self.binned.find(&mut RefSlice::new(&mut node.refs), &node.bounds);
        let overlap = object
            .as_ref()
            .map_or(f32::INFINITY, |split| split.left.aabb().intersection(split.right.aabb()).half_area());
        let object_cost = object.as_ref().map_or(f32::INFINITY, |split| split.cost);
        let cut = (node.budget > 0 && overlap > self.overlap_min).then(|| self.cheapest_cut(node)).flatten();
        let cut = cut.filter(|cut| {
            cut.cost < object_cost
                && cut.left_count + cut.right_count <= count + node.budget
                && fits_depth(config, cut.left_count.max(cut.right_count), node.depth + 1)
        });
        let cost = cut.map_or(object_cost, |cut| cut.cost);
        if fits_leaf && !pays(config, count, &node.bounds, cost) {
            return None;
        }
        if let Some(sides) = cut.and_then(|cut| self.cut(node, &cut)) {
            return Some(sides);
        }
        let fits = |left_count: usize| {
            left_count > 0
                && left_count < count
                && fits_depth(config, left_count.max(count - left_count), node.depth + 1)
        };
        let mut order = RefSlice::new(&mut node.refs);
        let middle = match object {
            Some(split) if fits(split.left_count) => {
                if let Some(plan) = &split.plan {
                    self.binned.apply(&mut order, plan);
                }
                split.left_count
            }
            _ => order.split_middle(node.bounds.aabb().longest_axis()),
        };
        let right = node.refs.split_off(middle);
        let left = std::mem::take(&mut node.refs);
        Some(sides(node, left, right))
    }

    /// The plane with the least split cost among those between bins over the node's box.
    fn cheapest_cut(&self, node: &Member) -> Option<Cut> {
        let bounds = node.bounds.aabb();
        // Few references have few places where a cut can pay.
        let bins = self.config.bins.min(MOST_PLANES).min((2 * node.count).max(4));
        let mut cheapest: Option<Cut> = None;
        for axis in 0..3 {
            let (low, extent) = (bounds.min[axis], bounds.max[axis] - bounds.min[axis]);
            let scale = bins as f32 / extent;
            if !(extent > 0.0 && scale > 0.0 && scale < f32::INFINITY) {
                continue;
            }
            let plane =
                |i: usize| if i == bins { bounds.max[axis] } else { low + extent * (i as f32 / bins as f32) };
            let bin = |at: f32| (((at - low) * scale) as usize).min(bins - 1);
            let mut slots = [Slot { bounds: Bound::EMPTY, begins: 0, ends: 0 }; MOST_PLANES];
            for r in &node.refs {
                let whole = r.bound.aabb();
                let (first, last) = (bin(whole.min[axis]), bin(whole.max[axis]));
                let mut met = None;
                for (i, slot) in (first..=last).zip(&mut slots[first..]) {
                    let part = if first == last {
                        whole
                    } else {
                        self.part(r, &whole, axis, plane(i), plane(i + 1))
                    };
                    if !part.is_empty() {
                        slot.bounds = slot.bounds.union(Bound::from(part));
                        met = Some((met.map_or(i, |(begin, _)| begin), i));
                    }
                }
                let (begin, end) = met.unwrap_or((first, first));
                slots[begin].begins += 1;
                slots[end].ends += 1;
            }
            let mut right_of = [(Bound::EMPTY, 0); MOST_PLANES];
            let mut right = (Bound::EMPTY, 0);
            for i in (1..bins).rev() {
                right = (right.0.union(slots[i].bounds), right.1 + slots[i].ends);
                right_of[i] = right;
            }
            let mut left = (Bound::EMPTY, 0);
            for i in 1..bins {
                left = (left.0.union(slots[i - 1].bounds), left.1 + slots[i - 1].begins);
                let right = right_of[i];
                if left.1 == 0 || right.1 == 0 {
                    continue;
                }
                let cost = self.blocks.of(left.1 as f32) * left.0.half_area()
                    + self.blocks.of(right.1 as f32) * right.0.half_area();
                if cheapest.is_none_or(|c| cost < c.cost) {
                    let ((left, left_count), (right, right_count)) = (left, right);
                    cheapest = Some(Cut { cost, axis, at: plane(i), left, right, left_count, right_count });
                }
            }
        }
        cheapest
    }

    /// The box of the part of a reference between two planes: what was cut off before stays off.
    #[inline]
    fn part(&self, r: &BuildRef, whole: &Aabb, axis: usize, from: f32, to: f32) -> Aabb {
        let mut clip = *whole;
        clip.min[axis] = clip.min[axis].max(from);
        clip.max[axis] = clip.max[axis].min(to);
        self.shapes.bounds_between(r.shape(), axis, from, to).intersection(clip)
    }

    /// Cuts the references; `None` if nothing would be won in number.
    fn cut(&self, node: &Member, cut: &Cut) -> Option<[Member; 2]> {
        let (axis, at) = (cut.axis, cut.at);
        let (mut left_box, mut right_box) = (cut.left, cut.right);
        let (mut left_count, mut right_count) = (cut.left_count as f32, cut.right_count as f32);
        let (mut left, mut right) = (Vec::with_capacity(cut.left_count), Vec::with_capacity(cut.right_count));
        for r in &node.refs {
            let whole = r.bound.aabb();
            if whole.max[axis] <= at {
                left.push(*r);
                continue;
            }
            if whole.min[axis] >= at {
                right.push(*r);
                continue;
            }
            let part_left = self.part(r, &whole, axis, f32::NEG_INFINITY, at);
            let part_right = self.part(r, &whole, axis, at, f32::INFINITY);
            match (part_left.is_empty(), part_right.is_empty()) {
                (_, true) => left.push(*r),
                (true, false) => right.push(*r),
                (false, false) => {
                    // Unsplitting: whole on the left, whole on the right, or cut.
                    let (grown_left, grown_right) = (left_box.union(r.bound), right_box.union(r.bound));
                    let (area_left, area_right) = (left_box.half_area(), right_box.half_area());
                    let (on_left, on_right) = (self.blocks.of(left_count), self.blocks.of(right_count));
                    let cut_cost = area_left * on_left + area_right * on_right;
                    let fewer_right = self.blocks.of(right_count - 1.0);
                    let cost_left = grown_left.half_area() * on_left + area_right * fewer_right;
                    let fewer_left = self.blocks.of(left_count - 1.0);
                    let cost_right = area_left * fewer_left + grown_right.half_area() * on_right;
                    if cost_left < cut_cost && cost_left <= cost_right {
                        left_box = grown_left;
                        right_count -= 1.0;
                        left.push(*r);
                    } else if cost_right < cut_cost {
                        right_box = grown_right;
                        left_count -= 1.0;
                        right.push(*r);
                    } else {
                        left.push(BuildRef::new(&part_left, r.shape()));
                        right.push(BuildRef::new(&part_right, r.shape()));
                    }
                }
            }
        }
        let count = node.count;
        let added = (left.len() + right.len()).checked_sub(count)?;
        let halves = !left.is_empty() && !right.is_empty() && left.len() < count && right.len() < count;
        let fits = fits_depth(self.config, left.len().max(right.len()), node.depth + 1);
        (halves && fits && added <= node.budget).then(|| sides(node, left, right))
    }
}

/// What a node becomes: two members, each with its share of what is left of the budget, and of the progress.
fn sides(node: &Member, left: Vec<BuildRef>, right: Vec<BuildRef>) -> [Member; 2] {
    let total = left.len() + right.len();
    let budget = node.budget.saturating_sub(total.saturating_sub(node.count));
    let part = |whole: usize| (whole as f64 * left.len() as f64 / total as f64) as usize;
    let (budget_left, progress_left) = (part(budget), part(node.progress as usize) as u64);
    [(left, budget_left, progress_left), (right, budget - budget_left, node.progress - progress_left)].map(
        |(refs, budget, progress)| {
            let bounds = refs.iter().fold(Bound::EMPTY, |all, r| all.union(r.bound));
            Member { count: refs.len(), refs, bounds, depth: node.depth + 1, budget, progress }
        },
    )
}
