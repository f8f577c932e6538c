//! The outline: lines of nodes that open and close, only those on the screen drawn.

use egui::accesskit::Role;
use egui::{Color32, Rect, Response, ScrollArea, Sense, Shape, Ui, WidgetInfo, pos2, vec2};

use super::{color_values, node_name, select, sibling_value, weight_of};
use crate::app::commands::{Command, Commands};
use crate::app::panels::glossary::Term;
use crate::app::panels::numbers;
use crate::app::panels::widgets::{self, Side};
use crate::app::view::{AppView, SiblingKey, TreeView};
use crate::inspect::outline::{Outline, OutlineLine};

const LINE_HEIGHT: f32 = 18.0;
/// Lines that are seen at once.
const LINES: f32 = 12.0;
const INDENT: f32 = 11.0;
/// Deeper nodes stand no further to the right, so that names keep their place.
const MOST_INDENTED: u32 = 10;
const SHARE_WIDTH: f32 = 58.0;

/// The lines, and of which tree they are.
#[derive(Default)]
pub struct OutlineView {
    outline: Outline,
    /// Where the tree lies in memory: another tree, another outline.
    of: Option<usize>,
    /// The selection that was last brought into view, and the order that siblings were last put in.
    shown: u64,
    sorted: Option<(SiblingKey, bool)>,
    scroll_to: Option<usize>,
}

impl OutlineView {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        widgets::term_section(ui, Term::Outline);
        let tree_view = *view.tree_view;
        let describe = |key: SiblingKey| (key.name(), key.description());
        let order =
            widgets::combo(ui, Term::SiblingOrder, Some(tree_view.order), &SiblingKey::ALL, &describe, "");
        if let Some(order) = order {
            commands.push(Command::SetTreeView(TreeView { order, ..tree_view }));
        }
        self.follow(view);
        let count = self.outline.lines().len();
        let height = LINE_HEIGHT * LINES;
        let mut list =
            ScrollArea::vertical().id_salt("outline").max_height(height).auto_shrink([false, true]);
        if let Some(line) = self.scroll_to.take() {
            list = list.vertical_scroll_offset((line as f32 - 0.4 * LINES).max(0.0) * LINE_HEIGHT);
        }
        let mut toggled = None;
        ui.scope(|ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            list.show_rows(ui, LINE_HEIGHT, count, |ui, rows| {
                for index in rows {
                    let line = self.outline.lines()[index];
                    match self.line(ui, view, line) {
                        Some(Asked::Toggle) => toggled = Some(index),
                        Some(Asked::Select { add }) => {
                            // It is seen already.
                            self.shown = view.selections.version + 1;
                            select(commands, line.node, add);
                        }
                        None => {}
                    }
                }
            });
        });
        if let (Some(index), Some(world)) = (toggled, view.world) {
            self.outline.toggle(world.shown_tree(), index, sibling_value(view).as_deref());
        }
    }

    /// Follows the tree, the order and the selection.
    fn follow(&mut self, view: &AppView) {
        let Some(world) = view.world else { return };
        let tree = world.shown_tree();
        let value = sibling_value(view);
        let address = std::ptr::from_ref(tree).addr();
        let sorted = (view.tree_view.order, value.is_some());
        if self.of != Some(address) {
            self.of = Some(address);
            self.outline = Outline::new(tree);
            self.outline.toggle(tree, 0, value.as_deref());
            self.shown = 0;
        } else if self.sorted != Some(sorted) {
            self.outline.sort(tree, value.as_deref());
        }
        self.sorted = Some(sorted);
        let selected = view.selections.current().filter(|_| self.shown != view.selections.version);
        if let (Some(selection), Some(census)) = (selected, view.census) {
            self.shown = view.selections.version;
            let path = census.family.path(selection.node());
            self.scroll_to = self.outline.reveal(tree, &path, value.as_deref());
        }
    }

    fn line(&self, ui: &mut Ui, view: &AppView, line: OutlineLine) -> Option<Asked> {
        let world = view.world?;
        let size = vec2(ui.available_width(), LINE_HEIGHT);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let selected = view.selections.current().is_some_and(|s| s.nodes.contains(&line.node));
        widgets::paint_line(ui, rect, &response, selected);
        let open = self.outline.is_open(line.node);
        let left = rect.left() + 4.0 + INDENT * line.depth.min(MOST_INDENTED) as f32;
        let handle = Rect::from_min_size(pos2(left, rect.top()), vec2(14.0, LINE_HEIGHT));
        if !line.is_leaf {
            paint_handle(ui, handle, open);
        }
        let mut right = rect.right() - 4.0;
        if let Some(share) = share(view, line) {
            let cell = Rect::from_x_y_ranges(right - SHARE_WIDTH..=right, rect.y_range());
            let text = format!("{} %", numbers::decimal(100.0 * share, 2));
            widgets::paint_text(ui, cell, Side::Right, &text, widgets::number_font(ui), view.palette.muted);
            right -= SHARE_WIDTH + 4.0;
        }
        if let Some(color) = swatch(view, line) {
            let at = pos2(right - 4.0, rect.center().y);
            ui.painter().rect_filled(Rect::from_center_size(at, vec2(8.0, 8.0)), 1.5, color);
            right -= 14.0;
        }
        let name = node_name(world, line.node);
        let shapes = view.census.map(|census| census.family.references(line.node));
        let text = match shapes {
            Some(shapes) => format!("{name} · {}", numbers::count(shapes)),
            None => name.clone(),
        };
        let cell = Rect::from_x_y_ranges(handle.right() + 2.0..=right, rect.y_range());
        let color = if selected { view.palette.accent } else { ui.visuals().text_color() };
        widgets::paint_text(ui, cell, Side::Left, &text, widgets::body_font(ui), color);
        response.widget_info(|| {
            WidgetInfo::selected(Role::TreeItem, true, selected, format!("{name}, depth {}", line.depth))
        });
        let asked = asked(&response, handle, line);
        response.on_hover_text(format!(
            "{name}, depth {}{}. Click selects, Ctrl adds, a double click opens and closes.",
            line.depth,
            shapes.map_or(String::new(), |n| format!(", {} shapes below", numbers::count(n)))
        ));
        asked
    }
}

