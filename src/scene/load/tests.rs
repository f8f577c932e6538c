//! What holds for the files of every format; and files to hand to the readers' own tests.

use std::path::Path;

use super::*;
use crate::scene::{Light, MaterialKind};

/// Files in a folder that is removed afterwards.
pub(super) struct Files(tempfile::TempDir);

impl Files {
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).expect("a file in it");
        }
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn load(&self, name: &str) -> Result<Loaded, LoadError> {
        load(&SceneRef::File(self.path(name)), UpAxis::Y, &Task::new())
    }
}

/// Loads a single file of that name and content.
pub(super) fn load_bytes(name: &str, bytes: &[u8]) -> Result<Loaded, LoadError> {
    Files::new(&[(name, bytes)]).load(name)
}

/// The scene of a file that needs no repair.
pub(super) fn sound(name: &str, bytes: &[u8]) -> Scene {
    let loaded = load_bytes(name, bytes).expect("a sound file");
    assert_eq!(loaded.warnings, Vec::<String>::new());
    loaded.scene
}

/// Checks that a file cannot be loaded, and that the message is one line, names the file, and says `parts`.
pub(super) fn refuses(name: &str, bytes: &[u8], parts: &[&str]) {
    let message = match load_bytes(name, bytes) {
        Ok(loaded) => panic!("{name} was loaded with {:?}", loaded.warnings),
        Err(error) => error.to_string(),
    };
    assert!(message.contains(name) && !message.contains('\n'), "{message}");
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

/// Checks that a file is loaded with `count` shapes and one warning that says `parts`.
pub(super) fn repairs(name: &str, bytes: &[u8], count: usize, parts: &[&str]) -> Scene {
    let loaded = load_bytes(name, bytes).expect("a file that can be repaired");
    assert_eq!(loaded.scene.shape_count(), count, "{:?}", loaded.warnings);
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    for part in parts {
        assert!(loaded.warnings[0].contains(part), "'{part}' is not in: {:?}", loaded.warnings);
    }
    loaded.scene
}

/// Checks that no single damaged byte makes a reader panic, hang, or make a scene that is not sound.
pub(super) fn survives_damage(format: Format, whole: &[u8]) {
    let mut bytes = whole.to_vec();
    for place in 0..bytes.len() {
        for damage in [0x00, 0xff, bytes[place] ^ 0x01, b'9'] {
            let sound = std::mem::replace(&mut bytes[place], damage);
            let model = parse(format, &bytes, Path::new("no such folder"), &Task::new());
            if let Ok((scene, _)) = model.and_then(|model| model.finish("damaged", UpAxis::Y)) {
                assert!(
                    scene.bounds().is_finite() && scene.camera.eye.is_finite(),
                    "byte {place} as {damage}"
                );
                assert_eq!(scene.shapes.len(), scene.shape_materials.len());
            }
            bytes[place] = sound;
        }
    }
}

const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn what_is_no_file_of_ours_is_said() {
    let files = Files::new(&[("empty.obj", b""), ("model.fbx", b"Kaydara"), ("model", b"v 0 0 0")]);
    for (name, part) in [
        ("missing.obj", "there is no such file"),
        ("empty.obj", "the file is empty"),
        ("model.fbx", "'.fbx' is no format"),
        ("model", "no extension"),
        ("", "this is a folder"),
    ] {
        let message = files.load(name).expect_err("an error").to_string();
        assert!(message.contains(part) && !message.contains('\n'), "{message}");
    }
    assert!(files.load("model.fbx").expect_err("an error").to_string().contains(".obj .ply .stl .gltf .glb"));
}

#[test]
fn extensions_are_read_in_any_case() {
    for format in Format::ALL {
        assert_eq!(Format::of(&Path::new("a.b").with_extension(format.name().to_uppercase())), Some(format));
    }
    assert_eq!(load_bytes("A.OBJ", TRIANGLE).expect("a scene").scene.shape_count(), 1);
}

#[test]
fn garbage_of_any_format_is_refused_without_a_panic() {
    use rand::{Rng, SeedableRng};
    let mut random = rand_pcg::Pcg32::seed_from_u64(1);
    for format in Format::ALL {
        for length in [1, 10, 84, 200, 5000] {
            let mut bytes = vec![0; length];
            random.fill_bytes(&mut bytes);
            refuses(&format!("garbage.{}", format.name()), &bytes, &[]);
        }
    }
}

#[test]
fn the_hash_is_that_of_the_content() {
    let loaded = load_bytes("a.obj", TRIANGLE).expect("a scene");
    // `printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' | sha256sum`
    assert_eq!(loaded.content_hash, HASH);
    assert_eq!(loaded.scene.name, "a.obj");
    let builtin = load(&SceneRef::default(), UpAxis::Y, &Task::new()).expect("the default scene");
    assert_eq!((builtin.content_hash.as_str(), builtin.scene.shape_count()), ("", 4977));
}

const HASH: &str = "697b00ab13410c52a542d2e9c63711fcc04e9cbf6c0d3439a9b43cc812e6e713";

#[test]
fn an_opened_file_is_framed_and_lit_without_further_shapes() {
    for up in UpAxis::ALL {
        let files = Files::new(&[("a.obj", TRIANGLE)]);
        let scene = load(&SceneRef::File(files.path("a.obj")), up, &Task::new()).expect("a scene").scene;
        assert_eq!((scene.shape_count(), scene.unbounded().count()), (1, 0));
        assert_eq!(scene.camera.up, up);
        let frame = scene.camera.frame(100, 100);
        for vertex in scene.triangle(0).v {
            let p = frame.project(vertex);
            assert!(p.z > 0.0 && p.x > 0.0 && p.x < 100.0 && p.y > 0.0 && p.y < 100.0);
        }
        let [Light::Panel { quad, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
        assert!(quad.corner.dot(up.vector()) > 0.5, "the light is not above");
        assert!(scene.sky.radiance.min_element() > 0.0);
        assert!(scene.file_faces.is_none() && !scene.is_animated());
    }
}

#[test]
fn a_file_with_lamps_gets_no_other_light() {
    let files = Files::new(&[
        ("a.obj", b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl lamp\nf 1 2 3\n"),
        ("a.mtl", b"newmtl lamp\nKe 5 5 5\n"),
    ]);
    let scene = files.load("a.obj").expect("a scene").scene;
    assert_eq!(scene.lights, [Light::Shape { shape: 1 }]);
    assert!(matches!(scene.material(1).kind, MaterialKind::Emissive { .. }));
    assert!(scene.sky.radiance.max_element() < 0.1);
}

#[test]
fn a_cancelled_load_stops() {
    let task = Task::new();
    task.cancel();
    let files = Files::new(&[("a.obj", TRIANGLE)]);
    for scene in [SceneRef::File(files.path("a.obj")), SceneRef::Builtin("soup".to_owned())] {
        assert!(matches!(load(&scene, UpAxis::Y, &task), Err(LoadError::Cancelled)));
    }
}

#[test]
fn of_many_identical_triangles_a_few_are_kept() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 2 3 1\n");
    // Other vertices in the same places count, too.
    text.push_str(&"f 1 2 3\nf 4 2 3\n".repeat(50_000));
    text.push_str("f 3 2 1\n");
    let scene = repairs("a.obj", text.as_bytes(), 258, &["99745 faces", "lying exactly on 256 others"]);
    let faces = scene.file_faces.as_deref().expect("a map to the file");
    assert_eq!((faces[0], faces[1], faces[256], faces[257]), (0, 1, 256, 100_002));
}
