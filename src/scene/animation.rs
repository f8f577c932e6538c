//! Motion as a pure function of time; t = 0 is the still scene.

use std::ops::Range;

use glam::Vec3;

use super::Scene;

/// What moves, and how.
#[derive(Clone, Debug, PartialEq)]
pub enum Track {
    /// Vertices of the mesh (a range of positions and one of normals).
    Vertices { positions: Range<u32>, normals: Range<u32>, motion: Motion },
    /// One bounded shape that is not a triangle, by shape index.
    Shape { shape: u32, motion: Motion },
}

/// A motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// A twist about the vertical (y) axis through `center`: the angle grows with height above it, by
    /// `amplitude * sin(rate * t)` radians a unit.
    Twist { center: Vec3, amplitude: f32, rate: f32 },
    /// A turn about an axis through the shape's own centre, `rate` radians a second.
    Turn { axis: Vec3, rate: f32 },
    /// The bounce of `room`: up by `height * (1 - ((t mod 2) - 1)^2)`.
    Bounce { height: f32 },
    /// The swing of the light of `room`: about z through `pivot`, by `amplitude * sin(rate * t)`.
    Swing { pivot: Vec3, amplitude: f32, rate: f32 },
}

impl Scene {
    /// Whether the scene moves at all.
    pub fn is_animated(&self) -> bool {
        !self.animation.is_empty()
    }

    /// This scene (which must be the one of t = 0) at another moment.
    #[must_use]
    pub fn at(&self, time: f32) -> Scene {
        let _ = time;
        todo!()
    }
}
