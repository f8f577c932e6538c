//! Trees from files in the panels and in the window: a valid one is traced, a broken one is drawn and its faults listed.

use std::path::PathBuf;
use std::sync::Arc;

use bvhscope::accel::validate::{At, ViolationKind};
use bvhscope::accel::{BuildConfig, RawTree};
use bvhscope::app::commands::{Command, Mark};
use bvhscope::app::panels::PanelKind;
use bvhscope::export::tree_file;
use bvhscope::scene::builtin;
use bvhscope::session::TreeRef;
use bvhscope::task::Task;
use bvhscope::world::{TreeFile, World};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::fixture::{Program, build};
use super::window::{settle, window};
use super::{HEIGHT, WIDTHS, clipped_texts, keep, picture};

/// A world over a small scene with the tree of a file, as it was built or damaged.
fn world(damage: impl FnOnce(&mut RawTree)) -> Arc<World> {
    let scene = Arc::new(builtin::make("soup:300").expect("a scene"));
    let mut raw = RawTree::of(&build(&scene, &BuildConfig::default()).tree);
    damage(&mut raw);
    let file = TreeFile {
        path: PathBuf::from("/trees/engine.npz"),
        name: "engine.npz".to_owned(),
        raw,
        triangle_count: Some(300),
        content_hash: String::new(),
    };
    let world = World::with_tree(scene, Arc::new(file), &BuildConfig::default(), &Task::new());
    Arc::new(world.expect("nobody cancels"))
}

fn broken() -> Arc<World> {
    world(|raw| {
        raw.child_index[3] = 5000;
        raw.child_max[0] = [0.1; 3];
        raw.child_max[9][1] += 0.5;
        raw.child_min[1][2] = f32::NAN;
        raw.leaf_count[7] = -1;
        raw.shape_index[40] = raw.shape_index[41];
    })
}

fn program(kind: PanelKind, world: Arc<World>, dark: bool) -> Program {
    let mut program = Program::full(kind, dark);
    program.world = Some(world);
    program.session.set_tree(Some(PathBuf::from("/trees/engine.npz")));
    program
}

#[test]
fn the_panel_of_a_tree_file_is_drawn_for_valid_and_broken_trees() {
    for (name, world) in [("valid", world(|_| ())), ("broken", broken())] {
        for (kind, width, dark) in [
            (PanelKind::TreeFile, WIDTHS[0], true),
            (PanelKind::TreeFile, WIDTHS[1], false),
            (PanelKind::Build, WIDTHS[0], true),
        ] {
            let mut harness = program(kind, Arc::clone(&world), dark).harness([width, HEIGHT]);
            harness.run();
            assert_eq!(clipped_texts(&harness), Vec::<String>::new(), "{name} {width}");
            let Some(picture) = picture(&mut harness) else { return };
            keep(&picture, &format!("{}-{name}-{width}", kind.title()));
        }
    }
}

#[test]
fn a_fault_that_is_clicked_is_marked() {
    let world = broken();
    let findings = &world.imported.as_ref().expect("a tree from a file").findings;
    for kind in [
        ViolationKind::BadLink,
        ViolationKind::NotContained,
        ViolationKind::NotFinite,
        ViolationKind::BadLeaf,
    ] {
        assert!(findings.count(kind) > 0, "{kind:?}: {findings:?}");
    }
    let mut harness = program(PanelKind::TreeFile, Arc::clone(&world), true).harness([WIDTHS[1], HEIGHT]);
    harness.run();
    harness.get_by_label_contains("Fault bad link").click();
    harness.run();
    harness.get_by_label_contains("the child 5000 is out of range").click();
    harness.run();
    assert_eq!(harness.state().asked, [format!("mark {:?}", Some(Mark::Item(At::Node(0))))]);
    assert!(harness.query_by_label_contains("Marked: node 0").is_some());
    harness.get_by_label("Frame").click();
    harness.run();
    harness.get_by_label("Unmark").click();
    harness.run();
    assert_eq!(harness.state().asked[1..], ["frame marked", "mark None"]);
    // All kinds again, then the shape that is missing: it has a box, too.
    harness.get_by_label_contains("Fault bad link").click();
    harness.run();
    harness.get_by_label_contains("Fault shape missing").click();
    harness.run();
    harness.get_all_by_label_contains("is in no leaf").next().expect("a line").click();
    harness.run();
    assert!(harness.state().marked.as_ref().is_some_and(|marked| marked.bounds.is_some()));
}

