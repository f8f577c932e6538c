//! The nearest hits of a packet's rays while they walk.

use fearless_simd::{Simd, f32x8, f64x4, mask32x8, prelude::*};

use super::super::best::Best;
use super::super::block::{Candidates, Passed, TriangleBlock};
use crate::accel::traverse::packet::{GROUP, Lanes, PACKET, PacketLanes, Rays};
use crate::geometry::{Hit, Ray, ShapeHit};

/// The nearest hit of each ray so far. As in [`Best`], of triangles that are hit for sure only bounds of the distance are
/// kept.
#[derive(Debug)]
pub struct PacketBest<'a> {
    /// Nothing behind these can be the nearest hits.
    t_max: Lanes,
    /// A hit behind the end of the nearest one's bounds cannot replace it, one before this start does.
    start: Lanes,
    /// The rays with a hit that is known to the last bit, and the hits.
    found: Rays,
    exact: [Hit; PACKET],
    /// Where a hit is pending: its block, lane and edge functions.
    pending: Rays,
    blocks: [Option<&'a TriangleBlock>; PACKET],
    lanes: [u8; PACKET],
    edges: [Lanes; 3],
}

impl Default for PacketBest<'_> {
    fn default() -> Self {
        Self {
            t_max: Lanes::ZERO,
            start: Lanes::ZERO,
            found: Rays::NONE,
            exact: [Hit::none(0.0); PACKET],
            pending: Rays::NONE,
            blocks: [None; PACKET],
            lanes: [0; PACKET],
            edges: [Lanes::ZERO; 3],
        }
    }
}

impl<'a> PacketBest<'a> {
    /// Starts without a hit before these ends.
    #[inline(always)]
    pub fn reset(&mut self, t_max: &Lanes) {
        (self.t_max, self.start) = (*t_max, *t_max);
        self.forget();
    }

    /// Forgets all hits.
    pub fn forget(&mut self) {
        (self.found, self.pending) = (Rays::NONE, Rays::NONE);
    }

    #[inline(always)]
    pub fn set(&mut self, ray: usize, hit: Hit) {
        self.exact[ray] = hit;
        self.t_max.set(ray, hit.t);
        self.start.set(ray, hit.t);
        self.pending = self.pending.without(Rays::one(ray));
        self.found = self.found.or(Rays::one(ray));
    }

    /// Nothing behind these can be the nearest hits.
    #[inline(always)]
    pub fn ends(&self) -> &Lanes {
        &self.t_max
    }

    /// The rays of a group for which hits before `upper` are nearer than all that is known.
    #[inline(always)]
    pub fn nearer<S: Simd>(&self, simd: S, group: usize, upper: f32x8<S>) -> u32 {
        upper.simd_lt(self.start.load(simd, group)).to_bitmask() as u32
    }

    /// Some rays of a group pass through the triangle in a lane of a block, nearer than all before: [`Best::pass`].
    #[inline(always)]
    pub fn pass<S: Simd>(
        &mut self,
        simd: S,
        (block, lane): (&'a TriangleBlock, usize),
        group: usize,
        rays: u32,
        found: &Candidates<f32x8<S>>,
    ) {
        let mask = mask32x8::from_bitmask(simd, u64::from(rays));
        self.t_max.blend(group, mask, found.upper, simd);
        self.start.blend(group, mask, found.lower, simd);
        for (edges, edge) in self.edges.iter_mut().zip(found.edges) {
            edges.blend(group, mask, edge, simd);
        }
        let rays = Rays::in_group(group, rays);
        self.pending = self.pending.or(rays);
        for ray in rays.iter() {
            self.blocks[ray] = Some(block);
            self.lanes[ray] = lane as u8;
        }
    }

    /// Whether a hit at `t` is nearer than all that is known of a ray, whatever its shape.
    #[inline(always)]
    pub fn is_nearer(&self, index: usize, t: f32) -> bool {
        t < self.start.get(index)
    }

    /// Replaces a ray's hit by what `shape` answered if that is nearer.
    #[inline(always)]
    pub fn keep(&mut self, index: usize, ray: &Ray, shape: u32, answer: Option<ShapeHit>) {
        if answer.is_some() {
            let mut best = self.of_ray(index);
            best.keep(ray, shape, answer);
            self.take(index, best);
        }
    }

    /// Takes back a ray's nearest hit that may have been replaced.
    #[inline(always)]
    pub fn take(&mut self, ray: usize, best: Best<'a>) {
        match best.known() {
            Ok(hit) if hit.is_some() => self.set(ray, hit),
            Ok(_) => {}
            Err(Passed { block, lane, edges, lower, upper }) => {
                self.t_max.set(ray, upper);
                self.start.set(ray, lower);
                for (lanes, edge) in self.edges.iter_mut().zip(edges) {
                    lanes.set(ray, edge);
                }
                self.blocks[ray] = Some(block);
                self.lanes[ray] = lane as u8;
                self.pending = self.pending.or(Rays::one(ray));
            }
        }
    }

    /// A ray's nearest hit alone.
    #[inline(always)]
    pub fn of_ray(&self, index: usize) -> Best<'a> {
        let passed = self.blocks[index].filter(|_| self.pending.has(index)).map(|block| Passed {
            block,
            lane: u32::from(self.lanes[index]),
            edges: [self.edges[0].get(index), self.edges[1].get(index), self.edges[2].get(index)],
            lower: self.start.get(index),
            upper: self.t_max.get(index),
        });
        let hit = if self.found.has(index) { self.exact[index] } else { Hit::none(self.t_max.get(index)) };
        Best::pending(hit, passed)
    }

