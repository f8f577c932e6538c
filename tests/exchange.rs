//! Trees of other programs through files of the documented form: those of the crates `bvh` and `obvhs`, of Embree's builder
//! where it is installed, and what the exporters of docs/tree-format.md write. Each gives the answers of brute force.

#[path = "exchange/npz_writer.rs"]
mod npz_writer;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use assert_cmd::Command as Program;
use glam::{Vec3, Vec3A};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use bvhscope::accel::simd::SimdLevel;
use bvhscope::accel::{BuildConfig, RayCounters};
use bvhscope::geometry::{Hit, PreparedRay, Ray, Shape};
use bvhscope::scene::{Scene, builtin};
use bvhscope::session::{Session, prepare};
use bvhscope::task::Task;
use bvhscope::world::{Packets, World};
use npz_writer::NpzWriter;

const DOCUMENT: &str = include_str!("../docs/tree-format.md");
const RUST_WRITER: &str = include_str!("exchange/npz_writer.rs");
const EMBREE: &str = include_str!("exchange/embree.cpp");

/// The blocks of code of a language in the document.
fn blocks(language: &str) -> Vec<&'static str> {
    let start = format!("```{language}\n");
    DOCUMENT.split(&start).skip(1).map(|rest| rest.split("\n```").next().expect("a block ends")).collect()
}

/// A tree in arrays, two slots a node.
#[derive(Default)]
struct Arrays {
    child_min: Vec<[f32; 3]>,
    child_max: Vec<[f32; 3]>,
    child_index: Vec<i32>,
    leaf_first: Vec<i32>,
    leaf_count: Vec<i32>,
    shape_index: Vec<i32>,
}

impl Arrays {
    fn slot(&mut self, child: i32, min: [f32; 3], max: [f32; 3]) {
        self.child_min.push(min);
        self.child_max.push(max);
        self.child_index.push(child);
    }

    fn leaf(&mut self, shapes: &[u32]) -> i32 {
        self.leaf_first.push(self.shape_index.len() as i32);
        self.leaf_count.push(shapes.len() as i32);
        self.shape_index.extend(shapes.iter().map(|shape| *shape as i32));
        -1 - self.leaf_first.len() as i32
    }

    fn write(&self, triangles: &[[Vec3; 3]], path: &Path) {
        let n = self.child_index.len() / 2;
        let mut npz = NpzWriter::default();
        npz.add("child_min", "<f4", &format!("({n}, 2, 3)"), bytemuck::cast_slice(&self.child_min));
        npz.add("child_max", "<f4", &format!("({n}, 2, 3)"), bytemuck::cast_slice(&self.child_max));
        npz.add("child_index", "<i4", &format!("({n}, 2)"), bytemuck::cast_slice(&self.child_index));
        for (name, numbers) in [
            ("leaf_first", &self.leaf_first),
            ("leaf_count", &self.leaf_count),
            ("shape_index", &self.shape_index),
        ] {
            npz.add(name, "<i4", &format!("({},)", numbers.len()), bytemuck::cast_slice(numbers));
        }
        npz.add("triangles", "<f4", &format!("({}, 3, 3)", triangles.len()), bytemuck::cast_slice(triangles));
        npz.finish(std::fs::File::create(path).expect("a file")).expect("written");
    }
}

fn soup(count: usize) -> Vec<[Vec3; 3]> {
    let scene = builtin::make(&format!("soup:{count}")).expect("a scene");
    let corners = (0..count as u32).map(|shape| match scene.shape(shape) {
        Shape::Triangle(triangle) => triangle.v,
        other => panic!("{other:?}"),
    });
    corners.collect()
}

