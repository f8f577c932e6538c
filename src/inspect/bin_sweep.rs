//! What the bins do: SAH cost, nodes visited and build time over the number of bins, and the full sweep as a line.

use std::sync::Arc;

use serde::Serialize;

use crate::accel::{BuildConfig, Builder};
use crate::render::measure::count_rays;
use crate::render::{CountKind, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// One number of bins; `bins` is `None` for the full sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BinPoint {
    pub bins: Option<usize>,
    pub sah_cost: Option<f64>,
    pub nodes_visited_mean: Option<f64>,
    pub build_ms: f64,
    /// Whether `build_ms` was taken with nothing else running.
    pub timed_alone: bool,
}

/// 24 numbers of bins from 2 to 256, closer together where they are few: that is where they matter.
pub fn coarse_bins() -> Vec<usize> {
    vec![2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128, 192, 256]
}

/// Builds the binned tree (or, for `None`, the swept one) with `base`'s other settings, and counts the camera rays of
/// every `stride`-th pixel.
///
/// # Errors
/// [`Cancelled`] when the task was.
#[expect(
    clippy::too_many_arguments,
    reason = "a scene, a view of it and a point of the curve; called from one place"
)]
pub fn measure_bins(
    scene: &Arc<Scene>,
    camera: &Camera,
    base: &BuildConfig,
    bins: Option<usize>,
    settings: &RenderSettings,
    stride: u32,
    timed_alone: bool,
    task: &Task,
) -> Result<BinPoint, Cancelled> {
    let config = match bins {
        Some(bins) => BuildConfig { builder: Builder::Binned, bins, ..*base },
        None => BuildConfig { builder: Builder::Sweep, ..*base },
    };
    let world = World::build(Arc::clone(scene), &config, &task.step())?;
    let rays = count_rays(&world, camera, settings, CountKind::Camera, stride, &task.step())?;
    Ok(BinPoint {
        bins,
        sah_cost: world.figures.sah_cost.map(|c| c.total()),
        nodes_visited_mean: rays.nodes_visited_mean,
        build_ms: world.report.build_ms,
        timed_alone,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_bins_rise_and_span_the_whole_range() {
        let bins = coarse_bins();
        assert!(bins.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(
            (bins.len(), bins[0], bins[bins.len() - 1]),
            (24, *BuildConfig::BINS.start(), *BuildConfig::BINS.end())
        );
        assert!(bins.contains(&BuildConfig::default().bins));
    }

    #[test]
    fn a_point_says_what_its_tree_costs() {
        let scene = Arc::new(crate::scene::builtin::make("soup:400").expect("a built-in scene"));
        let settings = RenderSettings { width: 64, height: 36, ..RenderSettings::default() };
        let at = |bins| {
            let base = BuildConfig { leaf: 3, ..BuildConfig::default() };
            measure_bins(&scene, &scene.camera, &base, bins, &settings, 4, false, &Task::new())
                .expect("nobody cancels")
        };
        let (two, many, sweep) = (at(Some(2)), at(Some(128)), at(None));
        let cost = |p: &BinPoint| p.sah_cost.expect("it has an area");
        assert!(cost(&many) < cost(&two), "more bins find better splits: {two:?} {many:?}");
        assert!((cost(&many) / cost(&sweep) - 1.0).abs() < 0.1, "{many:?} {sweep:?}");
        assert_eq!((two.bins, sweep.bins, two.timed_alone), (Some(2), None, false));
        assert!(two.nodes_visited_mean > many.nodes_visited_mean && many.build_ms > 0.0);
    }
}
