//! Boxes seen through the camera: on which pixels they lie, and their edges clipped to what is seen.

use glam::{Vec2, Vec3};

use crate::geometry::Aabb;
use crate::scene::camera::CameraFrame;

/// The near plane lies at this share of the distance to the farthest corner of the scene.
const NEAR_SHARE: f32 = 1e-4;

/// Pixels around the edges of a box that its lines may touch.
const MARGIN: f32 = 1.5;

/// The corners at the two ends of a box's twelve edges, four along each axis. Corner bits: 0 for max x, 1 for max y,
/// 2 for max z.
const EDGES: [[[usize; 2]; 4]; 3] =
    [[[0, 1], [2, 3], [4, 5], [6, 7]], [[0, 2], [1, 3], [4, 6], [5, 7]], [[0, 4], [1, 5], [2, 6], [3, 7]]];

/// A camera turned for projecting many boxes. Camera space: x right, y up, z forward.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    pub frame: CameraFrame,
    near: f32,
    /// Normals in world space of the planes through the eye that bound what is seen: left, right, bottom, top.
    sides: [Vec3; 4],
    /// Pixels a unit of the camera-space direction with z = 1.
    scale: Vec2,
}

/// Pixels that a box may touch: rows and columns `min..max`, inside the picture, never empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    pub min: [u16; 2],
    pub max: [u16; 2],
}

/// What becomes of a box on screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    Outside,
    TooSmall,
    Seen {
        rect: PixelRect,
        /// Width + height of what lies inside the picture, in pixels.
        size: f32,
        /// Depth of the nearest corner along the camera's forward axis.
        depth: f32,
        /// Whether edges must be clipped.
        clipped: bool,
    },
}

impl Projector {
    /// For a scene inside `bounds`.
    pub fn new(frame: CameraFrame, bounds: &Aabb) -> Self {
        let farthest = bounds.corners().iter().map(|&c| (c - frame.eye).length()).fold(0.0, f32::max);
        let [x, y] = [frame.right, frame.up];
        let [right, up] = [frame.forward * frame.half_size.x, frame.forward * frame.half_size.y];
        let sides = [right + x, right - x, up + y, up - y];
        Self {
            frame,
            near: (farthest * NEAR_SHARE).max(f32::MIN_POSITIVE),
            sides,
            scale: 0.5 * frame.size / frame.half_size,
        }
    }

    /// `x` of the camera-space direction, with z = 1, through the centres of a column of pixels.
    #[inline]
    pub fn column_direction(&self, x: u32) -> f32 {
        (2.0 * (x as f32 + 0.5) / self.frame.size.x - 1.0) * self.frame.half_size.x
    }

    /// `y` of the camera-space direction, with z = 1, through the centres of a row of pixels.
    #[inline]
    pub fn row_direction(&self, y: u32) -> f32 {
        (1.0 - 2.0 * (y as f32 + 0.5) / self.frame.size.y) * self.frame.half_size.y
    }

    /// The corners in camera space, in the order of [`Aabb::corners`].
    #[inline]
    pub fn corners(&self, bounds: &Aabb) -> [Vec3; 8] {
        let f = &self.frame;
        let d = bounds.min - f.eye;
        let e = bounds.max - bounds.min;
        let base = Vec3::new(d.dot(f.right), d.dot(f.up), d.dot(f.forward));
        let axis = |i: usize| Vec3::new(f.right[i], f.up[i], f.forward[i]) * e[i];
        let (x, y, z) = (axis(0), axis(1), axis(2));
        let (bx, by, bxy) = (base + x, base + y, base + x + y);
        [base, bx, by, bxy, base + z, bx + z, by + z, bxy + z]
    }

    /// Pixels from the top left, and 1 / z, which is linear on the screen.
    #[inline]
    pub fn screen(&self, p: Vec3) -> Vec3 {
        let w = 1.0 / p.z;
        let middle = 0.5 * self.frame.size;
        Vec3::new(middle.x + p.x * w * self.scale.x, middle.y - p.y * w * self.scale.y, w)
    }

