//! Every panel drawn with real data, narrow and wide, dark and light, and driven as a user drives it.
//!
//! Pictures need a graphics driver for tests (Mesa's lavapipe will do). Without one, what needs pictures says that it
//! is skipped; `BVHSCOPE_REQUIRE_GPU=1` makes that a failure. `BVHSCOPE_PANEL_PICTURES=folder` keeps the pictures.

#[path = "panels/compare.rs"]
mod compare;
#[path = "panels/fixture.rs"]
mod fixture;
#[path = "panels/nodes.rs"]
mod nodes;
#[path = "panels/plots.rs"]
mod plots;
#[path = "panels/tours.rs"]
mod tours;
#[path = "panels/trees.rs"]
mod trees;
#[path = "panels/window.rs"]
mod window;

use std::panic::{AssertUnwindSafe, catch_unwind};

use bvhscope::accel::{Builder, Layout, Width};
use bvhscope::app::commands::SaveTarget;
use bvhscope::app::panels::PanelKind;
use bvhscope::app::view::{CompareStyle, CompareViews, Stale, SweepState, TableState};
use bvhscope::render::{BoxStyle, View};
use bvhscope::scene::{SceneRef, UpAxis};
use bvhscope::world::NodeFigure;
use egui::accesskit::Role;
use egui::{Key, Pos2, Shape, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use fixture::{Program, job};

const WIDTHS: [f32; 2] = [320.0, 700.0];

/// As high as the highest panel, so that nothing is scrolled away.
const HEIGHT: f32 = 1500.0;

fn panel(kind: PanelKind) -> Harness<'static, Program> {
    Program::full(kind, true).harness([WIDTHS[0], HEIGHT])
}

/// The drawn panel; `None` where this machine has no driver for it.
fn picture(harness: &mut Harness<'_, Program>) -> Option<image::RgbaImage> {
    rendered(|| harness.render())
}

/// What was rendered; `None` where this machine has no driver for it.
fn rendered(render: impl FnOnce() -> Result<image::RgbaImage, String>) -> Option<image::RgbaImage> {
    match catch_unwind(AssertUnwindSafe(render)) {
        Ok(Ok(picture)) => return Some(picture),
        Ok(Err(reason)) => eprintln!("skipped: the panel cannot be rendered here: {reason}"),
        Err(_) => eprintln!("skipped: no driver for wgpu on this machine (mesa-vulkan-drivers has one)"),
    }
    let required = std::env::var_os("BVHSCOPE_REQUIRE_GPU").is_some_and(|v| v == "1");
    assert!(!required, "BVHSCOPE_REQUIRE_GPU=1, and the panel could not be rendered");
    None
}

fn keep(picture: &image::RgbaImage, name: &str) {
    if let Some(folder) = std::env::var_os("BVHSCOPE_PANEL_PICTURES") {
        std::fs::create_dir_all(&folder).expect("the folder for pictures");
        let path = std::path::Path::new(&folder).join(format!("{name}.png"));
        picture.save(path).expect("a picture can be written");
    }
}

/// Texts that reach over the sides of what they are clipped to.
fn clipped_texts(harness: &Harness<'_, Program>) -> Vec<String> {
    fn texts<'a>(shape: &'a Shape, found: &mut Vec<&'a egui::epaint::TextShape>) {
        match shape {
            Shape::Text(text) => found.push(text),
            Shape::Vec(shapes) => shapes.iter().for_each(|s| texts(s, found)),
            _ => {}
        }
    }
    let mut clipped = Vec::new();
    for shape in &harness.output().shapes {
        let mut found = Vec::new();
        texts(&shape.shape, &mut found);
        for text in found {
            let rect = text.visual_bounding_rect();
            let out =
                rect.left() < shape.clip_rect.left() - 0.5 || rect.right() > shape.clip_rect.right() + 0.5;
            if out && rect.is_positive() {
                clipped.push(format!("{:?} at {rect:?} in {:?}", text.galley.text(), shape.clip_rect));
            }
        }
    }
    clipped
}

