//! Two states against each other in the whole program.

use super::*;
use crate::app::ab::BLINK_MS;
use crate::inspect::difference::DifferenceSummary;
use crate::render::difference::{Difference, shared_range};
use crate::session::{SessionScene, Variant};

fn soup() -> Session {
    let mut session = Session { view: View::NodesVisited, ..Session::default() };
    session.scene.reference = SceneRef::Builtin("soup:400".to_owned());
    session
}

/// A: binned, B: median, which is active.
fn two_states() -> Harness<'static, App> {
    let mut harness = start(soup());
    edit(&mut harness, |s| {
        s.keep();
        s.build_mut().builder = Builder::Median;
    });
    harness
}

fn compare(harness: &mut Harness<'_, App>, left: usize, right: usize, style: CompareStyle) {
    push(harness, Command::SetCompareViews(Some(CompareViews::of_states(left, right, style))));
}

fn builder(harness: &Harness<'_, App>, slot: usize) -> Builder {
    let state = harness.state().state();
    let (config, _) =
        state.picture(slot).expect("a picture").frame.key.tree.expect("counts are those of a tree");
    config.builder
}

#[test]
fn both_trees_are_shown_on_one_range_and_subtracted() {
    let mut harness = two_states();
    for style in CompareStyle::ALL {
        compare(&mut harness, 0, 1, style);
        assert_eq!([builder(&harness, 0), builder(&harness, 1)], [Builder::Binned, Builder::Median]);
        let state = harness.state().state();
        let frames = [0, 1].map(|slot| &state.picture(slot).expect("a picture").frame);
        let [a, b] = frames.map(|frame| &*frame.film);
        let range = shared_range([a, b], &state.session.display);
        assert!(frames.iter().all(|frame| frame.presented.range == range), "{style:?}");
        let difference = Difference::of(a, b).expect("two heatmaps");
        let summary = DifferenceSummary::of(&difference, View::NodesVisited);
        assert_eq!(state.ab.panel.difference, summary, "{style:?}");
        assert_eq!(state.ab.panel.ready, [true; 2]);
    }
    // The same two the other way round.
    compare(&mut harness, 1, 0, CompareStyle::Difference);
    assert_eq!([builder(&harness, 0), builder(&harness, 1)], [Builder::Median, Builder::Binned]);
    push(&mut harness, Command::SetCompareViews(None));
    let state = harness.state().state();
    assert!(state.ab.kept.is_empty() && state.ab.difference.is_none() && state.picture(1).is_none());
    assert_eq!(errors(&harness), Vec::<String>::new());
}

#[test]
fn a_tree_that_is_compared_stays_when_the_current_one_changes() {
    let mut harness = start(soup());
    let world = Arc::clone(&harness.state().state().document.as_ref().expect("a scene").world);
    edit(&mut harness, |s| {
        s.keep();
    });
    compare(&mut harness, 0, 1, CompareStyle::Wipe);
    for bins in [4, 8] {
        edit(&mut harness, move |s| s.build_mut().bins = bins);
        let state = harness.state().state();
        let kept: Vec<_> = state.ab.kept.iter().map(|kept| Arc::ptr_eq(&kept.world, &world)).collect();
        assert_eq!(kept, [true], "it is neither built again nor joined by others");
        let shown = [0, 1].map(|slot| state.shown(slot).expect("a tree").tree.config.bins);
        assert_eq!(shown, [16, bins]);
    }
}

#[test]
fn boxes_are_those_of_the_tree_that_they_lie_over() {
    let mut session = soup();
    session.overlay.depths = Some([0, 3]);
    let mut harness = start(session);
    edit(&mut harness, |s| {
        s.keep();
        s.build_mut().builder = Builder::Median;
    });
    compare(&mut harness, 0, 1, CompareStyle::SideBySide);
    let state = harness.state().state();
    let of = |slot| state.boxes_of(slot).expect("boxes").key.tree.config.builder;
    assert_eq!([of(0), of(1)], [Builder::Binned, Builder::Median]);
    assert_eq!(state.own_boxes().map(|b| b.key.tree.config.builder), Some(Builder::Median));
    // Two views of one tree have the same boxes.
    let views = CompareViews::of_views(View::NodesVisited, View::RayCost, CompareStyle::SideBySide);
    push(&mut harness, Command::SetCompareViews(Some(views)));
    let state = harness.state().state();
    assert!(state.ab.boxes.is_none() && state.boxes_of(1).is_some());
}

