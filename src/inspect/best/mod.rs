//! The best settings for a scene and a view: a search over bins, leaf limit and costs.
//!
//! A few points far apart first, then a pattern search around the best of them (Hooke and Jeeves, "Direct Search Solution
//! of Numerical and Statistical Problems", 1961): each setting in turn a step up or down its list, as long as that is
//! better; when nothing is, half the step. Ray cost is counted, so the same search finds the same tree, and a tree of
//! equal ray cost is taken only if it is quicker to build. Times are measured: there the winner meets the default once
//! more, in turns, and has won only if its slowest run is quicker than the default's quickest.

mod axes;
mod walk;

use serde::Serialize;

use super::columns::Column;
use super::compare::ComparedFigure;
use super::sweep::{SweepPoint, same_tree, weight};
use crate::accel::{BuildConfig, Builder, StopRule, Width};
use crate::task::{Cancelled, Task};

use axes::Axes;
use walk::Walk;

/// Points that a search measures at most, if nothing else is said.
pub const BUDGET: usize = 64;

/// How often the winner and the default are measured in turns. By chance alone all of one come before all of the other
/// in one of 70 cases.
const RUNS: usize = 4;

/// What is to be least.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    #[default]
    RayCost,
    Time,
}

impl Objective {
    pub const ALL: [Self; 2] = [Self::RayCost, Self::Time];

    pub fn name(self) -> &'static str {
        match self {
            Self::RayCost => "ray-cost",
            Self::Time => "time",
        }
    }

    pub fn description(self) -> &'static str {
        match self {
            Self::RayCost => "least measured ray cost",
            Self::Time => "least time of one build and so many frames' rays",
        }
    }
}

/// What is searched for, and among what.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    pub objective: Objective,
    /// Frames that the tree is built for; the objective `time` adds up their rays' times.
    pub frames: u32,
    pub builders: Vec<Builder>,
    pub widths: Vec<Width>,
    /// Most trees that are measured, those of the last comparison aside.
    pub budget: usize,
}

/// How the winner stands to the default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Better,
    /// Nothing that was tried was better.
    DefaultIsBest,
    /// It was quicker in the search, but not clearly so when both ran in turns.
    WithinNoise,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    pub search: Search,
    pub verdict: Verdict,
    pub best: SweepPoint,
    /// [`BuildConfig::default`], measured on the same rays.
    pub default: SweepPoint,
    /// Every tree that was measured, in order.
    pub tried: Vec<SweepPoint>,
    /// Whether it ended because no step was better, and not because [`Search::budget`] was spent.
    pub settled: bool,
}

/// Measures a tree under a name; the flag asks for new times, whatever is known.
pub type Measure<'a> = dyn FnMut(&str, &BuildConfig, bool) -> Result<SweepPoint, Cancelled> + 'a;

impl Search {
    /// Over bins, leaf limit and costs of one builder and width.
    pub fn around(base: &BuildConfig, objective: Objective) -> Self {
        Self {
            objective,
            frames: 100,
            builders: vec![base.builder],
            widths: vec![base.width],
            budget: BUDGET,
        }
    }

    /// What the objective says of a point; infinite where it has nothing to say.
    pub fn value(&self, point: &SweepPoint) -> f64 {
        let value = match self.objective {
            Objective::RayCost => point.number("ray_cost_mean"),
            Objective::Time => point
                .number("build_ms")
                .zip(point.number("traversal_ms"))
                .map(|(build, frame)| build + f64::from(self.frames) * frame),
        };
        value.unwrap_or(f64::INFINITY)
    }

    /// The objective in words.
    pub fn what(&self) -> String {
        match self.objective {
            Objective::RayCost => "measured ray cost".to_owned(),
            Objective::Time if self.frames == 1 => "time of the build and a frame's rays".to_owned(),
            Objective::Time => format!("time of the build and {} frames' rays", self.frames),
        }
    }

    /// Searches, with `base`'s other settings. Progress on `task`: a step a tree, of `budget`.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was, or when `measure` says so.
    pub fn run(&self, base: &BuildConfig, task: &Task, measure: &mut Measure<'_>) -> Result<Best, Cancelled> {
        task.start(self.budget.max(1) as u64);
        let default = default_of(base);
        let axes = Axes::new(self, base);
        let mut walk = Walk { search: self, axes: &axes, default, tried: Vec::new(), task, measure };
        walk.try_config(&default)?;
        let settled = match walk.first(base)? {
            Some(start) => walk.descend(start)?,
            None => false,
        };
        let tried = std::mem::take(&mut walk.tried);
        let best = tried
            .iter()
            .min_by(|a, b| self.order(a, b, &default))
            .cloned()
            .expect("the default was measured, whatever the budget");
        let (verdict, [best, default]) = self.decide(&axes, best, &tried[0], measure)?;
        Ok(Best { search: self.clone(), verdict, best, default, tried, settled })
    }

