//! The only place where a scene meets its trees: rays are asked here.
//!
//! Planes and the ground are outside the tree. Every query tests them before it walks the tree; they are no part of any
//! count. Hits at the same t go to the lowest shape index, so no answer of `intersect` depends on the tree.

mod best;
mod block;
mod blockers;
mod epo;
mod imported;
mod node_figure;
mod packet;
mod packets;
pub mod store;
mod watch;

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::Vec3;

use crate::accel::build::Onlooker;
use crate::accel::quality::TreeFigures;
use crate::accel::simd::{SimdLevel, SimdToken};
use crate::accel::{
    BuildConfig, BuildPhase, BuildReport, LeafIntersector, Probe, Shapes, Tree, Update, build_over,
    build_watched, refit, traverse, validate,
};
use crate::each_width;
use crate::geometry::{Aabb, Hit, PreparedRay, Ray, Shape};
use crate::scene::{Scene, ShadowRule};
use crate::task::{Cancelled, Task};

pub use store::PrimStore;

pub use best::Best;
use blockers::Blockers;
pub use epo::Epo;
pub use imported::{Imported, OtherScene, TreeFile};
pub use node_figure::NodeFigure;
pub use packets::Packets;
use store::Beyond;
pub use watch::{RayQuery, Watched};

/// A frozen scene with one tree over its bounded shapes. Immutable; share it behind an `Arc`.
#[derive(Debug)]
pub struct World {
    pub scene: Arc<Scene>,
    pub tree: Tree,
    /// Its phases end with `pack` (the shapes' geometry, in leaf order).
    pub report: BuildReport,
    pub figures: TreeFigures,
    /// The tree of a file that was asked for. It is `tree`, unless it has faults.
    pub imported: Option<Imported>,
    store: PrimStore,
    blockers: Blockers,
    epo: OnceLock<Option<Epo>>,
    simd: SimdToken,
}

impl World {
    /// Builds the tree that `config` describes over the scene's bounded shapes. In debug builds the tree is validated. With
    /// [`Update::Refit`] a scene that has moved gets the tree of its still scene, refitted; the phases are then those of the
    /// refit alone.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    ///
    /// # Panics
    /// If a shape's box is not finite (loaders remove such shapes), or `config` is out of range.
    pub fn build(scene: Arc<Scene>, config: &BuildConfig, task: &Task) -> Result<Self, Cancelled> {
        task.check()?;
        let (tree, report) = build_over(&BoundedShapes(built_over(&scene, config)), config, task)?;
        if scene.still.is_some() && config.update == Update::Refit {
            return Self::with_refitted(scene, &tree, report, task);
        }
        check_valid(&tree, &scene, config);
        Self::with_built(scene, tree, report, config, task)
    }

