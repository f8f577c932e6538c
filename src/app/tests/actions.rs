//! Actions, undo, bookmarks and the session of last time, in the whole window.

use std::path::{Path, PathBuf};

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

use super::super::commands::{Asked, Command};
use super::super::panels::PanelKind;
use super::super::{App, AppOptions, autosave};
use super::{cornell, edit, errors, press, push, settle, start};
use crate::accel::Builder;
use crate::render::View;
use crate::scene::{Camera, SceneRef};
use crate::session::Session;

fn press_with(harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    settle(harness);
}

fn type_text(harness: &mut Harness<'_, App>, text: &str) {
    harness.event(Event::Text(text.to_owned()));
    settle(harness);
}

fn session<'a>(harness: &'a Harness<'_, App>) -> &'a Session {
    &harness.state().state().session
}

fn camera(harness: &Harness<'_, App>) -> Camera {
    harness.state().state().camera().expect("something is open")
}

#[test]
fn the_palette_finds_runs_and_closes() {
    let mut harness = start(cornell());
    let is_open = |harness: &Harness<'_, App>| harness.query_by_label("Find a command").is_some();
    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    assert!(is_open(&harness) && !harness.state().state().paused, "Ctrl+P is not P");
    type_text(&mut harness, "builder sweep");
    press(&mut harness, Key::Enter);
    assert!(!is_open(&harness));
    assert_eq!(session(&harness).build().builder, Builder::Sweep);

    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    type_text(&mut harness, "view");
    // Keys go to the text, not to the views that have them.
    type_text(&mut harness, " albedo");
    press(&mut harness, Key::ArrowDown);
    press(&mut harness, Key::ArrowUp);
    press(&mut harness, Key::Enter);
    assert_eq!(session(&harness).view, View::Albedo);

    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    press(&mut harness, Key::Escape);
    assert!(!is_open(&harness));
    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    type_text(&mut harness, "panel table");
    harness.get_by_role_and_label(Role::ListItem, "Window: Panel Table").click();
    settle(&mut harness);
    assert!(!is_open(&harness) && harness.state_mut().layout_mut().is_showing(PanelKind::Table));
    assert!(errors(&harness).is_empty(), "{:?}", errors(&harness));
}

#[test]
fn a_command_that_cannot_be_done_stays_undone_and_the_palette_open() {
    let mut harness = start(cornell());
    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    type_text(&mut harness, "animate");
    press(&mut harness, Key::Enter);
    assert!(!harness.state().state().animating, "nothing moves in the Cornell box");
    assert!(harness.query_by_label("Find a command").is_some());
}

