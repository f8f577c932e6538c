//! What stands at a step of the tree's construction.

use egui::Color32;

use super::marks::{Line, OWN, edges};
use crate::app::state::State;

/// To be split or merged yet.
const OPEN: Color32 = Color32::from_rgb(94, 178, 255);
const DONE: Color32 = Color32::from_rgb(150, 220, 140);
const CHILD: Color32 = Color32::from_rgb(255, 214, 64);

/// `step` of none for the finished tree, which is no moment of it.
pub fn lines(state: &State, lines: &mut Vec<Line>) {
    let Some(document) = &state.document else { return };
    let (step, count) = state.player.step(document.tree);
    if step == count {
        return;
    }
    let Some(shown) = state.player.shown(document.tree) else { return };
    for (bounds, open) in &shown.boxes {
        lines.extend(edges(bounds, if *open { OPEN } else { DONE }, 1.0));
    }
    if let Some((_, bounds, children)) = &shown.split {
        lines.extend(children.iter().flat_map(|child| edges(child, CHILD, 1.5)));
        lines.extend(edges(bounds, OWN, 2.5));
    }
}
