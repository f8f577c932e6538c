//! A block's triangles against the rays of a packet: eight rays at once against each, with the arithmetic and the answers of
//! one ray against the block.

use fearless_simd::{Simd, f32x8, prelude::*};

use super::super::block::{Candidates, TriangleBlock};
use super::best::PacketBest;
use crate::accel::traverse::packet::{PacketLanes, PacketProbe, Rays};

/// Every triangle of a block against the rays.
#[inline(always)]
pub fn block_nearest<'a, S: Simd>(
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
            let t_max = best.ends().load(simd, group);
            let found = candidates(simd, &corners, packet, group, t_max);
            let lanes = found.lanes & asked;
            if lanes == 0 {
                continue;
            }
            let decided = lanes & found.inside & best.nearer(simd, group, found.upper);
            if decided != 0 {
                best.pass(simd, (block, lane), group, decided, &found);
            }
            for ray in Rays::in_group(group, lanes & !decided).iter() {
                let prepared = packet.prepared(ray);
                let t_max = best.ends().get(ray);
                let answer = block.triangle(lane).intersect_within(&prepared, prepared.ray.t_min, t_max);
                best.keep(ray, &prepared.ray, block.shape(lane), answer);
            }
        }
    }
}

/// Which rays a triangle of a block stops.
#[inline(always)]
pub fn block_stops<S: Simd>(
    simd: S,
    block: &TriangleBlock,
    packet: &PacketLanes,
    mut rays: Rays,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut PacketProbe,
) -> Rays {
    probe.shapes_tested(rays, block.count());
    let mut stopped = Rays::NONE;
    for lane in 0..block.count() as usize {
        if !blocks(block.shape(lane)) {
            continue;
        }
        let corners = corners(simd, block, lane, packet);
        for (group, asked) in rays.groups() {
            let t_max = packet.t_max().load(simd, group);
            let found = candidates(simd, &corners, packet, group, t_max);
            stopped = stopped.or(Rays::in_group(group, found.sure & asked));
            for ray in Rays::in_group(group, found.lanes & asked & !found.sure).iter() {
                if block.triangle(lane).intersect(&packet.prepared(ray)).is_some() {
                    stopped = stopped.or(Rays::one(ray));
                }
            }
        }
        rays = rays.without(stopped);
    }
    stopped
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

/// The rays of a group that may hit a triangle, and what is known of the others of the group.
#[inline(always)]
fn candidates<S: Simd>(
    simd: S,
    corners: &[[f32x8<S>; 3]; 3],
    packet: &PacketLanes,
    group: usize,
    t_max: f32x8<S>,
) -> Candidates<f32x8<S>> {
    let interval = [packet.t_min(simd, group), t_max];
    let (origin, shear) = (packet.permuted_origin(simd, group), packet.shear(simd, group));
    Candidates::new(simd, *corners, origin, shear, interval)
}
