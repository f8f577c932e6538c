//! Files as NumPy writes them, byte by byte, and files that are broken.

use std::io::{Cursor, Write};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;

/// An array in NumPy's form.
fn npy(descr: &str, shape: &str, fortran: &str, data: &[u8]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}").into_bytes();
    header.resize((10 + header.len() + 1).next_multiple_of(64) - 11, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header);
    bytes.extend(data);
    bytes
}

fn bytes_of<T: Copy, const N: usize>(values: &[T], encode: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().flat_map(|value| encode(*value)).collect()
}

fn f32s(shape: &str, values: &[f32]) -> Vec<u8> {
    npy("<f4", shape, "False", &bytes_of(values, f32::to_le_bytes))
}

fn i32s(shape: &str, values: &[i32]) -> Vec<u8> {
    npy("<i4", shape, "False", &bytes_of(values, i32::to_le_bytes))
}

const MIN: [f32; 6] = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
const MAX: [f32; 6] = [1.0, 1.0, 0.0, 3.0, 1.0, 0.0];
const TRIANGLES: [f32; 18] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, //
    2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 2.0, 1.0, 0.0,
];

/// A binary tree over two triangles.
fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("child_min", f32s("(1, 2, 3)", &MIN)),
        ("child_max", f32s("(1, 2, 3)", &MAX)),
        ("child_index", i32s("(1, 2)", &[-2, -3])),
        ("leaf_first", i32s("(2,)", &[0, 1])),
        ("leaf_count", i32s("(2,)", &[1, 1])),
        ("shape_index", i32s("(2,)", &[0, 1])),
        ("triangles", f32s("(2, 3, 3)", &TRIANGLES)),
    ]
}

fn npz(arrays: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    // As NumPy does: sizes of 64 bits.
    let options = SimpleFileOptions::default().compression_method(method).large_file(true);
    for (name, bytes) in arrays {
        zip.start_file(format!("{name}.npy"), options).expect("a file");
        zip.write_all(bytes).expect("room");
    }
    zip.finish().expect("an archive").into_inner()
}

fn read_npz(arrays: &[(&str, Vec<u8>)]) -> Result<TreeArrays, String> {
    read_bytes(&npz(arrays, CompressionMethod::Stored), TreeFormat::Npz)
}

fn read_bytes(bytes: &[u8], format: TreeFormat) -> Result<TreeArrays, String> {
    read(bytes, format, &Task::new()).map_err(|fault| match fault {
        Fault::Cancelled => "cancelled".to_owned(),
        Fault::Content { reason, .. } => reason,
    })
}

fn with(name: &'static str, bytes: Vec<u8>) -> Vec<(&'static str, Vec<u8>)> {
    let mut all = arrays();
    all.retain(|(n, _)| *n != name);
    all.push((name, bytes));
    all
}

#[test]
fn plain_and_compressed_archives_and_json_say_the_same() {
    let tree = read_npz(&arrays()).expect("a tree");
    assert_eq!((tree.width, &tree.child_index[..]), (2, &[-2, -3][..]));
    assert_eq!((tree.child_min[1], tree.child_max[1]), ([2.0, 0.0, 0.0], [3.0, 1.0, 0.0]));
    assert_eq!((&tree.leaf_first[..], &tree.leaf_count[..]), (&[0, 1][..], &[1, 1][..]));
    assert_eq!(tree.triangles.as_ref().map(Vec::len), Some(2));
    let compressed = npz(&arrays(), CompressionMethod::Deflated);
    assert_eq!(read_bytes(&compressed, TreeFormat::Npz), Ok(tree.clone()));
    let json = br#"{"child_min": [[[0, 0, 0], [2, 0, 0]]], "child_max": [[[1, 1, 0], [3, 1, 0]]],
        "child_index": [[-2, -3]], "leaf_first": [0, 1], "leaf_count": [1, 1], "shape_index": [0, 1],
        "triangles": [[[0,0,0],[1,0,0],[0,1,0]], [[2,0,0],[3,0,0],[2,1,0]]], "of": "something else"}"#;
    assert_eq!(read_bytes(json, TreeFormat::Json), Ok(tree));
}

#[test]
fn numbers_of_other_kinds_are_taken() {
    let wide = |values: &[i64]| bytes_of(values, i64::to_le_bytes);
    let tree = read_npz(&with("child_index", npy("<i8", "(1, 2)", "False", &wide(&[-2, -3]))));
    assert_eq!(tree.expect("a tree").child_index, [-2, -3]);
    let small = npy("|i1", "(1, 2)", "False", &[254, 253]);
    assert_eq!(read_npz(&with("child_index", small)).expect("a tree").child_index, [-2, -3]);
    let unsigned = npy("<u4", "(2,)", "False", &bytes_of(&[0_u32, 1], u32::to_le_bytes));
    assert_eq!(read_npz(&with("shape_index", unsigned)).expect("a tree").shape_index, [0, 1]);
    let without: Vec<_> = arrays().into_iter().filter(|(name, _)| *name != "triangles").collect();
    assert_eq!(read_npz(&without).expect("a tree").triangles, None);
}

