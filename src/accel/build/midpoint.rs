//! Spatial middle: the first splitting rule that textbooks teach.

use crate::accel::config::BuildConfig;
use crate::geometry::Aabb;

use super::bound::{BlockCount, Bound};
use super::order::{BuildRef, Order, RefSlice};
use super::top_down::{Split, Splitter};

/// Splits halfway between the outermost centroids, along the axis on which they lie farthest apart (Pharr, Jakob,
/// Humphreys, "Physically Based Rendering", 4th edition, 7.3.1).
pub struct Midpoint(BlockCount);

impl Midpoint {
    pub fn new(config: &BuildConfig) -> Self {
        Self(BlockCount::new(config.block))
    }
}

impl Splitter<RefSlice<'_>> for Midpoint {
    const WEIGHS_COST: bool = true;
    type Plan = ();

    fn find(&self, order: &mut RefSlice<'_>, _bounds: &Bound) -> Option<Split<()>> {
        let centers = Aabb::from_points(order.refs.iter().map(|r| r.bound.aabb().center()));
        let axis = centers.longest_axis();
        let middle = centers.center()[axis];
        let left_count = partition(order.refs, |r| r.bound.aabb().center()[axis] < middle);
        let separates = left_count > 0 && left_count < order.len();
        separates.then(|| ordered(order, left_count, self.0))
    }

    fn apply(&self, _order: &mut RefSlice<'_>, (): &()) {}
}

/// Brings those to the front that belong there, and counts them.
fn partition(refs: &mut [BuildRef], is_left: impl Fn(&BuildRef) -> bool) -> usize {
    let mut left_count = 0;
    for i in 0..refs.len() {
        if is_left(&refs[i]) {
            refs.swap(i, left_count);
            left_count += 1;
        }
    }
    left_count
}

/// The split, with its cost, of references that are in order already.
pub(super) fn ordered(order: &RefSlice<'_>, left_count: usize, blocks: BlockCount) -> Split<()> {
    let count = order.len();
    let (left, right) = (order.bounds(0..left_count), order.bounds(left_count..count));
    let weight = |bound: &Bound, count: usize| blocks.of(count as f32) * bound.half_area();
    let cost = weight(&left, left_count) + weight(&right, count - left_count);
    Split { cost, left_count, left, right, plan: None }
}
