//! The embedded meshes: binary PLY files of the one layout that `assets/` uses.

use std::collections::HashMap;

use glam::Vec3;

use crate::scene::Mesh;

/// Positions and triangles of an embedded file. Little-endian; three floats a vertex; a byte 3 and three 16-bit indices a
/// face, as the files' headers say.
pub(super) fn read(bytes: &[u8]) -> Mesh {
    const HEADER_END: &[u8] = b"end_header\n";
    let end =
        bytes.windows(HEADER_END.len()).position(|w| w == HEADER_END).expect("an embedded mesh has a header");
    let (header, body) = bytes.split_at(end + HEADER_END.len());
    let header = std::str::from_utf8(header).expect("an embedded header is text");
    let count = |element: &str| -> usize {
        let value = header.lines().find_map(|line| line.strip_prefix(element)?.trim().parse().ok());
        value.expect("an embedded header counts its elements")
    };
    let (vertices, faces) = body.split_at(count("element vertex ") * 12);
    let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let index = |b: &[u8]| u32::from(u16::from_le_bytes([b[0], b[1]]));
    let positions =
        vertices.chunks_exact(12).map(|v| Vec3::new(float(v), float(&v[4..]), float(&v[8..]))).collect();
    let triangles: Vec<[u32; 3]> =
        faces.chunks_exact(7).map(|f| [index(&f[1..]), index(&f[3..]), index(&f[5..])]).collect();
    assert_eq!(triangles.len(), count("element face "), "an embedded mesh is whole");
    Mesh::flat(positions, &triangles)
}

/// Makes vertices at the same place one, and drops those that no triangle uses; without normals and coordinates.
pub(super) fn welded(mesh: &Mesh) -> Mesh {
    let mut indices = HashMap::new();
    let mut positions = Vec::new();
    let mut index_of = |old: u32| {
        let position = mesh.positions[old as usize];
        *indices.entry(position.to_array().map(f32::to_bits)).or_insert_with(|| {
            positions.push(position);
            positions.len() as u32 - 1
        })
    };
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.position.map(&mut index_of)).collect();
    Mesh::flat(positions, &triangles)
}
