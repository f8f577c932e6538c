//! What one ray did in a tree, step by step: boxes tested, children that wait, shapes tested, and where it stopped.

use crate::accel::traverse::{Step, hits_root};
use crate::accel::{ChildRef, NodeId, Nodes, RayCounters, Tree};
use crate::each_width;
use crate::geometry::{Aabb, Hit, Ray};
use crate::world::{RayQuery, Watched, World};

/// The steps of a ray, in order.
#[derive(Clone, Debug)]
pub struct RayHistory {
    pub ray: Ray,
    pub query: RayQuery,
    pub steps: Vec<RayStep>,
    /// The shape that is the answer.
    pub answer: Option<u32>,
    pub counters: RayCounters,
    /// The ray misses the root's box, so that it visits nothing.
    pub missed_root: bool,
}

/// One step. Distances are along the ray, in units of its direction.
#[derive(Clone, Debug, PartialEq)]
pub enum RayStep {
    /// The walk begins at the root, from `t_min` on.
    Begin {
        t_min: f32,
    },
    /// A shape outside the tree.
    Outside {
        shape: u32,
        outcome: Outcome,
    },
    /// The children of an inner node are tested up to `t_max`.
    Boxes {
        node: NodeId,
        t_max: f32,
        children: Vec<BoxTest>,
    },
    /// A child that was entered waits on the stack.
    Push {
        node: NodeId,
        entry: f32,
    },
    /// The nearest that waits is taken from the stack.
    Pop {
        node: NodeId,
        entry: f32,
    },
    /// It is dropped: it begins behind the nearest hit.
    Drop {
        node: NodeId,
        entry: f32,
        t_max: f32,
    },
    /// The shapes of a leaf are tested.
    Leaf {
        node: NodeId,
    },
    Shape {
        shape: u32,
        outcome: Outcome,
    },
    /// A hit that counts: the walk is over at once, whatever still waits.
    Stop {
        shape: u32,
    },
    /// The nearest hit of the walk.
    Nearest {
        shape: u32,
        t: f32,
    },
    /// Nothing was hit.
    Miss,
}

/// A child's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxTest {
    pub node: NodeId,
    pub bounds: Aabb,
    /// Where the ray enters it; `None` if it does not, before its end.
    pub entry: Option<f32>,
}

/// What the test of a shape said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    Missed,
    /// Hit, but not nearer than the nearest hit so far, or beyond the ray's end.
    Behind {
        t: f32,
    },
    /// The nearest hit so far.
    Nearest {
        t: f32,
    },
    /// Hit, and the ray stops there.
    Stops {
        t: f32,
    },
    /// Hit, but it lets light pass.
    LetsPass {
        t: f32,
    },
    /// Left out: it lets light pass.
    Skipped,
    /// Left out: the ray had stopped.
    NotReached,
}

impl Outcome {
    /// Whether the shape was tested at all.
    pub fn is_tested(self) -> bool {
        !matches!(self, Self::Skipped | Self::NotReached)
    }
}

impl RayStep {
    /// The node that the step is about.
    pub fn node(&self) -> Option<NodeId> {
        match *self {
            Self::Boxes { node, .. }
            | Self::Push { node, .. }
            | Self::Pop { node, .. }
            | Self::Drop { node, .. }
            | Self::Leaf { node } => Some(node),
            Self::Begin { .. }
            | Self::Outside { .. }
            | Self::Shape { .. }
            | Self::Stop { .. }
            | Self::Nearest { .. }
            | Self::Miss => None,
        }
    }

    /// The shape that the step is about.
    pub fn shape(&self) -> Option<u32> {
        match *self {
            Self::Outside { shape, .. }
            | Self::Shape { shape, .. }
            | Self::Stop { shape }
            | Self::Nearest { shape, .. } => Some(shape),
            Self::Begin { .. }
            | Self::Boxes { .. }
            | Self::Push { .. }
            | Self::Pop { .. }
            | Self::Drop { .. }
            | Self::Leaf { .. }
            | Self::Miss => None,
        }
    }
}

