//! What a picture accumulates: linear colours or raw numbers, a pixel each.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::views::{CountKind, View, ViewClass};
use crate::scene::ShadowRule;

/// What a film depends on besides scene, camera, time and tree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RenderSettings {
    /// Picture size in pixels, 1 to 16384 each.
    pub width: u32,
    pub height: u32,
    /// Samples a pixel of a finished picture; `None`: 1 for `render`, without end in the window.
    pub spp: Option<u32>,
    pub seed: u64,
    /// Most bounces of a path, or reflections of a Whitted ray.
    pub max_depth: u32,
    /// Worker threads; 0 for all.
    pub threads: usize,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self { width: 1280, height: 720, spp: None, seed: 0, max_depth: 10, threads: 0 }
    }
}

/// What is drawn into a film: the view with the settings that change its raw content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FilmSubject {
    pub view: View,
    pub count: CountKind,
    pub shadow_rule: ShadowRule,
}

/// The raw content of a picture, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    pub subject: FilmSubject,
    /// Samples a pixel so far.
    pub samples: u32,
    pub content: FilmContent,
}

/// Sums over the samples.
#[derive(Clone, Debug, PartialEq)]
pub enum FilmContent {
    /// Linear RGB (radiance and data views).
    Color(Vec<Vec3>),
    /// Numbers (distance, heat, class views). NaN where there is nothing to say (a miss).
    Number(Vec<f32>),
}

impl Film {
    /// An empty film of the kind that the view asks for.
    pub fn new(width: u32, height: u32, subject: FilmSubject) -> Self {
        let pixels = width as usize * height as usize;
        let content = match subject.view.class() {
            ViewClass::Radiance | ViewClass::Data => FilmContent::Color(vec![Vec3::ZERO; pixels]),
            ViewClass::Distance | ViewClass::Heat | ViewClass::Leaf | ViewClass::Class => {
                FilmContent::Number(vec![0.0; pixels])
            }
        };
        Self { width, height, subject, samples: 0, content }
    }

    /// The mean linear colour of a pixel; `None` on a film of numbers, outside the film, or before the first sample.
    pub fn color(&self, x: u32, y: u32) -> Option<Vec3> {
        let index = self.index(x, y)?;
        match &self.content {
            FilmContent::Color(sums) => Some(sums[index] / self.samples as f32),
            FilmContent::Number(_) => None,
        }
    }

    /// The mean number of a pixel; `None` on a film of colours, outside the film, before the first sample, or where there
    /// is no number.
    pub fn number(&self, x: u32, y: u32) -> Option<f32> {
        let index = self.index(x, y)?;
        match &self.content {
            FilmContent::Color(_) => None,
            FilmContent::Number(sums) => Some(sums[index] / self.samples as f32).filter(|n| !n.is_nan()),
        }
    }

    /// How many numbers the film holds, NaN or not; 0 for a film of colours, and before the first sample.
    pub fn numbers_count(&self) -> usize {
        match &self.content {
            FilmContent::Number(sums) if self.samples > 0 => sums.len(),
            FilmContent::Number(_) | FilmContent::Color(_) => 0,
        }
    }

    /// All mean numbers, NaN where there is none; `None` on a film of colours.
    pub fn numbers(&self) -> Option<Vec<f32>> {
        match &self.content {
            FilmContent::Color(_) => None,
            // Without samples this is 0 / 0: NaN, no number.
            FilmContent::Number(sums) => Some(sums.iter().map(|s| s / self.samples as f32).collect()),
        }
    }

    /// Where a pixel lies in the content; `None` outside the film or before the first sample.
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let inside = x < self.width && y < self.height && self.samples > 0;
        inside.then(|| y as usize * self.width as usize + x as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(view: View) -> Film {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::Glass };
        Film::new(3, 2, subject)
    }

    #[test]
    fn every_view_gets_the_content_of_its_class() {
        for view in View::ALL {
            let colored = matches!(view.class(), ViewClass::Radiance | ViewClass::Data);
            match film(view).content {
                FilmContent::Color(sums) => assert!(colored && sums.len() == 6, "{}", view.name()),
                FilmContent::Number(sums) => assert!(!colored && sums.len() == 6, "{}", view.name()),
            }
        }
    }

    #[test]
    fn pixels_are_means_and_absent_outside_or_without_samples() {
        let mut numbers = film(View::Depth);
        assert_eq!(numbers.number(0, 0), None);
        numbers.samples = 2;
        numbers.content = FilmContent::Number(vec![2.0, 4.0, 6.0, 8.0, 10.0, f32::NAN]);
        assert_eq!(numbers.number(1, 1), Some(5.0));
        assert_eq!((numbers.number(2, 1), numbers.number(3, 0), numbers.number(0, 2)), (None, None, None));
        assert_eq!(numbers.numbers().map(|n| n[3]), Some(4.0));
        assert_eq!(numbers.color(0, 0), None);

        let mut colors = film(View::Path);
        colors.samples = 4;
        colors.content = FilmContent::Color(vec![Vec3::splat(2.0); 6]);
        assert_eq!(colors.color(2, 1), Some(Vec3::splat(0.5)));
        assert_eq!((colors.color(2, 2), colors.number(0, 0), colors.numbers()), (None, None, None));
    }
}