#[test]
fn boxes_of_double_precision_still_contain_their_triangles() {
    let corners = [0.1_f64, -0.1, 0.3, 0.7, 1e-9, 7.3];
    let doubles = npy("<f8", "(1, 2, 3)", "False", &bytes_of(&corners, f64::to_le_bytes));
    let min = read_npz(&with("child_min", doubles)).expect("a tree").child_min;
    let repeated = corners.repeat(3);
    let doubles = npy("<f8", "(2, 3, 3)", "False", &bytes_of(&repeated, f64::to_le_bytes));
    let triangles = read_npz(&with("triangles", doubles)).expect("a tree").triangles.expect("triangles");
    assert_eq!((min[0], min[1]), (triangles[0][0].to_array(), triangles[0][1].to_array()));
}

#[test]
fn what_does_not_fit_is_said_with_the_array_s_name() {
    let cases = [
        (with("child_min", f32s("(2, 3)", &MIN)), "child_min has the shape (2, 3); wanted is (n, 2, 3)"),
        (
            with("child_index", i32s("(2,)", &[-2, -3])),
            "child_index has the shape (2); wanted is (nodes, slots)",
        ),
        (with("child_max", f32s("(0, 2, 3)", &[])), "child_max has 0 slots of boxes, child_index has 2"),
        (with("leaf_count", i32s("(1,)", &[1])), "leaf_first has 2 entries and leaf_count 1"),
        (
            with("child_index", npy("<u4", "(1, 2)", "False", &[255; 8])),
            "child_index: number 0 is 4294967295, which does not fit",
        ),
        (with("shape_index", f32s("(2,)", &[0.0, 1.0])), "holds indices: save it as np.int32"),
        (
            with("child_min", npy("<f4", "(1, 2, 3)", "True", &[0; 24])),
            "the array child_min is stored in Fortran order",
        ),
        (with("child_min", npy(">f4", "(1, 2, 3)", "False", &[0; 24])), "numbers of the kind '>f4'"),
        (with("child_min", npy("<f4", "(1, 2, 3)", "False", &[0; 20])), "ends after"),
        (
            with("child_index", npy("<i4", "(100000000000, 2)", "False", &[0; 20])),
            "child_index ends after 0 of 200000000000 numbers",
        ),
        (with("child_index", b"hello, I am no array".to_vec()), "child_index is not in NumPy's form"),
        (
            with("triangles", f32s("(2, 9)", &TRIANGLES)),
            "triangles has the shape (2, 9); wanted is (n, 3, 3)",
        ),
        (arrays()[..3].to_vec(), "there is no array 'leaf_first'"),
    ];
    for (arrays, expected) in cases {
        let message = read_npz(&arrays).expect_err(expected);
        assert!(message.contains(expected), "{expected}: {message}");
    }
    for (json, expected) in [
        ("{", "no tree in JSON"),
        (r#"{"child_index": []}"#, "missing field `child_min`"),
        (
            r#"{"child_min": [[]], "child_max": [[]], "child_index": [[1, 2], [3]], "leaf_first": [], "leaf_count": [],
                "shape_index": []}"#,
            "child_min has 0 in row 0",
        ),
    ] {
        let message = read_bytes(json.as_bytes(), TreeFormat::Json).expect_err(json);
        assert!(message.contains(expected), "{json}: {message}");
    }
}

#[test]
fn triangles_become_a_scene_one_by_one() {
    let mut tree = read_npz(&arrays()).expect("a tree");
    let scene = tree.scene("two.npz", UpAxis::Y, &Task::new()).expect("a scene");
    assert_eq!((scene.shape_count(), scene.name.as_str(), scene.lights.len()), (2, "two.npz", 1));
    let reason = |tree: &TreeArrays| match tree.scene("t", UpAxis::Y, &Task::new()) {
        Err(Fault::Content { reason, .. }) => reason,
        other => panic!("{other:?}"),
    };
    tree.triangles.as_mut().expect("triangles")[1][2].x = f32::NAN;
    assert!(reason(&tree).contains("triangle 1 (counted from 0)"));
    tree.triangles = None;
    assert!(reason(&tree).contains("name the scene that the tree was built over"));
}

/// Whatever a file holds, reading it ends, without a panic, in arrays that fit together or in a message.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut rng = Pcg32::seed_from_u64(11);
    let mut read_at_all = 0;
    let originals = [
        (npz(&arrays(), CompressionMethod::Stored), TreeFormat::Npz),
        (npz(&arrays(), CompressionMethod::Deflated), TreeFormat::Npz),
        (br#"{"child_min":[[[0,0,0]]],"child_index":[[-2]]}"#.to_vec(), TreeFormat::Json),
    ];
    for i in 0..6000 {
        let (original, format) = &originals[i % originals.len()];
        let mut bytes = original.clone();
        match i % 5 {
            0 => bytes.truncate(rng.random_range(0..bytes.len())),
            1 => bytes = (0..rng.random_range(0..400)).map(|_| rng.random()).collect(),
            _ => {
                for _ in 0..rng.random_range(1..9) {
                    let at = rng.random_range(0..bytes.len());
                    bytes[at] = rng.random();
                }
            }
        }
        if let Ok(tree) = read_bytes(&bytes, *format) {
            read_at_all += 1;
            assert_eq!(tree.child_min.len(), tree.child_index.len());
            assert_eq!(tree.leaf_first.len(), tree.leaf_count.len());
        }
    }
    // A changed byte of data is caught by its checksum, one of a name or a date is not.
    assert!(read_at_all > 0);
}
