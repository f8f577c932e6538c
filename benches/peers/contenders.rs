//! Every library with every kind of tree that is measured, behind one interface: triangles in, a tree that answers rays
//! out. What a library wants its triangles to look like beforehand is made before the clock starts; what it does to walk
//! the tree faster, such as ordering the triangles, is part of the build.

use std::time::{Duration, Instant};

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvhscope::accel::{Block, BuildConfig, Builder, Improver, Widen, Width};
use bvhscope::geometry::Ray;
use bvhscope::render::bench::{Query, RaySet};
use bvhscope::task::Task;
use bvhscope::world::World;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::triangle::Triangle;
use parry3d::query::RayCast;
use parry3d::shape::TriMesh;

use super::inputs::Input;

/// A library with one kind of tree.
pub struct Contender {
    name: &'static str,
    build: fn(&Input) -> Built,
}

pub struct Built {
    pub build_ms: f64,
    pub walker: Box<dyn Walker>,
}

/// A tree that answers rays.
pub trait Walker {
    /// Answers as those of `bvhscope bench`: t, infinity for a miss; for `occluded` 1 or 0.
    fn trace(&self, set: &RaySet, answers: &mut [f32]);
}

impl Contender {
    pub fn name(&self) -> &'static str {
        self.name
    }

    pub fn build(&self, input: &Input) -> Built {
        (self.build)(input)
    }
}

/// This program's 8-wide tree, as `--width 8 --leaf 4 --widen collapse`: what the others are compared with.
pub fn reference() -> Contender {
    let build = |input: &Input| {
        let wide = BuildConfig {
            width: Width::W8,
            leaf: 4,
            widen: Widen::Collapse,
            block: Block::B4,
            ..BuildConfig::default()
        };
        ours(input, &wide)
    };
    Contender { name: "bvhscope 8-wide", build }
}

/// The first is [`reference`].
pub fn all() -> Vec<Contender> {
    let contender = |name, build| Contender { name, build };
    vec![
        reference(),
        contender("bvhscope binary", |input| {
            ours(input, &BuildConfig { width: Width::W2, ..BuildConfig::default() })
        }),
        contender("bvhscope binary, ploc", |input| {
            ours(input, &BuildConfig { width: Width::W2, builder: Builder::Ploc, ..BuildConfig::default() })
        }),
        contender("bvhscope binary, binned, reinsertion", |input| {
            let improver = Improver::Reinsertion;
            ours(input, &BuildConfig { width: Width::W2, improver, ..BuildConfig::default() })
        }),
        contender("obvhs binary, fast", |input| obvhs_binary(input, BvhBuildParams::fast_build())),
        contender("obvhs binary, fastest", |input| obvhs_binary(input, BvhBuildParams::fastest_build())),
        contender("obvhs binary, medium", |input| obvhs_binary(input, BvhBuildParams::medium_build())),
        contender("obvhs binary, very slow", |input| obvhs_binary(input, BvhBuildParams::very_slow_build())),
        contender("obvhs 8-wide, fast", |input| obvhs_wide(input, BvhBuildParams::fast_build())),
        contender("obvhs 8-wide, medium", |input| obvhs_wide(input, BvhBuildParams::medium_build())),
        contender("bvh", bvh_crate),
        contender("parry3d TriMesh", parry),
    ]
}

fn timed<T>(build: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let built = build();
    (start.elapsed().as_secs_f64() * 1e3, built)
}

fn answer(set: &RaySet, answers: &mut [f32], nearest: impl Fn(&Ray) -> f32, any: impl Fn(&Ray) -> bool) {
    let rays = set.rays.iter().zip(answers);
    match set.query {
        Query::Intersect => rays.for_each(|(ray, answer)| *answer = nearest(ray)),
        Query::Occluded => rays.for_each(|(ray, answer)| *answer = f32::from(u8::from(any(ray)))),
    }
}

// ---- this program

