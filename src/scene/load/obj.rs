//! OBJ through `tobj`, behind a look at every line (`obj_text`).

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};

use super::fault::{Fault, Watched, counted, guarded};
use super::model::{Corner, Model};
use super::mtl;
use super::obj_text::{self, ObjText};
use super::texture::Textures;
use crate::task::Task;

/// Faces between two looks at the task.
const CHECK_EVERY: usize = 4096;

/// Reads a model with its materials and textures, which lie in `folder`. Its faces are those of the file.
pub(super) fn read(bytes: &[u8], folder: &Path, task: &Task) -> Result<Model, Fault> {
    let prepared = obj_text::prepare(bytes, task)?;
    if prepared.face_count == 0 {
        let vertices = counted(prepared.vertex_count, "vertex");
        return Err(Fault::of_file(match prepared.vertex_count {
            0 => "no line of it begins with 'v' or 'f': this is no OBJ file, or a damaged one".to_owned(),
            _ => format!(
                "there are no faces in it (but {vertices}); export the model again, as a mesh of polygons"
            ),
        }));
    }
    let mut model = Model::new();
    model.warnings.clone_from(&prepared.warnings);
    model.removed.too_few_corners = prepared.too_few_corners;
    model.set_face_count(prepared.face_count);

    let files = MaterialFiles { folder, warnings: RefCell::default() };
    let (objects, materials) = parse(&prepared, &files, task)?;
    model.warnings.extend(files.warnings.into_inner());
    warn_of_missing_materials(&mut model, &prepared, &materials);

    let mut textures = Textures::new(folder);
    model.materials = materials.iter().map(|m| mtl::material(m, &mut textures)).collect();
    model.images = textures.read(task, &mut model.warnings)?;
    let mut faces = FileFaces { kept: prepared.kept_faces.as_deref(), next: 0 };
    for object in objects {
        add_object(&mut model, &object.mesh, &mut faces, task)?;
    }
    Ok(model)
}

fn parse(
    prepared: &ObjText,
    files: &MaterialFiles,
    task: &Task,
) -> Result<(Vec<tobj::Model>, Vec<tobj::Material>), Fault> {
    let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let mut reader = BufReader::with_capacity(1 << 16, Watched::new(prepared.text.as_bytes(), task));
    let parsed = guarded("OBJ", || tobj::load_obj_buf(&mut reader, &options, |path| files.load(path)))?;
    task.check()?;
    match parsed {
        Ok((objects, materials)) => Ok((objects, materials.unwrap_or_default())),
        Err(error) => Err(Fault::of_file(format!("{error}; export the model again"))),
    }
}

/// Finds the file's index of each face.
struct FileFaces<'a> {
    kept: Option<&'a [u32]>,
    next: usize,
}

impl FileFaces<'_> {
    fn next(&mut self) -> u32 {
        let face = self.kept.map_or(self.next as u32, |kept| kept[self.next]);
        self.next += 1;
        face
    }
}

