//! A parallelogram: corner, and its two edges; the outside is along `edge_u x edge_v`.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::polygon::Polygon;
use super::rounding::{outward_box, rounded_point};
use super::slabs::Span;
use super::{Aabb, PreparedRay, Ray, ShapeHit, SurfacePoint, SurfaceSample};

/// How far beyond an edge, as a share of its length, a ray still hits: what double precision may lose. Far below one
/// unit in the last place of a single precision coordinate, it closes the gap between quads that share an edge.
const EDGE_SLACK: f64 = 1e-12;

/// Shares of an edge between which a ray hits.
pub(crate) const EDGE: std::ops::RangeInclusive<f64> = -EDGE_SLACK..=1.0 + EDGE_SLACK;

/// A quad in double precision, with its normal and the inverse of the normal's squared length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlatQuad {
    corner: [f64; 3],
    edge_u: [f64; 3],
    edge_v: [f64; 3],
    normal: [f64; 3],
    scale: f64,
}

impl FlatQuad {
    /// Where a ray meets the plane: its t, and the shares of the edges. `T` is a number or a vector of lanes; the arithmetic
    /// is the same.
    #[inline(always)]
    pub(crate) fn meet<T>(&self, origin: [T; 3], direction: [T; 3]) -> [T; 3]
    where
        T: Copy
            + Add<Output = T>
            + Sub<Output = T>
            + Mul<Output = T>
            + Div<Output = T>
            + Sub<f64, Output = T>
            + Mul<f64, Output = T>
            + Neg<Output = T>,
    {
        let Self { corner, edge_u, edge_v, normal, scale } = self;
        let dot = |a: [T; 3]| a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2];
        let to_origin = [origin[0] - corner[0], origin[1] - corner[1], origin[2] - corner[2]];
        let t = -dot(to_origin) / dot(direction);
        let at = |axis: usize| origin[axis] + direction[axis] * t - corner[axis];
        let p = [at(0), at(1), at(2)];
        let [a, b, c] = *edge_v;
        let u = dot([p[1] * c - p[2] * b, p[2] * a - p[0] * c, p[0] * b - p[1] * a]) * *scale;
        let [a, b, c] = *edge_u;
        let v = dot([p[2] * b - p[1] * c, p[0] * c - p[2] * a, p[1] * a - p[0] * b]) * *scale;
        [t, u, v]
    }

    /// [`Quad::intersect_in`].
    #[inline]
    pub(crate) fn intersect_in(&self, ray: &PreparedRay, span: &Span) -> Option<ShapeHit> {
        let (origin, direction) = (ray.ray.origin.as_dvec3(), ray.ray.direction.as_dvec3());
        let [t, u, v] = self.meet(origin.to_array(), direction.to_array());
        // A quad without area or a ray along it makes NaN, which is in no range.
        if !(EDGE.contains(&u) && EDGE.contains(&v)) {
            return None;
        }
        Some(Quad::hit_at(span.place(t)?, u, v))
    }
}

/// A parallelogram: corner, and its two edges; the outside is along `edge_u x edge_v`. One without area is never hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quad {
    pub corner: Vec3,
    pub edge_u: Vec3,
    pub edge_v: Vec3,
}

impl Quad {
    /// In order around the quad.
    pub(crate) fn corners(&self) -> [DVec3; 4] {
        let (corner, u, v) = self.in_double();
        [corner, corner + u, corner + u + v, corner + v]
    }

    fn in_double(&self) -> (DVec3, DVec3, DVec3) {
        (self.corner.as_dvec3(), self.edge_u.as_dvec3(), self.edge_v.as_dvec3())
    }

