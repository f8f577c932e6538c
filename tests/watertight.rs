//! No ray leaves a closed mesh: aimed exactly at shared vertices and edges, along axes, with zeros of both signs, at
//! every width and layout and every level of instructions.
//!
//! `BVHSCOPE_WATERTIGHT_RAYS` sets how many rays are shot in each mesh. The full run, some minutes long:
//!
//!     BVHSCOPE_WATERTIGHT_RAYS=10000000 cargo test --release --test watertight

#[path = "exchange/shapes_of_trees.rs"]
mod shapes_of_trees;

use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use rayon::prelude::*;

use bvhscope::accel::BuildConfig;
use bvhscope::accel::simd::SimdLevel;
use bvhscope::accel::{RawTree, Width};
use bvhscope::geometry::{Aabb, Ray, ShapeKind};
use bvhscope::scene::{Color, Material, MaterialKind, Mesh, Scene, ShapeSlot};
use bvhscope::task::Task;
use bvhscope::world::{Packets, TreeFile, World};
use shapes_of_trees::widened;

/// Rays in each mesh where the environment does not say how many: a few seconds without optimisation.
const DEFAULT_RAYS: usize = 60_000;
/// Rays that share a random stream, so that they are the same at any number of threads.
const CHUNK: usize = 1000;
/// 20 * 4^5 triangles.
const SUBDIVISIONS: usize = 5;
/// Largest difference of a hit's t from that of the point aimed at, in units of the distance: far from the origin the
/// point itself lies off its edge by rounding.
const T_TOLERANCE: f32 = 0.01;

/// A closed mesh around `center`. From every point within `inside` of it, every ray meets the mesh exactly once.
struct ClosedMesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    center: Vec3,
    inside: f32,
    /// A vertex and an axis along which it can be seen from inside.
    axis_targets: Vec<(Vec3, usize)>,
}

impl ClosedMesh {
    /// An icosphere whose vertices are moved at random, a third of them along their radius alone so that their zeros
    /// stay; stretched, then moved to `center`.
    fn displaced_icosphere(stretch: Vec3, center: Vec3) -> Self {
        let (sphere, triangles) = icosphere();
        let mut rng = Pcg32::seed_from_u64(1);
        let displace = |(i, p): (usize, &Vec3)| {
            let jitter = if i % 3 == 0 { Vec3::ZERO } else { vec(&mut rng, 0.006) };
            let waves = 0.1 * (3.0 * p.x + 1.0).sin() * (4.0 * p.y).cos() + 0.06 * (5.0 * p.z + p.x).sin();
            (*p + jitter) * (1.0 + waves + rng.random_range(-0.003..0.003)) * stretch + center
        };
        let positions: Vec<Vec3> = sphere.iter().enumerate().map(displace).collect();
        assert_closed(&triangles);
        let nearest_plane = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| (positions[i as usize] - center).as_dvec3());
                (b - a).cross(c - a).normalize_or(DVec3::NEG_ONE).dot(a) as f32
            })
            .fold(f32::INFINITY, f32::min);
        // Inside of all planes, so every triangle is seen from inside, and from its back.
        let inside = 0.9 * nearest_plane;
        assert!(inside > 0.1, "the mesh is bent too much: {nearest_plane}");
        let axis_targets = positions
            .iter()
            .flat_map(|&v| (0..3).map(move |axis| (v, axis)))
            .filter(|&(v, axis)| without(v - center, axis).length() < 0.9 * inside)
            .collect();
        Self { positions, triangles, center, inside, axis_targets }
    }

    fn scene(&self) -> Scene {
        let slot = |index| ShapeSlot { kind: ShapeKind::Triangle, index };
        let kind = MaterialKind::Diffuse { reflectivity: 0.0 };
        let material = Material { name: "matt".to_owned(), color: Color::Solid(Vec3::ONE), kind };
        Scene {
            name: "closed mesh".to_owned(),
            shapes: (0..self.triangles.len() as u32).map(slot).collect(),
            shape_materials: vec![0; self.triangles.len()],
            mesh: Mesh::flat(self.positions.clone(), &self.triangles),
            materials: Arc::new(vec![material]),
            ..Scene::default()
        }
    }

    fn vertex(&self, rng: &mut Pcg32) -> Vec3 {
        self.positions[rng.random_range(0..self.positions.len())]
    }

    /// On a shared edge, up to rounding: its middle, or anywhere.
    fn edge_point(&self, rng: &mut Pcg32) -> Vec3 {
        let triangle = self.triangles[rng.random_range(0..self.triangles.len())];
        let corner = rng.random_range(0..3);
        let [a, b] = [triangle[corner], triangle[(corner + 1) % 3]].map(|i| self.positions[i as usize]);
        let share = if rng.random() { 0.5 } else { rng.random_range(0.0..1.0) };
        a.lerp(b, share)
    }

    fn seam_point(&self, rng: &mut Pcg32) -> Vec3 {
        if rng.random() { self.vertex(rng) } else { self.edge_point(rng) }
    }

    /// Every sixteenth is the centre itself.
    fn inner_point(&self, rng: &mut Pcg32) -> Vec3 {
        let reach = if rng.random_range(0..16) == 0 { 0.0 } else { self.inside };
        // A cube that fits in the ball.
        self.center + vec(rng, 1.0) * (reach * 0.57)
    }
}

