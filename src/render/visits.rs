//! How often the rays of a frame visit each node.

use std::sync::atomic::{AtomicU32, Ordering};

use super::film::RenderSettings;
use super::observer::{RayKind, RayObserver, TracedRays};
use super::pass::Pass;
use super::tiles::tiles;
use super::views::CountKind;
use super::whitted::Whitted;
use crate::accel::traverse::Step;
use crate::accel::{Family, NodeId};
use crate::geometry::Ray;
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::{NodeFigure, RayQuery, Watched, World};

/// Visits of every node, by [`NodeId`](crate::accel::NodeId), by the rays of the given kind of one Whitted frame: the same
/// rays as those of [`count_rays`](super::measure::count_rays). Announces its progress on `task`, in pixels.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn node_visits(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    count: CountKind,
    task: &Task,
) -> Result<Vec<u32>, Cancelled> {
    let size = [settings.width, settings.height];
    let pass = Pass::new(world, camera, size, settings, ShadowRule::default(), 0);
    task.start(u64::from(settings.width) * u64::from(settings.height));
    visits_of(&pass, size, count, task)
}

/// Visits of every node by the camera rays of a pass.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub(super) fn camera_visits(pass: &Pass, size: [u32; 2], task: &Task) -> Result<Vec<u32>, Cancelled> {
    visits_of(pass, size, CountKind::Camera, &task.step())
}

fn visits_of(pass: &Pass, size: [u32; 2], count: CountKind, task: &Task) -> Result<Vec<u32>, Cancelled> {
    let (world, rule) = (pass.world, pass.shadow_rule);
    let visits: Vec<AtomicU32> = (0..world.tree.node_count()).map(|_| AtomicU32::new(0)).collect();
    let state = || (Whitted::new(world), Visitor { world, rule, count, visits: &visits });
    let finished = |pixels| task.advance(pixels);
    tiles::<(), _>(size, task, &finished, state, |(whitted, visitor), pixels, _| {
        whitted.radiance(pass, pixels, visitor, task).map(|_| ())
    })?;
    Ok(visits.into_iter().map(AtomicU32::into_inner).collect())
}

/// A figure of every node ([`World::node_values`]), the visits among them: by the camera rays of a picture of that size.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn node_values(
    world: &World,
    figure: NodeFigure,
    camera: &Camera,
    [width, height]: [u32; 2],
    task: &Task,
) -> Result<Vec<f32>, Cancelled> {
    // A broken tree is drawn, but another one is traced.
    let is_traced = std::ptr::eq(world.shown_tree(), &world.tree);
    if figure != NodeFigure::Visits || !is_traced {
        return world.node_values(figure, task);
    }
    let settings = RenderSettings { width, height, ..RenderSettings::default() };
    let visits = node_visits(world, camera, &settings, CountKind::Camera, task)?;
    Ok(visits.into_iter().map(|n| n as f32).collect())
}

/// A figure of the leaf of each shape, by the shape's index; of the node above the leaf where the figure is one of inner nodes.
/// Of a shape in several leaves that of the first, NaN where it is undefined. `visits`: of every node, for
/// [`NodeFigure::Visits`].
///
/// # Errors
/// [`Cancelled`] when the task was.
pub(super) fn shape_values(
    world: &World,
    figure: NodeFigure,
    visits: &[u32],
    task: &Task,
) -> Result<Vec<f32>, Cancelled> {
    let tree = &world.tree;
    let of_nodes: Vec<f32> = match figure {
        NodeFigure::Visits => visits.iter().map(|&n| n as f32).collect(),
        _ => world.node_values(figure, task)?,
    };
    let of_parent = matches!(figure, NodeFigure::Overlap | NodeFigure::EmptySpace);
    let family = if of_parent { Some(Family::of(tree, task)?) } else { None };
    let mut values = vec![f32::NAN; world.scene.shape_count()];
    for leaf_idx in (0..tree.leaf_count() as u32).rev() {
        let leaf = NodeId(tree.inner_count() as u32 + leaf_idx);
        let node = family.as_ref().and_then(|family| family.parent(leaf)).unwrap_or(leaf);
        // Of a broken tree there are figures, but another one is traced.
        let value = of_nodes.get(node.0 as usize).copied().unwrap_or(f32::NAN);
        for &shape in tree.leaf_shapes(leaf_idx) {
            values[shape as usize] = value;
        }
    }
    Ok(values)
}

/// Counts the visits of one ray, too.
pub fn add_visits(world: &World, ray: &Ray, query: RayQuery, visits: &[AtomicU32]) {
    let inner_count = world.tree.inner_count();
    world.watch(ray, query, &mut |watched| {
        let node = match watched {
            Watched::Step(Step::Boxes { node_idx, .. }) => node_idx as usize,
            Watched::Step(Step::Leaf { leaf_idx }) => inner_count + leaf_idx as usize,
            Watched::Step(Step::Shapes { .. } | Step::Popped { .. })
            | Watched::Walk { .. }
            | Watched::Found { .. } => return,
        };
        visits[node].fetch_add(1, Ordering::Relaxed);
    });
}

/// Traces the rays that are told of once more, and counts.
struct Visitor<'v> {
    world: &'v World,
    rule: ShadowRule,
    count: CountKind,
    visits: &'v [AtomicU32],
}

impl RayObserver for Visitor<'_> {
    const COUNTS: bool = false;

    fn asks_for_camera_rays_alone(&self) -> bool {
        self.count == CountKind::Camera
    }

    fn traced(&mut self, traced: &TracedRays) {
        if !self.count.includes(traced.kind) {
            return;
        }
        let query = match traced.kind {
            RayKind::Camera | RayKind::Bounce => RayQuery::Intersect,
            RayKind::Shadow => RayQuery::OccludedFiltered(self.rule),
        };
        for ray in traced.rays {
            add_visits(self.world, ray, query, self.visits);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::BuildConfig;
    use crate::render::measure::count_rays;
    use crate::scene::builtin;

    #[test]
    fn the_visits_of_all_nodes_are_those_that_rays_count() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let settings = RenderSettings { width: 40, height: 30, ..RenderSettings::default() };
        for &(width, layout) in &BuildConfig::NODES {
            let config = BuildConfig { width, layout, ..BuildConfig::default() };
            let world = World::build(Arc::clone(&scene), &config, &Task::new()).expect("nobody cancels");
            for count in CountKind::ALL {
                let visits = node_visits(&world, &scene.camera, &settings, count, &Task::new());
                let visits = visits.expect("nobody cancels");
                let figures = count_rays(&world, &scene.camera, &settings, count, 1, &Task::new());
                let figures = figures.expect("nobody cancels");
                let (inner, leaves) = visits.split_at(world.tree.inner_count());
                let rays = figures.ray_count as f64;
                for (sum, mean) in [(inner, figures.inner_visits_mean), (leaves, figures.leaf_visits_mean)] {
                    let sum: u64 = sum.iter().map(|&v| u64::from(v)).sum();
                    assert_eq!(sum as f64, (mean.expect("counted") * rays).round(), "{width:?} {count:?}");
                }
                assert!(u64::from(visits[0]) + figures.missed_root_count >= figures.ray_count);
            }
        }
    }
}
