//! The walk from place to place of a search: a few far apart, then steps to better ones.

use super::axes::{Axes, Spot};
use super::{Measure, Search};
use crate::accel::{BuildConfig, StopRule};
use crate::inspect::sweep::{SweepPoint, same_tree};
use crate::task::{Cancelled, Task};

/// Bins, leaf limit and C_t / C_i of the first points; without a ratio the stop rule is `limit`.
const FIRST: [(usize, usize, Option<f32>); 8] = [
    (16, 2, None),
    (32, 4, Some(1.0)),
    (16, 4, None),
    (64, 1, None),
    (16, 8, Some(2.0)),
    (8, 8, None),
    (32, 16, Some(1.0)),
    (128, 2, Some(0.5)),
];

/// A search on its way.
pub(super) struct Walk<'a, 'm> {
    pub search: &'a Search,
    pub axes: &'a Axes,
    pub default: BuildConfig,
    /// Every tree that was measured, in order.
    pub tried: Vec<SweepPoint>,
    pub task: &'a Task,
    pub measure: &'a mut Measure<'m>,
}

impl Walk<'_, '_> {
    /// The point of some settings; `None` if the budget is spent.
    pub fn try_config(&mut self, config: &BuildConfig) -> Result<Option<SweepPoint>, Cancelled> {
        self.task.check()?;
        if let Some(known) = self.tried.iter().find(|p| same_tree(&p.config, config)) {
            return Ok(Some(known.clone()));
        }
        if self.tried.len() >= self.search.budget.max(1) {
            return Ok(None);
        }
        let point = (self.measure)(&self.axes.name(config), config, false)?;
        self.tried.push(point.clone());
        self.task.advance(1);
        Ok(Some(point))
    }

    /// The best of a few places far apart; `None` if the budget does not reach so far.
    pub fn first(&mut self, base: &BuildConfig) -> Result<Option<Spot>, Cancelled> {
        let axes = self.axes;
        let of_each = (self.search.budget / 3 / axes.kinds.len().max(1)).clamp(1, FIRST.len());
        let mut spots = Vec::new();
        if let Some(kind) = axes.kinds.iter().position(|k| *k == (base.builder, base.width)) {
            let ratio = (base.stop == StopRule::Cost).then_some(base.traversal_cost / base.intersection_cost);
            spots.push(axes.spot(kind, base.bins, base.leaf, ratio));
        }
        for (bins, leaf, ratio) in &FIRST[..of_each] {
            spots.extend((0..axes.kinds.len()).map(|kind| axes.spot(kind, *bins, *leaf, *ratio)));
        }
        let mut best: Option<(SweepPoint, Spot)> = None;
        for spot in spots {
            let Some(point) = self.try_config(&axes.config(spot))? else { break };
            if best.as_ref().is_none_or(|(b, _)| self.is_better(&point, b)) {
                best = Some((point, spot));
            }
        }
        Ok(best.map(|(_, spot)| spot))
    }

    /// Goes on to better places until there is none near. False if the budget was spent before.
    pub fn descend(&mut self, mut spot: Spot) -> Result<bool, Cancelled> {
        let axes = self.axes;
        let mut steps = [4, 4, 4];
        let Some(mut here) = self.try_config(&axes.config(spot))? else { return Ok(false) };
        loop {
            let mut next = Vec::new();
            for (axis, step) in (1..4).zip(steps) {
                next.extend([step, -step].into_iter().filter_map(|by| axes.moved(spot, axis, by)));
            }
            let finest = steps == [1, 1, 1];
            if finest {
                // Where no step of a list is better, another builder or width may be.
                next.extend((0..axes.kinds.len()).map(|kind| [kind, spot[1], spot[2], spot[3]]));
            }
            let mut moved = false;
            for to in next {
                let Some(point) = self.try_config(&axes.config(to))? else { return Ok(false) };
                if self.is_better(&point, &here) {
                    (here, spot, moved) = (point, to, true);
                    break;
                }
            }
            if !moved && finest {
                return Ok(true);
            }
            if !moved {
                steps = steps.map(|step| (step / 2).max(1));
            }
        }
    }

    fn is_better(&self, a: &SweepPoint, b: &SweepPoint) -> bool {
        self.search.order(a, b, &self.default).is_lt()
    }
}
