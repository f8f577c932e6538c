//! What a picture accumulates: linear colours or raw numbers, a pixel each.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::views::{CountKind, View};
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
        let _ = (width, height, subject);
        todo!()
    }

    /// The mean linear colour of a pixel; `None` on a film of numbers.
    pub fn color(&self, x: u32, y: u32) -> Option<Vec3> {
        let _ = (x, y);
        todo!()
    }

    /// The mean number of a pixel; `None` on a film of colours, outside the film, or where there is no number.
    pub fn number(&self, x: u32, y: u32) -> Option<f32> {
        let _ = (x, y);
        todo!()
    }

    /// All mean numbers, NaN where there is none; `None` on a film of colours.
    pub fn numbers(&self) -> Option<Vec<f32>> {
        todo!()
    }
}
