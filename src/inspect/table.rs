//! The five trees side by side.

use std::sync::Arc;

use super::stats::{Measurement, TreeStats};
use crate::accel::BuildConfig;
use crate::render::{CountKind, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};

/// Builds of each tree; the build time is their median.
const BUILDS: usize = 5;

/// Builds and measures the five trees at the leaf limit, bins and costs of `base`, all rays of a Whitted frame counted;
/// build time is the median of 5 builds. Progress on `task` in steps; `finished` gets each row as it comes.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn five_trees(
    scene: &Arc<Scene>,
    camera: &Camera,
    base: &BuildConfig,
    settings: &RenderSettings,
    task: &Task,
    finished: &mut dyn FnMut(&TreeStats),
) -> Result<Vec<TreeStats>, Cancelled> {
    let measurement =
        Measurement { scene, camera, settings, count: CountKind::All, timed: true, builds: BUILDS };
    measurement.rows(&base.five_trees().map(|(name, config)| (name.to_owned(), config)), task, finished)
}

impl Measurement<'_> {
    /// Measures one tree after the other. Progress on `task`; `finished` gets each row as it comes.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn rows(
        &self,
        trees: &[(String, BuildConfig)],
        task: &Task,
        finished: &mut dyn FnMut(&TreeStats),
    ) -> Result<Vec<TreeStats>, Cancelled> {
        task.start(self.steps() * trees.len() as u64);
        let mut rows = Vec::with_capacity(trees.len());
        for (name, config) in trees {
            let row = self.of(name, config, None, task)?;
            finished(&row);
            rows.push(row);
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::columns::{COLUMNS, Value};
    use crate::scene::builtin;

    fn soup() -> (Arc<Scene>, RenderSettings) {
        let scene = Arc::new(builtin::make("soup:300").expect("a built-in scene"));
        (scene, RenderSettings { width: 32, height: 18, ..RenderSettings::default() })
    }

    #[test]
    fn five_rows_come_one_after_the_other_with_all_figures() {
        let (scene, settings) = soup();
        let task = Task::new();
        let mut seen = Vec::new();
        let mut progress = Vec::new();
        let rows = five_trees(&scene, &scene.camera, &BuildConfig::default(), &settings, &task, &mut |row| {
            seen.push(row.name.clone());
            progress.push(task.fraction().expect("the work is known"));
        });
        let rows = rows.expect("nobody cancels");
        assert_eq!(seen, ["BVH", "BVH_SAH", "QBVH", "BVH_BIN", "QBVH_BIN"]);
        assert!((0..5).all(|i| (progress[i] - (i + 1) as f32 / 5.0).abs() < 1e-6), "{progress:?}");
        for row in &rows {
            assert_eq!((row.count, row.shape_count), (CountKind::All, 300));
            assert!(row.rays.ray_count >= 32 * 18, "camera rays and those that follow");
            for column in COLUMNS.iter().filter(|c| c.key != "tree_file") {
                assert_ne!(column.value(row), Value::Missing, "{} of {}", column.key, row.name);
            }
        }
        // One frame, so the same rays whatever the tree.
        assert!(rows.iter().all(|row| row.rays.ray_count == rows[0].rays.ray_count));
        let cost = |i: usize| rows[i].figures.sah_cost.expect("it has an area").total();
        assert!(cost(1) < cost(0), "a swept tree is better than a median one");
    }

    #[test]
    fn a_cancel_between_rows_stops_the_table() {
        let (scene, settings) = soup();
        let task = Task::new();
        let mut rows = 0;
        let table = five_trees(&scene, &scene.camera, &BuildConfig::default(), &settings, &task, &mut |_| {
            rows += 1;
            task.cancel();
        });
        assert_eq!((table, rows), (Err(Cancelled), 1));
    }
}
