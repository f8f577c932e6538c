//! PLY through `ply-rs-bw`: its header and its binary data.
//!
//! Data in text is read here: the crate's grammar knows no `nan`, `.5` or `5.`, and a file that has them should open.

mod element;

use std::io::{BufReader, ErrorKind};

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess};

use super::fault::{Fault, Watched, excerpt, guarded};
use super::model::{Corner, Model};
use crate::task::Task;
use element::{FaceElement, Skipped, VertexElement};

/// Lines between two looks at the task.
const CHECK_EVERY: usize = 4096;

/// Reads a model; its faces are those of the file, or else the triangles of its strips.
pub(super) fn read(bytes: &[u8], task: &Task) -> Result<Model, Fault> {
    if !bytes.starts_with(b"ply") {
        return Err(Fault::at_byte(
            0,
            "the file does not begin with 'ply': it is no PLY file, or a damaged one",
        ));
    }
    let (header_text, body) = split_header(bytes)?;
    let header = guarded("PLY", || {
        let mut reader = Reader::new(header_text.as_bytes());
        Parser::<Skipped>::new().read_header(&mut reader).map_err(|error| {
            let line = error.line().unwrap_or(1);
            let text = header_text.lines().nth(line - 1).unwrap_or_default();
            Fault::at_line(
                line,
                format!("'{}' is no line of a PLY header; export the model again", excerpt(text)),
            )
        })
    })??;
    let mut content = Content::default();
    match header.encoding {
        Encoding::Ascii => read_text(body, header_text.lines().count(), &header, &mut content, task)?,
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => {
            guarded("PLY", || read_binary(body, &header, &mut content, task))??;
        }
    }
    task.check()?;
    Ok(content.into_model(&header))
}

/// The header as clean lines, and what follows it.
fn split_header(bytes: &[u8]) -> Result<(String, &[u8]), Fault> {
    let mut text = String::new();
    let mut rest = bytes;
    while let Some(end) = rest.iter().position(|b| *b == b'\n') {
        let line = String::from_utf8_lossy(&rest[..end]);
        let line = line.trim();
        rest = &rest[end + 1..];
        text.push_str(if line.is_empty() { "comment" } else { line });
        text.push('\n');
        if line == "end_header" {
            return Ok((text, rest));
        }
    }
    Err(Fault::of_file(
        "the header has no line 'end_header': the file is truncated or damaged; export the model again",
    ))
}

/// What the file's elements hold.
#[derive(Default)]
struct Content {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<Vec3>,
    /// Corners of all faces, and where each face's end; texture coordinates of corners where the file has them.
    corners: Vec<u32>,
    face_ends: Vec<usize>,
    corner_uvs: Vec<f32>,
    uv_ends: Vec<usize>,
    strips: Vec<u32>,
}

impl Content {
    fn add_vertex(&mut self, vertex: &VertexElement) {
        self.positions.push(vertex.position);
        self.normals.push(vertex.normal);
        self.uvs.push(vertex.uv);
        self.colors.push(vertex.color);
    }

    fn add_face(&mut self, face: &FaceElement) {
        self.corners.extend(&face.indices);
        self.face_ends.push(self.corners.len());
        self.corner_uvs.extend(&face.uvs);
        self.uv_ends.push(self.corner_uvs.len());
    }

    fn into_model(self, header: &Header) -> Model {
        let has = |names: &[&str]| {
            header
                .elements
                .get("vertex")
                .is_some_and(|e| names.iter().any(|name| e.properties.contains_key(*name)))
        };
        let mut model = Model::new();
        let (has_normals, has_uvs) = (has(&["nx"]), has(element::U_NAMES));
        model.mesh.positions = self.positions;
        if has_normals {
            model.mesh.normals = self.normals;
        }
        if has_uvs {
            model.mesh.uvs = self.uvs;
        }
        if has(element::RED_NAMES) {
            model.colors = self.colors;
        }
        let corner = |position: u32| Corner {
            position,
            normal: if has_normals { position } else { Corner::NONE },
            uv: if has_uvs { position } else { Corner::NONE },
        };
        model.reserve(self.face_ends.len());
        let (mut start, mut uv_start) = (0, 0);
        let mut polygon = Vec::new();
        for (face, (end, uv_end)) in self.face_ends.iter().zip(&self.uv_ends).enumerate() {
            polygon.clear();
            polygon.extend(self.corners[start..*end].iter().map(|i| corner(*i)));
            let uvs = &self.corner_uvs[uv_start..*uv_end];
            if uvs.len() == polygon.len() * 2 {
                for (corner, uv) in polygon.iter_mut().zip(uvs.chunks_exact(2)) {
                    corner.uv = model.mesh.uvs.len() as u32;
                    model.mesh.uvs.push(Vec2::new(uv[0], uv[1]));
                }
            }
            model.add_face(face as u32, &polygon, Model::NO_MATERIAL);
            (start, uv_start) = (*end, *uv_end);
        }
        add_strips(&mut model, &self.strips, self.face_ends.len() as u32, corner);
        model
    }
}

