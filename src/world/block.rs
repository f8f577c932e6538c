//! Four triangles tested at once, lane by lane exactly as [`Triangle::intersect`] does it.
//!
//! The edge test runs on all lanes. Of the lanes that pass it, those whose distance cannot matter are dropped by an error
//! bound, and what is left is confirmed one by one in double precision.

use fearless_simd::{Simd, f32x4, prelude::*};
use glam::Vec3;

use crate::geometry::triangle::{Sheared, edges, shear};
use crate::geometry::{Hit, PreparedRay, Ray, ShapeHit, Triangle};

/// Triangles in a block.
pub const LANES: usize = 4;

/// Set in the first shape's index of a leaf's block if the leaf holds more than this block.
const GOES_ON: u32 = 1 << 31;

/// Up to four triangles as structure of arrays. Lanes without a triangle hold NaN, which no ray hits.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct TriangleBlock {
    /// `corners[corner][axis]`.
    corners: [[[f32; LANES]; 3]; 3],
    /// Index of each lane's shape; [`Hit::NO_SHAPE`] without one. See [`GOES_ON`].
    shapes: [u32; LANES],
}

/// What the edge test needs of a ray, spread over the lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneRay<'a, S: Simd> {
    simd: S,
    ray: &'a PreparedRay,
    origin: [f32x4<S>; 3],
    shear: [f32x4<S>; 2],
}

#[inline(always)]
fn spread<S: Simd>(simd: S, value: f32) -> f32x4<S> {
    f32x4::simd_from(simd, value)
}

impl<'a, S: Simd> LaneRay<'a, S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &'a PreparedRay) -> Self {
        let ([x, y, z], [shear_x, shear_y, _]) = (ray.origin, ray.shear);
        Self {
            simd,
            ray,
            origin: [spread(simd, x), spread(simd, y), spread(simd, z)],
            shear: [spread(simd, shear_x), spread(simd, shear_y)],
        }
    }

    #[inline(always)]
    pub fn ray(&self) -> &'a PreparedRay {
        self.ray
    }

    #[inline(always)]
    pub fn t_min(&self) -> f32 {
        self.ray.ray.t_min
    }

    #[inline(always)]
    pub fn t_max(&self) -> f32 {
        self.ray.ray.t_max
    }
}

/// The lanes that may be hit in an interval: those of four triangles that a ray tests, or of eight rays that a triangle
/// tests.
#[derive(Clone, Copy, Debug)]
pub struct Candidates<V> {
    sheared: Sheared<V>,
    pub edges: [V; 3],
    /// Bit i for lane i.
    pub lanes: u32,
    /// Those of them that are hit in the interval for sure: what confirms a hit would not say otherwise.
    pub sure: u32,
    /// Those of them that are hit behind `t_min` for sure, if at all in time.
    pub inside: u32,
    /// The distance of each, which is known to lie strictly between these.
    pub lower: V,
    pub upper: V,
}

impl<V> Candidates<V> {
    /// The lanes that pass the edge test and may be hit between `t_min` and `t_max`. Corners and origin are in the ray's
    /// permuted axes, `shear` is that of [`PreparedRay`].
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        corners: [[V; 3]; 3],
        origin: [V; 3],
        shear_by: [V; 3],
        [t_min, t_max]: [V; 2],
    ) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let [shear_x, shear_y, inv_depth] = shear_by;
        let sheared = shear(corners, origin, [shear_x, shear_y]);
        let edges = edges(sheared);
        let zero = V::simd_from(simd, 0.0);
        let left = edges[0].simd_ge(zero) & edges[1].simd_ge(zero) & edges[2].simd_ge(zero);
        let right = edges[0].simd_le(zero) & edges[1].simd_le(zero) & edges[2].simd_le(zero);
        let lanes = (left | right).to_bitmask() as u32;
        if lanes == 0 {
            return Self { sheared, edges, lanes, sure: 0, inside: 0, lower: zero, upper: zero };
        }
        let [a, b, c] = corners;
        let depths = [a[2] - origin[2], b[2] - origin[2], c[2] - origin[2]];
        let Bounded { known, inside, lower, upper } = bounded(simd, sheared, edges, depths, inv_depth);
        // A NaN says nothing.
        let outside = known & (upper.simd_lt(t_min) | lower.simd_gt(t_max));
        let inside = inside & lower.simd_gt(t_min);
        let sure = inside & upper.simd_lt(t_max);
        let lanes = lanes & !outside.to_bitmask() as u32;
        let (inside, sure) = (lanes & inside.to_bitmask() as u32, lanes & sure.to_bitmask() as u32);
        Self { sheared, edges, lanes, sure, inside, lower, upper }
    }
}

