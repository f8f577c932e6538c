//! Motion as a pure function of time; t = 0 is the still scene.

use std::ops::Range;
use std::sync::Arc;

use glam::{Quat, Vec3};

use crate::geometry::{Aabb, Rigid, ShapeKind};

use super::Scene;

/// What moves, and how.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// Vertices of the mesh: a range of positions, and an empty one of normals or one of the same length, in which each
    /// normal belongs to the position at its place.
    Vertices { positions: Range<u32>, normals: Range<u32>, motion: Motion },
    /// One bounded shape that is not a triangle, by shape index.
    Shape { shape: u32, motion: Motion },
}

/// A motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// A twist about the vertical (y) axis through `center`: the angle grows with height above it, by
    /// `amplitude * sin(rate * t)` radians a unit.
    Twist { center: Vec3, amplitude: f32, rate: f32 },
    /// A turn about an axis through the shape's own centre, `rate` radians a second.
    Turn { axis: Vec3, rate: f32 },
    /// The bounce of `room`: up by `height * (1 - ((t mod 2) - 1)^2)`.
    Bounce { height: f32 },
    /// The swing of the light of `room`: about z through `pivot`, by `amplitude * sin(rate * t)`.
    Swing { pivot: Vec3, amplitude: f32, rate: f32 },
}

impl Scene {
    /// Whether the scene moves at all.
    pub fn is_animated(&self) -> bool {
        !self.animation.is_empty()
    }

    /// This scene (which must be the one of t = 0) at another moment. A time that is not finite is taken as 0.
    #[must_use]
    pub fn at(self: &Arc<Self>, time: f32) -> Scene {
        debug_assert!(self.time == 0.0, "a scene that has moved must not be moved again");
        let mut scene = Self::clone(self);
        if time == 0.0 || !time.is_finite() {
            return scene;
        }
        scene.time = time;
        scene.still = Some(Arc::clone(self));
        for track in self.animation.iter() {
            match track {
                Track::Vertices { positions, normals, motion } => {
                    let positions = positions.start as usize..positions.end as usize;
                    let normals = normals.start as usize..normals.end as usize;
                    motion.move_vertices(
                        &mut scene.mesh.positions[positions],
                        &mut scene.mesh.normals[normals],
                        time,
                    );
                }
                Track::Shape { shape, motion } => scene.move_shape(*shape, motion, time),
            }
        }
        scene
    }

    fn move_shape(&mut self, shape: u32, motion: &Motion, time: f32) {
        let slot = self.shapes[shape as usize];
        let index = slot.index as usize;
        match slot.kind {
            ShapeKind::Triangle => debug_assert!(false, "triangles move by their vertices"),
            ShapeKind::Sphere => {
                let sphere = &mut self.spheres[index];
                sphere.center = motion.placement(sphere.center, time).point(sphere.center);
            }
            ShapeKind::Cuboid => {
                let placed = &mut self.cuboids[index].world_from_object;
                *placed = motion.placement(placed.translation, time).then_after(placed);
            }
            ShapeKind::Quad => {
                let quad = &mut self.quads[index];
                let center = quad.corner + (quad.edge_u + quad.edge_v) * 0.5;
                let moved = motion.placement(center, time);
                quad.corner = moved.point(quad.corner);
                quad.edge_u = moved.vector(quad.edge_u);
                quad.edge_v = moved.vector(quad.edge_v);
            }
            ShapeKind::Torus => {
                let placed = &mut self.tori[index].world_from_object;
                *placed = motion.placement(placed.translation, time).then_after(placed);
            }
        }
    }
}

impl Motion {
    /// Where the motion has taken a rigid shape whose centre was at `center`. A twist turns it as a whole, by the angle at
    /// its centre.
    fn placement(&self, center: Vec3, time: f32) -> Rigid {
        match *self {
            Self::Twist { center: pivot, amplitude, rate } => {
                let angle = amplitude * (rate * time).sin() * (center.y - pivot.y);
                about(pivot, Quat::from_rotation_y(angle))
            }
            Self::Turn { axis, rate } => {
                about(center, Quat::from_axis_angle(axis.normalize_or(Vec3::Y), rate * time))
            }
            Self::Bounce { height } => {
                let phase = time.rem_euclid(2.0) - 1.0;
                Rigid::new(Quat::IDENTITY, Vec3::Y * height * (1.0 - phase * phase))
            }
            Self::Swing { pivot, amplitude, rate } => {
                about(pivot, Quat::from_rotation_z(amplitude * (rate * time).sin()))
            }
        }
    }

    /// Moves positions, and the normals that belong to them. All but a twist move them as one rigid body around the middle
    /// of their box.
    fn move_vertices(&self, positions: &mut [Vec3], normals: &mut [Vec3], time: f32) {
        let Self::Twist { center, amplitude, rate } = *self else {
            let middle = Aabb::from_points(positions.iter().copied()).center();
            let moved = self.placement(middle, time);
            positions.iter_mut().for_each(|p| *p = moved.point(*p));
            normals.iter_mut().for_each(|n| *n = moved.vector(*n));
            return;
        };
        let angle_per_unit = amplitude * (rate * time).sin();
        // Normals first: they depend on where their positions were.
        for (normal, position) in normals.iter_mut().zip(positions.iter()) {
            *normal = twisted_normal(*normal, *position - center, angle_per_unit);
        }
        for position in positions {
            let offset = *position - center;
            *position = center + Quat::from_rotation_y(angle_per_unit * offset.y) * offset;
        }
    }
}