/// Adds the triangles of strips; an index that is no vertex's (by custom -1) begins a new one.
fn add_strips(model: &mut Model, strips: &[u32], first_face: u32, corner: impl Fn(u32) -> Corner) {
    let mut face = first_face;
    for strip in strips.split(|i| *i == u32::MAX) {
        for (i, triangle) in strip.windows(3).enumerate() {
            // Every other triangle of a strip is turned.
            let [a, b] = if i % 2 == 0 { [0, 1] } else { [1, 0] };
            let corners = [corner(triangle[a]), corner(triangle[b]), corner(triangle[2])];
            model.add_face(face, &corners, Model::NO_MATERIAL);
            face += 1;
        }
    }
}

/// What the elements of a name are read as.
enum Kind {
    Vertex,
    Face,
    Strips,
    Other,
}

fn kind_of(element: &ElementDef) -> Kind {
    match element.name.as_str() {
        "vertex" => Kind::Vertex,
        "face" => Kind::Face,
        "tristrips" => Kind::Strips,
        _ => Kind::Other,
    }
}

fn read_binary(body: &[u8], header: &Header, content: &mut Content, task: &Task) -> Result<(), Fault> {
    let mut reader = BufReader::with_capacity(1 << 16, Watched::new(body, task));
    for definition in header.elements.values() {
        // Elements without properties take no bytes; their number can be anything.
        let count = if definition.properties.is_empty() { 0 } else { definition.count };
        for i in 0..count {
            let fault = |error: ParseError| binary_fault(&error, definition, i, task);
            let source = &mut reader;
            match kind_of(definition) {
                Kind::Vertex => content.add_vertex(&element_of(source, definition, header).map_err(fault)?),
                Kind::Face => content.add_face(&element_of(source, definition, header).map_err(fault)?),
                Kind::Strips => {
                    let strip: FaceElement = element_of(source, definition, header).map_err(fault)?;
                    content.strips.extend(strip.indices);
                    content.strips.push(u32::MAX);
                }
                Kind::Other => {
                    let _: Skipped = element_of(source, definition, header).map_err(fault)?;
                }
            }
        }
    }
    Ok(())
}

fn element_of<E: PropertyAccess>(
    reader: &mut BufReader<Watched>,
    definition: &ElementDef,
    header: &Header,
) -> Result<E, ParseError> {
    let parser = Parser::<E>::new();
    match header.encoding {
        Encoding::BinaryBigEndian => parser.read_big_endian_element(reader, definition),
        Encoding::BinaryLittleEndian | Encoding::Ascii => {
            parser.read_little_endian_element(reader, definition)
        }
    }
}

fn binary_fault(error: &ParseError, definition: &ElementDef, index: usize, task: &Task) -> Fault {
    if task.is_cancelled() {
        return Fault::Cancelled;
    }
    let ElementDef { name, count, .. } = definition;
    let reason = match error.kind() {
        ErrorKind::UnexpectedEof => {
            format!("the file ends in {name} {} of {count}: it is truncated", index + 1)
        }
        _ => format!("{name} {} of {count} is damaged ({error})", index + 1),
    };
    Fault::of_file(format!("{reason}; export the model again"))
}

