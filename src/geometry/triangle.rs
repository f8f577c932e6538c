//! A triangle; its outside is where its vertices turn counter-clockwise.
//!
//! The test against a ray is that of Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (2013): no ray passes
//! between triangles that share an edge or a vertex. It differs in one point: the distance of the few triangles that
//! pass the edge test is computed from their plane in double precision. So a ray that starts within the error bound
//! of a triangle, on either side, never hits it by mistake, however thin it is and however flat the ray.

use std::ops::{Mul, Sub};

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::polygon::Polygon;
use super::rounding::{outward_box, rounded_point};
use super::slabs::Span;
use super::{Aabb, PreparedRay, Ray, ShapeHit, SurfacePoint, SurfaceSample};

/// A triangle; its outside is where its vertices turn counter-clockwise. One without area is never hit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Triangle {
    pub v: [Vec3; 3],
}

/// The three corners seen along the ray: coordinates across it, relative to it.
pub(crate) type Sheared<T> = [[T; 2]; 3];

/// Looks at three corners along the ray. `corners[i]` and `origin` are in the ray's permuted axes. `T` is a number or
/// a vector of lanes; the arithmetic is the same.
#[inline(always)]
pub(crate) fn shear<T>(corners: [[T; 3]; 3], origin: [T; 3], shear: [T; 2]) -> Sheared<T>
where
    T: Copy + Sub<Output = T> + Mul<Output = T>,
{
    // Not by `map`, whose closure would be compiled without the caller's instructions.
    let [a, b, c] = corners;
    [shear_one(a, origin, shear), shear_one(b, origin, shear), shear_one(c, origin, shear)]
}

#[inline(always)]
fn shear_one<T>(corner: [T; 3], origin: [T; 3], shear: [T; 2]) -> [T; 2]
where
    T: Copy + Sub<Output = T> + Mul<Output = T>,
{
    let z = corner[2] - origin[2];
    [(corner[0] - origin[0]) - shear[0] * z, (corner[1] - origin[1]) - shear[1] * z]
}

/// Twice the areas that the ray spans with each edge; index i belongs to the edge opposite of corner i. Equal signs
/// mean that the ray passes inside. A zero may be a rounded one: [`Triangle::confirm`] looks again.
#[inline(always)]
pub(crate) fn edges<T>([a, b, c]: Sheared<T>) -> [T; 3]
where
    T: Copy + Sub<Output = T> + Mul<Output = T>,
{
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}

/// Whether all three have one sign; false for NaN.
#[inline(always)]
fn same_sign<T: PartialOrd + Default>(e: &[T; 3]) -> bool {
    let zero = T::default();
    (e[0] >= zero && e[1] >= zero && e[2] >= zero) || (e[0] <= zero && e[1] <= zero && e[2] <= zero)
}

impl Triangle {
    pub fn bounds(&self) -> Aabb {
        let [a, b, c] = self.v;
        Aabb { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        self.intersect_within(ray, ray.ray.t_min, ray.ray.t_max)
    }

    /// As [`Triangle::intersect`] with another interval.
    #[inline]
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        let permuted = |p: Vec3| [p[ray.k[0]], p[ray.k[1]], p[ray.k[2]]];
        let [x, y, _] = ray.shear;
        let sheared = shear(self.v.map(permuted), ray.origin, [x, y]);
        let edges = edges(sheared);
        if same_sign(&edges) { self.confirm(ray, &sheared, edges, t_min, t_max) } else { None }
    }

