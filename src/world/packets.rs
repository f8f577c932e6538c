//! Many rays at once, in packets: the answers and the counts of one ray after the other, in less time for coherent rays.

use super::World;
use super::best::Best;
use super::packet::PacketBest;
use crate::accel::RayCounters;
use crate::accel::traverse::packet::{self, PACKET, PacketCounters, PacketProbe, RayPacket, Rays};
use crate::at_level;
use crate::geometry::{Hit, Ray};
use crate::scene::ShadowRule;

/// Packets whose rays meet nodes in smaller company than this, on average, take longer than their rays one by one ...
const COMPANY: f32 = 10.0;
/// ... and so do the next ones, probably.
const PAUSE: u32 = 15;
/// The weight of the last packet in that average.
const SHARE: f32 = 0.25;

/// Traces rays in packets, best if each [`PACKET`] of them that follow each other are neighbours in a picture. Rays that
/// are not coherent are traced one by one. Keeps what it needs from packet to packet: one for a thread.
#[derive(Debug)]
pub struct Packets<'w> {
    world: &'w World,
    packet: RayPacket,
    best: Box<PacketBest<'w>>,
    hits: Vec<Option<Hit>>,
    counters: Vec<RayCounters>,
    blocked: Vec<bool>,
    /// The average company of the last packets.
    company: f32,
    /// Packets that are still traced ray by ray.
    pause: u32,
    may_pause: bool,
}

impl<'w> Packets<'w> {
    pub fn new(world: &'w World) -> Self {
        Self {
            world,
            packet: RayPacket::default(),
            best: Box::default(),
            hits: Vec::new(),
            counters: Vec::new(),
            blocked: Vec::new(),
            company: PACKET as f32,
            pause: 0,
            may_pause: true,
        }
    }

    /// Traces all rays in packets, whether that pays or not.
    #[must_use]
    pub fn without_pauses(self) -> Self {
        Self { may_pause: false, ..self }
    }

    /// What [`World::intersect`] answers for each of the rays.
    pub fn intersect(&mut self, rays: &[Ray]) -> &[Option<Hit>] {
        self.hits.clear();
        self.hits.resize(rays.len(), None);
        for (i, rays) in rays.chunks(PACKET).enumerate() {
            let alone = self.nearest(rays, PacketProbe(None));
            self.keep_hits(PACKET * i, rays.len());
            for ray in alone.iter() {
                self.hits[PACKET * i + ray] = self.world.intersect(&rays[ray], &mut ());
            }
        }
        &self.hits
    }

    /// The same, with what [`World::intersect`] counts for each ray.
    pub fn intersect_and_count(&mut self, rays: &[Ray]) -> (&[Option<Hit>], &[RayCounters]) {
        self.hits.clear();
        self.hits.resize(rays.len(), None);
        self.count_nearest(rays, true);
        (&self.hits, &self.counters)
    }

    /// What [`World::intersect`] counts for each of the rays.
    pub fn count(&mut self, rays: &[Ray]) -> &[RayCounters] {
        self.count_nearest(rays, false);
        &self.counters
    }

    fn count_nearest(&mut self, rays: &[Ray], keeps_hits: bool) {
        self.counters.clear();
        self.counters.resize(rays.len(), RayCounters::default());
        for (i, rays) in rays.chunks(PACKET).enumerate() {
            let first = PACKET * i;
            let mut counted = PacketCounters::default();
            let alone = self.nearest(rays, PacketProbe(Some(&mut counted)));
            if keeps_hits {
                self.keep_hits(first, rays.len());
            }
            let counters = &mut self.counters[first..][..rays.len()];
            counted.get(counters);
            for ray in alone.iter() {
                let hit = self.world.intersect(&rays[ray], &mut counters[ray]);
                if keeps_hits {
                    self.hits[first + ray] = hit;
                }
            }
        }
    }

    /// Whether [`World::occluded`] finds anything, for each of the rays.
    pub fn occluded(&mut self, rays: &[Ray]) -> &[bool] {
        self.any(rays, |_| true, false);
        &self.blocked
    }

    /// Whether [`World::occluded_filtered`] finds anything, for each of the rays.
    pub fn occluded_filtered(&mut self, rays: &[Ray], rule: ShadowRule) -> &[bool] {
        self.any(rays, self.world.blockers.under(rule), false);
        &self.blocked
    }

