//! No order at all: how bad a tree can be, and how much the others are worth.

use rand::SeedableRng;
use rand::seq::SliceRandom;

use crate::accel::config::BuildConfig;

use super::bound::{BlockCount, Bound};
use super::midpoint::ordered;
use super::order::{BuildRef, Order, RefSlice};
use super::top_down::{Split, Splitter};

/// Splits a list of references at the middle of the list.
pub struct Random(BlockCount);

impl Random {
    /// Shuffles the references, always the same way.
    pub fn new(config: &BuildConfig, refs: &mut [BuildRef]) -> Self {
        refs.shuffle(&mut rand_pcg::Pcg64Mcg::seed_from_u64(0));
        Self(BlockCount::new(config.block))
    }
}

impl Splitter<RefSlice<'_>> for Random {
    const WEIGHS_COST: bool = true;
    type Plan = ();

    fn find(&self, order: &mut RefSlice<'_>, _bounds: &Bound) -> Option<Split<()>> {
        Some(ordered(order, order.len() / 2, self.0))
    }

    fn apply(&self, _order: &mut RefSlice<'_>, (): &()) {}
}
