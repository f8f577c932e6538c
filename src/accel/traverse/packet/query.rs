//! What a packet asks: the nearest hits, or any. And what lies in the leaves, as a packet sees it.

use crate::accel::simd::Instructions;
use crate::accel::tree::Walked;

use super::super::boxes::BoxLanes;
use super::super::{LeafIntersector, RayCounters, Start, walk_below};
use super::counters::PacketProbe;
use super::lanes::PacketLanes;
use super::rays::{Lanes, Rays};

/// What lies in the leaves, tested against the rays of a packet.
pub trait PacketLeaves: LeafIntersector {
    /// What is known of the nearest hit of each ray.
    type Bests<'a>
    where
        Self: 'a;

    /// Nothing behind these can be the nearest hits.
    fn ends<'b>(bests: &'b Self::Bests<'_>) -> &'b Lanes;

    /// What is known for one of the rays.
    fn take_out<'a>(bests: &Self::Bests<'a>, ray: usize) -> Self::Best<'a>
    where
        Self: 'a;

    /// Puts it back when the ray has walked alone for a while.
    fn put_back<'a>(bests: &mut Self::Bests<'a>, ray: usize, best: Self::Best<'a>)
    where
        Self: 'a;

    /// Tests every shape of the leaf against `rays` and keeps the nearest hits, as [`LeafIntersector::intersect`] does.
    fn intersect_packet<'a, S: Instructions>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        packet: &PacketLanes,
        rays: Rays,
        bests: &mut Self::Bests<'a>,
        probe: &mut PacketProbe,
    );

    /// Which of `rays` hit a shape of the leaf that `blocks` says stops them.
    fn occluded_packet<S: Instructions>(
        &self,
        simd: S,
        leaf_idx: u32,
        packet: &PacketLanes,
        rays: Rays,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut PacketProbe,
    ) -> Rays;
}

/// What a ray needs that goes on alone.
#[derive(Clone, Debug, Default)]
pub(super) struct Alone {
    pub counters: RayCounters,
    full: Vec<super::super::Waiting>,
}

/// What a packet is after.
pub(super) trait Query<'l, L: PacketLeaves> {
    fn t_max(&self) -> &Lanes;

    /// Tests a leaf; answers which rays are done.
    fn leaf<S: Instructions>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        packet: &PacketLanes,
        rays: Rays,
        probe: &mut PacketProbe,
    ) -> Rays;

    /// Walks on with one ray from a node that it enters; answers whether it is done.
    fn alone<S: Instructions, const N: usize, T: BoxLanes<S, N>>(
        &mut self,
        simd: S,
        bvh: Walked<T>,
        start: Start,
        leaves: &'l L,
        ray: usize,
        alone: &mut Alone,
    ) -> bool;
}

pub(super) struct Nearest<'b, 'l, L: PacketLeaves + 'l> {
    pub bests: &'b mut L::Bests<'l>,
}

impl<'l, L: PacketLeaves> Query<'l, L> for Nearest<'_, 'l, L> {
    #[inline(always)]
    fn t_max(&self) -> &Lanes {
        L::ends(self.bests)
    }

    #[inline(always)]
    fn leaf<S: Instructions>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        packet: &PacketLanes,
        rays: Rays,
        probe: &mut PacketProbe,
    ) -> Rays {
        leaves.intersect_packet(simd, leaf_idx, packet, rays, self.bests, probe);
        Rays::NONE
    }

    #[inline(always)]
    fn alone<S: Instructions, const N: usize, T: BoxLanes<S, N>>(
        &mut self,
        simd: S,
        bvh: Walked<T>,
        start: Start,
        leaves: &'l L,
        ray: usize,
        alone: &mut Alone,
    ) -> bool {
        let mut best = L::take_out(self.bests, ray);
        let mut query = super::super::Nearest::<L> { best: &mut best };
        walk_below(simd, bvh, start, leaves, &mut query, &mut alone.counters, &mut alone.full);
        L::put_back(self.bests, ray, best);
        false
    }
}

pub(super) struct Any<'a, F> {
    pub t_max: Lanes,
    pub blocks: &'a F,
    pub stopped: Rays,
}

impl<'l, L: PacketLeaves, F: Fn(u32) -> bool> Query<'l, L> for Any<'_, F> {
    #[inline(always)]
    fn t_max(&self) -> &Lanes {
        &self.t_max
    }

    #[inline(always)]
    fn leaf<S: Instructions>(
        &mut self,
        simd: S,
        leaf_idx: u32,
        leaves: &'l L,
        packet: &PacketLanes,
        rays: Rays,
        probe: &mut PacketProbe,
    ) -> Rays {
        let stopped = leaves.occluded_packet(simd, leaf_idx, packet, rays, self.blocks, probe);
        self.stopped = self.stopped.or(stopped);
        stopped
    }

    #[inline(always)]
    fn alone<S: Instructions, const N: usize, T: BoxLanes<S, N>>(
        &mut self,
        simd: S,
        bvh: Walked<T>,
        start: Start,
        leaves: &'l L,
        ray: usize,
        alone: &mut Alone,
    ) -> bool {
        let mut query = super::super::Any { t_max: self.t_max.get(ray), blocks: self.blocks, found: None };
        walk_below(simd, bvh, start, leaves, &mut query, &mut alone.counters, &mut alone.full);
        if query.found.is_some() {
            self.stopped = self.stopped.or(Rays::one(ray));
        }
        query.found.is_some()
    }
}
