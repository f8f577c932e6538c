//! Where the viewport and the panels lie: dockable, kept between runs, and checked before it is used again.

use egui_tiles::{Container, Linear, LinearDir, SimplificationOptions, Tile, TileId, Tiles, Tree};
use serde::{Deserialize, Serialize};

use super::panels::PanelKind;

/// Changes with the form or the meaning of what is stored: a layout of another version is not read.
pub const STORAGE_KEY: &str = "bvhscope_layout_2";

/// Widths of the columns at the sides of the first start, in points.
const LEFT_WIDTH: f32 = 322.0;
const RIGHT_WIDTH: f32 = 342.0;
/// The part of the left column that the build has.
const UPPER_SHARE: f32 = 0.45;
/// The part of the right column that the figures have.
const FIGURES_SHARE: f32 = 0.5;
/// The viewport is never made narrower than this to keep the columns as wide as they were.
const LEAST_VIEWPORT: f32 = 320.0;

/// What a tile holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Pane {
    Viewport,
    Panel(PanelKind),
}

impl Pane {
    pub fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::Viewport).chain(PanelKind::ALL.into_iter().map(Self::Panel))
    }

    pub fn title(self) -> &'static str {
        match self {
            Self::Viewport => "Viewport",
            Self::Panel(kind) => kind.title(),
        }
    }

    /// One sentence for tabs and menus.
    pub fn about(self) -> &'static str {
        match self {
            Self::Viewport => "the picture, with the boxes over it",
            Self::Panel(PanelKind::Scene) => "what is loaded, what else can be opened, and how it moves",
            Self::Panel(PanelKind::Build) => "how the tree is built, and the builds so far",
            Self::Panel(PanelKind::Boxes) => "which boxes of the tree are drawn over the picture",
            Self::Panel(PanelKind::Heatmap) => "what a ray costs at each pixel",
            Self::Panel(PanelKind::Cost) => "what the tree costs, and what more bins would do",
            Self::Panel(PanelKind::Compare) => "two states, scenes or moments against each other",
            Self::Panel(PanelKind::Shadows) => "what an early-out shadow query gets wrong, and what it saves",
            Self::Panel(PanelKind::Table) => "five trees side by side on this scene",
            Self::Panel(PanelKind::Sweep) => "many trees on this scene, plotted, and the best of them",
            Self::Panel(PanelKind::TreeFile) => "a tree from another program, and what is wrong with it",
            Self::Panel(PanelKind::Tree) => {
                "the nodes of the tree: an outline, a plot, and all of the selected one"
            }
            Self::Panel(PanelKind::Rays) => {
                "the rays of a pixel, and what each did in the tree, step by step"
            }
            Self::Panel(PanelKind::Splits) => {
                "where the selected node could be split, and what that would cost"
            }
            Self::Panel(PanelKind::Construction) => "how the tree came about, step by step",
            Self::Panel(PanelKind::Export) => "pictures and figures as files",
        }
    }
}

/// The tree of tiles, and the width it was last drawn at.
#[derive(Clone, Debug)]
pub struct Layout {
    pub tree: Tree<Pane>,
    width: Option<f32>,
}

impl Default for Layout {
    fn default() -> Self {
        Self { tree: default_tree(), width: None }
    }
}

/// What is stored.
#[derive(Serialize, Deserialize)]
struct Stored {
    tree: Tree<Pane>,
    width: Option<f32>,
}

impl Layout {
    /// The stored layout if it is whole, else the default one.
    pub fn load(storage: &dyn eframe::Storage) -> Self {
        let stored: Option<Stored> = eframe::get_value(storage, STORAGE_KEY);
        stored
            .filter(|s| is_whole(&s.tree) && s.width.is_none_or(|w| w.is_finite() && w > 0.0))
            .map_or_else(Self::default, |s| Self { tree: s.tree, width: s.width })
    }

    pub fn save(&self, storage: &mut dyn eframe::Storage) {
        let stored = Stored { tree: self.tree.clone(), width: self.width };
        eframe::set_value(storage, STORAGE_KEY, &stored);
    }

    /// Whether a panel is drawn now: neither hidden nor behind another tab.
    pub fn is_showing(&self, kind: PanelKind) -> bool {
        let Some(id) = self.tree.tiles.find_pane(&Pane::Panel(kind)) else { return false };
        self.tree.active_tiles().contains(&id)
    }

    /// Whether a panel is somewhere, if perhaps behind another tab.
    pub fn is_open(&self, kind: PanelKind) -> bool {
        let id = self.tree.tiles.find_pane(&Pane::Panel(kind));
        id.is_some_and(|id| self.tree.tiles.is_visible(id))
    }