    /// The same, with what [`World::occluded_filtered`] counts for each ray.
    pub fn occluded_filtered_and_count(
        &mut self,
        rays: &[Ray],
        rule: ShadowRule,
    ) -> (&[bool], &[RayCounters]) {
        self.any(rays, self.world.blockers.under(rule), true);
        (&self.blocked, &self.counters)
    }

    /// Finds the nearest hits of one packet; answers the rays for which nothing was done.
    fn nearest(&mut self, rays: &[Ray], mut probe: PacketProbe) -> Rays {
        if self.pauses() {
            self.best.forget();
            return Rays::first(rays.len());
        }
        let World { tree, store, simd, scene, .. } = self.world;
        self.packet.take(*simd, tree, rays);
        self.best.reset(self.packet.lanes().t_max());
        if scene.unbounded().next().is_some() {
            for (i, ray) in rays.iter().enumerate() {
                let mut outside = Best::new(Hit::none(ray.last()));
                self.world.outside_nearest(ray, |_| ray.t_min, &mut outside);
                self.best.take(i, outside);
            }
        }
        let alone = packet::intersect(*simd, tree, store, &mut self.packet, &mut self.best, &mut probe);
        self.look_at_company();
        alone
    }

    /// Writes down the hits of the last packet, `count` rays from `first` on.
    fn keep_hits(&mut self, first: usize, count: usize) {
        let (lanes, hits) = (self.packet.lanes(), &mut self.hits[first..][..count]);
        at_level!(self.world.simd, simd => self.best.hits(simd, lanes, hits));
    }

    fn any(&mut self, rays: &[Ray], blocks: impl Fn(u32) -> bool, counts: bool) {
        self.blocked.clear();
        self.blocked.resize(rays.len(), false);
        self.counters.clear();
        self.counters.resize(if counts { rays.len() } else { 0 }, RayCounters::default());
        for (i, rays) in rays.chunks(PACKET).enumerate() {
            let first = PACKET * i;
            let mut alone = Rays::first(rays.len());
            if !self.pauses() {
                let mut counted = counts.then(PacketCounters::default);
                let stopped;
                (stopped, alone) = self.any_of_packet(rays, &blocks, PacketProbe(counted.as_mut()));
                for ray in stopped.iter() {
                    self.blocked[first + ray] = true;
                }
                if let Some(counted) = counted {
                    counted.get(&mut self.counters[first..][..rays.len()]);
                }
                self.look_at_company();
            }
            for ray in alone.iter() {
                let blocker = match self.counters.get_mut(first + ray) {
                    Some(counters) => self.world.any(&rays[ray], &blocks, counters),
                    None => self.world.any(&rays[ray], &blocks, &mut ()),
                };
                self.blocked[first + ray] = blocker.is_some();
            }
        }
    }

    /// Which rays of one packet are stopped, and for which nothing was done.
    fn any_of_packet(
        &mut self,
        rays: &[Ray],
        blocks: &impl Fn(u32) -> bool,
        mut probe: PacketProbe,
    ) -> (Rays, Rays) {
        let World { tree, store, simd, scene, .. } = self.world;
        let mut outside = Rays::NONE;
        if scene.unbounded().next().is_some() {
            for (i, ray) in rays.iter().enumerate() {
                if self.world.outside_stops(ray, blocks).is_some() {
                    outside = outside.or(Rays::one(i));
                }
            }
        }
        self.packet.take(*simd, tree, rays);
        let asked = Rays::first(rays.len()).without(outside);
        let (stopped, alone) =
            packet::occluded(*simd, tree, store, asked, &mut self.packet, blocks, &mut probe);
        (stopped.or(outside), alone)
    }

    /// Whether the next packet is traced ray by ray, because its predecessor's rays were not coherent.
    fn pauses(&mut self) -> bool {
        let pauses = self.pause > 0;
        self.pause = self.pause.saturating_sub(1);
        pauses
    }

    fn look_at_company(&mut self) {
        if let Some(company) = self.packet.company() {
            self.company += SHARE * (company - self.company);
            if self.company < COMPANY && self.may_pause {
                self.pause = PAUSE;
            }
        }
    }
}
