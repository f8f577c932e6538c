//! glTF documents made by hand.

use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use crate::scene::load::tests::{Files, load_bytes, refuses, repairs, sound, survives_damage};
use crate::scene::load::{Format, Loaded};
use crate::scene::{Color, MaterialKind, Scene};

/// A document over one buffer of positions (a unit square's corners), normals, texture coordinates and indices, with one
/// mesh of one primitive placed once.
fn document() -> (Value, Vec<u8>) {
    let mut data = Vec::new();
    let mut put = |values: &[f32]| data.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    put(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    put(&[0.0, 0.0, 1.0].repeat(4));
    put(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    data.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let view =
        |offset: usize, length: usize| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let accessor = |view: usize, component: u32, count: usize, kind: &str| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let mut positions = accessor(0, 5126, 4, "VEC3");
    positions["min"] = json!([0, 0, 0]);
    positions["max"] = json!([1, 1, 0]);
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0,
        }]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1.0]}}],
        "accessors": [
            positions,
            accessor(1, 5126, 4, "VEC3"),
            accessor(2, 5126, 4, "VEC2"),
            accessor(3, 5123, 6, "SCALAR"),
        ],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 32), view(128, 12)],
        "buffers": [{"uri": "data.bin", "byteLength": 140}],
    });
    (document, data)
}

fn load_changed(change: impl FnOnce(&mut Value)) -> Result<Loaded, String> {
    let (mut document, data) = document();
    change(&mut document);
    let files = Files::new(&[("a.gltf", document.to_string().as_bytes()), ("data.bin", &data)]);
    files.load("a.gltf").map_err(|error| error.to_string())
}

fn changed(change: impl FnOnce(&mut Value)) -> Scene {
    let loaded = load_changed(change).expect("a sound file");
    assert_eq!(loaded.warnings, Vec::<String>::new());
    loaded.scene
}

fn material(body: Value) -> MaterialKind {
    changed(|d| d["materials"] = json!([body])).material(0).kind
}

/// The same as a GLB.
fn glb() -> Vec<u8> {
    let (mut document, data) = document();
    document["buffers"] = json!([{"byteLength": data.len()}]);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF".to_vec();
    let word = |value: usize| (value as u32).to_le_bytes();
    glb.extend([word(2), word(12 + 8 + text.len() + 8 + data.len())].concat());
    glb.extend([&word(text.len())[..], b"JSON", &text].concat());
    glb.extend([&word(data.len())[..], b"BIN\0", &data].concat());
    glb
}

#[test]
fn text_and_binary_are_the_same_model() {
    let (text, binary) = (changed(|_| {}), sound("a.glb", &glb()));
    for scene in [&text, &binary] {
        assert_eq!(scene.shape_count(), 2);
        assert_eq!(scene.triangle(1).v, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        let t = scene.mesh.triangles[0];
        assert_eq!(scene.mesh.normals[t.normal[1] as usize], Vec3::Z);
        // In glTF v points down.
        assert_eq!(t.uv.map(|i| scene.mesh.uvs[i as usize]), [Vec2::ZERO, Vec2::X, Vec2::ONE]);
        assert_eq!(scene.material(0).name, "paint");
        assert_eq!(scene.material(0).color, Color::Solid(Vec3::new(0.8, 0.4, 0.2)));
    }
}

#[test]
fn nodes_place_meshes_with_stretch_and_mirror() {
    let scene = changed(|d| {
        d["nodes"] = json!([
            {"children": [1, 2], "translation": [10, 0, 0]},
            {"mesh": 0, "scale": [2, 1, 1], "rotation": [0, 0.707_106_77, 0, 0.707_106_77]},
            {"mesh": 0, "scale": [-1, 1, 1]},
        ]);
    });
    assert_eq!(scene.shape_count(), 4);
    // The unit square in x and y is stretched along x and turned so that x points along -z.
    assert!((scene.triangle(0).v[1] - Vec3::new(10.0, 0.0, -2.0)).length() < 1e-5);
    assert_eq!(scene.triangle(2).v[0], Vec3::X * 10.0);
    for (shape, normal) in [(0, Vec3::X), (1, Vec3::X), (2, Vec3::Z), (3, Vec3::Z)] {
        let v = scene.triangle(shape).v;
        let outside = (v[1] - v[0]).cross(v[2] - v[0]).normalize();
        assert!(outside.dot(normal) > 0.999, "triangle {shape} faces {outside}");
        let given = scene.mesh.normals[scene.mesh.triangles[shape as usize].normal[0] as usize];
        assert!(given.dot(normal) > 0.999, "triangle {shape} has the normal {given}");
    }
}

#[test]
fn strips_fans_and_lists_without_indices_are_read() {
    for (mode, count, turned) in [(4, 1, false), (5, 2, true), (6, 2, false)] {
        let scene = changed(|d| {
            d["meshes"][0]["primitives"][0]["mode"] = json!(mode);
            d["meshes"][0]["primitives"][0].as_object_mut().expect("an object").remove("indices");
        });
        assert_eq!(scene.shape_count(), count, "mode {mode}");
        let v = scene.triangle(0).v;
        assert!((v[1] - v[0]).cross(v[2] - v[0]).z > 0.0, "mode {mode}");
        if turned {
            assert_eq!(scene.triangle(1).v, [Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)]);
        }
    }
}