/// The rotation about an axis through `pivot`.
fn about(pivot: Vec3, rotation: Quat) -> Rigid {
    Rigid::new(rotation, pivot - rotation * pivot)
}

/// A normal under the twist `p -> RotY(k p.y) p`, of Jacobian `R (I + k w e_y^T)` with `w = e_y x p`; since w has no y, the
/// inverse transpose is `R (I - k e_y w^T)`.
fn twisted_normal(normal: Vec3, offset: Vec3, angle_per_unit: f32) -> Vec3 {
    let sheared = normal - Vec3::Y * (angle_per_unit * Vec3::Y.cross(offset).dot(normal));
    (Quat::from_rotation_y(angle_per_unit * offset.y) * sheared).normalize_or(normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn every_moving_scene_is_still_at_zero_and_moves_after() {
        let mut moving = 0;
        for (name, _) in builtin::SCENES {
            let still = Arc::new(builtin::make(name).expect("a built-in scene"));
            let start = still.at(0.0);
            assert_eq!(still.mesh.positions, start.mesh.positions, "{name}");
            assert_eq!(
                (&still.spheres, &still.cuboids, &still.quads),
                (&start.spheres, &start.cuboids, &start.quads)
            );
            if !still.is_animated() {
                continue;
            }
            moving += 1;
            let later = still.at(0.7);
            assert_eq!(later.time, 0.7);
            assert_eq!(later.shape_count(), still.shape_count());
            assert_ne!((&still.spheres, &still.cuboids), (&later.spheres, &later.cuboids), "{name}");
            let again = still.at(0.7);
            assert_eq!(later.mesh.positions, again.mesh.positions, "{name} is not a function of time");
            assert!(still.at(f32::NAN).mesh.positions == still.mesh.positions);
        }
        assert!(moving >= 2, "bunny and room move");
    }

    #[test]
    fn a_twist_turns_by_height_and_keeps_normals_at_right_angles() {
        let twist = Motion::Twist { center: Vec3::new(0.5, 0.0, 0.0), amplitude: 0.8, rate: 1.0 };
        let (p, n) = (Vec3::new(1.0, 1.5, 0.3), Vec3::new(0.6, 0.64, 0.48).normalize());
        let (s, t) = n.any_orthonormal_pair();
        let h = 1e-2;
        let mut points = vec![p, p + s * h, p - s * h, p + t * h, p - t * h, Vec3::new(1.5, 0.0, 0.0)];
        let mut normals = vec![n];
        twist.move_vertices(&mut points, &mut normals, 1.0);
        let moved = (points[1] - points[2]).cross(points[3] - points[4]).normalize();
        assert!(moved.dot(normals[0]) > 0.9999, "{moved} is not {}", normals[0]);
        assert!((points[5] - Vec3::new(1.5, 0.0, 0.0)).length() < 1e-6, "the foot stays");
        let angle = 0.8 * 1.0_f32.sin() * 1.5;
        let expected = Vec3::X * 0.5 + Quat::from_rotation_y(angle) * Vec3::new(0.5, 1.5, 0.3);
        assert!((points[0] - expected).length() < 1e-5);
    }

    #[test]
    fn the_room_follows_its_formulas() {
        let still = Arc::new(builtin::make("room").expect("a built-in scene"));
        for time in [0.0_f32, 0.5, 1.0, 2.75, 9.3] {
            let room = still.at(time);
            let h = 1.0 - (time.rem_euclid(2.0) - 1.0).powi(2);
            assert!((room.spheres[0].center - Vec3::new(-1.4, -0.5 + h, 2.0)).length() < 1e-5);
            let swing = Quat::from_rotation_z(0.1 * (0.6 * time).sin());
            let middle = Vec3::new(0.0, 2.6, 2.0) + swing * Vec3::new(0.0, -0.9, 0.0);
            let quad = room.quads[0];
            assert!((quad.corner + (quad.edge_u + quad.edge_v) / 2.0 - middle).length() < 1e-5);
            assert!(quad.edge_u.cross(quad.edge_v).normalize().dot(swing * Vec3::NEG_Y) > 0.9999);
            let turned = Quat::from_rotation_y(0.5 * time)
                * Quat::from_rotation_x(45_f32.to_radians())
                * Quat::from_rotation_z(45_f32.to_radians());
            let cube = room.cuboids[0].world_from_object;
            assert!((cube.translation - Vec3::new(1.4, 0.0, 2.0)).length() < 1e-5);
            assert!(cube.rotation.dot(turned).abs() > 0.99999);
        }
    }
}
