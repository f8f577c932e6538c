//! The Compare panel, driven as a user drives it.

use bvhscope::app::panels::PanelKind;
use bvhscope::app::view::{AbState, CompareStyle, CompareViews};
use bvhscope::render::View;
use bvhscope::scene::SceneRef;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::fixture::Program;
use super::{HEIGHT, WIDTHS, keep, picture};

fn panel() -> Harness<'static, Program> {
    let mut harness = Program::full(PanelKind::Compare, true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    harness
}

/// One state, and nothing compared.
fn alone() -> Harness<'static, Program> {
    let mut program = Program::full(PanelKind::Build, true);
    program.kind = PanelKind::Compare;
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.run();
    harness
}

fn click(harness: &mut Harness<'_, Program>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

fn names(harness: &Harness<'_, Program>) -> Vec<String> {
    harness.state().session.variants.iter().map(|state| state.name.clone()).collect()
}

#[test]
fn a_state_is_kept_and_compared_with_what_comes_after_it() {
    let mut harness = alone();
    harness.get_by_label("Keep the current state, change a setting, and compare the two here.");
    assert!(harness.get_by_label("Show wipe").accesskit_node().is_disabled(), "there is one state only");
    click(&mut harness, "Keep the current state");
    assert_eq!(names(&harness), ["A", "B"]);
    assert_eq!(harness.state().session.active, 1);
    for (label, style) in [
        ("Show wipe", CompareStyle::Wipe),
        ("Show blink", CompareStyle::Blink),
        ("Show difference", CompareStyle::Difference),
        ("Show side by side", CompareStyle::SideBySide),
    ] {
        click(&mut harness, label);
        assert_eq!(harness.state().compare, Some(CompareViews::of_states(0, 1, style)));
    }
    // Who keeps again goes on looking at what is changed.
    click(&mut harness, "Keep the current state");
    let expected = CompareViews::of_states(0, 2, CompareStyle::SideBySide);
    assert_eq!((names(&harness).len(), harness.state().compare), (3, Some(expected)));
    click(&mut harness, "Swap left and right");
    let expected = CompareViews::of_states(2, 0, CompareStyle::SideBySide);
    assert_eq!(harness.state().compare, Some(expected));
    click(&mut harness, "Show off");
    assert_eq!(harness.state().compare, None);
}

#[test]
fn states_are_renamed_pinned_used_and_forgotten() {
    let mut harness = panel();
    let field = harness.get_by_label("Name of state 1");
    field.focus();
    harness.run();
    harness.get_by_label("Name of state 1").type_text(" four");
    harness.run();
    harness.key_press(egui::Key::Enter);
    harness.run();
    assert_eq!(names(&harness)[0], "A four");
    click(&mut harness, "Pin A four");
    let state = &harness.state().session.variants[0];
    assert_eq!(
        (state.scene.as_ref().map(|s| &s.reference), state.time),
        (Some(&SceneRef::default()), Some(0.0))
    );
    click(&mut harness, "Pin A four");
    assert_eq!(harness.state().session.variants[0].time, None);
    click(&mut harness, "Use A four");
    assert_eq!((harness.state().session.active, harness.state().session.build().bins), (0, 4));
    assert!(harness.state().asked.contains(&"use state 0".to_owned()));
    click(&mut harness, "Forget B");
    assert_eq!((names(&harness).len(), harness.state().compare), (1, None));
}

#[test]
fn another_moment_another_scene_and_our_own_tree_are_states_of_their_own() {
    let mut harness = alone();
    assert!(harness.get_by_label("Compare with our own tree").accesskit_node().is_disabled());
    click(&mut harness, "Compare with the later moment");
    let session = &harness.state().session;
    assert_eq!((session.time, session.time_of(1), &*session.variants[1].name), (0.0, 0.5, "A at 0.5 s"));
    let compare = harness.state().compare.expect("two states");
    assert_eq!(compare.sides().map(|side| side.variant), [Some(0), Some(1)]);
    // Asked for again, it is the same state.
    click(&mut harness, "Compare with the later moment");
    assert_eq!(names(&harness).len(), 2);
    harness.get_by_label("Other scene").focus();
    harness.run();
    harness.get_by_label("Other scene").type_text("soup:50");
    harness.run();
    click(&mut harness, "Compare with the other scene");
    let session = &harness.state().session;
    assert_eq!(session.scene_of(2).reference, SceneRef::Builtin("soup:50".to_owned()));
    assert_eq!(session.scene.reference, SceneRef::default());
    harness.get_by_label("Each scene through its own camera").click();
    harness.run();
    assert!(harness.state().compare.expect("two scenes").own_cameras);
}

#[test]
fn figures_are_listed_with_difference_and_verdict() {
    let mut harness = panel();
    let comparison = harness.state().ab.figures.clone().expect("measured");
    let row = comparison.rows.iter().find(|row| row.column.key == "sah_cost").expect("a figure");
    assert_eq!(row.better, Some(true), "sixteen bins are better than four");
    let listed = |harness: &Harness<'_, Program>, key: &str| {
        let row = comparison.rows.iter().find(|row| row.column.key == key).expect("a figure");
        let begin = format!(": A {}, B {}", row.column.show(&row.a), row.column.show(&row.b));
        let rows = harness.query_all_by_role(Role::Row);
        let labels: Vec<String> = rows.filter_map(|row| row.accesskit_node().label()).collect();
        labels.into_iter().find(|label| {
            label.contains(&begin)
                && label.to_lowercase().starts_with(row.column.title.to_lowercase().as_str())
        })
    };
    let sah = listed(&harness, "sah_cost").expect("it is listed");
    assert!(sah.contains('−') && sah.ends_with("better"), "{sah}");
    assert_eq!(listed(&harness, "leaf"), None, "equal figures are hidden");
    harness.get_by_label("Hide what is equal").click();
    harness.run();
    assert!(listed(&harness, "leaf").is_some());
    // So that what follows has its place again.
    harness.get_by_label("Hide what is equal").click();
    harness.run();
    let cost = comparison.ray_cost.expect("measured");
    harness.get_by_label(&format!("A: {}", cost.a.shown()));
    harness.get_by_label("Time frames").scroll_to_me();
    harness.run_steps(12);
    click(&mut harness, "Time frames");
    assert_eq!(harness.state().asked, ["time comparison"]);
    harness.get_by_label("Histogram of the differences of the pixels");
    let summary = harness.state().ab.difference.clone().expect("two heatmaps");
    let share = 100.0 * summary.lower_count as f64 / summary.pixel_count() as f64;
    assert!(harness.query_all_by_label_contains(&format!("{share:.1} %")).count() > 0);
}

#[test]
fn pictures_without_numbers_are_offered_others() {
    let mut harness = panel();
    assert!(harness.query_by_label("Show ray cost").is_none());
    harness.state_mut().session.view = View::Path;
    harness.run();
    harness.get_by_label("The picture path has no numbers to subtract.");
    click(&mut harness, "Show ray cost");
    assert_eq!(harness.state().session.view, View::RayCost);
}

#[test]
fn what_is_not_there_yet_is_said() {
    let mut program = Program::full(PanelKind::Compare, false);
    program.ab = AbState { building: Some(super::job("B: building binned", None)), ..AbState::default() };
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.run_steps(4);
    harness.get_by_label("Waiting for both trees.");
    if let Some(shown) = picture(&mut harness) {
        keep(&shown, "Compare-building-light");
    }
    harness.get_by_role_and_label(Role::Button, "Stop").click();
    harness.run_steps(4);
    assert_eq!(harness.state().compare, None);
}
