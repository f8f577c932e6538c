//! The pinhole camera.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::geometry::{Aabb, Ray};

/// The world axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpAxis {
    #[default]
    Y,
    Z,
}

impl UpAxis {
    pub const ALL: [Self; 2] = [Self::Y, Self::Z];

    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    pub fn vector(self) -> Vec3 {
        match self {
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
        }
    }
}

/// Position, target and vertical field of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    pub eye: Vec3,
    pub target: Vec3,
    pub fov_y_degrees: f32,
    pub up: UpAxis,
}

impl Default for Camera {
    fn default() -> Self {
        Self { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::ZERO, fov_y_degrees: 45.0, up: UpAxis::Y }
    }
}

/// A camera prepared for a picture of a given size: unit vectors to the right, up and forward, and half the picture's
/// width and height at distance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    pub half_size: Vec2,
    pub size: Vec2,
}

impl Camera {
    /// Prepares for a picture of `width` x `height` pixels. Looking along the up axis picks any horizon.
    pub fn frame(&self, width: u32, height: u32) -> CameraFrame {
        let _ = (width, height);
        todo!()
    }

    /// A camera that sees all of `bounds`, from its front, slightly above.
    pub fn framing(bounds: &Aabb, up: UpAxis) -> Self {
        let _ = (bounds, up);
        todo!()
    }

    /// Turns around the target by angles in radians; never over the pole.
    pub fn orbit(&mut self, yaw: f32, pitch: f32) {
        let _ = (yaw, pitch);
        todo!()
    }

    /// Moves eye and target together, in pixels of a picture `height` pixels high, so that the target follows the mouse.
    pub fn pan(&mut self, delta: Vec2, height: f32) {
        let _ = (delta, height);
        todo!()
    }

    /// Moves towards the target (`steps > 0`) or away from it, never through it.
    pub fn dolly(&mut self, steps: f32) {
        let _ = steps;
        todo!()
    }

    /// Flies: `motion` is along right, up, forward in scene units.
    pub fn fly(&mut self, motion: Vec3) {
        let _ = motion;
        todo!()
    }
}

impl CameraFrame {
    /// The ray through a point of the picture, in pixels from the top left; unit direction.
    #[inline]
    pub fn ray(&self, pixel: Vec2) -> Ray {
        let x = (2.0 * pixel.x / self.size.x - 1.0) * self.half_size.x;
        let y = (1.0 - 2.0 * pixel.y / self.size.y) * self.half_size.y;
        Ray::new(self.eye, (self.forward + x * self.right + y * self.up).normalize())
    }

    /// Where a point lies: pixels from the top left, and the distance along `forward` (negative behind the camera).
    #[inline]
    pub fn project(&self, point: Vec3) -> Vec3 {
        let d = point - self.eye;
        let z = d.dot(self.forward);
        let x = d.dot(self.right) / (z * self.half_size.x);
        let y = d.dot(self.up) / (z * self.half_size.y);
        Vec3::new((x + 1.0) * 0.5 * self.size.x, (1.0 - y) * 0.5 * self.size.y, z)
    }
}
