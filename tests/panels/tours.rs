//! The guided tours, taken from the menu to their end.

use bvhscope::app::commands::{Asked, Command};
use bvhscope::app::tours::{Go, TOURS};
use egui::Key;
use egui_kittest::kittest::Queryable as _;

use super::window::{SIZE, Window, keep, settle, window};

fn take(window: &mut Window, tour: usize) {
    window.state_mut().push(Command::Ask(Asked::Tour(Go::Begin(tour))));
    settle(window);
}

/// What has to be seen at each step: its words, and two pictures where two are compared.
fn check_step(window: &mut Window, tour: usize, step: usize) {
    let wanted = &TOURS[tour].steps[step];
    let state = window.state().state();
    let touring = state.touring.as_ref().expect("a tour");
    assert_eq!(touring.step().title, wanted.title);
    assert!(!touring.is_pending(), "{} is not set up", wanted.title);
    assert_eq!(state.compare.is_some(), state.session.variants.len() == 2 || wanted.compares_views());
    for slot in 0..state.subjects().len() {
        assert!(state.picture(slot).is_some(), "{}: picture {slot} is missing", wanted.title);
    }
    assert_eq!(wanted.selects_something(), state.selections.current().is_some(), "{}", wanted.title);
    let inspection = &state.inspection;
    if let Some(found) = inspection.found.as_ref().filter(|_| tour == 4) {
        assert_eq!((found.rays.len(), inspection.view.chosen), (2, 1), "the shadow ray is looked at");
    }
    window.get_by_label(wanted.title);
    window.get_by_label(wanted.text);
}

#[test]
fn every_tour_can_be_taken_to_its_end_and_back() {
    let mut window = window("cornell", SIZE);
    let before = window.state().state().session.clone();
    let colors = window.state().state().tree_view.figure;
    for (index, tour) in TOURS.iter().enumerate() {
        take(&mut window, index);
        for step in 0..tour.steps.len() {
            if step > 0 {
                window.key_press(Key::PageDown);
                settle(&mut window);
            }
            check_step(&mut window, index, step);
            keep(&mut window, &format!("Tour-{}-{}", index + 1, step + 1));
        }
        window.key_press(Key::PageDown);
        settle(&mut window);
        check_step(&mut window, index, tour.steps.len() - 1);
    }
    window.key_press(Key::PageUp);
    settle(&mut window);
    check_step(&mut window, TOURS.len() - 1, TOURS[TOURS.len() - 1].steps.len() - 2);
    window.get_by_label("End tour").click();
    settle(&mut window);
    let state = window.state().state();
    assert!(state.touring.is_none() && state.compare.is_none());
    assert_eq!(state.tree_view.figure, colors);
    assert_eq!(state.session.scene.reference, before.scene.reference);
    assert_eq!((state.session.variants.clone(), state.session.view), (before.variants, before.view));
}

#[test]
fn a_tour_can_be_left_where_it_stands_and_opening_ends_it() {
    let mut window = window("bunny", SIZE);
    take(&mut window, 1);
    window.get_by_label("Stay here").click();
    settle(&mut window);
    let state = window.state().state();
    assert!(state.touring.is_none() && state.session.build().bins == 8);
    take(&mut window, 1);
    let scene = bvhscope::scene::SceneRef::Builtin("cornell".to_owned());
    window.state_mut().push(Command::OpenScene(scene.clone()));
    settle(&mut window);
    let state = window.state().state();
    assert!(state.touring.is_none());
    assert_eq!(state.session.scene.reference, scene);
}
