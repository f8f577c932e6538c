//! The mean ray cost of two trees with its confidence, ray by ray: the same camera ray in both.
//!
//! A mean of n values x has the 95 percent interval `mean ± 1.96 s / sqrt(n)`, where `s² = sum (x - mean)² / (n - 1)`: the
//! normal approximation, whose error is small beside the interval for the thousands of rays that a picture has. The
//! rays are taken as a random sample of all rays of the view. They lie on a grid, through the pixels' centres, and rays
//! that lie side by side cost about the same; such a mean is off by less than one of as many rays at random, so the
//! interval is rather too wide than too narrow.
//!
//! For the difference x is B - A of each ray. Where one ray is dear in both trees that cancels, so its interval is often
//! much smaller than those of the two means: a difference can be sure although these overlap.

use serde::Serialize;

use crate::render::film::FilmSubject;
use crate::render::integrate::render;
use crate::render::{CountKind, RenderSettings, View};
use crate::scene::{Camera, ShadowRule};
use crate::task::{Cancelled, Task};
use crate::world::World;

/// Of the standard normal distribution, the value that 97.5 percent do not exceed.
const Z_95: f64 = 1.959_963_984_540_054;

/// A mean, and how far from the true one it may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanInterval {
    pub mean: f64,
    /// The 95 percent interval is the mean plus and minus this; `None` of a single value.
    pub half_width_95: Option<f64>,
}

impl MeanInterval {
    /// `None` of no value.
    fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let (count, sum) = values.clone().fold((0u64, 0.0), |(n, sum), x| (n + 1, sum + x));
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let mean = sum / n;
        let squares: f64 = values.map(|x| (x - mean) * (x - mean)).sum();
        let half_width_95 = (count > 1).then(|| Z_95 * (squares / (n - 1.0) / n).sqrt());
        Some(Self { mean, half_width_95 })
    }

    /// Whether zero lies outside the interval.
    pub fn is_sure(&self) -> bool {
        self.half_width_95.is_some_and(|half| self.mean.abs() > half)
    }

    /// For people, as in `12.34 ± 0.05`.
    pub fn shown(&self) -> String {
        match self.half_width_95 {
            Some(half) => {
                // Two digits of the uncertainty say enough.
                let digits = if half > 0.0 { (1.0 - half.log10().floor()).clamp(1.0, 6.0) } else { 2.0 };
                let digits = digits as usize;
                format!("{:.digits$} ± {half:.digits$}", self.mean)
            }
            None => format!("{:.2}", self.mean),
        }
    }
}

/// Mean cost of a camera ray, `C_t * inner visits + C_i * shape tests`, of A, of B, and of B - A ray by ray.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairedRayCost {
    /// Rays that were traced in both.
    pub ray_count: u64,
    pub a: MeanInterval,
    pub b: MeanInterval,
    /// Of B - A.
    pub difference: MeanInterval,
    /// The mean difference in percent of A's mean; `None` where that is zero.
    pub percent: Option<f64>,
}

impl PairedRayCost {
    /// Of the same rays, in the same order, in A and in B. `None` of no ray, or of two numbers of rays.
    pub fn of(a: &[f32], b: &[f32]) -> Option<Self> {
        if a.len() != b.len() {
            return None;
        }
        let of = |costs: &[f32]| MeanInterval::of(costs.iter().map(|&x| f64::from(x)));
        let pairs = a.iter().zip(b).map(|(&a, &b)| f64::from(b) - f64::from(a));
        let (mean_a, mean_b, difference) = (of(a)?, of(b)?, MeanInterval::of(pairs)?);
        let percent = (mean_a.mean != 0.0).then(|| 100.0 * difference.mean / mean_a.mean);
        Some(Self { ray_count: a.len() as u64, a: mean_a, b: mean_b, difference, percent })
    }

    /// Traces one ray through the centre of every pixel in both worlds, each seen through its own camera.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn measure(
        worlds: [&World; 2],
        cameras: [&Camera; 2],
        settings: &RenderSettings,
        task: &Task,
    ) -> Result<Option<Self>, Cancelled> {
        let a = camera_ray_costs(worlds[0], cameras[0], settings, task)?;
        let b = camera_ray_costs(worlds[1], cameras[1], settings, task)?;
        Ok(Self::of(&a, &b))
    }

    /// One line for people.
    pub fn shown(&self) -> String {
        let percent = self.percent.map_or_else(String::new, |p| format!(" ({p:+.1} %)"));
        let verdict = if self.difference.is_sure() { "" } else { ", which may be chance" };
        format!(
            "A {}, B {}, B - A {}{percent}{verdict}",
            self.a.shown(),
            self.b.shown(),
            self.difference.shown()
        )
    }
}

