//! The program from outside: every command on small scenes, its results, its exit codes, and what it says to bad input.

#[path = "cli/films.rs"]
mod films;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use bvhscope::accel::{Builder, Width};
use bvhscope::export::ray_file;
use bvhscope::export::session_file;
use bvhscope::geometry::Ray;
use bvhscope::render::View;
use bvhscope::session::{Session, flags};
use glam::Vec3;
use serde_json::Value as Json;
use tempfile::TempDir;

/// A scene and a size for which every command takes a moment only.
const SMALL: [&str; 3] = ["soup:2000", "--size", "64x36"];

fn program(words: &[&str]) -> Command {
    let mut command = Command::cargo_bin("bvhscope").expect("the program is built");
    command.args(words).env("RUST_BACKTRACE", "0");
    command
}

/// Runs a command on the small scene.
fn small(command: &str, words: &[&str]) -> Command {
    let mut program = program(&[command]);
    program.args(SMALL).args(words);
    program
}

fn stdout(command: &mut Command) -> String {
    let output = command.assert().code(0).get_output().clone();
    String::from_utf8(output.stdout).expect("text")
}

fn json(command: &mut Command) -> Json {
    serde_json::from_str(&stdout(command)).expect("JSON alone on standard output")
}

/// Runs a command that fails: its one message, on standard error, and nothing on standard output.
fn refusal(command: &mut Command, code: i32) -> String {
    let output = command.assert().code(code).get_output().clone();
    assert!(
        output.stdout.is_empty(),
        "a failure prints no result: {}",
        String::from_utf8_lossy(&output.stdout)
    );
    let message = String::from_utf8(output.stderr).expect("text");
    assert!(message.contains("error: "), "{message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(path: &Path) -> String {
    path.to_str().expect("a path in UTF-8").to_owned()
}

fn written(folder: &TempDir, name: &str, bytes: impl AsRef<[u8]>) -> String {
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("written");
    text(&path)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

fn pixels(path: &Path) -> image::RgbaImage {
    image::open(path).expect("a picture").to_rgba8()
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

#[test]
fn render_writes_a_picture_that_carries_its_session() {
    let folder = folder();
    let out = folder.path().join("a.png");
    let printed =
        stdout(&mut small("render", &["--view", "nodes-visited", "--bins", "8", "--out", &text(&out)]));
    assert_eq!(printed.trim(), text(&out));
    let picture = pixels(&out);
    assert_eq!(picture.dimensions(), (64, 36));
    let first = picture.get_pixel(0, 0);
    assert!(picture.pixels().any(|p| p != first), "a picture of something");
    assert_eq!(names(folder.path()), ["a.png"], "no temporary file is left");

    let session = session_file::open(&out).expect("a session");
    assert_eq!((session.view, session.build().bins), (View::NodesVisited, 8));
    assert_eq!((session.render.width, session.scene.shape_count), (64, Some(2000)));
}

#[test]
fn a_picture_a_session_and_the_copied_command_make_the_same_picture() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    small("render", &["--view", "whitted", "--boxes", "0..3", "--time", "0.5", "--exposure", "-0.5"])
        .args(["--spp", "2", "--seed", "9", "--out", &text(&at("a.png"))])
        .assert()
        .code(0);
    program(&["render", &text(&at("a.png")), "--out", &text(&at("b.png"))]).assert().code(0);
    let session = session_file::open(&at("a.png")).expect("a session");
    session_file::save(&session, &at("s.ron")).expect("saved");
    program(&["render", "--session", &text(&at("s.ron")), "--out", &text(&at("c.png"))]).assert().code(0);
    let command = flags::command_line(&session, &text(&at("d.png")));
    let words = shlex::split(&command).expect("whole quotes");
    program(&words[1..].iter().map(String::as_str).collect::<Vec<_>>()).assert().code(0);
    let first = pixels(&at("a.png"));
    for name in ["b.png", "c.png", "d.png"] {
        assert!(pixels(&at(name)) == first, "{name} differs");
    }
}

#[test]
fn flags_override_a_session() {
    let folder = folder();
    let mut session = Session::default();
    session.build_mut().bins = 32;
    session.build_mut().leaf = 7;
    session.render.width = 40;
    session.render.height = 20;
    let path = folder.path().join("s.ron");
    session_file::save(&session, &path).expect("saved");
    let stats =
        json(&mut program(&["stats", "soup:500", "--session", &text(&path), "--leaf", "3", "--json"]));
    assert_eq!((&stats["bins"], &stats["leaf"]), (&32.into(), &3.into()));
    assert_eq!((&stats["shape_count"], &stats["settings"]["width"]), (&500.into(), &40.into()));
}

#[test]
fn boxes_and_a_legend_change_the_picture() {
    let folder = folder();
    let render = |name: &str, words: &[&str]| {
        let path = folder.path().join(name);
        small("render", &["--view", "box-tests", "--out", &text(&path)]).args(words).assert().code(0);
        pixels(&path)
    };
    let plain = render("plain.png", &[]);
    let boxes = render("boxes.png", &["--boxes", "all", "--boxes-hidden"]);
    let legend = render("legend.png", &["--legend"]);
    assert!(plain != boxes);
    assert!(legend.height() > plain.height() && legend.width() == plain.width());
    assert!(plain.enumerate_pixels().all(|(x, y, pixel)| legend.get_pixel(x, y) == pixel));
}

#[test]
fn raw_numbers_are_the_same_in_csv_and_exr() {
    use exr::prelude::*;
    let folder = folder();
    let (table, picture) = (folder.path().join("a.csv"), folder.path().join("a.exr"));
    for out in [&table, &picture] {
        small("render", &["--view", "box-tests", "--out", &text(out)]).assert().code(0);
    }
    let text = fs::read_to_string(&table).expect("a table");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("x,y,box-tests"));
    let values: Vec<f32> =
        lines.map(|line| line.rsplit(',').next().expect("a cell").parse().unwrap_or(f32::NAN)).collect();
    assert_eq!(values.len(), 64 * 36);
    assert!(values.iter().copied().fold(0.0, f32::max) > 10.0, "boxes were tested");
    let image = read_first_flat_layer_from_file(&picture).expect("an EXR file");
    assert_eq!(image.layer_data.attributes.layer_name, Some(Text::from("box-tests")));
    let raw = image.layer_data.channel_data.list[0].sample_data.values_as_f32();
    assert!(raw.zip(&values).all(|(a, b)| a == *b || (a.is_nan() && b.is_nan())));
}

#[test]
fn the_same_picture_at_any_number_of_threads() {
    let folder = folder();
    let render = |threads: &str| {
        let path = folder.path().join(format!("{threads}.png"));
        small("render", &["--spp", "2", "--threads", threads, "--out", &text(&path)]).assert().code(0);
        pixels(&path)
    };
    assert!(render("1") == render("3"));
}

#[test]
fn table_names_the_five_trees_and_reproduces_the_first_count() {
    let rows = json(&mut program(&["table", "--size", "64x36", "--json"]));
    let rows = rows.as_array().expect("a list");
    let names: Vec<_> = rows.iter().map(|row| row["name"].as_str().expect("a name")).collect();
    assert_eq!(names, ["BVH", "BVH_SAH", "QBVH", "BVH_BIN", "QBVH_BIN"]);
    assert_eq!(rows[0]["node_count"], 5857);
    let keys = [
        "scene",
        "shape_count",
        "name",
        "builder",
        "width",
        "bins",
        "leaf",
        "node_count",
        "leaf_count",
        "reference_count",
        "depth_max",
        "depth_mean",
        "sah_cost",
        "epo",
        "lcv",
        "nodes_visited_mean",
        "inner_visits_mean",
        "box_tests_mean",
        "shape_tests_mean",
        "ray_cost_mean",
        "build_ms",
        "traversal_ms",
        "frames_per_s",
        "bytes",
    ];
    for row in rows {
        let row = row.as_object().expect("an object");
        for key in keys {
            assert!(row.contains_key(key), "{key}");
        }
        assert_eq!(
            (&row["scene"], &row["shape_count"], &row["count"]),
            (&"bunny".into(), &4977.into(), &"all".into())
        );
        assert!(row["traversal_ms"].as_f64() > Some(0.0) && row["frames_per_s"].as_f64() > Some(0.0));
    }
    assert!(rows[1]["nodes_visited_mean"].as_f64() < rows[0]["nodes_visited_mean"].as_f64());
}

#[test]
fn stats_are_one_object_and_a_page_for_people() {
    let stats = json(&mut small("stats", &["--width", "4", "--leaf", "5", "--json"]));
    assert_eq!(
        (&stats["width"], &stats["leaf"], &stats["shape_count"]),
        (&4.into(), &5.into(), &2000.into())
    );
    let sizes = stats["leaf_sizes"].as_array().expect("a list");
    let references: u64 =
        sizes.iter().enumerate().map(|(n, count)| n as u64 * count.as_u64().expect("a count")).sum();
    assert_eq!(references, 2000);
    let page = stdout(&mut small("stats", &[]));
    for word in ["soup", "SAH cost", "nodes / ray", "build (ms)", "depth"] {
        assert!(page.contains(word), "{word}: {page}");
    }
    let table = stdout(&mut small("stats", &["--csv"]));
    assert_eq!(table.lines().count(), 2);
    assert!(table.starts_with("scene,shape_count,name,builder,width"));
    assert!(stdout(&mut small("stats", &["--markdown"])).starts_with("| tree |"));
}

#[test]
fn sweep_is_a_tree_for_each_of_the_grid() {
    let words = ["--bins-grid", "4,16", "--leaf-grid", "1,8", "--json"];
    let rows = json(&mut small("sweep", &words));
    let pairs: Vec<_> = rows
        .as_array()
        .expect("a list")
        .iter()
        .map(|row| (row["bins"].as_u64().expect("bins"), row["leaf"].as_u64().expect("leaf")))
        .collect();
    assert_eq!(pairs, [(4, 1), (16, 1), (4, 8), (16, 8)]);
    let message = refusal(&mut small("sweep", &["--bins-grid", "4,999"]), 2);
    assert!(message.contains("--bins-grid '4,999'") && message.contains("2 to 256"), "{message}");
}

#[test]
fn a_sweep_goes_over_builders_widths_and_costs_and_marks_its_front() {
    let words =
        ["--builders", "binned,median", "--widths", "all", "--stops", "all", "--traversal-costs", "1,4"];
    let words = [&words[..], &["--bins-grid", "8", "--leaf-grid", "4", "--json"]].concat();
    let rows = json(&mut small("sweep", &words));
    let rows = rows.as_array().expect("a list");
    // Binned: limit, and cost twice; median has no costs.
    assert_eq!(rows.len(), 3 * (3 + 1));
    assert!(rows.iter().any(|row| row["pareto_front"] == true) && rows[0]["traversal_ms"].is_null());
    for row in rows {
        // All under the session's costs, 1 and 1.
        let sum = row["inner_visits_mean"].as_f64().expect("a number")
            + row["shape_tests_mean"].as_f64().expect("one");
        assert!((row["ray_cost_mean"].as_f64().expect("a number") - sum).abs() < 1e-9, "{row}");
    }
    let page =
        stdout(&mut small("sweep", &["--bins-grid", "8", "--leaf-grid", "1,4", "--timed", "--x", "bytes"]));
    assert!(page.contains('•') && page.contains("traversal (ms)"), "{page}");
    assert!(page.contains("Pareto front of memory (KiB) and ray cost"), "{page}");
    for (flag, text, part) in [
        ("--builders", "binned,best", "allowed are all, or some of median, sweep"),
        ("--traversal-costs", "1,0", "numbers above 0"),
        ("--x", "bins", "choose one of node_count"),
        ("--find-best", "speed", "ray-cost, time"),
        ("--out", "points.txt", "use .csv or .json"),
    ] {
        let code = if flag == "--out" { 1 } else { 2 };
        let message = refusal(&mut small("sweep", &[flag, text]), code);
        assert!(message.contains(part), "{message}");
    }
    assert!(
        refusal(&mut small("sweep", &["--find-best", "time", "--bins-grid", "4"]), 2).contains("--bins-grid")
    );
}

#[test]
fn a_sweep_goes_on_from_its_file() {
    let folder = folder();
    for name in ["points.csv", "points.json"] {
        let path = text(&folder.path().join(name));
        let grid = |bins: &'static str| ["--bins-grid", bins, "--leaf-grid", "2,4", "--csv"];
        small("sweep", &grid("4")).args(["--out", &path]).assert().code(0);
        let before = stdout(&mut small("sweep", &[&grid("4")[..], &["--resume", &path]].concat()));
        let output = small("sweep", &[&grid("4,16")[..], &["--resume", &path]].concat())
            .assert()
            .code(0)
            .get_output()
            .clone();
        let said = String::from_utf8(output.stderr).expect("text");
        assert!(said.contains("2 points taken") && said.contains("4 trees, 2 of them"), "{said}");
        let printed = String::from_utf8(output.stdout).expect("text");
        assert_eq!(printed.lines().count(), 5, "{printed}");
        // What was measured before was not measured again: to the last digit the same times.
        let times = |text: &str, bins: &str| -> Vec<String> {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let keys = reader.headers().expect("keys").clone();
            let at = |key: &str| keys.iter().position(|k| k == key).expect("a key");
            let rows = reader.records().map(|r| r.expect("a row"));
            rows.filter(|r| &r[at("bins")] == bins).map(|r| r[at("build_ms")].to_owned()).collect()
        };
        assert_eq!(times(&printed, "4"), times(&before, "4"));
        if name == "points.csv" {
            assert_eq!(fs::read_to_string(&path).expect("a file"), printed);
        }
        // Points of another camera are not mixed in, and not lost.
        let mut other = small("sweep", &[&grid("4")[..], &["--resume", &path, "--count", "all"]].concat());
        assert!(refusal(&mut other, 1).contains("4 points of another scene, camera, size or cost"));
        let aside = text(&folder.path().join("aside.csv"));
        small("sweep", &[&grid("4")[..], &["--resume", &path, "--count", "all", "--out", &aside]].concat())
            .assert()
            .code(0);
    }
    assert_eq!(names(folder.path()).len(), 3, "no temporary file is left");
    assert!(
        refusal(&mut small("sweep", &["--resume", "missing.csv"]), 1).contains("cannot read missing.csv")
    );
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_leaves_what_is_done_and_goes_on() {
    let folder = folder();
    let path = folder.path().join("points.csv");
    let words =
        ["sweep", "soup:3000", "--size", "200x120", "--bins-grid", "2,3,4,5,6,7,8,9,10,11,12,13,14,15,16"];
    let words =
        [&words[..], &["--leaf-grid", "1,2,3,4,5,6,7,8", "--out", path.to_str().expect("UTF-8")]].concat();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_bvhscope"))
        .args(&words)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    let start = std::time::Instant::now();
    while !path.exists() && start.elapsed().as_secs() < 120 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("a signal").success());
    let code = child.wait().expect("it ends").code();
    let output = child.wait_with_output().expect("output");
    let said = String::from_utf8(output.stderr).expect("text");
    let printed = String::from_utf8(output.stdout).expect("text");
    // A machine that is quick enough may have been done.
    if code == Some(0) {
        return;
    }
    assert!(code == Some(1) && said.contains("stopped after") && said.contains("--resume"), "{said}");
    let rows = fs::read_to_string(&path).expect("a file").lines().count() - 1;
    assert!((1..120).contains(&rows) && printed.contains("leaf"), "{rows} rows; {printed}");
    assert_eq!(names(folder.path()), ["points.csv"], "no temporary file is left");
    let words =
        ["sweep", "soup:3000", "--size", "200x120", "--bins-grid", "2", "--leaf-grid", "1,2", "--csv"];
    let page = stdout(program(&words).args(["--resume", path.to_str().expect("UTF-8")]));
    assert!(page.lines().count() > rows, "what was done is kept");
}

#[test]
fn the_best_tree_is_found_and_never_worse_than_the_default() {
    let words = ["--find-best", "ray-cost", "--budget", "30"];
    let found = json(small("sweep", &words).arg("--json"));
    let cost = |row: &Json| row["ray_cost_mean"].as_f64().expect("a number");
    let (best, default) = (cost(&found["best"]), cost(&found["default"]));
    let tried = found["tried"].as_array().expect("a list");
    assert!(tried.len() <= 30 && tried.len() > 8);
    assert!(tried.iter().all(|row| cost(row) >= best) && default >= best);
    assert_eq!((&found["default"]["bins"], &found["default"]["leaf"]), (&16.into(), &2.into()));
    if found["verdict"] == "better" {
        assert!(best < default && found["gain_percent"].as_f64().expect("a gain") > 0.0);
        assert_eq!(found["differences"]["ray_cost_mean"]["better"], true);
        // The flags of the best make the tree that it says.
        let flags = found["best"]["build_flags"].as_str().expect("flags");
        let stats = json(small("stats", &["--json"]).args(flags.split_whitespace()));
        assert_eq!(stats["node_count"], found["best"]["node_count"]);
    } else {
        assert_eq!(found["verdict"], "default-is-best");
    }
    let again = json(small("sweep", &words).arg("--json"));
    assert_eq!(again["best"]["build_flags"], found["best"]["build_flags"], "counted, so the same each time");
    let time = stdout(&mut small("sweep", &["--find-best", "time", "--frames", "3", "--budget", "4"]));
    assert!(time.contains("Of 4 trees") && time.contains("3 frames"), "{time}");
}

#[test]
fn compare_holds_two_settings_against_each_other() {
    let words = ["--a", "--builder median", "--b", "--builder binned --bins 8", "--json"];
    let both = json(&mut small("compare", &words));
    assert_eq!((&both["a"]["builder"], &both["b"]["builder"]), (&"median".into(), &"binned".into()));
    assert_eq!(both["b"]["bins"], 8);
    let difference = both["differences"]["node_count"]["difference"].as_f64().expect("a number");
    let count = |side: &str| both[side]["node_count"].as_f64().expect("a number");
    assert_eq!(difference, count("b") - count("a"));
    let page = stdout(&mut small("compare", &["--b", "--leaf 8"]));
    assert!(page.contains("B - A") && page.contains("leaf limit"), "{page}");
    assert!(refusal(&mut small("compare", &[]), 2).contains("--a"));
    assert!(
        refusal(&mut small("compare", &["--a", "--builder best"]), 2)
            .contains("median, sweep, binned, spatial")
    );
}

#[test]
fn compare_says_how_sure_the_ray_cost_is() {
    let words = ["--a", "--builder random", "--b", "--builder sweep"];
    let cost = json(small("compare", &words).arg("--json"))["camera_ray_cost"].clone();
    let number = |side: &str, key: &str| cost[side][key].as_f64().expect("a number");
    let difference = number("b", "mean") - number("a", "mean");
    assert!((number("difference", "mean") - difference).abs() < 1e-9, "{cost}");
    assert!(difference < 0.0 && number("difference", "half_width_95") > 0.0, "{cost}");
    let page = stdout(&mut small("compare", &words));
    assert!(page.contains("95 % interval") && page.contains("±"), "{page}");
    let csv = stdout(small("compare", &words).arg("--csv"));
    assert!(csv.contains("camera_ray_cost_half_width_95,"), "{csv}");
    // Other costs are other units.
    let units = ["--a", "--traversal-cost 2", "--b", "--leaf 3"];
    let output = small("compare", &units).assert().code(0).get_output().clone();
    assert!(String::from_utf8_lossy(&output.stderr).contains("different units"));
}

#[test]
fn compare_takes_two_scenes_and_two_moments() {
    let two = json(&mut small("compare", &["--a", "soup:40", "--b", "soup:90 --leaf 4", "--json"]));
    assert_eq!((&two["a"]["shape_count"], &two["b"]["shape_count"]), (&40.into(), &90.into()));
    assert_eq!(two["differences"]["shape_count"]["difference"], 50.0);
    let page = stdout(&mut small("compare", &["--b", "soup:90"]));
    assert!(page.contains("A: ") && page.contains("B: ") && page.contains("90 shapes"), "{page}");
    let moved = ["compare", "bunny", "--size", "64x36", "--b", "--time 0.7", "--json"];
    let moved = json(&mut program(&moved));
    assert_eq!(moved["differences"]["shape_count"]["difference"], 0.0);
    assert_ne!(moved["differences"]["sah_cost"]["difference"], 0.0);
    assert!(refusal(&mut small("compare", &["--a", "a.ron"]), 2).contains("name a scene"));
}

#[test]
fn compare_writes_pictures_that_open_as_both_states() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let (both, difference) = (at("both.png"), at("difference.png"));
    let words = ["--view", "ray-cost", "--a", "--builder median", "--b", "--builder sweep --time 0.5"];
    let mut command = small("compare", &words);
    stdout(command.arg("--out").arg(&both).arg("--difference").arg(&difference));
    let size = |path| image::image_dimensions(path).expect("a picture");
    assert!(size(&both).0 == 2 * size(&difference).0 + 4, "{:?} {:?}", size(&both), size(&difference));
    let session = session_file::open(&both).expect("a session");
    let states: Vec<_> = (0..2)
        .map(|i| (&*session.variants[i].name, session.variants[i].build.builder.name(), session.time_of(i)))
        .collect();
    assert_eq!(states, [("A", "median", 0.0), ("B", "sweep", 0.5)]);
    let out = at("x.png").to_string_lossy().into_owned();
    for (words, expected) in [
        (["--b", "--leaf 4", "--difference", &out], "choose --view depth, nodes-visited"),
        (["--b", "--view ray-cost", "--difference", &out], "the same view"),
        (["--b", "--leaf 4", "--out", "x.exr"], "must end in .png"),
    ] {
        let message = refusal(&mut small("compare", &words), 2);
        assert!(message.contains(expected), "{message}");
    }
    assert!(!at("x.png").exists());
}