    /// Hides a panel, or brings it to the front.
    pub fn show(&mut self, kind: PanelKind, shown: bool) {
        let Some(id) = self.tree.tiles.find_pane(&Pane::Panel(kind)) else { return };
        self.tree.tiles.set_visible(id, shown);
        if shown {
            self.tree.make_active(|tile, _| tile == id);
        }
    }

    /// Gives what a wider or narrower window has more or less to the viewport: the columns keep their widths.
    pub fn fit_width(&mut self, width: f32) {
        let before = self.width.replace(width);
        let target = self.viewport_column();
        let Some(root) = self.tree.root() else { return };
        let visible: Vec<TileId> = self.tree.active_tiles();
        let Some(Tile::Container(Container::Linear(linear))) = self.tree.tiles.get_mut(root) else { return };
        if linear.dir != LinearDir::Horizontal {
            return;
        }
        let first_time = before.is_none();
        let before = before.unwrap_or(width);
        if (before - width).abs() < 0.5 && !first_time {
            return;
        }
        keep_columns(linear, &visible, target, if first_time { None } else { Some(before) }, width);
    }

    /// The child of the root that holds the viewport.
    fn viewport_column(&self) -> Option<TileId> {
        let mut id = self.tree.tiles.find_pane(&Pane::Viewport)?;
        while let Some(parent) = self.tree.tiles.parent_of(id) {
            if self.tree.is_root(parent) {
                return Some(id);
            }
            id = parent;
        }
        None
    }
}

/// Sets the shares so that all columns but the one of the viewport stay as wide as they were. `before`: the width that
/// the shares stood for; `None` when they are points already.
fn keep_columns(
    linear: &mut Linear,
    visible: &[TileId],
    target: Option<TileId>,
    before: Option<f32>,
    width: f32,
) {
    let columns: Vec<TileId> = linear.children.iter().copied().filter(|c| visible.contains(c)).collect();
    let Some(target) = target.filter(|t| columns.contains(t)) else { return };
    let total: f32 = columns.iter().map(|c| linear.shares[*c]).sum();
    if total <= 0.0 {
        return;
    }
    let points = before.map_or(1.0, |before| before / total);
    let others: f32 = columns.iter().filter(|c| **c != target).map(|c| linear.shares[*c] * points).sum();
    let rest = width - others;
    if rest < LEAST_VIEWPORT {
        return;
    }
    for column in columns {
        let share = if column == target { rest } else { linear.shares[column] * points };
        linear.shares.set_share(column, share);
    }
}

/// How tiles are kept tidy: every panel keeps a tab with its name.
pub fn simplification() -> SimplificationOptions {
    SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
}

/// At the left the settings of tree and boxes, in the middle the picture, at the right what the tree costs, and below that
/// why: its nodes. What is needed less often lies behind tabs.
fn default_tree() -> Tree<Pane> {
    use PanelKind::{Boxes, Build, Compare, Cost, Export, Heatmap, Scene, Shadows, Sweep, Table, TreeFile};
    let mut tiles = Tiles::default();
    let tabs = |tiles: &mut Tiles<Pane>, kinds: &[PanelKind]| {
        let children = kinds.iter().map(|k| tiles.insert_pane(Pane::Panel(*k))).collect();
        tiles.insert_tab_tile(children)
    };
    let above = tabs(&mut tiles, &[Build, Scene, Export]);
    let below = tabs(&mut tiles, &[Boxes, Heatmap]);
    let mut left = Linear::new(LinearDir::Vertical, vec![above, below]);
    left.shares.set_share(above, UPPER_SHARE);
    left.shares.set_share(below, 1.0 - UPPER_SHARE);
    let left = tiles.insert_container(left);
    let viewport = tiles.insert_pane(Pane::Viewport);
    let viewport = tiles.insert_tab_tile(vec![viewport]);
    let figures = tabs(&mut tiles, &[Cost, Compare, Table, Sweep, Shadows, TreeFile]);
    let reasons =
        tabs(&mut tiles, &[PanelKind::Tree, PanelKind::Rays, PanelKind::Splits, PanelKind::Construction]);
    let mut right = Linear::new(LinearDir::Vertical, vec![figures, reasons]);
    right.shares.set_share(figures, FIGURES_SHARE);
    right.shares.set_share(reasons, 1.0 - FIGURES_SHARE);
    let right = tiles.insert_container(right);
    let mut columns = Linear::new(LinearDir::Horizontal, vec![left, viewport, right]);
    columns.shares.set_share(left, LEFT_WIDTH);
    columns.shares.set_share(viewport, 1280.0 - LEFT_WIDTH - RIGHT_WIDTH);
    columns.shares.set_share(right, RIGHT_WIDTH);
    let root = tiles.insert_container(columns);
    Tree::new(egui::Id::unique("bvhscope tiles"), root, tiles)
}

