//! A grid over bins and leaf limits.

use super::stats::{Measurement, TreeStats};
use crate::accel::BuildConfig;
use crate::task::{Cancelled, Task};

/// Which numbers of bins and which leaf limits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepGrid {
    pub bins: Vec<usize>,
    pub leaf: Vec<usize>,
}

impl Default for SweepGrid {
    fn default() -> Self {
        Self { bins: vec![2, 4, 8, 16, 32, 64, 128, 256], leaf: vec![1, 2, 4, 8, 16] }
    }
}

impl SweepGrid {
    /// The trees of the grid, named by what differs, leaf limit by leaf limit, with `base`'s other settings. A builder
    /// that does not look at bins has one tree a leaf limit.
    pub fn trees(&self, base: &BuildConfig) -> Vec<(String, BuildConfig)> {
        let own_bins = [base.bins];
        let bins = if base.builder.uses_bins() { &self.bins[..] } else { &own_bins };
        let mut trees = Vec::with_capacity(bins.len() * self.leaf.len());
        for &leaf in &self.leaf {
            for &bins in bins {
                let name = if base.builder.uses_bins() {
                    format!("{bins} bins, leaf {leaf}")
                } else {
                    format!("{}, leaf {leaf}", base.builder.name())
                };
                trees.push((name, BuildConfig { bins, leaf, ..*base }));
            }
        }
        trees
    }
}

/// Measures every tree of the grid. Progress on `task`; `finished` gets each row as it comes.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn sweep(
    measurement: &Measurement,
    base: &BuildConfig,
    grid: &SweepGrid,
    task: &Task,
    finished: &mut dyn FnMut(&TreeStats),
) -> Result<Vec<TreeStats>, Cancelled> {
    measurement.rows(&grid.trees(base), task, finished)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Builder;
    use crate::render::{CountKind, RenderSettings};

    #[test]
    fn the_grid_is_the_product_for_a_builder_with_bins() {
        let grid = SweepGrid { bins: vec![4, 16], leaf: vec![1, 2, 8] };
        let trees = grid.trees(&BuildConfig::default());
        let pairs: Vec<_> = trees.iter().map(|(_, c)| (c.leaf, c.bins)).collect();
        assert_eq!(pairs, [(1, 4), (1, 16), (2, 4), (2, 16), (8, 4), (8, 16)]);
        assert_eq!(trees[5].0, "16 bins, leaf 8");
    }

    #[test]
    fn a_builder_without_bins_has_one_column() {
        let base = BuildConfig { builder: Builder::Sweep, bins: 7, ..BuildConfig::default() };
        let trees = SweepGrid { bins: vec![4, 16], leaf: vec![1, 2] }.trees(&base);
        assert_eq!(trees.iter().map(|(_, c)| (c.leaf, c.bins)).collect::<Vec<_>>(), [(1, 7), (2, 7)]);
    }

    #[test]
    fn a_sweep_measures_every_tree_of_its_grid() {
        let scene = std::sync::Arc::new(crate::scene::builtin::make("soup:200").expect("a built-in scene"));
        let settings = RenderSettings { width: 16, height: 9, ..RenderSettings::default() };
        let measurement = Measurement {
            scene: &scene,
            camera: &scene.camera,
            settings: &settings,
            count: CountKind::Camera,
            timed: false,
            builds: 1,
        };
        let grid = SweepGrid { bins: vec![4, 32], leaf: vec![1, 8] };
        let mut rows = 0;
        let all = sweep(&measurement, &BuildConfig::default(), &grid, &Task::new(), &mut |_| rows += 1);
        let all = all.expect("nobody cancels");
        assert_eq!((all.len(), rows), (4, 4));
        assert!(all.iter().all(|row| row.times.is_none() && row.rays.ray_count == 16 * 9));
        assert!(all[0].figures.leaf_count > all[2].figures.leaf_count, "larger leaves are fewer");
        assert_eq!((all[1].config.bins, all[1].config.leaf), (32, 1));
    }

    #[test]
    fn every_tree_of_the_default_grid_can_be_built() {
        for (name, config) in SweepGrid::default().trees(&BuildConfig::default()) {
            assert_eq!(config.check(), Ok(()), "{name}");
        }
    }
}