#[test]
fn bench_traces_three_sets_on_one_thread_and_on_all() {
    let bench = json(&mut small("bench", &["--threads", "2", "--json"]));
    let sets: Vec<_> = bench["sets"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|set| {
            (set["set"].as_str().expect("a name").to_owned(), set["threads"].as_u64().expect("a number"))
        })
        .collect();
    let expected =
        [("primary", 1), ("primary", 2), ("diffuse", 1), ("diffuse", 2), ("shadow", 1), ("shadow", 2)];
    assert_eq!(sets, expected.map(|(name, threads)| (name.to_owned(), threads)));
    for set in bench["sets"].as_array().expect("a list") {
        assert!(
            set["rays"].as_u64() >= set["hits"].as_u64() && set["mrays_per_s"].as_f64() > Some(0.0),
            "{set}"
        );
    }
    assert_eq!(bench["sets"][0]["rays"], 64 * 36);
    assert_eq!(bench["sets"][0]["sum_t"], bench["sets"][1]["sum_t"]);
    assert!(bench["build_one_thread_ms"].as_f64() > Some(0.0));
    assert!(bench["build_ms"].as_f64() > Some(0.0) && bench["node_count"].as_u64() > Some(1000));
}

#[test]
fn bench_measures_every_tree_and_packets_answer_as_rays_alone() {
    let all = json(&mut small("bench", &["--threads", "1", "--all", "--packets", "--json"]));
    let trees = all.as_array().expect("a list");
    let names: Vec<_> = trees
        .iter()
        .map(|tree| (tree["builder"].as_str().expect("a name").to_owned(), tree["width"].as_u64()))
        .collect();
    let expected = Builder::ALL
        .into_iter()
        .flat_map(|builder| Width::ALL.map(|width| (builder.name().to_owned(), Some(width.get() as u64))));
    assert_eq!(names, expected.collect::<Vec<_>>());
    let alone = json(&mut small("bench", &["--threads", "1", "--json"]));
    for tree in trees {
        for (set, same) in
            tree["sets"].as_array().expect("a list").iter().zip(alone["sets"].as_array().expect("a list"))
        {
            assert_eq!((&set["packets"], &same["packets"]), (&true.into(), &false.into()));
            for key in ["set", "rays", "hits", "sum_t"] {
                assert_eq!(set[key], same[key], "{key} of {tree}");
            }
        }
    }
    let table = stdout(&mut small("bench", &["--threads", "1", "--all"]));
    assert!(table.contains("build_ms/1") && table.contains("primary/1"), "{table}");
    assert_eq!(table.lines().filter(|line| line.contains("sweep")).count(), Width::ALL.len(), "{table}");
    let csv = stdout(&mut small("bench", &["--threads", "1", "--all", "--csv"]));
    assert_eq!(csv.lines().count(), 1 + 3 * trees.len(), "{csv}");
}