    /// Where a box lies on the screen.
    pub fn footprint(&self, bounds: &Aabb) -> Footprint {
        // The nearest and the farthest corner along a plane's normal, without looking at corners.
        let half = (bounds.max - bounds.min) * 0.5;
        let center = bounds.min + half - self.frame.eye;
        let span = |normal: Vec3| {
            let (at, reach) = (center.dot(normal), half.dot(normal.abs()));
            [at - reach, at + reach]
        };
        let [depth, depth_max] = span(self.frame.forward);
        // Written so that a NaN, which only absurd coordinates give, is outside.
        let mut inside = depth_max >= self.near;
        let mut clipped = depth < self.near;
        for side in self.sides {
            let [min, max] = span(side);
            inside &= max >= 0.0;
            clipped |= min < 0.0;
        }
        if !inside {
            return Footprint::Outside;
        }
        let (min, max) = self.screen_bounds(bounds, depth < self.near);
        if (max - min).max_element() < 1.0 {
            return Footprint::TooSmall;
        }
        self.seen(min, max, depth, clipped)
    }

    /// The rectangle around a box on the screen, or around its part before the near plane.
    fn screen_bounds(&self, bounds: &Aabb, crosses_near: bool) -> (Vec2, Vec2) {
        let corners = self.corners(bounds);
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let mut grow = |p: Vec3| {
            let p = self.screen(p).truncate();
            (min, max) = (min.min(p), max.max(p));
        };
        if crosses_near {
            for &[a, b] in EDGES.as_flattened() {
                let (a, b) = (corners[a], corners[b]);
                if let Some((a, b)) = clip(a, b, a.z - self.near, b.z - self.near) {
                    grow(a);
                    grow(b);
                }
            }
        } else {
            corners.into_iter().for_each(grow);
        }
        (min, max)
    }

    fn seen(&self, min: Vec2, max: Vec2, depth: f32, clipped: bool) -> Footprint {
        let size = self.frame.size;
        let (min, max) = (min.max(Vec2::ZERO), max.min(size));
        if !(min.x <= max.x && min.y <= max.y) {
            return Footprint::Outside;
        }
        // Pixels around, since a line is wider than its edge.
        let low = |v: f32| (v - MARGIN).max(0.0) as u16;
        let high = |v: f32, end: f32| (v + MARGIN + 1.0).min(end) as u16;
        let rect =
            PixelRect { min: [low(min.x), low(min.y)], max: [high(max.x, size.x), high(max.y, size.y)] };
        Footprint::Seen { rect, size: (max - min).element_sum(), depth, clipped }
    }

    /// Signed distances, up to scale, to the planes that bound what is seen (near, left, right, bottom, top): inside
    /// where all are at least 0.
    #[inline]
    fn planes(&self, p: Vec3) -> [f32; 5] {
        let x = self.frame.half_size.x * p.z;
        let y = self.frame.half_size.y * p.z;
        [p.z - self.near, p.x + x, x - p.x, p.y + y, y - p.y]
    }

    /// The edges of a box as lines on the screen (see [`Projector::screen`]), each once, clipped to what is seen.
    pub fn edges(&self, bounds: &Aabb, clipped: bool, mut draw: impl FnMut(Vec3, Vec3)) {
        let corners = self.corners(bounds);
        let screen = corners.map(|corner| self.screen(corner));
        let extent = bounds.extent();
        for (axis, edges) in EDGES.iter().enumerate() {
            if extent[axis] == 0.0 {
                continue;
            }
            for &[a, b] in edges {
                // Of edges that fall together in a flat box, the one at its min.
                if (0..3).any(|other| other != axis && extent[other] == 0.0 && a >> other & 1 == 1) {
                    continue;
                }
                if !clipped {
                    draw(screen[a], screen[b]);
                } else if let Some((a, b)) = self.clip(corners[a], corners[b]) {
                    draw(self.screen(a), self.screen(b));
                }
            }
        }
    }

    /// The part of a segment in camera space that is seen.
    fn clip(&self, mut a: Vec3, mut b: Vec3) -> Option<(Vec3, Vec3)> {
        for plane in 0..5 {
            (a, b) = clip(a, b, self.planes(a)[plane], self.planes(b)[plane])?;
        }
        Some((a, b))
    }
}