    pub fn bounds(&self) -> Aabb {
        let [a, b, c, d] = self.corners();
        outward_box(a.min(b).min(c).min(d), a.max(b).max(c).max(d))
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Quad::intersect`] with another interval.
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        self.intersect_in(ray, &Span::new(ray, &self.bounds(), t_min, t_max)?)
    }

    /// The hit in a span of the ray that was made for the quad's own box. The hit's `u` and `v` are the shares of the edges.
    pub fn intersect_in(&self, ray: &PreparedRay, span: &Span) -> Option<ShapeHit> {
        self.flat().intersect_in(ray, span)
    }

    /// The hit at `t` and at these shares of the edges.
    #[inline(always)]
    pub(crate) fn hit_at(t: f32, u: f64, v: f64) -> ShapeHit {
        ShapeHit { t, u: u.clamp(0.0, 1.0) as f32, v: v.clamp(0.0, 1.0) as f32 }
    }

    /// What all rays that meet it share.
    #[inline]
    pub(crate) fn flat(&self) -> FlatQuad {
        let (corner, edge_u, edge_v) = self.in_double();
        let normal = edge_u.cross(edge_v);
        FlatQuad {
            corner: corner.to_array(),
            edge_u: edge_u.to_array(),
            edge_v: edge_v.to_array(),
            normal: normal.to_array(),
            scale: 1.0 / normal.length_squared(),
        }
    }

    #[inline(always)]
    pub fn surface(&self, _ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let SurfaceSample { position, error, normal, uv } = self.sample(Vec2::new(hit.u, hit.v));
        SurfacePoint { position, error, normal, uv }
    }

    /// The unit normal on the outside; zero for a quad without area.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        let (_, edge_u, edge_v) = self.in_double();
        edge_u.cross(edge_v).normalize_or_zero().as_vec3()
    }

    pub fn area(&self) -> f32 {
        let (_, edge_u, edge_v) = self.in_double();
        edge_u.cross(edge_v).length() as f32
    }

    #[inline]
    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        let (corner, edge_u, edge_v) = self.in_double();
        let point = corner + edge_u * f64::from(u.x) + edge_v * f64::from(u.y);
        let magnitude = corner.abs().max_element() + edge_u.abs().max_element() + edge_v.abs().max_element();
        let (position, error) = rounded_point(point, magnitude);
        SurfaceSample { position, error, normal: self.normal(), uv: u }
    }

    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        Polygon::clipped(self.corners(), clip).bounds().intersection(*clip)
    }

    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        Polygon::clipped(self.corners(), clip).area() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::super::checks::{check_shape, hit, random_vec, rng};
    use super::*;

    const FLOOR: Quad = Quad {
        corner: Vec3::new(-1.0, 0.0, -1.0),
        edge_u: Vec3::new(0.0, 0.0, 2.0),
        edge_v: Vec3::new(4.0, 0.0, 0.0),
    };

    #[test]
    fn what_holds_for_every_shape() {
        check_shape(&Shape::Quad(FLOOR), false);
        let rng = &mut rng(2);
        for _ in 0..20 {
            let [corner, edge_u, edge_v] = std::array::from_fn(|_| random_vec(rng, 2.0));
            check_shape(&Shape::Quad(Quad { corner, edge_u, edge_v }), false);
        }
    }

    #[test]
    fn a_flat_quad_has_a_flat_box_and_its_corners_and_edges_are_hit() {
        assert_eq!(FLOOR.bounds(), Aabb::new(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(3.0, 0.0, 1.0)));
        assert_eq!((FLOOR.normal(), FLOOR.area()), (Vec3::Y, 8.0));
        for (x, z, expected) in [
            (-1.0, -1.0, true),
            (3.0, 1.0, true),
            (3.0, 0.3, true),
            (3.001, 0.0, false),
            (0.0, -1.001, false),
        ] {
            let found = hit(&Shape::Quad(FLOOR), Vec3::new(x, 2.0, z), Vec3::NEG_Y);
            assert_eq!(found.is_some(), expected, "{x} {z}");
        }
        let found = hit(&Shape::Quad(FLOOR), Vec3::new(0.0, -2.0, 0.5), Vec3::Y).unwrap();
        assert_eq!((found.t, found.u, found.v), (2.0, 0.75, 0.25));
    }

    #[test]
    fn a_quad_without_area_is_never_hit() {
        let flat = Quad { edge_v: FLOOR.edge_u * 2.0, ..FLOOR };
        assert_eq!(hit(&Shape::Quad(flat), Vec3::new(-1.0, 1.0, 0.0), Vec3::NEG_Y), None);
        assert_eq!((flat.area(), flat.normal()), (0.0, Vec3::ZERO));
    }
}