fn obvhs_tree(triangles: &[[Vec3; 3]]) -> Arrays {
    let own: Vec<obvhs::triangle::Triangle> = triangles
        .iter()
        .map(|v| obvhs::triangle::Triangle {
            v0: Vec3A::from(v[0]),
            v1: Vec3A::from(v[1]),
            v2: Vec3A::from(v[2]),
        })
        .collect();
    let mut time = std::time::Duration::default();
    let params = obvhs::BvhBuildParams::medium_build();
    let bvh = obvhs::bvh2::builder::build_bvh2_from_tris(&own, params, &mut time);
    let mut arrays = Arrays::default();
    // Nodes of theirs that are inner nodes, in our order.
    let mut open = vec![0_usize];
    let mut at = 0;
    while at < open.len() {
        let first = bvh.nodes[open[at]].first_index as usize;
        for child in [first, first + 1] {
            let node = &bvh.nodes[child];
            let index = if node.is_leaf() {
                let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                arrays.leaf(&bvh.primitive_indices[range])
            } else {
                open.push(child);
                open.len() as i32 - 1
            };
            let bounds = node.aabb();
            arrays.slot(index, bounds.min.to_array(), bounds.max.to_array());
        }
        at += 1;
    }
    arrays
}

struct Boxed {
    bounds: bvh::aabb::Aabb<f32, 3>,
    node: usize,
}

impl bvh::aabb::Bounded<f32, 3> for Boxed {
    fn aabb(&self) -> bvh::aabb::Aabb<f32, 3> {
        self.bounds
    }
}

impl bvh::bounding_hierarchy::BHShape<f32, 3> for Boxed {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

fn bvh_tree(triangles: &[[Vec3; 3]]) -> Arrays {
    use bvh::bvh::BvhNode;
    let mut shapes: Vec<Boxed> = triangles
        .iter()
        .map(|v| {
            let (min, max) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
            let bounds = bvh::aabb::Aabb::with_bounds(min.to_array().into(), max.to_array().into());
            Boxed { bounds, node: 0 }
        })
        .collect();
    let tree = bvh::bvh::Bvh::build(&mut shapes);
    let mut arrays = Arrays::default();
    let mut open = vec![0_usize];
    let mut at = 0;
    while at < open.len() {
        let BvhNode::Node { child_l_index, child_l_aabb, child_r_index, child_r_aabb, .. } =
            &tree.nodes[open[at]]
        else {
            panic!("an inner node");
        };
        for (child, bounds) in [(*child_l_index, child_l_aabb), (*child_r_index, child_r_aabb)] {
            let index = match &tree.nodes[child] {
                BvhNode::Leaf { shape_index, .. } => arrays.leaf(&[*shape_index as u32]),
                BvhNode::Node { .. } => {
                    open.push(child);
                    open.len() as i32 - 1
                }
            };
            arrays.slot(index, bounds.min.into(), bounds.max.into());
        }
        at += 1;
    }
    arrays
}

fn nearest(scene: &Scene, ray: &Ray) -> Hit {
    let prepared = PreparedRay::new(*ray);
    let mut best = Hit::none(ray.last());
    for shape in 0..scene.shape_count() as u32 {
        if let Some(hit) = scene.shape(shape).intersect(&prepared)
            && best.is_beaten_by(hit.t, shape)
        {
            best = Hit { t: hit.t, shape, u: hit.u, v: hit.v };
        }
    }
    best
}

fn rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let mut rng = Pcg32::seed_from_u64(6);
    let bounds = scene.bounds().padded(0.5);
    let mut point = || {
        let share = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..1.0)));
        bounds.min + share * bounds.extent()
    };
    (0..count)
        .map(|i| {
            let (from, mut to) = (point(), point());
            if i % 5 == 0 {
                to[i % 3] = from[i % 3];
            }
            Ray::new(from, to - from)
        })
        .collect()
}

