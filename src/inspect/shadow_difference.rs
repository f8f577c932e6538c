//! Pixel classes and saved nodes of the shadow views, counted.

use serde::Serialize;

use crate::render::film::Film;
use crate::render::shadow::ShadowClass;

/// Pixels a class, in order of [`ShadowClass::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClassCounts(pub [u64; 5]);

impl ClassCounts {
    /// Counts a `shadow-difference` film; `None` for any other.
    pub fn of(film: &Film) -> Option<Self> {
        let _ = film;
        todo!()
    }

    pub fn get(&self, class: ShadowClass) -> u64 {
        self.0[class as usize]
    }
}
