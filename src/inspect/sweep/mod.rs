//! Trees by the hundred: which settings, what each tree is worth, how long the rest will take.
//!
//! **Costs.** C_t and C_i decide two things: the tree, where the stop rule `cost` or optimal widening weighs them, and the
//! unit of SAH cost, EPO and ray cost. Trees that were built with different costs are comparable only under the same ones.
//! So a sweep takes all figures under one pair, that of the settings it starts from, whatever each tree was built with;
//! the columns `traversal_cost` and `intersection_cost` go on saying the latter. What a tree owes to its costs is then
//! seen in its figures. Only their ratio changes a tree.
//!
//! **Order.** Builds and timed frames run one after the other, each with all threads: two at once would slow each other
//! down and spoil both times. Counting is not timed, but a frame's rays are counted by all threads already, so several
//! trees at once would find no thread that is free.

mod grid;
pub mod plot;
mod point;
mod progress;

use std::time::{Duration, Instant};

use super::stats::Measurement;
use crate::accel::BuildConfig;
use crate::task::{Cancelled, Task};

pub use grid::{MOST_POINTS, SweepGrid, costs_matter, relevant, same_tree};
pub use point::SweepPoint;
pub use progress::{Progress, rough_time, weight};

/// What a sweep says while it runs.
#[derive(Clone, Copy, Debug)]
pub enum SweepEvent<'a> {
    /// A tree is about to be built.
    Started { name: &'a str, config: &'a BuildConfig },
    /// A point is there, after so long.
    Measured { point: &'a SweepPoint, took: Duration },
    /// A point was known already.
    Known { point: &'a SweepPoint },
}

/// Measures points of a sweep, or takes them from those that are known.
#[derive(Clone, Copy, Debug)]
pub struct Sweeper<'a> {
    pub measurement: Measurement<'a>,
    /// C_t and C_i of all figures; see the module.
    pub costs: [f32; 2],
    /// Points of the same scene and view.
    pub known: &'a [SweepPoint],
}

