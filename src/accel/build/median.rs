//! Object median: the longest axis of the node's box, sorted by centroid, split at the middle.

use crate::geometry::Aabb;

use super::order::Order;
use super::top_down::{Candidate, Splitter};

/// Always follows the stop rule `limit`: its splits have no price to weigh.
pub struct Median;

impl<O: Order> Splitter<O> for Median {
    const WEIGHS_COST: bool = false;

    fn find(&self, _order: &mut O, bounds: &Aabb) -> Option<Candidate> {
        Some(Candidate { axis: bounds.longest_axis(), position: 0, cost: 0.0, scale: 0.0, origin: 0.0 })
    }

    fn apply(&self, order: &mut O, split: &Candidate) -> usize {
        order.split_middle(split.axis)
    }
}