    /// The world of another moment of the same scene, by a refit of this world's tree: the same as [`World::of`] with the same
    /// configuration and file, in less time. `None` if trees are not to be refitted, or it is another scene or the still one.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn moved(&self, scene: &Arc<Scene>, task: &Task) -> Result<Option<Self>, Cancelled> {
        let own = self.scene.still.as_ref().unwrap_or(&self.scene);
        let is_same = scene.still.as_ref().is_some_and(|still| Arc::ptr_eq(still, own));
        let is_traced = self.imported.is_none() || self.traced_file().is_some();
        if !is_same || !is_traced || self.report.config.update != Update::Refit {
            return Ok(None);
        }
        let world = Self::with_refitted(Arc::clone(scene), &self.tree, self.report.clone(), task)?;
        Ok(Some(Self { imported: self.imported.clone(), ..world }))
    }

    /// The scene with a tree that was made for another moment of it.
    fn with_refitted(
        scene: Arc<Scene>,
        tree: &Tree,
        report: BuildReport,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let start = Instant::now();
        let tree = refit(tree, &BoundedShapes(&scene), task)?;
        let phase = BuildPhase { name: "refit", ms: elapsed_ms(start) };
        check_valid(&tree, &scene, &report.config);
        let config = report.config;
        let threads = rayon::current_num_threads();
        let report = BuildReport { build_ms: phase.ms, phases: vec![phase], threads, ..report };
        Self::with_built(scene, tree, report, &config, task)
    }

    /// As if some shapes were not there: for looking at what they hide. Shapes keep their indices. Lights shine on, also those
    /// whose shapes are hidden.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    ///
    /// # Panics
    /// As [`World::build`], and if `hidden` does not ascend.
    pub fn without(
        scene: Arc<Scene>,
        hidden: &[u32],
        config: &BuildConfig,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        assert!(hidden.is_sorted(), "hidden shapes ascend");
        task.check()?;
        let is_shown = |shape: &u32| hidden.binary_search(shape).is_err();
        let shown: Vec<u32> = (0..scene.shape_count() as u32).filter(is_shown).collect();
        let shapes = SomeShapes { all: BoundedShapes(&scene), shown: &shown };
        let (mut tree, report) = build_over(&shapes, config, task)?;
        each_width!(&mut tree, t => t.refs.iter_mut().for_each(|shape| *shape = shown[*shape as usize]));
        Self::with_built(scene, tree, report, config, task)
    }

    /// Builds the tree of a scene once more, with somebody who looks on; the world's own stays. Of a refitted tree it is the
    /// build at t = 0, over the boxes of [`World::build_scene`].
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn watch_build(&self, onlooker: Onlooker<'_>, task: &Task) -> Result<(), Cancelled> {
        build_watched(&BoundedShapes(self.build_scene()), &self.report.config, onlooker, task).map(|_| ())
    }

    /// The scene of the moment that the tree was built for: the world's own, unless the tree was refitted since.
    pub fn build_scene(&self) -> &Scene {
        built_over(&self.scene, &self.report.config)
    }

    /// The scene with a tree over its shapes.
    fn with_built(
        scene: Arc<Scene>,
        tree: Tree,
        mut report: BuildReport,
        config: &BuildConfig,
        task: &Task,
    ) -> Result<Self, Cancelled> {
        let start = Instant::now();
        let store = PrimStore::new(&scene, &tree, task)?;
        let pack_phase = BuildPhase { name: "pack", ms: elapsed_ms(start) };
        report.build_ms += pack_phase.ms;
        report.phases.push(pack_phase);
        let figures = TreeFigures::measure(&tree, config.traversal_cost, config.intersection_cost);
        let blockers = Blockers::new(&scene);
        Ok(Self {
            scene,
            tree,
            report,
            figures,
            imported: None,
            store,
            blockers,
            epo: OnceLock::new(),
            simd: SimdToken::of(config),
        })
    }

    /// Takes all figures, also those of rays that are counted from here on, under the costs `[C_t, C_i]` instead of those
    /// that the tree was built with.
    pub fn weigh(&mut self, [traversal_cost, intersection_cost]: [f32; 2]) {
        let config = &mut self.report.config;
        if [config.traversal_cost, config.intersection_cost] != [traversal_cost, intersection_cost] {
            (config.traversal_cost, config.intersection_cost) = (traversal_cost, intersection_cost);
            self.figures = TreeFigures::measure(&self.tree, traversal_cost, intersection_cost);
            self.epo = OnceLock::new();
        }
    }

    /// Tree and primitive store together, ready to trace, in bytes.
    pub fn bytes(&self) -> usize {
        self.tree.bytes() + self.store.bytes()
    }

    /// What its rays are traced with.
    pub fn simd_level(&self) -> SimdLevel {
        self.simd.level()
    }

    /// The leaves' geometry, for walks of the tree beyond the queries below.
    pub fn store(&self) -> &PrimStore {
        &self.store
    }

    /// The nearest hit in `t_min..=t_max`, planes and ground included.
    #[inline]
    pub fn intersect<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        self.nearest(ray, &self.store, |_| ray.t_min, probe)
    }

    /// Whether anything at all lies in `t_min..=t_max`: the shape that was found first.
    #[inline]
    pub fn occluded<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<u32> {
        self.any(ray, |_| true, probe)
    }

    /// Whether a shape lies in `t_min..=t_max` that blocks light under `rule`: the one that was found first. Spheres and
    /// other single shapes that let light pass are not even tested, and not counted.
    #[inline]
    pub fn occluded_filtered<P: Probe>(&self, ray: &Ray, rule: ShadowRule, probe: &mut P) -> Option<u32> {
        self.any(ray, self.blockers.under(rule), probe)
    }

    /// The same question answered by nearest hits: while the nearest hit's material lets light pass, goes on along the
    /// same ray by t, past that shape. The blocking shape, if there is one.
    ///
    /// The hits come in order of t and then of the shape index, each strictly after the one before: of shapes at the
    /// same t none is lost and none comes twice, and the search ends after as many steps as there are surfaces.
    pub fn occluded_by_intersect<P: Probe>(&self, ray: &Ray, rule: ShadowRule, probe: &mut P) -> Option<u32> {
        let blocks = self.blockers.under(rule);
        let mut hit = self.intersect(ray, probe)?;
        while !blocks(hit.shape) {
            let beyond = Beyond { store: &self.store, t: hit.t, shape: hit.shape };
            let rest = Ray { t_min: hit.t, ..*ray };
            hit = self.nearest(&rest, &beyond, |shape| beyond.t_min(shape), probe)?;
        }
        Some(hit.shape)
    }

    /// Keeps the nearest hit of what is outside the tree.
    #[inline]
    fn outside_nearest(&self, ray: &Ray, t_min: impl Fn(u32) -> f32, best: &mut Best<'_>) {
        for (index, plane, _) in self.scene.unbounded() {
            let answer = plane.intersect_within(&PreparedRay::new(*ray), t_min(index), best.t_max());
            best.keep(ray, index, answer);
        }
    }

    /// What is outside the tree and stops a ray.
    #[inline]
    fn outside_stops(&self, ray: &Ray, blocks: impl Fn(u32) -> bool) -> Option<u32> {
        let mut outside = self.scene.unbounded();
        let found = outside
            .find(|(index, plane, _)| blocks(*index) && plane.intersect(&PreparedRay::new(*ray)).is_some());
        found.map(|(index, ..)| index)
    }

    /// Compiled for every level of instructions, so not inlined.
    #[inline(never)]
    fn nearest<'a, L: LeafIntersector<Best<'a> = Best<'a>> + 'a, P: Probe>(
        &'a self,
        ray: &Ray,
        leaves: &'a L,
        t_min: impl Fn(u32) -> f32,
        probe: &mut P,
    ) -> Option<Hit> {
        let mut best = Best::new(Hit::none(ray.last()));
        self.outside_nearest(ray, t_min, &mut best);
        traverse::intersect(self.simd, &self.tree, leaves, ray, &mut best, probe);
        let hit = *best.exact(ray);
        hit.is_some().then_some(hit)
    }

    /// Compiled for every level of instructions, so not inlined.
    #[inline(never)]
    fn any<P: Probe>(&self, ray: &Ray, blocks: impl Fn(u32) -> bool, probe: &mut P) -> Option<u32> {
        let in_the_way = self.outside_stops(ray, &blocks);
        if in_the_way.is_some() {
            return in_the_way;
        }
        traverse::occluded(self.simd, &self.tree, &self.store, ray, &blocks, probe)
    }
}