impl TriangleBlock {
    pub const EMPTY: Self = Self { corners: [[[f32::NAN; LANES]; 3]; 3], shapes: [Hit::NO_SHAPE; LANES] };

    /// A block of at most [`LANES`] triangles with the indices of their shapes. `goes_on`: it is the first one of a leaf
    /// that holds more.
    pub fn new(triangles: &[(u32, Triangle)], goes_on: bool) -> Self {
        assert!(triangles.len() <= LANES, "a block holds {LANES} triangles");
        let mut block = Self::EMPTY;
        for (lane, (shape, triangle)) in triangles.iter().enumerate() {
            block.shapes[lane] = *shape;
            for corner in 0..3 {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = triangle.v[corner][axis];
                }
            }
        }
        if goes_on {
            block.shapes[0] |= GOES_ON;
        }
        block
    }

    #[inline(always)]
    pub fn shape(&self, lane: usize) -> u32 {
        self.shapes[lane] & !GOES_ON
    }

    /// Whether the leaf whose first block this is holds more. True for a block without triangles.
    #[inline(always)]
    pub fn goes_on(&self) -> bool {
        self.shapes[0] & GOES_ON != 0
    }

    /// A corner of a lane's triangle along an axis.
    #[inline(always)]
    pub fn coordinate(&self, lane: usize, corner: usize, axis: usize) -> f32 {
        self.corners[corner % 3][axis % 3][lane % LANES]
    }

    /// Triangles in it.
    #[inline(always)]
    pub fn count(&self) -> u32 {
        self.shapes.iter().map(|&shape| u32::from(shape != Hit::NO_SHAPE)).sum()
    }

    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let [a, b, c] = &self.corners;
        let [a, b, c] = [
            Vec3::new(a[0][lane], a[1][lane], a[2][lane]),
            Vec3::new(b[0][lane], b[1][lane], b[2][lane]),
            Vec3::new(c[0][lane], c[1][lane], c[2][lane]),
        ];
        Triangle { v: [a, b, c] }
    }

    /// The lanes that pass the edge test and may be hit between the ray's `t_min` and `t_max`.
    #[inline(always)]
    pub fn candidates<S: Simd>(&self, ray: &LaneRay<S>, t_max: f32) -> Candidates<f32x4<S>> {
        let simd = ray.simd;
        let [a, b, c] = &self.corners;
        let corners = [load(ray, a), load(ray, b), load(ray, c)];
        let inv_depth = spread(simd, ray.ray.shear[2]);
        let interval = [spread(simd, ray.t_min()), spread(simd, t_max)];
        Candidates::new(simd, corners, ray.origin, [ray.shear[0], ray.shear[1], inv_depth], interval)
    }

    /// The hit of a lane that is a candidate.
    #[inline(always)]
    pub fn confirm<S: Simd>(
        &self,
        candidates: &Candidates<f32x4<S>>,
        lane: usize,
        ray: &LaneRay<S>,
        t_min: f32,
        t_max: f32,
    ) -> Option<ShapeHit> {
        let sheared = candidates.sheared.map(|corner| corner.map(|c| c[lane]));
        let edges = candidates.edges.map(|e| e[lane]);
        self.triangle(lane).confirm(ray.ray, &sheared, edges, t_min, t_max)
    }
}

/// A corner of every triangle, in the ray's permuted axes.
#[inline(always)]
fn load<S: Simd>(ray: &LaneRay<S>, corner: &[[f32; LANES]; 3]) -> [f32x4<S>; 3] {
    let [x, y, z] = ray.ray.k;
    let (x, y, z) = (&corner[x], &corner[y], &corner[z]);
    [
        f32x4::load_array_ref(ray.simd, x),
        f32x4::load_array_ref(ray.simd, y),
        f32x4::load_array_ref(ray.simd, z),
    ]
}

/// The largest magnitude in every lane.
#[inline(always)]
fn most<S: Simd, V: SimdFloat<S, Element = f32>>([a, b, c]: [V; 3]) -> V {
    a.abs().max(b.abs()).max(c.abs())
}