/// A ray from inside, and the t of the point of the mesh that it is aimed at, if it meets the mesh there first.
struct Shot {
    ray: Ray,
    target_t: Option<f32>,
}

impl Shot {
    /// From `origin` at `target`, with a direction of any length: powers of two, which round nothing.
    fn at(origin: Vec3, target: Vec3, rng: &mut Pcg32) -> Self {
        let scale = f32::powi(2.0, rng.random_range(-12..=12));
        // Where a component is zero, of either sign.
        let direction =
            (target - origin).to_array().map(|d| if d == 0.0 { signed_zero(rng) } else { d * scale });
        Self { ray: Ray::new(origin, Vec3::from_array(direction)), target_t: Some(scale.recip()) }
    }

    /// The kinds in turn.
    fn number(i: usize, mesh: &ClosedMesh, rng: &mut Pcg32) -> Self {
        match i % 6 {
            0 => Self::at(mesh.inner_point(rng), mesh.vertex(rng), rng),
            1 => Self::at(mesh.inner_point(rng), mesh.edge_point(rng), rng),
            2 => Self::along_an_axis(mesh, rng),
            3 | 4 => Self::across_an_axis(mesh, rng),
            _ => Self::from_the_wall(mesh, rng),
        }
    }

    /// Along an axis, exactly at a vertex.
    fn along_an_axis(mesh: &ClosedMesh, rng: &mut Pcg32) -> Self {
        let (target, axis) = mesh.axis_targets[rng.random_range(0..mesh.axis_targets.len())];
        let aside = without(target - mesh.center, axis).length();
        let reach = (mesh.inside * mesh.inside - aside * aside).sqrt();
        let mut origin = target;
        origin[axis] = mesh.center[axis] + reach * rng.random_range(-0.9..0.9);
        Self::at(origin, target, rng)
    }

    /// At a vertex or an edge, in a plane across an axis: one component of the direction is zero.
    fn across_an_axis(mesh: &ClosedMesh, rng: &mut Pcg32) -> Self {
        loop {
            let (target, mut origin) = (mesh.seam_point(rng), mesh.inner_point(rng));
            let axis = rng.random_range(0..3);
            origin[axis] = target[axis];
            if origin.distance(mesh.center) < mesh.inside {
                return Self::at(origin, target, rng);
            }
        }
    }

    /// From just inside the wall, so that many rays run flat along it. They may meet it anywhere.
    fn from_the_wall(mesh: &ClosedMesh, rng: &mut Pcg32) -> Self {
        let start = mesh.edge_point(rng);
        let origin = start.lerp(mesh.center, [0.002, 0.01, 0.1][rng.random_range(0..3)]);
        Self { target_t: None, ..Self::at(origin, mesh.seam_point(rng), rng) }
    }
}

/// One world for every width, layout and level of instructions.
fn worlds(mesh: &ClosedMesh) -> Vec<(BuildConfig, World)> {
    let scene = Arc::new(mesh.scene());
    let levels = SimdLevel::ALL.into_iter().filter(|level| *level != SimdLevel::Auto && level.is_available());
    let configs = levels.flat_map(|simd| {
        // More than one triangle a leaf, so that blocks are tested, full ones and others.
        BuildConfig::NODES.map(|(width, layout)| BuildConfig {
            width,
            layout,
            simd,
            leaf: 4,
            ..BuildConfig::default()
        })
    });
    let mut worlds: Vec<_> = configs
        .map(|config| {
            let world = World::build(Arc::clone(&scene), &config, &Task::new()).expect("nobody cancels");
            assert_eq!(world.simd_level(), config.simd);
            (config, world)
        })
        .collect();
    // And a tree of sixteen slots a node, which comes from elsewhere.
    let wide = worlds.iter().filter(|(config, _)| config.width == Width::W2).map(|(config, world)| {
        let file = TreeFile {
            path: "wide.npz".into(),
            name: "wide.npz".to_owned(),
            raw: widened(&RawTree::of(&world.tree), 16),
            triangle_count: None,
            content_hash: String::new(),
        };
        let world = World::with_tree(Arc::clone(&scene), Arc::new(file), config, &Task::new());
        let world = world.expect("nobody cancels");
        assert!(world.traced_file().is_some() && world.tree.width() == 16);
        (*config, world)
    });
    let wide: Vec<_> = wide.collect();
    worlds.extend(wide);
    worlds
}