/// What is known before a step is made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// What waits, the next one last, with where the ray enters it.
    pub stack: Vec<(NodeId, f32)>,
    /// The inner node or leaf whose content is tested.
    pub node: Option<NodeId>,
    /// The nearest hit so far.
    pub nearest: Option<(u32, f32)>,
}

impl RayHistory {
    /// Asks a ray and writes down every step.
    pub fn record(world: &World, ray: &Ray, query: RayQuery) -> Self {
        let mut recorder = Recorder {
            world,
            ray: *ray,
            query,
            steps: Vec::new(),
            counters: RayCounters::default(),
            best: Hit::none(ray.last()),
            beyond: None,
            stopped: false,
        };
        let answer = world.watch(ray, query, &mut |what| recorder.note(what));
        if answer.is_none() {
            recorder.steps.push(RayStep::Miss);
        }
        let Recorder { steps, counters, .. } = recorder;
        let missed_root = !hits_root(&world.tree, ray);
        Self { ray: *ray, query, steps, answer, counters, missed_root }
    }

    /// What is known when `count` steps have been made.
    pub fn after(&self, count: usize) -> Moment {
        let mut moment = Moment::default();
        for step in &self.steps[..count.min(self.steps.len())] {
            match *step {
                RayStep::Begin { .. } => moment = Moment::default(),
                RayStep::Boxes { node, .. } | RayStep::Leaf { node } => moment.node = Some(node),
                RayStep::Push { node, entry } => moment.stack.push((node, entry)),
                RayStep::Pop { node, .. } => {
                    moment.stack.pop();
                    moment.node = Some(node);
                }
                RayStep::Drop { .. } => {
                    moment.stack.pop();
                }
                RayStep::Outside { shape, outcome: Outcome::Nearest { t } }
                | RayStep::Shape { shape, outcome: Outcome::Nearest { t } }
                | RayStep::Nearest { shape, t } => moment.nearest = Some((shape, t)),
                RayStep::Outside { .. } | RayStep::Shape { .. } | RayStep::Stop { .. } | RayStep::Miss => {}
            }
        }
        moment
    }

    /// Boxes that were entered and never looked into: what stopping early, or a near hit, saved.
    pub fn left_waiting(&self) -> usize {
        self.after(self.steps.len()).stack.len()
    }
}

/// Turns what is told of a walk into steps.
struct Recorder<'w> {
    world: &'w World,
    ray: Ray,
    query: RayQuery,
    steps: Vec<RayStep>,
    counters: RayCounters,
    /// Of this walk.
    best: Hit,
    /// The hit behind which this walk goes on.
    beyond: Option<Hit>,
    /// By a shape that was found.
    stopped: bool,
}

