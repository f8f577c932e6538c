//! Shapes that are no triangles against the rays of a packet. Their boxes are tested against eight rays at once, and so are
//! quads; the others are asked ray by ray.

use fearless_simd::{Simd, f32x8, f64x4, prelude::*};

use super::super::store::Stored;
use super::best::PacketBest;
use crate::accel::traverse::packet::{GROUP, Lanes, PacketLanes, PacketProbe, Rays};
use crate::geometry::quad::{EDGE, FlatQuad};
use crate::geometry::{Aabb, Hit, PreparedRay, Quad, ShapeHit, Span};

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
pub fn singles_nearest<S: Simd, G>(
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
        for index in in_span(simd, bounds, packet, rays, best.ends()).iter() {
            let ray = packet.prepared(index);
            if let Some(span) = Span::new(&ray, bounds, ray.ray.t_min, best.ends().get(index)) {
                best.keep(index, &ray.ray, *shape, test(geometry, &ray, &span));
            }
        }
    }
}

/// Adds the rays to `stopped` that a shape of one kind stops.
#[inline(always)]
pub fn singles_stop<S: Simd, G>(
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
        let (origin, direction) =
            (packet.origin_in_double(simd, first), packet.direction_in_double(simd, first));
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
pub fn quads_nearest<S: Simd>(
    simd: S,
    stored: &[Stored<FlatQuad>],
    packet: &PacketLanes,
    rays: Rays,
    best: &mut PacketBest,
    probe: &mut PacketProbe,
) {
    for Stored { bounds, geometry, shape } in stored {
        probe.shapes_tested(rays, 1);
        for (group, asked) in rays.groups() {
            let t_max = best.ends().load(simd, group);
            let Some(hits) = quad_hits(simd, geometry, bounds, packet, group, asked, t_max) else { continue };
            let t = hits.t.to_array();
            for index in Rays::in_group(group, hits.rays).iter() {
                let lane = index % GROUP;
                let hit = Quad::hit_at(t[lane], hits.u[lane], hits.v[lane]);
                if best.is_nearer(index, hit.t) {
                    best.set(index, Hit { t: hit.t, shape: *shape, u: hit.u, v: hit.v });
                } else {
                    best.keep(index, &packet.ray(index), *shape, Some(hit));
                }
            }
        }
    }
}

#[inline(always)]
pub fn quads_stop<S: Simd>(
    simd: S,
    stored: &[Stored<FlatQuad>],
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
        for (group, asked) in left.groups() {
            let t_max = packet.t_max().load(simd, group);
            if let Some(hits) = quad_hits(simd, geometry, bounds, packet, group, asked, t_max) {
                *stopped = stopped.or(Rays::in_group(group, hits.rays));
            }
        }
    }
}