#[test]
fn materials_become_what_they_come_nearest_to() {
    let pbr = |metallic: f32, roughness: f32| json!({"pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness}});
    assert_eq!(material(pbr(1.0, 0.0)), MaterialKind::Mirror);
    assert_eq!(material(pbr(1.0, 0.5)), MaterialKind::Diffuse { reflectivity: 0.0 });
    assert_eq!(material(pbr(0.0, 0.0)), MaterialKind::Diffuse { reflectivity: 0.0 });
    let glass = json!({"extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": 1.4},
    }});
    assert_eq!(material(glass), MaterialKind::Glass { ior: 1.4, absorption: Vec3::ZERO });
    let lamp = json!({
        "emissiveFactor": [1.0, 0.5, 0.0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
    });
    assert_eq!(material(lamp), MaterialKind::Emissive { radiance: Vec3::new(4.0, 2.0, 0.0) });
}

#[test]
fn textures_are_read_from_files_and_buffers() {
    let mut png = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 128, 255]));
    pixels.write_to(&mut png, image::ImageFormat::Png).expect("an encoded image");
    let png = png.into_inner();
    for embedded in [false, true] {
        let (mut document, mut data) = document();
        document["textures"] = json!([{"source": 0}]);
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
        if embedded {
            document["bufferViews"]
                .as_array_mut()
                .expect("an array")
                .push(json!({"buffer": 0, "byteOffset": data.len(), "byteLength": png.len()}));
            document["images"] = json!([{"bufferView": 4, "mimeType": "image/png"}]);
            data.extend(&png);
            document["buffers"][0]["byteLength"] = json!(data.len());
        } else {
            document["images"] = json!([{"uri": "skin.png"}]);
        }
        let text = document.to_string();
        let files = Files::new(&[("a.gltf", text.as_bytes()), ("data.bin", &data), ("skin.png", &png)]);
        let loaded = files.load("a.gltf").expect("a scene");
        assert_eq!(loaded.warnings, Vec::<String>::new());
        let color = loaded.scene.material(0).color_at(Vec2::ZERO, &loaded.scene.images);
        assert!((color - Vec3::new(0.8, 0.0, 0.2 * 0.215_861)).length() < 1e-4, "{color}");
    }
}

#[test]
fn a_missing_texture_is_a_warning() {
    let loaded = load_changed(|d| {
        d["textures"] = json!([{"source": 0}]);
        d["images"] = json!([{"uri": "gone.png"}]);
        d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    });
    let loaded = loaded.expect("a scene");
    assert!(loaded.warnings.len() == 1 && loaded.warnings[0].contains("texture 0"), "{:?}", loaded.warnings);
}