#[test]
fn every_panel_is_drawn_at_both_widths_in_both_looks() {
    for kind in PanelKind::ALL {
        for (width, dark) in [(WIDTHS[0], true), (WIDTHS[1], true), (WIDTHS[0], false)] {
            let mut harness = Program::full(kind, dark).harness([width, HEIGHT]);
            harness.run();
            // The five trees scroll sideways where they do not fit.
            if kind != PanelKind::Table || width > 500.0 {
                let clipped = clipped_texts(&harness);
                assert!(clipped.is_empty(), "{kind:?} at {width}: {}", clipped.join("\n"));
            }
            let Some(picture) = picture(&mut harness) else { return };
            let look = if dark { "dark" } else { "light" };
            keep(&picture, &format!("{}-{width}-{look}", kind.title()));
            let first = *picture.get_pixel(2, 2);
            let drawn = picture.pixels().filter(|p| **p != first).count();
            assert!(drawn > 4000, "{kind:?} shows hardly anything: {drawn} pixels");
        }
    }
}

#[test]
fn every_panel_is_drawn_before_anything_is_loaded() {
    for kind in PanelKind::ALL {
        let mut harness = Program::empty(kind, true).harness([WIDTHS[0], HEIGHT]);
        harness.run();
        assert_eq!(clipped_texts(&harness), Vec::<String>::new(), "{kind:?}");
        if let Some(picture) = picture(&mut harness) {
            keep(&picture, &format!("{}-empty", kind.title()));
        }
    }
}

#[test]
fn dragging_bins_changes_them_at_once_and_holds_the_range_meanwhile() {
    let mut harness = panel(PanelKind::Build);
    let slider = harness.get_by_role_and_label(Role::Slider, "Bins").rect();
    let at = |t: f32| pos2(slider.left() + t * slider.width(), slider.center().y);
    harness.drag_at(at(0.2));
    harness.run();
    let first = harness.state().session.build().bins;
    assert!(harness.state().range_locked, "the range is held while the slider is");
    harness.hover_at(at(0.9));
    harness.run();
    let second = harness.state().session.build().bins;
    assert!(first < 16 && second > 64, "{first}, {second}");
    harness.drop_at(at(0.9));
    harness.run();
    assert!(!harness.state().range_locked);
    assert_eq!(harness.state().asked, ["hold range true", "hold range false"]);
}

#[test]
fn nodes_are_compressed_at_width_8_only() {
    let mut harness = panel(PanelKind::Build);
    let click = |harness: &mut Harness<'_, Program>, label: &str| {
        harness.get_by_label(label).click();
        harness.run();
    };
    let layout = |harness: &Harness<'_, Program>| harness.state().session.build().layout;
    assert!(harness.get_by_label("Layout compressed").accesskit_node().is_disabled(), "at width 2");
    click(&mut harness, "Width 8");
    click(&mut harness, "Layout compressed");
    assert_eq!(layout(&harness), Layout::Compressed);
    let note = "Compressed leaves hold 3 shapes at most.";
    assert!(harness.query_by_label(note).is_none());
    harness.get_by_role_and_label(Role::Slider, "Leaf limit").set_value_accesskit(8.0);
    harness.run();
    harness.get_by_label(note);
    harness.get_by_role_and_label(Role::Slider, "Pre-split").set_value_accesskit(0.3);
    harness.run();
    assert_eq!((layout(&harness), harness.state().session.build().pre_split), (Layout::Compressed, 0.3));
    assert_eq!(clipped_texts(&harness), Vec::<String>::new());
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Build-compressed");
    }
    click(&mut harness, "Width 4");
    assert_eq!(layout(&harness), Layout::Full);
    assert_eq!(harness.state().session.build().check(), Ok(()));
}