    /// Whether the winner is better than the default, and both with the figures that decided.
    fn decide(
        &self,
        axes: &Axes,
        best: SweepPoint,
        default: &SweepPoint,
        measure: &mut Measure<'_>,
    ) -> Result<(Verdict, [SweepPoint; 2]), Cancelled> {
        if same_tree(&best.config, &default.config) {
            return Ok((Verdict::DefaultIsBest, [best, default.clone()]));
        }
        if self.objective == Objective::RayCost {
            return Ok((Verdict::Better, [best, default.clone()]));
        }
        let mut runs: [Vec<SweepPoint>; 2] = Default::default();
        for _ in 0..RUNS {
            for (runs, config) in runs.iter_mut().zip([best.config, default.config]) {
                runs.push(measure(&axes.name(&config), &config, true)?);
            }
        }
        for runs in &mut runs {
            runs.sort_by(|a, b| self.value(a).total_cmp(&self.value(b)));
        }
        let [best, default] = &runs;
        let clear = self.value(&best[RUNS - 1]) < self.value(&default[0]);
        let verdict = if clear { Verdict::Better } else { Verdict::WithinNoise };
        Ok((verdict, [best, default].map(|runs| runs[RUNS / 2].clone())))
    }

    /// The better of two points first. Of equal ones the default, then what is quicker to build.
    fn order(&self, a: &SweepPoint, b: &SweepPoint, default: &BuildConfig) -> std::cmp::Ordering {
        let effort = |p: &SweepPoint| {
            let config = &p.config;
            let own = if same_tree(config, default) { -1.0 } else { weight(config) };
            // Larger leaves are fewer; the rule `cost` looks at more splits than `limit`.
            [own, -(config.leaf as f64), f64::from(config.stop == StopRule::Cost)]
        };
        let efforts = effort(a).into_iter().zip(effort(b));
        self.value(a).total_cmp(&self.value(b)).then_with(|| {
            efforts.map(|(a, b)| a.total_cmp(&b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        })
    }
}

impl Best {
    /// Every figure of the default, of the winner, and the gain.
    pub fn gains(&self) -> Vec<ComparedFigure> {
        ComparedFigure::all(&self.default, &self.best)
    }

    /// By how many percent the objective is less than the default's.
    pub fn gain_percent(&self) -> Option<f64> {
        let [best, default] = [&self.best, &self.default].map(|p| self.search.value(p));
        let gain = 100.0 * (1.0 - best / default);
        gain.is_finite().then_some(gain)
    }

    /// What came out, in a sentence or two.
    pub fn sentence(&self) -> String {
        let what = self.search.what();
        let count = self.tried.len();
        let of = format!("Of {count} trees");
        let mut text = match (self.verdict, self.gain_percent()) {
            (Verdict::Better, Some(gain)) => format!(
                "{of} {} has the least {what}: {} against {} of the default, {gain:.1} % less.",
                self.best.name(),
                self.shown(&self.best),
                self.shown(&self.default),
            ),
            (Verdict::Better, None) | (Verdict::DefaultIsBest, _) => {
                format!("{of} none has less {what} than the default's {}.", self.shown(&self.default))
            }
            (Verdict::WithinNoise, _) => format!(
                "{of} none has clearly less {what} than the default's {}: the nearest, {}, is within the noise.",
                self.shown(&self.default),
                self.best.name(),
            ),
        };
        if !self.settled {
            text += &format!(" The search ended at its limit of {} trees.", self.search.budget);
        }
        text
    }

    fn shown(&self, point: &SweepPoint) -> String {
        let value = self.search.value(point);
        let (key, unit) = match self.search.objective {
            Objective::RayCost => ("ray_cost_mean", ""),
            Objective::Time => ("build_ms", " ms"),
        };
        let column = Column::of(key).expect("the key of a column");
        column.show_number(value) + unit
    }
}

/// The program's own settings, for the same processor.
fn default_of(base: &BuildConfig) -> BuildConfig {
    BuildConfig { simd: base.simd, ..BuildConfig::default() }
}

#[cfg(test)]
mod tests;
