//! One file per builder behind [`Builder`](super::Builder); boxes and a configuration in, a tree and a report out.

mod binned;
mod bound;
mod few;
mod lbvh;
mod leaves;
mod median;
mod midpoint;
mod morton;
mod onlooker;
mod order;
#[cfg(feature = "peers")]
mod peers;
mod ploc;
mod presplit;
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
use super::compressed::CompressedBvh;
use super::config::{BuildConfig, Builder, Improver, Layout, StopRule, Width};
use super::optimize::improve;
use super::tree::{Tree, WideBvh};
use super::widen::widen;

use order::RefSlice;

pub use binned::bin_index;
pub use onlooker::{Onlooker, Round, RoundKind};

/// A stage of a build, with its wall time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct BuildPhase {
    /// `prepare` (compute, and sort, the boxes), `presplit` (cut large shapes), `split` (find and make all splits), `layout` (what was built side by side put
    /// together in depth-first order), `improve` (all rounds of the improver), `widen` (make wide nodes of a binary tree), `compress` (make
    /// them small).
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

    /// Ends a phase, or another part of it.
    fn finish(&mut self, name: &'static str) {
        let now = Instant::now();
        let ms = (now - self.last).as_secs_f64() * 1e3;
        match self.phases.iter_mut().find(|phase| phase.name == name) {
            Some(phase) => phase.ms += ms,
            None => self.phases.push(BuildPhase { name, ms }),
        }
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
    /// The box around the part of a shape inside `clip`; empty if there is none. What parts touch together is what the
    /// whole touches: their boxes reach all sides of the shape's own.
    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb;

    /// What the surface areas of the boxes of a shape's parts add up to when it is cut ever finer; the area of its own box
    /// for what is never to be cut in advance.
    fn area_in_parts(&self, shape: u32) -> f32;
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

    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
        self[shape as usize].intersection(*clip)
    }

    /// A box is full: cutting it gains nothing.
    fn area_in_parts(&self, shape: u32) -> f32 {
        self[shape as usize].area()
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
    build_watched(shapes, config, Onlooker::nobody(), task)
}

/// As [`build_over`], with somebody who looks at what stands after each round of what is made in rounds.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// As [`build`].
pub fn build_watched<B: Shapes + ?Sized>(
    shapes: &B,
    config: &BuildConfig,
    mut onlooker: Onlooker<'_>,
    task: &Task,
) -> Result<(Tree, BuildReport), Cancelled> {
    config.check().expect("a build configuration is checked where it is given");
    let asked = config;
    let config = &BuildConfig { leaf: config.leaf_limit(), ..*config };
    let mut clock = PhaseClock::start();
    let mut refs = order::build_refs(shapes.count(), |shape| shapes.bounds(shape), task)?;
    if config.pre_split > 0.0 {
        clock.finish("prepare");
        refs = presplit::presplit(refs, shapes, config.pre_split, task)?;
        clock.finish("presplit");
    }
    task.start(refs.len() as u64);
    // What looks at a finished binary tree gets one with the leaves that it asks for.
    let from_binary = config.is_optimal() || config.improver != Improver::None;
    let binary_config = match config.is_optimal() {
        true => BuildConfig { leaf: 1, stop: StopRule::Limit, ..*config },
        false => *config,
    };
    let input = match config.builder {
        Builder::Median | Builder::Sweep | Builder::Binned | Builder::Midpoint | Builder::Random => {
            Input::Refs(refs)
        }
        Builder::Lbvh | Builder::Ploc => {
            clock.finish("prepare");
            let bvh = match config.builder {
                Builder::Lbvh => lbvh::build(&refs, config, task)?,
                _ => ploc::build(&refs, config, &mut onlooker, task)?,
            };
            let bvh = leaves::stopped(bvh, &binary_config);
            clock.finish("split");
            Input::Binary(bvh)
        }
        #[cfg(feature = "peers")]
        builder if builder.is_peer() => {
            clock.finish("prepare");
            let bvh = peers::build(shapes, &refs, config, task)?;
            clock.finish("split");
            Input::Binary(bvh)
        }
        Builder::ObvhsFast
        | Builder::ObvhsMedium
        | Builder::ObvhsVerySlow
        | Builder::Bvh
        | Builder::Parry3d => unreachable!("the configuration was checked"),
        Builder::Spatial => {
            clock.finish("prepare");
            let bvh = spatial::build(refs, shapes, &binary_config, task)?;
            clock.finish("split");
            Input::Binary(bvh)
        }
    };
    let input = match input {
        Input::Refs(_) if from_binary => {
            let tree = top_down::<2>(input, &binary_config, task, &mut clock)?;
            Input::Binary(Bvh2::from_wide(&tree))
        }
        input => input,
    };
    // Whatever was cut short by a cancel is no tree.
    task.check()?;
    let mut steps = Steps { config, task, clock: &mut clock, onlooker: &mut onlooker, rounds: Vec::new() };
    let tree = match config.width {
        Width::W2 => Tree::W2(steps.finish(input)?),
        Width::W4 => Tree::W4(steps.finish(input)?),
        Width::W8 => Tree::W8(steps.finish(input)?),
    };
    let rounds = steps.rounds;
    let tree = match tree {
        Tree::W8(tree) if config.layout == Layout::Compressed => {
            task.check()?;
            let tree = CompressedBvh::new(&tree);
            clock.finish("compress");
            Tree::C8(tree)
        }
        tree => tree,
    };
    let build_ms = clock.phases.iter().map(|p| p.ms).sum();
    let threads = rayon::current_num_threads();
    Ok((tree, BuildReport { config: *asked, phases: clock.phases, rounds, build_ms, threads }))
}

/// What the last steps of a build begin with.
enum Input {
    Refs(Vec<order::BuildRef>),
    /// A finished binary tree, still to be improved and widened.
    Binary(Bvh2),
}

/// The last steps of a build.
struct Steps<'a, 'o> {
    config: &'a BuildConfig,
    task: &'a Task,
    clock: &'a mut PhaseClock,
    onlooker: &'a mut Onlooker<'o>,
    /// [`BuildReport::rounds`].
    rounds: Vec<Option<f64>>,
}

impl Steps<'_, '_> {
    /// The tree itself.
    fn finish<const N: usize>(&mut self, input: Input) -> Result<WideBvh<N>, Cancelled> {
        let Self { config, task, .. } = *self;
        let mut tree = match input {
            Input::Binary(mut bvh) => {
                if config.improver != Improver::None {
                    self.rounds = improve(&mut bvh, config, self.onlooker, task)?;
                    self.clock.finish("improve");
                }
                let tree = widen(&bvh, config, task)?;
                self.clock.finish("widen");
                tree
            }
            input => top_down(input, config, task, self.clock)?,
        };
        if config.pre_split > 0.0 {
            tree.merge_parts();
            self.clock.finish("presplit");
        }
        Ok(tree)
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
        Input::Refs(refs) if config.builder == Builder::Sweep => {
            let mut arrays = sweep::SweepArrays::sorted(&refs);
            task.check()?;
            clock.finish("prepare");
            let splitter = sweep::Sweep(bound::BlockCount::new(config.block));
            top_down::build(arrays.order(&refs), &splitter, config, task, clock)
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