/// The scene of the moment that a tree is built for.
fn built_over<'a>(scene: &'a Scene, config: &BuildConfig) -> &'a Scene {
    match config.update {
        Update::Rebuild => scene,
        Update::Refit => scene.still.as_deref().unwrap_or(scene),
    }
}

/// Holds a tree of ours to what is asked of all, in debug builds.
fn check_valid(tree: &Tree, scene: &Scene, config: &BuildConfig) {
    if cfg!(debug_assertions) {
        let violations = validate::validate(tree, &scene.shape_bounds());
        assert!(violations.is_empty(), "a tree with {config:?} is not valid: {violations:?}");
    }
}

/// Some of the shapes, by their place among those.
struct SomeShapes<'a> {
    all: BoundedShapes<'a>,
    shown: &'a [u32],
}

impl Shapes for SomeShapes<'_> {
    fn count(&self) -> usize {
        self.shown.len()
    }

    fn bounds(&self, shape: u32) -> Aabb {
        self.all.bounds(self.shown[shape as usize])
    }

    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
        self.all.bounds_between(self.shown[shape as usize], axis, from, to)
    }

    fn corners(&self, shape: u32) -> Option<[Vec3; 3]> {
        self.all.corners(self.shown[shape as usize])
    }

    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
        self.all.bounds_inside(self.shown[shape as usize], clip)
    }

    fn area_in_parts(&self, shape: u32) -> f32 {
        self.all.area_in_parts(self.shown[shape as usize])
    }
}

/// The shapes that a tree is built over.
struct BoundedShapes<'a>(&'a Scene);

