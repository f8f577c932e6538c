//! Every builder, width, way of widening and query against testing every shape, on random and degenerate scenes: the
//! same shape at the same t, to the last bit, whatever the tree.

#[path = "exchange/shapes_of_trees.rs"]
mod shapes_of_trees;

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3, Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use bvhscope::accel::simd::SimdLevel;
use bvhscope::accel::{BuildConfig, Builder, Layout, RawTree, RayCounters, StopRule, Widen, Width, validate};
use bvhscope::geometry::{
    Aabb, Cuboid, Hit, Plane, PreparedRay, Quad, Ray, Rigid, Shape, ShapeHit, ShapeKind, Sphere, Torus,
    Triangle,
};
use bvhscope::scene::{Color, Material, MaterialKind, MeshTriangle, Scene, ShadowRule, ShapeSlot};
use bvhscope::task::Task;
use bvhscope::world::{Packets, TreeFile, World};
use shapes_of_trees::{list, widened};

/// Materials of every test scene, by index.
const DIFFUSE: u32 = 0;
const GLASS: u32 = 1;
const MIRROR: u32 = 2;
const EMISSIVE: u32 = 3;
const MATERIALS: u32 = 4;

fn materials() -> Arc<Vec<Material>> {
    let kinds = [
        MaterialKind::Diffuse { reflectivity: 0.0 },
        MaterialKind::Glass { ior: 1.5, absorption: Vec3::ZERO },
        MaterialKind::Mirror,
        MaterialKind::Emissive { radiance: Vec3::ONE },
    ];
    let named = |kind| Material { name: "test".to_owned(), color: Color::Solid(Vec3::ONE), kind };
    Arc::new(kinds.map(named).to_vec())
}

fn empty_scene(name: &str) -> Scene {
    Scene { name: name.to_owned(), materials: materials(), ..Scene::default() }
}

fn scene_of(name: &str, shapes: impl IntoIterator<Item = (Shape, u32)>) -> Scene {
    let mut scene = empty_scene(name);
    for (shape, material) in shapes {
        add(&mut scene, shape, material);
    }
    scene
}

fn add(scene: &mut Scene, shape: Shape, material: u32) {
    let index = match shape {
        Shape::Triangle(triangle) => {
            let first = scene.mesh.positions.len() as u32;
            scene.mesh.positions.extend(triangle.v);
            let none = [MeshTriangle::NO_INDEX; 3];
            let position = [first, first + 1, first + 2];
            scene.mesh.triangles.push(MeshTriangle { position, normal: none, uv: none });
            scene.mesh.triangles.len()
        }
        Shape::Sphere(sphere) => push(&mut scene.spheres, sphere),
        Shape::Cuboid(cuboid) => push(&mut scene.cuboids, cuboid),
        Shape::Quad(quad) => push(&mut scene.quads, quad),
        Shape::Torus(torus) => push(&mut scene.tori, torus),
    } - 1;
    scene.shapes.push(ShapeSlot { kind: shape.kind(), index: index as u32 });
    scene.shape_materials.push(material);
}

fn push<T>(all: &mut Vec<T>, element: T) -> usize {
    all.push(element);
    all.len()
}

fn vec(rng: &mut Pcg32, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

/// A point of a coarse grid: origins, faces and vertices of different shapes coincide.
fn grid_point(rng: &mut Pcg32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-4..=4) as f32 * 0.5))
}

fn triangle(v: [Vec3; 3]) -> Shape {
    Shape::Triangle(Triangle { v })
}

fn random_shape(rng: &mut Pcg32, kind: ShapeKind) -> Shape {
    let center = vec(rng, 3.0);
    let turn = Quat::from_scaled_axis(vec(rng, 3.0));
    let world_from_object = Rigid::new(turn, center);
    match kind {
        ShapeKind::Triangle => triangle(std::array::from_fn(|_| center + vec(rng, 0.8))),
        ShapeKind::Sphere => Shape::Sphere(Sphere { center, radius: rng.random_range(0.05..0.6) }),
        ShapeKind::Cuboid => {
            Shape::Cuboid(Cuboid { world_from_object, half_extent: vec(rng, 0.5).abs() + 0.01 })
        }
        ShapeKind::Quad => Shape::Quad(Quad { corner: center, edge_u: vec(rng, 1.0), edge_v: vec(rng, 1.0) }),
        ShapeKind::Torus => Shape::Torus(Torus {
            world_from_object,
            major_radius: rng.random_range(0.2..0.7),
            minor_radius: rng.random_range(0.02..0.2),
        }),
    }
}