fn check(shot: &Shot, world: &World, config: &BuildConfig) {
    let ray = &shot.ray;
    let hit = world.intersect(ray, &mut ());
    let hit = hit.unwrap_or_else(|| panic!("{ray:?} leaves the mesh with {config:?}"));
    assert!(world.occluded(ray, &mut ()).is_some(), "occluded: {ray:?} leaves the mesh with {config:?}");
    if let Some(target_t) = shot.target_t {
        let off = (hit.t - target_t).abs();
        assert!(off <= T_TOLERANCE * target_t, "{ray:?} misses its target with {config:?}: {hit:?}");
    }
}

/// What the rays of a packet that walk together have in common: the signs and the largest axis of their directions.
fn octant_and_axis(direction: Vec3) -> (u32, usize) {
    (direction.is_negative_bitmask(), direction.abs().max_position())
}

fn check_packets(rays: &[Ray], world: &World, config: &BuildConfig) {
    let mut packets = Packets::new(world).without_pauses();
    for (ray, hit) in rays.iter().zip(packets.intersect(rays)) {
        assert_eq!(*hit, world.intersect(ray, &mut ()), "in a packet {ray:?} goes astray with {config:?}");
    }
    for (ray, occluded) in rays.iter().zip(packets.occluded(rays)) {
        assert!(occluded, "in a packet occluded: {ray:?} leaves the mesh with {config:?}");
    }
}

fn check_mesh(mesh: &ClosedMesh) {
    assert!(mesh.axis_targets.len() > 1000, "only {}", mesh.axis_targets.len());
    let worlds = worlds(mesh);
    let chunks = ray_count().div_ceil(CHUNK);
    (0..chunks).into_par_iter().for_each(|chunk| {
        let mut rng = Pcg32::seed_from_u64(chunk as u64);
        let shots: Vec<Shot> = (0..CHUNK).map(|i| Shot::number(i, mesh, &mut rng)).collect();
        // Those that may walk together side by side.
        let mut rays: Vec<Ray> = shots.iter().map(|shot| shot.ray).collect();
        rays.sort_by_key(|ray| octant_and_axis(ray.direction));
        for (config, world) in &worlds {
            for shot in &shots {
                check(shot, world, config);
            }
            check_packets(&rays, world, config);
        }
    });
}

fn ray_count() -> usize {
    match std::env::var("BVHSCOPE_WATERTIGHT_RAYS") {
        Ok(text) => text.parse().expect("BVHSCOPE_WATERTIGHT_RAYS is a number of rays"),
        Err(_) => DEFAULT_RAYS,
    }
}

#[test]
fn no_ray_leaves_a_displaced_icosphere() {
    check_mesh(&ClosedMesh::displaced_icosphere(Vec3::ONE, Vec3::ZERO));
}

#[test]
fn no_ray_leaves_a_stretched_icosphere_far_from_the_origin() {
    check_mesh(&ClosedMesh::displaced_icosphere(Vec3::new(1.4, 0.8, 1.1), Vec3::new(1000.3, -77.7, 0.1)));
}

/// Vertices on the unit sphere, and triangles that turn counter-clockwise seen from outside. The twelve vertices that it
/// starts from lie in the planes between the axes.
fn icosphere() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 2.0 * (PI / 5.0).cos();
    let corner = |a: f32, b: f32| [Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)];
    let corners = [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)];
    let mut positions: Vec<Vec3> = corners.into_iter().flat_map(|(a, b)| corner(a, b)).collect();
    let mut triangles = nearest_triples(&positions);
    for p in &mut positions {
        *p = p.normalize();
    }
    for _ in 0..SUBDIVISIONS {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let quarters = triangles.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        triangles = quarters.collect();
    }
    (positions, triangles)
}

/// The faces of an icosahedron with edges of length 2.
fn nearest_triples(corners: &[Vec3]) -> Vec<[u32; 3]> {
    let is_edge = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 0.1;
    let mut faces = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for (k, &c) in corners.iter().enumerate().skip(j + 1) {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let outwards = (b - a).cross(c - a).dot(a) > 0.0;
                    let [j, k] = if outwards { [j, k] } else { [k, j] };
                    faces.push([i, j, k].map(|i| i as u32));
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    faces
}

/// Every edge is passed once in either direction.
fn assert_closed(triangles: &[[u32; 3]]) {
    let mut directed = HashSet::new();
    for t in triangles {
        for i in 0..3 {
            assert!(directed.insert([t[i], t[(i + 1) % 3]]), "an edge of {t:?} is passed twice");
        }
    }
    assert!(directed.iter().all(|[a, b]| directed.contains(&[*b, *a])));
}

fn vec(rng: &mut Pcg32, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

fn signed_zero(rng: &mut Pcg32) -> f32 {
    if rng.random() { 0.0 } else { -0.0 }
}

/// A vector without its part along an axis.
fn without(mut v: Vec3, axis: usize) -> Vec3 {
    v[axis] = 0.0;
    v
}
