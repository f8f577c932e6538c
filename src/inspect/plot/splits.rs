//! The plot of what a node's splits would cost.

use super::{Axis, Ink, Mark, Plot, Series};
use crate::accel::split_costs::SplitCandidate;
use crate::inspect::split_curve::{BinnedPlanes, SplitCurve};

/// The names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Costs above this many times the least are cut off: what matters lies below.
const MOST_TIMES: f64 = 6.0;

/// The exact cost at every position of an axis, the planes between bins over it, what the node costs as a leaf and as it was
/// split. `planes`: of the build's bins, and of others held beside them.
pub fn split_costs(curve: &SplitCurve, planes: &[BinnedPlanes; 2], axis: usize) -> Plot {
    let exact = &curve.curves[axis];
    let at = |candidate: &SplitCandidate| [f64::from(candidate.position), f64::from(candidate.cost)];
    let finite = |candidates: &[SplitCandidate]| -> Vec<[f64; 2]> {
        candidates.iter().filter(|candidate| candidate.cost.is_finite()).map(at).collect()
    };
    let [build, beside] = planes.each_ref().map(|planes| finite(&planes.axes[axis]));
    let points = finite(exact);
    let least = points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let most = points.iter().chain(&build).map(|p| p[1]).fold(0.0, f64::max).min(MOST_TIMES * least);
    let lines = [Some(curve.leaf_cost), curve.made_cost].into_iter().flatten().map(f64::from);
    let seen = lines.filter(|cost| *cost <= 1.5 * most);
    let y = Axis::around(seen.chain([least, most])).labelled("cost");
    let ends = [points.first(), points.last()].map(|p| p.map_or(0.0, |p| p[0]));
    let x = Axis::linear(if ends[1] > ends[0] { ends } else { [ends[0], ends[0] + 1.0] }, 6);
    let line = Series::new("exact", Mark::Line { width: 1.5 }, Ink::Accent).at(points);
    let leaf = Series::new("as a leaf", Mark::Across, Ink::Muted).at([[ends[0], f64::from(curve.leaf_cost)]]);
    let mut plot = Plot::new("Split costs", x.labelled(AXES[axis]), y).with(line).with(leaf);
    if planes[1].bins != planes[0].bins {
        let dots = Mark::Dots { radius: 1.75, filled: true };
        plot = plot.with(Series::new(format!("{} bins", planes[1].bins), dots, Ink::Third).at(beside));
    }
    let dots = Mark::Dots { radius: 3.0, filled: true };
    plot =
        plot.with(Series::new(format!("{} bins of the build", planes[0].bins), dots, Ink::Second).at(build));
    if let Some(made) = curve.made_cost {
        let series = Series::new("as it was split", Mark::Across, Ink::Second);
        plot = plot.with(series.faint(0.6).at([[ends[0], f64::from(made)]]));
    }
    match curve.made.filter(|made| made.axis == axis) {
        Some(made) => {
            plot.with(Series::new("the split that was made", Mark::Upright, Ink::Second).at([at(&made)]))
        }
        None => plot,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Builder, Family, NodeId, Width};
    use crate::scene::builtin;
    use crate::task::Task;
    use crate::world::World;

    #[test]
    fn every_axis_has_its_curve_and_one_the_split_that_was_made() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let config = BuildConfig { builder: Builder::Sweep, width: Width::W2, ..BuildConfig::default() };
        let world = World::build(scene, &config, &Task::new()).expect("nobody cancels");
        let family = Family::of(&world.tree, &Task::new()).expect("nobody cancels");
        let curve = SplitCurve::of(&world, &family, NodeId(0), &Task::new()).expect("nobody cancels");
        let planes = [16, 64].map(|bins| curve.binned(bins));
        let plots = [0, 1, 2].map(|axis| split_costs(&curve, &planes, axis));
        let has = |plot: &Plot, name: &str| plot.series.iter().any(|series| series.name == name);
        assert_eq!(plots.iter().filter(|plot| has(plot, "the split that was made")).count(), 1);
        for plot in &plots {
            assert!(has(plot, "exact") && has(plot, "64 bins") && has(plot, "as a leaf"));
            assert!(plot.y.range[0] < plot.y.range[1] && plot.x.range[0] < plot.x.range[1]);
        }
    }
}