/// Adds what `tobj` calls a mesh: the faces of one object and material, with arrays of their own.
fn add_object(
    model: &mut Model,
    object: &tobj::Mesh,
    faces: &mut FileFaces,
    task: &Task,
) -> Result<(), Fault> {
    let count = object.positions.len() / 3;
    let mesh = &mut model.mesh;
    let first = [mesh.positions.len() as u32, mesh.normals.len() as u32, mesh.uvs.len() as u32];
    let triples =
        |values: &[f32]| values.as_chunks().0.iter().copied().map(Vec3::from_array).collect::<Vec<_>>();
    mesh.positions.extend(triples(&object.positions));
    // `obj_text` sees to it that an object has these for all of its corners or for none.
    let has_normals = object.normals.len() == count * 3;
    let has_uvs = object.texcoords.len() == count * 2;
    if has_normals {
        mesh.normals.extend(triples(&object.normals));
    }
    if has_uvs {
        mesh.uvs.extend(object.texcoords.as_chunks().0.iter().copied().map(Vec2::from_array));
    }
    if object.vertex_color.len() == count * 3 {
        model.colors.extend(triples(&object.vertex_color));
    }
    let corner = |i: &u32| Corner {
        position: first[0] + i,
        normal: if has_normals { first[1] + i } else { Corner::NONE },
        uv: if has_uvs { first[2] + i } else { Corner::NONE },
    };
    let material = object.material_id.map_or(Model::NO_MATERIAL, |id| id as u32);
    let mut rest = object.indices.as_slice();
    let mut polygon = Vec::new();
    // No arities: all are triangles.
    let triangles = std::iter::repeat_n(&3, if object.face_arities.is_empty() { rest.len() / 3 } else { 0 });
    for (i, arity) in object.face_arities.iter().chain(triangles).enumerate() {
        if i.is_multiple_of(CHECK_EVERY) {
            task.check()?;
        }
        let (corners, after) = rest.split_at(*arity as usize);
        rest = after;
        polygon.clear();
        polygon.extend(corners.iter().map(corner));
        model.add_face(faces.next(), &polygon, material);
    }
    Ok(())
}

fn warn_of_missing_materials(model: &mut Model, prepared: &ObjText, materials: &[tobj::Material]) {
    let defined: BTreeSet<&str> = materials.iter().map(|m| m.name.as_str()).collect();
    let missing: Vec<&str> =
        prepared.used_materials.iter().map(String::as_str).filter(|name| !defined.contains(name)).collect();
    if !missing.is_empty() {
        let shown = missing.iter().take(5).copied().collect::<Vec<_>>().join(", ");
        let more = if missing.len() > 5 { ", ..." } else { "" };
        let count = counted(missing.len(), "material");
        model.warn(format!("{count} not found in any material file, shown grey: {shown}{more}"));
    }
}

/// Finds and reads the material files of a model.
struct MaterialFiles<'a> {
    folder: &'a Path,
    warnings: RefCell<Vec<String>>,
}

