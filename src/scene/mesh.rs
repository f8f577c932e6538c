//! Triangles over shared vertices, their smooth normals, and refinement by bisection.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use glam::{Vec2, Vec3};

/// Vertex indices of a triangle. `NO_INDEX` stands for a missing normal or texture coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshTriangle {
    pub position: [u32; 3],
    pub normal: [u32; 3],
    pub uv: [u32; 3],
}

impl MeshTriangle {
    pub const NO_INDEX: u32 = u32::MAX;

    /// A triangle without normals and texture coordinates.
    pub fn flat(position: [u32; 3]) -> Self {
        Self { position, normal: [Self::NO_INDEX; 3], uv: [Self::NO_INDEX; 3] }
    }
}

/// All triangles of a scene. Every index of a triangle is in range.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<MeshTriangle>,
}

impl Mesh {
    /// A mesh of positions only.
    pub fn flat(positions: Vec<Vec3>, triangles: &[[u32; 3]]) -> Self {
        let triangles = triangles.iter().map(|&t| MeshTriangle::flat(t)).collect();
        Self { positions, triangles, ..Self::default() }
    }

    /// Gives every position one normal, at the same index: the mean of the normals of the triangles around it, each
    /// weighted by its angle there (Thuermer and Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998).
    pub fn compute_smooth_normals(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for triangle in &mut self.triangles {
            triangle.normal = triangle.position;
            let p = triangle.position.map(|i| self.positions[i as usize]);
            let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
            for corner in 0..3 {
                let a = p[(corner + 1) % 3] - p[corner];
                let b = p[(corner + 2) % 3] - p[corner];
                sums[triangle.position[corner] as usize] += normal * a.cross(b).length().atan2(a.dot(b));
            }
        }
        self.normals = sums.into_iter().map(|sum| sum.normalize_or(Vec3::Y)).collect();
    }

    /// Cuts the longest edge in the middle, `times` times over: each of its one or two triangles becomes two. Of equally
    /// long edges the one with the lowest vertex indices comes first, so that the result is always the same. Normals and
    /// texture coordinates are dropped.
    pub fn bisect_longest_edges(&mut self, times: usize) {
        let mut edges = Edges::of(self);
        for _ in 0..times {
            let Some(Edge { length_squared: _, vertices: [a, b] }) = edges.pop_longest() else { break };
            let middle = self.positions.len() as u32;
            self.positions.push((self.positions[a as usize] + self.positions[b as usize]) * 0.5);
            for triangle_idx in edges.take_triangles([a, b]) {
                let corners = self.triangles[triangle_idx as usize].position;
                let with = |old: u32| MeshTriangle::flat(corners.map(|v| if v == old { middle } else { v }));
                let added = self.triangles.len() as u32;
                self.triangles[triangle_idx as usize] = with(b);
                self.triangles.push(with(a));
                let opposite = corners.into_iter().find(|v| *v != a && *v != b).unwrap_or(middle);
                edges.replace_triangle([b, opposite], triangle_idx, added);
                edges.add([a, middle], triangle_idx, &self.positions);
                edges.add([middle, b], added, &self.positions);
                edges.add([middle, opposite], triangle_idx, &self.positions);
                edges.add([middle, opposite], added, &self.positions);
            }
        }
        self.normals.clear();
        self.uvs.clear();
        for triangle in &mut self.triangles {
            *triangle = MeshTriangle::flat(triangle.position);
        }
    }
}

/// An edge in the order of the queue: long ones are greater, then those with lower vertex indices.
#[derive(Clone, Copy, Debug)]
struct Edge {
    length_squared: f32,
    /// Ascending.
    vertices: [u32; 2],
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        self.length_squared.total_cmp(&other.length_squared).then_with(|| other.vertices.cmp(&self.vertices))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Edge {}

/// The triangles at every edge, and the edges by length.
#[derive(Default)]
struct Edges {
    triangles: BTreeMap<[u32; 2], Vec<u32>>,
    queue: BinaryHeap<Edge>,
}

impl Edges {
    fn of(mesh: &Mesh) -> Self {
        let mut edges = Self::default();
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.position;
            for edge in [[a, b], [b, c], [c, a]] {
                edges.add(edge, i as u32, &mesh.positions);
            }
        }
        edges
    }