/// The share of error in the determinant from which on nothing is taken for known: the bounds hold to first order only.
const MOST_DET_ERROR: f32 = 0.0625;

/// What rounding errors leave no doubt about.
struct Bounded<S: Simd, V: SimdFloat<S>> {
    /// Lanes with a distance between `lower` and `upper`, both not reached.
    known: V::Mask,
    /// Those of them that the ray passes through, away from the edges.
    inside: V::Mask,
    lower: V,
    upper: V,
}

/// Bounds the distances by single precision arithmetic.
///
/// The bounds are those of Pharr, Jakob and Humphreys, "Physically Based Rendering", third edition, 3.9.6, to which the
/// error of the determinant is added, and all of it doubled.
#[inline(always)]
fn bounded<S: Simd, V: SimdFloat<S, Element = f32>>(
    simd: S,
    sheared: Sheared<V>,
    edges: [V; 3],
    depths: [V; 3],
    inv_depth: V,
) -> Bounded<S, V> {
    /// Relative error of `n` operations in a row.
    const fn gamma(n: i32) -> f32 {
        let error = n as f32 * 0.5 * f32::EPSILON;
        error / (1.0 - error)
    }
    let [[ax, ay], [bx, by], [cx, cy]] = sheared;
    let (x, y, z, e) = (most([ax, bx, cx]), most([ay, by, cy]), most(depths), most(edges));
    let (x_error, y_error, z_error) = ((x + z) * gamma(5), (y + z) * gamma(5), z * gamma(3));
    let e_error = (x * y * gamma(2) + y_error * x + x_error * y) * 2.0;
    let sum_error = (e * z * gamma(3) + e_error * z + z_error * e) * 3.0;
    let det = edges[0] + edges[1] + edges[2];
    let scale = inv_depth / det;
    let t = (edges[0] * depths[0] + edges[1] * depths[1] + edges[2] * depths[2]) * scale;
    let det_share = e_error * 3.0 / det.abs();
    let error = (sum_error * scale.abs() + t.abs() * (det_share + gamma(6))) * 1.125;
    let [a, b, c] = edges;
    let known = det_share.simd_lt(V::simd_from(simd, MOST_DET_ERROR));
    let inside = known & a.abs().min(b.abs()).min(c.abs()).simd_gt(e_error * 2.0);
    Bounded { known, inside, lower: t - error, upper: t + error }
}

impl<S: Simd> Candidates<f32x4<S>> {
    /// Whether a lane is hit between the ray's `t_min` and the `t_max` that was asked for, without confirming it.
    #[inline(always)]
    pub fn is_sure(&self, lane: usize) -> bool {
        self.sure >> lane & 1 != 0
    }

    /// A lane's hit, if it is one behind `t_min` for sure.
    #[inline(always)]
    pub fn inside<'a>(&self, block: &'a TriangleBlock, lane: usize) -> Option<Passed<'a>> {
        (self.inside >> lane & 1 != 0).then(
            #[inline(always)]
            || Passed {
                block,
                lane: lane as u32,
                lower: self.lower[lane],
                upper: self.upper[lane],
                edges: [self.edges[0][lane], self.edges[1][lane], self.edges[2][lane]],
            },
        )
    }

    /// The lanes, ascending.
    #[inline(always)]
    pub fn lanes(&self) -> Lanes {
        Lanes(self.lanes)
    }
}

/// A triangle that the ray passes through for sure, and about where.
#[derive(Clone, Copy, Debug)]
pub struct Passed<'a> {
    pub block: &'a TriangleBlock,
    pub lane: u32,
    pub edges: [f32; 3],
    /// The distance lies strictly between these.
    pub lower: f32,
    pub upper: f32,
}

impl Passed<'_> {
    /// The hit as [`TriangleBlock::confirm`] would tell it.
    #[inline(always)]
    pub fn hit(&self, ray: &Ray) -> Hit {
        let lane = self.lane as usize;
        let ShapeHit { t, u, v } = self.block.triangle(lane).place(ray, self.edges);
        Hit { t, shape: self.block.shape(lane), u, v }
    }
}

/// Bits that are set, ascending.
pub struct Lanes(u32);

