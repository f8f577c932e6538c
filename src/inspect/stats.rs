//! All figures of one tree on one scene and view, with the settings that gave them.

use std::sync::Arc;

use serde::Serialize;

use crate::accel::BuildConfig;
use crate::accel::build::BuildPhase;
use crate::accel::quality::{SahCost, TreeFigures};
use crate::render::measure::{FrameTimes, RayFigures, count_rays, time_frame};
use crate::render::ray_costs::{RayCosts, ray_costs};
use crate::render::{CountKind, RenderSettings};
use crate::scene::{Camera, Scene};
use crate::task::{Cancelled, Task};
use crate::world::{TreeFile, World};

/// One object a tree: what `stats`, `table`, `sweep` and `compare` print, and what the panels show.
/// [`TreeRecord`](super::columns::TreeRecord) is its flat form.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TreeStats {
    /// `BVH_SAH`, `A`, or what else the caller calls it.
    pub name: String,
    pub scene: String,
    pub shape_count: usize,
    pub config: BuildConfig,
    /// The tree is from a file, and of `config` the costs and instructions alone count.
    pub imported: Option<ImportedTree>,
    pub count: CountKind,
    pub figures: TreeFigures,
    pub phases: Vec<BuildPhase>,
    pub build_ms: f64,
    pub rays: RayFigures,
    /// End-point overlap ([`World::epo`]).
    pub epo: Option<f64>,
    /// Of the three kinds of rays.
    pub ray_costs: RayCosts,
    /// `None` when not timed.
    pub times: Option<FrameTimes>,
    /// Tree and shapes ready to trace.
    pub bytes: usize,
    /// Size, seed and depth of the frame whose rays were counted.
    pub settings: RenderSettings,
    pub camera: Camera,
}

/// What is known of the making of a tree from a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ImportedTree {
    /// The file's name.
    pub file: String,
    /// Slots a node in the file.
    pub width: usize,
}

/// What trees are measured on: one scene, one view of it, and how much is asked.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    pub scene: &'a Arc<Scene>,
    pub camera: &'a Camera,
    pub settings: &'a RenderSettings,
    pub count: CountKind,
    /// Whether a frame is timed. The caller then holds the lease: nothing else may run meanwhile.
    pub timed: bool,
    /// How often each tree is built; the build time is the median. At least once.
    pub builds: usize,
}

/// Measures a world: counts rays, clips shapes to boxes, and times a frame if `timed`.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn tree_stats(
    name: &str,
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    count: CountKind,
    timed: bool,
    task: &Task,
) -> Result<TreeStats, Cancelled> {
    let rays = count_rays(world, camera, settings, count, 1, task)?;
    let costs = ray_costs(world, camera, settings, &task.step())?;
    let epo = world.epo(&task.step())?.map(|epo| epo.total);
    let times = if timed { Some(time_frame(world, camera, settings, task)?) } else { None };
    Ok(TreeStats {
        name: name.to_owned(),
        scene: world.scene.name.clone(),
        shape_count: world.scene.shape_count(),
        config: world.report.config,
        imported: world
            .traced_file()
            .map(|file| ImportedTree { file: file.name.clone(), width: file.raw.width }),
        count,
        figures: world.figures.clone(),
        phases: world.report.phases.clone(),
        build_ms: world.report.build_ms,
        rays,
        epo,
        ray_costs: costs,
        times,
        bytes: world.bytes(),
        settings: *settings,
        camera: *camera,
    })
}

