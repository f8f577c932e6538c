//! The leaves against the rays of a packet: eight rays at once against each triangle, with the arithmetic and the answers
//! of one ray against a [`TriangleBlock`].

use fearless_simd::{Simd, f32x8, f64x4, mask32x8, prelude::*};

use super::best::Best;
use super::block::{Bounded, Passed, TriangleBlock, bounded};
use super::store::{PrimStore, Stored};
use crate::accel::simd::Instructions;
use crate::accel::traverse::packet::{GROUP, Lanes, PACKET, PacketLanes, PacketLeaves, PacketProbe, Rays};
use crate::geometry::quad::{EDGE, FlatQuad};
use crate::geometry::triangle::{edges, shear};
use crate::geometry::{Aabb, Cuboid, Hit, PreparedRay, Quad, Ray, ShapeHit, Span, Sphere, Torus};

/// The nearest hit of each ray so far. As in [`Best`], of triangles that are hit for sure only bounds of the distance are
/// kept.
#[derive(Debug)]
pub struct PacketBest<'a> {
    /// Nothing behind these can be the nearest hits.
    t_max: Lanes,
    /// A hit behind the end of the nearest one's bounds cannot replace it, one before this start does.
    start: Lanes,
    /// The rays with a hit that is known to the last bit, and the hits.
    found: u64,
    exact: [Hit; PACKET],
    /// Where a hit is pending: its block, lane and edge functions.
    pending: u64,
    blocks: [Option<&'a TriangleBlock>; PACKET],
    lanes: [u8; PACKET],
    edges: [Lanes; 3],
}

