//! The values that a search tries, in lists, and the trees at their places.

use super::{Search, default_of};
use crate::accel::{BuildConfig, Builder, StopRule, Width};
use crate::inspect::bin_sweep::coarse_bins;
use crate::inspect::sweep::SweepGrid;

/// Leaf limits that are tried.
const LEAF: [usize; 17] = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 32, 48, 64];

/// C_t for C_i = 1 that are tried under the stop rule `cost`.
const RATIOS: [f32; 13] = [0.0625, 0.125, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0];

/// Values of what is searched, each list in order.
pub(super) struct Axes {
    base: BuildConfig,
    pub kinds: Vec<(Builder, Width)>,
    bins: Vec<usize>,
    leaf: Vec<usize>,
    /// `None`: the stop rule `limit`.
    ratios: Vec<Option<f32>>,
    names: SweepGrid,
}

/// A place in the lists: kind, bins, leaf limit, ratio.
pub(super) type Spot = [usize; 4];

impl Axes {
    pub fn new(search: &Search, base: &BuildConfig) -> Self {
        let kinds = search
            .builders
            .iter()
            .flat_map(|&builder| search.widths.iter().map(move |&width| (builder, width)))
            .collect();
        let with = |mut list: Vec<usize>, own| {
            list.push(own);
            list.sort_unstable();
            list.dedup();
            list
        };
        let bins = with(coarse_bins(), base.bins);
        let leaf = with(LEAF.to_vec(), base.leaf);
        let mut ratios = RATIOS.to_vec();
        ratios.push(base.traversal_cost / base.intersection_cost);
        ratios.sort_by(f32::total_cmp);
        ratios.dedup();
        let names = SweepGrid {
            builders: search.builders.clone(),
            widths: search.widths.clone(),
            stops: StopRule::ALL.to_vec(),
            bins: bins.clone(),
            leaf: leaf.clone(),
            traversal_costs: ratios.clone(),
            ..SweepGrid::around(base)
        };
        let ratios = std::iter::once(None).chain(ratios.into_iter().map(Some)).collect();
        Self { base: *base, kinds, bins, leaf, ratios, names }
    }

    pub fn name(&self, config: &BuildConfig) -> String {
        if *config == default_of(&self.base) { "default".to_owned() } else { self.names.name(config) }
    }

    pub fn config(&self, [kind, bins, leaf, ratio]: Spot) -> BuildConfig {
        let (builder, width) = self.kinds[kind];
        let config =
            BuildConfig { builder, width, bins: self.bins[bins], leaf: self.leaf[leaf], ..self.base };
        match self.ratios[ratio] {
            None => BuildConfig { stop: StopRule::Limit, ..config },
            Some(ratio) => {
                let most = BuildConfig::MAX_COST;
                let traversal_cost = (ratio * config.intersection_cost).min(most);
                BuildConfig { stop: StopRule::Cost, traversal_cost, ..config }
            }
        }
    }

    /// The place of these values, or of those next to them.
    pub fn spot(&self, kind: usize, bins: usize, leaf: usize, ratio: Option<f32>) -> Spot {
        let nearest = |list: &[usize], value: usize| {
            (0..list.len()).min_by_key(|&i| list[i].abs_diff(value)).expect("lists are not empty")
        };
        let distance = |r: &Option<f32>| match (r, ratio) {
            (None, None) => 0.0,
            (Some(a), Some(b)) => (a / b).log2().abs(),
            (None, Some(_)) | (Some(_), None) => f32::INFINITY,
        };
        let ratios = (0..self.ratios.len())
            .min_by(|&i, &j| distance(&self.ratios[i]).total_cmp(&distance(&self.ratios[j])))
            .expect("lists are not empty");
        [kind, nearest(&self.bins, bins), nearest(&self.leaf, leaf), ratios]
    }

    /// So many places along one list, if it goes on for so long.
    pub fn moved(&self, spot: Spot, axis: usize, by: isize) -> Option<Spot> {
        let length = [self.kinds.len(), self.bins.len(), self.leaf.len(), self.ratios.len()][axis];
        let to = spot[axis].checked_add_signed(by).filter(|&to| to < length)?;
        let mut moved = spot;
        moved[axis] = to;
        Some(moved)
    }
}
