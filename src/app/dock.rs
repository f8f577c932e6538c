//! Draws the tiles: the viewport, and the panels behind their tabs.

use egui::{Color32, Response, Stroke, Style, Ui, Visuals, WidgetText};
use egui_tiles::{Behavior, ResizeState, SimplificationOptions, TabState, TileId, Tiles, UiResponse};

use super::commands::Commands;
use super::layout::{Layout, Pane, simplification};
use super::panels::{PanelKind, Panels};
use super::state::State;
use super::view::AppView;
use super::viewport::{Viewport, ViewportOutput};

/// What the tiles draw with.
pub struct Dock<'a> {
    pub state: &'a State,
    pub viewport: &'a mut Viewport,
    pub panels: &'a mut Panels,
    pub commands: &'a mut Commands,
}

/// Draws all tiles; what the viewport found out, if it was drawn.
pub fn ui(ui: &mut Ui, layout: &mut Layout, dock: Dock) -> Option<ViewportOutput> {
    layout.fit_width(ui.available_width());
    let view = dock.state.view();
    let mut behavior = TileBehavior {
        viewport_tile: layout.tree.tiles.find_pane(&Pane::Viewport),
        in_front: layout.tree.active_tiles(),
        view: &view,
        dock,
        output: None,
        closed: None,
    };
    layout.tree.ui(&mut behavior, ui);
    let TileBehavior { output, closed, .. } = behavior;
    if let Some(kind) = closed {
        layout.show(kind, false);
    }
    output
}

struct TileBehavior<'a> {
    viewport_tile: Option<TileId>,
    in_front: Vec<TileId>,
    view: &'a AppView<'a>,
    dock: Dock<'a>,
    output: Option<ViewportOutput>,
    closed: Option<PanelKind>,
}

impl Behavior<Pane> for TileBehavior<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        let Dock { state, viewport, panels, commands } = &mut self.dock;
        match pane {
            Pane::Viewport => self.output = Some(viewport.ui(ui, state, commands)),
            Pane::Panel(kind) => {
                ui.painter().rect_filled(ui.max_rect(), 0.0, ui.visuals().panel_fill);
                panels.ui(*kind, ui, self.view, commands);
            }
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<Pane>, id: TileId, button: Response) -> Response {
        match tiles.get_pane(&id) {
            Some(pane) => button.on_hover_text(format!("{}: {}", pane.title(), pane.about())),
            None => button,
        }
    }

    /// The panel in front of its tabs; the View menu brings it back.
    fn is_tab_closable(&self, tiles: &Tiles<Pane>, id: TileId) -> bool {
        self.in_front.contains(&id) && matches!(tiles.get_pane(&id), Some(Pane::Panel(_)))
    }

    /// Hides it; its place is kept.
    fn on_tab_close(&mut self, tiles: &mut Tiles<Pane>, id: TileId) -> bool {
        if let Some(Pane::Panel(kind)) = tiles.get_pane(&id) {
            self.closed = Some(*kind);
        }
        false
    }

    /// A viewport alone needs no title.
    fn is_tab_bar_visible(&self, _: TileId, tabs: &egui_tiles::Tabs) -> bool {
        tabs.children.len() > 1 || tabs.children.first().copied() != self.viewport_tile
    }

    fn simplification_options(&self) -> SimplificationOptions {
        simplification()
    }

    fn tab_bar_height(&self, _: &Style) -> f32 {
        26.0
    }

    fn tab_title_spacing(&self, _: &Visuals) -> f32 {
        10.0
    }

    fn gap_width(&self, _: &Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn resize_stroke(&self, style: &Style, state: ResizeState) -> Stroke {
        let color = match state {
            ResizeState::Idle => self.tab_bar_color(&style.visuals),
            ResizeState::Hovering | ResizeState::Dragging => style.visuals.hyperlink_color,
        };
        Stroke::new(3.0, color)
    }

    fn tab_bar_color(&self, visuals: &Visuals) -> Color32 {
        if visuals.dark_mode { visuals.extreme_bg_color } else { visuals.widgets.inactive.bg_fill }
    }

    fn tab_outline_stroke(&self, _: &Visuals, _: &Tiles<Pane>, _: TileId, _: &TabState) -> Stroke {
        Stroke::NONE
    }
}