impl Sweeper<'_> {
    /// The point that is known of these settings, if it has all that is asked.
    pub fn find(&self, config: &BuildConfig) -> Option<&SweepPoint> {
        self.known.iter().find(|p| same_tree(&p.config, config) && (p.is_timed() || !self.measurement.timed))
    }

    /// The point of one tree. `fresh`: measured now, whatever is known.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn point(
        &self,
        name: &str,
        config: &BuildConfig,
        fresh: bool,
        task: &Task,
        say: &mut dyn FnMut(SweepEvent),
    ) -> Result<SweepPoint, Cancelled> {
        if let Some(point) = self.find(config).filter(|_| !fresh) {
            let point = point.clone().named(name);
            say(SweepEvent::Known { point: &point });
            return Ok(point);
        }
        say(SweepEvent::Started { name, config });
        let start = Instant::now();
        let stats = self.measurement.weighed(name, config, None, self.costs, &task.step())?;
        let point = SweepPoint::of(&stats);
        say(SweepEvent::Measured { point: &point, took: start.elapsed() });
        Ok(point)
    }

    /// Every point of the grid around `base`, one after the other. Progress on `task` a point at a time.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was; what `say` was told stays true.
    pub fn grid(
        &self,
        grid: &SweepGrid,
        base: &BuildConfig,
        task: &Task,
        say: &mut dyn FnMut(SweepEvent),
    ) -> Result<Vec<SweepPoint>, Cancelled> {
        let configs = grid.points(base);
        task.start(configs.len() as u64);
        let mut points = Vec::with_capacity(configs.len());
        for config in &configs {
            points.push(self.point(&grid.name(config), config, false, task, say)?);
            task.advance(1);
        }
        Ok(points)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::StopRule;
    use crate::render::{CountKind, RenderSettings};
    use crate::scene::{Scene, builtin};

    fn soup() -> (Arc<Scene>, RenderSettings) {
        let scene = Arc::new(builtin::make("soup:200").expect("a built-in scene"));
        (scene, RenderSettings { width: 16, height: 9, ..RenderSettings::default() })
    }

    fn measurement<'a>(scene: &'a Arc<Scene>, settings: &'a RenderSettings) -> Measurement<'a> {
        let (camera, count) = (&scene.camera, CountKind::Camera);
        Measurement { scene, camera, settings, count, timed: false, builds: 1 }
    }

    fn grid(base: &BuildConfig) -> SweepGrid {
        SweepGrid { bins: vec![4, 32], leaf: vec![1, 8], ..SweepGrid::around(base) }
    }

    #[test]
    fn a_sweep_measures_every_tree_of_its_grid() {
        let (scene, settings) = soup();
        let base = BuildConfig::default();
        let sweeper = Sweeper { measurement: measurement(&scene, &settings), costs: [1.0, 1.0], known: &[] };
        let (mut started, mut measured) = (0, 0);
        let task = Task::new();
        let all = sweeper.grid(&grid(&base), &base, &task, &mut |event| match event {
            SweepEvent::Started { .. } => started += 1,
            SweepEvent::Measured { .. } => measured += 1,
            SweepEvent::Known { .. } => panic!("nothing is known"),
        });
        let all = all.expect("nobody cancels");
        assert_eq!((all.len(), started, measured, task.fraction()), (4, 4, 4, Some(1.0)));
        assert!(
            all.iter().all(|p| p.number("traversal_ms").is_none() && p.number("ray_cost_mean").is_some())
        );
        assert!(all[0].number("leaf_count") > all[2].number("leaf_count"), "larger leaves are fewer");
        assert_eq!((all[1].config.bins, all[1].config.leaf), (32, 1));
    }

    #[test]
    fn what_is_known_is_not_measured_again() {
        let (scene, settings) = soup();
        let base = BuildConfig::default();
        let first = Sweeper { measurement: measurement(&scene, &settings), costs: [1.0, 1.0], known: &[] };
        let mut known = first.grid(&grid(&base), &base, &Task::new(), &mut |_| ()).expect("nobody cancels");
        let last = known.pop().expect("four points");
        let mut words = Vec::new();
        let again = Sweeper { known: &known, ..first };
        let all = again.grid(&grid(&base), &base, &Task::new(), &mut |event| {
            words.push(match event {
                SweepEvent::Started { .. } => "started",
                SweepEvent::Measured { .. } => "measured",
                SweepEvent::Known { .. } => "known",
            });
        });
        let all = all.expect("nobody cancels");
        assert_eq!(words, ["known", "known", "known", "started", "measured"]);
        assert_eq!((&all[..3], all[3].config), (&known[..], last.config));
        // A point without times does not answer a sweep with times.
        let timed = Sweeper { measurement: Measurement { timed: true, ..first.measurement }, ..again };
        assert!(timed.find(&known[0].config).is_none() && again.find(&known[0].config).is_some());
    }

    #[test]
    fn a_cancel_between_points_ends_the_sweep_and_keeps_what_was_said() {
        let (scene, settings) = soup();
        let base = BuildConfig::default();
        let sweeper = Sweeper { measurement: measurement(&scene, &settings), costs: [1.0, 1.0], known: &[] };
        let task = Task::new();
        let mut kept = Vec::new();
        let all = sweeper.grid(&grid(&base), &base, &task, &mut |event| {
            if let SweepEvent::Measured { point, .. } = event {
                kept.push(point.clone());
                task.cancel();
            }
        });
        assert_eq!((all, kept.len()), (Err(Cancelled), 1));
    }

    #[test]
    fn trees_built_with_different_costs_are_weighed_by_the_same() {
        let (scene, settings) = soup();
        let base = BuildConfig { stop: StopRule::Cost, leaf: 16, ..BuildConfig::default() };
        let grid = SweepGrid {
            bins: vec![16],
            leaf: vec![16],
            traversal_costs: vec![0.1, 1.0, 10.0],
            ..SweepGrid::around(&base)
        };
        let sweeper = Sweeper { measurement: measurement(&scene, &settings), costs: [1.0, 1.0], known: &[] };
        let all = sweeper.grid(&grid, &base, &Task::new(), &mut |_| ()).expect("nobody cancels");
        assert!(all[0].number("leaf_count") > all[2].number("leaf_count"), "dear nodes make large leaves");
        for point in &all {
            let number = |key| point.number(key).expect(key);
            let expected = number("inner_visits_mean") + number("shape_tests_mean");
            assert!((number("ray_cost_mean") - expected).abs() < 1e-9);
        }
        assert_eq!(all.iter().map(|p| p.number("traversal_cost")).collect::<Vec<_>>()[2], Some(10.0));
    }
}
