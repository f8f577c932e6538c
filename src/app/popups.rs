//! What lies over the window for a moment: the command palette, the page of shortcuts, and a paste that is awaited.

use egui::text::LayoutJob;
use egui::{
    Align, Align2, Color32, Event, FontId, Id, Key, Modal, Modifiers, Rect, Role, ScrollArea, Sense,
    TextEdit, TextFormat, TextStyle, Ui, WidgetInfo, pos2, vec2,
};
use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use super::actions::{Action, Around, Info};
use super::commands::Commands;
use super::shortcuts;

/// Sizes of the palette, in points.
const WIDTH: f32 = 580.0;
const ROW: f32 = 25.0;
const MOST_ROWS: f32 = 13.0;
const FROM_TOP: f32 = 64.0;

/// Worth of a letter of a text that a sentence holds: less than in a piece of a name (16, and more at the beginning of a
/// word), and more than of letters that lie scattered in one.
const IN_SENTENCE: u32 = 17;

/// Frames after which the clipboard has nothing to give.
const PASTE_FRAMES: u32 = 5;

/// What lies over the window.
#[derive(Default)]
pub struct Popups {
    pub shortcuts: bool,
    pub finder: Option<Finder>,
    /// Frames since a paste was asked for.
    paste: Option<u32>,
}

impl Popups {
    pub fn ui(&mut self, ui: &Ui, around: &Around, commands: &mut Commands) {
        shortcuts::page(ui, around, &mut self.shortcuts);
        if let Some(finder) = &mut self.finder
            && finder.ui(ui, around, commands)
        {
            self.finder = None;
        }
    }

    pub fn wait_for_paste(&mut self) {
        self.paste = Some(0);
    }

    /// The text that was asked of the clipboard, once it comes.
    pub fn pasted(&mut self, ctx: &egui::Context) -> Option<Result<String, &'static str>> {
        let frames = self.paste?;
        let text = ctx.input_mut(|input| {
            let at = input.events.iter().position(|event| matches!(event, Event::Paste(_)))?;
            match input.events.remove(at) {
                Event::Paste(text) => Some(text),
                _ => None,
            }
        });
        self.paste = None;
        if let Some(text) = text {
            return Some(Ok(text));
        }
        if frames >= PASTE_FRAMES {
            return Some(Err(
                "The clipboard holds no text: copy a camera first, as with Edit > Copy camera.",
            ));
        }
        self.paste = Some(frames + 1);
        ctx.request_repaint();
        None
    }
}

/// The command palette: a text, and the actions whose names it is found in.
#[derive(Default)]
pub struct Finder {
    text: String,
    /// Among those that are found.
    selected: usize,
    /// Since the keys moved it the selection is kept in sight.
    moved: bool,
    /// Where the mouse was: it selects only if it moves.
    mouse: Option<egui::Pos2>,
}

/// An action that was found.
struct Found {
    action: Action,
    info: Info,
    name: String,
    /// Indices of the name's letters that the text was found in.
    letters: Vec<u32>,
}

