//! STL, binary through `stl_io` and in text by an own reader.
//!
//! The crate's reader of texts refuses solids without a name, files of several solids, upper case, and any number that is
//! not finite, and says no line; what it cannot read here is common. It also takes a binary file whose comment begins
//! with `solid` for a text.

use std::io::Cursor;

use glam::Vec3;

use super::fault::{Fault, excerpt, guarded};
use super::model::{Corner, Model};
use crate::task::Task;

const HEADER: usize = 80;
const FACET: usize = 50;
/// Facets, or lines, between two looks at the task.
const CHECK_EVERY: usize = 4096;

/// Reads a model; its facets are the file's faces.
pub(super) fn read(bytes: &[u8], task: &Task) -> Result<Model, Fault> {
    let mut model = Model::new();
    if is_text(bytes) {
        read_text(&String::from_utf8_lossy(bytes), &mut model, task)?;
        if std::str::from_utf8(bytes).is_err() {
            model.warn("the file is not UTF-8; what could not be read was replaced");
        }
    } else {
        read_binary(bytes, &mut model, task)?;
    }
    Ok(model)
}

/// A text begins with `solid`, but so do the comments of some binary files, whose length then fits their count.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let says_solid = start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid");
    says_solid && facet_count(bytes).is_none_or(|count| HEADER + 4 + count * FACET != bytes.len())
}

/// The number of facets that a binary file announces.
fn facet_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER..HEADER + 4)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

fn read_binary(bytes: &[u8], model: &mut Model, task: &Task) -> Result<(), Fault> {
    let count = facet_count(bytes).ok_or_else(|| {
        Fault::of_file(format!(
            "neither a text that begins with 'solid' nor a binary STL: it ends after {} of the {} bytes of a header; \
             export the model again",
            bytes.len(),
            HEADER + 4
        ))
    })?;
    let expected = HEADER + 4 + count * FACET;
    if bytes.len() < expected {
        return Err(Fault::at_byte(
            bytes.len(),
            format!(
                "the file ends here, but its header announces {count} facets in {expected} bytes: it is truncated, or \
                 no STL file; export the model again"
            ),
        ));
    }
    // Without its comment the crate cannot take it for a text.
    let mut data = vec![0; HEADER];
    data.extend_from_slice(&bytes[HEADER..expected]);
    let mut data = Cursor::new(data);
    model.reserve(count);
    guarded("STL", || {
        let facets =
            stl_io::create_stl_reader(&mut data).map_err(|error| Fault::of_file(error.to_string()))?;
        for (i, facet) in facets.enumerate() {
            if i.is_multiple_of(CHECK_EVERY) {
                task.check()?;
            }
            let facet = facet.map_err(|error| {
                Fault::at_byte(HEADER + 4 + i * FACET, format!("{error}; export the model again"))
            })?;
            add_facet(model, i, facet.vertices.map(|v| Vec3::from_array(v.0)));
        }
        Ok(())
    })?
}

fn add_facet(model: &mut Model, face: usize, vertices: [Vec3; 3]) {
    let first = model.mesh.positions.len() as u32;
    model.mesh.positions.extend(vertices);
    let corner = |i| Corner { position: first + i, normal: Corner::NONE, uv: Corner::NONE };
    model.add_face(face as u32, &[corner(0), corner(1), corner(2)], Model::NO_MATERIAL);
}