/// Opens the tree of a file over its own triangles at every level of instructions, and asks rays alone and in packets.
fn assert_answers_are_those_of_brute_force(path: &Path, ray_count: usize) -> World {
    let task = Task::new();
    let mut session = Session::default();
    let prepared = prepare::import(&mut session, None, path, &task).expect("a tree with its triangles");
    let file = prepared.tree.expect("a tree");
    let rays = rays(&prepared.scene, ray_count);
    let expected: Vec<Hit> = rays.iter().map(|ray| nearest(&prepared.scene, ray)).collect();
    let levels = SimdLevel::ALL.into_iter().filter(|level| level.is_available());
    let worlds = levels.map(|simd| {
        let config = BuildConfig { simd, ..BuildConfig::default() };
        let world =
            World::of(Arc::clone(&prepared.scene), Some(&file), &config, &task).expect("not cancelled");
        let findings = &world.imported.as_ref().expect("a tree from a file").findings;
        assert!(world.traced_file().is_some(), "{}: {:?}", path.display(), findings.violations.first());
        world
    });
    let mut counted: Option<Vec<RayCounters>> = None;
    let worlds: Vec<World> = worlds.collect();
    for world in &worlds {
        let mut counters = vec![RayCounters::default(); rays.len()];
        for ((ray, expected), counters) in rays.iter().zip(&expected).zip(&mut counters) {
            let hit = world.intersect(ray, counters);
            assert_eq!(
                hit.map(|h| (h.t, h.shape)),
                expected.is_some().then_some((expected.t, expected.shape)),
                "{ray:?}"
            );
            assert_eq!(world.occluded(ray, &mut ()).is_some(), hit.is_some(), "{ray:?}");
        }
        let mut packets = Packets::new(world).without_pauses();
        let (hits, of_packets) = packets.intersect_and_count(&rays);
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(hits[i], world.intersect(ray, &mut ()), "in a packet {ray:?}");
            assert_eq!(of_packets[i], counters[i], "in a packet {ray:?}");
        }
        assert_eq!(*counted.get_or_insert_with(|| counters.clone()), counters, "{:?}", world.simd_level());
    }
    worlds.into_iter().next_back().expect("a level")
}

#[test]
fn trees_of_other_crates_are_traced() {
    let folder = tempfile::tempdir().expect("a folder");
    let triangles = soup(3000);
    for (name, arrays) in [("obvhs", obvhs_tree(&triangles)), ("bvh", bvh_tree(&triangles))] {
        let path = folder.path().join(format!("{name}.npz"));
        arrays.write(&triangles, &path);
        let world = assert_answers_are_those_of_brute_force(&path, 400);
        assert_eq!((world.tree.width(), world.tree.refs().len()), (2, 3000), "{name}");
        assert!(world.figures.sah_cost.is_some_and(|cost| cost.total() > 1.0));
    }
}

/// Runs a command, and says what it said if it fails.
fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Whether a tool is there; else says that the test skips, and why.
fn has(what: &str, program: &str, arguments: &[&str]) -> bool {
    let found = Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("skipped: {what} is not installed ({program} {})", arguments.join(" "));
    }
    found
}

fn compiled(folder: &Path, name: &str, code: &str, libraries: &[&str]) -> PathBuf {
    let (source, program) = (folder.join(format!("{name}.cpp")), folder.join(name));
    std::fs::write(&source, code).expect("written");
    run(Command::new("g++").args(["-std=c++17", "-Wall", "-o"]).arg(&program).arg(&source).args(libraries));
    program
}

