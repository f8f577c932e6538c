//! The folders are layers: this test reads `src/` and fails on an upward import, and on what a layer must not name.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder (or file) of `src/` and the layers that it may import. The list is `ARCHITECTURE.md`'s map.
const LAYERS: &[(&str, &[&str])] = &[
    ("task", &[]),
    ("geometry", &[]),
    ("scene", &["geometry", "task"]),
    ("accel", &["geometry", "task"]),
    ("world", &["accel", "scene", "geometry", "task"]),
    ("render", &["world", "accel", "scene", "geometry", "task"]),
    ("inspect", &["render", "world", "accel", "scene", "geometry", "task"]),
    ("session", &["inspect", "render", "world", "accel", "scene", "geometry", "task"]),
    ("export", &["session", "inspect", "render", "world", "accel", "scene", "geometry", "task"]),
    ("app", &["export", "session", "inspect", "render", "world", "accel", "scene", "geometry", "task"]),
    (
        "cli",
        &["app", "export", "session", "inspect", "render", "world", "accel", "scene", "geometry", "task"],
    ),
];

/// Longest file that is still one thing (STYLE: at 500 ask why, at 700 split).
const MOST_LINES: usize = 700;

struct Source {
    path: PathBuf,
    /// First folder or file stem below `src/`.
    layer: String,
    text: String,
}

fn collect(folder: &Path, sources: &mut Vec<Source>, root: &Path) {
    for entry in fs::read_dir(folder).expect("src can be listed") {
        let path = entry.expect("an entry of src").path();
        if path.is_dir() {
            collect(&path, sources, root);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let inside = path.strip_prefix(root).expect("below src");
            let first = inside.components().next().expect("a name").as_os_str().to_string_lossy();
            let layer = first.trim_end_matches(".rs").to_owned();
            let text = fs::read_to_string(&path).expect("UTF-8 source");
            sources.push(Source { path, layer, text });
        }
    }
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut sources = Vec::new();
    collect(&root, &mut sources, &root);
    assert!(sources.len() > 40, "the walk over src found only {} files", sources.len());
    sources
}

/// The code of a line: no comment.
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or(line)
}

/// Whether `word` stands in `line` as a whole word.
fn names(line: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        !line[..at].chars().next_back().is_some_and(part)
            && !line[at + word.len()..].chars().next().is_some_and(part)
    })
}

/// Every line of code with its place, for the sources that `pick` picks.
fn offenders(pick: impl Fn(&Source) -> bool, is_wrong: impl Fn(&Source, &str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for source in sources().iter().filter(|s| pick(s)) {
        for (number, line) in source.text.lines().enumerate() {
            if is_wrong(source, code(line)) {
                found.push(format!("{}:{}: {}", source.path.display(), number + 1, line.trim()));
            }
        }
    }
    found
}

fn assert_none(rule: &str, found: &[String]) {
    assert!(found.is_empty(), "{rule}:\n{}", found.join("\n"));
}

#[test]
fn imports_go_downward_only() {
    let found = offenders(
        |s| !["lib", "main", "engine", "build"].contains(&s.layer.as_str()),
        |source, line| {
            let Some((_, allowed)) = LAYERS.iter().find(|(name, _)| *name == source.layer) else {
                return true;
            };
            line.match_indices("crate::").any(|(at, _)| {
                let target: String =
                    line[at + 7..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let is_layer = LAYERS.iter().any(|(name, _)| *name == target);
                is_layer && target != source.layer && !allowed.contains(&target.as_str())
            })
        },
    );
    assert_none("an import goes upward, or a folder is not in the map", &found);
}

/// Layers that are compiled as a crate of their own.
const ENGINE: [&str; 7] = ["task", "geometry", "scene", "accel", "world", "render", "inspect"];

#[test]
fn the_engine_is_all_up_to_inspect() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let modules = |file: &str| -> Vec<String> {
        let text = fs::read_to_string(root.join(file)).expect("UTF-8 source");
        let names = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
        names.map(str::to_owned).collect()
    };
    for (layer, allowed) in LAYERS {
        let in_engine = ENGINE.contains(layer);
        assert_eq!(modules("engine.rs").contains(&(*layer).to_owned()), in_engine, "{layer}");
        assert_eq!(modules("lib.rs").contains(&(*layer).to_owned()), !in_engine, "{layer}");
        assert!(!in_engine || allowed.iter().all(|below| ENGINE.contains(below)), "{layer}");
    }
}

#[test]
fn only_app_names_egui() {
    let egui = ["egui", "eframe", "egui_plot", "egui_tiles", "egui_extras", "rfd"];
    let found = offenders(|s| s.layer != "app", |_, line| egui.iter().any(|word| names(line, word)));
    assert_none("egui is named outside app/", &found);
}

#[test]
fn unsafe_code_lives_in_the_simd_folder_alone() {
    let found = offenders(
        |s| !s.path.to_string_lossy().contains("/accel/simd/"),
        |_, line| names(line, "unsafe") && !line.contains("unsafe_code"),
    );
    assert_none("unsafe outside accel/simd/", &found);
}

#[test]
fn files_are_touched_at_the_edges_only() {
    let edges = ["/scene/load/", "/export/", "/cli/", "/app/"];
    let found = offenders(
        |s| !edges.iter().any(|edge| s.path.to_string_lossy().contains(edge)),
        |source, line| {
            let tests_begin = source.text.find("#[cfg(test)]").unwrap_or(source.text.len());
            let in_tests = source.text.find(line).is_some_and(|at| at > tests_begin);
            !in_tests && ["fs::", "File::open", "File::create"].iter().any(|call| line.contains(call))
        },
    );
    assert_none("files are read in scene/load, written in export, and named by cli and app", &found);
}

#[test]
fn every_file_says_what_it_is_and_is_one_thing() {
    for source in sources() {
        let place = source.path.display();
        assert!(source.text.starts_with("//! "), "{place} does not begin with a //! sentence");
        let lines = source.text.lines().count();
        assert!(lines <= MOST_LINES, "{place} has {lines} lines: split it");
    }
}

#[test]
fn no_unwrap_outside_tests() {
    for source in sources() {
        let production = source.text.split("#[cfg(test)]").next().unwrap_or("");
        for (number, line) in production.lines().enumerate() {
            assert!(
                !code(line).contains(".unwrap()"),
                "{}:{}: unwrap outside tests",
                source.path.display(),
                number + 1
            );
        }
    }
}