/// The cost of one camera ray through the centre of every pixel.
fn camera_ray_costs(
    world: &World,
    camera: &Camera,
    settings: &RenderSettings,
    task: &Task,
) -> Result<Vec<f32>, Cancelled> {
    let subject =
        FilmSubject { view: View::RayCost, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
    let film = render(subject, world, camera, settings, 1, &task.step())?;
    Ok(film.numbers().expect("a heatmap holds numbers"))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::render::measure::count_rays;
    use crate::scene::builtin;

    #[test]
    fn means_and_intervals_by_hand() {
        // Sums of squares around the means: A 10, B 14, B - A 2; n - 1 = 3.
        let paired = PairedRayCost::of(&[1.0, 2.0, 4.0, 5.0], &[2.0, 3.0, 4.0, 7.0]).expect("four rays");
        assert_eq!((paired.ray_count, paired.a.mean, paired.b.mean), (4, 3.0, 4.0));
        let half = |squares: f64| Z_95 * (squares / 3.0 / 4.0).sqrt();
        for (interval, squares) in [(paired.a, 10.0), (paired.b, 14.0), (paired.difference, 2.0)] {
            let seen = interval.half_width_95.expect("more than one ray");
            assert!((seen - half(squares)).abs() < 1e-12, "{seen} {squares}");
        }
        assert_eq!((paired.difference.mean, paired.percent), (1.0, Some(100.0 / 3.0)));
        assert!(paired.difference.is_sure(), "although the intervals of A and B overlap");
        assert!(paired.a.mean + half(10.0) > paired.b.mean - half(14.0));
    }

    #[test]
    fn equal_rays_are_equal_for_sure_and_no_ray_has_no_mean() {
        let same = PairedRayCost::of(&[3.0, 9.0], &[3.0, 9.0]).expect("two rays");
        assert_eq!((same.difference.mean, same.difference.half_width_95), (0.0, Some(0.0)));
        assert!(!same.difference.is_sure());
        assert_eq!(PairedRayCost::of(&[], &[]), None);
        assert_eq!(PairedRayCost::of(&[1.0], &[1.0, 2.0]), None);
        let one = PairedRayCost::of(&[0.0], &[4.0]).expect("one ray");
        assert_eq!((one.b.half_width_95, one.percent, one.b.shown()), (None, None, "4.00".to_owned()));
    }

    #[test]
    fn it_is_said_with_as_many_digits_as_are_known() {
        let shown = |mean, half| MeanInterval { mean, half_width_95: Some(half) }.shown();
        assert_eq!(shown(12.3456, 0.0512), "12.346 ± 0.051");
        assert_eq!(shown(12.3456, 3.21), "12.3 ± 3.2");
        assert_eq!(shown(-1234.56, 123.0), "-1234.6 ± 123.0");
        assert_eq!(shown(0.0, 0.0), "0.00 ± 0.00");
    }

    /// The interval of the mean of many small samples holds the true mean about 95 times of 100.
    #[test]
    fn the_interval_holds_what_it_promises() {
        let mut state = 7u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let mut inside = 0;
        for _ in 0..1000 {
            let (a, b): (Vec<f32>, Vec<f32>) = (0..200)
                .map(|_| {
                    let x = uniform() * 10.0;
                    (x, x + uniform())
                })
                .unzip();
            let d = PairedRayCost::of(&a, &b).expect("rays").difference;
            inside += usize::from((d.mean - 0.5).abs() <= d.half_width_95.expect("many rays"));
        }
        assert!((925..=975).contains(&inside), "{inside} of 1000");
    }

    #[test]
    fn the_means_are_those_of_every_other_figure() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let task = Task::new();
        let world = |builder| {
            let config = BuildConfig { builder, traversal_cost: 1.5, ..BuildConfig::default() };
            World::build(Arc::clone(&scene), &config, &task).expect("nobody cancels")
        };
        let (a, b) = (world(Builder::Median), world(Builder::Binned));
        let settings = RenderSettings { width: 64, height: 36, ..RenderSettings::default() };
        let camera = scene.camera;
        let paired = PairedRayCost::measure([&a, &b], [&camera; 2], &settings, &task);
        let paired = paired.expect("nobody cancels").expect("rays");
        for (world, mean) in [(&a, paired.a.mean), (&b, paired.b.mean)] {
            let counted = count_rays(world, &camera, &settings, CountKind::Camera, 1, &task);
            let expected = counted.expect("nobody cancels").ray_cost_mean.expect("rays");
            assert!((mean / expected - 1.0).abs() < 1e-6, "{mean} {expected}");
        }
        assert_eq!(paired.ray_count, 64 * 36);
        assert!(paired.difference.mean < 0.0 && paired.difference.is_sure(), "{paired:?}");
    }
}
