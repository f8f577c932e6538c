//! Undo and redo of every setting, one step for what a user does in one go.
//!
//! egui's `Undoer` waits until nothing changes any more, which would make one step of two settings that are changed one
//! soon after the other, and two of one long drag. Here a step ends with the hand that made it: all that changes while a
//! button of the mouse is held is one step, and so are changes of the same settings by wheel or keys that follow each other
//! within [`TOGETHER`].
//!
//! No steps are: the size of the window, time that flows while the scene is animated, and what a load finds out. Another
//! scene, session or tree that is opened ends the history: undo never loads anything. *Open recent* goes back there.

use std::time::{Duration, Instant};

use super::state::State;
use super::view::CompareViews;
use crate::session::Session;
use crate::session::flags::flags;

/// Changes of the same settings without a hold of the mouse, as by the wheel, are one step within this time.
const TOGETHER: Duration = Duration::from_millis(800);

/// Steps that are remembered.
const MOST: usize = 200;

/// Values longer than this, in characters, are not said.
const LONGEST_VALUE: usize = 20;

/// Everything that can be undone.
#[derive(Clone, Debug, PartialEq)]
struct Snapshot {
    session: Session,
    compare: Option<CompareViews>,
}

/// From one snapshot to the next.
#[derive(Clone, Debug)]
struct Step {
    before: Snapshot,
    after: Snapshot,
    /// The press of the mouse that came last before it.
    press: u64,
    changed: Instant,
}

/// What was done, and what was undone.
#[derive(Default)]
pub struct Undo {
    /// Oldest first.
    past: Vec<Step>,
    /// The next one to be done again last.
    future: Vec<Step>,
    /// As it was when it was last looked at; `None` until something is open.
    seen: Option<Snapshot>,
    /// The load that the history belongs to.
    load: Option<u64>,
    /// Counts presses of the mouse's buttons.
    press: u64,
    /// A button is held, or was let go in this frame.
    holds: bool,
    /// The last step may still grow.
    open: bool,
}

impl Undo {
    /// Tells what the mouse does in this frame; before [`Undo::observe`].
    pub fn mouse(&mut self, pressed: bool, holds: bool) {
        self.press += u64::from(pressed);
        self.holds = holds;
    }

    /// Time that flows is no step.
    pub fn time_flows(&mut self, time: f32) {
        if let Some(seen) = &mut self.seen {
            seen.session.time = time;
        }
    }

    /// Looks whether anything has changed since the last time.
    pub fn observe(&mut self, state: &State, now: Instant) {
        let load = state.document.as_ref().map(|document| document.load);
        if load != self.load {
            *self = Self { load, seen: load.map(|_| snapshot(state)), press: self.press, ..Self::default() };
            return;
        }
        let Some(seen) = &mut self.seen else { return };
        adopt_surroundings(&mut seen.session, &state.session);
        if seen.session == state.session && seen.compare == state.compare {
            return;
        }
        let after = snapshot(state);
        let before = std::mem::replace(seen, after.clone());
        let changes = changes(&before, &after);
        if changes.is_empty() {
            return;
        }
        self.future.clear();
        let press = self.press;
        let grows = self.open
            && self.past.last().is_some_and(|last| {
                let same_hold = self.holds && last.press == press;
                let soon = now.saturating_duration_since(last.changed) < TOGETHER;
                same_hold || (soon && names(&self::changes(&last.before, &last.after)) == names(&changes))
            });
        match self.past.last_mut().filter(|_| grows) {
            Some(last) => {
                (last.after, last.changed, last.press) = (after, now, press);
                // Dragged back to where it was.
                if self::changes(&last.before, &last.after).is_empty() {
                    self.past.pop();
                }
            }
            None => self.past.push(Step { before, after, press, changed: now }),
        }
        self.open = true;
        if self.past.len() > MOST {
            self.past.remove(0);
        }
    }

    /// What the next undo takes back, in words.
    pub fn undo_text(&self) -> Option<String> {
        self.past.last().map(text)
    }

    /// What the next redo does again, in words.
    pub fn redo_text(&self) -> Option<String> {
        self.future.last().map(text)
    }

    /// Takes the last step back; what it was, in words.
    pub fn undo(&mut self, state: &mut State) -> Option<String> {
        let step = self.past.pop()?;
        self.go(state, &step.after, &step.before);
        let text = text(&step);
        self.future.push(step);
        Some(text)
    }

    /// Does the step that was undone last again; what it was, in words.
    pub fn redo(&mut self, state: &mut State) -> Option<String> {
        let step = self.future.pop()?;
        self.go(state, &step.before, &step.after);
        let text = text(&step);
        self.past.push(step);
        Some(text)
    }

