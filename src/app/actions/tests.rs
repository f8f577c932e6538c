//! The list of actions holds together: names, sentences and keys.

use super::*;
use crate::app::state::State;
use crate::session::Session;

/// The actions of a program with bookmarks and recent scenes.
fn with_all(check: impl FnOnce(&Around)) {
    let mut session = Session::default();
    for _ in 0..12 {
        session.add_bookmark(crate::scene::Camera::default()).expect("room");
    }
    let mut state = State::new(session, true);
    state.remember_recent(&SceneRef::File("/models/sponza.obj".into()));
    let (layout, undo) = (Layout::default(), Undo::default());
    check(&Around { view: &state.view(), layout: &layout, undo: &undo, reopens: true });
}

#[test]
fn every_action_says_what_it_is_and_no_two_are_called_the_same() {
    with_all(|around| {
        let mut names: Vec<String> = Vec::new();
        for action in Action::all(around) {
            let info = action.info(around);
            assert!(!info.name.is_empty() && !info.about.is_empty(), "{action:?}");
            assert!(!info.about.ends_with('.'), "{action:?}: sentences of the list have no full stop");
            let name = info.full_name();
            assert!(!names.contains(&name), "{name} twice");
            names.push(name);
        }
        assert!(names.len() > 60, "{}", names.len());
    });
}

#[test]
fn no_two_actions_share_a_key_and_none_is_one_of_text_fields() {
    with_all(|around| {
        let mut keys = Vec::new();
        for action in Action::all(around) {
            for key in action.info(around).keys {
                assert!(!keys.contains(&key), "{action:?} takes a key that is taken: {key:?}");
                keys.push(key);
            }
        }
        for key in [Key::C, Key::V, Key::X, Key::A] {
            assert!(!keys.contains(&ctrl(key)), "Ctrl+{} belongs to text fields", key.name());
        }
        assert_eq!(
            keys.iter()
                .filter(|key| key.modifiers == Modifiers::COMMAND && DIGITS.contains(&key.logical_key))
                .count(),
            9
        );
    });
}

#[test]
fn what_needs_a_scene_says_so_while_there_is_none() {
    with_all(|around| {
        for action in [Action::FrameScene, Action::CopyCamera, Action::Animate, Action::Undo] {
            assert!(action.info(around).obstacle.is_some(), "{action:?}");
        }
        assert!(Action::Open.info(around).obstacle.is_none());
    });
}
