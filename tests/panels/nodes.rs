//! Nodes that are selected and rays that are looked at, in their panels and in the window.

use bvhscope::accel::NodeId;
use bvhscope::app::inspection::{AskedAs, RayOrigin, RaysAsked};
use bvhscope::app::panels::PanelKind;
use bvhscope::app::selection::Selection;
use bvhscope::app::view::SiblingKey;
use bvhscope::inspect::census::Weight;
use bvhscope::inspect::ray_tree::RaySource;
use bvhscope::world::NodeFigure;
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use super::fixture::Program;
use super::window::{SIZE, Window, settle, window};
use super::{HEIGHT, WIDTHS, clipped_texts, keep, picture};

fn tree_panel() -> Harness<'static, Program> {
    let mut harness = Program::full(PanelKind::Tree, true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    harness
}

fn type_into(harness: &mut Harness<'_, Program>, label: &str, text: &str) {
    let field = harness.get_by_role_and_label(Role::TextInput, label);
    field.focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, label).type_text(text);
    harness.run();
    harness.key_press(Key::Enter);
    harness.run();
}

fn selected(harness: &Harness<'_, Program>) -> Vec<u32> {
    let selection = harness.state().selections.current();
    selection.map_or(Vec::new(), |s| s.nodes.iter().map(|n| n.0).collect())
}

#[test]
fn a_node_is_found_by_its_number_and_all_of_it_is_shown() {
    let mut harness = tree_panel();
    type_into(&mut harness, "Find", "leaf 77");
    let world = harness.state().world.clone().expect("a world");
    assert_eq!(selected(&harness), [world.tree.inner_count() as u32 + 77]);
    harness.get_by_label("Leaf 77");
    let lines = harness.get_all_by_role(Role::TreeItem).filter_map(|n| n.accesskit_node().label());
    assert!(lines.into_iter().any(|label| label.starts_with("leaf 77, depth ")), "the outline opens there");
    harness.get_by_label("Up").click();
    harness.run();
    harness.get_by_label("Up").click();
    harness.run();
    assert!(world.tree.leaf_index(NodeId(selected(&harness)[0])).is_none(), "two above is an inner node");
    let overlap = harness.get_by_label_contains("Overlap: ").value().unwrap_or_default();
    assert!(overlap.chars().any(|c| c.is_ascii_digit()), "{overlap}");
    assert_eq!(clipped_texts(&harness), Vec::<String>::new());
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Tree-selected");
    }
    harness.get_by_label("Deselect").click();
    harness.run();
    assert!(selected(&harness).is_empty());
    harness.get_by_label("Back").click();
    harness.run();
    assert_eq!(selected(&harness).len(), 1);
}

#[test]
fn a_number_that_is_not_there_is_said_in_words() {
    let mut harness = tree_panel();
    type_into(&mut harness, "Find", "node 999999");
    harness.get_by_label_contains("There is no node 999999: the last one is");
    assert!(selected(&harness).is_empty());
}

#[test]
fn the_outline_opens_selects_and_sorts() {
    let mut harness = tree_panel();
    let lines = |harness: &Harness<'_, Program>| harness.get_all_by_role(Role::TreeItem).count();
    let before = lines(&harness);
    assert_eq!(before, 3, "the root and its two children");
    let node = harness.get_by_role_and_label(Role::TreeItem, "node 1, depth 1").rect();
    harness.drag_at(pos2(node.left() + 21.0, node.center().y));
    harness.drop_at(pos2(node.left() + 21.0, node.center().y));
    harness.run();
    assert_eq!(lines(&harness), before + 2, "a click on the triangle opens");
    harness.get_by_role_and_label(Role::TreeItem, "node 1, depth 1").click();
    harness.run();
    assert_eq!(selected(&harness), [1]);
    harness.state_mut().tree_view.order = SiblingKey::Weight(Weight::SahCost);
    harness.run();
    assert_eq!(lines(&harness), before + 2, "what was open stays open");
}

