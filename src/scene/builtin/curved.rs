//! Rounds a coarse mesh: every triangle becomes a curved patch through its corners, at right angles to their normals.
//!
//! After Vlachos, Peters, Boyd, Mitchell, "Curved PN Triangles" (2001).

use std::collections::HashMap;

use glam::Vec3;

use crate::scene::Mesh;

/// The same surface with every edge cut into `segments`, smooth normals included. The mesh must have a normal at each
/// position, at the same index.
pub(super) fn curved(mesh: &Mesh, segments: u32) -> Mesh {
    let mut points = Points { positions: mesh.positions.clone(), on_edges: HashMap::new(), segments };
    let mut triangles = Vec::with_capacity(mesh.triangles.len() * (segments * segments) as usize);
    for triangle in &mesh.triangles {
        let patch = Patch::new(mesh, triangle.position);
        let mut row = points.row(&patch, 0);
        for i in 1..=segments {
            let next = points.row(&patch, i);
            for j in 0..i as usize {
                triangles.push([row[j], next[j], next[j + 1]]);
                if j + 1 < i as usize {
                    triangles.push([row[j], next[j + 1], row[j + 1]]);
                }
            }
            row = next;
        }
    }
    let mut curved = Mesh::flat(points.positions, &triangles);
    curved.compute_smooth_normals();
    curved
}

/// A cubic Bezier triangle over a triangle of the mesh.
struct Patch {
    corners: [u32; 3],
    p: [Vec3; 3],
    /// The inner control points of the edge from corner i to the next: near i, and near the next.
    edges: [[Vec3; 2]; 3],
    middle: Vec3,
}

impl Patch {
    fn new(mesh: &Mesh, corners: [u32; 3]) -> Self {
        let p = corners.map(|c| mesh.positions[c as usize]);
        let n = corners.map(|c| mesh.normals[c as usize]);
        // A third of the way from corner i to corner j, in the plane at right angles to the normal at i.
        let near = |i: usize, j: usize| (2.0 * p[i] + p[j] - (p[j] - p[i]).dot(n[i]) * n[i]) / 3.0;
        let edges = [0, 1, 2].map(|i| [near(i, (i + 1) % 3), near((i + 1) % 3, i)]);
        let mean_edge = edges.iter().flatten().sum::<Vec3>() / 6.0;
        let mean_corner = (p[0] + p[1] + p[2]) / 3.0;
        Self { corners, p, edges, middle: mean_edge + (mean_edge - mean_corner) / 2.0 }
    }

    /// The point of barycentric coordinates `b`.
    fn at(&self, b: [f32; 3]) -> Vec3 {
        let mut point = 6.0 * b[0] * b[1] * b[2] * self.middle;
        for i in 0..3 {
            let (here, next) = (b[i], b[(i + 1) % 3]);
            point += here.powi(3) * self.p[i];
            point += 3.0 * here * next * (here * self.edges[i][0] + next * self.edges[i][1]);
        }
        point
    }
}

/// The points made so far; those on edges are shared by the triangles there.
struct Points {
    positions: Vec<Vec3>,
    /// By the edge's corners, ascending, and the place on it from the first.
    on_edges: HashMap<(u32, u32, u32), u32>,
    segments: u32,
}

impl Points {
    /// The indices of row `i` of a patch's grid: from the edge 0-1 to the edge 0-2, corner 0 being row 0.
    fn row(&mut self, patch: &Patch, i: u32) -> Vec<u32> {
        (0..=i).map(|j| self.point(patch, [self.segments - i, i - j, j])).collect()
    }

    /// The index of the point whose barycentric coordinates are `weights` over the number of segments.
    fn point(&mut self, patch: &Patch, weights: [u32; 3]) -> u32 {
        let b = weights.map(|w| w as f32 / self.segments as f32);
        if let Some(corner) = (0..3).find(|c| weights[*c] == self.segments) {
            return patch.corners[corner];
        }
        let new = self.positions.len() as u32;
        let index = match (0..3).find(|c| weights[*c] == 0) {
            Some(opposite) => {
                let (i, j) = ((opposite + 1) % 3, (opposite + 2) % 3);
                let (a, b) = (patch.corners[i], patch.corners[j]);
                let key = if a < b { (a, b, weights[j]) } else { (b, a, weights[i]) };
                *self.on_edges.entry(key).or_insert(new)
            }
            None => new,
        };
        if index == new {
            self.positions.push(patch.at(b));
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube's corners on the unit sphere, with their directions as normals.
    fn coarse_sphere() -> Mesh {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let mut mesh = Mesh::flat((0..8).map(|i| corner(i).normalize()).collect(), &triangles);
        mesh.compute_smooth_normals();
        mesh.normals = mesh.positions.clone();
        mesh
    }

    #[test]
    fn a_cube_becomes_nearly_a_sphere_and_stays_closed() {
        let coarse = coarse_sphere();
        let round = curved(&coarse, 4);
        assert_eq!(round.triangles.len(), 12 * 16);
        // Euler: a closed surface has half as many positions as triangles, and two more.
        assert_eq!(round.positions.len(), 12 * 16 / 2 + 2);
        let roundness = |m: &Mesh| {
            let corners = m.triangles.iter().map(|t| t.position.map(|i| m.positions[i as usize]));
            let middles: Vec<f32> = corners.map(|c| c.iter().sum::<Vec3>().length() / 3.0).collect();
            middles.iter().sum::<f32>() / middles.len() as f32
        };
        for (i, p) in round.positions.iter().enumerate() {
            // The flattest place: the middle of a square's diagonal, an arc of 109.5 degrees, at (4 + 4/3) / 8 * 2 / sqrt 3.
            assert!((0.769..1.05).contains(&p.length()), "{p}");
            assert!(round.normals[i].dot(p.normalize()) > 0.9, "{p} faces {}", round.normals[i]);
        }
        // A flat triangle of three of the cube's corners has its middle at sqrt(11) / sqrt(27).
        assert!((roundness(&coarse) - (11.0_f32 / 27.0).sqrt()).abs() < 1e-5);
        assert!(roundness(&round) > 0.8, "{}", roundness(&round));
    }

    #[test]
    fn corners_stay_and_one_segment_changes_nothing() {
        let coarse = coarse_sphere();
        let same = curved(&coarse, 1);
        assert_eq!(same.positions, coarse.positions);
        let positions = |m: &Mesh| m.triangles.iter().map(|t| t.position).collect::<Vec<_>>();
        assert_eq!(positions(&same), positions(&coarse));
    }
}