/// Only `vertex` and `endfacet` carry anything; the normal follows from the vertices.
fn read_text(text: &str, model: &mut Model, task: &Task) -> Result<(), Fault> {
    let mut corners: Vec<Vec3> = Vec::with_capacity(3);
    let (mut facets, mut last_line, mut is_open, mut is_ended) = (0, 0, false, false);
    for (line, number) in text.lines().zip(1_usize..) {
        if number.is_multiple_of(CHECK_EVERY) {
            task.check()?;
        }
        last_line = number;
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        let keyword = keyword.to_ascii_lowercase();
        match keyword.as_str() {
            "vertex" => corners.push(vertex(words).ok_or_else(|| {
                let what = format!("'{}' is not a vertex of three numbers", excerpt(line));
                Fault::at_line(number, format!("{what}; correct it, or export the model again"))
            })?),
            "facet" => (is_open, is_ended) = (true, false),
            "endfacet" => {
                is_open = false;
                match corners[..] {
                    [a, b, c] => add_facet(model, facets, [a, b, c]),
                    _ if corners.len() < 3 => model.removed.too_few_corners += 1,
                    _ => {
                        let what = format!("this facet has {} vertices instead of three", corners.len());
                        return Err(Fault::at_line(number, format!("{what}; export the model again")));
                    }
                }
                corners.clear();
                facets += 1;
            }
            "endsolid" => is_ended = true,
            "solid" | "outer" | "endloop" | "color" => {}
            _ => {
                let what = format!("'{}' belongs to no STL text", excerpt(line));
                return Err(Fault::at_line(
                    number,
                    format!("{what}; the file is damaged: export the model again"),
                ));
            }
        }
    }
    model.set_face_count(facets);
    if is_open {
        let what = "the text ends within a facet: the file is truncated; export the model again";
        return Err(Fault::at_line(last_line, what));
    }
    if !is_ended && facets > 0 {
        model.warn("the text does not end with 'endsolid': facets behind its end may be missing");
    }
    Ok(())
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let mut next = || words.next()?.parse::<f32>().ok();
    Some(Vec3::new(next()?, next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load::Format;
    use crate::scene::load::tests::{load_bytes, refuses, repairs, sound, survives_damage};

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    /// A binary file of some triangles.
    fn binary(comment: &[u8], triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = comment.to_vec();
        bytes.resize(HEADER, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0.0_f32; 3].iter().chain(triangle).flat_map(|f| f.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    const A: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    const B: [f32; 9] = [2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 2.0, 1.0, 0.0];

    #[test]
    fn binary_files_are_read_whatever_their_comment_says() {
        for comment in [&b"made here"[..], b"solid made here", b"solid"] {
            let scene = sound("a.stl", &binary(comment, &[A, B]));
            assert_eq!(scene.shape_count(), 2);
            assert_eq!(scene.triangle(1).v[0], Vec3::X * 2.0);
        }
        let mut with_more = binary(b"", &[A]);
        with_more.extend([1, 2, 3]);
        assert_eq!(sound("a.stl", &with_more).shape_count(), 1);
    }

    #[test]
    fn texts_are_read_with_and_without_a_name_and_in_several_solids() {
        for text in [
            format!("solid thing\n{FACET}endsolid thing\n"),
            format!("solid\n{FACET}endsolid\n"),
            format!("SOLID thing\r\n{}ENDSOLID\r\n", FACET.to_uppercase().replace('\n', "\r\n")),
            format!("\n  solid\n  {}endsolid", FACET.replace('\n', "\n   ")),
        ] {
            assert_eq!(sound("a.stl", text.as_bytes()).triangle(0).v, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        }
        let two = format!("solid a\n{FACET}endsolid a\nsolid b\n{FACET}{FACET}endsolid b\n");
        assert_eq!(sound("a.stl", two.as_bytes()).shape_count(), 3);
    }

    #[test]
    fn facets_that_are_no_triangles_or_no_numbers_are_counted() {
        let text = format!(
            "solid\n{FACET}{}{}endsolid",
            FACET.replace("1 0 0", "nan 0 0"),
            FACET.replace("0 1 0", "inf 0 0")
        );
        repairs("a.stl", text.as_bytes(), 1, &["2 faces", "not a number"]);
        let two_corners = FACET.replace("vertex 0 1 0\n", "");
        let scene = repairs(
            "a.stl",
            format!("solid\n{two_corners}{FACET}endsolid").as_bytes(),
            1,
            &["fewer than three"],
        );
        assert_eq!(scene.file_faces.as_deref(), Some(&vec![1]));
        let mut bad = A;
        bad[4] = f32::NAN;
        repairs("a.stl", &binary(b"", &[bad, B]), 1, &["1 face with a coordinate"]);
    }

    #[test]
    fn damage_is_said_with_its_place() {
        let text = format!("solid\n{FACET}");
        refuses(
            "a.stl",
            text.replace("vertex 1 0 0", "vertex 1 0 x").as_bytes(),
            &["line 5", "three numbers"],
        );
        refuses("a.stl", text.replace("outer loop", "outre").as_bytes(), &["line 3", "'outre'"]);
        refuses("a.stl", format!("solid\n{}", &FACET[..50]).as_bytes(), &["line 5", "number"]);
        refuses("a.stl", format!("solid\n{}", &FACET[..43]).as_bytes(), &["line 4", "truncated"]);
        let four = FACET.replace("endloop", "vertex 1 1 1\nendloop");
        refuses("a.stl", format!("solid\n{four}").as_bytes(), &["4 vertices"]);
        let whole = binary(b"", &[A, B]);
        refuses("a.stl", &whole[..whole.len() - 1], &["byte 183", "2 facets in 184 bytes", "truncated"]);
        refuses("a.stl", &whole[..40], &["40 of the 84 bytes"]);
        refuses("a.stl", &binary(b"", &[]), &["no faces"]);
        refuses("a.stl", b"solid\nendsolid\n", &["no faces"]);
        repairs("a.stl", text.as_bytes(), 1, &["endsolid"]);
    }

    #[test]
    fn damage_is_never_a_panic() {
        survives_damage(Format::Stl, &binary(b"", &[A, B]));
        survives_damage(Format::Stl, format!("solid\n{FACET}endsolid\n").as_bytes());
    }

    #[test]
    fn text_that_is_not_utf_8_is_read() {
        let mut text = b"solid caf\xe9\n".to_vec();
        text.extend(format!("{FACET}endsolid\n").bytes());
        assert_eq!(load_bytes("a.stl", &text).expect("a scene").warnings.len(), 1);
    }
}
