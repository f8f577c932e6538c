//! Pre-splitting: large shapes are cut before any builder sees them, so that every builder can put their parts apart
//! (Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", 2013, the section on triangle
//! splitting).
//!
//! A shape's priority is the cube root of what cutting can take off its box, times the importance of the most important
//! plane that the box crosses: of the planes that halve the scene's box, its halves and so on, those of the first level
//! count 1, and of each level below half as much. So many cuts as the budget allows are shared out by priority; then each
//! shape is cut at its most important plane, and what cuts it has left are shared between the two parts by the lengths of
//! their boxes.

use rayon::prelude::*;

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::Shapes;
use super::bound::Bound;
use super::order::{BuildRef, PARALLEL_MIN};

/// Levels of planes an axis.
const LEVELS: u32 = 20;

/// Halvings of the interval in which the scale of the priorities is searched.
const ROUNDS: usize = 12;

/// References whose shapes are cut by one thread at a time.
const PIECE: usize = 1024;

/// The planes that halve the cube around all shapes, its halves, and so on.
struct Planes {
    min: [f64; 3],
    /// Cells of the last level.
    cells_per_unit: f64,
}

/// A plane across `axis`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plane {
    /// 0 for the one through the middle of everything.
    level: u32,
    axis: usize,
    at: f32,
}

/// Cuts shapes in parts: at most `share` times as many more references as there are. They are the same at any thread count,
/// and the parts of a shape follow each other.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn presplit<B: Shapes + ?Sized>(
    refs: Vec<BuildRef>,
    shapes: &B,
    share: f32,
    task: &Task,
) -> Result<Vec<BuildRef>, Cancelled> {
    let budget = (refs.len() as f64 * f64::from(share)) as u64;
    let around = |refs: &[BuildRef]| refs.iter().fold(Bound::EMPTY, |all, r| all.union(r.bound));
    let bounds = refs.par_chunks(PARALLEL_MIN).map(around).reduce(|| Bound::EMPTY, Bound::union);
    let Some(planes) = Planes::new(&bounds.aabb()) else { return Ok(refs) };
    let priority = |r: &BuildRef| priority(&planes, shapes, r);
    let priorities: Vec<f32> = refs.par_iter().with_min_len(PIECE).map(priority).collect();
    task.check()?;
    let Some(scale) = scale(&priorities, budget) else { return Ok(refs) };
    let pieces = refs.par_chunks(PIECE).zip(priorities.par_chunks(PIECE)).map(|(refs, priorities)| {
        task.check()?;
        let mut parts = Vec::with_capacity(2 * refs.len());
        for (r, &priority) in refs.iter().zip(priorities) {
            match cuts(priority, scale) {
                0 => parts.push(*r),
                cuts => cut(&planes, shapes, (r.shape(), r.bound.aabb()), cuts, &mut parts),
            }
        }
        Ok(parts)
    });
    Ok(pieces.collect::<Result<Vec<_>, Cancelled>>()?.concat())
}

/// What cutting the shape is worth; 0 for nothing.
fn priority<B: Shapes + ?Sized>(planes: &Planes, shapes: &B, r: &BuildRef) -> f32 {
    let bounds = r.bound.aabb();
    let Some(plane) = planes.most_important(&bounds) else { return 0.0 };
    let saved = f64::from(bounds.area()) - f64::from(shapes.area_in_parts(r.shape()));
    let priority = (saved * 0.5_f64.powi(plane.level as i32)).cbrt() as f32;
    if priority > 0.0 && priority < f32::INFINITY { priority } else { 0.0 }
}

#[inline]
fn cuts(priority: f32, scale: f64) -> u64 {
    (f64::from(priority) * scale) as u64
}