#[test]
fn every_choice_of_the_build_panel_reaches_the_session() {
    let mut harness = panel(PanelKind::Build);
    let click = |harness: &mut Harness<'_, Program>, label: &str| {
        harness.get_by_label(label).click();
        harness.run();
    };
    assert!(harness.query_by_label("Wide nodes collapse").is_none(), "width 2 has no wide nodes");
    click(&mut harness, "Width 4");
    click(&mut harness, "Wide nodes collapse");
    click(&mut harness, "Stop rule cost");
    click(&mut harness, "Builder sweep");
    harness.get_by_role_and_label(Role::Slider, "Leaf limit").set_value_accesskit(8.0);
    harness.run();
    harness.get_by_role_and_label(Role::SpinButton, "Traversal cost").set_value_accesskit(1.5);
    harness.run();
    let build = *harness.state().session.build();
    assert_eq!((build.builder, build.width, build.leaf), (Builder::Sweep, Width::W4, 8));
    assert_eq!((build.widen.name(), build.stop.name(), build.traversal_cost), ("collapse", "cost", 1.5));
    assert!(harness.get_by_role_and_label(Role::Slider, "Bins").accesskit_node().is_disabled());
    let shown = harness.get_by_label_contains("The tree that is shown was built with").value();
    assert!(shown.is_some_and(|l| l.contains("binned 16")), "the tree lags behind, and it says so");
}

#[test]
fn the_report_shows_the_figures_of_the_tree_and_their_change() {
    let harness = panel(PanelKind::Build);
    let world = harness.state().world.clone().expect("a world");
    let sah = world.figures.sah_cost.expect("a cost").total();
    let label = format!("SAH cost: {sah:.2}");
    let label = harness.get_by_label_contains(&label).value().unwrap_or_default();
    assert!(label.ends_with('%'), "64 bins were before, and the change is said: {label}");
}

#[test]
fn a_click_on_the_history_brings_its_settings_back() {
    let mut harness = panel(PanelKind::Build);
    harness.get_by_label("Build 1: binned 4 · leaf 2 · binary").click();
    harness.run();
    assert_eq!(harness.state().session.build().bins, 4);
}

#[test]
fn a_slow_build_shows_progress_and_can_be_cancelled() {
    let mut program = Program::full(PanelKind::Build, true);
    program.building = Some(job("building binned, 16 bins", Some(0.4)));
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.get_by_label_contains("40 %");
    harness.get_by_label("Cancel").click();
    harness.run();
    assert_eq!(harness.state().asked, ["cancel build"]);
    harness.state_mut().building = Some(bvhscope::app::view::JobStatus {
        elapsed: std::time::Duration::from_millis(150),
        ..job("building", None)
    });
    harness.run();
    assert!(harness.query_by_label("Cancel").is_none(), "a quick build does not flicker");
}

#[test]
fn boxes_are_switched_and_their_depths_dragged_over_the_bars() {
    let mut harness = panel(PanelKind::Boxes);
    harness.get_by_label("Show boxes").click();
    harness.run();
    assert_eq!(harness.state().session.overlay.depths, None);
    harness.get_by_label("Show boxes").click();
    harness.run();
    harness.get_by_label("Style fill").click();
    harness.get_by_label("Leaves only").click();
    harness.run();
    let overlay = harness.state().session.overlay;
    assert_eq!(
        (overlay.depths, overlay.style, overlay.leaves_only),
        (Some([0, 6]), BoxStyle::Fill, true),
        "the depths from before"
    );
    let deepest = harness.state().world.as_ref().and_then(|w| w.figures.depth_max).expect("a deep tree");
    let bars = harness.get_by_label_contains("Depth range").rect().shrink2(egui::vec2(4.0, 2.0));
    let bar = |depth: u32| {
        pos2(bars.left() + (depth as f32 + 0.5) / (deepest + 1) as f32 * bars.width(), bars.center().y)
    };
    drag(&mut harness, bar(9), bar(11));
    assert_eq!(harness.state().session.overlay.depths, Some([9, 11]), "a new range");
    let edge = bars.left() + 12.0 / (deepest + 1) as f32 * bars.width();
    drag(&mut harness, pos2(edge, bars.center().y), bar(14));
    let depths = harness.state().session.overlay.depths.expect("a range");
    assert!(depths[0] == 9 && (13..=15).contains(&depths[1]), "only the upper end moved: {depths:?}");
}