impl Finder {
    /// Draws it over the window; true when it has done its work.
    fn ui(&mut self, ui: &Ui, around: &Around, commands: &mut Commands) -> bool {
        let keys = read_keys(ui);
        let mut found = found(around, &self.text);
        self.selected = self.selected.min(found.len().saturating_sub(1));
        self.move_by(keys.steps, found.len());
        let mut chosen = keys.enter.then_some(self.selected);
        let area =
            Modal::default_area(Id::unique("bvhscope palette")).anchor(Align2::CENTER_TOP, [0.0, FROM_TOP]);
        let modal = Modal::new(Id::unique("bvhscope palette")).area(area).show(ui.ctx(), |ui| {
            ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 60.0));
            if self.field(ui) {
                found = self::found(around, &self.text);
                (self.selected, self.moved) = (0, true);
            }
            ui.add_space(4.0);
            chosen = self.list(ui, around, &found).or(chosen);
            self.footer(ui, around, &found);
        });
        let chosen = chosen.and_then(|index| found.get(index)).filter(|found| found.info.obstacle.is_none());
        if let Some(found) = chosen {
            commands.push(found.action.command(around));
        }
        chosen.is_some() || keys.escape || modal.backdrop_response.clicked()
    }

    fn move_by(&mut self, steps: i32, count: usize) {
        if steps != 0 && count > 0 {
            let next = self.selected as i32 + steps;
            // A single step goes around; a page stops at the end.
            let next = if steps.abs() == 1 {
                next.rem_euclid(count as i32)
            } else {
                next.clamp(0, count as i32 - 1)
            };
            (self.selected, self.moved) = (next as usize, true);
        }
    }

    /// The field for the text; whether it was changed.
    fn field(&mut self, ui: &mut Ui) -> bool {
        let edit = TextEdit::singleline(&mut self.text)
            .hint_text("What do you want to do?")
            .font(TextStyle::Heading)
            .desired_width(ui.available_width());
        let field = ui.add(edit).accessible_name("Find a command");
        field.request_focus();
        field.changed()
    }

    /// The index of the action that was clicked.
    fn list(&mut self, ui: &mut Ui, around: &Around, found: &[Found]) -> Option<usize> {
        let mouse = ui.input(|i| i.pointer.hover_pos());
        let mouse_moved = self.mouse.is_some() && mouse != self.mouse;
        self.mouse = mouse;
        let mut clicked = None;
        ScrollArea::vertical().max_height(MOST_ROWS * ROW).auto_shrink([false, true]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            for (index, found) in found.iter().enumerate() {
                let (rect, response) =
                    ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
                let enabled = found.info.obstacle.is_none();
                response.widget_info(|| {
                    WidgetInfo::selected(Role::ListItem, enabled, index == self.selected, &found.name)
                });
                if response.hovered() && mouse_moved {
                    self.selected = index;
                }
                if response.clicked() {
                    clicked = Some(index);
                }
                if index == self.selected && self.moved {
                    response.scroll_to_me(None);
                }
                if ui.is_rect_visible(rect) {
                    paint_row(ui, around, rect, found, index == self.selected);
                }
            }
        });
        self.moved = false;
        if found.is_empty() {
            ui.weak("No command is called like that.");
        }
        clicked
    }

    /// What the selected action does, or why it cannot be done.
    fn footer(&self, ui: &mut Ui, around: &Around, found: &[Found]) {
        ui.separator();
        let Some(Found { info, .. }) = found.get(self.selected) else {
            ui.weak("Esc closes");
            return;
        };
        let (text, color) = match info.obstacle {
            Some(obstacle) => (obstacle, around.view.palette.warning),
            None => (info.about.as_ref(), around.view.palette.muted),
        };
        ui.add(egui::Label::new(egui::RichText::new(text).color(color)).truncate());
    }
}

struct Keys {
    steps: i32,
    enter: bool,
    escape: bool,
}

/// The keys of the palette, before its text field gets them.
fn read_keys(ui: &Ui) -> Keys {
    ui.input_mut(|input| {
        let mut count = |key| input.count_and_consume_key(Modifiers::NONE, key) as i32;
        let page = MOST_ROWS as i32 - 1;
        let steps =
            count(Key::ArrowDown) - count(Key::ArrowUp) + page * (count(Key::PageDown) - count(Key::PageUp));
        Keys { steps, enter: count(Key::Enter) > 0, escape: count(Key::Escape) > 0 }
    })
}

/// The actions whose names hold the text's letters in order, or whose sentences hold the text as it is, the best first. All
/// of them for no text.
fn found(around: &Around, text: &str) -> Vec<Found> {
    let actions = Action::all(around).into_iter().map(|action| {
        let info = action.info(around);
        let name = info.full_name();
        Found { action, info, name, letters: Vec::new() }
    });
    let text = text.trim();
    if text.is_empty() {
        return actions.collect();
    }
    let mut matcher = Matcher::new(Config::DEFAULT);
    let pattern = Pattern::parse(text, CaseMatching::Ignore, Normalization::Smart);
    let mut buffer = Vec::new();
    let letters = text.chars().count() as u32;
    let mut scored: Vec<(u32, Found)> = actions
        .filter_map(|mut found| {
            let name = Utf32Str::new(&found.name, &mut buffer);
            let by_name = pattern.indices(name, &mut matcher, &mut found.letters);
            let is_said = letters > 2 && found.info.about.to_lowercase().contains(&text.to_lowercase());
            let by_sentence = is_said.then_some(IN_SENTENCE * letters);
            if by_name.is_none() || by_sentence > by_name {
                found.letters.clear();
            }
            by_name.max(by_sentence).map(|score| (score, found))
        })
        .collect();
    // Stable: of equally good ones the first of the list stays first.
    scored.sort_by_key(|(score, found)| (found.info.obstacle.is_some(), std::cmp::Reverse(*score)));
    scored.into_iter().map(|(_, found)| found).collect()
}

