//! Object median: the longest axis of the node's box, sorted by centroid, split at the middle.

use super::bound::Bound;
use super::order::Order;
use super::top_down::{Split, Splitter};

/// Finds no split of its own, so that every node is split at the object median. Always follows the stop rule `limit`:
/// its splits have no price to weigh.
pub struct Median;

impl<O: Order> Splitter<O> for Median {
    const WEIGHS_COST: bool = false;
    type Plan = ();

    fn find(&self, _order: &mut O, _bounds: &Bound) -> Option<Split<()>> {
        None
    }

    fn apply(&self, _order: &mut O, (): &()) {}
}