fn drag(harness: &mut Harness<'_, Program>, from: Pos2, to: Pos2) {
    harness.drag_at(from);
    harness.run();
    harness.hover_at(to);
    harness.run();
    harness.drop_at(to);
    harness.run();
}

#[test]
fn the_depth_range_obeys_the_keyboard() {
    let mut harness = panel(PanelKind::Boxes);
    harness.get_by_label_contains("Depth range").focus();
    harness.run();
    harness.key_press(Key::ArrowRight);
    harness.run();
    assert_eq!(harness.state().session.overlay.depths, Some([1, 7]));
    harness.key_press_modifiers(egui::Modifiers::SHIFT, Key::ArrowLeft);
    harness.run();
    assert_eq!(harness.state().session.overlay.depths, Some([1, 6]));
    harness.get_by_role_and_label(Role::SpinButton, "Least depth").set_value_accesskit(3.0);
    harness.run();
    assert_eq!(harness.state().session.overlay.depths, Some([3, 6]));
}

#[test]
fn left_out_boxes_are_said() {
    let harness = panel(PanelKind::Boxes);
    harness.get_by_label_contains("boxes are left out");
}

#[test]
fn the_heatmap_chooses_counter_rays_range_and_threshold() {
    let mut harness = panel(PanelKind::Heatmap);
    harness.get_by_role_and_label(Role::ComboBox, "Counter").click();
    harness.run();
    harness.get_by_label("box tests").click();
    harness.run();
    harness.get_by_label("Rays all").click();
    harness.run();
    assert_eq!(harness.state().session.view, View::BoxTests);
    assert_eq!(harness.state().session.count.name(), "all");
    harness.get_by_label("Range manual").click();
    harness.run();
    let auto = harness.state().session.display.range.expect("manual starts from what was automatic");
    assert!(auto[0] == 0.0 && auto[1] > 0.0);
    harness.get_by_label("Fit").click();
    harness.run();
    let fitted = harness.state().session.display.range.expect("a range");
    assert!(fitted[1] >= auto[1], "the highest number is not below the 99.5th percentile");
    let bars = harness.get_by_label_contains("Range of the colour map").rect();
    drag(&mut harness, pos2(bars.right() - 5.0, bars.center().y), bars.center());
    let dragged = harness.state().session.display.range.expect("a range");
    assert!(dragged[0] == fitted[0] && dragged[1] < 0.7 * fitted[1], "{dragged:?} after {fitted:?}");
    harness.get_by_role_and_label(Role::CheckBox, "Threshold").click();
    harness.run();
    assert_eq!(harness.state().session.display.threshold, None);
    harness.get_by_label_contains("Back to").click();
    harness.run();
    assert_eq!(harness.state().session.view, View::Path);
}

#[test]
fn a_picture_of_light_is_developed() {
    let mut program = Program::full(PanelKind::Heatmap, true);
    program.session.view = View::Whitted;
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.get_by_role_and_label(Role::Slider, "Exposure").set_value_accesskit(2.0);
    harness.get_by_label("Tone curve reinhard").click();
    harness.run();
    let display = harness.state().session.display;
    assert_eq!((display.exposure, display.tonemap.name()), (2.0, "reinhard"));
    assert!(harness.query_by_label_contains("95th percentile").is_none(), "light has no counts");
}