/// Whether every pane is there once, can be reached from the root, and no link is broken or circular.
fn is_whole(tree: &Tree<Pane>) -> bool {
    let Some(root) = tree.root() else { return false };
    let mut found = Vec::new();
    let mut open = vec![root];
    let mut visited = Vec::new();
    while let Some(id) = open.pop() {
        if visited.contains(&id) {
            return false;
        }
        visited.push(id);
        match tree.tiles.get(id) {
            Some(Tile::Pane(pane)) => found.push(*pane),
            Some(Tile::Container(container)) => open.extend(container.children().copied()),
            None => return false,
        }
    }
    let viewport = tree.tiles.find_pane(&Pane::Viewport);
    found.len() == Pane::all().count()
        && Pane::all().all(|pane| found.contains(&pane))
        && viewport.is_some_and(|id| tree.tiles.is_visible(id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[derive(Default)]
    struct Memory(HashMap<String, String>);

    impl eframe::Storage for Memory {
        fn get_string(&self, key: &str) -> Option<String> {
            self.0.get(key).cloned()
        }
        fn set_string(&mut self, key: &str, value: String) {
            self.0.insert(key.to_owned(), value);
        }
        fn remove_string(&mut self, key: &str) {
            self.0.remove(key);
        }
        fn flush(&mut self) {}
    }

    fn widths(layout: &Layout, width: f32) -> Vec<f32> {
        let root = layout.tree.root().expect("a root");
        let Some(Container::Linear(linear)) = layout.tree.tiles.get_container(root) else {
            panic!("the root is a row");
        };
        linear.shares.split(&linear.children, width)
    }

    #[test]
    fn at_first_start_build_boxes_cost_and_tree_are_in_front() {
        let layout = Layout::default();
        assert!(is_whole(&layout.tree));
        let showing: Vec<_> = PanelKind::ALL.into_iter().filter(|k| layout.is_showing(*k)).collect();
        assert_eq!(showing, [PanelKind::Build, PanelKind::Boxes, PanelKind::Cost, PanelKind::Tree]);
        assert!(PanelKind::ALL.into_iter().all(|k| layout.is_open(k)));
    }

    #[test]
    fn a_wider_window_gives_its_width_to_the_viewport() {
        let mut layout = Layout::default();
        for width in [1280.0, 1920.0, 1100.0, 1280.0] {
            layout.fit_width(width);
            let columns = widths(&layout, width);
            assert!((columns[0] - LEFT_WIDTH).abs() < 1.0, "{columns:?} at {width}");
            assert!((columns[2] - RIGHT_WIDTH).abs() < 1.0, "{columns:?} at {width}");
        }
        layout.fit_width(700.0);
        assert!(widths(&layout, 700.0)[1] > 200.0, "the viewport is never squeezed away");
    }

    #[test]
    fn a_layout_is_kept_and_a_broken_one_is_not_used() {
        let mut memory = Memory::default();
        let mut layout = Layout::default();
        layout.show(PanelKind::Table, true);
        layout.show(PanelKind::Boxes, false);
        layout.save(&mut memory);
        let kept = Layout::load(&memory);
        assert!(kept.is_showing(PanelKind::Table) && !kept.is_open(PanelKind::Boxes));

        let mut broken = layout.clone();
        let id = broken.tree.tiles.find_pane(&Pane::Panel(PanelKind::Cost)).expect("a pane");
        broken.tree.tiles.remove(id);
        broken.save(&mut memory);
        assert!(Layout::load(&memory).is_open(PanelKind::Cost));

        let text = memory.0[STORAGE_KEY].clone();
        for garbage in ["", "(tree:", &text[..text.len() / 2]] {
            memory.0.insert(STORAGE_KEY.to_owned(), garbage.to_owned());
            assert!(is_whole(&Layout::load(&memory).tree));
        }
    }

    #[test]
    fn a_hidden_panel_comes_back_to_the_front() {
        let mut layout = Layout::default();
        layout.show(PanelKind::Heatmap, false);
        assert!(!layout.is_open(PanelKind::Heatmap) && !layout.is_showing(PanelKind::Heatmap));
        layout.show(PanelKind::Heatmap, true);
        assert!(layout.is_showing(PanelKind::Heatmap) && !layout.is_showing(PanelKind::Boxes));
    }
}