impl Recorder<'_> {
    fn note(&mut self, what: Watched) {
        match what {
            Watched::Walk { t_min } => self.begin(t_min),
            Watched::Step(Step::Boxes { node_idx, t_max, entered, entries }) => {
                each_width!(&self.world.tree, t => self.boxes(t, node_idx, t_max, entered, entries));
            }
            Watched::Step(Step::Leaf { leaf_idx }) => self.leaf(leaf_idx),
            Watched::Step(Step::Shapes { count }) => self.counters.shape_tests += u64::from(count),
            Watched::Step(Step::Popped { child, entry, t_max }) => {
                let node = node_of(&self.world.tree, child);
                self.steps.push(if entry <= t_max {
                    RayStep::Pop { node, entry }
                } else {
                    RayStep::Drop { node, entry, t_max }
                });
            }
            Watched::Found { shape, t } => self.steps.push(match t {
                Some(t) => {
                    self.beyond = Some(Hit { t, shape, u: 0.0, v: 0.0 });
                    RayStep::Nearest { shape, t }
                }
                None => RayStep::Stop { shape },
            }),
        }
    }

    fn begin(&mut self, t_min: f32) {
        self.steps.push(RayStep::Begin { t_min });
        self.best = Hit::none(self.ray.last());
        let outside: Vec<u32> = self.world.scene.unbounded().map(|(shape, ..)| shape).collect();
        for shape in outside {
            let outcome = self.outcome(shape, false);
            self.steps.push(RayStep::Outside { shape, outcome });
        }
    }

    fn boxes<T: Nodes>(&mut self, tree: &T, node_idx: u32, t_max: f32, entered: u32, entries: &[f32]) {
        self.counters.inner_visits += 1;
        let slots = (0..T::WIDTH).map(|slot| (slot, tree.slot(node_idx, slot)));
        let filled = slots.filter(|(_, (child, _))| !child.is_empty());
        let mut waiting = Vec::new();
        let children: Vec<BoxTest> = filled
            .map(|(slot, (child, bounds))| {
                let entry = (entered >> slot & 1 != 0).then(|| entries[slot]);
                waiting.extend(entry.map(|entry| (entry, child)));
                let node = tree.node_id(child).expect("the slot is filled");
                BoxTest { node, bounds, entry }
            })
            .collect();
        self.counters.box_tests += children.len() as u64;
        self.steps.push(RayStep::Boxes { node: NodeId(node_idx), t_max, children });
        // The order of the walk: the nearest goes on, of equally near ones that with the smaller reference.
        waiting.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.0.cmp(&a.1.0)));
        waiting.pop();
        self.steps.extend(waiting.into_iter().map(|(entry, child)| RayStep::Push {
            node: tree.node_id(child).expect("the slot is filled"),
            entry,
        }));
    }

    fn leaf(&mut self, leaf_idx: u32) {
        self.counters.leaf_visits += 1;
        let node = NodeId(self.world.tree.inner_count() as u32 + leaf_idx);
        self.steps.push(RayStep::Leaf { node });
        let mut stopped_in = None;
        for (shape, test) in self.world.test_order(leaf_idx) {
            // A block of triangles is tested whole.
            let reached = stopped_in.is_none_or(|stopped| stopped == test);
            let outcome = if reached { self.outcome(shape, true) } else { Outcome::NotReached };
            if let Outcome::Stops { .. } = outcome {
                stopped_in = stopped_in.or(Some(test));
            }
            self.steps.push(RayStep::Shape { shape, outcome });
        }
    }

    /// What the test of a shape says in this walk, as far as it has come.
    fn outcome(&mut self, shape: u32, in_tree: bool) -> Outcome {
        let blocks = match self.query {
            RayQuery::Intersect | RayQuery::IntersectThrough(_) => return self.among_nearest(shape),
            RayQuery::Occluded => true,
            RayQuery::OccludedFiltered(rule) => self.world.blocks(shape, rule),
        };
        let triangle =
            in_tree && matches!(self.world.scene.shape(shape), crate::geometry::Shape::Triangle(_));
        if self.stopped && !triangle {
            return Outcome::NotReached;
        }
        if !blocks && !triangle {
            return Outcome::Skipped;
        }
        match self.world.hit_alone(&self.ray, shape) {
            None => Outcome::Missed,
            Some(hit) if !blocks => Outcome::LetsPass { t: hit.t },
            // The first of a block that is hit is the answer.
            Some(hit) if self.stopped => Outcome::Behind { t: hit.t },
            Some(hit) => {
                self.stopped = true;
                Outcome::Stops { t: hit.t }
            }
        }
    }

    fn among_nearest(&mut self, shape: u32) -> Outcome {
        let t_min = match &self.beyond {
            None => self.ray.t_min,
            Some(hit) if shape <= hit.shape => hit.t.next_up(),
            Some(hit) => hit.t,
        };
        match self.world.hit_alone(&Ray { t_min, ..self.ray }, shape) {
            None => Outcome::Missed,
            Some(hit) if self.best.is_beaten_by(hit.t, shape) => {
                self.best = hit;
                Outcome::Nearest { t: hit.t }
            }
            Some(hit) => Outcome::Behind { t: hit.t },
        }
    }
}