#[test]
fn the_build_panel_says_that_a_tree_is_imported_and_brings_ours_back() {
    let mut harness = program(PanelKind::Build, world(|_| ()), true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    assert!(harness.query_by_label("The tree is imported from engine.npz.").is_some());
    let bins = || harness.get_by_role_and_label(Role::Slider, "Bins");
    assert!(bins().accesskit_node().is_disabled(), "a file's tree has no bins to set");
    harness.get_by_label("Build a tree instead").click();
    harness.run();
    assert_eq!(harness.state().asked, ["build own tree"]);
    assert!(harness.query_by_label_contains("imported from").is_none());
}

#[test]
fn the_window_traces_a_valid_tree_and_draws_a_broken_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = Arc::new(builtin::make("soup:500").expect("a scene"));
    let ours = build(&scene, &BuildConfig { leaf: 5, ..BuildConfig::default() });
    let [path, as_text] = ["five.npz", "five.json"].map(|name| folder.path().join(name));
    for path in [&path, &as_text] {
        tree_file::save(&ours.tree, &scene, path).expect("written");
    }
    let mut window = window("soup:500", super::window::SIZE);
    let settled = |window: &mut super::window::Window, command: Command| {
        window.state_mut().push(command);
        window.step();
        settle(window);
    };
    let world = |window: &super::window::Window| {
        Arc::clone(&window.state().state().document.as_ref().expect("a document").world)
    };
    settled(&mut window, Command::ImportTree(path.clone()));
    assert_eq!(world(&window).tree, ours.tree);
    assert!(world(&window).traced_file().is_some());
    let session = window.state().state().session.clone();
    // The same triangles: the scene stays.
    assert_eq!(session.scene.reference.text(), "soup:500");
    assert!(session.tree().is_some_and(|TreeRef { content_hash, .. }| content_hash.len() == 64));
    assert_eq!(window.state().state().history.last().and_then(|e| e.tree.clone()), session.tree().cloned());
    // Back to ours, and by the history to the file's again.
    settled(&mut window, Command::BuildOwnTree);
    assert!(world(&window).imported.is_none() && world(&window).tree != ours.tree);
    let entry = window.state().state().history[1].clone();
    let bring_back = move |s: &mut bvhscope::session::Session| s.variants[0].tree = entry.tree;
    settled(&mut window, Command::Edit(Box::new(bring_back)));
    assert_eq!(world(&window).tree, ours.tree);

    let text = std::fs::read_to_string(&as_text).expect("text");
    let damaged = folder.path().join("damaged.json");
    std::fs::write(&damaged, text.replacen("\"leaf_first\": [0,", "\"leaf_first\": [7,", 1))
        .expect("written");
    settled(&mut window, Command::ImportTree(damaged));
    let shown = world(&window);
    let imported = shown.imported.as_ref().expect("a tree from a file");
    assert!(shown.traced_file().is_none() && !imported.findings.is_valid());
    assert_eq!(shown.shown_tree().leaf_count(), ours.tree.leaf_count());
    assert_ne!(shown.shown_tree(), &shown.tree);
    settled(&mut window, Command::Mark(Some(Mark::Item(At::Leaf(0)))));
    assert!(
        window
            .state()
            .state()
            .marked
            .as_ref()
            .is_some_and(|m| m.bounds.is_some() && m.parent_bounds.is_some())
    );
    let camera = window.state().state().camera();
    settled(&mut window, Command::FrameMarked);
    assert_ne!(window.state().state().camera(), camera);
    // What cannot be read changes nothing.
    settled(&mut window, Command::ImportTree(folder.path().join("nowhere.npz")));
    assert!(Arc::ptr_eq(&world(&window), &shown));
}