/// The build time is the one that the program reports, from the scene to rays, on one thread.
fn ours(input: &Input, config: &BuildConfig) -> Built {
    let scene = input.scene();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let world = one.install(|| World::build(scene, config, &Task::new())).expect("nobody cancels");
    Built { build_ms: world.report.build_ms, walker: Box::new(world) }
}

impl Walker for World {
    fn trace(&self, set: &RaySet, answers: &mut [f32]) {
        let nearest = |ray: &Ray| self.intersect(ray, &mut ()).map_or(f32::INFINITY, |hit| hit.t);
        answer(set, answers, nearest, |ray| self.occluded(ray, &mut ()).is_some());
    }
}

// ---- obvhs, with its own triangles in leaf order, as its examples do

struct Obvhs<T> {
    tree: T,
    triangles: Vec<Triangle>,
}

fn obvhs_binary(input: &Input, params: BvhBuildParams) -> Built {
    let triangles = obvhs_triangles(input);
    let (build_ms, walker) = timed(|| {
        let tree = build_bvh2_from_tris(&triangles, params, &mut Duration::default());
        Obvhs { triangles: in_leaf_order(&triangles, &tree.primitive_indices), tree }
    });
    Built { build_ms, walker: Box::new(walker) }
}

fn obvhs_wide(input: &Input, params: BvhBuildParams) -> Built {
    let triangles = obvhs_triangles(input);
    let (build_ms, walker) = timed(|| {
        let tree = build_cwbvh_from_tris(&triangles, params, &mut Duration::default());
        Obvhs { triangles: in_leaf_order(&triangles, &tree.primitive_indices), tree }
    });
    Built { build_ms, walker: Box::new(walker) }
}

fn obvhs_triangles(input: &Input) -> Vec<Triangle> {
    let triangle = |v: &[Vec3; 3]| Triangle { v0: v[0].into(), v1: v[1].into(), v2: v[2].into() };
    input.triangles.iter().map(triangle).collect()
}

fn in_leaf_order(triangles: &[Triangle], primitive_indices: &[u32]) -> Vec<Triangle> {
    primitive_indices.iter().map(|&i| triangles[i as usize]).collect()
}

fn obvhs_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(Vec3A::from(ray.origin), Vec3A::from(ray.direction), ray.t_min, ray.t_max)
}

impl Walker for Obvhs<Bvh2> {
    fn trace(&self, set: &RaySet, answers: &mut [f32]) {
        let test = |ray: &obvhs::ray::Ray, i: usize| self.triangles[i].intersect(ray);
        let nearest = |ray: &Ray| {
            let mut hit = obvhs::ray::RayHit::none();
            // Of a miss, hit.t may be the ray's t_max.
            if self.tree.ray_traverse(obvhs_ray(ray), &mut hit, test) { hit.t } else { f32::INFINITY }
        };
        answer(set, answers, nearest, |ray| !self.tree.ray_traverse_miss(obvhs_ray(ray), test));
    }
}

impl Walker for Obvhs<CwBvh> {
    fn trace(&self, set: &RaySet, answers: &mut [f32]) {
        let test = |ray: &obvhs::ray::Ray, i: usize| self.triangles[i].intersect(ray);
        let nearest = |ray: &Ray| {
            let mut hit = obvhs::ray::RayHit::none();
            // Of a miss, hit.t may be the ray's t_max.
            if self.tree.ray_traverse(obvhs_ray(ray), &mut hit, test) { hit.t } else { f32::INFINITY }
        };
        answer(set, answers, nearest, |ray| !self.tree.ray_traverse_miss(obvhs_ray(ray), test));
    }
}

// ---- bvh, which leaves the shapes to its user; its own triangle test sees front faces only

struct BvhShape {
    v: [Vec3; 3],
    bounds: Aabb<f32, 3>,
    node_idx: usize,
}

impl Bounded<f32, 3> for BvhShape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for BvhShape {
    fn set_bh_node_index(&mut self, node_idx: usize) {
        self.node_idx = node_idx;
    }

