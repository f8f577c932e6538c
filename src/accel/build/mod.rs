//! One file per builder behind [`Builder`](super::Builder); boxes and a configuration in, a tree and a report out.

mod binned;
mod bound;
mod few;
mod lbvh;
mod leaves;
mod median;
mod midpoint;
mod morton;
mod order;
#[cfg(feature = "peers")]
mod peers;
mod ploc;
mod random;
mod segment;
mod spatial;
mod sweep;
mod top_down;

use std::time::Instant;

use glam::Vec3;

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::bvh2::Bvh2;
use super::config::{BuildConfig, Builder, Improver, StopRule, Width};
use super::optimize::improve;
use super::tree::{Tree, WideBvh};
use super::widen::widen;

use order::RefSlice;

pub use binned::bin_index;

/// A stage of a build, with its wall time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct BuildPhase {
    /// `prepare` (compute, and sort, the boxes), `split` (find and make all splits), `layout` (what was built side by side put
    /// together in depth-first order), `improve` (all rounds of the improver), `widen` (make wide nodes of a binary tree).
    pub name: &'static str,
    pub ms: f64,
}

/// What a build says of itself; times are wall times in milliseconds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BuildReport {
    pub config: BuildConfig,
    pub phases: Vec<BuildPhase>,
    /// The SAH cost of the binary tree before the improver's first round and after each; empty without an improver, `None`
    /// where it is undefined.
    pub rounds: Vec<Option<f64>>,
    /// The sum of the phases.
    pub build_ms: f64,
    pub threads: usize,
}

/// Splits the time since it was started into phases.
struct PhaseClock {
    last: Instant,
    phases: Vec<BuildPhase>,
}

impl PhaseClock {
    fn start() -> Self {
        Self { last: Instant::now(), phases: Vec::new() }
    }

    fn finish(&mut self, name: &'static str) {
        let now = Instant::now();
        self.phases.push(BuildPhase { name, ms: (now - self.last).as_secs_f64() * 1e3 });
        self.last = now;
    }
}

/// What a tree is built over: shapes with boxes, counted from 0.
pub trait Shapes: Sync {
    fn count(&self) -> usize;

    /// The box around a shape.
    fn bounds(&self, shape: u32) -> Aabb;

    /// A box around the part of a shape between two planes across `axis`; empty if there is none.
    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb;

    /// The corners, if the shape is a triangle: some libraries build over those.
    fn corners(&self, _shape: u32) -> Option<[Vec3; 3]> {
        None
    }
}

/// Boxes that are shapes themselves.
impl Shapes for [Aabb] {
    fn count(&self) -> usize {
        self.len()
    }

    fn bounds(&self, shape: u32) -> Aabb {
        self[shape as usize]
    }

    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
        let mut part = self[shape as usize];
        part.min[axis] = part.min[axis].max(from);
        part.max[axis] = part.max[axis].min(to);
        part
    }
}

/// Builds a tree over `boxes`; the index of a box is the index of its shape. The tree is the same at any thread count.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// If `config` is out of range ([`BuildConfig::check`]) or a box is empty or not finite.
pub fn build(boxes: &[Aabb], config: &BuildConfig, task: &Task) -> Result<(Tree, BuildReport), Cancelled> {
    build_over(boxes, config, task)
}