/// Rays into and past the scene, from all around it.
fn rays() -> Vec<Ray> {
    (0..500)
        .map(|i| {
            let turn = i as f32 * 0.37;
            let origin = Vec3::new(turn.cos() * 10.0, (i % 7) as f32 - 3.0, turn.sin() * 10.0);
            let target = Vec3::new((i % 11) as f32 - 5.0, (i % 5) as f32 - 2.0, (i % 3) as f32 - 1.0) * 0.3;
            Ray::new(origin, target - origin)
        })
        .collect()
}

#[test]
fn answers_to_rays_of_a_file_do_not_depend_on_the_tree() {
    let folder = folder();
    let path = |name: &str| text(&folder.path().join(name));
    ray_file::write_rays(Path::new(&path("rays")), &rays()).expect("written");
    for query in ["intersect", "occluded"] {
        let answers = path(query);
        let from_file = ["--rays", &path("rays"), "--query", query, "--json"];
        let first = json(small("bench", &from_file).args(["--builder", "median", "--answers", &answers]));
        let hits = first["sets"][0]["hits"].as_u64().expect("a count");
        assert!((50..500).contains(&hits), "{hits} hits");
        assert!(first["sets"][0].get("mismatches").is_none());
        let second = json(small("bench", &from_file).args(["--width", "8", "--expect", &answers]));
        assert_eq!((&second["sets"][0]["mismatches"], &second["sets"][0]["hits"]), (&0.into(), &hits.into()));

        let mut wrong = ray_file::read_answers(Path::new(&answers)).expect("answers");
        assert_eq!(wrong.len(), 500);
        for answer in &mut wrong[..10] {
            *answer = if answer.is_finite() && *answer > 0.0 { f32::INFINITY } else { 1.0 };
        }
        ray_file::write_answers(Path::new(&path("wrong")), &wrong).expect("written");
        let third = json(small("bench", &from_file).args(["--expect", &path("wrong")]));
        assert_eq!(third["sets"][0]["mismatches"], 10);
    }
    let page = stdout(small("bench", &["--rays", &path("rays")]).args(["--expect", &path("intersect")]));
    assert!(page.contains("mismatches") && page.contains("file"), "{page}");
}