#[test]
fn the_plot_selects_zooms_and_shows_every_figure() {
    let mut harness = tree_panel();
    let plot = harness.get_by_role_and_label(Role::Canvas, "Icicle plot of the tree").rect();
    let at = pos2(plot.left() + 0.3 * plot.width(), plot.top() + 0.5 * plot.height());
    harness.hover_at(at);
    harness.run();
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run();
    assert_eq!(selected(&harness).len(), 1);
    for figure in NodeFigure::ALL {
        for weight in Weight::ALL {
            let state = harness.state_mut();
            (state.tree_view.figure, state.tree_view.weight) = (figure, weight);
            harness.run();
            assert_eq!(clipped_texts(&harness), Vec::<String>::new(), "{figure:?} {weight:?}");
        }
        if let Some(picture) = picture(&mut harness) {
            keep(&picture, &format!("Tree-{}", figure.name()));
        }
    }
}

#[test]
fn a_pair_that_overlaps_is_selected_by_a_click() {
    let mut harness = tree_panel();
    let first = harness.get_by_label_contains("1. ");
    first.click();
    harness.run();
    let nodes = selected(&harness);
    assert_eq!(nodes.len(), 2);
    let tree = &harness.state().world.as_ref().expect("a world").tree;
    let family = bvhscope::accel::Family::of(tree, &bvhscope::task::Task::new()).expect("nobody cancels");
    assert_eq!(family.parent(NodeId(nodes[0])), family.parent(NodeId(nodes[1])));
}

#[test]
fn the_rays_of_a_pixel_are_walked_through() {
    let mut harness = Program::full(PanelKind::Rays, true).harness([WIDTHS[0], HEIGHT]);
    harness.run_steps(12);
    let count = harness.get_all_by_role(Role::TreeItem).count();
    assert!(count > 1, "the pixel sees something that bounces or is lit");
    let steps = |h: &Harness<'_, Program>| h.state().inspection.step();
    let (step, all) = steps(&harness);
    assert!(step == all && all > 5, "at first the whole history is shown");
    harness.get_by_label("First").click();
    harness.run_steps(12);
    assert_eq!(steps(&harness).0, 0);
    for _ in 0..3 {
        harness.get_by_label("Step").click();
        harness.run_steps(12);
    }
    harness.get_by_label("Step back").click();
    harness.run_steps(12);
    assert_eq!(steps(&harness).0, 2);
    harness.get_by_label("Next").click();
    harness.run_steps(12);
    assert_ne!(harness.state().inspection.view.chosen, 0);
    assert_eq!(clipped_texts(&harness), Vec::<String>::new());
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Rays-next");
    }
    harness.get_by_label("Asked occluded").click();
    harness.run_steps(12);
    assert_eq!(harness.state().inspection.view.asked_as, AskedAs::Occluded);
}

#[test]
fn a_wide_panel_shows_the_three_ways_side_by_side() {
    let mut harness = Program::full(PanelKind::Rays, false).harness([WIDTHS[1], HEIGHT]);
    harness.run();
    harness.get_by_label("First").click();
    harness.run_steps(12);
    let begins = harness.get_all_by_label("Step 1: walk from the root").count();
    assert_eq!(begins, 3);
    assert_eq!(clipped_texts(&harness), Vec::<String>::new());
}

