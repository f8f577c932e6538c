//! The whole program behind the window, driven without one: what a user does, and what is there when it has settled.

mod actions;
mod exports;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Event, Key, Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

use super::commands::{Command, ExportRequest};
use super::panels::PanelKind;
use super::view::{CompareStyle, CompareViews};
use super::{App, AppOptions};
use crate::accel::Builder;
use crate::render::View;
use crate::scene::SceneRef;
use crate::session::Session;

mod ab;

/// A program that is busy for so long hangs, on however slow a machine.
const HANGS: Duration = Duration::from_secs(600);

/// Small, so that pictures are quick.
const SIZE: [f32; 2] = [760.0, 400.0];

fn start(session: Session) -> Harness<'static, App> {
    let options = AppOptions { hold_progressive: true, ..AppOptions::default() };
    let mut harness = Harness::builder()
        .with_size(SIZE)
        .with_max_steps(64)
        .build_eframe(move |cc| App::new(cc, session, options));
    settle(&mut harness);
    harness
}

fn cornell() -> Session {
    let mut session = Session { view: View::Normal, ..Session::default() };
    session.scene.reference = SceneRef::Builtin("cornell".to_owned());
    session
}

/// Frames until everything that was asked for is there.
fn settle(harness: &mut Harness<'_, App>) {
    let start = Instant::now();
    let mut quiet = 0;
    while quiet < 3 {
        harness.step();
        quiet = if harness.state().is_idle() { quiet + 1 } else { 0 };
        std::thread::sleep(Duration::from_millis(1));
        assert!(start.elapsed() < HANGS, "the program does not come to rest");
    }
}

fn push(harness: &mut Harness<'_, App>, command: Command) {
    harness.state_mut().push(command);
    settle(harness);
}

fn edit(harness: &mut Harness<'_, App>, change: impl FnOnce(&mut Session) + Send + 'static) {
    push(harness, Command::Edit(Box::new(change)));
}

fn errors(harness: &Harness<'_, App>) -> Vec<String> {
    harness.state().state().messages.iter().filter(|m| m.error).map(|m| m.text.clone()).collect()
}

/// The middle of the viewport.
fn middle(harness: &Harness<'_, App>) -> Pos2 {
    harness.get_by_label("Viewport").rect().center()
}

fn press(harness: &mut Harness<'_, App>, key: Key) {
    harness.key_press(key);
    settle(harness);
}

#[test]
fn a_scene_is_opened_built_rendered_and_counted() {
    let harness = start(cornell());
    let state = harness.state().state();
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    let view = state.view();
    let world = view.world.expect("a tree");
    assert_eq!(view.scene.map(|s| s.shape_count()), Some(world.tree.refs().len()));
    let film = view.film.expect("a picture");
    assert_eq!([film.width, film.height], state.viewport);
    assert_eq!([state.session.render.width, state.session.render.height], state.viewport);
    assert!(view.rays.is_some_and(|r| r.nodes_visited_mean.is_some_and(|n| n > 1.0)));
    assert_eq!((view.history.len(), view.recent.len()), (1, 1));
    assert!(view.history[0].nodes_visited_mean.is_some());
}

#[test]
fn another_tree_keeps_the_converged_picture_and_a_heatmap_follows_it() {
    let mut harness = start(cornell());
    let film = |harness: &Harness<'_, App>| {
        Arc::clone(&harness.state().state().picture(0).expect("a picture").frame.film)
    };
    let before = film(&harness);
    edit(&mut harness, |s| s.build_mut().builder = Builder::Median);
    assert!(Arc::ptr_eq(&before, &film(&harness)), "the normals do not depend on the tree");
    assert_eq!(harness.state().state().history.len(), 2);
    edit(&mut harness, |s| s.view = View::NodesVisited);
    let median = film(&harness);
    edit(&mut harness, |s| s.build_mut().builder = Builder::Sweep);
    let sweep = film(&harness);
    assert_ne!(median.content, sweep.content, "the counts do");
    edit(&mut harness, |s| s.build_mut().builder = Builder::Median);
    assert!(Arc::ptr_eq(&median, &film(&harness)), "what was rendered once is kept");
    let view = harness.state().state().view();
    assert!(view.histogram.is_some() && view.range.is_some());
}

#[test]
fn the_range_is_held_while_a_slider_is() {
    let mut harness = start(Session { view: View::NodesVisited, ..cornell() });
    let range = |harness: &Harness<'_, App>| harness.state().state().view().range;
    let before = range(&harness);
    push(&mut harness, Command::HoldRange(true));
    edit(&mut harness, |s| s.build_mut().leaf = 64);
    assert!(harness.state().state().view().range_locked);
    assert_eq!(range(&harness), before);
    push(&mut harness, Command::HoldRange(false));
    assert_ne!(range(&harness), before, "one leaf of everything costs something else");
}