/// The part of a segment on the side of a plane where the distance, linear along it, is at least 0.
fn clip(a: Vec3, b: Vec3, distance_a: f32, distance_b: f32) -> Option<(Vec3, Vec3)> {
    let cut = || a + (b - a) * (distance_a / (distance_a - distance_b));
    match (distance_a >= 0.0, distance_b >= 0.0) {
        (true, true) => Some((a, b)),
        (true, false) => Some((a, cut())),
        (false, true) => Some((cut(), b)),
        (false, false) => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Looks from the origin along -z; 90 degrees wide and high; 100 x 100 pixels.
    pub fn front_frame() -> CameraFrame {
        CameraFrame {
            eye: Vec3::ZERO,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            half_size: Vec2::ONE,
            pixel_size: Vec2::splat(0.02),
            size: Vec2::splat(100.0),
        }
    }

    fn projector() -> Projector {
        Projector::new(front_frame(), &Aabb::new(Vec3::splat(-100.0), Vec3::splat(100.0)))
    }

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb::new(center - half, center + half)
    }

    #[test]
    fn corners_agree_with_the_camera() {
        let p = projector();
        let bounds = Aabb::new(Vec3::new(-1.0, 2.0, -9.0), Vec3::new(3.0, 4.0, -5.0));
        for (seen, corner) in p.corners(&bounds).into_iter().zip(bounds.corners()) {
            let (ours, theirs) = (p.screen(seen), p.frame.project(corner));
            assert!((ours.truncate() - theirs.truncate()).length() < 1e-3);
            assert!((1.0 / ours.z - theirs.z).abs() < 1e-4);
        }
    }

    #[test]
    fn a_box_is_outside_too_small_or_seen() {
        let p = projector();
        assert_eq!(p.footprint(&cube(Vec3::new(0.0, 0.0, 5.0), 1.0)), Footprint::Outside);
        assert_eq!(p.footprint(&cube(Vec3::new(40.0, 0.0, -5.0), 1.0)), Footprint::Outside);
        assert_eq!(p.footprint(&cube(Vec3::new(0.0, 0.0, -50.0), 0.2)), Footprint::TooSmall);
        let Footprint::Seen { rect, size, clipped, depth } =
            p.footprint(&cube(Vec3::new(0.0, 0.0, -5.0), 1.0))
        else {
            panic!("it lies in the middle of the picture");
        };
        // Its near side, at distance 4, covers a quarter of 100 pixels each way from the middle: 37.5 to 62.5.
        assert!(!clipped && (size - 50.0).abs() < 1e-3 && (depth - 4.0).abs() < 1e-5);
        assert_eq!((rect.min, rect.max), ([36, 36], [65, 65]));
    }

    #[test]
    fn a_box_around_the_eye_covers_the_picture() {
        let p = projector();
        let Footprint::Seen { rect, clipped, .. } = p.footprint(&cube(Vec3::ZERO, 10.0)) else {
            panic!("the eye is inside");
        };
        assert!(clipped);
        assert_eq!((rect.min, rect.max), ([0, 0], [100, 100]));
    }

    #[test]
    fn absurd_coordinates_are_outside() {
        let p = projector();
        let huge = Aabb::new(Vec3::splat(-3e38), Vec3::splat(3e38));
        let _ = p.footprint(&huge);
        p.edges(&huge, true, |_, _| ());
        assert_eq!(p.footprint(&cube(Vec3::splat(f32::NAN), 1.0)), Footprint::Outside);
    }

    fn edges(bounds: &Aabb, clipped: bool) -> Vec<(Vec3, Vec3)> {
        let mut out = Vec::new();
        projector().edges(bounds, clipped, |a, b| out.push((a, b)));
        out
    }

    #[test]
    fn a_flat_box_has_four_edges_and_a_needle_one() {
        let at = |e: Vec3| Aabb::new(Vec3::new(0.0, 0.0, -5.0), Vec3::new(0.0, 0.0, -5.0) + e);
        assert_eq!(edges(&at(Vec3::ONE), false).len(), 12);
        assert_eq!(edges(&at(Vec3::new(1.0, 0.0, 1.0)), false).len(), 4);
        assert_eq!(edges(&at(Vec3::new(0.0, 1.0, 0.0)), false).len(), 1);
        assert_eq!(edges(&at(Vec3::ZERO), false).len(), 0);
    }

    #[test]
    fn clipped_edges_stay_inside_the_picture_and_before_the_eye() {
        let lines = edges(&cube(Vec3::new(1.0, 0.5, -1.0), 3.0), true);
        assert!(!lines.is_empty());
        for point in lines.iter().flat_map(|(a, b)| [a, b]) {
            assert!(point.z > 0.0 && point.truncate().cmpge(Vec2::splat(-0.01)).all(), "{point}");
            assert!(point.truncate().cmple(Vec2::splat(100.01)).all(), "{point}");
        }
    }
}