#[test]
fn a_free_ray_is_typed_in_and_a_bad_one_refused() {
    let mut harness = Program::full(PanelKind::Rays, true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    type_into(&mut harness, "Free ray", "0,1,5,0,0,0");
    harness.get_by_label_contains("leads nowhere");
    let field = harness.get_by_role_and_label(Role::TextInput, "Free ray");
    field.focus();
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    type_into(&mut harness, "Free ray", "0,1,5,0,0,-1");
    let origin = harness.state().inspection.view.origin;
    assert!(matches!(origin, Some(RayOrigin::Free(ray)) if ray.origin.z == 5.0), "{origin:?}");
}

fn current(window: &Window) -> Option<&Selection> {
    window.state().state().selections.current()
}

#[test]
fn a_click_in_the_viewport_leads_to_shape_leaf_path_and_rays() {
    let mut window = window("bunny", SIZE);
    window.state_mut().layout_mut().show(PanelKind::Rays, true);
    settle(&mut window);
    let viewport = window.get_by_role_and_label(Role::Image, "Viewport").rect();
    window.drag_at(viewport.center());
    window.drop_at(viewport.center());
    settle(&mut window);
    let selection = current(&window).expect("the bunny stands in the middle").clone();
    let world = window.state().state().document.as_ref().map(|d| d.world.clone()).expect("open");
    let leaf_idx = world.tree.leaf_index(selection.node()).expect("a leaf");
    assert!(world.tree.leaf_shapes(leaf_idx).contains(&selection.shape.expect("a shape")));
    let inspection = &window.state().state().inspection;
    assert!(inspection.found.as_ref().is_some_and(|f| !f.rays.is_empty()));
    let recorded = inspection.recorded.as_ref().expect("the first ray's steps");
    assert_eq!(recorded.history.answer, selection.shape);
    super::window::keep(&mut window, "Window-rays-picked");
    window.key_press(Key::OpenBracket);
    settle(&mut window);
    assert!(current(&window).is_some_and(|s| world.tree.leaf_index(s.node()).is_none()), "up to the parent");
    window.key_press(Key::CloseBracket);
    settle(&mut window);
    assert_eq!(current(&window).map(Selection::node), Some(selection.node()));
    window.state_mut().layout_mut().show(PanelKind::Tree, true);
    settle(&mut window);
    super::window::keep(&mut window, "Window-tree-picked");
    window.get_by_label("Builder sweep").click();
    settle(&mut window);
    let after = current(&window).expect("the selection follows its shape");
    assert_eq!(after.shape, selection.shape);
    window.key_press(Key::Escape);
    settle(&mut window);
    assert!(current(&window).is_none());
}

#[test]
fn the_rays_follow_the_view_unless_another_source_is_set() {
    let mut window = window("cornell", SIZE);
    window.state_mut().layout_mut().show(PanelKind::Rays, true);
    settle(&mut window);
    let viewport = window.get_by_role_and_label(Role::Image, "Viewport").rect();
    // On the wall at the back, above the boxes, which the lamp lights.
    let at = pos2(viewport.center().x, viewport.top() + 0.3 * viewport.height());
    window.drag_at(at);
    window.drop_at(at);
    settle(&mut window);
    let source = |window: &Window| match window.state().state().inspection.found.as_ref()?.key.asked {
        RaysAsked::Pixel(question) => Some(question.source),
        RaysAsked::Free(_) => None,
    };
    assert_eq!(source(&window), Some(RaySource::Path));
    window.get_by_label("Rays of whitted").click();
    settle(&mut window);
    assert_eq!(source(&window), Some(RaySource::Whitted));
    let rays = window.state().state().inspection.found.as_ref().map_or(0, |f| f.rays.len());
    assert!(rays > 1, "a camera ray and a shadow ray at least");
}

#[test]
fn the_splits_of_a_selected_node_are_weighed() {
    let mut harness = Program::full(PanelKind::Splits, true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    harness.get_by_label_contains("Select a node");
    let pick = bvhscope::app::selection::Pick::Node(NodeId(0));
    harness.state_mut().apply(bvhscope::app::commands::Command::Select { pick, add: false });
    harness.run();
    let figure = |harness: &Harness<'_, Program>, label: &str| -> f64 {
        let text = harness.get_by_label_contains(&format!("{label}: ")).value().unwrap_or_default();
        let number = text.split(": ").nth(1).and_then(|t| t.split(' ').next()).unwrap_or_default();
        number.replace(',', "").parse().unwrap_or(f64::NAN)
    };
    let [best, made, build] =
        ["Best of all", "As it was split", "Best of the build's bins"].map(|label| figure(&harness, label));
    assert!(best <= made && (made - build).abs() < 2e-3, "{best} {made} {build}");
    assert!(figure(&harness, "As a leaf") > made);
    assert_eq!(clipped_texts(&harness), Vec::<String>::new());
    let before = figure(&harness, "Best of the bins beside");
    harness.get_by_role_and_label(Role::Slider, "Bins beside").set_value_accesskit(2.0);
    harness.run();
    harness.state_mut().weigh_splits();
    harness.run();
    assert!(figure(&harness, "Best of the bins beside") >= before, "two bins see one plane an axis");
}

#[test]
fn a_construction_is_played_step_by_step() {
    let mut harness = Program::full(PanelKind::Construction, true).harness([WIDTHS[0], HEIGHT]);
    harness.run();
    harness.get_by_label_contains("The tree is finished");
    harness.get_by_label("Start").click();
    harness.run();
    for _ in 0..3 {
        harness.get_by_label("Forward").click();
        harness.run();
    }
    assert_eq!(harness.state().player.view.step, 3);
    harness.get_by_label("node 2");
    let pick = bvhscope::app::selection::Pick::Node(NodeId(40));
    harness.state_mut().apply(bvhscope::app::commands::Command::Select { pick, add: false });
    harness.run();
    harness.get_by_label("To the selected node").click();
    harness.run();
    assert_eq!(harness.state().player.view.step, 41);
    if let Some(picture) = picture(&mut harness) {
        keep(&picture, "Construction-step");
    }
}

#[test]
fn hidden_shapes_are_seen_through() {
    let mut window = window("bunny", SIZE);
    let viewport = window.get_by_role_and_label(Role::Image, "Viewport").rect();
    let click = |window: &mut Window| {
        window.drag_at(viewport.center());
        window.drop_at(viewport.center());
        settle(window);
        current(window).and_then(|selection| selection.shape)
    };
    let first = click(&mut window).expect("the bunny stands in the middle");
    window.key_press(Key::H);
    settle(&mut window);
    let state = window.state().state();
    assert!(state.hidden.contains(first) && state.visible_world().is_some());
    let key = state.picture(0).expect("a picture").frame.key;
    assert_eq!(key.hidden, state.hidden.version, "the picture is without it");
    super::window::keep(&mut window, "Window-hidden");
    let second = click(&mut window).expect("there is something behind it");
    assert_ne!(first, second);
    window.key_press(Key::O);
    settle(&mut window);
    let state = window.state().state();
    assert!(!state.hidden.contains(second) && state.hidden.contains(first));
    window.key_press(Key::J);
    settle(&mut window);
    assert!(window.state().state().hidden.is_empty());
    assert_eq!(click(&mut window), Some(first));
}

#[test]
fn a_part_of_a_heatmap_is_marked_and_its_worst_pixel_selected() {
    let mut window = window("bunny", SIZE);
    window.key_press(Key::Num7);
    window.state_mut().layout_mut().show(PanelKind::Heatmap, true);
    settle(&mut window);
    let camera = window.state().state().camera();
    let viewport = window.get_by_role_and_label(Role::Image, "Viewport").rect();
    let [from, to] = [0.3, 0.6].map(|t| viewport.min + t * viewport.size());
    let modifiers = Modifiers::SHIFT;
    let button =
        |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers };
    window.event(Event::ModifiersChanged(modifiers));
    window.event(Event::PointerMoved(from));
    window.event(button(from, true));
    window.step();
    window.event(Event::PointerMoved(to));
    window.step();
    window.event(button(to, false));
    window.step();
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    settle(&mut window);
    let state = window.state().state();
    let region = state.region.expect("a part is marked");
    assert_eq!(state.camera(), camera, "the camera stays");
    let figures = state.region_figures.as_ref().expect("its numbers");
    assert!(figures.histogram.is_some() && !figures.largest.is_empty());
    let worst = figures.largest[0].pixel;
    assert!((region.from[0]..region.to[0]).contains(&worst[0]));
    super::window::keep(&mut window, "Window-region");
    window.state_mut().push(bvhscope::app::commands::Command::GoToPixel(worst));
    settle(&mut window);
    assert!(current(&window).is_some());
}