fn node_of(tree: &Tree, child: ChildRef) -> NodeId {
    each_width!(tree, t => t.node_id(child)).expect("only children wait")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec2;

    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::scene::{ShadowRule, builtin};
    use crate::task::Task;

    const QUERIES: [RayQuery; 4] = [
        RayQuery::Intersect,
        RayQuery::IntersectThrough(ShadowRule::GlassMirror),
        RayQuery::Occluded,
        RayQuery::OccludedFiltered(ShadowRule::Glass),
    ];

    fn answer(world: &World, ray: &Ray, query: RayQuery, counters: &mut RayCounters) -> Option<u32> {
        match query {
            RayQuery::Intersect => world.intersect(ray, counters).map(|hit| hit.shape),
            RayQuery::IntersectThrough(rule) => world.occluded_by_intersect(ray, rule, counters),
            RayQuery::Occluded => world.occluded(ray, counters),
            RayQuery::OccludedFiltered(rule) => world.occluded_filtered(ray, rule, counters),
        }
    }

    /// Steps must follow from one another, whatever was told.
    fn check(world: &World, history: &RayHistory) {
        let mut stack = Vec::new();
        let mut tested = 0;
        for step in &history.steps {
            match step {
                RayStep::Begin { .. } => stack.clear(),
                RayStep::Push { node, entry } => stack.push((*node, *entry)),
                RayStep::Pop { node, entry } | RayStep::Drop { node, entry, .. } => {
                    assert_eq!(stack.pop(), Some((*node, *entry)), "the order of the walk");
                }
                RayStep::Shape { outcome, .. } => tested += u64::from(outcome.is_tested()),
                RayStep::Boxes { node, children, .. } => {
                    assert!((node.0 as usize) < world.tree.inner_count() && !children.is_empty());
                }
                RayStep::Leaf { node } => assert!(world.tree.leaf_index(*node).is_some()),
                RayStep::Outside { .. } | RayStep::Stop { .. } | RayStep::Nearest { .. } | RayStep::Miss => {}
            }
        }
        assert_eq!(tested, history.counters.shape_tests, "{:?}", history.steps);
        assert_eq!(history.left_waiting(), stack.len());
        // Of the last walk: those before it ended at what lets light pass.
        let mut last = None;
        for step in &history.steps {
            match step {
                RayStep::Begin { .. } => last = None,
                RayStep::Shape { shape, outcome: Outcome::Nearest { .. } | Outcome::Stops { .. } }
                | RayStep::Outside { shape, outcome: Outcome::Nearest { .. } | Outcome::Stops { .. } } => {
                    last = Some(*shape);
                }
                _ => {}
            }
        }
        assert_eq!(last, history.answer, "what was found last is the answer");
    }

    #[test]
    fn a_recorded_ray_answers_and_counts_as_one_that_nobody_watches() {
        for name in ["bunny", "room", "cornell"] {
            let Ok(scene) = builtin::make(name) else { panic!("{name} is built in") };
            let scene = Arc::new(scene);
            for &(width, layout) in &BuildConfig::NODES {
                let builder = if width.get() == 2 { Builder::Spatial } else { Builder::Binned };
                let config = BuildConfig { width, layout, builder, leaf: 7, ..BuildConfig::default() };
                let world = World::build(Arc::clone(&scene), &config, &Task::new()).expect("nobody cancels");
                let frame = scene.camera.frame(40, 30);
                for i in 0..300 {
                    let pixel = Vec2::new((i * 7 % 40) as f32 + 0.5, (i * 11 % 30) as f32 + 0.5);
                    let mut ray = frame.ray(pixel);
                    if i % 3 == 0 {
                        ray.t_max = 4.0 + (i % 5) as f32;
                    }
                    for query in QUERIES {
                        let history = RayHistory::record(&world, &ray, query);
                        let mut counters = RayCounters::default();
                        let expected = answer(&world, &ray, query, &mut counters);
                        assert_eq!((history.answer, history.counters), (expected, counters), "{query:?}");
                        check(&world, &history);
                    }
                }
            }
        }
    }

    #[test]
    fn a_ray_beside_everything_makes_no_step() {
        let scene = Arc::new(builtin::make("cornell").expect("a built-in scene"));
        let world = World::build(Arc::clone(&scene), &BuildConfig::default(), &Task::new()).expect("built");
        let far = scene.bounds().max + 10.0;
        let history = RayHistory::record(&world, &Ray::new(far, glam::Vec3::ONE), RayQuery::Intersect);
        assert!(history.missed_root && history.answer.is_none());
        assert_eq!(history.steps.last(), Some(&RayStep::Miss));
        assert_eq!(history.counters, RayCounters::default());
    }
}
