//! Counting the pixel classes of the shadow views, and the nodes that each way of asking visits.

use std::sync::Arc;

use rayon::prelude::*;

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::shadow_difference::ClassCounts;
use crate::render::RenderSettings;
use crate::render::pass::Pass;
use crate::render::shadow::{ShadowClass, answers};
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// What the counts depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowKey {
    pub tree: TreeKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub rule: ShadowRule,
}

#[derive(Clone)]
pub struct ShadowRequest {
    pub key: ShadowKey,
    pub world: Arc<World>,
    pub settings: RenderSettings,
}

/// Every pixel's shadow ray, asked three ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowFigures {
    pub counts: ClassCounts,
    /// Nodes visited a ray by `intersect`, by plain `occluded`, by the filtered one; `None` if no ray was asked.
    pub nodes_mean: Option<[f64; 3]>,
}

pub type ShadowJob = Job<ShadowRequest, (ShadowKey, ShadowFigures)>;

pub fn job() -> ShadowJob {
    Job::new(Patience::None, PoolKind::Background, |run: &Run<ShadowRequest, _>| {
        let Ok(_pass) = run.context.gate.enter(run.task, OnLease::Finish) else { return };
        let ShadowRequest { key, world, settings } = run.request;
        let settings = RenderSettings { width: key.width, height: key.height, ..*settings };
        if let Ok(figures) = ask_all(world, &key.camera, &settings, key.rule, run.task) {
            run.emit((*key, figures));
        }
    })
}

/// Asks the shadow ray of every pixel three ways. In the current pool.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn ask_all(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    rule: ShadowRule,
    task: &Task,
) -> Result<ShadowFigures, Cancelled> {
    let size = [settings.width, settings.height];
    let pass = Pass::new(world, camera, size, settings, rule, 0);
    let rows: Result<Vec<Sums>, Cancelled> = (0..settings.height)
        .into_par_iter()
        .map(|y| {
            task.check()?;
            Ok((0..settings.width).fold(Sums::default(), |sums, x| sums.with(&pass, x, y)))
        })
        .collect();
    let sums = rows?.into_iter().fold(Sums::default(), Sums::plus);
    let asked: u64 = sums.classes.iter().sum::<u64>() - sums.classes[ShadowClass::NotAsked as usize];
    let mean = |nodes: u64| nodes as f64 / asked as f64;
    Ok(ShadowFigures {
        counts: ClassCounts(sums.classes),
        nodes_mean: (asked > 0).then(|| sums.nodes.map(mean)),
    })
}

#[derive(Clone, Copy, Default)]
struct Sums {
    classes: [u64; 5],
    nodes: [u64; 3],
}

impl Sums {
    fn with(mut self, pass: &Pass, x: u32, y: u32) -> Self {
        let answers = answers(pass, x, y);
        let class = answers.as_ref().map_or(ShadowClass::NotAsked, |a| a.class);
        self.classes[class as usize] += 1;
        if let Some(a) = answers {
            for (sum, answer) in self.nodes.iter_mut().zip([a.intersect, a.occluded, a.filtered]) {
                *sum += answer.counters.nodes_visited();
            }
        }
        self
    }

    fn plus(mut self, other: Self) -> Self {
        for (sum, n) in self.classes.iter_mut().zip(other.classes) {
            *sum += n;
        }
        for (sum, n) in self.nodes.iter_mut().zip(other.nodes) {
            *sum += n;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::BuildConfig;
    use crate::render::film::FilmSubject;
    use crate::render::integrate::render;
    use crate::render::{CountKind, View};
    use crate::scene::builtin;

    #[test]
    fn the_counts_are_those_of_the_difference_view() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let camera = scene.camera;
        let task = Task::new();
        let world = World::build(scene, &BuildConfig::default(), &task).expect("not cancelled");
        let settings = RenderSettings { width: 48, height: 32, ..Default::default() };
        let rule = ShadowRule::Glass;
        let figures = ask_all(&world, &camera, &settings, rule, &task).expect("not cancelled");
        let subject =
            FilmSubject { view: View::ShadowDifference, count: CountKind::Camera, shadow_rule: rule };
        let film = render(subject, &world, &camera, &settings, 1, &task).expect("not cancelled");
        assert_eq!(Some(figures.counts), ClassCounts::of(&film));
        let [intersect, occluded, _] = figures.nodes_mean.expect("rays were asked");
        assert!(intersect > occluded, "the early out saves nodes: {intersect} against {occluded}");
    }
}