    fn add(&mut self, vertices: [u32; 2], triangle: u32, positions: &[Vec3]) {
        let key = ascending(vertices);
        let triangles = self.triangles.entry(key).or_default();
        if triangles.is_empty() {
            let length_squared = positions[key[0] as usize].distance_squared(positions[key[1] as usize]);
            self.queue.push(Edge { length_squared, vertices: key });
        }
        if !triangles.contains(&triangle) {
            triangles.push(triangle);
        }
    }

    fn pop_longest(&mut self) -> Option<Edge> {
        self.queue.pop()
    }

    fn take_triangles(&mut self, edge: [u32; 2]) -> Vec<u32> {
        self.triangles.remove(&ascending(edge)).unwrap_or_default()
    }

    fn replace_triangle(&mut self, edge: [u32; 2], old: u32, new: u32) {
        for triangle in self.triangles.get_mut(&ascending(edge)).into_iter().flatten() {
            if *triangle == old {
                *triangle = new;
            }
        }
    }
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed tetrahedron, outside outwards.
    fn tetrahedron() -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X * 3.0, Vec3::Y, Vec3::Z];
        Mesh::flat(positions, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    }

    /// Six times the enclosed volume, and whether every edge is passed once in either direction.
    fn volume_and_closed(mesh: &Mesh) -> (f32, bool) {
        let mut directed = std::collections::BTreeSet::new();
        let mut volume = 0.0;
        let mut once = true;
        for t in &mesh.triangles {
            let p = t.position.map(|i| mesh.positions[i as usize]);
            volume += p[0].dot(p[1].cross(p[2]));
            for k in 0..3 {
                once &= directed.insert([t.position[k], t.position[(k + 1) % 3]]);
            }
        }
        (volume, once && directed.iter().all(|[a, b]| directed.contains(&[*b, *a])))
    }

    #[test]
    fn bisection_adds_two_triangles_an_inner_edge_and_keeps_the_solid() {
        let mut mesh = tetrahedron();
        let before = volume_and_closed(&mesh);
        assert!(before.0 > 0.0 && before.1);
        mesh.bisect_longest_edges(50);
        assert_eq!(mesh.triangles.len(), 4 + 100);
        let after = volume_and_closed(&mesh);
        assert!((after.0 - before.0).abs() < 1e-4 && after.1, "{after:?}");
        let longest = mesh.triangles.iter().map(|t| {
            let p = t.position.map(|i| mesh.positions[i as usize]);
            p[0].distance(p[1]).max(p[1].distance(p[2])).max(p[2].distance(p[0]))
        });
        assert!(longest.fold(0.0, f32::max) < 1.0);
    }

    #[test]
    fn bisection_cuts_the_longest_edge_first() {
        let mut mesh = Mesh::flat(vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Y], &[[0, 1, 2]]);
        mesh.bisect_longest_edges(1);
        assert_eq!(mesh.positions[3], Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(mesh.triangles.len(), 2);
    }

    #[test]
    fn smooth_normals_point_outwards_and_have_unit_length() {
        let mut mesh = tetrahedron();
        mesh.bisect_longest_edges(20);
        mesh.compute_smooth_normals();
        let center = Vec3::new(0.5, 0.2, 0.2);
        for t in &mesh.triangles {
            assert_eq!(t.normal, t.position);
            for i in t.position.map(|i| i as usize) {
                assert!((mesh.normals[i].length() - 1.0).abs() < 1e-5);
                assert!(mesh.normals[i].dot(mesh.positions[i] - center) > 0.0);
            }
        }
    }

    #[test]
    fn a_degenerate_triangle_leaves_normals_sound() {
        let mut mesh = Mesh::flat(vec![Vec3::ZERO; 3], &[[0, 1, 2], [0, 0, 0]]);
        mesh.compute_smooth_normals();
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    }
}