impl Default for PacketBest<'_> {
    fn default() -> Self {
        Self {
            t_max: Lanes::ZERO,
            start: Lanes::ZERO,
            found: 0,
            exact: [Hit::none(0.0); PACKET],
            pending: 0,
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
        (self.found, self.pending) = (0, 0);
    }

    #[inline(always)]
    pub fn set(&mut self, ray: usize, hit: Hit) {
        self.exact[ray] = hit;
        self.t_max.set(ray, hit.t);
        self.start.set(ray, hit.t);
        self.pending &= !(1 << ray);
        self.found |= 1 << ray;
    }

    /// Whether a hit at `t` is nearer than all that is known of a ray, whatever its shape.
    #[inline(always)]
    fn is_behind(&self, index: usize, t: f32) -> bool {
        t < self.start.get(index)
    }

    /// Replaces a ray's hit by what `shape` answered if that is nearer.
    #[inline(always)]
    fn keep(&mut self, index: usize, ray: &Ray, shape: u32, answer: Option<ShapeHit>) {
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
                self.pending |= 1 << ray;
            }
        }
    }

    /// A ray's nearest hit alone.
    #[inline(always)]
    pub fn of_ray(&self, index: usize) -> Best<'a> {
        let passed = self.blocks[index].filter(|_| self.pending >> index & 1 != 0).map(|block| Passed {
            block,
            lane: u32::from(self.lanes[index]),
            edges: [self.edges[0].get(index), self.edges[1].get(index), self.edges[2].get(index)],
            lower: self.start.get(index),
            upper: self.t_max.get(index),
        });
        let hit =
            if self.found >> index & 1 != 0 { self.exact[index] } else { Hit::none(self.t_max.get(index)) };
        Best::pending(hit, passed)
    }

    /// The nearest hits themselves, where there are any.
    #[inline(always)]
    pub fn hits<S: Simd>(&self, simd: S, packet: &PacketLanes, hits: &mut [Option<Hit>]) {
        let known = Rays(self.found & !self.pending);
        for ray in known.iter() {
            hits[ray] = Some(self.exact[ray]);
        }
        for (group, rays) in Rays(self.pending).groups() {
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
        let wide = |lanes: &Lanes| {
            let [a, b, c, d] = lanes.four(first);
            four([f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
        };
        let vector = |v: &[[f64; 4]; 3]| [four(v[0]), four(v[1]), four(v[2])];
        let [a, b, c] = [vector(&corners[0]), vector(&corners[1]), vector(&corners[2])];
        let [origin, direction] = [packet.origins(), packet.directions()];
        let origin = [wide(&origin[0]), wide(&origin[1]), wide(&origin[2])];
        let direction = [wide(&direction[0]), wide(&direction[1]), wide(&direction[2])];
        let normal = cross(minus(b, a), minus(c, a));
        let t = dot(normal, minus(a, origin)) / dot(normal, direction);
        let e = [wide(&self.edges[0]), wide(&self.edges[1]), wide(&self.edges[2])];
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

impl PrimStore {
    /// Every triangle of a block against the rays.
    #[inline(always)]
    fn block_nearest<'a, S: Simd>(
        simd: S,
        block: &'a TriangleBlock,
        packet: &PacketLanes,
        rays: Rays,
        best: &mut PacketBest<'a>,
        probe: &mut PacketProbe,
    ) {
        probe.shapes_tested(rays, block.count());
        for lane in 0..block.count() as usize {
            let corners = corners(simd, block, lane, packet);
            for (group, asked) in rays.groups() {
                let t_max = best.t_max.load(simd, group);
                let Some(found) = candidates(simd, &corners, packet, group, asked, t_max) else { continue };
                let Candidates { edges, lanes, inside, lower, upper, .. } = found;
                let nearer = inside & upper.simd_lt(best.start.load(simd, group));
                let decided = nearer.to_bitmask() as u32 & lanes;
                let nearer = mask32x8::from_bitmask(simd, u64::from(decided));
                if decided != 0 {
                    best.t_max.blend(group, nearer, upper, simd);
                    best.start.blend(group, nearer, lower, simd);
                    for (best, edge) in best.edges.iter_mut().zip(edges) {
                        best.blend(group, nearer, edge, simd);
                    }
                    let decided = Rays::in_group(group, decided);
                    best.pending |= decided.0;
                    for ray in decided.iter() {
                        best.blocks[ray] = Some(block);
                        best.lanes[ray] = lane as u8;
                    }
                }
                for ray in Rays::in_group(group, lanes & !decided).iter() {
                    let prepared = packet.prepared(ray);
                    let t_max = best.t_max.get(ray);
                    let answer = block.triangle(lane).intersect_within(&prepared, prepared.ray.t_min, t_max);
                    best.keep(ray, &prepared.ray, block.shape(lane), answer);
                }
            }
        }
    }

    /// What a leaf holds beside its first block.
    #[inline(always)]
    fn rest_nearest<'a, S: Simd>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        packet: &PacketLanes,
        rays: Rays,
        best: &mut PacketBest<'a>,
        probe: &mut PacketProbe,
    ) {
        for block in self.further_blocks(leaf_idx) {
            Self::block_nearest(simd, block, packet, rays, best, probe);
        }
        let others = self.others(leaf_idx);
        singles_nearest(simd, others.spheres, Sphere::intersect_in, packet, rays, best, probe);
        singles_nearest(simd, others.cuboids, Cuboid::intersect_in, packet, rays, best, probe);
        quads_nearest(simd, others.quads, packet, rays, best, probe);
        singles_nearest(simd, others.tori, Torus::intersect_in, packet, rays, best, probe);
    }

    /// Adds the rays to `stopped` that what a leaf holds beside its first block stops.
    #[inline(always)]
    fn rest_stops<S: Simd>(
        &self,
        simd: S,
        leaf_idx: u32,
        (packet, rays): (&PacketLanes, Rays),
        stopped: &mut Rays,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut PacketProbe,
    ) {
        for block in self.further_blocks(leaf_idx) {
            let left = rays.without(*stopped);
            if left.is_empty() {
                return;
            }
            *stopped = stopped.or(Self::block_stops(simd, block, packet, left, blocks, probe));
        }
        let others = self.others(leaf_idx);
        singles_stop(simd, others.spheres, Sphere::intersect_in, (packet, rays), stopped, blocks, probe);
        singles_stop(simd, others.cuboids, Cuboid::intersect_in, (packet, rays), stopped, blocks, probe);
        quads_stop(simd, others.quads, (packet, rays), stopped, blocks, probe);
        singles_stop(simd, others.tori, Torus::intersect_in, (packet, rays), stopped, blocks, probe);
    }

    /// Which rays a triangle of a block stops.
    #[inline(always)]
    fn block_stops<S: Simd>(
        simd: S,
        block: &TriangleBlock,
        packet: &PacketLanes,
        mut rays: Rays,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut PacketProbe,
    ) -> Rays {
        probe.shapes_tested(rays, block.count());
        let mut stopped = 0;
        for lane in 0..block.count() as usize {
            if !blocks(block.shape(lane)) {
                continue;
            }
            let corners = corners(simd, block, lane, packet);
            for (group, asked) in rays.groups() {
                let t_max = packet.t_max().load(simd, group);
                let Some(found) = candidates(simd, &corners, packet, group, asked, t_max) else { continue };
                let sure = found.sure.to_bitmask() as u32 & found.lanes;
                stopped |= Rays::in_group(group, sure).0;
                for ray in Rays::in_group(group, found.lanes & !sure).iter() {
                    if block.triangle(lane).intersect(&packet.prepared(ray)).is_some() {
                        stopped |= 1 << ray;
                    }
                }
            }
            rays = Rays(rays.0 & !stopped);
        }
        Rays(stopped)
    }
}

/// The corners of a triangle in the packet's permuted axes, the same for all rays.
#[inline(always)]
fn corners<S: Simd>(simd: S, block: &TriangleBlock, lane: usize, packet: &PacketLanes) -> [[f32x8<S>; 3]; 3] {
    let axes = packet.axes();
    let corner = |corner: usize| {
        let c = |axis: usize| f32x8::simd_from(simd, block.coordinate(lane, corner, axes[axis]));
        [c(0), c(1), c(2)]
    };
    [corner(0), corner(1), corner(2)]
}

/// The rays of a group that may hit a triangle, as [`super::block::Candidates`] tells of the triangles of a block.
struct Candidates<S: Simd> {
    edges: [f32x8<S>; 3],
    lanes: u32,
    sure: mask32x8<S>,
    inside: mask32x8<S>,
    lower: f32x8<S>,
    upper: f32x8<S>,
}

#[inline(always)]
fn candidates<S: Simd>(
    simd: S,
    corners: &[[f32x8<S>; 3]; 3],
    packet: &PacketLanes,
    group: usize,
    asked: u32,
    t_max: f32x8<S>,
) -> Option<Candidates<S>> {
    let origin = packet.permuted_origin(simd, group);
    let [shear_x, shear_y, inv_depth] = packet.shear(simd, group);
    let sheared = shear(*corners, origin, [shear_x, shear_y]);
    let edges = edges(sheared);
    let zero = f32x8::simd_from(simd, 0.0);
    let left = edges[0].simd_ge(zero) & edges[1].simd_ge(zero) & edges[2].simd_ge(zero);
    let right = edges[0].simd_le(zero) & edges[1].simd_le(zero) & edges[2].simd_le(zero);
    let lanes = (left | right).to_bitmask() as u32 & asked;
    if lanes == 0 {
        return None;
    }
    let [a, b, c] = corners;
    let depths = [a[2] - origin[2], b[2] - origin[2], c[2] - origin[2]];
    let Bounded { known, inside, lower, upper } = bounded(simd, sheared, edges, depths, inv_depth);
    let t_min = packet.t_min(simd, group);
    // A NaN says nothing.
    let outside = known & (upper.simd_lt(t_min) | lower.simd_gt(t_max));
    let inside = inside & lower.simd_gt(t_min);
    let sure = inside & upper.simd_lt(t_max);
    let lanes = lanes & !(outside.to_bitmask() as u32);
    Some(Candidates { edges, lanes, sure, inside, lower, upper })
}

/// Which rays a shape's own box does not rule out.
#[inline(always)]
fn in_span<S: Simd>(simd: S, bounds: &Aabb, packet: &PacketLanes, rays: Rays, t_max: &Lanes) -> Rays {
    rays.that(
        #[inline(always)]
        |group| {
            let [enter, leave] = packet.span(simd, group, bounds);
            let asked = enter.simd_le(t_max.load(simd, group)) & leave.simd_ge(packet.t_min(simd, group));
            (enter.simd_le(leave) & asked).to_bitmask() as u32
        },
    )
}

/// The shapes of one kind against the rays, whose own test is that of one ray.
#[inline(always)]
fn singles_nearest<S: Simd, G>(
    simd: S,
    stored: &[Stored<G>],
    test: impl Fn(&G, &PreparedRay, &Span) -> Option<ShapeHit>,
    packet: &PacketLanes,
    rays: Rays,
    best: &mut PacketBest,
    probe: &mut PacketProbe,
) {
    for Stored { bounds, geometry, shape } in stored {
        probe.shapes_tested(rays, 1);
        for index in in_span(simd, bounds, packet, rays, &best.t_max).iter() {
            let ray = packet.prepared(index);
            if let Some(span) = Span::new(&ray, bounds, ray.ray.t_min, best.t_max.get(index)) {
                best.keep(index, &ray.ray, *shape, test(geometry, &ray, &span));
            }
        }
    }
}

/// Adds the rays to `stopped` that a shape of one kind stops.
#[inline(always)]
fn singles_stop<S: Simd, G>(
    simd: S,
    stored: &[Stored<G>],
    test: impl Fn(&G, &PreparedRay, &Span) -> Option<ShapeHit>,
    (packet, rays): (&PacketLanes, Rays),
    stopped: &mut Rays,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut PacketProbe,
) {
    for Stored { bounds, geometry, shape } in stored {
        let left = rays.without(*stopped);
        if left.is_empty() || !blocks(*shape) {
            continue;
        }
        probe.shapes_tested(left, 1);
        for index in in_span(simd, bounds, packet, left, packet.t_max()).iter() {
            let ray = packet.prepared(index);
            let span = Span::new(&ray, bounds, ray.ray.t_min, ray.ray.t_max);
            if span.and_then(|span| test(geometry, &ray, &span)).is_some() {
                *stopped = stopped.or(Rays::one(index));
            }
        }
    }
}

/// A quad's hits by a group of rays.
struct QuadHits<S: Simd> {
    rays: u32,
    t: f32x8<S>,
    u: [f64; GROUP],
    v: [f64; GROUP],
}

/// The arithmetic of [`Quad::intersect_in`] and [`Span::place`].
#[inline(always)]
fn quad_hits<S: Simd>(
    simd: S,
    quad: &FlatQuad,
    bounds: &Aabb,
    packet: &PacketLanes,
    group: usize,
    asked: u32,
    t_max: f32x8<S>,
) -> Option<QuadHits<S>> {
    let t_min = packet.t_min(simd, group);
    let [enter, leave] = packet.span(simd, group, bounds);
    let inside = enter.simd_le(leave) & enter.simd_le(t_max) & leave.simd_ge(t_min);
    let mut rays = inside.to_bitmask() as u32 & asked;
    if rays == 0 {
        return None;
    }
    let (mut t, mut u, mut v) = ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
    let mut on_quad = 0;
    for half in 0..GROUP / 4 {
        let first = GROUP * group + 4 * half;
        let [origin, direction] = [packet.origins(), packet.directions()];
        let wide = |lanes: &Lanes| {
            let [a, b, c, d] = lanes.four(first);
            f64x4::load_array(simd, [f64::from(a), f64::from(b), f64::from(c), f64::from(d)])
        };
        let origin = [wide(&origin[0]), wide(&origin[1]), wide(&origin[2])];
        let direction = [wide(&direction[0]), wide(&direction[1]), wide(&direction[2])];
        let [of_t, of_u, of_v] = quad.meet(origin, direction);
        let (low, high) = (f64x4::simd_from(simd, *EDGE.start()), f64x4::simd_from(simd, *EDGE.end()));
        let within = of_u.simd_ge(low) & of_u.simd_le(high) & of_v.simd_ge(low) & of_v.simd_le(high);
        on_quad |= (within.to_bitmask() as u32) << (4 * half);
        let (of_t, of_u, of_v) = (of_t.to_array(), of_u.to_array(), of_v.to_array());
        for lane in 0..4 {
            t[4 * half + lane] = of_t[lane] as f32;
            u[4 * half + lane] = of_u[lane];
            v[4 * half + lane] = of_v[lane];
        }
    }
    let t = f32x8::load_array(simd, t);
    let t = t.simd_lt(enter).select(enter, t.simd_gt(leave).select(leave, t));
    rays &= on_quad & (t.simd_ge(t_min) & t.simd_le(t_max)).to_bitmask() as u32;
    (rays != 0).then_some(QuadHits { rays, t, u, v })
}

#[inline(always)]
fn quads_nearest<S: Simd>(
    simd: S,
    stored: &[Stored<Quad>],
    packet: &PacketLanes,
    rays: Rays,
    best: &mut PacketBest,
    probe: &mut PacketProbe,
) {
    for Stored { bounds, geometry, shape } in stored {
        probe.shapes_tested(rays, 1);
        let quad = geometry.flat();
        for (group, asked) in rays.groups() {
            let t_max = best.t_max.load(simd, group);
            let Some(hits) = quad_hits(simd, &quad, bounds, packet, group, asked, t_max) else { continue };
            let t = hits.t.to_array();
            for index in Rays::in_group(group, hits.rays).iter() {
                let lane = index % GROUP;
                let hit = Quad::hit_at(t[lane], hits.u[lane], hits.v[lane]);
                if best.is_behind(index, hit.t) {
                    best.set(index, Hit { t: hit.t, shape: *shape, u: hit.u, v: hit.v });
                } else {
                    best.keep(index, &packet.ray(index), *shape, Some(hit));
                }
            }
        }
    }
}

#[inline(always)]
fn quads_stop<S: Simd>(
    simd: S,
    stored: &[Stored<Quad>],
    (packet, rays): (&PacketLanes, Rays),
    stopped: &mut Rays,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut PacketProbe,
) {
    for Stored { bounds, geometry, shape } in stored {
        let left = rays.without(*stopped);
        if left.is_empty() || !blocks(*shape) {
            continue;
        }
        probe.shapes_tested(left, 1);
        let quad = geometry.flat();
        for (group, asked) in left.groups() {
            let t_max = packet.t_max().load(simd, group);
            if let Some(hits) = quad_hits(simd, &quad, bounds, packet, group, asked, t_max) {
                *stopped = stopped.or(Rays::in_group(group, hits.rays));
            }
        }
    }
}

impl PacketLeaves for PrimStore {
    type Bests<'a>
        = PacketBest<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn ends<'b>(bests: &'b PacketBest<'_>) -> &'b Lanes {
        &bests.t_max
    }

    #[inline(always)]
    fn take_out<'a>(bests: &PacketBest<'a>, ray: usize) -> Best<'a>
    where
        Self: 'a,
    {
        bests.of_ray(ray)
    }

    #[inline(always)]
    fn put_back<'a>(bests: &mut PacketBest<'a>, ray: usize, best: Best<'a>)
    where
        Self: 'a,
    {
        bests.take(ray, best);
    }

    #[inline(always)]
    fn intersect_packet<'a, S: Instructions>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        packet: &PacketLanes,
        rays: Rays,
        best: &mut PacketBest<'a>,
        probe: &mut PacketProbe,
    ) {
        let block = self.block(leaf_idx);
        Self::block_nearest(simd, block, packet, rays, best, probe);
        if block.goes_on() {
            simd.apart(
                #[inline(always)]
                || self.rest_nearest(simd, leaf_idx, packet, rays, best, probe),
            );
        }
    }

    #[inline(always)]
    fn occluded_packet<S: Instructions>(
        &self,
        simd: S,
        leaf_idx: u32,
        packet: &PacketLanes,
        rays: Rays,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut PacketProbe,
    ) -> Rays {
        let block = self.block(leaf_idx);
        let mut stopped = Self::block_stops(simd, block, packet, rays, blocks, probe);
        if block.goes_on() {
            simd.apart(
                #[inline(always)]
                || self.rest_stops(simd, leaf_idx, (packet, rays), &mut stopped, blocks, probe),
            );
        }
        stopped
    }
}
