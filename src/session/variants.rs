//! The states that a session keeps side by side: A, B, C. One is active, and is what is edited; the others stay as they
//! are. A state has build settings, perhaps the tree of a file, and perhaps a scene and a moment of its own.

use serde::{Deserialize, Serialize};

use super::{Session, SessionScene, TreeRef};
use crate::accel::BuildConfig;

/// Most states side by side.
pub const MAX_VARIANTS: usize = 64;

/// Named build settings, and what they build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    pub name: String,
    pub build: BuildConfig,
    /// The tree of a file instead of one that is built; its costs and instructions are those of `build`.
    #[serde(default)]
    pub tree: Option<TreeRef>,
    /// `None`: the session's scene. The active state has none of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SessionScene>,
    /// `None`: the session's moment. The active state has none of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f32>,
}

impl Default for Variant {
    fn default() -> Self {
        Self { name: "A".to_owned(), build: BuildConfig::default(), tree: None, scene: None, time: None }
    }
}

impl Session {
    /// The scene of a state.
    pub fn scene_of(&self, index: usize) -> &SessionScene {
        self.variants[index].scene.as_ref().unwrap_or(&self.scene)
    }

    /// The moment of a state, in seconds.
    pub fn time_of(&self, index: usize) -> f32 {
        self.variants[index].time.unwrap_or(self.time)
    }

    /// The session in which another state is active. Every state shows what it did before: those without a scene or a
    /// moment of their own keep the session's, which are now those of the state that became active.
    #[must_use]
    pub fn activated(&self, index: usize) -> Self {
        let mut session = self.clone();
        session.scene = self.scene_of(index).clone();
        session.time = self.time_of(index);
        session.active = index;
        for (i, variant) in session.variants.iter_mut().enumerate() {
            let (scene, time) = (self.scene_of(i), self.time_of(i));
            variant.scene = (scene.reference != session.scene.reference).then(|| scene.clone());
            variant.time = (time != session.time).then_some(time);
        }
        session
    }

    /// Keeps the active state as it is, and goes on with a copy of it under another name, which becomes active. `false` if
    /// there are too many already.
    pub fn keep(&mut self) -> bool {
        let copy = Variant { name: self.free_name(), ..self.variants[self.active].clone() };
        let added = self.add(copy);
        if let Some(index) = added {
            self.active = index;
        }
        added.is_some()
    }

    /// Adds a state, or finds the one that is like it but for the name; its index. `None` if there are too many already.
    pub fn add_or_find(&mut self, variant: Variant) -> Option<usize> {
        let is_like = |other: &Variant| Variant { name: variant.name.clone(), ..other.clone() } == variant;
        match self.variants.iter().position(is_like) {
            Some(index) => Some(index),
            None => self.add(variant),
        }
    }

    fn add(&mut self, variant: Variant) -> Option<usize> {
        if self.variants.len() >= MAX_VARIANTS {
            return None;
        }
        self.variants.push(variant);
        Some(self.variants.len() - 1)
    }

    /// Forgets a state that is not active; whether it did.
    pub fn remove_variant(&mut self, index: usize) -> bool {
        if index == self.active || index >= self.variants.len() {
            return false;
        }
        self.variants.remove(index);
        self.active -= usize::from(self.active > index);
        true
    }

    /// The first of A, B, C ... Z, A2, B2 ... that no state has.
    pub fn free_name(&self) -> String {
        let names = (1..).flat_map(|round| {
            ('A'..='Z').map(move |letter| match round {
                1 => letter.to_string(),
                _ => format!("{letter}{round}"),
            })
        });
        let is_free = |name: &String| self.variants.iter().all(|variant| variant.name != *name);
        names.into_iter().find(is_free).expect("there are more names than states")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneRef;

    fn scene(name: &str) -> SessionScene {
        SessionScene { reference: SceneRef::Builtin(name.to_owned()), ..SessionScene::default() }
    }

    /// What every state shows.
    fn shown(session: &Session) -> Vec<(SceneRef, f32, usize)> {
        let states = 0..session.variants.len();
        let bins = |i: usize| session.variants[i].build.bins;
        states.map(|i| (session.scene_of(i).reference.clone(), session.time_of(i), bins(i))).collect()
    }

    fn three() -> Session {
        let mut session = Session { time: 0.5, ..Session::default() };
        assert!(session.keep());
        session.build_mut().bins = 8;
        let other = Variant { scene: Some(scene("soup:10")), time: Some(2.0), ..Variant::default() };
        assert_eq!(session.add_or_find(other), Some(2));
        session
    }

    #[test]
    fn keeping_freezes_what_was_and_goes_on_with_a_copy() {
        let session = three();
        assert_eq!(session.active, 1);
        let names: Vec<_> = session.variants.iter().map(|v| (v.name.as_str(), v.build.bins)).collect();
        assert_eq!(names, [("A", 16), ("B", 8), ("A", 16)]);
        assert_eq!(session.free_name(), "C");
    }

    #[test]
    fn another_active_state_changes_what_no_state_shows() {
        let session = three();
        for index in 0..3 {
            let other = session.activated(index);
            assert_eq!(other.active, index);
            assert_eq!(shown(&other), shown(&session), "{index}");
            assert_eq!((&other.variants[index].scene, other.variants[index].time), (&None, None));
            let back = other.activated(1);
            assert_eq!(back, session, "{index}");
        }
        assert_eq!(session.activated(2).scene.reference, SceneRef::Builtin("soup:10".to_owned()));
    }

    #[test]
    fn a_state_is_found_again_whatever_its_name() {
        let mut session = three();
        let same = Variant { name: "another".to_owned(), ..session.variants[0].clone() };
        assert_eq!(session.add_or_find(same), Some(0));
        let later = Variant { time: Some(7.0), ..session.variants[0].clone() };
        assert_eq!(session.add_or_find(later), Some(3));
    }

    #[test]
    fn the_active_state_cannot_be_removed_and_stays_active() {
        let mut session = three();
        assert!(!session.remove_variant(1) && !session.remove_variant(9));
        assert!(session.remove_variant(0));
        assert_eq!((session.active, session.variants.len(), session.build().bins), (0, 2, 8));
        assert!(session.remove_variant(1));
        assert_eq!((session.active, session.variants.len()), (0, 1));
    }

    #[test]
    fn names_go_on_after_z_and_states_have_an_end() {
        let mut session = Session::default();
        while session.keep() {}
        assert_eq!(session.variants.len(), MAX_VARIANTS);
        let names: Vec<_> = session.variants.iter().map(|v| v.name.as_str()).collect();
        assert_eq!((names[25], names[26], names[52]), ("Z", "A2", "A3"));
    }
}