/// All five kinds, all materials, a plane and a ground.
fn mixed(seed: u64, count: usize) -> Scene {
    let mut rng = Pcg32::seed_from_u64(seed);
    let shapes: Vec<(Shape, u32)> = (0..count)
        .map(|i| (random_shape(&mut rng, ShapeKind::ALL[i % 5]), rng.random_range(0..MATERIALS)))
        .collect();
    let mut scene = scene_of("mixed", shapes);
    scene.planes.push((Plane { normal: Vec3::X, offset: -3.0 }, GLASS));
    scene.ground = Some((Plane { normal: Vec3::Y, offset: -2.5 }, DIFFUSE));
    scene
}

/// Triangles, quads and cuboids in the same few planes, many of them in exactly the same place.
fn coplanar() -> Scene {
    let mut scene = empty_scene("coplanar");
    for i in 0..36 {
        let corner = Vec3::new((i % 6) as f32 * 0.5 - 1.5, (i / 6) as f32 * 0.5 - 1.5, 0.0);
        let (u, v) = (Vec3::X * 0.5, Vec3::Y * 0.5);
        let material = i % MATERIALS;
        add(&mut scene, triangle([corner, corner + u, corner + v]), material);
        add(&mut scene, triangle([corner + u, corner + u + v, corner + v]), DIFFUSE);
        if i % 3 == 0 {
            add(&mut scene, Shape::Quad(Quad { corner, edge_u: u, edge_v: v }), (material + 1) % MATERIALS);
        }
        if i % 4 == 0 {
            let center = corner + (u + v) * 0.5 - Vec3::Z * 0.25;
            let world_from_object = Rigid::new(Quat::IDENTITY, center);
            let cuboid = Cuboid { world_from_object, half_extent: Vec3::splat(0.25) };
            add(&mut scene, Shape::Cuboid(cuboid), GLASS);
        }
    }
    scene
}

/// The same triangles again and again, and glass around and at the same place as what blocks.
fn identical() -> Scene {
    let mut scene = empty_scene("identical");
    let v = [Vec3::new(-1.0, -1.0, 0.3), Vec3::new(1.0, -1.0, -0.2), Vec3::new(0.0, 1.0, 0.1)];
    for i in 0..30 {
        add(&mut scene, triangle(v), if i % 10 == 7 { DIFFUSE } else { GLASS });
        add(&mut scene, Shape::Sphere(Sphere { center: Vec3::X, radius: 1.0 }), [MIRROR, GLASS][i % 2]);
    }
    add(&mut scene, Shape::Sphere(Sphere { center: Vec3::X, radius: 1.0 }), EMISSIVE);
    scene
}

/// Points, segments and slivers among a few real triangles; some flat in an axis-aligned plane.
fn degenerate() -> Scene {
    let mut rng = Pcg32::seed_from_u64(3);
    let mut scene = empty_scene("degenerate");
    for i in 0..80 {
        let (a, b) = (grid_point(&mut rng), grid_point(&mut rng));
        let shape = match i % 5 {
            0 => triangle([a, a, a]),
            1 => triangle([a, b, b]),
            2 => triangle([a, b, a + (b - a) * 0.5]),
            3 => triangle([a, b, a + (b - a) * 0.5 + vec(&mut rng, 1e-5)]),
            _ => triangle([a, b, grid_point(&mut rng)]),
        };
        add(&mut scene, shape, i % MATERIALS);
    }
    let flat = Quad { corner: Vec3::ZERO, edge_u: Vec3::X, edge_v: Vec3::X * 2.0 };
    add(&mut scene, Shape::Quad(flat), DIFFUSE);
    add(&mut scene, Shape::Sphere(Sphere { center: Vec3::ONE, radius: 0.0 }), DIFFUSE);
    let half_extent = Vec3::new(0.5, 0.0, 0.5);
    add(&mut scene, Shape::Cuboid(Cuboid { world_from_object: Rigid::IDENTITY, half_extent }), GLASS);
    scene
}

