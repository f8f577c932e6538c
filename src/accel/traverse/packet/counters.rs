//! What each ray of a packet meets, counted for many rays at once.

use super::super::RayCounters;
use super::rays::Rays;

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

    /// Tells of the bits that are set: a ray, and what its bit counts.
    #[inline]
    fn each(&self, mut tell: impl FnMut(usize, u64)) {
        for (bit, &plane) in self.0.iter().enumerate() {
            for ray in Rays(plane).iter() {
                tell(ray, 1 << bit);
            }
        }
    }
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
        let mut of = |planes: &Planes, which: fn(&mut RayCounters) -> &mut u64| {
            planes.each(|ray, count| {
                if let Some(counters) = counters.get_mut(ray) {
                    *which(counters) += count;
                }
            });
        };
        of(&self.inner_visits, |c| &mut c.inner_visits);
        of(&self.leaf_visits, |c| &mut c.leaf_visits);
        of(&self.box_tests, |c| &mut c.box_tests);
        of(&self.shape_tests, |c| &mut c.shape_tests);
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