#[test]
fn a_tree_of_embree_is_traced() {
    const HEADER: &str =
        "#if !__has_include(<embree4/rtcore.h>) && !__has_include(<embree3/rtcore.h>)\n#error none\n#endif\n";
    if !has("a C++ compiler", "g++", &["--version"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let probe = folder.path().join("probe.cpp");
    std::fs::write(&probe, HEADER).expect("written");
    let probe = probe.to_str().expect("a path in UTF-8");
    if !has("Embree (Debian: libembree-dev)", "g++", &["-fsyntax-only", probe]) {
        return;
    }
    let library = if Path::new("/usr/include/embree4").exists() { "-lembree4" } else { "-lembree3" };
    let program =
        compiled(folder.path(), "embree", &(blocks("cpp")[0].to_owned() + "\n" + EMBREE), &[library]);
    let triangles = soup(3000);
    let input = folder.path().join("triangles");
    std::fs::write(&input, bytemuck::cast_slice(&triangles)).expect("written");
    for (slots, room) in [(2, 2), (4, 4), (7, 8), (8, 8), (16, 16)] {
        let path = folder.path().join(format!("embree-{slots}.npz"));
        run(Command::new(&program).arg(&input).arg(slots.to_string()).arg(&path));
        let world = assert_answers_are_those_of_brute_force(&path, 400);
        assert_eq!((world.tree.width(), world.tree.refs().len()), (room, 3000));
    }
}

#[test]
fn the_exporters_of_the_document_write_what_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    assert_eq!(blocks("rust"), [RUST_WRITER.trim_end()], "tests/exchange/npz_writer.rs is the document's");
    std::fs::write(path("t.json"), blocks("json")[0]).expect("written");
    assert_answers_are_those_of_brute_force(&path("t.json"), 40);
    if has("NumPy", "python3", &["-c", "import numpy"]) {
        std::fs::write(path("tree.py"), blocks("python")[0]).expect("written");
        run(Command::new("python3").arg(path("tree.py")).arg(path("numpy.npz")));
        let world = assert_answers_are_those_of_brute_force(&path("numpy.npz"), 300);
        assert_eq!((world.tree.width(), world.scene.shape_count()), (2, 500));
    }
    if has("a C++ compiler", "g++", &["--version"]) {
        let program = compiled(folder.path(), "writer", &blocks("cpp").join("\n"), &[]);
        run(Command::new(program).arg(path("cpp.npz")));
        let world = assert_answers_are_those_of_brute_force(&path("cpp.npz"), 40);
        assert_eq!((world.tree.width(), world.tree.leaf_count()), (4, 3));
    }
}

#[test]
fn numpy_reads_what_is_exported() {
    if !has("NumPy", "python3", &["-c", "import numpy"]) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.npz");
    bvhscope().args(["export-tree", "soup:300", "--width", "4", "--out"]).arg(&path).assert().success();
    let check = "import sys, numpy as np\nt = np.load(sys.argv[1])\nassert t['child_index'].shape[1] == 4\n\
                 assert t['child_min'].dtype == np.float32 and t['child_min'].shape[1:] == (4, 3)\n\
                 assert sorted(t['shape_index']) == list(range(300)) and t['triangles'].shape == (300, 3, 3)\n\
                 np.savez_compressed(sys.argv[2], **t)";
    let packed = folder.path().join("packed.npz");
    run(Command::new("python3").args(["-c", check]).arg(&path).arg(&packed));
    let world = assert_answers_are_those_of_brute_force(&packed, 300);
    assert_eq!(world.tree.width(), 4);
}

fn bvhscope() -> Program {
    let mut program = Program::new(env!("CARGO_BIN_EXE_bvhscope"));
    program.env_remove("RUST_BACKTRACE");
    program
}

fn output(arguments: &[&str]) -> (bool, String, String) {
    let output = bvhscope().args(arguments).output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.success(), text(output.stdout), text(output.stderr))
}