fn read_text(
    body: &[u8],
    header_lines: usize,
    header: &Header,
    content: &mut Content,
    task: &Task,
) -> Result<(), Fault> {
    let numbered = body.split(|b| *b == b'\n').zip(header_lines + 1..);
    let mut lines = numbered.filter(|(line, _)| !line.trim_ascii().is_empty());
    for definition in header.elements.values() {
        let count = if definition.properties.is_empty() { 0 } else { definition.count };
        for i in 0..count {
            if i.is_multiple_of(CHECK_EVERY) {
                task.check()?;
            }
            let Some((line, number)) = lines.next() else {
                let what =
                    format!("the file ends in {} {} of {count}: it is truncated", definition.name, i + 1);
                return Err(Fault::of_file(format!("{what}; export the model again")));
            };
            task.advance(line.len() as u64 + 1);
            let filled = match kind_of(definition) {
                Kind::Vertex => element::from_text(line, definition).map(|v| content.add_vertex(&v)),
                Kind::Face => element::from_text(line, definition).map(|f| content.add_face(&f)),
                Kind::Strips => element::from_text(line, definition).map(|strip: FaceElement| {
                    content.strips.extend(strip.indices);
                    content.strips.push(u32::MAX);
                }),
                Kind::Other => Some(()),
            };
            if filled.is_none() {
                let text = excerpt(&String::from_utf8_lossy(line));
                let what = format!("'{text}' does not hold the numbers of a {}", definition.name);
                return Err(Fault::at_line(number, format!("{what}; correct it, or export the model again")));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::Format;
    use crate::scene::load::tests::{load_bytes, refuses, repairs, sound, survives_damage};
    use crate::scene::{MeshTriangle, Scene};

    const VERTEX: &str = "property float x\nproperty float y\nproperty float z\n";
    const FACE: &str = "property list uchar int vertex_indices\n";

    fn ascii(vertices: usize, faces: usize, body: &str) -> Vec<u8> {
        let header = format!("ply\nformat ascii 1.0\ncomment made here\nelement vertex {vertices}\n{VERTEX}");
        format!("{header}element face {faces}\n{FACE}end_header\n{body}").into_bytes()
    }

    /// Two faces of a unit square, in binary.
    fn binary(format: &str) -> Vec<u8> {
        let header =
            format!("ply\nformat {format} 1.0\nelement vertex 4\n{VERTEX}element face 2\n{FACE}end_header\n");
        let (mut bytes, little) = (header.into_bytes(), format == "binary_little_endian");
        for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(if little { value.to_le_bytes() } else { value.to_be_bytes() });
        }
        for face in [&[0_i32, 1, 2][..], &[0, 1, 2, 3]] {
            bytes.push(face.len() as u8);
            bytes.extend(face.iter().flat_map(|i| if little { i.to_le_bytes() } else { i.to_be_bytes() }));
        }
        bytes
    }

    const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    #[test]
    fn text_and_both_orders_of_bytes_are_the_same_model() {
        let text = sound("a.ply", &ascii(4, 2, &format!("{SQUARE}3 0 1 2\n4 0 1 2 3\n")));
        assert_eq!(text.shape_count(), 3);
        assert_eq!(text.file_faces.as_deref(), Some(&vec![0, 1, 1]));
        for format in ["binary_little_endian", "binary_big_endian"] {
            let scene = sound("a.ply", &binary(format));
            assert_eq!(scene.mesh.positions, text.mesh.positions, "{format}");
            assert_eq!(scene.mesh.triangles, text.mesh.triangles, "{format}");
        }
    }

    #[test]
    fn the_embedded_bunny_reads_alike() {
        let scene = sound("bunny.ply", include_bytes!("../../../assets/bunny.ply"));
        assert_eq!((scene.shape_count(), scene.mesh.positions.len()), (3674, 1839));
    }

    #[test]
    fn normals_coordinates_and_colours_of_vertices_are_read() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                    property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
                    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
                    element face 1\nproperty uchar flags\nproperty list uchar uint vertex_index\nend_header\n\
                    0 0 0 0 0 3 0.25 0.5 255 0 0 255\n1 0 0 0 0 1 1 0 255 0 0 255\n0 1 0 0 0 1 0 1 255 0 0 255\n7 3 0 1 2\n";
        let scene: Scene = sound("a.ply", text.as_bytes());
        let t = scene.mesh.triangles[0];
        assert_eq!(scene.mesh.normals[t.normal[0] as usize], Vec3::Z);
        assert_eq!(scene.mesh.uvs[t.uv[0] as usize], Vec2::new(0.25, 0.5));
        assert_eq!(scene.material(0).color_at(Vec2::ZERO, &[]), Vec3::X);
    }

    #[test]
    fn coordinates_of_corners_are_read() {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\n{VERTEX}element face 2\n{FACE}property list uchar float texcoord\n\
             end_header\n{SQUARE}3 0 1 2 6 0 0 0.5 0 1 1\n3 0 2 3 0\n"
        );
        let scene = sound("a.ply", text.as_bytes());
        let uv = scene.mesh.triangles[0].uv.map(|i| scene.mesh.uvs[i as usize]);
        assert_eq!(uv, [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::ONE]);
        assert_eq!(scene.mesh.triangles[1].uv, [MeshTriangle::NO_INDEX; 3]);
    }

    #[test]
    fn strips_are_cut_with_every_other_triangle_turned() {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\n{VERTEX}element tristrips 1\nproperty list int int vertex_indices\n\
             end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n"
        );
        let scene = sound("a.ply", text.as_bytes());
        assert_eq!(scene.shape_count(), 3);
        for i in 0..3 {
            let v = scene.triangle(i).v;
            assert!((v[1] - v[0]).cross(v[2] - v[0]).z > 0.0, "triangle {i} is turned");
        }
    }

    #[test]
    fn other_elements_are_skipped() {
        let text = format!(
            "ply\r\nformat ascii 1.0\r\n\r\nelement camera 1\r\nproperty float f\r\nproperty list uchar float k\r\n\
             element nothing 99999999999\r\nelement vertex 3\r\n{VERTEX}element face 1\r\n{FACE}end_header\r\n\
             1 2 3 4\r\n0 0 0\r\n.5 0 0\r\n0 5. 0\r\n\r\n3 0 1 2\r\n"
        );
        assert_eq!(sound("a.ply", text.as_bytes()).triangle(0).v[1], Vec3::X * 0.5);
    }

    #[test]
    fn faces_that_cannot_be_shown_are_counted() {
        let outside = ascii(4, 4, &format!("{SQUARE}3 0 1 4\n3 0 1 -1\n3 0 1 2\n3 0 1 3000000000\n"));
        let scene = repairs("a.ply", &outside, 1, &["3 faces pointing to a vertex"]);
        assert_eq!(scene.file_faces.as_deref(), Some(&vec![2]));
        let not_finite = ascii(4, 2, "0 0 0\nnan 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
        repairs("a.ply", &not_finite, 1, &["1 face with a coordinate"]);
        repairs(
            "a.ply",
            &ascii(4, 2, &format!("{SQUARE}2 0 1\n3 0 1 2\n")),
            1,
            &["fewer than three corners"],
        );
    }

    #[test]
    fn damage_is_said_with_its_place() {
        refuses("a.ply", b"ply in name only\n", &["end_header"]);
        refuses("a.ply", b"not a ply\n", &["byte 0", "'ply'"]);
        refuses(
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex many\nend_header\n",
            &["line 3", "element vertex many"],
        );
        refuses("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\n", &["end_header", "truncated"]);
        refuses("a.ply", b"ply\nelement vertex 1\nend_header\n", &["header"]);
        refuses("a.ply", &ascii(4, 1, "0 0 0\n1 0 zero\n"), &["line 12", "'1 0 zero'"]);
        refuses("a.ply", &ascii(4, 1, "0 0 0\n1 0 0\n"), &["vertex 3 of 4", "truncated"]);
        refuses("a.ply", &ascii(4, 2, &format!("{SQUARE}3 0 1 2\n4 0 1 2\n")), &["line 16", "'4 0 1 2'"]);
        refuses("a.ply", &ascii(4, 0, SQUARE), &["no faces", "4 vertices"]);
        refuses("a.ply", &ascii(4, 1, &format!("{SQUARE}4000000000 1\n")), &["line 15"]);
        let whole = binary("binary_little_endian");
        refuses("a.ply", &whole[..whole.len() - 1], &["face 2 of 2", "truncated"]);
        refuses("a.ply", &whole[..whole.len() - 40], &["vertex 4 of 4", "truncated"]);
    }

    #[test]
    fn counts_that_lie_neither_hang_nor_take_memory() {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for count in [u64::MAX, u64::MAX / 12, 1 << 40] {
                let text = format!("ply\nformat {format} 1.0\nelement vertex {count}\n{VERTEX}end_header\n");
                refuses("a.ply", text.as_bytes(), &["vertex 1 of", "truncated"]);
            }
        }
    }

    #[test]
    fn damage_is_never_a_panic() {
        for format in ["binary_little_endian", "binary_big_endian"] {
            survives_damage(Format::Ply, &binary(format));
        }
        survives_damage(Format::Ply, &ascii(4, 2, &format!("{SQUARE}3 0 1 2\n4 0 1 2 3\n")));
    }

    #[test]
    fn a_truncated_file_is_never_a_panic() {
        for whole in [binary("binary_big_endian"), ascii(4, 2, &format!("{SQUARE}3 0 1 2\n4 0 1 2 3\n"))] {
            for end in 1..whole.len() {
                // Either outcome is right for some end; a panic is not.
                let _ = load_bytes("a.ply", &whole[..end]);
            }
        }
    }
}