#[test]
fn colour_maps_are_chosen_by_their_colours() {
    let mut harness = panel(PanelKind::Heatmap);
    harness.get_by_role_and_label(Role::ComboBox, "Colour map").click();
    harness.run();
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Heatmap-maps");
    }
    harness.get_by_label("viridis").click();
    harness.run();
    assert_eq!(harness.state().session.display.colormap.name(), "viridis");
}

#[test]
fn a_held_range_is_said() {
    let mut program = Program::full(PanelKind::Heatmap, true);
    program.range_locked = true;
    let harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.get_by_label_contains("Held while you drag");
}

#[test]
fn a_click_on_the_curve_sets_the_number_of_bins() {
    let mut program = Program::full(PanelKind::Cost, true);
    program.session.build_mut().builder = Builder::Median;
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    let chart = harness.get_by_label("SAH cost over bins").rect();
    let at = pos2(chart.right() - 0.12 * chart.width(), chart.center().y);
    harness.hover_at(at);
    harness.run();
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run();
    let build = *harness.state().session.build();
    assert!(build.bins > 64 && build.builder == Builder::Binned, "{build:?}");
}

#[test]
fn the_prediction_stands_beside_what_was_measured() {
    let harness = panel(PanelKind::Cost);
    let labels = [
        "SAH alone: ",
        "SAH + EPO: ",
        "primary rays: ",
        "diffuse rays: ",
        "shadow rays: ",
        "Measured: ",
        "Rays that miss the root: ",
        "Empty space: ",
        "Lanes filled: ",
    ];
    for label in labels {
        let figure = harness.get_by_label_contains(label).value().unwrap_or_default();
        assert!(figure.chars().any(|c| c.is_ascii_digit()), "{figure}");
    }
    harness.get_by_label_contains("Of 5 builds");
}

#[test]
fn boxes_can_be_coloured_by_every_figure_of_a_node() {
    for figure in NodeFigure::ALL {
        let mut harness = Program::full(PanelKind::Boxes, true).harness([WIDTHS[0], HEIGHT]);
        harness.get_by_role_and_label(Role::ComboBox, "Colour").click();
        harness.run();
        harness.get_by_role_and_label(Role::Button, figure.label()).click();
        harness.run();
        assert_eq!(harness.state().session.overlay.color, figure);
    }
}

#[test]
fn shadows_are_compared_in_two_pictures() {
    let mut program = Program::full(PanelKind::Shadows, true);
    program.session.time = 1.0;
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    assert_eq!(harness.state().asked, Vec::<String>::new(), "what was set stays when the panel opens");
    harness.get_by_label("Show the false shadow").click();
    harness.run();
    harness.get_by_label("Compare wipe").click();
    harness.run();
    let views = harness.state().compare.expect("two pictures");
    assert_eq!(
        views,
        CompareViews::of_views(View::ShadowIntersect, View::ShadowOccluded, CompareStyle::Wipe)
    );
    harness.get_by_label("Light passes glass + mirror").click();
    harness.get_by_label("Picture difference").click();
    harness.run();
    let program = harness.state();
    assert_eq!((program.session.view, program.compare), (View::ShadowDifference, None));
    assert_eq!(program.session.shadow_rule.name(), "glass+mirror");
    assert_eq!(program.asked[0], "shadow preset");
}

#[test]
fn the_shadows_open_on_their_preset_over_the_default_scene_as_it_came() {
    let harness = panel(PanelKind::Shadows);
    assert_eq!(harness.state().asked, ["shadow preset"], "once");
    let mut program = Program::full(PanelKind::Shadows, true);
    program.session.scene.reference = SceneRef::File("mine.obj".into());
    let harness = program.harness([WIDTHS[0], HEIGHT]);
    assert_eq!(harness.state().asked, Vec::<String>::new(), "a scene of the user's own stays");
}