    /// The second half of the test, for a triangle whose edges passed the first one.
    #[inline]
    pub(crate) fn confirm(
        &self,
        ray: &PreparedRay,
        sheared: &Sheared<f32>,
        edges_f32: [f32; 3],
        t_min: f32,
        t_max: f32,
    ) -> Option<ShapeHit> {
        let e = if edges_f32.contains(&0.0) {
            // Products of two single precision numbers are exact in double precision, so these signs are right.
            let exact = edges(sheared.map(|corner| corner.map(f64::from)));
            if !same_sign(&exact) {
                return None;
            }
            exact
        } else {
            edges_f32.map(f64::from)
        };
        let det = e[0] + e[1] + e[2];
        let normal = self.area_normal();
        if det == 0.0 || normal == DVec3::ZERO {
            return None;
        }
        let mut t = self.plane_distance(normal, &ray.ray);
        if !t.is_finite() {
            // The ray lies in the plane to the last bit, yet a neighbour may count on this triangle to stop it.
            let (kz, origin) = (ray.k[2], ray.ray.origin.as_dvec3());
            let depth = |i: usize| e[i] * (f64::from(self.v[i][kz]) - origin[kz]);
            t = (depth(0) + depth(1) + depth(2)) / (det * f64::from(ray.ray.direction[kz]));
        }
        let t = Span::new(ray, &self.bounds(), t_min, t_max)?.place(t)?;
        Some(ShapeHit { t, u: (e[1] / det) as f32, v: (e[2] / det) as f32 })
    }

    /// What [`Triangle::confirm`] answers for a hit about which the error bounds of its edges leave no doubt: the ray
    /// passes inside, well away from the edges, so the distance is finite and inside the triangle's own box.
    #[inline(always)]
    pub(crate) fn place(&self, ray: &Ray, edges_f32: [f32; 3]) -> ShapeHit {
        let [a, b, c] = edges_f32;
        let e = [f64::from(a), f64::from(b), f64::from(c)];
        let det = e[0] + e[1] + e[2];
        let t = self.plane_distance(self.area_normal(), ray) as f32;
        ShapeHit { t, u: (e[1] / det) as f32, v: (e[2] / det) as f32 }
    }

    /// Where the ray meets the triangle's plane.
    #[inline(always)]
    fn plane_distance(&self, normal: DVec3, ray: &Ray) -> f64 {
        normal.dot(self.v[0].as_dvec3() - ray.origin.as_dvec3()) / normal.dot(ray.direction.as_dvec3())
    }

    /// Along the outside normal, twice as long as the area; zero for a triangle without area.
    #[inline(always)]
    fn area_normal(&self) -> DVec3 {
        let [a, b, c] = self.v;
        let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        (b - a).cross(c - a)
    }

    #[inline(always)]
    pub fn surface(&self, _ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        let (position, error) = self.point(hit.u, hit.v);
        SurfacePoint { position, error, normal: self.normal(), uv: Vec2::new(hit.u, hit.v) }
    }

