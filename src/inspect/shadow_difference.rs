//! Pixel classes and saved nodes of the shadow views, counted.

use serde::Serialize;

use crate::render::ViewClass;
use crate::render::film::{Film, FilmContent};
use crate::render::shadow::ShadowClass;

/// Pixels a class, in order of [`ShadowClass::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ClassCounts(pub [u64; 5]);

impl ClassCounts {
    /// Counts a `shadow-difference` film; `None` for any other.
    pub fn of(film: &Film) -> Option<Self> {
        let FilmContent::Number(sums) = &film.content else { return None };
        if film.subject.view.class() != ViewClass::Class || film.samples == 0 {
            return None;
        }
        let mut counts = [0; 5];
        for class in sums.iter().map(|sum| ShadowClass::from_number(sum / film.samples as f32)) {
            counts[class.unwrap_or(ShadowClass::NotAsked) as usize] += 1;
        }
        Some(Self(counts))
    }

    pub fn get(&self, class: ShadowClass) -> u64 {
        self.0[class as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::FilmSubject;
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    fn film(view: View, numbers: &[f32]) -> Film {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::default() };
        let content = FilmContent::Number(numbers.to_vec());
        Film { width: numbers.len() as u32, height: 1, subject, samples: 1, content }
    }

    #[test]
    fn every_pixel_is_counted_once() {
        let counts =
            ClassCounts::of(&film(View::ShadowDifference, &[1.0, 3.0, 1.0, 0.0, f32::NAN, 2.0, 3.0, 3.0]));
        let counts = counts.expect("a class film");
        assert_eq!(counts, ClassCounts([2, 2, 1, 3, 0]));
        assert_eq!(counts.get(ShadowClass::DarkOnlyInOccluded), 3);
    }

    #[test]
    fn other_films_have_no_classes() {
        assert_eq!(ClassCounts::of(&film(View::ShadowSaving, &[1.0])), None);
        let empty = Film { samples: 0, ..film(View::ShadowDifference, &[1.0]) };
        assert_eq!(ClassCounts::of(&empty), None);
    }
}