#[test]
fn figures_of_both_are_measured_while_the_panel_is_looked_at() {
    let mut harness = two_states();
    compare(&mut harness, 0, 1, CompareStyle::SideBySide);
    assert!(harness.state().state().ab.panel.figures.is_none(), "nobody looks");
    harness.state_mut().layout_mut().show(PanelKind::Compare, true);
    settle(&mut harness);
    let state = harness.state().state();
    let figures = state.ab.panel.figures.clone().expect("measured");
    assert_eq!((&*figures.a.name, &*figures.b.name), ("A", "B"));
    let builders = [&figures.a, &figures.b].map(|stats| stats.config.builder);
    assert_eq!(builders, [Builder::Binned, Builder::Median]);
    let [width, height] = state.viewport;
    let cost = figures.ray_cost.expect("two trees, the same rays");
    assert_eq!(cost.ray_count, u64::from(width) * u64::from(height));
    assert!((cost.a.mean - figures.a.rays.ray_cost_mean.expect("rays")).abs() < 1e-3);
    assert!(figures.a.times.is_none() && state.ab.panel.can_time);
    push(&mut harness, Command::TimeComparison);
    let panel = &harness.state().state().ab.panel;
    let timed = panel.figures.clone().expect("measured");
    assert!(timed.a.times.is_some() && timed.b.times.is_some() && !panel.can_time);
    edit(&mut harness, |s| s.build_mut().leaf = 8);
    let again = harness.state().state().ab.panel.figures.clone().expect("measured");
    assert_eq!((again.a.config.leaf, again.b.config.leaf), (2, 8));
    assert!(again.a.times.is_none(), "times are asked for anew");
}

#[test]
fn another_scene_is_loaded_for_its_side_and_can_become_the_current_one() {
    let mut harness = start(soup());
    edit(&mut harness, |s| {
        let reference = SceneRef::Builtin("cornell".to_owned());
        let scene = Some(SessionScene { reference, ..SessionScene::default() });
        s.add_or_find(Variant { name: "other".to_owned(), scene, ..Variant::default() });
    });
    compare(&mut harness, 0, 1, CompareStyle::SideBySide);
    let scenes = |harness: &Harness<'_, App>| {
        [0, 1].map(|slot| harness.state().state().shown(slot).expect("a tree").world.scene.shape_count())
    };
    let counts = scenes(&harness);
    assert!(counts[0] == 400 && counts[1] < 100, "{counts:?}");
    let state = harness.state().state();
    assert_eq!(state.shown(0).map(|s| s.camera), state.shown(1).map(|s| s.camera), "cameras are linked");
    let own = CompareViews { own_cameras: true, ..state.compare.expect("two") };
    push(&mut harness, Command::SetCompareViews(Some(own)));
    let state = harness.state().state();
    let right = state.shown(1).expect("a tree");
    assert_eq!(right.camera, right.world.scene.camera);
    assert_ne!(state.shown(0).expect("a tree").camera, right.camera);
    assert!(state.picture(0).is_some() && state.picture(1).is_some());
    push(&mut harness, Command::ActivateVariant(1));
    let state = harness.state().state();
    assert_eq!(state.session.scene.reference, SceneRef::Builtin("cornell".to_owned()));
    assert_eq!(scenes(&harness), counts, "each side shows what it did before");
    assert_eq!(errors(&harness), Vec::<String>::new());
}

#[test]
fn a_moment_is_compared_with_a_later_one() {
    let mut session = soup();
    session.scene.reference = SceneRef::default();
    let mut harness = start(session);
    edit(&mut harness, |s| {
        let later = Variant { name: "later".to_owned(), time: Some(0.75), ..s.variants[0].clone() };
        s.add_or_find(later);
    });
    compare(&mut harness, 0, 1, CompareStyle::Blink);
    let state = harness.state().state();
    let times = [0, 1].map(|slot| state.shown(slot).expect("a tree").world.scene.time);
    assert_eq!(times, [0.0, 0.75]);
    let same = |slot: usize| state.picture(slot).expect("a picture").frame.key.scene;
    assert_ne!(same(0), same(1));
    assert!(state.compare.is_some_and(|c| c.blink_ms == BLINK_MS));
}

#[test]
fn what_cannot_be_opened_is_said_once_and_the_other_side_stays() {
    let mut harness = start(soup());
    edit(&mut harness, |s| {
        let reference = SceneRef::File("nowhere/to/be/found.obj".into());
        let scene = Some(SessionScene { reference, ..SessionScene::default() });
        s.add_or_find(Variant { name: "lost".to_owned(), scene, ..Variant::default() });
    });
    compare(&mut harness, 0, 1, CompareStyle::Wipe);
    let errors = errors(&harness);
    assert!(errors.len() == 1 && errors[0].contains("found.obj"), "{errors:?}");
    let state = harness.state().state();
    assert_eq!(state.ab.panel.ready, [true, false]);
    assert!(state.picture(0).is_some() && state.picture(1).is_none());
    // A state that is gone leaves the current one on both sides.
    edit(&mut harness, |s| s.variants.truncate(1));
    assert_eq!(harness.state().state().ab.panel.ready, [true, true]);
}

#[test]
fn pictures_without_a_tree_are_shared_and_not_subtracted() {
    let mut harness = two_states();
    edit(&mut harness, |s| s.view = View::Normal);
    compare(&mut harness, 0, 1, CompareStyle::Difference);
    let state = harness.state().state();
    let film = |slot| Arc::clone(&state.picture(slot).expect("a picture").frame.film);
    assert!(Arc::ptr_eq(&film(0), &film(1)), "one film serves both");
    assert!(state.ab.difference.is_none() && !state.compares_numbers());
}