#[test]
fn broken_ray_files_and_answers_that_do_not_fit_are_refused() {
    let folder = folder();
    let path = |name: &str| text(&folder.path().join(name));
    let garbage = written(&folder, "garbage", "nonsense");
    assert!(refusal(&mut small("bench", &["--rays", &garbage]), 1).contains("holds"));
    assert!(refusal(&mut small("bench", &["--rays", &path("none")]), 1).contains("there is no such file"));
    ray_file::write_rays(Path::new(&path("rays")), &rays()).expect("written");
    ray_file::write_answers(Path::new(&path("few")), &[1.0]).expect("written");
    let message = refusal(small("bench", &["--rays", &path("rays")]).args(["--expect", &path("few")]), 1);
    assert!(message.contains("1 answers") && message.contains("500 rays"), "{message}");
    assert!(refusal(&mut small("bench", &["--expect", &path("few")]), 2).contains("--rays"));
    let out = path("missing/answers");
    assert!(
        refusal(small("bench", &["--rays", &path("rays")]).args(["--answers", &out]), 1)
            .contains("no folder")
    );
}

#[test]
fn lists_have_a_line_a_choice() {
    let views = stdout(&mut program(&["list", "views"]));
    assert_eq!(views.lines().count(), View::ALL.len());
    assert!(views.lines().any(|line| line.starts_with("nodes-visited")));
    for what in ["builders", "scenes", "colormaps"] {
        assert!(stdout(&mut program(&["list", what])).lines().count() >= 3, "{what}");
    }
    let scenes = json(&mut program(&["list", "scenes", "--json"]));
    assert!(scenes.as_array().is_some_and(|list| list.iter().any(|scene| scene["name"] == "bunny")));
}

