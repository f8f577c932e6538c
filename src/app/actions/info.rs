//! What is said of an action: name, sentence, keys, whether it can be done and whether it is on.

use std::borrow::Cow;

use egui::{KeyboardShortcut, Ui};

/// What an action has to do with; headings of the page of shortcuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    File,
    Edit,
    Camera,
    Select,
    Rays,
    Picture,
    Tree,
    Learn,
    Window,
}

impl Group {
    pub const ALL: [Self; 9] = [
        Self::File,
        Self::Edit,
        Self::Camera,
        Self::Select,
        Self::Rays,
        Self::Picture,
        Self::Tree,
        Self::Learn,
        Self::Window,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Camera => "Camera",
            Self::Select => "Select",
            Self::Rays => "Rays",
            Self::Picture => "Picture",
            Self::Tree => "Tree",
            Self::Learn => "Learn",
            Self::Window => "Window",
        }
    }
}

/// An action as menus and lists show it.
#[derive(Clone, Debug)]
pub struct Info {
    pub group: Group,
    /// As in a menu.
    pub name: Cow<'static, str>,
    /// One sentence without a full stop.
    pub about: Cow<'static, str>,
    /// The one that is shown first.
    pub keys: Vec<KeyboardShortcut>,
    /// Why it cannot be done now.
    pub obstacle: Option<&'static str>,
    /// Of what can be on or off, or is one of several choices.
    pub on: Option<bool>,
}

impl Info {
    pub fn new(
        group: Group,
        name: impl Into<Cow<'static, str>>,
        about: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self { group, name: name.into(), about: about.into(), keys: Vec::new(), obstacle: None, on: None }
    }

    /// Adds a shortcut.
    pub fn key(mut self, key: KeyboardShortcut) -> Self {
        self.keys.push(key);
        self
    }

    pub fn on(self, on: bool) -> Self {
        Self { on: Some(on), ..self }
    }

    /// Can be done under a condition only; `otherwise` says why not.
    pub fn only_if(self, can: bool, otherwise: &'static str) -> Self {
        Self { obstacle: (!can).then_some(otherwise), ..self }
    }

    /// With its group, as the command palette lists it.
    pub fn full_name(&self) -> String {
        format!("{}: {}", self.group.name(), self.name)
    }

    /// Its first shortcut; empty if it has none.
    pub fn key_text(&self, ui: &Ui) -> String {
        self.keys.first().map_or_else(String::new, |key| text(ui, key))
    }

    /// All of its shortcuts.
    pub fn keys_text(&self, ui: &Ui) -> String {
        let keys: Vec<String> = self.keys.iter().map(|key| text(ui, key)).collect();
        keys.join(", ")
    }
}

/// A shortcut as it is printed on the keys: `[` instead of `OpenBracket`.
fn text(ui: &Ui, shortcut: &KeyboardShortcut) -> String {
    let text = ui.ctx().format_shortcut(shortcut);
    let key = shortcut.logical_key;
    match key.symbol_or_name() {
        // Arrows and the like are better told by their names: not every font has them.
        symbol if symbol.len() == 1 => text.replace(key.name(), symbol),
        _ => text,
    }
}