#[test]
fn a_tree_goes_out_and_comes_back_on_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("t.npz");
    let tree = path.to_str().expect("a path in UTF-8");
    bvhscope()
        .args(["export-tree", "soup:400", "--builder", "sweep", "--width", "2", "--out", tree])
        .assert()
        .success();
    let small = ["--size", "40x30"];
    let (done, text, _) = output(&["import", tree, small[0], small[1]]);
    assert!(done && text.contains("t.npz: valid") && text.contains("SAH cost"), "{text}");
    let json = |arguments: &[&str]| -> serde_json::Value {
        let (done, text, errors) = output(arguments);
        assert!(done, "{errors}");
        serde_json::from_str(&text).expect("JSON")
    };
    let imported = json(&["import", tree, "--json", small[0], small[1]]);
    let ours =
        json(&["stats", "soup:400", "--builder", "sweep", "--width", "2", "--json", small[0], small[1]]);
    assert_eq!(imported["valid"], true);
    assert_eq!(imported["violations"].as_array().map(Vec::len), Some(0));
    let figures = &imported["figures"];
    for key in ["sah_cost", "node_count", "depth_max", "reference_count", "width"] {
        assert_eq!(figures[key], ours[key], "{key}");
    }
    assert_eq!(figures["builder"], "imported");
    assert_eq!(figures["tree_file"], "t.npz");
    assert!(figures["bins"].is_null() && figures["build_ms"].is_null() && figures["leaf"].is_null());
    // Over the same scene, beside one of ours, by its flag.
    let flags = format!("--tree {tree}");
    let (done, text, errors) = output(&[
        "compare",
        "soup:400",
        "--a",
        &flags,
        "--b",
        "--builder median",
        "--csv",
        small[0],
        small[1],
    ]);
    assert!(done && text.contains("imported") && text.contains("median"), "{text} {errors}");
    // As a picture's tree, and as the scene alone.
    let picture = folder.path().join("p.png");
    let picture = picture.to_str().expect("a path in UTF-8");
    let (done, _, errors) =
        output(&["render", tree, "--out", picture, "--view", "nodes-visited", small[0], small[1]]);
    assert!(done, "{errors}");
    assert_eq!(json(&["stats", picture, "--json"])["tree_file"], "t.npz");
    // Of a scene of other shapes.
    let (done, _, errors) = output(&["import", tree, "soup:399"]);
    assert!(
        !done && errors.contains("400 triangles, but the scene") && errors.lines().count() == 1,
        "{errors}"
    );
}

#[test]
fn a_broken_tree_is_listed_and_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("broken.json");
    let text = blocks("json")[0].replace("[[1, 1, 0], [3, 1, 0]]", "[[1, 0.5, 0], [3, 1, 0]]");
    std::fs::write(&path, text.replace("[[-2, -3]]", "[[-2, 7]]")).expect("written");
    let tree = path.to_str().expect("a path in UTF-8");
    let (done, text, errors) = output(&["import", tree]);
    assert!(!done && errors.contains("is not valid"), "{errors}");
    assert!(text.contains("node 0, slot 1: the child 7 is out of range"), "{text}");
    assert!(
        text.contains("shape 1 is in no leaf") && text.contains("reaches out of its box by 0.5"),
        "{text}"
    );
    let (done, text, _) = output(&["import", tree, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert!(!done && json["valid"] == false && json["counts"]["bad-link"] == 1, "{json}");
    let first = &json["violations"][0];
    assert_eq!(first["kind"], "bad-link");
    assert_eq!(first["node"], 0);
    assert_eq!(first["fault"], true);
    let (_, text, _) = output(&["import", tree, "--csv"]);
    assert!(text.starts_with("kind,fault,node,leaf,shape,message\nbad-link,true,0,,,"), "{text}");
    // Elsewhere a tree of ours takes its place, and it says so.
    let (done, text, errors) = output(&["stats", tree, "--csv", "--size", "40x30"]);
    assert!(done && text.contains("binned") && errors.contains("has faults"), "{errors}");
    for (arguments, expected) in [
        (vec!["import", "t.obj"], "is no tree"),
        (vec!["import"], "TREE"),
        (vec!["export-tree", "bunny", "--out", "t.ply"], "written as .npz or .json"),
        (vec!["import", "nowhere.npz"], "no such file"),
    ] {
        let (done, _, errors) = output(&arguments);
        assert!(!done && errors.contains(expected), "{arguments:?}: {errors}");
    }
}