/// Long thin triangles across the whole scene, crossing each other.
fn slivers() -> Scene {
    let mut rng = Pcg32::seed_from_u64(4);
    let shapes: Vec<(Shape, u32)> = (0..150)
        .map(|_| {
            let (a, along) = (vec(&mut rng, 3.0), vec(&mut rng, 4.0));
            let shape = triangle([a, a + along, a + along * 0.5 + vec(&mut rng, 0.02)]);
            (shape, rng.random_range(0..MATERIALS))
        })
        .collect();
    scene_of("slivers", shapes)
}

fn scenes() -> Vec<Scene> {
    let mut rng = Pcg32::seed_from_u64(2);
    let mut all = vec![mixed(1, 150), coplanar(), identical(), degenerate(), slivers(), empty_scene("empty")];
    for kind in ShapeKind::ALL {
        all.push(scene_of(kind.name(), [(random_shape(&mut rng, kind), GLASS)]));
    }
    let mut plane_alone = empty_scene("a plane alone");
    plane_alone.planes.push((Plane { normal: Vec3::Z, offset: 0.0 }, MIRROR));
    all.push(plane_alone);
    all
}

/// Every builder, width, layout and way of widening, at small and large leaves, with shapes whole and cut in advance.
fn configs() -> Vec<BuildConfig> {
    let mut all = Vec::new();
    for builder in Builder::ALL {
        for (width, layout) in BuildConfig::NODES {
            for widen in Widen::ALL {
                for (leaf, stop, pre_split) in [
                    (2, StopRule::Limit, 0.0),
                    (1, StopRule::Cost, 0.0),
                    (11, StopRule::Cost, 0.0),
                    (2, StopRule::Limit, 0.6),
                ] {
                    let config =
                        BuildConfig { builder, width, layout, widen, leaf, stop, ..BuildConfig::default() };
                    if width != Width::W2 || widen == Widen::Split {
                        all.push(BuildConfig { pre_split, ..config });
                    }
                }
            }
        }
    }
    all
}

fn build(scene: &Arc<Scene>, config: &BuildConfig) -> World {
    let world = World::build(Arc::clone(scene), config, &Task::new()).expect("nobody cancels");
    let violations = validate::validate(&world.tree, &scene.shape_bounds());
    assert!(violations.is_empty(), "'{}' with {config:?}: {violations:?}", scene.name);
    world
}

/// Random rays; rays between points of the grid; rays along axes, with zeros of both signs; rays at shapes and at the
/// corners of their boxes, and along shapes; rays that start on surfaces; and some that end early or begin late.
fn rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let mut rng = Pcg32::seed_from_u64(5);
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut rays = Vec::with_capacity(count);
    for i in 0..count {
        let mut ray = match i % 8 {
            0 => Ray::new(vec(&mut rng, 4.0), vec(&mut rng, 1.0)),
            1 => Ray::new(grid_point(&mut rng) * 3.0, grid_point(&mut rng)),
            2 => Ray::new(grid_point(&mut rng), axes[rng.random_range(0..6)]),
            3 => Ray::new(vec(&mut rng, 2.0), axes[rng.random_range(0..6)] * 0.7),
            // At a corner or an edge of a shape's box, from a point of the grid.
            4 if scene.shape_count() > 0 => {
                let bounds = scene.shape(rng.random_range(0..scene.shape_count() as u32)).bounds();
                let origin = grid_point(&mut rng) * 2.0;
                Ray::new(origin, bounds.corners()[rng.random_range(0..8)] - origin)
            }
            5 | 6 if scene.shape_count() > 0 => {
                let shape = scene.shape(rng.random_range(0..scene.shape_count() as u32));
                let mut point = || shape.sample(Vec2::new(rng.random(), rng.random())).position;
                let (p, q) = (point(), point());
                // Every other one along the shape, in its plane if it has one.
                let origin = if i % 2 == 0 { p + (p - q) * 3.0 } else { vec(&mut rng, 4.0) };
                Ray::new(origin, q - origin)
            }
            _ => {
                // From a surface: the first hit of another ray, moved not at all.
                let from = Ray::new(vec(&mut rng, 4.0), vec(&mut rng, 1.0));
                let start = nearest(scene, &from, |_| true).map_or(from.origin, |hit| from.at(hit.t));
                Ray::new(start, vec(&mut rng, 1.0))
            }
        };
        if i % 4 == 1 {
            ray.t_max = rng.random_range(0.1..4.0);
        }
        if i % 5 == 2 {
            ray.t_min = rng.random_range(0.0..1.0);
        }
        rays.push(ray);
    }
    rays
}

