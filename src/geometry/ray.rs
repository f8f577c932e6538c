//! Rays and hits.
//!
//! The shear of [`PreparedRay`] is that of Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (2013).

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A ray segment: points `origin + t * direction` for `t_min <= t <= t_max`. The direction need not be of unit length;
/// t is in units of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
    pub t_min: f32,
    pub t_max: f32,
}

impl Ray {
    /// A ray from `origin` without end.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The largest t of a hit. An infinite `t_max` becomes the largest finite one: no hit lies further, and a box beside an
    /// axis-parallel ray, which the ray enters at infinity, is then behind its end.
    #[inline(always)]
    pub fn last(&self) -> f32 {
        self.t_max.min(f32::MAX)
    }

    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// The nearest hit so far. `u`, `v` are the barycentric coordinates of a triangle's vertices 1 and 2; for every other
/// shape they are zero or what that shape's `intersect` wants to remember for its `surface`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    pub t: f32,
    /// Index of the shape in the scene; [`Hit::NO_SHAPE`] for none yet.
    pub shape: u32,
    pub u: f32,
    pub v: f32,
}

impl Hit {
    /// The shape index of a miss. Larger than every real one, so that any hit at an equal t replaces it.
    pub const NO_SHAPE: u32 = u32::MAX;

    /// No hit up to `t_max`.
    #[inline]
    pub fn none(t_max: f32) -> Self {
        Self { t: t_max, shape: Self::NO_SHAPE, u: 0.0, v: 0.0 }
    }

    #[inline]
    pub fn is_some(&self) -> bool {
        self.shape != Self::NO_SHAPE
    }

    /// Whether a candidate replaces this hit: nearer, or as near with a lower shape index, so that the answer does
    /// not depend on the order in which a tree asks.
    #[inline]
    pub fn is_beaten_by(&self, t: f32, shape: u32) -> bool {
        t < self.t || (t == self.t && shape < self.shape)
    }
}

/// A ray with what box and triangle tests need computed once.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    pub ray: Ray,
    /// `1 / direction`, with infinities where a component is zero.
    pub inv_direction: Vec3,
    /// Axis indices after the permutation that makes the largest direction component the z axis.
    pub k: [usize; 3],
    /// The origin in permuted axes.
    pub origin: [f32; 3],
    /// Shear `(d.x / d.z, d.y / d.z, 1 / d.z)` in permuted axes, up to rounding.
    pub shear: [f32; 3],
}

/// The permutation for each largest axis of a direction that is positive, and negative, there: x and y are swapped to
/// keep the winding of triangles.
const PERMUTATIONS: [[usize; 3]; 6] = [[1, 2, 0], [2, 1, 0], [2, 0, 1], [0, 2, 1], [0, 1, 2], [1, 0, 2]];

impl PreparedRay {
    /// [`Ray::last`] becomes `t_max`.
    #[inline(always)]
    pub fn new(ray: Ray) -> Self {
        let ray = Ray { t_max: ray.last(), ..ray };
        let d = ray.direction.to_array();
        let a = [d[0].abs(), d[1].abs(), d[2].abs()];
        // Without branches: which axis is the largest is anyone's guess. As x, else y, else z of equally large ones.
        let is_x = usize::from(a[0] >= a[1] && a[0] >= a[2]);
        let is_y = usize::from(a[1] >= a[2]);
        let kz = (1 - is_x) * (2 - is_y);
        let k = PERMUTATIONS[2 * kz + usize::from(d[kz] < 0.0)];
        let origin = ray.origin.to_array();
        // One division of four lanes.
        let inv_direction = ray.direction.extend(1.0).recip().truncate();
        // Not by three more divisions: any shear will do, as long as it is the same for all triangles.
        let inv_z = inv_direction.to_array()[k[2]];
        Self {
            ray,
            inv_direction,
            k,
            origin: [origin[k[0]], origin[k[1]], origin[k[2]]],
            shear: [d[k[0]] * inv_z, d[k[1]] * inv_z, inv_z],
        }
    }
}