    /// The nearest hits themselves, where there are any.
    #[inline(always)]
    pub fn hits<S: Simd>(&self, simd: S, packet: &PacketLanes, hits: &mut [Option<Hit>]) {
        let known = self.found.without(self.pending);
        for ray in known.iter() {
            hits[ray] = Some(self.exact[ray]);
        }
        for (group, rays) in self.pending.groups() {
            for half in 0..GROUP / 4 {
                let rays = rays >> (4 * half) & 0b1111;
                if rays == 0 {
                    continue;
                }
                let first = GROUP * group + 4 * half;
                let found = self.four_hits(simd, packet, first, rays);
                for lane in 0..4 {
                    if rays >> lane & 1 != 0 {
                        hits[first + lane] = Some(found[lane]);
                    }
                }
            }
        }
    }

    /// [`Triangle::place`](crate::geometry::Triangle) for four rays from `first` on, those of `rays`.
    #[inline(always)]
    fn four_hits<S: Simd>(&self, simd: S, packet: &PacketLanes, first: usize, rays: u32) -> [Hit; 4] {
        let mut corners = [[[0.0; 4]; 3]; 3];
        let mut shapes = [0; 4];
        for lane in 0..4 {
            let Some(block) = self.blocks[first + lane].filter(|_| rays >> lane & 1 != 0) else { continue };
            let of_block = usize::from(self.lanes[first + lane]);
            shapes[lane] = block.shape(of_block);
            let triangle = block.triangle(of_block);
            for (corner, v) in corners.iter_mut().zip(triangle.v) {
                corner[0][lane] = f64::from(v.x);
                corner[1][lane] = f64::from(v.y);
                corner[2][lane] = f64::from(v.z);
            }
        }
        let four = |values: [f64; 4]| f64x4::load_array(simd, values);
        let vector = |v: &[[f64; 4]; 3]| [four(v[0]), four(v[1]), four(v[2])];
        let [a, b, c] = [vector(&corners[0]), vector(&corners[1]), vector(&corners[2])];
        let (origin, direction) =
            (packet.origin_in_double(simd, first), packet.direction_in_double(simd, first));
        let normal = cross(minus(b, a), minus(c, a));
        let t = dot(normal, minus(a, origin)) / dot(normal, direction);
        let [e0, e1, e2] = &self.edges;
        let e = [e0.in_double(simd, first), e1.in_double(simd, first), e2.in_double(simd, first)];
        let det = e[0] + e[1] + e[2];
        let (t, u, v) = (t.to_array(), (e[1] / det).to_array(), (e[2] / det).to_array());
        let mut hits = [Hit::none(0.0); 4];
        for lane in 0..4 {
            hits[lane] = Hit { t: t[lane] as f32, shape: shapes[lane], u: u[lane] as f32, v: v[lane] as f32 };
        }
        hits
    }
}

/// The arithmetic of `glam`, lane by lane.
#[inline(always)]
fn minus<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> [f64x4<S>; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> [f64x4<S>; 3] {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}
