//! The icicle plot: drawn as one mesh, only what can be seen.

use egui::accesskit::Role;
use egui::{Color32, FontId, Mesh, Rect, Response, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use super::{color_values, node_name, select, weight_of};
use crate::accel::NodeId;
use crate::app::commands::Commands;
use crate::app::panels::glossary::Term;
use crate::app::panels::{numbers, widgets};
use crate::app::view::AppView;
use crate::inspect::icicle::{IcicleCell, IcicleWindow, cells, place};
use crate::world::NodeFigure;

const HEIGHT: f32 = 168.0;
/// Heights of a row: what all depths share of the plot, within these.
const ROW: std::ops::RangeInclusive<f32> = 9.0..=22.0;
/// Narrower nodes are drawn together with their neighbours, in points.
const LEAST_WIDTH: f64 = 1.5;
/// A node is named in its cell if it is this wide, in points.
const NAMED_WIDTH: f32 = 44.0;
/// The closest look: this share of the root's width over the whole plot.
const CLOSEST: f64 = 1e-9;

/// The part of the tree that is looked at.
pub struct IcicleView {
    from: f64,
    to: f64,
    /// Scrolled down by, in rows.
    top: f32,
    /// The selection that was last brought into view.
    shown: u64,
}

impl Default for IcicleView {
    fn default() -> Self {
        Self { from: 0.0, to: 1.0, top: 0.0, shown: 0 }
    }
}

impl IcicleView {
    pub fn ui(&mut self, ui: &mut Ui, view: &AppView, commands: &mut Commands) {
        let Some(world) = view.world else { return };
        let (rect, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Icicle plot of the tree"));
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let Some(weight) = weight_of(view, view.tree_view.weight) else {
            let text = "Counting…";
            let (font, color) = (FontId::proportional(12.0), view.palette.muted);
            painter.text(rect.center(), egui::Align2::CENTER_CENTER, text, font, color);
            return;
        };
        let tree = world.shown_tree();
        self.reveal(view, &weight);
        let deepest = tree.depth_max().unwrap_or(0);
        let frame = self.frame(rect, deepest);
        self.navigate(ui, &response, &frame, deepest);
        let frame = self.frame(rect, deepest);
        let least = LEAST_WIDTH * (self.to - self.from) / f64::from(rect.width());
        let last = self.top as u32 + (rect.height() / frame.row).ceil() as u32;
        let window = IcicleWindow {
            from: self.from,
            to: self.to,
            least,
            depths: [self.top as u32, last.min(deepest)],
        };
        let cells = cells(tree, &weight, &window);
        paint(&painter, view, &frame, &cells);
        self.pointed_at(&response, view, &frame, &cells, commands);
        legend(ui, view);
    }

    fn frame(&self, rect: Rect, deepest: u32) -> Frame {
        let row = (rect.height() / (deepest + 1) as f32).clamp(*ROW.start(), *ROW.end());
        Frame { rect, row, from: self.from, to: self.to, top: self.top }
    }

    /// Brings what was newly selected into view.
    fn reveal(&mut self, view: &AppView, weight: &dyn Fn(NodeId) -> f64) {
        let (Some(world), Some(census)) = (view.world, view.census) else { return };
        let Some(selection) = view.selections.current().filter(|_| self.shown != view.selections.version)
        else {
            return;
        };
        self.shown = view.selections.version;
        let node = selection.node();
        let Some([from, to]) = place(world.shown_tree(), &census.family, &weight, node) else { return };
        let outside = to <= self.from || from >= self.to || to - from < 2e-3 * (self.to - self.from);
        if outside {
            // So wide that it can be seen among its neighbours.
            let width = ((to - from) * 12.0).clamp(CLOSEST, 1.0);
            self.look_at(0.5 * (from + to) - 0.5 * width, width);
        }
        let depth = census.family.depth(node) as f32;
        let rows = HEIGHT / ROW.start();
        if depth < self.top || depth + 1.0 > self.top + rows {
            self.top = (depth - 0.5 * rows).max(0.0);
        }
    }

    fn look_at(&mut self, from: f64, width: f64) {
        let width = width.clamp(CLOSEST, 1.0);
        self.from = from.clamp(0.0, 1.0 - width);
        self.to = self.from + width;
    }

    /// The wheel zooms, a drag moves.
    fn navigate(&mut self, ui: &Ui, response: &Response, frame: &Frame, deepest: u32) {
        let width = self.to - self.from;
        let drag = response.drag_delta();
        if drag != egui::Vec2::ZERO {
            self.look_at(self.from - f64::from(drag.x / frame.rect.width()) * width, width);
            let rows = frame.rect.height() / frame.row;
            let most = ((deepest + 1) as f32 - rows).max(0.0);
            self.top = (self.top - drag.y / frame.row).clamp(0.0, most);
        }
        let Some(at) = response.hover_pos() else { return };
        let (scroll, zoom) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = f64::from((-scroll * 0.01).exp() / zoom);
        if factor != 1.0 && factor.is_finite() {
            let under = frame.share_at(at.x);
            let closer = (width * factor).clamp(CLOSEST, 1.0);
            self.look_at(under - (under - self.from) * closer / width, closer);
            // The panel is not to scroll at the same time.
            ui.input_mut(|i| i.smooth_scroll_delta = egui::Vec2::ZERO);
        }
    }

    /// What lies under the mouse.
    fn pointed_at(
        &mut self,
        response: &Response,
        view: &AppView,
        frame: &Frame,
        cells: &[IcicleCell],
        commands: &mut Commands,
    ) {
        let Some(at) = response.hover_pos() else { return };
        let (share, depth) = (frame.share_at(at.x), frame.depth_at(at.y));
        let hit = cells.iter().find(|c| c.depth == depth && c.from <= share && share < c.to);
        let Some(cell) = hit else {
            if response.double_clicked() {
                self.look_at(0.0, 1.0);
                self.top = 0.0;
            }
            return;
        };
        if response.double_clicked() {
            self.look_at(cell.from, cell.to - cell.from);
        } else if response.clicked() {
            let add = response.ctx.input(|i| i.modifiers.command);
            // It is seen already: no other look at the tree.
            self.shown = view.selections.version + 1;
            select(commands, cell.node, add);
        }
        response.clone().on_hover_ui_at_pointer(|ui| tooltip(ui, view, cell));
    }
}

/// Where shares and depths lie on the screen.
struct Frame {
    rect: Rect,
    row: f32,
    from: f64,
    to: f64,
    top: f32,
}

impl Frame {
    fn cell(&self, cell: &IcicleCell) -> Rect {
        let scale = f64::from(self.rect.width()) / (self.to - self.from);
        let x = |share: f64| self.rect.left() + ((share - self.from) * scale) as f32;
        let y = self.rect.top() + (cell.depth as f32 - self.top) * self.row;
        let (left, right) = (self.rect.left() - 1.0, self.rect.right() + 1.0);
        let (from, to) = (x(cell.from).clamp(left, right), x(cell.to).clamp(left, right));
        Rect::from_min_max(pos2(from, y), pos2(to, y + self.row))
    }

    fn share_at(&self, x: f32) -> f64 {
        self.from + (self.to - self.from) * f64::from((x - self.rect.left()) / self.rect.width())
    }

    fn depth_at(&self, y: f32) -> u32 {
        ((y - self.rect.top()) / self.row + self.top).max(0.0) as u32
    }
}

fn paint(painter: &egui::Painter, view: &AppView, frame: &Frame, cells: &[IcicleCell]) {
    let mut mesh = Mesh::default();
    let values = color_values(view);
    for cell in cells {
        let rect = frame.cell(cell);
        // A hair between neighbours, where there is room.
        let gap = if rect.width() > 3.0 { 0.5 } else { 0.0 };
        let body = Rect::from_min_max(rect.min, rect.max - vec2(gap, 1.0));
        mesh.add_colored_rect(body, color(view, values, cell));
    }
    painter.add(mesh);
    let Some(world) = view.world else { return };
    let font = FontId::proportional(9.5);
    for cell in cells.iter().filter(|cell| cell.count == 1) {
        let rect = frame.cell(cell);
        if rect.width() >= NAMED_WIDTH && frame.row >= 11.0 {
            let text = node_name(world, cell.node);
            let clipped = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
            let ink = Color32::from_gray(18);
            let at = pos2(rect.left().max(frame.rect.left()) + 3.0, rect.center().y - 0.5);
            clipped.text(at, egui::Align2::LEFT_CENTER, text, font.clone(), ink);
        }
    }
    let Some(selection) = view.selections.current() else { return };
    let above = view.census.map(|census| census.family.path(selection.node())).unwrap_or_default();
    for cell in cells.iter().filter(|cell| cell.count == 1) {
        let selected = selection.nodes.contains(&cell.node);
        if selected || above.contains(&cell.node) {
            let width = if selected { 2.0 } else { 1.0 };
            let stroke = Stroke::new(width, if view.palette.dark { Color32::WHITE } else { Color32::BLACK });
            let rect = frame.cell(cell).shrink2(vec2(0.5, 0.5));
            painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Inside);
        }
    }
}

fn color(view: &AppView, values: Option<&crate::inspect::census::Values>, cell: &IcicleCell) -> Color32 {
    let figure = view.tree_view.figure;
    let known = values.and_then(|v| Some((*v.of_nodes.get(cell.node.0 as usize)?, v.range?)));
    let (value, range) = known.unwrap_or((f32::NAN, [0.0, 1.0]));
    let [r, g, b] = figure.color(value, range);
    let color = Color32::from_rgb(r, g, b);
    if cell.count > 1 { color.gamma_multiply(0.7) } else { color }
}

fn tooltip(ui: &mut Ui, view: &AppView, cell: &IcicleCell) {
    let (Some(world), Some(census)) = (view.world, view.census) else { return };
    ui.set_max_width(260.0);
    if cell.count > 1 {
        ui.strong(format!("{} nodes too narrow to be told apart", numbers::count(cell.count)));
        ui.label("Zoom with the wheel.");
        return;
    }
    ui.strong(node_name(world, cell.node));
    ui.label(format!(
        "depth {}, {} shapes below",
        cell.depth,
        numbers::count(census.family.references(cell.node))
    ));
    let share = numbers::decimal(100.0 * (cell.to - cell.from), 2);
    ui.label(format!("{share} % of all {}", view.tree_view.weight.name()));
    if let Some(value) = color_values(view).and_then(|v| v.of_nodes.get(cell.node.0 as usize)) {
        ui.label(figure_words(view.tree_view.figure, *value));
    }
}

/// A figure of a node with its value.
pub fn figure_words(figure: NodeFigure, value: f32) -> String {
    let label = figure.label();
    match figure {
        NodeFigure::Unique => format!("{label}: no meaning"),
        _ if value.is_nan() => format!("{label}: {}", numbers::DASH),
        NodeFigure::SahShare | NodeFigure::EmptySpace | NodeFigure::Fill => {
            format!("{label}: {} %", numbers::decimal(100.0 * f64::from(value), 2))
        }
        NodeFigure::Depth | NodeFigure::LeafSize | NodeFigure::Visits => {
            format!("{label}: {}", numbers::count(value as u64))
        }
        NodeFigure::Epo | NodeFigure::Overlap => {
            format!("{label}: {}", numbers::short(f64::from(value)))
        }
    }
}

/// What the colours mean.
fn legend(ui: &mut Ui, view: &AppView) {
    let figure = view.tree_view.figure;
    if figure == NodeFigure::Unique {
        return;
    }
    let Some(range) = color_values(view).and_then(|values| values.range) else { return };
    let bar = widgets::color_bar(ui, &|t| {
        let [r, g, b] = figure.color(figure.value_at(t, range), range);
        Color32::from_rgb(r, g, b)
    });
    bar.on_hover_text(Term::IcicleColor.text());
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 12.0), Sense::hover());
    let (font, muted) = (widgets::small_font(ui), view.palette.muted);
    let side = |side, text: String| {
        widgets::paint_text(ui, rect, side, &text, font.clone(), muted);
    };
    let text =
        |value: f32| figure_words(figure, value).split_once(": ").map_or(String::new(), |t| t.1.to_owned());
    side(widgets::Side::Left, text(range[0]));
    side(widgets::Side::Right, text(range[1]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_depths_are_found_where_they_are_drawn() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 100.0));
        let frame = Frame { rect, row: 10.0, from: 0.25, to: 0.75, top: 2.0 };
        let cell = IcicleCell { node: NodeId(4), count: 1, depth: 5, from: 0.3, to: 0.4 };
        let at = frame.cell(&cell).center();
        assert!((frame.share_at(at.x) - 0.35).abs() < 1e-6);
        assert_eq!(frame.depth_at(at.y), 5);
    }

    #[test]
    fn a_look_stays_inside_the_tree() {
        let mut view = IcicleView::default();
        for (from, width) in [(-3.0, 0.5), (0.9, 0.5), (0.2, 7.0), (0.999_999_999, 1e-20)] {
            view.look_at(from, width);
            assert!(view.from >= 0.0 && view.to <= 1.0 + 1e-12 && view.to > view.from, "{from} {width}");
        }
    }

    #[test]
    fn figures_are_said_in_their_units() {
        assert_eq!(figure_words(NodeFigure::Fill, 0.5), "fill: 50.00 %");
        assert_eq!(figure_words(NodeFigure::LeafSize, 3.0), "leaf size: 3");
        assert_eq!(figure_words(NodeFigure::Overlap, f32::NAN), format!("overlap: {}", numbers::DASH));
    }
}