/// By what priorities are multiplied, so that rounded down they add up to the budget or just below; `None` if nothing is
/// to be cut.
fn scale(priorities: &[f32], budget: u64) -> Option<f64> {
    // In pieces of one size, so that the sum is the same at any thread count.
    let sums = priorities.par_chunks(PIECE).map(|piece| piece.iter().map(|&p| f64::from(p)).sum::<f64>());
    let sum: f64 = sums.collect::<Vec<_>>().iter().sum();
    if sum <= 0.0 || budget == 0 {
        return None;
    }
    let worthy = priorities.par_iter().with_min_len(PARALLEL_MIN).filter(|&&p| p > 0.0).count();
    let total = |scale: f64| -> u64 {
        priorities.par_iter().with_min_len(PARALLEL_MIN).map(|&priority| cuts(priority, scale)).sum()
    };
    // Rounding takes less than one from each: the answer lies between the two.
    let (mut low, mut high) = (budget as f64 / sum, (budget + worthy as u64) as f64 / sum);
    for _ in 0..ROUNDS {
        let middle = 0.5 * (low + high);
        if total(middle) <= budget {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Rounding of the sum may have put even the lower end too high.
    Some(if total(low) <= budget { low } else { low * (1.0 - 1e-9) })
}

/// Adds a shape's part in at most so many more parts.
fn cut<B: Shapes + ?Sized>(
    planes: &Planes,
    shapes: &B,
    (shape, part): (u32, Aabb),
    cuts: u64,
    parts: &mut Vec<BuildRef>,
) {
    let plane = if cuts > 0 { planes.most_important(&part) } else { None };
    let Some(Plane { axis, at, .. }) = plane else {
        parts.push(BuildRef::new(&part, shape));
        return;
    };
    let (mut below, mut above) = (part, part);
    (below.max[axis], above.min[axis]) = (at, at);
    let [left, right] = [below, above].map(|clip| shapes.bounds_inside(shape, &clip));
    match (left.is_empty(), right.is_empty()) {
        (true, true) => parts.push(BuildRef::new(&part, shape)),
        // Only the box reached across; its plane is now a side.
        (false, true) => cut(planes, shapes, (shape, left), cuts, parts),
        (true, false) => cut(planes, shapes, (shape, right), cuts, parts),
        (false, false) => {
            let [a, b] = [left, right].map(|part| f64::from(part.extent().max_element()));
            let share = if a + b > 0.0 { a / (a + b) } else { 0.5 };
            let of_left = ((cuts - 1) as f64 * share).round() as u64;
            cut(planes, shapes, (shape, left), of_left, parts);
            cut(planes, shapes, (shape, right), cuts - 1 - of_left, parts);
        }
    }
}

impl Planes {
    /// `None` where there is no extent.
    fn new(bounds: &Aabb) -> Option<Self> {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let side = (max - min).max_element();
        let cells_per_unit = f64::from(1_u32 << LEVELS) / side;
        (side > 0.0 && cells_per_unit < f64::INFINITY).then(|| Self { min: min.to_array(), cells_per_unit })
    }

    /// Of the planes strictly inside a box that of the highest level; of several that across its longest side.
    fn most_important(&self, part: &Aabb) -> Option<Plane> {
        let extent = part.extent();
        let mut best: Option<Plane> = None;
        for axis in 0..3 {
            let cell = |at: f32| (f64::from(at) - self.min[axis]) * self.cells_per_unit;
            // What ends on a plane does not cross it.
            let low = cell(part.min[axis]) as u32;
            let high = (cell(part.max[axis]).ceil() as u32).saturating_sub(1);
            let Some(bit) = (low ^ high).checked_ilog2().filter(|_| low < high) else { continue };
            let at = (self.min[axis] + f64::from(high >> bit << bit) / self.cells_per_unit) as f32;
            let plane = Plane { level: (LEVELS - 1).saturating_sub(bit), axis, at };
            let inside = part.min[axis] < at && at < part.max[axis];
            let better = best.is_none_or(|best| {
                plane.level < best.level || (plane.level == best.level && extent[axis] > extent[best.axis])
            });
            if inside && better {
                best = Some(plane);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn planes_halve_the_cube_its_halves_and_so_on() {
        let planes = Planes::new(&Aabb::new(Vec3::splat(-8.0), Vec3::splat(8.0))).expect("an extent");
        let over = |low: f32, high: f32| Aabb::new(Vec3::new(0.5, low, 0.5), Vec3::new(0.5, high, 0.5));
        let found = |low, high| planes.most_important(&over(low, high)).map(|plane| (plane.level, plane.at));
        assert_eq!(found(-1.0, 7.0), Some((0, 0.0)));
        assert_eq!(found(0.0, 7.0), Some((1, 4.0)));
        assert_eq!(found(-8.0, -4.5), Some((2, -6.0)));
        assert_eq!(found(0.0, 4.0), Some((2, 2.0)), "a side on a plane does not cross it");
        assert_eq!(found(0.51, 0.51), None);
        let both = Aabb::new(Vec3::new(-1.0, -2.0, 1.0), Vec3::new(1.0, 2.0, 1.5));
        assert_eq!(planes.most_important(&both).map(|plane| plane.axis), Some(1), "across the longer side");
        assert!(Planes::new(&Aabb::from_points([Vec3::ONE])).is_none());
    }

    #[test]
    fn cuts_add_up_to_the_budget_or_just_below() {
        let priorities: Vec<f32> = (0..3000).map(|i| ((i * 7919) % 1013) as f32 * 0.01).collect();
        for budget in [1, 2, 50, 3000, 12_345] {
            let scale = scale(&priorities, budget).expect("something to cut");
            let total: u64 = priorities.iter().map(|&p| cuts(p, scale)).sum();
            assert!(total <= budget && total + 40 >= budget, "{total} of {budget}");
        }
        assert_eq!(scale(&priorities, 0), None);
        assert_eq!(scale(&[0.0; 10], 5), None);
    }
}