impl Measurement<'_> {
    /// How many times [`Measurement::of`] advances its task.
    pub fn steps(&self) -> u64 {
        self.builds.max(1) as u64 + 1
    }

    /// Builds the tree of `config`, or takes that of `file`, and measures it. Advances `task`, which the caller started, by
    /// [`Measurement::steps`].
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(
        &self,
        name: &str,
        config: &BuildConfig,
        file: Option<&Arc<TreeFile>>,
        task: &Task,
    ) -> Result<TreeStats, Cancelled> {
        self.weighed(name, config, file, [config.traversal_cost, config.intersection_cost], task)
    }

    /// As [`Measurement::of`], with every figure under the costs `[C_t, C_i]`, whatever costs the tree was built with:
    /// so that figures of trees built with different costs can be compared.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn weighed(
        &self,
        name: &str,
        config: &BuildConfig,
        file: Option<&Arc<TreeFile>>,
        costs: [f32; 2],
        task: &Task,
    ) -> Result<TreeStats, Cancelled> {
        let mut reports = Vec::new();
        let mut world = loop {
            let world = World::of(Arc::clone(self.scene), file, config, &task.step())?;
            task.advance(1);
            reports.push(world.report.clone());
            if reports.len() >= self.builds.max(1) {
                break world;
            }
        };
        reports.sort_by(|a, b| a.build_ms.total_cmp(&b.build_ms));
        let median = &reports[reports.len() / 2];
        world.weigh(costs);
        let stats = self.of_world(name, &world, &task.step())?;
        task.advance(1);
        Ok(TreeStats { config: *config, build_ms: median.build_ms, phases: median.phases.clone(), ..stats })
    }

    /// Measures a tree that is there.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of_world(&self, name: &str, world: &World, task: &Task) -> Result<TreeStats, Cancelled> {
        tree_stats(name, world, self.camera, self.settings, self.count, self.timed, task)
    }
}

impl TreeStats {
    /// Figures made up, for tests and examples of what is done with figures.
    pub fn example(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            scene: "bunny".to_owned(),
            shape_count: 4977,
            config: BuildConfig::default(),
            imported: None,
            count: CountKind::Camera,
            figures: TreeFigures {
                node_count: 5937,
                inner_count: 2968,
                leaf_count: 2969,
                reference_count: 4977,
                depth_max: Some(20),
                depth_mean: Some(13.25),
                leaf_sizes: vec![0, 961, 2008],
                sah_cost: Some(SahCost { inner: 9.0, leaf: 3.5 }),
                levels: Vec::new(),
                overlap: 100.0,
                empty_space: 500.0,
                empty_space_mean: Some(0.25),
                slot_fill: Some(0.75),
                leaf_fill: Some(0.5),
                bytes: 1 << 18,
            },
            phases: Vec::new(),
            build_ms: 4.0,
            rays: RayFigures { ray_count: 100, nodes_visited_mean: Some(7.5), ..RayFigures::default() },
            epo: None,
            ray_costs: RayCosts { primary: Some(7.0), diffuse: Some(8.0), shadow: None },
            times: None,
            bytes: 1 << 19,
            settings: RenderSettings::default(),
            camera: Camera::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_can_be_weighed_by_other_costs_than_the_tree_was_built_with() {
        let scene = Arc::new(crate::scene::builtin::make("soup:300").expect("a built-in scene"));
        let settings = RenderSettings { width: 16, height: 9, ..RenderSettings::default() };
        let (camera, count) = (&scene.camera, CountKind::Camera);
        let measurement =
            Measurement { scene: &scene, camera, settings: &settings, count, timed: false, builds: 1 };
        let config = BuildConfig { traversal_cost: 3.0, intersection_cost: 0.5, ..BuildConfig::default() };
        let measure =
            |costs| measurement.weighed("A", &config, None, costs, &Task::new()).expect("nobody cancels");
        let (own, plain) = (measure([3.0, 0.5]), measure([1.0, 1.0]));
        assert_eq!(own.figures, measurement.of("A", &config, None, &Task::new()).expect("no cancel").figures);
        assert_eq!((own.config, plain.config), (config, config), "it says what the tree was built with");
        let sah = |stats: &TreeStats| stats.figures.sah_cost.expect("it has an area");
        assert!((sah(&own).inner / sah(&plain).inner - 3.0).abs() < 1e-9);
        assert!((sah(&own).leaf / sah(&plain).leaf - 0.5).abs() < 1e-9);
        let rays = |c_t: f64, c_i: f64| {
            let rays = &plain.rays;
            c_t * rays.inner_visits_mean.expect("rays") + c_i * rays.shape_tests_mean.expect("rays")
        };
        for (stats, expected) in [(&own, rays(3.0, 0.5)), (&plain, rays(1.0, 1.0))] {
            assert!((stats.rays.ray_cost_mean.expect("rays") - expected).abs() < 1e-9);
        }
    }
}