#[test]
fn settings_are_undone_and_done_again_by_keys() {
    let mut harness = start(cornell());
    let before = session(&harness).clone();
    push(&mut harness, Command::ShowPanel { panel: PanelKind::Build, shown: true });
    harness.get_by_role_and_label(Role::Slider, "Bins").set_value_accesskit(40.0);
    settle(&mut harness);
    press(&mut harness, Key::B);
    press_with(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!((session(&harness).overlay.depths, session(&harness).build().bins), (None, 40));
    press_with(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(session(&harness), &before);
    let world = harness.state().state().document.as_ref().expect("open").world.clone();
    assert_eq!(world.report.config.bins, before.build().bins, "the tree follows");
    press_with(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(session(&harness), &before, "there is nothing before that");
    press_with(&mut harness, Modifiers::COMMAND, Key::Y);
    press_with(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(session(&harness).build().bins, 40);
    assert!(session(&harness).overlay.depths.is_some());
}

#[test]
fn undo_does_not_go_beyond_another_scene_that_was_opened() {
    let mut harness = start(cornell());
    edit(&mut harness, |s| s.build_mut().bins = 40);
    push(&mut harness, Command::OpenScene(SceneRef::Builtin("soup:50".to_owned())));
    push(&mut harness, Command::Ask(Asked::Undo));
    assert_eq!(session(&harness).build().bins, 40);
    assert_eq!(session(&harness).scene.reference, SceneRef::Builtin("soup:50".to_owned()));
}

#[test]
fn a_drag_of_the_camera_is_one_step() {
    let mut harness = start(cornell());
    let before = camera(&harness);
    let at = super::middle(&harness);
    harness.drag_at(at);
    for i in 1..=5 {
        harness.hover_at(at + egui::vec2(8.0, 4.0) * i as f32);
        harness.step();
    }
    harness.drop_at(at + egui::vec2(40.0, 20.0));
    settle(&mut harness);
    assert_ne!(camera(&harness), before);
    press_with(&mut harness, Modifiers::COMMAND, Key::Z);
    assert_eq!(camera(&harness), before);
}

#[test]
fn bookmarks_are_added_renamed_gone_to_and_removed() {
    let mut harness = start(cornell());
    let first = camera(&harness);
    press_with(&mut harness, Modifiers::COMMAND, Key::B);
    assert!(session(&harness).overlay.depths.is_none(), "Ctrl+B is not B");
    press(&mut harness, Key::F);
    let second = camera(&harness);
    press_with(&mut harness, Modifiers::COMMAND, Key::B);
    press_with(&mut harness, Modifiers::COMMAND, Key::Num1);
    assert_eq!(camera(&harness), first);
    press_with(&mut harness, Modifiers::COMMAND, Key::Num2);
    assert_eq!(camera(&harness), second);
    push(&mut harness, Command::Ask(Asked::RenameBookmark { index: 1, name: " left ear ".to_owned() }));
    push(&mut harness, Command::Ask(Asked::RemoveBookmark(0)));
    let names: Vec<_> = session(&harness).bookmarks.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["left ear"]);
    press_with(&mut harness, Modifiers::COMMAND, Key::P);
    type_text(&mut harness, "left ear");
    press(&mut harness, Key::Enter);
    assert_eq!(camera(&harness), second);
}

#[test]
fn a_camera_is_copied_and_pasted_as_text_and_a_bad_one_is_said() {
    let mut harness = start(cornell());
    let text = crate::session::bookmark::camera_text(camera(&harness));
    press_with(&mut harness, Modifiers::COMMAND | Modifiers::SHIFT, Key::C);
    let said: Vec<_> = harness.state().state().messages.iter().map(|m| m.text.clone()).collect();
    assert_eq!(said, ["Copied: camera"]);
    let before = camera(&harness);
    press(&mut harness, Key::F);
    let paste = |harness: &mut Harness<'_, App>, text: &str| {
        harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::V);
        harness.step();
        harness.event(Event::Paste(text.to_owned()));
        settle(harness);
    };
    paste(&mut harness, &text);
    assert_eq!(camera(&harness), before);
    paste(&mut harness, "not a camera");
    assert_eq!(camera(&harness), before);
    assert!(errors(&harness)[0].starts_with("'not a camera' is no camera"), "{:?}", errors(&harness));
}

/// A window that keeps its session at `path`; started with nothing but flags, if there are any.
fn start_again(path: &Path, flags: Option<&[(&'static str, &str)]>) -> Harness<'static, App> {
    let options = AppOptions {
        hold_progressive: true,
        kept_session: Some(path.to_owned()),
        reopen: flags.map(|flags| flags.iter().map(|(name, text)| (*name, (*text).to_owned())).collect()),
        ..AppOptions::default()
    };
    let mut harness = Harness::builder()
        .with_size(super::SIZE)
        .with_max_steps(64)
        .build_eframe(move |cc| App::new(cc, cornell(), options));
    settle(&mut harness);
    harness
}

#[test]
fn the_session_is_kept_and_opened_again_and_flags_go_over_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("settings/last.ron");
    let mut harness = start_again(&path, Some(&[]));
    assert_eq!(session(&harness).view, View::Normal, "the first start has nothing to open again");
    edit(&mut harness, |s| (s.view, s.build_mut().leaf) = (View::Albedo, 7));
    press_with(&mut harness, Modifiers::COMMAND, Key::B);
    eframe::App::on_exit(harness.state_mut(), None);
    let kept = session(&harness).clone();
    drop(harness);
    assert_eq!(autosave::read(&path, &[]), Ok(Some(kept)));

    let again = start_again(&path, Some(&[("leaf", "3")]));
    let shown = session(&again);
    assert_eq!((shown.view, shown.build().leaf, shown.bookmarks.len()), (View::Albedo, 3, 1));
    let named = start_again(&path, None);
    assert_eq!(session(&named).view, View::Normal, "a scene that is named wins");
}

#[test]
fn the_session_is_kept_while_the_window_is_open() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("last.ron");
    drop(start_again(&path, None));
    let kept = autosave::read(&path, &[]).expect("readable").expect("kept when the scene was there");
    assert_eq!(kept.scene.reference, SceneRef::Builtin("cornell".to_owned()));
}

#[test]
fn what_cannot_be_opened_again_is_said_once_and_the_default_scene_comes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("last.ron");
    let mut lost = cornell();
    lost.scene.reference = SceneRef::File(PathBuf::from("/nowhere/gone.obj"));
    lost.build_mut().leaf = 9;
    crate::export::session_file::save(&lost, &path).expect("saved");
    let mut again = start_again(&path, Some(&[]));
    assert_eq!(errors(&again).len(), 1, "{:?}", errors(&again));
    assert!(errors(&again)[0].contains("/nowhere/gone.obj"), "{:?}", errors(&again));
    assert_eq!(session(&again).scene.reference, SceneRef::default());
    assert_eq!(session(&again).build().leaf, 9, "the settings are those of last time");
    eframe::App::on_exit(again.state_mut(), None);
    assert!(errors(&start_again(&path, Some(&[]))).is_empty(), "said once");

    std::fs::write(&path, "(version: 1, view: nonsense)").expect("written");
    let broken = start_again(&path, Some(&[]));
    assert!(errors(&broken)[0].contains("session of last time"), "{:?}", errors(&broken));
    assert_eq!(session(&broken).view, View::Normal);
}
