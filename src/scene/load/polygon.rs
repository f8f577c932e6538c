//! Cuts faces with more than three corners into triangles, concave ones too.

use earcut::Earcut;
use glam::{DVec3, Vec3};

/// Cuts polygons; kept between faces for its buffers.
pub(super) struct PolygonCutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl PolygonCutter {
    /// A face with more corners is no face of a model, and cutting it would take too long.
    pub const MAX_CORNERS: usize = 1 << 16;

    pub fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), triangles: Vec::new() }
    }

    /// Indices into `corners`, three a triangle, that turn the same way as the face. What has no area is cut into a fan, so
    /// that its degenerate triangles stay.
    pub fn cut(&mut self, corners: &[Vec3]) -> &[u32] {
        self.triangles.clear();
        match corners {
            [] | [_] | [_, _] => {}
            [_, _, _] => self.triangles.extend([0, 1, 2]),
            [a, b, c, d] => {
                let other_diagonal =
                    are_opposed([*a, *b, *c], [*a, *c, *d]) && !are_opposed([*a, *b, *d], [*b, *c, *d]);
                self.triangles.extend(if other_diagonal { [0, 1, 3, 1, 2, 3] } else { [0, 1, 2, 0, 2, 3] });
            }
            _ => self.cut_ears(corners),
        }
        &self.triangles
    }

    fn cut_ears(&mut self, corners: &[Vec3]) {
        let first = corners[0].as_dvec3();
        let offsets = || corners.iter().map(|c| c.as_dvec3() - first);
        let normal = newell_normal(offsets());
        let size = normal.abs();
        let k = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        // Seen along the normal's longest axis from the side where the face turns counter-clockwise.
        let (i, j) = if normal[k] >= 0.0 { ((k + 1) % 3, (k + 2) % 3) } else { ((k + 2) % 3, (k + 1) % 3) };
        self.flat.clear();
        self.flat.extend(offsets().map(|c| [c[i], c[j]]));
        if normal.length_squared() > 0.0 {
            self.earcut.earcut_slice(&self.flat, &[], &mut self.triangles);
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..corners.len() as u32).flat_map(|i| [0, i - 1, i]));
            return;
        }
        for triangle in self.triangles.chunks_exact_mut(3) {
            let [a, b, c] = [0, 1, 2].map(|corner| self.flat[triangle[corner] as usize]);
            if (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0.0 {
                triangle.swap(1, 2);
            }
        }
    }
}

/// Whether two triangles face away from each other.
fn are_opposed(a: [Vec3; 3], b: [Vec3; 3]) -> bool {
    let normal = |t: [Vec3; 3]| {
        let p = t.map(|v| v.as_dvec3());
        (p[1] - p[0]).cross(p[2] - p[0])
    };
    normal(a).dot(normal(b)) < 0.0
}

/// Twice the area of a polygon as a vector along its normal (Newell's method; Sutherland et al., 1974).
fn newell_normal(corners: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(a, b)| a.cross(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts a polygon and checks that the triangles cover its area and turn as it does.
    fn check(corners: &[Vec3], triangles: usize) {
        let normal = newell_normal(corners.iter().map(|c| c.as_dvec3()));
        let mut cutter = PolygonCutter::new();
        let cut = cutter.cut(corners).to_vec();
        assert_eq!(cut.len(), triangles * 3, "{corners:?}");
        let mut area = 0.0;
        for t in cut.chunks_exact(3) {
            let p = [0, 1, 2].map(|i| corners[t[i] as usize].as_dvec3());
            let cross = (p[1] - p[0]).cross(p[2] - p[0]);
            assert!(cross.dot(normal) >= 0.0, "{t:?} of {corners:?} is turned");
            area += cross.length();
        }
        assert!(
            (area - normal.length()).abs() <= 1e-6 * normal.length(),
            "{corners:?}: {area} of {}",
            normal.length()
        );
    }

    fn in_plane(points: &[(f32, f32)], u: Vec3, v: Vec3) -> Vec<Vec3> {
        points.iter().map(|(x, y)| Vec3::new(5.0, -3.0, 2.0) + u * *x + v * *y).collect()
    }

    #[test]
    fn concave_faces_are_cut_properly_in_any_plane_and_direction() {
        let arrow = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (0.5, 1.0)];
        let l_shape = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
        let comb =
            [(0.0, 0.0), (5.0, 0.0), (5.0, 3.0), (4.0, 3.0), (4.0, 1.0), (2.0, 1.0), (2.0, 3.0), (0.0, 3.0)];
        let pentagon = [(0.0, 0.0), (2.0, 0.0), (3.0, 1.5), (1.0, 3.0), (-1.0, 1.5)];
        for (u, v) in [
            (Vec3::X, Vec3::Y),
            (Vec3::Y, Vec3::Z),
            (Vec3::X, Vec3::Z),
            (Vec3::ONE, Vec3::new(1.0, -1.0, 0.3)),
        ] {
            for points in [&arrow[..], &l_shape, &comb, &pentagon] {
                for turn in 0..points.len() {
                    let mut corners = in_plane(points, u, v);
                    corners.rotate_left(turn);
                    check(&corners, points.len() - 2);
                    corners.reverse();
                    check(&corners, points.len() - 2);
                }
            }
        }
    }

    #[test]
    fn faces_without_area_stay_as_degenerate_triangles() {
        let mut cutter = PolygonCutter::new();
        assert_eq!(cutter.cut(&[Vec3::ONE; 5]).len(), 9);
        assert_eq!(cutter.cut(&[Vec3::ONE; 4]).len(), 6);
        assert_eq!(cutter.cut(&[Vec3::ONE; 3]).len(), 3);
        assert!(cutter.cut(&[Vec3::ONE; 2]).is_empty());
        let line: Vec<Vec3> = (0..6).map(|i| Vec3::X * i as f32).collect();
        assert_eq!(cutter.cut(&line).len(), 12);
    }

    #[test]
    fn many_corners_are_cut_in_time() {
        let count = PolygonCutter::MAX_CORNERS / 8;
        let corner = |i: usize| {
            let angle = i as f32 / count as f32 * std::f32::consts::TAU;
            Vec3::new(angle.cos(), angle.sin(), 0.0) * if i.is_multiple_of(2) { 2.0 } else { 1.0 }
        };
        let star: Vec<Vec3> = (0..count).map(corner).collect();
        check(&star, count - 2);
    }
}
