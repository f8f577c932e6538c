//! What each ray of a packet meets, counted for many rays at once.

use super::super::RayCounters;
use super::rays::{GROUP, Rays};

/// A counter of each ray, as planes of bits: one is added to many rays by a few operations.
#[derive(Clone, Debug)]
struct Planes([u64; u32::BITS as usize]);

impl Planes {
    #[inline(always)]
    fn add(&mut self, rays: Rays, mut count: u32) {
        let mut first = 0;
        while count != 0 {
            if count & 1 != 0 {
                let mut carry = rays.0;
                for plane in &mut self.0[first..] {
                    let both = *plane & carry;
                    *plane ^= carry;
                    carry = both;
                    if carry == 0 {
                        break;
                    }
                }
            }
            count >>= 1;
            first += 1;
        }
    }

    /// The bits number 8 `byte` to 8 `byte` + 7 of the counts of eight rays, a byte each.
    #[inline(always)]
    fn bytes(&self, byte: usize, group: usize) -> [u8; GROUP] {
        let mut of_rays = 0;
        for (bit, &plane) in self.byte(byte).iter().enumerate().filter(|(_, plane)| **plane != 0) {
            of_rays |= bits_in_bytes((plane >> (GROUP * group)) as u8) << bit;
        }
        of_rays.to_le_bytes()
    }

    #[inline(always)]
    fn byte(&self, byte: usize) -> &[u64; u8::BITS as usize] {
        &self.0.as_chunks().0[byte]
    }
}

/// Eight bytes of 0 or 1, the lowest for the lowest bit.
#[inline(always)]
fn bits_in_bytes(bits: u8) -> u64 {
    let each = u64::from_ne_bytes([1; 8]);
    // Each byte keeps its own bit; what is not 0 then reaches the byte's highest one.
    let own = (u64::from(bits) * each) & 0x8040_2010_0804_0201;
    ((own + 0x7f * each) >> 7) & each
}

/// [`RayCounters`] of each ray of a packet.
#[derive(Clone, Debug)]
pub struct PacketCounters {
    inner_visits: Planes,
    leaf_visits: Planes,
    box_tests: Planes,
    shape_tests: Planes,
}

impl Default for PacketCounters {
    fn default() -> Self {
        let none = Planes([0; _]);
        Self {
            inner_visits: none.clone(),
            leaf_visits: none.clone(),
            box_tests: none.clone(),
            shape_tests: none,
        }
    }
}

impl PacketCounters {
    /// Adds the counters of the first rays.
    pub fn get(&self, counters: &mut [RayCounters]) {
        let Self { inner_visits, leaf_visits, box_tests, shape_tests } = self;
        let planes = [inner_visits, leaf_visits, box_tests, shape_tests];
        for byte in 0..size_of::<u32>() {
            if planes.iter().all(|planes| *planes.byte(byte) == [0; _]) {
                continue;
            }
            for (group, counters) in counters.chunks_mut(GROUP).enumerate() {
                let counts = planes.map(|planes| planes.bytes(byte, group));
                for (ray, counters) in counters.iter_mut().enumerate() {
                    let [inner_visits, leaf_visits, box_tests, shape_tests] =
                        counts.map(|counts| u64::from(counts[ray]) << (u8::BITS as usize * byte));
                    counters.inner_visits += inner_visits;
                    counters.leaf_visits += leaf_visits;
                    counters.box_tests += box_tests;
                    counters.shape_tests += shape_tests;
                }
            }
        }
    }
}

/// Counts, or does not: decided when it runs, which costs a packet little.
pub struct PacketProbe<'a>(pub Option<&'a mut PacketCounters>);

impl PacketProbe<'_> {
    #[inline(always)]
    pub(super) fn counts(&self) -> bool {
        self.0.is_some()
    }

    #[inline(always)]
    pub(super) fn inner_visited(&mut self, rays: Rays, box_tests: u32) {
        if let Some(counters) = &mut self.0 {
            counters.inner_visits.add(rays, 1);
            counters.box_tests.add(rays, box_tests);
        }
    }

    /// Some rays met all of that.
    pub(super) fn counted(&mut self, rays: Rays, counted: &RayCounters) {
        if let Some(counters) = &mut self.0 {
            counters.inner_visits.add(rays, counted.inner_visits as u32);
            counters.leaf_visits.add(rays, counted.leaf_visits as u32);
            counters.box_tests.add(rays, counted.box_tests as u32);
            counters.shape_tests.add(rays, counted.shape_tests as u32);
        }
    }

    #[inline(always)]
    pub(super) fn leaf_visited(&mut self, rays: Rays) {
        if let Some(counters) = &mut self.0 {
            counters.leaf_visits.add(rays, 1);
        }
    }

    /// Each of the rays tests `count` shapes.
    #[inline(always)]
    pub fn shapes_tested(&mut self, rays: Rays, count: u32) {
        if let Some(counters) = &mut self.0 {
            counters.shape_tests.add(rays, count);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::super::rays::PACKET;
    use super::*;

    #[test]
    fn planes_count_as_numbers_do() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let mut counters = PacketCounters::default();
        let mut expected = [RayCounters::default(); PACKET];
        for i in 0..2000 {
            let (rays, tests) = (Rays(rng.random()), rng.random_range(0..100_000));
            let mut probe = PacketProbe(Some(&mut counters));
            probe.inner_visited(rays, i % 9);
            probe.leaf_visited(rays);
            probe.shapes_tested(rays, tests);
            for ray in rays.iter() {
                let of_ray = &mut expected[ray];
                of_ray.inner_visits += 1;
                of_ray.box_tests += u64::from(i % 9);
                of_ray.leaf_visits += 1;
                of_ray.shape_tests += u64::from(tests);
            }
        }
        assert!(expected.iter().any(|of_ray| of_ray.shape_tests > 1 << 24), "all bytes are asked");
        for count in [PACKET, 11] {
            let mut counts = vec![RayCounters::default(); count];
            counters.get(&mut counts);
            assert_eq!(counts, expected[..count]);
        }
    }
}