/// As [`build`], over shapes that are asked for their boxes.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// As [`build`].
pub fn build_over<B: Shapes + ?Sized>(
    shapes: &B,
    config: &BuildConfig,
    task: &Task,
) -> Result<(Tree, BuildReport), Cancelled> {
    config.check().expect("a build configuration is checked where it is given");
    let mut clock = PhaseClock::start();
    let count = shapes.count();
    let bounds = |shape| shapes.bounds(shape);
    task.start(count as u64);
    // What looks at a finished binary tree gets one with the leaves that it asks for.
    let from_binary = config.is_optimal() || config.improver != Improver::None;
    let binary_config = match config.is_optimal() {
        true => BuildConfig { leaf: 1, stop: StopRule::Limit, ..*config },
        false => *config,
    };
    let input = match config.builder {
        Builder::Median | Builder::Binned | Builder::Midpoint | Builder::Random => {
            Input::Refs(order::build_refs(count, bounds, task)?)
        }
        Builder::Lbvh | Builder::Ploc => {
            let refs = order::build_refs(count, bounds, task)?;
            clock.finish("prepare");
            let bvh = match config.builder {
                Builder::Lbvh => lbvh::build(&refs, config, task)?,
                _ => ploc::build(&refs, config, task)?,
            };
            let bvh = leaves::stopped(bvh, &binary_config);
            clock.finish("split");
            Input::Binary(bvh)
        }
        #[cfg(feature = "peers")]
        builder if builder.is_peer() => {
            let boxes: Vec<Aabb> = (0..count as u32).map(bounds).collect();
            clock.finish("prepare");
            let bvh = peers::build(shapes, &boxes, config, task)?;
            clock.finish("split");
            Input::Binary(bvh)
        }
        Builder::ObvhsFast
        | Builder::ObvhsMedium
        | Builder::ObvhsVerySlow
        | Builder::Bvh
        | Builder::Parry3d => unreachable!("the configuration was checked"),
        Builder::Sweep => Input::Boxes((0..count as u32).map(bounds).collect()),
        Builder::Spatial => {
            let refs = order::build_refs(count, bounds, task)?;
            clock.finish("prepare");
            let bvh = spatial::build(refs, shapes, &binary_config, task)?;
            clock.finish("split");
            Input::Binary(bvh)
        }
    };
    let input = match input {
        Input::Refs(_) | Input::Boxes(_) if from_binary => {
            let tree = top_down::<2>(input, &binary_config, task, &mut clock)?;
            Input::Binary(Bvh2::from_wide(&tree))
        }
        input => input,
    };
    let mut steps = Steps { config, task, clock: &mut clock, rounds: Vec::new() };
    let tree = match config.width {
        Width::W2 => Tree::W2(steps.finish(input)?),
        Width::W4 => Tree::W4(steps.finish(input)?),
        Width::W8 => Tree::W8(steps.finish(input)?),
    };
    let rounds = steps.rounds;
    let build_ms = clock.phases.iter().map(|p| p.ms).sum();
    let threads = rayon::current_num_threads();
    Ok((tree, BuildReport { config: *config, phases: clock.phases, rounds, build_ms, threads }))
}

/// The boxes in the form that a builder works on.
enum Input {
    Refs(Vec<order::BuildRef>),
    Boxes(Vec<Aabb>),
    /// A finished binary tree, still to be improved and widened.
    Binary(Bvh2),
}

/// The last steps of a build.
struct Steps<'a> {
    config: &'a BuildConfig,
    task: &'a Task,
    clock: &'a mut PhaseClock,
    /// [`BuildReport::rounds`].
    rounds: Vec<Option<f64>>,
}

impl Steps<'_> {
    /// The tree itself.
    fn finish<const N: usize>(&mut self, input: Input) -> Result<WideBvh<N>, Cancelled> {
        let Self { config, task, .. } = *self;
        match input {
            Input::Binary(mut bvh) => {
                if config.improver != Improver::None {
                    self.rounds = improve(&mut bvh, config, task)?;
                    self.clock.finish("improve");
                }
                let tree = widen(&bvh, config, task)?;
                self.clock.finish("widen");
                Ok(tree)
            }
            input => top_down(input, config, task, self.clock),
        }
    }
}

/// The tree that splits make, at any width at once.
fn top_down<const N: usize>(
    input: Input,
    config: &BuildConfig,
    task: &Task,
    clock: &mut PhaseClock,
) -> Result<WideBvh<N>, Cancelled> {
    match input {
        Input::Boxes(boxes) => {
            let mut arrays = sweep::SweepArrays::sorted(&boxes);
            task.check()?;
            clock.finish("prepare");
            let splitter = sweep::Sweep(bound::BlockCount::new(config.block));
            top_down::build(arrays.order(&boxes), &splitter, config, task, clock)
        }
        Input::Refs(mut refs) => {
            clock.finish("prepare");
            match config.builder {
                Builder::Median => {
                    top_down::build(RefSlice::new(&mut refs), &median::Median, config, task, clock)
                }
                Builder::Midpoint => {
                    let splitter = midpoint::Midpoint::new(config);
                    top_down::build(RefSlice::new(&mut refs), &splitter, config, task, clock)
                }
                Builder::Random => {
                    let splitter = random::Random::new(config, &mut refs);
                    top_down::build(RefSlice::new(&mut refs), &splitter, config, task, clock)
                }
                _ => {
                    let splitter = binned::Binned::new(config, task);
                    top_down::build(RefSlice::new(&mut refs), &splitter, config, task, clock)
                }
            }
        }
        Input::Binary(_) => unreachable!("a finished binary tree is not split again"),
    }
}

#[cfg(test)]
mod tests;
