//! A box of any orientation, hit from outside and inside.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::polygon::Polygon;
use super::rounding::{outward_box, rounded_point};
use super::slabs::Span;
use super::transform::ExactRigid;
use super::{Aabb, PreparedRay, Ray, Rigid, ShapeHit, SurfacePoint, SurfaceSample};

/// A box of any orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cuboid {
    pub world_from_object: Rigid,
    /// Half the side lengths, in object space; the centre is the object's origin.
    pub half_extent: Vec3,
}

/// One of the six sides.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    axis: usize,
    /// 1 on the side where the coordinate is positive, else -1.
    side: f64,
}

impl Face {
    const ALL: [Self; 6] = {
        let mut all = [Self { axis: 0, side: -1.0 }; 6];
        let mut i = 0;
        while i < 6 {
            all[i] = Self { axis: i / 2, side: if i % 2 == 0 { -1.0 } else { 1.0 } };
            i += 1;
        }
        all
    };

    /// The number that a hit carries.
    fn number(self) -> f32 {
        (2 * self.axis + usize::from(self.side > 0.0)) as f32
    }

    fn from_number(number: f32) -> Self {
        Self::ALL[(number as usize).min(5)]
    }

    fn normal(self) -> DVec3 {
        let mut normal = DVec3::ZERO;
        normal[self.axis] = self.side;
        normal
    }

    /// The two other axes, in order.
    fn tangents(self) -> (usize, usize) {
        [(1, 2), (0, 2), (0, 1)][self.axis]
    }

    /// The area of this face.
    fn area(self, half: DVec3) -> f64 {
        let (u, v) = self.tangents();
        4.0 * half[u] * half[v]
    }

    /// The point of this face at `uv` in the unit square, in object space.
    fn point(self, half: DVec3, uv: (f64, f64)) -> DVec3 {
        let (u, v) = self.tangents();
        let mut point = DVec3::ZERO;
        point[self.axis] = self.side * half[self.axis];
        point[u] = (2.0 * uv.0 - 1.0) * half[u];
        point[v] = (2.0 * uv.1 - 1.0) * half[v];
        point
    }
}

impl Cuboid {
    fn placed(&self) -> (ExactRigid, DVec3) {
        (self.world_from_object.exact(), self.half_extent.as_dvec3().abs())
    }