/// The oracle: every shape, plane and ground for which `asked` holds.
fn nearest(scene: &Scene, ray: &Ray, asked: impl Fn(u32) -> bool) -> Option<Hit> {
    let ray = PreparedRay::new(*ray);
    let bounded = (0..scene.shape_count() as u32).map(|i| (i, scene.shape(i).intersect(&ray)));
    let unbounded = scene.unbounded().map(|(i, plane, _)| (i, plane.intersect(&ray)));
    let mut best = Hit::none(f32::INFINITY);
    for (shape, answer) in bounded.chain(unbounded) {
        if let Some(ShapeHit { t, u, v }) = answer
            && asked(shape)
            && best.is_beaten_by(t, shape)
        {
            best = Hit { t, shape, u, v };
        }
    }
    best.is_some().then_some(best)
}

/// What each query must answer to a ray.
struct Expected {
    ray: Ray,
    hit: Option<Hit>,
    /// The nearest that blocks, by rule.
    blocking: [Option<Hit>; ShadowRule::ALL.len()],
}

fn expected(scene: &Scene, ray: Ray) -> Expected {
    let blocking = ShadowRule::ALL
        .map(|rule| nearest(scene, &ray, |shape| !scene.material(shape).lets_light_pass(rule)));
    Expected { ray, hit: nearest(scene, &ray, |_| true), blocking }
}

fn check(world: &World, expected: &Expected, context: &str) {
    let Expected { ray, hit, blocking } = expected;
    let scene = &world.scene;
    assert_eq!(world.intersect(ray, &mut ()), *hit, "intersect {ray:?} {context}");
    let any = world.occluded(ray, &mut ());
    assert_eq!(any.is_some(), hit.is_some(), "occluded {ray:?} {context}");
    let is_hit = |shape: u32| nearest(scene, ray, |s| s == shape).is_some();
    assert!(any.is_none_or(is_hit), "occluded by {any:?}, which {ray:?} does not hit, {context}");
    for (rule, nearest_blocking) in ShadowRule::ALL.into_iter().zip(blocking) {
        let filtered = world.occluded_filtered(ray, rule, &mut ());
        assert_eq!(filtered.is_some(), nearest_blocking.is_some(), "filtered {rule:?} {ray:?} {context}");
        let blocks = |shape: u32| !scene.material(shape).lets_light_pass(rule);
        assert!(filtered.is_none_or(|s| blocks(s) && is_hit(s)), "filtered {filtered:?} {ray:?} {context}");
        let by_intersect = world.occluded_by_intersect(ray, rule, &mut ());
        assert_eq!(
            by_intersect,
            nearest_blocking.map(|h| h.shape),
            "by intersect {rule:?} {ray:?} {context}"
        );
    }
}

#[test]
fn every_tree_answers_every_query_as_testing_every_shape_does() {
    for scene in scenes() {
        let scene = Arc::new(scene);
        let expected: Vec<Expected> =
            rays(&scene, 400).into_iter().map(|ray| expected(&scene, ray)).collect();
        let hits = expected.iter().filter(|e| e.hit.is_some()).count();
        assert!(hits > 15 || scene.name == "empty", "only {hits} rays hit '{}'", scene.name);
        for config in configs() {
            let world = build(&scene, &config);
            for e in &expected {
                check(&world, e, &format!("in '{}' with {config:?}", scene.name));
            }
        }
    }
}