    fn go(&mut self, state: &mut State, from: &Snapshot, to: &Snapshot) {
        let mut session = to.session.clone();
        adopt_surroundings(&mut session, &state.session);
        // A step that did not set the moment leaves it where it has come to.
        if from.session.time == to.session.time {
            session.time = state.session.time;
        }
        state.session = session;
        state.compare = to.compare;
        self.seen = Some(snapshot(state));
        self.open = false;
    }
}

fn snapshot(state: &State) -> Snapshot {
    Snapshot { session: state.session.clone(), compare: state.compare }
}

/// What is no setting: the window's size, and what was found out about files.
fn adopt_surroundings(session: &mut Session, now: &Session) {
    (session.render.width, session.render.height) = (now.render.width, now.render.height);
    session.scene.clone_from(&now.scene);
    for (variant, now) in session.variants.iter_mut().zip(&now.variants) {
        if let (Some(tree), Some(now)) = (&mut variant.tree, &now.tree)
            && tree.path == now.path
        {
            tree.content_hash.clone_from(&now.content_hash);
        }
    }
}

/// A setting that differs: its name, and the two values where they are short enough to be said.
#[derive(Debug, PartialEq)]
struct Change {
    name: String,
    values: Option<[String; 2]>,
}

fn changes(before: &Snapshot, after: &Snapshot) -> Vec<Change> {
    let (a, b) = (&before.session, &after.session);
    let mut found = Vec::new();
    for flag in flags() {
        let values = [flag.write(a), flag.write(b)];
        if values[0] != values[1] {
            let short = values.iter().all(|value| value.chars().count() <= LONGEST_VALUE);
            let values = (short && flag.name != "camera").then_some(values);
            found.push(Change { name: flag.name.replace('-', " "), values });
        }
    }
    let mut other = |differs: bool, name: &str| {
        if differs {
            found.push(Change { name: name.to_owned(), values: None });
        }
    };
    other(a.bookmarks != b.bookmarks, "bookmarks");
    other(a.active != b.active || a.variants.len() != b.variants.len(), "kept trees");
    other(a.variants.iter().zip(&b.variants).any(|(a, b)| a.name != b.name), "names of trees");
    other(before.compare != after.compare, "two views at once");
    if found.is_empty() && before != after {
        // Every setting has a flag; should one come without, it can be undone all the same.
        found.push(Change { name: "settings".to_owned(), values: None });
    }
    found
}

fn names(changes: &[Change]) -> Vec<&str> {
    changes.iter().map(|change| change.name.as_str()).collect()
}