#[test]
fn missing_and_short_buffers_are_said() {
    let (document, data) = document();
    let text = document.to_string();
    refuses("a.gltf", text.as_bytes(), &["data file 'data.bin'", "beside the model"]);
    let files = Files::new(&[("a.gltf", text.as_bytes()), ("data.bin", &data[..100])]);
    let message = files.load("a.gltf").expect_err("an error").to_string();
    assert!(message.contains("100 of 140 bytes"), "{message}");
    let whole = glb();
    for end in [4, 11, 30, whole.len() / 2, whole.len() - 1] {
        refuses("a.glb", &whole[..end], &["export the model again"]);
    }
}

#[test]
fn what_breaks_the_rules_is_said() {
    let refused = |change: fn(&mut Value), parts: &[&str]| {
        let message = load_changed(change).expect_err("an error");
        for part in parts {
            assert!(message.contains(part) && !message.contains('\n'), "'{part}' is not in: {message}");
        }
    };
    refuses("a.gltf", b"{\n  \"asset\": {\"version\": 2.0}\n", &["line"]);
    refuses("a.gltf", b"{}", &["asset"]);
    refused(|d| d["nodes"][0]["mesh"] = json!(7), &["nodes[0].mesh"]);
    refused(|d| d["nodes"] = json!([{}]), &["no faces"]);
    refused(|d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]), &["compress"]);
    // What lies outside or is of a wrong type makes a primitive unreadable, and it was the only one.
    refused(|d| d["accessors"][0]["count"] = json!(4000), &["no faces"]);
    refused(|d| d["accessors"][0]["count"] = json!(u64::MAX), &["a.gltf"]);
    refused(|d| d["accessors"][0]["componentType"] = json!(5123), &["no faces"]);
    refused(|d| d["accessors"][3]["type"] = json!("VEC2"), &["no faces"]);
    refused(|d| d["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["a.gltf"]);
    assert!(load_changed(|d| d["extensionsRequired"] = json!(["KHR_texture_transform"])).is_ok());
}

#[test]
fn damage_that_can_be_repaired_is_counted() {
    let (document, mut data) = document();
    let text = document.to_string();
    data[128 + 10] = 9;
    let files = Files::new(&[("a.gltf", text.as_bytes()), ("data.bin", &data)]);
    let loaded = files.load("a.gltf").expect("a file that can be repaired");
    assert_eq!(loaded.scene.shape_count(), 1);
    assert!(loaded.warnings[0].contains("1 face pointing to a vertex"), "{:?}", loaded.warnings);

    let loaded = load_changed(|d| {
        let mut points = d["meshes"][0]["primitives"][0].clone();
        points["mode"] = json!(0);
        d["meshes"][0]["primitives"].as_array_mut().expect("an array").push(points);
    });
    let loaded = loaded.expect("a scene");
    assert_eq!(loaded.scene.shape_count(), 2);
    assert!(loaded.warnings[0].contains("1 primitive of points or lines"), "{:?}", loaded.warnings);
}

#[test]
fn damage_is_never_a_panic() {
    survives_damage(Format::Glb, &glb());
}

#[test]
fn nodes_in_a_circle_are_walked_once() {
    let scene =
        changed(|d| d["nodes"] = json!([{"mesh": 0, "children": [1]}, {"mesh": 0, "children": [0, 1]}]));
    assert_eq!(scene.shape_count(), 4);
}

#[test]
fn not_a_number_in_a_matrix_or_a_position_is_counted() {
    let mut bytes = glb();
    let position = bytes.len() - 140;
    bytes[position..position + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = load_bytes("a.glb", &bytes).expect_err("both triangles have that corner").to_string();
    assert!(message.contains("2 faces with a coordinate that is not a number"), "{message}");
    let mut bytes = glb();
    let position = bytes.len() - 140 + 12;
    bytes[position..position + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    repairs("a.glb", &bytes, 1, &["1 face with a coordinate"]);
}