/// Trees from elsewhere: sixteen slots a node, and lists, at every level of instructions, rays alone and in packets.
#[test]
fn imported_trees_answer_every_query_as_testing_every_shape_does() {
    let levels = || SimdLevel::ALL.into_iter().filter(|level| level.is_available());
    for scene in scenes() {
        let scene = Arc::new(scene);
        let expected: Vec<Expected> =
            rays(&scene, 300).into_iter().map(|ray| expected(&scene, ray)).collect();
        let mut all = coherent_rays(&scene);
        all.truncate(3000);
        let binary = build(&scene, &BuildConfig { width: Width::W2, leaf: 1, ..BuildConfig::default() });
        let boxes = scene.shape_bounds();
        let mut trees = vec![("wide", widened(&RawTree::of(&binary.tree), 16))];
        if boxes.len() > 1 {
            trees.push(("list", list(&boxes)));
        }
        for ((name, raw), simd) in trees.iter().flat_map(|tree| levels().map(move |simd| (tree, simd))) {
            let file = TreeFile {
                path: "t.npz".into(),
                name: (*name).to_owned(),
                raw: raw.clone(),
                triangle_count: None,
                content_hash: String::new(),
            };
            let config = BuildConfig { simd, ..BuildConfig::default() };
            let world = World::with_tree(Arc::clone(&scene), Arc::new(file), &config, &Task::new());
            let world = world.expect("nobody cancels");
            let context = format!("in '{}', a {name}, {simd:?}", scene.name);
            assert!(world.traced_file().is_some(), "{context}: {:?}", world.imported);
            for e in &expected {
                check(&world, e, &context);
            }
            check_packets(&world, &all, &context);
        }
    }
}

#[test]
fn counting_changes_no_answer_and_planes_are_not_counted() {
    let scene = Arc::new(mixed(9, 120));
    for config in BuildConfig::default().five_trees().map(|(_, config)| config) {
        let world = build(&scene, &config);
        let mut sum = RayCounters::default();
        for ray in rays(&scene, 200) {
            let mut counters = RayCounters::default();
            assert_eq!(world.intersect(&ray, &mut counters), world.intersect(&ray, &mut ()), "{ray:?}");
            assert!(counters.shape_tests >= counters.leaf_visits, "a leaf holds at least one shape");
            assert!(counters.shape_tests <= scene.shape_count() as u64, "a shape is tested once a ray");
            sum += counters;
        }
        assert!(sum.shape_tests > 0 && sum.box_tests > sum.inner_visits, "{sum:?}");
        // In less tests than trying every shape.
        assert!(sum.shape_tests < 200 * scene.shape_count() as u64 / 4, "{config:?} {sum:?}");
    }
    let plane = scenes().into_iter().find(|s| s.name == "a plane alone").expect("one of the scenes");
    let world = build(&Arc::new(plane), &BuildConfig::default());
    let mut counters = RayCounters::default();
    let down = Ray::new(Vec3::Z, Vec3::NEG_Z);
    assert_eq!(world.intersect(&down, &mut counters).map(|h| (h.t, h.shape)), Some((1.0, 0)));
    assert_eq!(world.occluded_by_intersect(&down, ShadowRule::GlassMirror, &mut counters), None);
    assert_eq!(world.occluded(&down, &mut counters), Some(0));
    assert_eq!(counters, RayCounters::default());
}

/// Glass and a blocking shape in exactly the same place, in either order, and glass inside glass.
#[test]
fn a_search_through_glass_loses_nothing_at_the_same_distance() {
    let wall = |material| {
        (Shape::Quad(Quad { corner: Vec3::NEG_ONE, edge_u: Vec3::X * 2.0, edge_v: Vec3::Y * 2.0 }), material)
    };
    let ball = |radius, material| (Shape::Sphere(Sphere { center: Vec3::ZERO, radius }), material);
    let ray = Ray::new(Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z);
    let cases = [
        (vec![wall(GLASS), wall(DIFFUSE)], Some(1)),
        (vec![wall(DIFFUSE), wall(GLASS)], Some(0)),
        (vec![wall(GLASS), wall(GLASS), wall(GLASS)], None),
        (vec![ball(1.0, GLASS), ball(1.0, GLASS), ball(0.5, DIFFUSE)], Some(2)),
        (vec![ball(0.5, GLASS), ball(1.0, GLASS), ball(2.0, GLASS), wall(MIRROR)], Some(3)),
        (vec![ball(1.0, MIRROR), ball(1.0, DIFFUSE)], Some(0)),
    ];
    for (shapes, blocker) in cases {
        let scene = Arc::new(scene_of("coincident", shapes));
        for config in configs() {
            let world = build(&scene, &config);
            let found = world.occluded_by_intersect(&ray, ShadowRule::Glass, &mut ());
            assert_eq!(found, blocker, "{:?} {config:?}", scene.shapes);
            assert_eq!(
                world.occluded_filtered(&ray, ShadowRule::Glass, &mut ()).is_some(),
                blocker.is_some()
            );
        }
    }
}