#[test]
fn the_table_is_measured_stopped_used_and_copied() {
    let mut program = Program::full(PanelKind::Table, true);
    let rows = std::mem::take(&mut program.table).rows;
    let mut harness = program.harness([WIDTHS[1], HEIGHT]);
    harness.get_by_label("Measure").click();
    harness.run();
    harness.state_mut().table.running = Some(job("BVH_SAH", Some(0.3)));
    harness.run();
    harness.get_by_label("Stop").click();
    harness.run();
    assert_eq!(harness.state().asked, ["measure table", "cancel table"]);
    harness.state_mut().table = TableState { rows, running: None, stale: true };
    harness.run();
    harness.get_by_label_contains("Measure again");
    let best: Vec<_> = harness.get_all_by_label_contains("SAH cost: ").collect();
    assert_eq!(best.len(), 5);
    assert!(harness.query_all_by_label_contains(", the best").count() >= 8);
    harness.get_by_label("QBVH").click();
    harness.get_by_label("Copy as Markdown").click();
    harness.run();
    let program = harness.state();
    assert_eq!((program.session.build().builder, program.session.build().width), (Builder::Sweep, Width::W4));
    assert!(program.copied.starts_with('|') && program.copied.contains("QBVH_BIN"), "{}", program.copied);
}

#[test]
fn a_sweep_is_set_up_started_held_and_gone_on_with() {
    let mut program = Program::full(PanelKind::Sweep, true);
    program.sweep = SweepState::default();
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    harness.get_by_label_contains("40 trees");
    harness.get_by_label("Sweep Builder median").click();
    harness.get_by_label("Sweep Width 8").click();
    harness.run();
    harness.get_by_label_contains("90 trees");
    harness.get_by_label("Start").click();
    harness.run();
    harness.state_mut().sweep = SweepState {
        running: Some(job("sweep: 8 bins, leaf 4", Some(0.3))),
        left: Some(std::time::Duration::from_secs(75)),
        done: 27,
        total: 90,
        ..SweepState::default()
    };
    harness.run();
    harness.get_by_label_contains("27 of 90 trees, about 1 min 10 s left");
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Sweep-running");
    }
    harness.get_by_label("Pause").click();
    harness.run();
    harness.state_mut().sweep = SweepState { can_resume: true, done: 27, total: 90, ..SweepState::default() };
    harness.run();
    harness.get_by_label_contains("Paused after 27 of 90 trees");
    harness.get_by_label("Resume").click();
    harness.run();
    let asked = &harness.state().asked;
    assert_eq!(*asked, ["sweep of 90 trees", "pause sweep true", "pause sweep false"]);
}

#[test]
fn a_wrong_list_is_said_and_starts_nothing() {
    let mut harness = panel(PanelKind::Sweep);
    harness.get_by_role_and_label(Role::TextInput, "Bins").focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "Bins").type_text(", 999");
    harness.run();
    harness.get_by_label_contains("'999' is not allowed there");
    assert!(harness.get_by_label("Start").accesskit_node().is_disabled());
}