impl Iterator for Lanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::accel::simd::{SimdLevel, SimdToken};
    use crate::at_level;

    /// Coarse coordinates, so that rays go through edges and corners and along faces.
    fn point(rng: &mut Pcg32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| rng.random_range(-3..=3) as f32 * 0.7))
    }

    struct Answers {
        hits: [Option<ShapeHit>; LANES],
        sure: u32,
        /// Between which distances the lanes are hit that are so behind `t_min` for sure.
        inside: [Option<(f32, f32)>; LANES],
    }

    fn answers<S: Simd>(simd: S, block: &TriangleBlock, ray: &PreparedRay, t_max: f32) -> Answers {
        let lane_ray = LaneRay::new(simd, ray);
        let candidates = block.candidates(&lane_ray, t_max);
        let mut hits = [None; LANES];
        for lane in candidates.lanes() {
            hits[lane] = block.confirm(&candidates, lane, &lane_ray, 0.0, t_max);
        }
        let inside = std::array::from_fn(|lane| {
            candidates.inside(block, lane).map(|passed| {
                assert_eq!(
                    passed.hit(&ray.ray).t,
                    block.triangle(lane).intersect(ray).map_or(-1.0, |hit| hit.t)
                );
                (passed.lower, passed.upper)
            })
        });
        Answers { hits, sure: candidates.sure, inside }
    }

    #[test]
    fn every_lane_answers_exactly_as_the_triangle_alone_at_every_level() {
        let levels: Vec<_> = SimdLevel::ALL.into_iter().filter_map(SimdToken::new).collect();
        let mut rng = Pcg32::seed_from_u64(1);
        let (mut hits, mut surely) = (0, 0);
        for round in 0..40_000 {
            let fine = round % 3 == 0;
            let corner = |rng: &mut Pcg32| {
                let shift =
                    if fine { Vec3::new(rng.random(), rng.random(), rng.random()) } else { Vec3::ZERO };
                point(rng) + shift
            };
            let triangles: Vec<(u32, Triangle)> = (0..1 + round % 4)
                .map(|i| (i, Triangle { v: std::array::from_fn(|_| corner(&mut rng)) }))
                .collect();
            let block = TriangleBlock::new(&triangles, false);
            let ray = PreparedRay::new(Ray::new(corner(&mut rng), corner(&mut rng)));
            // Also ends just before, at and behind the first triangle.
            let first = triangles[0].1.intersect(&ray).map_or(f32::MAX, |hit| hit.t);
            let t_max = [f32::MAX, first, first.next_down(), 1.0][round as usize / 4 % 4];
            let alone: [_; LANES] = std::array::from_fn(|lane| {
                triangles.get(lane).and_then(|(_, t)| t.intersect_within(&ray, 0.0, t_max))
            });
            for &level in &levels {
                let Answers { hits: together, sure, inside } =
                    at_level!(level, simd => answers(simd, &block, &ray, t_max));
                assert_eq!(together, alone, "{level:?} {triangles:?} {ray:?}");
                for (lane, &bounds) in inside.iter().enumerate() {
                    let Some((lower, upper)) = bounds else { continue };
                    let t = triangles[lane].1.intersect(&ray).expect("it is hit for sure").t;
                    assert!(
                        lower < t && t < upper,
                        "{level:?} {lane} {lower} {t} {upper} {triangles:?} {ray:?}"
                    );
                }
                for lane in (0..LANES).filter(|lane| sure >> lane & 1 != 0) {
                    assert!(alone[lane].is_some(), "{level:?} {lane} {triangles:?} {ray:?} {t_max}");
                    surely += 1;
                }
            }
            hits += alone.iter().flatten().count();
        }
        assert!(hits > 1000 && surely > 1000, "only {hits} rays hit anything, {surely} surely");
    }

    #[test]
    fn a_block_knows_its_triangles_and_whether_its_leaf_goes_on() {
        let triangle = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        let all = [(7, triangle), (9, triangle), (11, triangle)];
        let (whole, part, none) = (
            TriangleBlock::new(&all, false),
            TriangleBlock::new(&all[..1], true),
            TriangleBlock::new(&[], true),
        );
        assert_eq!([whole.count(), part.count(), none.count()], [3, 1, 0]);
        assert_eq!([whole.goes_on(), part.goes_on(), none.goes_on()], [false, true, true]);
        assert_eq!((whole.shape(2), part.shape(0)), (11, 7));
    }
}