enum Asked {
    Toggle,
    Select { add: bool },
}

fn asked(response: &Response, handle: Rect, line: OutlineLine) -> Option<Asked> {
    let on_handle = response.interact_pointer_pos().is_some_and(|at| handle.contains(at));
    if !line.is_leaf && ((response.clicked() && on_handle) || (response.double_clicked() && !on_handle)) {
        Some(Asked::Toggle)
    } else if response.clicked() {
        Some(Asked::Select { add: response.ctx.input(|i| i.modifiers.command) })
    } else {
        None
    }
}

/// A triangle that points right, or down where the node is open.
fn paint_handle(ui: &Ui, rect: Rect, open: bool) {
    let (c, r) = (rect.center(), 3.5);
    let points = if open {
        vec![c + vec2(-r, -0.6 * r), c + vec2(r, -0.6 * r), c + vec2(0.0, 0.8 * r)]
    } else {
        vec![c + vec2(-0.6 * r, -r), c + vec2(0.8 * r, 0.0), c + vec2(-0.6 * r, r)]
    };
    let color = ui.visuals().weak_text_color();
    ui.painter().add(Shape::convex_polygon(points, color, egui::Stroke::NONE));
}

/// Of the plot's weight.
fn share(view: &AppView, line: OutlineLine) -> Option<f64> {
    let weight = weight_of(view, view.tree_view.weight)?;
    let total = weight(crate::accel::NodeId(0));
    (total > 0.0).then(|| weight(line.node) / total)
}

/// The plot's colour.
fn swatch(view: &AppView, line: OutlineLine) -> Option<Color32> {
    let values = color_values(view)?;
    let value = *values.of_nodes.get(line.node.0 as usize)?;
    let [r, g, b] = view.tree_view.figure.color(value, values.range?);
    Some(Color32::from_rgb(r, g, b))
}
