//! The panels inside the whole window: what is set is built, traced and shown.

use std::time::{Duration, Instant};

use bvhscope::app::panels::PanelKind;
use bvhscope::app::{App, AppOptions};
use bvhscope::render::View;
use bvhscope::render::shadow::ShadowClass;
use bvhscope::scene::SceneRef;
use bvhscope::session::Session;
use egui::accesskit::Role;
use egui::pos2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

pub type Window = Harness<'static, App>;

/// Ample for a machine that builds something else meanwhile.
const PATIENCE: Duration = Duration::from_secs(60);

/// The window of the first start.
pub const SIZE: [f32; 2] = [1280.0, 800.0];
/// High enough for whole panels.
const HIGH: [f32; 2] = [1280.0, 2800.0];

pub fn window(scene: &str, size: [f32; 2]) -> Window {
    let mut session = Session::default();
    session.scene.reference = SceneRef::Builtin(scene.to_owned());
    let options = AppOptions { hold_progressive: true, ..AppOptions::default() };
    let mut window = Harness::builder()
        .with_size(size)
        .with_max_steps(64)
        .build_eframe(move |cc| App::new(cc, session, options));
    settle(&mut window);
    window
}

/// Draws until all that was asked for is there.
pub fn settle(window: &mut Window) {
    let start = Instant::now();
    loop {
        window.step();
        if window.state().is_idle() {
            break;
        }
        assert!(start.elapsed() < PATIENCE, "the window does not come to rest");
        std::thread::sleep(Duration::from_millis(2));
    }
    window.run_steps(2);
}

fn figure(window: &Window, label: &str) -> String {
    window.get_by_label_contains(&format!("{label}: ")).value().unwrap_or_default()
}

#[test]
fn dragged_bins_are_built_and_the_figures_follow() {
    let mut window = window("soup:500", SIZE);
    let before = figure(&window, "SAH cost");
    assert!(before.chars().any(|c| c.is_ascii_digit()), "{before}");
    let slider = window.get_by_role_and_label(Role::Slider, "Bins").rect();
    let at = |t: f32| pos2(slider.left() + t * slider.width(), slider.center().y);
    window.drag_at(at(0.4));
    settle(&mut window);
    window.hover_at(at(0.02));
    settle(&mut window);
    let during = figure(&window, "SAH cost");
    assert_ne!(during, before, "the tree follows the hand");
    window.drop_at(at(0.02));
    settle(&mut window);
    let state = window.state().state();
    assert!(state.session.build().bins < 4, "{:?}", state.session.build());
    assert!(state.history.len() >= 2 && state.held_range.is_none());
    assert_eq!(figure(&window, "SAH cost"), during);
}

#[test]
fn a_build_of_the_history_comes_back_with_its_figures() {
    let mut window = window("soup:500", HIGH);
    let first = figure(&window, "SAH cost").split('+').next().map(str::trim).map(str::to_owned);
    window.get_by_label("Builder median").click();
    settle(&mut window);
    assert!(!figure(&window, "SAH cost").starts_with(first.as_deref().expect("a figure")));
    window.get_by_label("Build 1: binned 16 · leaf 2 · 8-wide split").click();
    settle(&mut window);
    assert!(figure(&window, "SAH cost").starts_with(first.as_deref().expect("a figure")));
}

pub fn keep(window: &mut Window, name: &str) {
    if let Some(picture) = super::rendered(|| window.render()) {
        super::keep(&picture, name);
    }
}

#[test]
fn the_shadows_open_on_the_false_shadow() {
    let mut window = window("bunny", SIZE);
    window.state_mut().layout_mut().show(PanelKind::Shadows, true);
    settle(&mut window);
    let state = window.state().state();
    assert_eq!(state.session.view, View::ShadowDifference);
    let counts = state.shadow.counts.expect("the pixels are counted while the panel is open");
    let all: u64 = counts.0.iter().sum();
    let wrong = counts.get(ShadowClass::DarkOnlyInOccluded);
    assert!(wrong * 200 > all, "{wrong} of {all} pixels show the false shadow");
    keep(&mut window, "Window-false-shadow");
}

#[test]
fn a_counter_chosen_in_the_heatmap_is_counted_and_shown() {
    let mut window = window("soup:500", SIZE);
    window.state_mut().layout_mut().show(PanelKind::Heatmap, true);
    settle(&mut window);
    window.get_by_role_and_label(Role::ComboBox, "Counter").click();
    settle(&mut window);
    window.get_by_role_and_label(Role::Button, "ray cost").click();
    settle(&mut window);
    assert_eq!(window.state().state().session.view, View::RayCost);
    let highest = figure(&window, "Maximum");
    assert!(highest.chars().any(|c| ('1'..='9').contains(&c)), "{highest}");
    keep(&mut window, "Window-heatmap");
}

#[test]
fn a_sweep_is_measured_and_a_point_of_it_loaded() {
    let mut window = window("soup:300", HIGH);
    window.state_mut().layout_mut().show(PanelKind::Sweep, true);
    settle(&mut window);
    window.get_by_label("Start").click();
    settle(&mut window);
    let points = window.state().state().sweep.points.clone();
    assert_eq!(points.len(), 40, "the whole grid");
    assert!(points.iter().all(|p| p.number("ray_cost_mean").is_some()));
    keep(&mut window, "Window-sweep");
    let other = points.iter().find(|p| p.config != *window.state().state().session.build());
    let other = other.expect("another tree").config;
    window
        .state_mut()
        .push(bvhscope::app::commands::Command::Edit(Box::new(move |s| *s.build_mut() = other)));
    settle(&mut window);
    assert_eq!(window.state().state().document.as_ref().map(|d| d.tree.config), Some(other));
    assert_eq!(window.state().state().sweep.points.len(), 40, "the points stay");
    assert_eq!(window.state().state().sweep.stale, None, "they are of this scene and view");
    window.state_mut().push(bvhscope::app::commands::Command::OpenScene(SceneRef::Builtin("cornell".into())));
    settle(&mut window);
    assert_eq!(window.state().state().sweep.stale, Some(bvhscope::app::view::Stale::Scene));
}

#[test]
fn every_panel_shows_in_the_window() {
    let mut window = window("bunny", SIZE);
    for kind in PanelKind::ALL {
        window.state_mut().layout_mut().show(kind, true);
        settle(&mut window);
        assert_eq!(window.unnamed_widgets(), Vec::<String>::new());
        keep(&mut window, &format!("Window-{}", kind.title()));
    }
}