impl MaterialFiles<'_> {
    /// Never fails: a file that is missing gives no materials, and a warning.
    fn load(&self, name: &Path) -> tobj::MTLLoadResult {
        let name = name.to_string_lossy().replace('\\', "/");
        let warnings = &mut *self.warnings.borrow_mut();
        let mut materials = Vec::new();
        // One line may name several files, and a name may have spaces in it.
        let names: Vec<&str> = match self.find(&name) {
            Some(_) => vec![&name],
            None => name.split_whitespace().collect(),
        };
        for name in names {
            match self.find(name).map(std::fs::read) {
                Some(Ok(bytes)) => materials.extend(mtl::read(&bytes, name, warnings)),
                Some(Err(error)) => warnings.push(format!("material file {name} cannot be read: {error}")),
                None => warnings.push(format!("material file {name} is missing; put it beside the model")),
            }
        }
        let index_of = materials.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect();
        Ok((materials, index_of))
    }

    fn find(&self, name: &str) -> Option<PathBuf> {
        let beside = name.rsplit('/').next().unwrap_or(name);
        [self.folder.join(name), self.folder.join(beside)].into_iter().find(|path| path.is_file())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use crate::scene::load::Format;
    use crate::scene::load::tests::{Files, load_bytes, refuses, repairs, sound, survives_damage};
    use crate::scene::{Color, MaterialKind, MeshTriangle, Scene};

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn square(rest: &str) -> Vec<u8> {
        format!("{SQUARE}{rest}").into_bytes()
    }

    /// The total area of a scene of triangles.
    fn area(scene: &Scene) -> f32 {
        (0..scene.shape_count() as u32).map(|i| scene.shape(i).area()).sum()
    }

    #[test]
    fn triangles_quads_and_concave_faces_are_read_in_order() {
        let text = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 1 2 0\nv 0 4 0\nf 1 2 3\nf 1 2 3 4\nf 1 2 3 4 5\n";
        let scene = sound("a.obj", text.as_bytes());
        assert_eq!(scene.shape_count(), 1 + 2 + 3);
        assert_eq!(scene.file_faces.as_deref(), Some(&vec![0, 1, 1, 2, 2, 2]));
        // The pentagon has a notch at (1, 2).
        let pentagon: f32 = (3..6).map(|i| scene.shape(i).area()).sum();
        assert!((pentagon - 12.0).abs() < 1e-4, "{pentagon}");
        for i in 0..6 {
            let v = scene.triangle(i).v;
            assert!((v[1] - v[0]).cross(v[2] - v[0]).z > 0.0, "triangle {i} is turned");
        }
    }

    #[test]
    fn negative_indices_count_backwards() {
        let scene = sound("a.obj", b"v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -4 -3 -2\n");
        assert_eq!(scene.triangle(0).v, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(scene.triangle(1).v, scene.triangle(0).v);
    }

    #[test]
    fn several_objects_keep_the_order_of_the_file_and_their_attributes() {
        let text = "vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 2\no a\nf 1//1 2//1 3//1\nf 1 2 3\no b\nf 1/1/1 2/2/1 3/3/1\n\
                    g c d\nf 1/1 2/2 3/3\nf 1/1 2/2 3\n";
        let scene = sound("a.obj", &square(text));
        assert_eq!(scene.shape_count(), 5);
        let has =
            |t: &MeshTriangle| (t.normal[0] != MeshTriangle::NO_INDEX, t.uv[0] != MeshTriangle::NO_INDEX);
        let attributes: Vec<_> = scene.mesh.triangles.iter().map(has).collect();
        assert_eq!(attributes, [(true, false), (false, false), (true, true), (false, true), (false, false)]);
        let t = scene.mesh.triangles[2];
        assert_eq!(scene.mesh.normals[t.normal[1] as usize], Vec3::Z, "normals have unit length");
        assert_eq!(t.uv.map(|i| scene.mesh.uvs[i as usize]), [Vec2::ZERO, Vec2::X, Vec2::Y]);
        assert!(scene.file_faces.is_none());
    }

    #[test]
    fn spacing_comments_continuations_and_old_line_ends_are_read() {
        let lines = "# made by hand\r\n  v\t0 0 0 # origin\r\nv 1. 0 .0\r\nv 0 1e0 0 1.0\r\n\r\ns off\r\nf 1 \\\r\n 2 3 # face\r\n";
        let scene = sound("a.obj", lines.as_bytes());
        assert_eq!(scene.triangle(0).v, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        let mac = lines.replace("\r\n", "\r").replace("\\\r 2", "2");
        assert_eq!(sound("a.obj", mac.as_bytes()).triangle(0).v, scene.triangle(0).v);
        let without_end = lines.trim_end();
        assert_eq!(sound("a.obj", without_end.as_bytes()).shape_count(), 1);
    }

    #[test]
    fn the_first_offending_line_is_said() {
        for (line, parts) in [
            ("v 1 2", ["line 6", "'v 1 2' does not hold 3 numbers"]),
            ("v 1 two 3", ["line 6", "'v 1 two 3'"]),
            ("vn 0 1", ["line 6", "3 numbers"]),
            ("vt", ["line 6", "1 number;"]),
            ("f 1 2 x", ["line 6", "'x' is no corner"]),
            ("f 1/2/3/4 1 2", ["line 6", "'1/2/3/4' is no corner"]),
            ("f 1.5 2 3", ["line 6", "'1.5'"]),
        ] {
            refuses("bad.obj", &square(&format!("f 1 2 3\n{line}\nv x\n")), &parts);
        }
        refuses("bad.obj", &square("f 1 \\\n2 3\nf 1 \\\n2 \\\n3q\n"), &["line 7", "'3q'"]);
    }

    #[test]
    fn faces_that_point_outside_are_left_out_and_mapped() {
        let text =
            square("f 1 2 3\nf 1 2 9\nf 0 1 2\nf -9 1 2\nf 99999999999 1 2\nf 1 3 4\nf 1 2\nf 1 2 4\n");
        let loaded = load_bytes("a.obj", &text).expect("a file that can be repaired");
        assert_eq!(loaded.scene.shape_count(), 3);
        assert_eq!(loaded.scene.file_faces.as_deref(), Some(&vec![0, 5, 7]));
        assert_eq!(loaded.scene.triangle(1).v, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        let warnings = loaded.warnings.join("\n");
        assert!(warnings.contains("4 faces left out") && warnings.contains("line 6"), "{warnings}");
        assert!(warnings.contains("1 face with fewer than three corners"), "{warnings}");
        refuses("a.obj", &square("f 1 2 7\nf 1 2 8\n"), &["none of its 2 faces", "line 5"]);
    }

    #[test]
    fn bad_indices_of_normals_cost_the_normals_only() {
        let text = square("vn 0 0 1\nf 1//1 2//1 3//7\nf 1//1 3//1 4//1\n");
        let scene = repairs("a.obj", &text, 2, &["1 face", "normal"]);
        assert_eq!(scene.mesh.triangles[0].normal, [MeshTriangle::NO_INDEX; 3]);
        assert_ne!(scene.mesh.triangles[1].normal, [MeshTriangle::NO_INDEX; 3]);
    }

    #[test]
    fn coordinates_that_are_no_numbers_or_too_large_are_counted() {
        let text = square(
            "v nan 0 0\nv inf 0 0\nv 0 1e13 0\nv 1e60 0 0\nf 1 2 3\nf 1 2 5\nf 1 2 6\nf 1 2 7\nf 8 2 1 3\nf 1 3 4\n",
        );
        let scene = repairs("a.obj", &text, 2, &["4 faces", "not a number, infinite, or beyond"]);
        assert_eq!(scene.file_faces.as_deref(), Some(&vec![0, 5]));
        assert!(scene.bounds().is_finite());
    }

    #[test]
    fn degenerate_faces_stay() {
        let scene = sound("a.obj", &square("f 1 1 1\nf 1 2 2\nf 1 2 3\n"));
        assert_eq!(scene.shape_count(), 3);
        assert_eq!(area(&scene), 0.5);
        let point = sound("point.obj", b"v 1 1 1\nf 1 1 1\n");
        assert!(point.camera.frame(10, 10).eye.is_finite());
    }

    #[test]
    fn files_without_faces_say_what_they_have() {
        refuses("a.obj", SQUARE.as_bytes(), &["no faces", "4 vertices", "export"]);
        refuses("a.obj", &square("l 1 2 3\np 1\n"), &["no faces"]);
        refuses("a.obj", b"hello\nworld\n", &["no line of it begins with 'v' or 'f'"]);
        refuses("a.obj", b"v 0 0 0\nf 1 1 1\n\0\0", &["byte 16", "binary data"]);
    }

    #[test]
    fn lines_and_points_are_no_faces() {
        repairs("a.obj", &square("l 1 2 3\nf 1 2 3\np 1 2 3\n"), 1, &["2 line or point elements"]);
    }

    #[test]
    fn text_that_is_not_utf_8_is_read() {
        let scene =
            repairs("a.obj", b"# caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng \xff\nf 1 2 3\n", 1, &["not UTF-8"]);
        assert_eq!(scene.triangle(0).v[1], Vec3::X);
        refuses("a.obj", b"v 0 0 \xff\nf 1 1 1\n", &["line 1"]);
    }

    #[test]
    fn vertex_colours_become_materials() {
        let text = b"v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 1 1 0 0 0 1\nf 1 2 3\nf 4 4 4\nf 3 2 1\n";
        let scene = sound("a.obj", text);
        let color = |shape| scene.material(shape).color_at(Vec2::ZERO, &[]);
        assert_eq!((color(0), color(1), color(2)), (Vec3::X, Vec3::Z, Vec3::X));
        assert_eq!(scene.shape_materials[0], scene.shape_materials[2], "one material a colour");
        repairs(
            "a.obj",
            b"v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            1,
            &["only some vertices have a colour"],
        );
    }

    #[test]
    fn materials_and_textures_are_read_from_beside_the_model() {
        let mut texture = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbImage::from_pixel(2, 2, image::Rgb([128, 255, 0]));
        pixels.write_to(&mut texture, image::ImageFormat::Png).expect("an encoded image");
        let model = square(
            "vt 0 0\nmtllib my materials.mtl\nusemtl red\nf 1 2 3\nusemtl wood\nf 1/1 2/1 3/1\nusemtl red\nf 1 3 4\n",
        );
        let materials =
            "newmtl red\nKd 1 0 0\nnewmtl wood\nKd 0.5 0.5 0.5\nmap_Kd -s 1 1 1 C:\\tex\\wood.png\n";
        let files = Files::new(&[
            ("a.obj", &model),
            ("my materials.mtl", materials.as_bytes()),
            ("wood.png", texture.get_ref()),
        ]);
        let loaded = files.load("a.obj").expect("a scene");
        assert_eq!(loaded.warnings, Vec::<String>::new());
        let scene = loaded.scene;
        let names: Vec<&str> = (0..3).map(|i| scene.material(i).name.as_str()).collect();
        assert_eq!(names, ["red", "wood", "red"]);
        let wood = scene.material(1).color_at(Vec2::splat(0.3), &scene.images);
        assert!(
            (wood - Vec3::new(0.5 * 0.215_861, 0.5, 0.0)).length() < 1e-4,
            "{wood} is not decoded from sRGB"
        );
    }

    #[test]
    fn what_is_missing_beside_the_model_is_a_warning() {
        let model = square("mtllib gone.mtl\nusemtl steel\nf 1 2 3\n");
        let loaded = load_bytes("a.obj", &model).expect("a scene");
        let warnings = loaded.warnings.join("\n");
        assert!(warnings.contains("gone.mtl is missing") && warnings.contains("steel"), "{warnings}");
        assert_eq!(loaded.scene.material(0).kind, MaterialKind::Diffuse { reflectivity: 0.0 });

        let files = Files::new(&[
            ("a.obj", &square("mtllib a.mtl\nusemtl wood\nf 1 2 3\n")),
            ("a.mtl", b"newmtl wood\nmap_Kd gone.png\n"),
        ]);
        let loaded = files.load("a.obj").expect("a scene");
        assert_eq!(loaded.warnings.len(), 1);
        assert!(loaded.warnings[0].contains("gone.png"), "{:?}", loaded.warnings);
        assert!(matches!(loaded.scene.material(0).color, Color::Image { .. }));
        assert_eq!(loaded.scene.material(0).color_at(Vec2::ZERO, &loaded.scene.images), Vec3::ONE);
    }

    #[test]
    fn a_texture_that_is_none_is_a_warning() {
        let files = Files::new(&[
            ("a.obj", &square("mtllib a.mtl\nusemtl wood\nf 1 2 3\n")),
            ("a.mtl", b"newmtl wood\nmap_Kd wood.png\n"),
            ("wood.png", b"\x89PNG\r\n\x1a\nnot at all"),
        ]);
        let loaded = files.load("a.obj").expect("a scene");
        assert!(loaded.warnings[0].contains("wood.png cannot be read"), "{:?}", loaded.warnings);
    }

    #[test]
    fn damage_is_never_a_panic() {
        let text = "vt 0 0\nvn 0 0 1\ng a\nusemtl b\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1 -2 -3\n";
        survives_damage(Format::Obj, &square(text));
    }

    #[test]
    fn a_truncated_file_is_never_a_panic() {
        let whole = square("vt 0 0\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 3/1/1 4/1/1\n");
        for end in 1..whole.len() {
            // Either outcome is right for some end; a panic is not.
            let _ = load_bytes("a.obj", &whole[..end]);
        }
    }
}
