//! Four triangles tested at once, lane by lane exactly as [`Triangle::intersect`] does it.
//!
//! The lanes are glam's four-float vectors: SIMD registers where the processor has them, with the rounding of single
//! numbers. The edge test runs on all lanes; the few that pass it are confirmed one by one.

use glam::{Vec3, Vec4};

use crate::geometry::triangle::{Sheared, edges, shear};
use crate::geometry::{Hit, PreparedRay, ShapeHit, Triangle};

/// Triangles in a block.
pub const LANES: usize = 4;

/// Up to four triangles as structure of arrays. Lanes without a triangle hold NaN, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct TriangleBlock {
    /// `corners[corner][axis]`.
    corners: [[Vec4; 3]; 3],
    /// Index of each lane's shape; [`Hit::NO_SHAPE`] without one.
    shapes: [u32; LANES],
}

/// What the edge test needs of a ray, spread over the lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneRay<'a> {
    ray: &'a PreparedRay,
    origin: [Vec4; 3],
    shear: [Vec4; 2],
}

impl<'a> LaneRay<'a> {
    #[inline]
    pub fn new(ray: &'a PreparedRay) -> Self {
        Self {
            ray,
            origin: ray.k.map(|axis| Vec4::splat(ray.ray.origin[axis])),
            shear: [Vec4::splat(ray.shear.x), Vec4::splat(ray.shear.y)],
        }
    }
}

/// The lanes whose triangles passed the edge test.
#[derive(Clone, Copy, Debug)]
pub struct Candidates {
    sheared: Sheared<Vec4>,
    edges: [Vec4; 3],
    /// Bit i for lane i.
    lanes: u32,
}

impl TriangleBlock {
    /// A block of at most [`LANES`] triangles with the indices of their shapes.
    pub fn new(triangles: &[(u32, Triangle)]) -> Self {
        assert!(triangles.len() <= LANES, "a block holds {LANES} triangles");
        let mut block = Self { corners: [[Vec4::NAN; 3]; 3], shapes: [Hit::NO_SHAPE; LANES] };
        for (lane, (shape, triangle)) in triangles.iter().enumerate() {
            block.shapes[lane] = *shape;
            for corner in 0..3 {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = triangle.v[corner][axis];
                }
            }
        }
        block
    }

    #[inline]
    pub fn shape(&self, lane: usize) -> u32 {
        self.shapes[lane]
    }

    fn triangle(&self, lane: usize) -> Triangle {
        Triangle { v: self.corners.map(|c| Vec3::new(c[0][lane], c[1][lane], c[2][lane])) }
    }

    /// The edge test on all lanes.
    #[inline]
    pub fn candidates(&self, ray: &LaneRay) -> Candidates {
        let k = ray.ray.k;
        let sheared = shear(self.corners.map(|c| [c[k[0]], c[k[1]], c[k[2]]]), ray.origin, ray.shear);
        let edges = edges(sheared);
        let zero = Vec4::ZERO;
        let left = edges[0].cmpge(zero) & edges[1].cmpge(zero) & edges[2].cmpge(zero);
        let right = edges[0].cmple(zero) & edges[1].cmple(zero) & edges[2].cmple(zero);
        Candidates { sheared, edges, lanes: (left | right).bitmask() }
    }

    /// The hit of a lane that passed the edge test.
    #[inline]
    pub fn confirm(
        &self,
        candidates: &Candidates,
        lane: usize,
        ray: &LaneRay,
        t_min: f32,
        t_max: f32,
    ) -> Option<ShapeHit> {
        let sheared = candidates.sheared.map(|corner| corner.map(|c| c[lane]));
        let edges = candidates.edges.map(|e| e[lane]);
        self.triangle(lane).confirm(ray.ray, &sheared, edges, t_min, t_max)
    }
}

impl Candidates {
    /// The lanes that passed, ascending.
    #[inline]
    pub fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let mut left = self.lanes;
        std::iter::from_fn(move || {
            let lane = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::geometry::Ray;

    /// Coarse coordinates, so that rays go through edges and corners and along faces.
    fn point(rng: &mut Pcg32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| rng.random_range(-3..=3) as f32 * 0.7))
    }

    #[test]
    fn every_lane_answers_exactly_as_the_triangle_alone() {
        let mut rng = Pcg32::seed_from_u64(1);
        let mut hits = 0;
        for round in 0..20_000 {
            let triangles: Vec<(u32, Triangle)> = (0..1 + round % 4)
                .map(|i| (i, Triangle { v: std::array::from_fn(|_| point(&mut rng)) }))
                .collect();
            let block = TriangleBlock::new(&triangles);
            let ray = PreparedRay::new(Ray::new(point(&mut rng), point(&mut rng)));
            let lane_ray = LaneRay::new(&ray);
            let candidates = block.candidates(&lane_ray);
            let mut answers = [None; LANES];
            for lane in candidates.lanes() {
                answers[lane] = block.confirm(&candidates, lane, &lane_ray, 0.0, f32::MAX);
            }
            for (lane, answer) in answers.into_iter().enumerate() {
                let alone = triangles.get(lane).and_then(|(_, t)| t.intersect(&ray));
                assert_eq!(answer, alone, "{triangles:?} {ray:?}");
                hits += usize::from(alone.is_some());
            }
        }
        assert!(hits > 500, "only {hits} rays hit anything");
    }
}