/// A closed mesh: a cube of side 2 whose faces are grids, with every vertex shared; its edges and the sides of boxes
/// coincide. `bend` maps the cube's points.
fn closed_mesh(cells: u32, bend: impl Fn(Vec3) -> Vec3) -> Scene {
    let mut scene = empty_scene("closed mesh");
    let step = 2.0 / cells as f32;
    for face in 0..6 {
        let turn = if face < 4 {
            Quat::from_rotation_y(FRAC_PI_2 * face as f32)
        } else {
            Quat::from_rotation_x(FRAC_PI_2 * (2 * face - 9) as f32)
        };
        let point = |i: u32, j: u32| {
            let flat = Vec3::new(i as f32 * step - 1.0, j as f32 * step - 1.0, 1.0);
            // Rounded to the grid, so that faces meet in the same vertices.
            let turned = ((turn * flat) / step * 2.0).round() * step / 2.0;
            bend(turned)
        };
        for i in 0..cells {
            for j in 0..cells {
                let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                add(&mut scene, triangle([a, b, c]), DIFFUSE);
                add(&mut scene, triangle([a, c, d]), DIFFUSE);
            }
        }
    }
    scene
}

/// Points on shared edges, and shared vertices.
fn seam_point(scene: &Scene, rng: &mut Pcg32) -> Vec3 {
    let t = scene.triangle(rng.random_range(0..scene.shape_count() as u32));
    let (a, b) = (t.v[rng.random_range(0..3)], t.v[rng.random_range(0..3)]);
    a.lerp(b, [0.0, 0.5, rng.random_range(0.0..1.0)][rng.random_range(0..3)])
}

