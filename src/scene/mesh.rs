//! Triangles over shared vertices.

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
