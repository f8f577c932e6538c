//! Plots of a tree: what its boxes say at each depth, and how full its leaves are.

use super::{Axis, Ink, Mark, Plot, Point, Series};
use crate::accel::quality::TreeFigures;
use crate::inspect::histogram::Histogram;

/// The SAH cost of inner nodes and leaves at each depth.
pub fn sah_by_depth(figures: &TreeFigures) -> Plot {
    let levels = &figures.levels;
    let inner = levels.iter().map(|level| level.sah_inner).collect();
    let leaf = levels.iter().map(|level| level.sah_leaf).collect();
    let highest = levels.iter().map(|level| level.sah_inner + level.sah_leaf).fold(0.0, f64::max);
    Plot::new("SAH cost per depth", depths(figures, 8), Axis::from_zero(highest).labelled("SAH cost"))
        .with_stacked_bars(0.0, [("inner nodes", Ink::Accent, inner), ("leaves", Ink::Second, leaf)])
}

/// Inner nodes and leaves at each depth.
pub fn nodes_by_depth(figures: &TreeFigures) -> Plot {
    let levels = &figures.levels;
    let inner = levels.iter().map(|level| level.inner_count as f64).collect();
    let leaves = levels.iter().map(|level| level.leaf_count as f64).collect();
    let most = levels.iter().map(|level| (level.inner_count + level.leaf_count) as f64).fold(0.0, f64::max);
    Plot::new("Nodes by depth", depths(figures, 12), Axis::root_from_zero(most).labelled("nodes"))
        .with_stacked_bars(0.0, [("inner nodes", Ink::Accent, inner), ("leaves", Ink::Second, leaves)])
}

fn depths(figures: &TreeFigures, most: usize) -> Axis {
    Axis::integers(0.0, figures.levels.len().max(1) as f64 - 1.0, most).labelled("depth")
}

/// How many leaves hold how many shapes.
pub fn leaf_sizes(figures: &TreeFigures) -> Plot {
    let counts: Vec<f64> = figures.leaf_sizes.iter().skip(1).map(|&n| n as f64).collect();
    let x = Axis::integers(1.0, counts.len().max(1) as f64, 8).labelled("shapes in the leaf");
    let y = Axis::from_zero(counts.iter().copied().fold(0.0, f64::max)).labelled("leaves");
    Plot::new("Leaf sizes", x, y).with_stacked_bars(1.0, [("leaves", Ink::Second, counts)])
}

/// The SAH cost of the binary tree before the improver's first round and after each.
pub fn round_costs(costs: &[f64]) -> Plot {
    let last = costs.len().saturating_sub(1) as f64;
    let x = Axis::integers(0.0, last, 8).labelled("rounds");
    let y = Axis::around(costs.iter().copied()).labelled("SAH cost of the binary tree");
    let points: Vec<[f64; 2]> = costs.iter().enumerate().map(|(i, cost)| [i as f64, *cost]).collect();
    Plot::new("SAH cost by round", x, y)
        .with(Series::new("line", Mark::Line { width: 1.5 }, Ink::Accent).at(points.clone()).decoration())
        .with(Series::new("rounds", Mark::Dots { radius: 2.5, filled: true }, Ink::Accent).at(points))
}

/// How many pixels have which number; `range` is what the colour map covers.
pub fn histogram(histogram: &Histogram, of: &str, range: [f64; 2]) -> Plot {
    let [from, to] = histogram.range.map(f64::from);
    let width = (to - from) / histogram.counts.len().max(1) as f64;
    let most = histogram.counts.iter().map(|n| *n as f64).fold(0.0, f64::max);
    let bars = histogram.counts.iter().enumerate().map(|(i, count)| Point {
        x: from + (i as f64 + 0.5) * width,
        y: *count as f64,
        ..Point::default()
    });
    let x = Axis::linear([from, if to > from { to } else { from + 1.0 }], 8).labelled(of);
    let series = Series::new("pixels", Mark::Bars { width }, Ink::Accent);
    let ends = range.map(|end| [end, 0.0]);
    Plot::new("Histogram", x, Axis::root_from_zero(most).labelled("pixels"))
        .with(Series { points: bars.collect(), ..series })
        .with(Series::new("range of the colour map", Mark::Upright, Ink::Second).at(ends))
}