fn check_watertight(scene: Scene, inside: f32) {
    let scene = Arc::new(scene);
    let configs = BuildConfig::default().five_trees().map(|(_, config)| config);
    let octal = BuildConfig { widen: Widen::Collapse, ..BuildConfig::default() };
    let compressed = BuildConfig { layout: Layout::Compressed, ..octal };
    let cut = BuildConfig { pre_split: 0.5, ..octal };
    for config in configs.into_iter().chain([octal, compressed, cut]) {
        let world = build(&scene, &config);
        let mut rng = Pcg32::seed_from_u64(8);
        for i in 0..6000 {
            let target = seam_point(&scene, &mut rng);
            let origin = match i % 3 {
                0 => vec(&mut rng, inside),
                // Almost straight at it: all but along the sides of the boxes.
                1 => target * rng.random_range(0.0..0.5) + vec(&mut rng, 1e-5),
                _ => (target + vec(&mut rng, 0.05)) * 0.01,
            };
            let ray = Ray::new(origin, target - origin);
            let hit = world.intersect(&ray, &mut ());
            let hit = hit.unwrap_or_else(|| panic!("{ray:?} leaves a closed mesh with {config:?}"));
            assert!(hit.t < 1.001, "{ray:?} passes the wall with {config:?}: {hit:?}");
            assert!(world.occluded(&ray, &mut ()).is_some(), "{ray:?} leaves with {config:?}");
        }
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh_of_axis_aligned_faces() {
    check_watertight(closed_mesh(12, |p| p), 0.9);
}

#[test]
fn no_ray_leaves_a_closed_mesh_far_from_the_origin() {
    let offset = Vec3::new(1000.3, -77.7, 0.1);
    let scene = Arc::new(closed_mesh(9, |p| p * 1.7 + offset));
    let world = build(&scene, &BuildConfig { width: Width::W4, ..BuildConfig::default() });
    let mut rng = Pcg32::seed_from_u64(9);
    for _ in 0..6000 {
        let target = seam_point(&scene, &mut rng);
        let origin = offset + vec(&mut rng, 1.5);
        let ray = Ray::new(origin, target - origin);
        assert!(world.intersect(&ray, &mut ()).is_some(), "{ray:?} leaves");
    }
}

#[test]
fn no_ray_leaves_a_closed_round_mesh() {
    check_watertight(closed_mesh(10, |p| p.normalize() * 1.3), 0.6);
    check_watertight(closed_mesh(7, |p| p * Vec3::new(1.0, 0.01, 3.7) + p.yzx() * 1e-3), 0.005);
}

/// From outside, at edges and vertices that face the ray: stopped by the near wall, not seen through to the far one.
#[test]
fn no_ray_enters_a_closed_mesh_from_outside() {
    let scene = Arc::new(closed_mesh(10, |p| p.normalize()));
    for (_, config) in BuildConfig::default().five_trees() {
        let world = build(&scene, &config);
        let mut rng = Pcg32::seed_from_u64(10);
        for i in 0..4000 {
            let target = seam_point(&scene, &mut rng);
            let origin = target * [3.0, 40.0][i % 2] + vec(&mut rng, 1.0);
            let ray = Ray::new(origin, target - origin);
            let hit = world.intersect(&ray, &mut ()).unwrap_or_else(|| panic!("{ray:?} misses, {config:?}"));
            assert!(hit.t < 1.001, "{ray:?} passes the near wall with {config:?}: {hit:?}");
        }
    }
}

#[test]
fn rays_that_are_no_rays_hit_nothing_and_stop_nothing() {
    let scene = Arc::new(mixed(12, 60));
    let world = build(&scene, &BuildConfig::default());
    let nan = Vec3::splat(f32::NAN);
    let cases = [
        Ray::new(nan, Vec3::X),
        Ray::new(Vec3::ZERO, nan),
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray { t_min: 2.0, t_max: 1.0, ..Ray::new(Vec3::ZERO, Vec3::X) },
        Ray { t_max: f32::NAN, t_min: f32::NAN, ..Ray::new(Vec3::ZERO, Vec3::X) },
    ];
    for ray in cases {
        assert_eq!(world.intersect(&ray, &mut ()), None, "{ray:?}");
        assert_eq!(world.occluded(&ray, &mut ()), None, "{ray:?}");
        assert_eq!(world.occluded_by_intersect(&ray, ShadowRule::Glass, &mut ()), None, "{ray:?}");
    }
}

/// The walks of every level, side by side: the same hits to the last bit, and the same visits.
#[test]
fn every_level_of_instructions_gives_the_same_hits_and_counts() {
    let levels: Vec<_> = SimdLevel::ALL.into_iter().filter(|level| level.is_available()).collect();
    assert!(levels.len() > 2, "{levels:?}");
    for scene in scenes() {
        let scene = Arc::new(scene);
        let rays = rays(&scene, 1500);
        for (width, layout) in BuildConfig::NODES {
            for leaf in [1, 6] {
                let worlds = levels.iter().map(|&simd| {
                    build(&scene, &BuildConfig { width, layout, leaf, simd, ..BuildConfig::default() })
                });
                let mut answers = worlds.map(|world| {
                    let ask = |ray: &Ray| {
                        let mut counters = [RayCounters::default(); 3];
                        let hit = world.intersect(ray, &mut counters[0]);
                        let any = world.occluded(ray, &mut counters[1]);
                        let blocking = world.occluded_by_intersect(ray, ShadowRule::Glass, &mut counters[2]);
                        (hit, any, blocking, counters)
                    };
                    rays.iter().map(ask).collect::<Vec<_>>()
                });
                let first = answers.next().expect("a level");
                for (level, answers) in levels[1..].iter().zip(answers) {
                    for (ray, (a, b)) in rays.iter().zip(first.iter().zip(&answers)) {
                        assert_eq!(
                            a, b,
                            "{level:?} of '{}', width {width:?} {layout:?}: {ray:?}",
                            scene.name
                        );
                    }
                }
            }
        }
    }
}

/// Rays that are alike: each a base ray with its end moved a little, a fan in a plane, or the same ray again and again; from
/// one origin or from several.
fn coherent_rays(scene: &Scene) -> Vec<Ray> {
    let mut rng = Pcg32::seed_from_u64(7);
    let mut all = Vec::new();
    for (i, base) in rays(scene, 160).into_iter().enumerate() {
        let spread = [0.0, 0.01, 0.2, 0.6][i % 4];
        let from_one = i % 3 != 0;
        // Now and then fewer than a packet holds.
        for _ in 0..if i % 10 == 9 { 23 } else { 64 } {
            let mut moved = vec(&mut rng, 1.0) * spread;
            if i % 7 == 0 {
                moved[i % 3] = 0.0;
            }
            let shift = if from_one { Vec3::ZERO } else { vec(&mut rng, 0.1) };
            all.push(Ray { origin: base.origin + shift, direction: base.direction + moved, ..base });
        }
    }
    all
}

fn check_packets(world: &World, rays: &[Ray], context: &str) {
    let mut packets = Packets::new(world).without_pauses();
    let alone: Vec<_> = rays
        .iter()
        .map(|ray| {
            let mut counters = [RayCounters::default(); 2];
            let hit = world.intersect(ray, &mut counters[0]);
            let stopped = world.occluded_filtered(ray, ShadowRule::Glass, &mut counters[1]).is_some();
            (hit, stopped, world.occluded(ray, &mut ()).is_some(), counters)
        })
        .collect();
    let check = |ray: usize, same: bool, what: &str| {
        assert!(same, "{what} of {:?}, whose answers alone are {:?}, {context}", rays[ray], alone[ray]);
    };
    for (i, hit) in packets.intersect(rays).iter().enumerate() {
        check(i, *hit == alone[i].0, "the hit");
    }
    let (hits, counters) = packets.intersect_and_count(rays);
    for i in 0..rays.len() {
        check(i, hits[i] == alone[i].0, "the counted hit");
        check(i, counters[i] == alone[i].3[0], &format!("the counters {:?}", counters[i]));
    }
    for (i, counters) in packets.count(rays).iter().enumerate() {
        check(i, *counters == alone[i].3[0], "the counters without hits");
    }
    for (i, stopped) in packets.occluded(rays).iter().enumerate() {
        check(i, *stopped == alone[i].2, "occluded");
    }
    for (i, stopped) in packets.occluded_filtered(rays, ShadowRule::Glass).iter().enumerate() {
        check(i, *stopped == alone[i].1, "occluded with filter");
    }
    let (stopped, counters) = packets.occluded_filtered_and_count(rays, ShadowRule::Glass);
    for i in 0..rays.len() {
        check(i, stopped[i] == alone[i].1, "occluded with filter, counted,");
        check(i, counters[i] == alone[i].3[1], &format!("the shadow ray's counters {:?}", counters[i]));
    }
    // With pauses: whatever was traced before.
    let mut packets = Packets::new(world);
    for i in [0, rays.len() / 2] {
        for (j, hit) in packets.intersect(&rays[i..]).iter().enumerate() {
            check(i + j, *hit == alone[i + j].0, "the hit, with pauses,");
        }
    }
}

/// Packets answer and count as their rays alone, to the last bit.
#[test]
fn a_packet_answers_and_counts_as_its_rays_alone() {
    let levels = || SimdLevel::ALL.into_iter().filter(|level| level.is_available());
    for scene in scenes() {
        let scene = Arc::new(scene);
        let mut all = coherent_rays(&scene);
        all.extend(rays(&scene, 500));
        for (width, layout) in BuildConfig::NODES {
            for (leaf, simd) in [1, 6].into_iter().flat_map(|leaf| levels().map(move |simd| (leaf, simd))) {
                let config = BuildConfig { width, layout, leaf, simd, ..BuildConfig::default() };
                let world = build(&scene, &config);
                check_packets(&world, &all, &format!("'{}' with {config:?}", scene.name));
            }
        }
    }
}

/// The deepest tree, and so many equally near shapes that rays disagree about their order all the way down.
#[test]
fn packets_part_ways_as_often_as_they_must() {
    let mut rng = Pcg32::seed_from_u64(9);
    let spheres = (0..400).map(|_| {
        let sphere = Sphere { center: vec(&mut rng, 0.01), radius: 1.0 };
        (Shape::Sphere(sphere), DIFFUSE)
    });
    let scene = Arc::new(scene_of("nested spheres", spheres));
    let rays: Vec<Ray> = (0..128)
        .map(|_| {
            let origin = Vec3::new(0.1, 0.2, -5.0) + vec(&mut rng, 0.5);
            Ray::new(origin, vec(&mut rng, 0.3) - origin)
        })
        .collect();
    for (width, layout) in BuildConfig::NODES {
        for builder in [Builder::Median, Builder::Binned] {
            let config = BuildConfig { builder, width, layout, leaf: 1, ..BuildConfig::default() };
            check_packets(&build(&scene, &config), &rays, &format!("{config:?}"));
        }
    }
}