fn text(step: &Step) -> String {
    let changes = changes(&step.before, &step.after);
    match changes.as_slice() {
        [Change { name, values: Some([before, after]) }] => format!("{name} {before} to {after}"),
        [] | [_] | [_, _] | [_, _, _] => names(&changes).join(", "),
        many => format!("{} settings", many.len()),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::jobs::{SceneKey, TreeKey};
    use crate::app::state::Document;
    use crate::render::View;
    use crate::scene::{Camera, builtin};
    use crate::task::Task;
    use crate::world::World;

    /// A program with something open, and a clock.
    struct Desk {
        state: State,
        undo: Undo,
        now: Instant,
    }

    impl Desk {
        fn new() -> Self {
            let session = Session::default();
            let still = Arc::new(builtin::make("soup:10").expect("a scene"));
            let world =
                World::build(Arc::clone(&still), session.build(), &Task::new()).expect("not cancelled");
            let tree = TreeKey::wanted(SceneKey::of(1, &still, &session), &session);
            let mut state = State::new(session, true);
            state.document =
                Some(Document { load: 1, still, world: Arc::new(world), tree, warnings: Vec::new() });
            let mut desk = Self { state, undo: Undo::default(), now: Instant::now() };
            desk.undo.observe(&desk.state, desk.now);
            desk
        }

        fn change(&mut self, change: impl FnOnce(&mut Session)) {
            change(&mut self.state.session);
            self.now += Duration::from_millis(16);
            self.undo.observe(&self.state, self.now);
        }

        /// A click of the mouse that changes something.
        fn click(&mut self, change: impl FnOnce(&mut Session)) {
            self.undo.mouse(true, true);
            self.change(change);
            self.undo.mouse(false, false);
        }

        fn undo(&mut self) -> Option<String> {
            self.undo.undo(&mut self.state)
        }

        fn redo(&mut self) -> Option<String> {
            self.undo.redo(&mut self.state)
        }
    }

    #[test]
    fn clicks_are_steps_of_their_own_and_are_said_in_words() {
        let mut desk = Desk::new();
        let start = desk.state.session.clone();
        desk.click(|s| s.build_mut().bins = 32);
        desk.click(|s| s.view = View::Normal);
        desk.click(|s| (s.ground, s.time) = (true, 2.0));
        let end = desk.state.session.clone();
        assert_eq!(desk.undo().as_deref(), Some("time, ground"));
        assert_eq!(desk.undo().as_deref(), Some("view path to normal"));
        assert_eq!(desk.undo.undo_text().as_deref(), Some("bins 16 to 32"));
        desk.undo();
        assert_eq!((desk.undo(), &desk.state.session), (None, &start));
        assert_eq!(desk.undo.redo_text().as_deref(), Some("bins 16 to 32"));
        while desk.redo().is_some() {}
        assert_eq!(desk.state.session, end);
        desk.undo();
        desk.click(|s| s.build_mut().leaf = 5);
        assert_eq!(desk.redo(), None, "another change ends what could be done again");
    }

    #[test]
    fn a_drag_is_one_step_however_long_and_one_back_to_its_start_is_none() {
        let mut desk = Desk::new();
        desk.undo.mouse(true, true);
        for bins in 17..40 {
            desk.now += Duration::from_secs(2);
            desk.change(|s| s.build_mut().bins = bins);
            desk.undo.mouse(false, true);
        }
        desk.undo.mouse(false, false);
        assert_eq!(desk.undo().as_deref(), Some("bins 16 to 39"));
        assert_eq!((desk.state.session.build().bins, desk.undo()), (16, None));
        desk.undo.mouse(true, true);
        for bins in [20, 18, 16] {
            desk.change(|s| s.build_mut().bins = bins);
            desk.undo.mouse(false, true);
        }
        assert_eq!(desk.undo(), None);
    }

    #[test]
    fn wheel_and_keys_are_one_step_until_they_rest() {
        let mut desk = Desk::new();
        let fly = |s: &mut Session| s.camera.get_or_insert_with(Camera::default).eye.x += 1.0;
        for _ in 0..10 {
            desk.change(fly);
        }
        desk.now += Duration::from_secs(2);
        desk.change(fly);
        desk.change(|s| s.build_mut().leaf = 3);
        assert_eq!(desk.undo().as_deref().map(|t| t.starts_with("leaf ")), Some(true));
        assert_eq!(desk.undo().as_deref(), Some("camera"));
        assert_eq!(desk.state.session.camera.map(|c| c.eye.x), Some(10.0));
        assert_eq!(desk.undo().as_deref(), Some("camera"));
        assert_eq!((desk.state.session.camera, desk.undo()), (None, None));
    }

    #[test]
    fn the_window_s_size_and_time_that_flows_are_no_steps_and_stay() {
        let mut desk = Desk::new();
        desk.click(|s| s.build_mut().bins = 32);
        desk.change(|s| (s.render.width, s.render.height) = (333, 222));
        desk.state.session.time = 4.5;
        desk.undo.time_flows(4.5);
        desk.undo.observe(&desk.state, desk.now);
        desk.change(|s| s.scene.content_hash = "ab".repeat(32));
        assert_eq!(desk.undo().as_deref(), Some("bins 16 to 32"));
        let session = &desk.state.session;
        assert_eq!((session.build().bins, session.time), (16, 4.5));
        assert_eq!((session.render.width, session.render.height), (333, 222));
        assert_eq!(session.scene.content_hash.len(), 64);
        desk.click(|s| s.time = 1.0);
        assert_eq!(desk.undo().as_deref(), Some("time 4.5 to 1"));
        assert_eq!(desk.state.session.time, 4.5);
    }

    #[test]
    fn another_scene_ends_the_history() {
        let mut desk = Desk::new();
        desk.click(|s| s.build_mut().bins = 32);
        desk.state.document.as_mut().expect("open").load = 2;
        desk.undo.observe(&desk.state, desk.now);
        assert_eq!((desk.undo(), desk.redo()), (None, None));
        desk.click(|s| s.build_mut().bins = 64);
        assert_eq!(desk.undo().as_deref(), Some("bins 32 to 64"));
    }

    #[test]
    fn every_part_of_a_session_that_changes_has_words() {
        let mut desk = Desk::new();
        desk.click(|s| drop(s.add_bookmark(Camera::default()).map(|b| b.name.clone())));
        desk.click(|s| s.variants.push(s.variants[0].clone()));
        desk.click(|s| s.variants[1].name = "B".to_owned());
        for expected in ["names of trees", "kept trees", "bookmarks"] {
            assert_eq!(desk.undo().as_deref(), Some(expected));
        }
    }
}