impl Shapes for BoundedShapes<'_> {
    fn count(&self) -> usize {
        self.0.shape_count()
    }

    fn bounds(&self, shape: u32) -> Aabb {
        self.0.shape(shape).bounds()
    }

    fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
        self.0.shape(shape).bounds_between(axis, from, to)
    }

    fn corners(&self, shape: u32) -> Option<[Vec3; 3]> {
        match self.0.shape(shape) {
            Shape::Triangle(triangle) => Some(triangle.v),
            Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Quad(_) | Shape::Torus(_) => None,
        }
    }

    fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
        self.0.shape(shape).clipped_bounds(clip)
    }

    fn area_in_parts(&self, shape: u32) -> f32 {
        self.0.shape(shape).area_in_parts()
    }
}

fn elapsed_ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn a_refitted_tree_gives_the_hits_of_a_new_one_and_its_own_figures() {
        let still = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let moved = |time| Arc::new(still.at(time));
        let frame = still.camera.frame(24, 18);
        for &(width, layout) in &BuildConfig::NODES {
            let rebuild = BuildConfig { width, layout, ..BuildConfig::default() };
            let config = BuildConfig { update: Update::Refit, ..rebuild };
            let build = |scene, config| World::build(scene, config, &Task::new()).expect("built");
            let first = build(Arc::clone(&still), &config);
            assert_eq!(first.tree, build(Arc::clone(&still), &rebuild).tree, "nothing has moved yet");
            let [new, old] = [&rebuild, &config].map(|config| build(moved(1.6), config));
            assert_eq!(old.tree.refs(), first.tree.refs());
            assert_eq!(old.report.phases.iter().map(|p| p.name).collect::<Vec<_>>(), ["refit", "pack"]);
            let sah_cost = |world: &World| world.figures.sah_cost.expect("a cost").total();
            assert!(sah_cost(&old) > 1.02 * sah_cost(&new), "{} {}", sah_cost(&old), sah_cost(&new));
            for (x, y) in (0..24).flat_map(|x| (0..18).map(move |y| (x as f32 + 0.5, y as f32 + 0.5))) {
                let ray = frame.ray(glam::Vec2::new(x, y));
                assert_eq!(old.intersect(&ray, &mut ()), new.intersect(&ray, &mut ()));
            }
            // From whichever moment it is moved, it is the same tree.
            for before in [&first, &build(moved(0.4), &config)] {
                let world =
                    before.moved(&moved(1.6), &Task::new()).expect("not cancelled").expect("refitted");
                assert_eq!(world.tree, old.tree);
            }
            let refused = |world: &World, to: &Arc<Scene>| {
                world.moved(to, &Task::new()).expect("not cancelled").is_none()
            };
            assert!(refused(&old, &still), "the still scene has the tree that was built");
            assert!(refused(&new, &moved(0.3)), "the configuration asks for new trees");
            let other = Arc::new(builtin::make("room").expect("a built-in scene"));
            assert!(refused(&old, &Arc::new(other.at(1.0))));
        }
    }

    #[test]
    fn rays_go_through_what_is_hidden() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let all = World::build(Arc::clone(&scene), &BuildConfig::default(), &Task::new()).expect("built");
        let frame = scene.camera.frame(24, 18);
        for &(width, layout) in &BuildConfig::NODES {
            let config = BuildConfig { width, layout, ..BuildConfig::default() };
            let hidden: Vec<u32> = (0..scene.shape_count() as u32).filter(|shape| shape % 3 != 0).collect();
            let some = World::without(Arc::clone(&scene), &hidden, &config, &Task::new()).expect("built");
            for (x, y) in (0..24).flat_map(|x| (0..18).map(move |y| (x as f32 + 0.5, y as f32 + 0.5))) {
                let ray = frame.ray(glam::Vec2::new(x, y));
                let hit = some.intersect(&ray, &mut ());
                assert!(hit.is_none_or(|hit| hit.shape % 3 == 0), "{hit:?}");
                let first = all.intersect(&ray, &mut ()).filter(|hit| hit.shape % 3 == 0);
                assert!(first.is_none() || hit == first, "what was seen before is seen still");
            }
        }
        let none: Vec<u32> = (0..scene.shape_count() as u32).collect();
        let empty = World::without(scene, &none, &BuildConfig::default(), &Task::new()).expect("built");
        assert_eq!(empty.tree.node_count(), 0);
    }
}