    pub fn bounds(&self) -> Aabb {
        let (world, half) = self.placed();
        let reach =
            world.x_axis().abs() * half.x + world.y_axis().abs() * half.y + world.z_axis().abs() * half.z;
        outward_box(world.translation - reach, world.translation + reach)
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Cuboid::intersect`] with another interval.
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        self.intersect_in(ray, &Span::new(ray, &self.bounds(), t_min, t_max)?)
    }

    /// The hit in a span of the ray that was made for the cuboid's own box. The hit's `u` is the number of the face.
    pub fn intersect_in(&self, ray: &PreparedRay, span: &Span) -> Option<ShapeHit> {
        let (world, half) = self.placed();
        let origin = world.inverse_point(ray.ray.origin.as_dvec3());
        let direction = world.inverse_vector(ray.ray.direction.as_dvec3());
        let (mut enter, mut enter_face) = (f64::NEG_INFINITY, Face::ALL[0]);
        let (mut leave, mut leave_face) = (f64::INFINITY, Face::ALL[0]);
        for axis in 0..3 {
            // By the sign bit, so that a negative zero divides to the right infinity.
            let side = 1f64.copysign(direction[axis]);
            let near = (-side * half[axis] - origin[axis]) / direction[axis];
            let far = (side * half[axis] - origin[axis]) / direction[axis];
            // A ray in the plane of a face makes NaN, which says nothing.
            if near > enter {
                (enter, enter_face) = (near, Face { axis, side: -side });
            }
            if far < leave {
                (leave, leave_face) = (far, Face { axis, side });
            }
        }
        // Infinite where the ray runs beside the cuboid, or has no direction.
        if !(enter <= leave && enter.is_finite() && leave.is_finite()) {
            return None;
        }
        let hit = |t: f64, face: Face| span.place(t).map(|t| ShapeHit { t, u: face.number(), v: 0.0 });
        hit(enter, enter_face).or_else(|| hit(leave, leave_face))
    }

    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let (world, half) = self.placed();
        let face = Face::from_number(hit.u);
        let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
        let point = world.inverse_point(point);
        let (u, v) = face.tangents();
        let share = |axis: usize| {
            if half[axis] > 0.0 { (0.5 + 0.5 * point[axis] / half[axis]).clamp(0.0, 1.0) } else { 0.5 }
        };
        let SurfaceSample { position, error, normal, uv } = self.face_point(face, (share(u), share(v)));
        SurfacePoint { position, error, normal, uv }
    }

    #[inline]
    fn face_point(&self, face: Face, uv: (f64, f64)) -> SurfaceSample {
        let (world, half) = self.placed();
        let magnitude = world.translation.abs().max_element() + half.length();
        let (position, error) = rounded_point(world.point(face.point(half, uv)), magnitude);
        let normal = world.vector(face.normal()).as_vec3();
        SurfaceSample { position, error, normal, uv: Vec2::new(uv.0 as f32, uv.1 as f32) }
    }

    pub fn area(&self) -> f32 {
        let (_, half) = self.placed();
        Face::ALL.iter().map(|face| face.area(half)).sum::<f64>() as f32
    }

    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        let (_, half) = self.placed();
        let mut rest = f64::from(u.x) * Face::ALL.iter().map(|face| face.area(half)).sum::<f64>();
        // The last face takes what rounding leaves over.
        let mut chosen = (Face::ALL[5], 0.5);
        for face in Face::ALL {
            let area = face.area(half);
            if rest < area {
                chosen = (face, rest / area);
                break;
            }
            rest -= area;
        }
        self.face_point(chosen.0, (chosen.1, f64::from(u.y)))
    }

    /// The parts of the six faces inside `clip`, in world space.
    fn clipped_faces(&self, clip: &Aabb) -> impl Iterator<Item = Polygon> {
        let (world, half) = self.placed();
        Face::ALL.into_iter().map(move |face| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            Polygon::clipped(corners.map(|uv| world.point(face.point(half, uv))), clip)
        })
    }

    /// Exact; empty for a clip that lies wholly inside, where no ray can hit.
    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        let parts = self.clipped_faces(clip).fold(Aabb::EMPTY, |all, part| all.union(part.bounds()));
        parts.intersection(*clip).intersection(self.bounds())
    }

    /// Exact.
    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        self.clipped_faces(clip).map(|part| part.area()).sum::<f64>() as f32
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::super::Shape;
    use super::super::checks::{check_shape, hit, random_placement, rng};
    use super::*;

    fn aligned(half_extent: Vec3) -> Cuboid {
        Cuboid { world_from_object: Rigid::IDENTITY, half_extent }
    }

    #[test]
    fn what_holds_for_every_shape() {
        check_shape(&Shape::Cuboid(aligned(Vec3::new(1.0, 2.0, 0.5))), true);
        let rng = &mut rng(6);
        for half_extent in [Vec3::ONE, Vec3::new(0.2, 2.0, 0.7), Vec3::new(1.0, 0.05, 1.0)] {
            let world_from_object = random_placement(rng);
            check_shape(&Shape::Cuboid(Cuboid { world_from_object, half_extent }), true);
        }
    }

    #[test]
    fn hits_from_outside_inside_and_along_faces() {
        let cuboid = Shape::Cuboid(aligned(Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!(hit(&cuboid, Vec3::new(0.0, 0.0, -5.0), Vec3::Z).unwrap().t, 2.0);
        assert_eq!(hit(&cuboid, Vec3::ZERO, Vec3::new(-0.0, 1.0, -0.0)).unwrap().t, 2.0);
        assert_eq!(hit(&cuboid, Vec3::new(1.0, 0.0, -5.0), Vec3::Z).unwrap().t, 2.0);
        assert_eq!(hit(&cuboid, Vec3::new(1.001, 0.0, -5.0), Vec3::Z), None);
        assert_eq!(hit(&cuboid, Vec3::new(0.0, 0.0, 5.0), Vec3::Z), None);
        assert_eq!(hit(&cuboid, Vec3::ZERO, Vec3::ZERO), None);
    }

    #[test]
    fn faces_have_their_normal_and_uv() {
        let cuboid = aligned(Vec3::new(1.0, 2.0, 4.0));
        for (axis, direction) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            for sign in [-1.0, 1.0] {
                let normal = direction * sign;
                let ray =
                    Ray::new(normal * 9.0 + Vec3::new(0.5, 1.0, 2.0) * (Vec3::ONE - direction), -normal);
                let found = cuboid.intersect(&PreparedRay::new(ray)).unwrap();
                let surface = cuboid.surface(&ray, &found);
                assert_eq!((surface.normal, surface.uv), (normal, Vec2::splat(0.75)), "axis {axis}");
            }
        }
        assert_eq!(cuboid.area(), 8.0 * (2.0 + 4.0 + 8.0));
    }

    #[test]
    fn a_turned_cuboid_has_the_box_of_its_corners() {
        let turn = Rigid::new(Quat::from_rotation_z(std::f32::consts::FRAC_PI_4), Vec3::new(5.0, 0.0, 0.0));
        let bounds = Cuboid { world_from_object: turn, half_extent: Vec3::ONE }.bounds();
        let diagonal = 2f32.sqrt();
        assert!((bounds.max - Vec3::new(5.0 + diagonal, diagonal, 1.0)).abs().max_element() < 1e-6);
        assert!((bounds.min - Vec3::new(5.0 - diagonal, -diagonal, -1.0)).abs().max_element() < 1e-6);
    }

    #[test]
    fn a_clip_inside_holds_no_surface() {
        let cuboid = aligned(Vec3::ONE);
        let inside = Aabb::new(Vec3::splat(-0.5), Vec3::splat(0.5));
        assert_eq!((cuboid.clipped_bounds(&inside), cuboid.area_inside(&inside)), (Aabb::EMPTY, 0.0));
    }
}