fn paint_row(ui: &Ui, around: &Around, rect: Rect, found: &Found, selected: bool) {
    let palette = around.view.palette;
    if selected {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().selection.bg_fill);
    }
    let enabled = found.info.obstacle.is_none();
    let text = if enabled { ui.visuals().strong_text_color() } else { palette.muted };
    let font = TextStyle::Body.resolve(ui.style());
    let keys = ui.painter().layout_no_wrap(found.info.keys_text(ui), FontId::monospace(11.5), palette.muted);
    let left = rect.left() + 8.0;
    let room = rect.width() - 16.0 - keys.size().x - 12.0;
    let galley = ui.painter().layout_job(row_text(ui, found, text, palette.accent, font, room));
    let place = |height: f32| rect.center().y - height / 2.0;
    let right = rect.right() - 8.0 - keys.size().x;
    ui.painter().galley(pos2(right, place(keys.size().y)), keys, Color32::PLACEHOLDER);
    ui.painter().galley(pos2(left, place(galley.size().y)), galley, text);
    if found.info.on == Some(true) {
        let mark = Rect::from_min_size(rect.left_top() + vec2(1.0, 6.0), vec2(3.0, rect.height() - 12.0));
        ui.painter().rect_filled(mark, 1.5, palette.accent);
    }
}

/// The name, with the letters that the text was found in.
fn row_text(ui: &Ui, found: &Found, text: Color32, accent: Color32, font: FontId, room: f32) -> LayoutJob {
    let mut job = LayoutJob::default();
    let group = found.info.group.name().chars().count() + 1;
    let quiet = ui.visuals().weak_text_color();
    for (index, letter) in found.name.chars().enumerate() {
        let color = if found.letters.contains(&(index as u32)) {
            accent
        } else if index < group {
            quiet
        } else {
            text
        };
        let format = TextFormat { valign: Align::Center, ..TextFormat::simple(font.clone(), color) };
        job.append(letter.encode_utf8(&mut [0; 4]), 0.0, format);
    }
    job.wrap = egui::text::TextWrapping::truncate_at_width(room);
    job
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::layout::Layout;
    use crate::app::state::State;
    use crate::app::undo::Undo;
    use crate::session::Session;

    fn first(text: &str) -> Option<Action> {
        let state = State::new(Session::default(), true);
        let (layout, undo) = (Layout::default(), Undo::default());
        let view = state.view();
        let around = Around { view: &view, layout: &layout, undo: &undo, reopens: true };
        found(&around, text).first().map(|found| found.action)
    }

    #[test]
    fn actions_are_found_by_pieces_of_their_names_and_by_their_sentences() {
        use crate::accel::Builder;
        use crate::render::{ColorMap, View};
        assert_eq!(first("save ses"), Some(Action::SaveSession));
        assert_eq!(first("nodvis"), Some(Action::ShowView(View::NodesVisited)));
        assert_eq!(first("BUILDER sweep"), Some(Action::UseBuilder(Builder::Sweep)));
        assert_eq!(first("colour viridis"), Some(Action::UseColors(ColorMap::Viridis)));
        assert_eq!(first("Utah"), Some(Action::OpenBuiltin(5)), "what the scene is, not what it is called");
        assert_eq!(first("qqqqq"), None);
        assert_eq!(first("  "), Some(Action::Open));
    }

    #[test]
    fn the_selection_goes_around_and_a_page_stops_at_the_end() {
        let mut finder = Finder::default();
        finder.move_by(-1, 5);
        assert_eq!(finder.selected, 4);
        finder.move_by(1, 5);
        assert_eq!(finder.selected, 0);
        finder.move_by(12, 5);
        assert_eq!(finder.selected, 4);
        finder.move_by(1, 0);
        assert_eq!(finder.selected, 4);
    }
}
