//! Plots are saved from where they are; films and reports from the Export panel.

use bvhscope::app::panels::PanelKind;
use bvhscope::export::plot::csv;
use bvhscope::inspect::plot::{Axis, Plot};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;

use super::fixture::Program;

const SIZE: [f32; 2] = [340.0, 3000.0];

/// Plots of a panel by the names of their buttons.
const PLOTS: [(PanelKind, &str); 8] = [
    (PanelKind::Cost, "SAH cost per depth"),
    (PanelKind::Cost, "Leaf sizes"),
    (PanelKind::Cost, "SAH cost over bins"),
    (PanelKind::Cost, "Nodes visited over bins"),
    (PanelKind::Build, "SAH cost"),
    (PanelKind::Boxes, "Depths"),
    (PanelKind::Heatmap, "Histogram"),
    (PanelKind::Sweep, "Plot"),
];

#[test]
fn every_plot_has_a_menu_that_saves_it_as_picture_drawing_or_data() {
    for (kind, plot) in PLOTS {
        let mut harness = Program::full(kind, true).harness(SIZE);
        harness.run();
        let button = format!("Save plot {plot}");
        for (item, format) in [("Save as PNG…", "Png"), ("Save as SVG…", "Svg"), ("Save data as CSV…", "Csv")]
        {
            harness.get_by_role_and_label(Role::Button, &button).click();
            harness.run();
            harness.get_by_label(item).click();
            harness.run();
            let asked = harness.state().asked.last().cloned().unwrap_or_default();
            assert!(
                asked.starts_with("SavePlot") && asked.contains(&format!("format: {format}")),
                "{plot}: {asked}"
            );
            assert!(asked.contains("points: [Point"), "{plot} has values: {asked}");
        }
        harness.get_by_role_and_label(Role::Button, &button).click();
        harness.run();
        harness.get_by_label("Copy data").click();
        harness.run();
        let copied = &harness.state().copied;
        assert!(copied.starts_with("series,") && copied.lines().count() > 2, "{plot}: {copied}");
    }
}

#[test]
fn the_export_panel_has_films_reports_and_the_last_plot() {
    let mut program = Program::full(PanelKind::Export, true);
    let plot = Plot::new("A plot of costs", Axis::from_zero(1.0), Axis::from_zero(1.0));
    assert_eq!(csv(&plot), "series,x,A plot of costs\n");
    program.plot = Some(plot);
    let mut harness = program.harness(SIZE);
    harness.run();
    assert!(harness.query_by_label("A plot of costs").is_some());
    harness.get_by_role_and_label(Role::SpinButton, "Frames").set_value_accesskit(12.0);
    harness.run();
    for (name, expected) in [("animation", "count: 12"), ("report", "Report {"), ("plot", "Plot {")] {
        harness.get_by_label(&format!("Save the {name}")).click();
        harness.run();
        let asked = harness.state().asked.last().cloned().unwrap_or_default();
        assert!(asked.contains(expected), "{name}: {asked}");
    }
    harness.get_by_label("Motion Time").click();
    harness.run();
    harness.get_by_role_and_label(Role::SpinButton, "To").set_value_accesskit(2.5);
    harness.run();
    harness.get_by_label("Save the animation").click();
    harness.run();
    let asked = harness.state().asked.last().cloned().unwrap_or_default();
    assert!(asked.contains("time: Some([0.0, 2.5])"), "{asked}");
}

#[test]
fn bookmarks_are_named_gone_to_and_removed_in_the_scene_panel() {
    let mut program = Program::full(PanelKind::Scene, true);
    program.session.add_bookmark(bvhscope::scene::Camera::default()).expect("room");
    let mut harness = program.harness(SIZE);
    harness.run();
    harness.get_by_label("Add bookmark").click();
    harness.run();
    assert_eq!(harness.state().asked.last().map(String::as_str), Some("AddBookmark"));
    harness.get_by_label("Go to Camera 1").click();
    harness.run();
    assert_eq!(harness.state().session.camera, Some(bvhscope::scene::Camera::default()));
    harness.get_by_label("Remove Camera 1").click();
    harness.run();
    assert_eq!(harness.state().asked.last().map(String::as_str), Some("RemoveBookmark(0)"));
    let field = || harness.get_by_role_and_label(Role::TextInput, "Name of Camera 1");
    field().focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "Name of Camera 1").type_text(" left");
    harness.run();
    harness.key_press(egui::Key::Enter);
    harness.run();
    let asked = harness.state().asked.last().cloned().unwrap_or_default();
    assert!(asked.starts_with("RenameBookmark") && asked.contains("left"), "{asked}");
    harness.get_by_role_and_label(Role::TextInput, "Camera as text").focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "Camera as text").type_text("0");
    harness.run();
    harness.key_press(egui::Key::Enter);
    harness.run();
    let asked = harness.state().asked.last().cloned().unwrap_or_default();
    assert!(asked.starts_with("UseCamera"), "{asked}");
}
