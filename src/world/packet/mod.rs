//! What lies in the leaves, against the rays of a packet.

mod best;
mod others;
mod triangles;

use fearless_simd::Simd;

use super::best::Best;
use super::store::PrimStore;
use crate::accel::simd::Instructions;
use crate::accel::traverse::packet::{Lanes, PacketLanes, PacketLeaves, PacketProbe, Rays};
use crate::geometry::{Cuboid, Sphere, Torus};

use others::{quads_nearest, quads_stop, singles_nearest, singles_stop};
use triangles::{block_nearest, block_stops};

pub use best::PacketBest;

impl PrimStore {
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
            block_nearest(simd, block, packet, rays, best, probe);
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
            *stopped = stopped.or(block_stops(simd, block, packet, left, blocks, probe));
        }
        let others = self.others(leaf_idx);
        singles_stop(simd, others.spheres, Sphere::intersect_in, (packet, rays), stopped, blocks, probe);
        singles_stop(simd, others.cuboids, Cuboid::intersect_in, (packet, rays), stopped, blocks, probe);
        quads_stop(simd, others.quads, (packet, rays), stopped, blocks, probe);
        singles_stop(simd, others.tori, Torus::intersect_in, (packet, rays), stopped, blocks, probe);
    }
}

impl PacketLeaves for PrimStore {
    type Bests<'a>
        = PacketBest<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn ends<'b>(bests: &'b PacketBest<'_>) -> &'b Lanes {
        bests.ends()
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
        block_nearest(simd, block, packet, rays, best, probe);
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
        let mut stopped = block_stops(simd, block, packet, rays, blocks, probe);
        if block.goes_on() {
            simd.apart(
                #[inline(always)]
                || self.rest_stops(simd, leaf_idx, (packet, rays), &mut stopped, blocks, probe),
            );
        }
        stopped
    }
}
