//! The closed set of bounded shapes, and what each of them can be asked.

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Aabb, Cuboid, Polygon, PreparedRay, Quad, Ray, Sphere, Torus, Triangle};

/// The kinds of bounded shapes. A plane is unbounded and is not among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ShapeKind {
    Triangle,
    Sphere,
    Cuboid,
    Quad,
    Torus,
}

impl ShapeKind {
    pub const ALL: [Self; 5] = [Self::Triangle, Self::Sphere, Self::Cuboid, Self::Quad, Self::Torus];

    pub fn name(self) -> &'static str {
        match self {
            Self::Triangle => "triangle",
            Self::Sphere => "sphere",
            Self::Cuboid => "cuboid",
            Self::Quad => "quad",
            Self::Torus => "torus",
        }
    }
}

/// One bounded shape, by value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Triangle(Triangle),
    Sphere(Sphere),
    Cuboid(Cuboid),
    Quad(Quad),
    Torus(Torus),
}

/// What a shape's `intersect` answers; `u`, `v` as in [`super::Hit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
}

/// The geometry of a point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Recomputed from the shape's own parameters where that is more precise than `ray.at(t)`.
    pub position: Vec3,
    /// A bound of the absolute error of each component of `position`.
    pub error: Vec3,
    /// The unit normal on the shape's outside (counter-clockwise side of a triangle or quad); never flipped towards the ray.
    pub normal: Vec3,
    pub uv: Vec2,
}

/// A point drawn uniformly by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    pub position: Vec3,
    pub error: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
}

/// The origin of a ray that leaves a surface along `direction`: `position` moved along the unit normal, to the side
/// that `direction` points to, by the error bound and at least to the next number in each component. It lies on that
/// side of the true surface for certain, and nothing in between is lost (Waechter and Binder, "A Fast and Robust Method
/// for Avoiding Self-Intersection", 2019, with the bound in place of their constants).
#[inline(always)]
pub fn leave_surface(position: Vec3, error: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
    let offset = side * error.dot(normal.abs());
    let moved = position + offset;
    // On by one or two units in the last place, against the rounding of the sum.
    let more = (moved.abs() * f32::EPSILON + f32::MIN_POSITIVE).copysign(offset);
    moved + Vec3::select(offset.cmpeq(Vec3::ZERO), Vec3::ZERO, more)
}

impl SurfacePoint {
    /// The origin of a ray that leaves along `direction` ([`leave_surface`]).
    #[inline]
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        leave_surface(self.position, self.error, self.normal, direction)
    }
}

impl SurfaceSample {
    /// The ray from `origin` to this point, direction not normalised, whose end lies before this point's own surface
    /// by what rounding may have moved either of them: whatever it hits stands between.
    #[inline(always)]
    pub fn ray_from(&self, origin: Vec3) -> Ray {
        let direction = self.position - origin;
        let spread = (self.error + direction.abs() * f32::EPSILON).dot(self.normal.abs());
        let t_max = 1.0 - 2.0 * f32::EPSILON - 1.01 * spread / direction.dot(self.normal).abs();
        Ray { origin, direction, t_min: 0.0, t_max: t_max.max(0.0) }
    }
}

/// Calls the same method of whichever shape it is.
macro_rules! each_shape {
    ($self:expr, $shape:ident => $body:expr) => {
        match $self {
            Shape::Triangle($shape) => $body,
            Shape::Sphere($shape) => $body,
            Shape::Cuboid($shape) => $body,
            Shape::Quad($shape) => $body,
            Shape::Torus($shape) => $body,
        }
    };
}

impl Shape {
    pub fn kind(&self) -> ShapeKind {
        match self {
            Self::Triangle(_) => ShapeKind::Triangle,
            Self::Sphere(_) => ShapeKind::Sphere,
            Self::Cuboid(_) => ShapeKind::Cuboid,
            Self::Quad(_) => ShapeKind::Quad,
            Self::Torus(_) => ShapeKind::Torus,
        }
    }

