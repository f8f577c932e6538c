//! Clipping a convex polygon to a box (Sutherland, Hodgman, "Reentrant Polygon Clipping", 1974), in double precision.

use glam::DVec3;

use super::Aabb;
use super::rounding::outward_box;

/// A quad's corners and one more for each of the six sides that may cut it.
const CAPACITY: usize = 10;

/// The part of a convex polygon inside a box.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    corners: [DVec3; CAPACITY],
    len: usize,
}

impl Polygon {
    /// A whole polygon of at most four corners.
    pub fn new<const N: usize>(corners: [DVec3; N]) -> Self {
        const { assert!(N <= 4, "no room for more corners") };
        let mut polygon = Self { corners: [DVec3::ZERO; CAPACITY], len: N };
        polygon.corners[..N].copy_from_slice(&corners);
        polygon
    }

    /// The part of the polygon with these corners (at most four) inside `clip`.
    pub fn clipped<const N: usize>(corners: [DVec3; N], clip: &Aabb) -> Self {
        Self::new(corners).inside(clip)
    }

    /// The part inside `clip`.
    #[must_use]
    pub fn inside(&self, clip: &Aabb) -> Self {
        let mut polygon = *self;
        for axis in 0..3 {
            for (side, at) in [(1.0, clip.min[axis]), (-1.0, clip.max[axis])] {
                let at = f64::from(at);
                // Most sides cut nothing off.
                if polygon.corners[..polygon.len].iter().any(|p| side * (p[axis] - at) < 0.0) {
                    polygon = polygon.cut(axis, side, at);
                }
            }
        }
        polygon
    }

    /// Keeps the side of the plane where `side * p[axis] >= side * at`.
    fn cut(&self, axis: usize, side: f64, at: f64) -> Self {
        let mut kept = Self { corners: [DVec3::ZERO; CAPACITY], len: 0 };
        for i in 0..self.len {
            let (p, q) = (self.corners[i], self.corners[(i + 1) % self.len]);
            let (height_p, height_q) = (side * (p[axis] - at), side * (q[axis] - at));
            if height_p >= 0.0 {
                kept.push(p);
            }
            if (height_p > 0.0 && height_q < 0.0) || (height_p < 0.0 && height_q > 0.0) {
                let mut crossing = p + (q - p) * (height_p / (height_p - height_q));
                crossing[axis] = at;
                kept.push(crossing);
            }
        }
        kept
    }

    fn push(&mut self, corner: DVec3) {
        // A convex polygon never overflows; rounding can make one that is flat to the last bit not quite convex.
        if self.len < CAPACITY {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The box around what is left, rounded outwards; empty if nothing is.
    pub fn bounds(&self) -> Aabb {
        let corners = &self.corners[..self.len];
        if corners.is_empty() {
            return Aabb::EMPTY;
        }
        let min = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let max = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        outward_box(min, max)
    }

    pub fn area(&self) -> f64 {
        let corners = &self.corners[..self.len];
        let Some(&first) = corners.first() else { return 0.0 };
        corners.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum::<DVec3>().length() * 0.5
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    const SQUARE: [DVec3; 4] =
        [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.0, 4.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];

    fn clip(min: [f32; 3], max: [f32; 3]) -> Aabb {
        Aabb::new(Vec3::from_array(min), Vec3::from_array(max))
    }

    #[test]
    fn inside_outside_and_across() {
        let all = Polygon::clipped(SQUARE, &clip([-1.0; 3], [9.0; 3]));
        assert_eq!((all.area(), all.bounds()), (16.0, clip([0.0; 3], [4.0, 4.0, 0.0])));
        let none = Polygon::clipped(SQUARE, &clip([-1.0, -1.0, 1.0], [9.0; 3]));
        assert_eq!((none.area(), none.bounds()), (0.0, Aabb::EMPTY));
        let part = Polygon::clipped(SQUARE, &clip([1.0, 3.0, -1.0], [3.0, 9.0, 1.0]));
        assert_eq!((part.area(), part.bounds()), (2.0, clip([1.0, 3.0, 0.0], [3.0, 4.0, 0.0])));
    }

    #[test]
    fn a_polygon_in_the_side_of_the_box_is_inside() {
        let flush = Polygon::clipped(SQUARE, &clip([0.0, 0.0, -1.0], [4.0, 4.0, 0.0]));
        assert_eq!(flush.area(), 16.0);
    }

    #[test]
    fn a_triangle_cut_by_six_sides_has_nine_corners() {
        // x + y + z = 0 through a cube around the origin is a hexagon; a large triangle in that plane covers it.
        let far = 100.0;
        let triangle = [DVec3::new(far, -far, 0.0), DVec3::new(-far, 0.0, far), DVec3::new(0.0, far, -far)];
        let hexagon = Polygon::clipped(triangle, &clip([-1.0; 3], [1.0; 3]));
        assert!((hexagon.area() - 3.0 * 3f64.sqrt()).abs() < 1e-12, "{}", hexagon.area());
        assert_eq!(hexagon.bounds(), clip([-1.0; 3], [1.0; 3]));
    }

    #[test]
    fn parts_on_both_sides_of_a_plane_add_up() {
        let triangle = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.7, -0.4, 2.2), DVec3::new(-0.6, 1.9, 0.8)];
        let whole = Polygon::clipped(triangle, &clip([-9.0; 3], [9.0; 3])).area();
        for at in [-0.3f32, 0.0, 0.4, 1.1] {
            let low = Polygon::clipped(triangle, &clip([-9.0; 3], [at, 9.0, 9.0])).area();
            let high = Polygon::clipped(triangle, &clip([at, -9.0, -9.0], [9.0; 3])).area();
            assert!((low + high - whole).abs() < 1e-14, "{at}: {low} + {high} != {whole}");
        }
    }
}
