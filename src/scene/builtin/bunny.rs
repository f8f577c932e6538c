//! The default scene: a bunny in a room, with a mirror sphere, a glass cuboid, and a floor that shines.

use glam::{Quat, Vec3};

use super::asset;
use crate::geometry::{Aabb, Rigid};
use crate::scene::assembly::Assembly;
use crate::scene::{Camera, Color, Mesh, Motion, Scene, Track, UpAxis};

/// Each cut adds two triangles to the 3,674 of the file.
const BISECTIONS: usize = 647;
/// From the floor to the tips of the ears.
const HEIGHT: f32 = 1.62;
const PLACE: Vec3 = Vec3::new(-0.1, 0.0, -0.35);
/// About the vertical, so that the face comes towards the camera.
const TURN_DEGREES: f32 = 24.0;

/// The inside of the room. Its floor is a square, so that the squares of the checker are.
const ROOM_MIN: Vec3 = Vec3::new(-3.0, 0.0, -2.4);
const ROOM_MAX: Vec3 = Vec3::new(3.0, 3.0, 3.6);
/// Squares of the checker along a side of the floor.
const FLOOR_SQUARES: f32 = 12.0;

pub(super) fn make() -> Scene {
    let mut scene = Assembly::new("bunny");
    let fur = scene.matt("bunny", Vec3::new(0.84, 0.79, 0.72));
    let (positions, normals) = scene.mesh(mesh(), fur);
    let motion = Motion::Twist { center: PLACE, amplitude: 1.1, rate: 1.3 };
    scene.track(Track::Vertices { positions, normals, motion });

    let mirror = scene.mirror("mirror sphere", Vec3::splat(0.95));
    let sphere = scene.sphere(Vec3::new(1.38, 0.52, -0.75), 0.52, mirror);
    scene.track(Track::Shape { shape: sphere, motion: Motion::Bounce { height: 0.8 } });

    let glass = scene.glass("glass cuboid", Vec3::new(0.85, 0.22, 0.30));
    let half = Vec3::new(0.26, 0.44, 0.26);
    // A hair above the floor: no two surfaces in one plane.
    let place = Rigid::new(Quat::from_rotation_y(0.55), Vec3::new(-1.2, half.y + 0.004, 0.4));
    let cuboid = scene.cuboid(place, half, glass);
    scene.track(Track::Shape { shape: cuboid, motion: Motion::Turn { axis: Vec3::Y, rate: 0.7 } });

    add_room(&mut scene);
    scene.finish(Camera {
        eye: Vec3::new(0.35, 1.32, 3.35),
        target: Vec3::new(0.0, 0.78, -0.3),
        fov_y_degrees: 39.0,
        up: UpAxis::Y,
    })
}

/// The refined bunny, standing on the floor at its place.
fn mesh() -> Mesh {
    let mut mesh = asset::read(include_bytes!("../../../assets/bunny.ply"));
    mesh.bisect_longest_edges(BISECTIONS);
    let bounds = Aabb::from_points(mesh.positions.iter().copied());
    let foot = bounds.center().with_y(bounds.min.y);
    let scale = HEIGHT / bounds.extent().y;
    let turn = Quat::from_rotation_y(TURN_DEGREES.to_radians());
    for p in &mut mesh.positions {
        *p = turn * ((*p - foot) * scale) + PLACE;
    }
    mesh.compute_smooth_normals();
    mesh
}

/// Six quads that face inwards, and one as the light under the ceiling.
fn add_room(scene: &mut Assembly) {
    let size = ROOM_MAX - ROOM_MIN;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let checker = Color::Checker {
        even: Vec3::new(0.82, 0.76, 0.68),
        odd: Vec3::new(0.24, 0.20, 0.18),
        size: 1.0 / FLOOR_SQUARES,
        fine: Vec::new(),
    };
    let floor = scene.surface("floor", checker, 0.3);
    let ceiling = scene.matt("ceiling", Vec3::new(0.82, 0.79, 0.74));
    let plaster = scene.matt("plaster", Vec3::new(0.66, 0.52, 0.40));
    let terracotta = scene.matt("terracotta", Vec3::new(0.68, 0.32, 0.20));
    let sage = scene.matt("sage", Vec3::new(0.36, 0.50, 0.42));
    let light = scene.emissive("light", Vec3::new(7.0, 6.4, 5.5));

    scene.quad(ROOM_MIN, z, x, floor);
    scene.quad(ROOM_MIN + y, x, z, ceiling);
    scene.quad(ROOM_MIN, x, y, plaster);
    scene.quad(ROOM_MIN + z, y, x, plaster);
    scene.quad(ROOM_MIN, y, z, terracotta);
    scene.quad(ROOM_MIN + x, z, y, sage);

    let half = Vec3::new(1.15, 0.0, 0.8);
    let middle = Vec3::new(-0.35, ROOM_MAX.y - 0.02, -0.1);
    scene.quad(middle - half, Vec3::X * 2.0 * half.x, Vec3::Z * 2.0 * half.z, light);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ShapeKind;

    #[test]
    fn has_exactly_the_shapes_that_the_table_counts() {
        let scene = make();
        let count = |kind| scene.shapes.iter().filter(|s| s.kind == kind).count();
        let counts = ShapeKind::ALL.map(count);
        assert_eq!(counts, [4968, 1, 1, 7, 0]);
        assert_eq!(scene.shape_count(), 4977);
        assert!(scene.planes.is_empty());
    }

    #[test]
    fn the_bunny_stands_on_the_floor_inside_the_room_closed() {
        let mesh = mesh();
        let bounds = Aabb::from_points(mesh.positions.iter().copied());
        assert!(bounds.min.y.abs() < 1e-6 && (bounds.max.y - HEIGHT).abs() < 1e-5);
        assert!(Aabb::new(ROOM_MIN, ROOM_MAX).padded(1e-5).contains(&bounds));
        let mut directed = std::collections::HashSet::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                assert!(directed.insert((t.position[k], t.position[(k + 1) % 3])));
            }
        }
        assert!(directed.iter().all(|(a, b)| directed.contains(&(*b, *a))), "an edge is open");
    }

    #[test]
    fn the_camera_sees_bunny_sphere_and_cuboid_whole() {
        let scene = make();
        let frame = scene.camera.frame(1280, 720);
        let mut boxes = vec![Aabb::from_points(scene.mesh.positions.iter().copied())];
        let sphere = scene.spheres[0];
        boxes.push(Aabb::new(sphere.center, sphere.center).padded(sphere.radius));
        let cuboid = scene.cuboids[0];
        let half = cuboid.half_extent;
        let reach = Vec3::new(half.x.hypot(half.z), half.y, half.x.hypot(half.z));
        let middle = cuboid.world_from_object.translation;
        boxes.push(Aabb::new(middle - reach, middle + reach));
        for bounds in boxes {
            for corner in bounds.corners() {
                let p = frame.project(corner);
                assert!(
                    p.z > 0.0 && p.x > 0.0 && p.x < 1280.0 && p.y > 0.0 && p.y < 720.0,
                    "{corner} at {p}"
                );
            }
        }
        assert!(Aabb::new(ROOM_MIN, ROOM_MAX).contains_point(scene.camera.eye));
    }
}