#[test]
fn help_says_every_flag_with_its_default() {
    for words in [&["--help"][..], &["render", "--help"], &["bench", "--help"]] {
        let help = stdout(&mut program(words));
        for flag in flags::flags() {
            assert!(help.contains(&format!("--{}", flag.name)), "{words:?}: --{}", flag.name);
        }
        for default in ["[default: binned]", "[default: 16]", "[default: 1280x720]", "[default: filmic]"] {
            assert!(help.contains(default), "{words:?}: {default}");
        }
    }
    assert!(stdout(&mut program(&["--version"])).starts_with("bvhscope "));
}

#[test]
fn wrong_usage_is_two() {
    for (words, expected) in [
        (&["stats", "--builder", "best"][..], "median, sweep, binned, spatial"),
        (&["stats", "--view", "noise"], "nodes-visited"),
        (&["stats", "--bins", "1"], "2 to 256"),
        (&["stats", "--leaf", "65"], "1 to 64"),
        (&["stats", "--width", "3"], "2, 4, 8"),
        (&["stats", "--size", "0x0"], "WIDTHxHEIGHT"),
        (&["stats", "--camera", "1,2,3"], "ex,ey,ez,tx,ty,tz,fov"),
        (&["stats", "--traversal-cost", "NaN"], "from 1e-6 to 1000"),
        (&["stats", "--json", "--csv"], "cannot be used with"),
        (&["render"], "--out"),
        (&["render", "--out", "picture.jpg"], ".png, .exr or .csv"),
        (&["list"], "WHAT"),
        (&["list", "things"], "builders, views, scenes, colormaps"),
        (&["stats", "--nonsense"], "unexpected argument"),
    ] {
        let message = refusal(&mut program(words), 2);
        assert!(message.contains(expected), "{words:?}: {message}");
    }
}

