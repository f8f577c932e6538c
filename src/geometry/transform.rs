//! Rigid placement of shapes: rotation and translation.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

/// Rotation, then translation. Named `world_from_object` where it places a shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rigid {
    pub rotation: Quat,
    pub translation: Vec3,
}

impl Rigid {
    pub const IDENTITY: Self = Self { rotation: Quat::IDENTITY, translation: Vec3::ZERO };

    pub fn new(rotation: Quat, translation: Vec3) -> Self {
        Self { rotation, translation }
    }

    pub fn point(&self, p: Vec3) -> Vec3 {
        self.rotation * p + self.translation
    }

    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.rotation * v
    }

    pub fn inverse_point(&self, p: Vec3) -> Vec3 {
        self.rotation.inverse() * (p - self.translation)
    }

    pub fn inverse_vector(&self, v: Vec3) -> Vec3 {
        self.rotation.inverse() * v
    }

    /// First `inner`, then `self`.
    #[must_use]
    pub fn then_after(&self, inner: &Self) -> Self {
        Self { rotation: self.rotation * inner.rotation, translation: self.point(inner.translation) }
    }
}