    fn bh_node_index(&self) -> usize {
        self.node_idx
    }
}

struct BvhCrate {
    tree: bvh::bvh::Bvh<f32, 3>,
    shapes: Vec<BvhShape>,
}

fn bvh_crate(input: &Input) -> Built {
    let shape = |v: &[Vec3; 3]| {
        let [a, b, c] = *v;
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        let bounds = Aabb::with_bounds(min.to_array().into(), max.to_array().into());
        BvhShape { v: *v, bounds, node_idx: 0 }
    };
    let mut shapes: Vec<BvhShape> = input.triangles.iter().map(shape).collect();
    let (build_ms, tree) = timed(|| bvh::bvh::Bvh::build(&mut shapes));
    Built { build_ms, walker: Box::new(BvhCrate { tree, shapes }) }
}

impl Walker for BvhCrate {
    fn trace(&self, set: &RaySet, answers: &mut [f32]) {
        let bvh_ray =
            |ray: &Ray| bvh::ray::Ray::new(ray.origin.to_array().into(), ray.direction.to_array().into());
        let nearest = |ray: &Ray| {
            let (mut t, by_distance) = (f32::INFINITY, bvh_ray(ray));
            // The shapes come in the order in which the ray enters their boxes, without end at a hit.
            for shape in self.tree.nearest_traverse_iterator(&by_distance, &self.shapes) {
                match by_distance.intersection_slice_for_aabb(&shape.bounds) {
                    Some((enter, _)) if enter <= t.min(ray.t_max) => {
                        t = t.min(moeller_trumbore(&shape.v, ray))
                    }
                    _ => break,
                }
            }
            t
        };
        let any = |ray: &Ray| {
            let bvh_ray = bvh_ray(ray);
            let mut met = self.tree.traverse_iterator(&bvh_ray, &self.shapes);
            met.any(|shape| moeller_trumbore(&shape.v, ray) < f32::INFINITY)
        };
        answer(set, answers, nearest, any);
    }
}

/// From both sides; infinity for a miss (Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
#[inline]
fn moeller_trumbore(v: &[Vec3; 3], ray: &Ray) -> f32 {
    let (edge_1, edge_2) = (v[1] - v[0], v[2] - v[0]);
    let p = ray.direction.cross(edge_2);
    let inv_det = edge_1.dot(p).recip();
    let from_corner = ray.origin - v[0];
    let u = from_corner.dot(p) * inv_det;
    let q = from_corner.cross(edge_1);
    let w = ray.direction.dot(q) * inv_det;
    let t = edge_2.dot(q) * inv_det;
    // False for NaN, which a ray in the triangle's plane gives.
    if u >= 0.0 && w >= 0.0 && u + w <= 1.0 && t >= ray.t_min && t <= ray.t_max { t } else { f32::INFINITY }
}

// ---- parry3d, which has no query for any hit but asks for the nearest

fn parry(input: &Input) -> Built {
    let vertex = |v: &Vec3| parry3d::math::Vector::new(v.x, v.y, v.z);
    let vertices = input.triangles.iter().flatten().map(vertex).collect();
    let indices = (0..input.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let (build_ms, mesh) = timed(|| TriMesh::new(vertices, indices).expect("there are triangles"));
    Built { build_ms, walker: Box::new(mesh) }
}

impl Walker for TriMesh {
    fn trace(&self, set: &RaySet, answers: &mut [f32]) {
        let cast = |ray: &Ray| {
            let [o, d] = [ray.origin, ray.direction].map(|v| parry3d::math::Vector::new(v.x, v.y, v.z));
            // Infinity times zero would be NaN there.
            self.cast_local_ray(&parry3d::query::Ray::new(o, d), ray.t_max.min(f32::MAX), false)
        };
        answer(set, answers, |ray| cast(ray).unwrap_or(f32::INFINITY), |ray| cast(ray).is_some());
    }
}
