//! A box in two SIMD registers, for the passes over references and bins.

use glam::{Mat3A, Vec3A, Vec4};

use crate::geometry::Aabb;

/// A box in two registers; the fourth lanes mean nothing here.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Bound {
    pub min: Vec4,
    pub max: Vec4,
}

impl Bound {
    pub const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    #[must_use]
    pub fn grown(self, point: Vec4) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// As [`Aabb::half_area`], bit for bit.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = (self.max - self.min).max(Vec4::ZERO);
        e.x * (e.y + e.z) + e.y * e.z
    }

    #[inline]
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.min.truncate(), max: self.max.truncate() }
    }
}

impl From<Aabb> for Bound {
    #[inline(always)]
    fn from(aabb: Aabb) -> Self {
        Self { min: aabb.min.extend(0.0), max: aabb.max.extend(0.0) }
    }
}

/// [`Bound::half_area`] of three boxes, a lane each. Infinite for [`Bound::EMPTY`].
#[inline(always)]
pub fn half_areas(bounds: &[Bound; 3]) -> Vec3A {
    let [a, b, c] = bounds.each_ref().map(|b| Vec3A::from_vec4(b.max - b.min));
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = Mat3A::from_cols(a, b, c).transpose();
    x * (y + z) + y * z
}