#[test]
fn what_cannot_be_opened_is_said_and_leaves_what_is_open() {
    let mut harness = start(cornell());
    let missing = PathBuf::from("/nowhere/model.obj");
    push(&mut harness, Command::OpenScene(SceneRef::File(missing)));
    let message = errors(&harness).pop().expect("an error");
    assert!(message.contains("/nowhere/model.obj"), "{message}");
    let state = harness.state().state();
    assert_eq!(state.session.scene.reference, SceneRef::Builtin("cornell".to_owned()));
    assert!(state.view().film.is_some());
    harness.get_by_label("Dismiss").click();
    settle(&mut harness);
    assert!(errors(&harness).is_empty());
    edit(&mut harness, |s| s.build_mut().bins = 9999);
    assert!(errors(&harness)[0].contains("2 to 256"));
    assert_eq!(harness.state().state().session.build().bins, 16, "the setting stays");
}

#[test]
fn a_saved_session_opens_what_it_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let (ron, png) = (folder.path().join("mine"), folder.path().join("mine.png"));
    let mut harness = start(cornell());
    edit(&mut harness, |s| {
        s.view = View::LeafVisits;
        s.build_mut().leaf = 7;
    });
    push(&mut harness, Command::SaveSession(ron.clone()));
    let picture = ExportRequest::Picture {
        path: png.clone(),
        width: 64,
        height: 48,
        samples: 1,
        overlay: true,
        legend: true,
    };
    push(&mut harness, Command::Export(picture));
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    for path in [ron.with_extension("ron"), png] {
        let mut other = start(Session { view: View::Albedo, ..cornell() });
        push(&mut other, Command::OpenSession(path));
        assert!(errors(&other).is_empty(), "{:?}", errors(&other));
        let session = &other.state().state().session;
        assert_eq!((session.view, session.build().leaf), (View::LeafVisits, 7));
        let camera = harness.state().state().camera();
        assert_eq!(other.state().state().camera(), camera);
    }
}

#[test]
fn every_panel_is_drawn_in_the_window_in_both_looks() {
    let mut harness = start(cornell());
    for dark in [true, false] {
        push(&mut harness, Command::SetDark(dark));
        for panel in PanelKind::ALL {
            push(&mut harness, Command::ShowPanel { panel, shown: true });
            assert!(harness.state_mut().layout_mut().is_showing(panel), "{}", panel.title());
        }
    }
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    let state = harness.state().state();
    assert!(state.curve.points.len() >= 20, "the bins were measured while Cost was open");
    assert!(state.curve.sweep.is_some());
    let forecast = state.view().forecast.copied().expect("predictions were measured while Cost was open");
    assert!(forecast.epo.is_some() && forecast.ray_costs.shadow.is_some());
    assert!(state.shadow.counts.is_some(), "the shadows were counted while Shadows was open");
    push(&mut harness, Command::ShowPanel { panel: PanelKind::Boxes, shown: false });
    assert!(!harness.state_mut().layout_mut().is_open(PanelKind::Boxes));
    push(&mut harness, Command::ResetLayout);
    assert!(harness.state_mut().layout_mut().is_showing(PanelKind::Boxes));
}

#[test]
fn keys_do_what_the_page_says_and_nothing_while_text_is_typed() {
    let mut harness = start(cornell());
    press(&mut harness, Key::B);
    assert_eq!(harness.state().state().session.overlay.depths, Some(super::DEFAULT_BOXES));
    assert!(harness.state().state().boxes.is_some(), "boxes are drawn");
    press(&mut harness, Key::B);
    assert!(
        harness.state().state().session.overlay.depths.is_none() && harness.state().state().boxes.is_none()
    );
    press(&mut harness, Key::Num7);
    assert_eq!(harness.state().state().session.view, View::ALL[6]);
    press(&mut harness, Key::P);
    assert!(harness.state().state().paused);
    press(&mut harness, Key::Space);
    assert!(!harness.state().state().paused);
    let own = harness.state().state().camera();
    press(&mut harness, Key::F);
    assert_ne!(harness.state().state().camera(), own);
    press(&mut harness, Key::R);
    assert_eq!(harness.state().state().camera(), own);
    press(&mut harness, Key::F1);
    assert!(harness.query_by_label("Shortcuts").is_some());

    push(&mut harness, Command::ShowPanel { panel: PanelKind::Scene, shown: true });
    harness.get_all_by_role(egui::accesskit::Role::TextInput).next().expect("a text field").focus();
    settle(&mut harness);
    let before = harness.state().state().session.clone();
    for key in [Key::B, Key::Num1, Key::P, Key::F] {
        press(&mut harness, key);
    }
    assert_eq!(harness.state().state().session, before);
    assert!(!harness.state().state().paused);
}

