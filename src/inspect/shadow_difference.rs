//! Pixel classes and saved nodes of the shadow views, counted.

use rayon::prelude::*;
use serde::Serialize;

use crate::render::film::{Film, FilmContent};
use crate::render::pass::Pass;
use crate::render::shadow::{FirstHit, ShadowAnswers, ShadowClass, first_hit};
use crate::render::{RenderSettings, ViewClass};
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Pixels a class, in order of [`ShadowClass::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClassCounts(pub [u64; 5]);

impl ClassCounts {
    /// Counts a `shadow-difference` film; `None` for any other.
    pub fn of(film: &Film) -> Option<Self> {
        let FilmContent::Number(sums) = &film.content else { return None };
        if film.subject.view.class() != ViewClass::Class || film.samples == 0 {
            return None;
        }
        let mut counts = [0; 5];
        for class in sums.iter().map(|sum| ShadowClass::from_number(sum / film.samples as f32)) {
            counts[class.unwrap_or(ShadowClass::NotAsked) as usize] += 1;
        }
        Some(Self(counts))
    }

    pub fn get(&self, class: ShadowClass) -> u64 {
        self.0[class as usize]
    }
}

/// Mean nodes visited per asked shadow ray by `intersect`, by `occluded`, and by `occluded` with filter, of the shadow
/// rays of a picture's first sample; `None` if no pixel asks. With `stride > 1` only every `stride`-th pixel in x and y.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn shadow_nodes_mean(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    rule: ShadowRule,
    stride: u32,
    task: &Task,
) -> Result<Option<[f64; 3]>, Cancelled> {
    let pass = Pass::new(world, camera, [settings.width, settings.height], settings, rule, 0);
    let stride = stride.max(1) as usize;
    let sums = (0..settings.height)
        .into_par_iter()
        .step_by(stride)
        .map(|y| {
            let mut sums = Sums::default();
            for x in (0..settings.width).step_by(stride) {
                task.check()?;
                let ray = pass.camera_ray(x, y);
                let hit = world.intersect(&ray, &mut ());
                if let FirstHit::Asked { shadow_ray, .. } = first_hit(&pass, [x, y], &ray, hit) {
                    sums.add(&ShadowAnswers::of(world, &shadow_ray, rule));
                }
            }
            Ok(sums)
        })
        .try_reduce(Sums::default, |a, b| Ok(a.merged(&b)))?;
    Ok((sums.rays > 0).then(|| sums.nodes.map(|nodes| nodes as f64 / sums.rays as f64)))
}

/// Integers, so that the order of adding does not matter.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    rays: u64,
    nodes: [u64; 3],
}

impl Sums {
    fn add(&mut self, answers: &ShadowAnswers) {
        self.rays += 1;
        let all = [&answers.intersect, &answers.occluded, &answers.filtered];
        for (sum, answer) in self.nodes.iter_mut().zip(all) {
            *sum += answer.counters.nodes_visited();
        }
    }

    fn merged(self, other: &Self) -> Self {
        let nodes = std::array::from_fn(|i| self.nodes[i] + other.nodes[i]);
        Self { rays: self.rays + other.rays, nodes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::FilmSubject;
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    fn film(view: View, numbers: &[f32]) -> Film {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
        let content = FilmContent::Number(numbers.to_vec());
        Film { width: numbers.len() as u32, height: 1, subject, samples: 1, content }
    }

    #[test]
    fn every_pixel_is_counted_once() {
        let counts =
            ClassCounts::of(&film(View::ShadowDifference, &[1.0, 3.0, 1.0, 0.0, f32::NAN, 2.0, 3.0, 3.0]));
        let counts = counts.expect("a class film");
        assert_eq!(counts, ClassCounts([2, 2, 1, 3, 0]));
        assert_eq!(counts.get(ShadowClass::DarkOnlyInOccluded), 3);
    }

    #[test]
    fn other_films_have_no_classes() {
        assert_eq!(ClassCounts::of(&film(View::ShadowSaving, &[1.0])), None);
        let empty = Film { samples: 0, ..film(View::ShadowDifference, &[1.0]) };
        assert_eq!(ClassCounts::of(&empty), None);
    }

    #[test]
    fn the_early_out_saves_nodes() {
        let scene = std::sync::Arc::new(crate::scene::builtin::make("bunny").expect("a built-in scene"));
        let camera = scene.camera;
        let world =
            World::build(scene, &crate::accel::BuildConfig::default(), &Task::new()).expect("nobody cancels");
        let settings = RenderSettings { width: 96, height: 54, ..RenderSettings::default() };
        let rule = ShadowRule::default();
        let mean = |stride| shadow_nodes_mean(&world, &camera, &settings, rule, stride, &Task::new());
        let [intersect, occluded, filtered] = mean(1).expect("nobody cancels").expect("most pixels ask");
        assert!(occluded <= filtered && filtered < intersect, "{intersect} {occluded} {filtered}");
        assert!(occluded > 1.0);
        let coarse = mean(3).expect("nobody cancels").expect("most pixels ask");
        assert!((coarse[0] / intersect - 1.0).abs() < 0.2, "{} {intersect}", coarse[0]);
    }
}