#[test]
fn points_are_loaded_from_plot_and_table_and_the_best_from_its_button() {
    let mut program = Program::full(PanelKind::Sweep, true);
    program.sweep.stale = Some(Stale::View);
    let mut harness = program.harness([WIDTHS[1], HEIGHT]);
    harness.get_by_label_contains("through another camera");
    harness.get_by_label("Sort by build (ms)").click();
    harness.run();
    let first = harness.get_all_by_label_contains("Point ").next().expect("a row");
    let name = first.accesskit_node().label().unwrap_or_default();
    first.click();
    harness.run();
    let chosen = *harness.state().session.build();
    let point = harness.state().sweep.points.iter().find(|p| p.config == chosen).expect("a point").clone();
    assert_eq!(name, format!("Point {}", point.name()));
    let quickest = harness.state().sweep.points.iter().filter_map(|p| p.number("build_ms"));
    assert_eq!(point.number("build_ms"), quickest.reduce(f64::min), "sorted by build time");
    let best = harness.state().sweep.best.clone().expect("a search");
    if best.verdict == bvhscope::inspect::best::Verdict::Better {
        harness.get_by_label("Load it").click();
        harness.run();
        assert_eq!(*harness.state().session.build(), best.best.config);
    }
    // Somewhere on the plot there is a point.
    harness.state_mut().edits = 0;
    // The heading above it has the same name.
    let rects = harness.get_all_by_label("Plot").map(|node| node.rect());
    let chart = rects.max_by(|a, b| a.height().total_cmp(&b.height())).expect("a plot");
    let found = (0..400).any(|i| {
        let at = pos2(
            chart.left() + chart.width() * (0.05 + 0.9 * (i % 20) as f32 / 20.0),
            chart.top() + chart.height() * (0.05 + 0.9 * (i / 20) as f32 / 20.0),
        );
        harness.hover_at(at);
        harness.step();
        harness.drag_at(at);
        harness.drop_at(at);
        harness.step();
        harness.state().edits > 0
    });
    assert!(found, "a click on a point loads it");
    harness.get_by_role_and_label(Role::Button, "Find the best").click();
    harness.get_by_label("Copy as CSV").click();
    harness.run();
    let program = harness.state();
    assert!(program.asked.iter().any(|a| a.starts_with("search of ")), "{:?}", program.asked);
    assert_eq!(program.copied.lines().count(), 1 + program.sweep.points.len());
}

#[test]
fn scenes_are_opened_and_staged() {
    let mut harness = panel(PanelKind::Scene);
    harness.get_by_label("Open cornell").click();
    harness.run();
    harness.get_by_role_and_label(Role::SpinButton, "Soup size").set_value_accesskit(5000.0);
    harness.run();
    harness.get_by_label("Open a soup of this size").click();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "File or name").focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "File or name").type_text("shots/a.png");
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
    harness.get_by_label("Animate").click();
    harness.get_by_label("Ground").click();
    harness.get_by_label("Up axis Z").click();
    harness.run();
    let program = harness.state();
    assert_eq!(program.asked, ["open cornell", "open soup:5000", "open session shots/a.png", "animate true"]);
    assert_eq!((program.session.ground, program.session.up), (true, UpAxis::Z));
}

#[test]
fn exports_carry_what_was_set() {
    let mut harness = panel(PanelKind::Export);
    harness.get_by_role_and_label(Role::SpinButton, "Picture width").set_value_accesskit(640.0);
    harness.run();
    harness.get_by_label("With legend").click();
    harness.run();
    harness.get_by_label("Save the picture").click();
    harness.run();
    harness.get_by_label("Choose where to save the raw film").click();
    harness.run();
    harness.state_mut().path_chosen(SaveTarget::Raw, "out/numbers.csv".into());
    harness.run();
    harness.get_by_label("Save the raw film").click();
    harness.run();
    harness.get_by_label("Copy command").click();
    harness.run();
    let program = harness.state();
    assert_eq!(
        program.asked,
        [
            "Picture { path: \"bunny-nodes-visited.png\", width: 640, height: 1080, samples: 1, overlay: true, \
             legend: true }",
            "ask raw film bunny-nodes-visited.exr",
            "Raw { path: \"out/numbers.csv\" }",
            "copy command",
        ]
    );
    assert!(program.copied.starts_with("bvhscope render"), "{}", program.copied);
}

#[test]
fn nothing_is_saved_while_something_is_being_saved() {
    let mut program = Program::full(PanelKind::Export, true);
    program.exporting = Some(job("rendering 1920 × 1080", Some(0.5)));
    let mut harness = program.harness([WIDTHS[0], HEIGHT]);
    assert!(harness.get_by_label("Save the picture").accesskit_node().is_disabled());
    harness.get_by_label("Cancel").click();
    harness.run();
    assert_eq!(harness.state().asked, ["cancel export"]);
}