    /// The unit normal on the outside; zero for a triangle without area.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.area_normal().normalize_or_zero().as_vec3()
    }

    /// The point with barycentric coordinates `u` and `v` of the vertices 1 and 2, and its error bound.
    #[inline]
    fn point(&self, u: f32, v: f32) -> (Vec3, Vec3) {
        let [a, b, c] = self.v.map(|v| v.as_dvec3());
        let point = a + (b - a) * f64::from(u) + (c - a) * f64::from(v);
        let magnitude = a.abs().max(b.abs()).max(c.abs()).max_element();
        rounded_point(point, magnitude)
    }

    pub fn area(&self) -> f32 {
        (self.area_normal().length() * 0.5) as f32
    }

    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        // Folds the half of the parallelogram that lies outside back into the triangle.
        let uv = if u.x + u.y > 1.0 { Vec2::ONE - u } else { u };
        let (position, error) = self.point(uv.x, uv.y);
        SurfaceSample { position, error, normal: self.normal(), uv }
    }

    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        Polygon::clipped(self.v.map(|v| v.as_dvec3()), clip).bounds().intersection(*clip)
    }

    /// The box around the part between two planes across `axis`, rounded outwards; empty if there is none. Many times as
    /// fast as [`Triangle::clipped_bounds`].
    pub fn bounds_between(&self, axis: usize, from: f32, to: f32) -> Aabb {
        let v = [self.v[0].as_dvec3(), self.v[1].as_dvec3(), self.v[2].as_dvec3()];
        let planes = [f64::from(from), f64::from(to)];
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..3 {
            let (p, q) = (v[i], v[(i + 1) % 3]);
            if (planes[0]..=planes[1]).contains(&p[axis]) {
                (min, max) = (min.min(p), max.max(p));
            }
            for plane in planes {
                if (p[axis] < plane) != (q[axis] < plane) && p[axis] != plane {
                    let mut crossing = p + (q - p) * ((plane - p[axis]) / (q[axis] - p[axis]));
                    crossing[axis] = plane;
                    (min, max) = (min.min(crossing), max.max(crossing));
                }
            }
        }
        if min.x > max.x { Aabb::EMPTY } else { outward_box(min, max) }
    }

    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        Polygon::clipped(self.v.map(|v| v.as_dvec3()), clip).area() as f32
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::super::checks::{check_shape, hit, random_direction, random_vec, rng, unit_square};
    use super::super::{Shape, Slabs};
    use super::*;

    fn triangle(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Triangle {
        Triangle { v: [a, b, c].map(Vec3::from_array) }
    }

    #[test]
    fn what_holds_for_every_shape() {
        check_shape(&Shape::Triangle(triangle([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])), false);
        let rng = &mut rng(1);
        for _ in 0..20 {
            let v = std::array::from_fn(|_| random_vec(rng, 2.0));
            check_shape(&Shape::Triangle(Triangle { v }), false);
        }
    }

    #[test]
    fn a_sliver_is_not_hit_by_rays_that_leave_it() {
        let rng = &mut rng(5);
        for _ in 0..50 {
            let (a, along) = (random_vec(rng, 5.0), random_vec(rng, 5.0));
            let c = a + along * rng.random_range(0.1..0.9) + random_vec(rng, 1e-4);
            let sliver = Triangle { v: [a, a + along, c] };
            for _ in 0..50 {
                let (u, v) = (rng.random_range(0.0..0.5), rng.random_range(0.0..0.5));
                let ray = Ray::new(Vec3::ZERO, Vec3::X);
                let surface = sliver.surface(&ray, &ShapeHit { t: 0.0, u, v });
                let direction = random_direction(rng);
                let leaving = Ray::new(surface.leave(direction), direction);
                let again = sliver.intersect(&PreparedRay::new(leaving));
                assert_eq!(again, None, "{sliver:?} {leaving:?}");
            }
        }
    }

    #[test]
    fn both_sides_are_hit_and_the_normal_stays_outside() {
        let t = triangle([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        for z in [-2.0, 2.0] {
            let ray = Ray::new(Vec3::new(0.25, 0.5, z), Vec3::new(0.0, 0.0, -z));
            let found = t.intersect(&PreparedRay::new(ray)).unwrap();
            assert_eq!((found.t, found.u, found.v), (1.0, 0.25, 0.5));
            let surface = t.surface(&ray, &found);
            assert_eq!((surface.normal, surface.position), (Vec3::Z, Vec3::new(0.25, 0.5, 0.0)));
        }
        assert_eq!(t.area(), 0.5);
    }

    #[test]
    fn triangles_without_area_or_with_nan_are_never_hit() {
        let flat = [
            triangle([1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.0]),
            triangle([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            triangle([-1.0, -1.0, 0.5], [0.0, 0.0, 0.5], [2.0, 2.0, 0.5]),
            triangle([-0.1, -0.2, -0.3], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6]),
            triangle([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            triangle([f32::NAN; 3], [f32::NAN; 3], [f32::NAN; 3]),
        ];
        let rng = &mut rng(3);
        for t in flat {
            for i in 0..2000 {
                let share: f32 = rng.random();
                let target = t.v[0].lerp(t.v[2], share);
                let target = if target.is_nan() { Vec3::ZERO } else { target };
                let origin =
                    if i % 2 == 0 { random_vec(rng, 3.0) } else { target - 2.0 * random_direction(rng) };
                assert_eq!(hit(&Shape::Triangle(t), origin, target - origin), None, "{t:?} {origin}");
            }
            assert!(t.area().is_nan() || t.area() == 0.0);
        }
    }

    #[test]
    fn rays_that_are_nan_or_have_no_direction_hit_nothing() {
        let t = Shape::Triangle(triangle([-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]));
        assert_eq!(hit(&t, Vec3::NAN, Vec3::Z), None);
        assert_eq!(hit(&t, Vec3::NEG_Z, Vec3::new(0.0, f32::NAN, 1.0)), None);
        assert_eq!(hit(&t, Vec3::NEG_Z, Vec3::ZERO), None);
        assert!(hit(&t, Vec3::NEG_Z, Vec3::Z).is_some());
    }

    /// A fan around an inner vertex, and every ray aimed at the vertex, the spokes and the rim's inside.
    #[test]
    fn no_ray_passes_between_triangles_that_share_an_edge() {
        let rng = &mut rng(11);
        for round in 0..60 {
            let offset = random_vec(rng, 100.0);
            // Every other fan is axis-aligned and flat, where boxes end at the shared edges.
            let lift = if round % 2 == 0 { 0.0 } else { 0.7 };
            let rim: [Vec3; 8] = [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)]
                .map(|(x, y)| offset + Vec3::new(x as f32, y as f32, lift * rng.random_range(-1.0..1.0)));
            let fan: [Triangle; 8] =
                std::array::from_fn(|i| Triangle { v: [offset, rim[i], rim[(i + 1) % 8]] });
            for _ in 0..300 {
                let spoke = rim[rng.random_range(0..8)];
                let share = if rng.random_range(0..4) == 0 { 0.0 } else { rng.random_range(0.0..0.99) };
                let target = offset.lerp(spoke, share);
                let away = Vec3::new(rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0), 50.0);
                let flat = [Vec3::ONE, Vec3::new(0.0, 1.0, 1.0), Vec3::new(1.0, 1e-6, 1.0), Vec3::Z];
                let origin = target + away * flat[rng.random_range(0..4)];
                let ray = PreparedRay::new(Ray::new(origin, target - origin));
                assert!(fan.iter().any(|t| t.intersect(&ray).is_some()), "{fan:?} {ray:?}");
            }
        }
    }

    /// Rays that all but lie in the triangle's plane, which they cross anywhere: what makes a tree and a test of every
    /// triangle disagree unless hits are confined.
    #[test]
    fn a_hit_lies_in_the_triangles_own_box_however_flat_the_ray() {
        let rng = &mut rng(12);
        let mut hits = 0;
        for _ in 0..50_000 {
            let t = Triangle { v: std::array::from_fn(|_| random_vec(rng, 2.0)) };
            let inside = |rng: &mut _| t.sample(unit_square(rng)).position;
            let (p, q) = (inside(rng), inside(rng));
            let origin = p + (p - q) * rng.random_range(0.0..20.0);
            let ray = PreparedRay::new(Ray::new(origin, q - origin));
            if let Some(found) = t.intersect(&ray) {
                let (enter, leave) = Slabs::new(&ray, &t.bounds()).interval(&t.bounds());
                assert!(enter <= found.t && found.t <= leave, "{t:?} {ray:?} {found:?}");
                hits += 1;
            }
        }
        assert!(hits > 1000, "only {hits} of these rays hit");
    }

    #[test]
    fn bounds_between_planes_are_those_of_the_clipped_triangle() {
        let rng = &mut rng(9);
        for round in 0..2000 {
            let coarse = |v: Vec3| if round % 2 == 0 { v.round() } else { v };
            let triangle = Triangle { v: std::array::from_fn(|_| coarse(random_vec(rng, 3.0))) };
            let whole = triangle.bounds();
            for axis in 0..3 {
                let mut ends = [0, 1].map(|_| coarse(random_vec(rng, 3.0))[axis]);
                ends.sort_by(f32::total_cmp);
                let mut clip = whole;
                clip.min[axis] = clip.min[axis].max(ends[0]);
                clip.max[axis] = clip.max[axis].min(ends[1]);
                let expected = if clip.is_empty() { Aabb::EMPTY } else { triangle.clipped_bounds(&clip) };
                let found = triangle.bounds_between(axis, ends[0], ends[1]);
                assert_eq!(found.is_empty(), expected.is_empty(), "{triangle:?} {axis} {ends:?}");
                let off = (found.min - expected.min).abs().max((found.max - expected.max).abs());
                assert!(found.is_empty() || off.max_element() < 1e-6, "{found:?} {expected:?} {triangle:?}");
            }
        }
    }
}