#[test]
fn bad_sessions_are_refused() {
    let folder = folder();
    for (name, bytes, expected) in [
        ("empty.ron", &b""[..], "this is not a session"),
        ("garbage.ron", b"\x00\xff\xfe", "not text"),
        ("newer.ron", b"(version: 2)", "version 2"),
        ("value.ron", b"(version: 1, render: (width: 0))", "WIDTHxHEIGHT"),
        ("cut.png", b"\x89PNG\r\n\x1a\n", "cannot read"),
    ] {
        let path = written(&folder, name, bytes);
        let message = refusal(&mut program(&["stats", &path]), 1);
        assert!(message.contains(expected) && message.contains(name), "{name}: {message}");
    }
    assert!(refusal(&mut program(&["stats", "--session", "none.ron"]), 1).contains("there is no such file"));
    let lost = written(&folder, "lost.ron", r#"(version: 1, scene: (reference: file("gone.obj")))"#);
    let message = refusal(&mut program(&["stats", &lost]), 1);
    assert!(message.contains("gone.obj"), "{message}");
}

#[test]
fn a_changed_model_is_opened_with_a_warning() {
    let folder = folder();
    let model = written(&folder, "a.obj", OBJ);
    let picture = folder.path().join("a.png");
    program(&["render", &model, "--size", "16x16", "--out", &text(&picture)]).assert().code(0);
    let again = program(&["stats", &text(&picture), "--json"]).assert().code(0).get_output().clone();
    assert!(!String::from_utf8_lossy(&again.stderr).contains("has changed"));
    fs::write(&model, &OBJ[..OBJ.len() - "f 2 3 4\n".len()]).expect("written");
    let changed = program(&["stats", &text(&picture), "--json"]).assert().code(0).get_output().clone();
    let warning = String::from_utf8_lossy(&changed.stderr).into_owned();
    assert!(warning.contains("has changed") && warning.contains("had 4 shapes and has 3"), "{warning}");
}

#[test]
fn models_that_cannot_be_used_are_refused_with_a_message() {
    let folder = folder();
    let nan = "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, bytes) in [
        ("empty.obj", &b""[..]),
        ("no_faces.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("garbage.obj", b"\x00\x01\x02\xff\xfe\xfd garbage \x80\x81"),
        ("garbage.ply", b"\x00\x01\x02\xff"),
        ("garbage.stl", b"\x00\x01\x02\xff"),
        ("garbage.glb", b"\x00\x01\x02\xff"),
        ("outside.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("nan.obj", nan.as_bytes()),
        ("unknown.xyz", b"0 0 0\n"),
    ] {
        let path = written(&folder, name, bytes);
        let message = refusal(&mut program(&["stats", &path, "--size", "8x8"]), 1);
        assert!(message.contains(name), "{name}: {message}");
    }
    let missing = text(&folder.path().join("missing.obj"));
    for words in [&["stats", &missing][..], &[&missing]] {
        let message = refusal(&mut program(words), 1);
        assert!(message.contains("missing.obj"), "{message}");
    }
}

#[test]
fn what_can_be_repaired_is_loaded_with_a_warning() {
    let folder = folder();
    let model = written(&folder, "a.obj", format!("mtllib missing.mtl\nusemtl red\n{OBJ}"));
    let output = program(&["stats", &model, "--size", "8x8", "--json"]).assert().code(0).get_output().clone();
    let warning = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(warning.contains("warning: ") && warning.contains("missing.mtl"), "{warning}");
    let stats: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(stats["shape_count"], 4);
}

#[test]
fn a_place_that_cannot_be_written_is_said_before_the_work() {
    let folder = folder();
    let missing = text(&folder.path().join("missing/a.png"));
    // A picture that would take hours: the answer comes at once.
    let long = ["render", "--size", "16384x16384", "--spp", "1000000", "--out"];
    let message = refusal(program(&long).arg(&missing).timeout(std::time::Duration::from_secs(20)), 1);
    assert!(message.contains("there is no folder") && message.contains("missing"), "{message}");
    let message = refusal(&mut program(&["render", "--out", "/proc/a.png"]), 1);
    assert!(message.contains("cannot write /proc/a.png"), "{message}");
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_failure() {
    use std::process::{Command, Stdio};
    let path: PathBuf = assert_cmd::cargo::cargo_bin("bvhscope");
    for words in [&["list", "views"][..], &["--help"]] {
        let mut child = Command::new(&path)
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("started");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("ended");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && message.is_empty(), "{words:?}: {message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let path: PathBuf = assert_cmd::cargo::cargo_bin("bvhscope");
    let output = std::process::Command::new(path).args(["list", "views"]).stdout(full).output().expect("ran");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot write to standard output"));
}