    /// The smallest box around the shape (for curved shapes rounded outwards).
    pub fn bounds(&self) -> Aabb {
        each_shape!(self, s => s.bounds())
    }

    /// The nearest hit with `t_min <= t <= t_max`, from outside or inside.
    #[inline]
    pub fn intersect(&self, ray: &PreparedRay) -> Option<ShapeHit> {
        each_shape!(self, s => s.intersect(ray))
    }

    /// As [`Shape::intersect`] with another interval.
    #[inline]
    pub fn intersect_within(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<ShapeHit> {
        each_shape!(self, s => s.intersect_within(ray, t_min, t_max))
    }

    /// The surface where `hit`, an answer of [`Shape::intersect`] to `ray`, lies.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit) -> SurfacePoint {
        each_shape!(self, s => s.surface(ray, hit))
    }

    /// The surface area.
    pub fn area(&self) -> f32 {
        each_shape!(self, s => s.area())
    }

    /// A point drawn uniformly by area from `u` in `[0, 1)^2`.
    pub fn sample(&self, u: Vec2) -> SurfaceSample {
        each_shape!(self, s => s.sample(u))
    }

    /// The box around the part of the shape inside `clip` (empty if there is none): exact for triangles, quads and
    /// cuboids, an upper bound for the others.
    pub fn clipped_bounds(&self, clip: &Aabb) -> Aabb {
        each_shape!(self, s => s.clipped_bounds(clip))
    }

    /// A box around the part between two planes across `axis` (empty if there is none): exact for triangles and quads but
    /// for rounding outwards, an upper bound for the others.
    pub fn bounds_between(&self, axis: usize, from: f32, to: f32) -> Aabb {
        if let Self::Triangle(triangle) = self {
            return triangle.bounds_between(axis, from, to);
        }
        let mut clip = self.bounds();
        clip.min[axis] = clip.min[axis].max(from);
        clip.max[axis] = clip.max[axis].min(to);
        if clip.is_empty() { Aabb::EMPTY } else { self.clipped_bounds(&clip) }
    }

    /// The shape itself, if it is flat.
    pub fn polygon(&self) -> Option<Polygon> {
        match self {
            Self::Triangle(triangle) => Some(Polygon::new(triangle.v.map(Vec3::as_dvec3))),
            Self::Quad(quad) => Some(Polygon::new(quad.corners())),
            Self::Sphere(_) | Self::Cuboid(_) | Self::Torus(_) => None,
        }
    }

    /// Whether [`Shape::area_inside`] is an estimate.
    pub fn area_is_sampled(&self) -> bool {
        match self {
            Self::Sphere(_) | Self::Torus(_) => true,
            Self::Triangle(_) | Self::Cuboid(_) | Self::Quad(_) => false,
        }
    }

    /// What the surface areas of the boxes of its parts add up to when a flat shape is cut ever finer: twice the areas of its
    /// shadows along the axes (Karras and Aila 2013). The area of its own box for bodies, whose surfaces would have to be
    /// boxed on all sides.
    pub fn area_in_parts(&self) -> f32 {
        let shadows = |u: Vec3, v: Vec3| u.cross(v).abs().element_sum();
        match self {
            Self::Triangle(Triangle { v: [a, b, c] }) => shadows(*b - *a, *c - *a),
            Self::Quad(quad) => 2.0 * shadows(quad.edge_u, quad.edge_v),
            Self::Sphere(_) | Self::Cuboid(_) | Self::Torus(_) => self.bounds().area(),
        }
    }

    /// The area of the part inside `clip`: exact for triangles, quads and cuboids, estimated on
    /// a fixed set of points for the others.
    pub fn area_inside(&self, clip: &Aabb) -> f32 {
        each_shape!(self, s => s.area_inside(clip))
    }
}