#[test]
fn the_mouse_orbits_pans_and_dollies() {
    let mut harness = start(cornell());
    let at = middle(&harness);
    let camera = |harness: &Harness<'_, App>| harness.state().state().camera().expect("a camera");
    let drag = |harness: &mut Harness<'_, App>, button, modifiers| {
        let button = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers };
        harness.event(Event::PointerMoved(at));
        harness.event_modifiers(button(at, true), modifiers);
        for i in 1..=4 {
            harness.event_modifiers(Event::PointerMoved(at + egui::vec2(5.0, 3.0) * i as f32), modifiers);
        }
        harness.event_modifiers(button(at + egui::vec2(20.0, 12.0), false), modifiers);
        settle(harness);
    };
    let before = camera(&harness);
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE);
    let orbited = camera(&harness);
    assert!(orbited.eye != before.eye && orbited.target == before.target);
    drag(&mut harness, PointerButton::Middle, Modifiers::NONE);
    let panned = camera(&harness);
    assert!(panned.target != orbited.target);
    let distance = |c: crate::scene::Camera| c.eye.distance(c.target);
    assert!((distance(panned) - distance(orbited)).abs() < 1e-3 * distance(orbited));
    harness.event(Event::PointerMoved(at));
    harness.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    for _ in 0..20 {
        harness.step();
    }
    settle(&mut harness);
    assert!(distance(camera(&harness)) < 0.95 * distance(panned), "the wheel goes nearer");
    let key = harness.state().state().picture(0).expect("a picture").frame.key;
    assert_eq!(key.camera, camera(&harness), "the picture follows");
}

#[test]
fn the_mouse_reads_shape_and_value() {
    let mut harness = start(Session { view: View::NodesVisited, ..cornell() });
    harness.hover_at(middle(&harness));
    settle(&mut harness);
    let hover = harness.state().state().hover.expect("the mouse is over the picture");
    assert!(hover.shape.is_some() && hover.distance.is_some_and(|d| d > 0.0));
    let film = Arc::clone(&harness.state().state().picture(0).expect("a picture").frame.film);
    assert_eq!(hover.value, film.number(hover.x, hover.y));
    assert!(hover.value.is_some_and(|v| v >= 1.0));
    harness.hover_at(pos2(3.0, 3.0));
    settle(&mut harness);
    assert_eq!(harness.state().state().hover, None);
}

#[test]
fn two_views_are_shown_side_by_side_and_as_a_wipe() {
    let mut harness = start(cornell());
    let whole = harness.state().state().viewport;
    for (style, width) in [(CompareStyle::SideBySide, whole[0] / 2), (CompareStyle::Wipe, whole[0])] {
        let compare = CompareViews::of_views(View::ShadowIntersect, View::ShadowOccluded, style);
        push(&mut harness, Command::SetCompareViews(Some(compare)));
        let state = harness.state().state();
        for (slot, side) in compare.sides().into_iter().enumerate() {
            let frame = &state.picture(slot).expect("a picture").frame;
            assert_eq!((Some(frame.key.subject.view), frame.film.width), (side.view, width));
        }
    }
    push(&mut harness, Command::SetCompareViews(None));
    assert!(harness.state().state().picture(1).is_none());
}

#[test]
fn the_false_shadow_is_shown_from_any_scene() {
    let mut harness = start(cornell());
    push(&mut harness, Command::ShadowPreset);
    let state = harness.state().state();
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
    assert_eq!(state.session.scene.reference, SceneRef::default());
    assert_eq!(state.session.view, View::ShadowDifference);
    assert!(state.camera() != state.document.as_ref().map(|d| d.still.camera), "it looks at the glass");
    let film = Arc::clone(&harness.state().state().picture(0).expect("a picture").frame.film);
    let counts = crate::inspect::shadow_difference::ClassCounts::of(&film).expect("classes");
    let share = counts.0[3] as f64 / counts.0.iter().sum::<u64>() as f64;
    assert!(share > 0.02, "the false shadow covers {share:.3} of the picture");
}

#[test]
fn a_moving_scene_gets_a_tree_for_each_moment() {
    let mut session = cornell();
    session.scene.reference = SceneRef::Builtin("room".to_owned());
    let mut harness = start(session);
    harness.state_mut().push(Command::SetAnimating(true));
    let start = Instant::now();
    while harness.state().state().session.time == 0.0 {
        harness.step();
        assert!(start.elapsed() < Duration::from_secs(30), "time stands still");
        std::thread::sleep(Duration::from_millis(2));
    }
    push(&mut harness, Command::SetAnimating(false));
    let state = harness.state().state();
    let document = state.document.as_ref().expect("a scene");
    assert_eq!(document.world.scene.time, state.session.time);
    assert_eq!(state.history.len(), 1, "moments are no builds of the history");
    edit(&mut harness, |s| s.time = 0.0);
    assert_eq!(harness.state().state().document.as_ref().map(|d| d.world.scene.time), Some(0.0));
}

#[test]
fn the_five_trees_are_measured_on_demand() {
    let mut harness = start(cornell());
    push(&mut harness, Command::ShowPanel { panel: PanelKind::Table, shown: true });
    assert!(harness.state().state().table.rows.is_empty(), "not by itself while progressive work is held");
    push(&mut harness, Command::MeasureTable);
    let table = &harness.state().state().table;
    let names: Vec<_> = table.rows.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["BVH", "BVH_SAH", "QBVH", "BVH_BIN", "QBVH_BIN"]);
    assert!(table.rows.iter().all(|r| r.times.is_some()) && !table.stale);
    edit(&mut harness, |s| s.build_mut().leaf = 5);
    assert!(harness.state().state().table.stale);
    assert_eq!(harness.state().state().table.rows.len(), 5);
}
