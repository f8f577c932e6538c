//! Rigid placement of shapes: rotation and translation.

use glam::{DMat3, DVec3, Quat, Vec3};
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

/// A [`Rigid`] in double precision, its rotation made exactly one.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactRigid {
    rotation: DMat3,
    pub translation: DVec3,
}

impl Rigid {
    #[inline]
    pub(super) fn exact(&self) -> ExactRigid {
        let rotation = DMat3::from_quat(self.rotation.as_dquat().normalize());
        ExactRigid { rotation, translation: self.translation.as_dvec3() }
    }
}

impl ExactRigid {
    /// The object's axes in world space.
    #[inline]
    pub fn x_axis(&self) -> DVec3 {
        self.rotation.x_axis
    }

    #[inline]
    pub fn y_axis(&self) -> DVec3 {
        self.rotation.y_axis
    }

    #[inline]
    pub fn z_axis(&self) -> DVec3 {
        self.rotation.z_axis
    }

    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    #[inline]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.rotation * v
    }

    #[inline]
    pub fn inverse_point(&self, p: DVec3) -> DVec3 {
        self.inverse_vector(p - self.translation)
    }

    #[inline]
    pub fn inverse_vector(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.rotation.x_axis.dot(v), self.rotation.y_axis.dot(v), self.rotation.z_axis.dot(v))
    }
}
