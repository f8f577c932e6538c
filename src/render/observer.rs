//! Who looks on while an integrator traces rays: nobody, a counter, or a recorder. One walk of the ray tree for all.

use crate::accel::traverse::hits_root;
use crate::accel::{RayCounters, Tree};
use crate::geometry::Ray;

use super::views::CountKind;

/// What a ray is traced for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the eye.
    Camera,
    /// Reflected or refracted.
    Bounce,
    /// Towards a light.
    Shadow,
}

impl CountKind {
    /// Whether rays of that kind are counted.
    #[inline]
    pub fn includes(self, kind: RayKind) -> bool {
        match self {
            Self::Camera => kind == RayKind::Camera,
            Self::Bounce => kind == RayKind::Bounce,
            Self::Shadow => kind == RayKind::Shadow,
            Self::All => true,
        }
    }
}

/// Rays of one kind that were traced together.
#[derive(Clone, Copy, Debug)]
pub struct TracedRays<'a> {
    pub kind: RayKind,
    pub rays: &'a [Ray],
    /// For which of the asked pixels each was traced.
    pub pixels: &'a [u32],
    /// From whose hit each goes on: its index among the camera or bounce rays that were told of last. Without meaning for
    /// camera rays.
    pub parents: &'a [u32],
    /// What each met; empty if [`RayObserver::COUNTS`] says that nobody asks.
    pub counters: &'a [RayCounters],
}

/// Is told of every ray. `()` looks at nothing and costs nothing.
pub trait RayObserver {
    /// Whether it looks at the counters.
    const COUNTS: bool;

    /// Whether rays after the camera rays need not be traced.
    fn asks_for_camera_rays_alone(&self) -> bool {
        false
    }

    fn traced(&mut self, traced: &TracedRays);
}

impl RayObserver for () {
    const COUNTS: bool = false;

    #[inline(always)]
    fn traced(&mut self, _: &TracedRays) {}
}

/// Adds up the counters of the rays of some kinds, a pixel a sum.
#[derive(Clone, Debug)]
pub struct CountPixels {
    count: CountKind,
    sums: Vec<RayCounters>,
}

impl CountPixels {
    pub fn new(count: CountKind) -> Self {
        Self { count, sums: Vec::new() }
    }

    /// From zero on, for so many pixels.
    pub fn restart(&mut self, pixels: usize) {
        self.sums.clear();
        self.sums.resize(pixels, RayCounters::default());
    }

    pub fn counters(&self) -> &[RayCounters] {
        &self.sums
    }
}

impl RayObserver for CountPixels {
    const COUNTS: bool = true;

    fn asks_for_camera_rays_alone(&self) -> bool {
        self.count == CountKind::Camera
    }

    fn traced(&mut self, traced: &TracedRays) {
        if self.count.includes(traced.kind) {
            for (&pixel, &counters) in traced.pixels.iter().zip(traced.counters) {
                self.sums[pixel as usize] += counters;
            }
        }
    }
}

/// Adds up the counters of all rays of some kinds.
#[derive(Clone, Debug)]
pub struct CountRays<'t> {
    count: CountKind,
    /// To tell which rays miss its root.
    tree: &'t Tree,
    /// Sums over the counted rays.
    pub counters: RayCounters,
    pub ray_count: u64,
    /// Rays that miss the root's box.
    pub missed_root_count: u64,
    /// Sum of the squares of the leaf visits.
    pub squared_leaf_visits: u64,
}

impl<'t> CountRays<'t> {
    pub fn new(count: CountKind, tree: &'t Tree) -> Self {
        Self {
            count,
            tree,
            counters: RayCounters::default(),
            ray_count: 0,
            missed_root_count: 0,
            squared_leaf_visits: 0,
        }
    }

    /// The sums of both.
    #[must_use]
    pub fn merged(mut self, other: &Self) -> Self {
        self.counters += other.counters;
        self.ray_count += other.ray_count;
        self.missed_root_count += other.missed_root_count;
        self.squared_leaf_visits += other.squared_leaf_visits;
        self
    }
}

impl RayObserver for CountRays<'_> {
    const COUNTS: bool = true;

    fn asks_for_camera_rays_alone(&self) -> bool {
        self.count == CountKind::Camera
    }

    fn traced(&mut self, traced: &TracedRays) {
        if !self.count.includes(traced.kind) {
            return;
        }
        for (ray, &counters) in traced.rays.iter().zip(traced.counters) {
            self.counters += counters;
            self.ray_count += 1;
            self.missed_root_count += u64::from(!hits_root(self.tree, ray));
            self.squared_leaf_visits += counters.leaf_visits * counters.leaf_visits;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::WideBvh;
    use glam::Vec3;

    #[test]
    fn only_rays_of_the_asked_kind_are_added_up() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let tree = Tree::W2(WideBvh::empty());
        for (count, expected) in
            [(CountKind::Camera, 2), (CountKind::Bounce, 3), (CountKind::Shadow, 4), (CountKind::All, 9)]
        {
            let (mut all, mut pixels) = (CountRays::new(count, &tree), CountPixels::new(count));
            pixels.restart(2);
            for (kind, leaf_visits) in [(RayKind::Camera, 2), (RayKind::Bounce, 3), (RayKind::Shadow, 4)] {
                let counters = [RayCounters { leaf_visits, ..RayCounters::default() }];
                let traced =
                    TracedRays { kind, rays: &[ray], pixels: &[1], parents: &[0], counters: &counters };
                all.traced(&traced);
                pixels.traced(&traced);
            }
            assert_eq!(all.counters.leaf_visits, expected);
            assert_eq!(all.ray_count, if count == CountKind::All { 3 } else { 1 });
            assert_eq!(all.missed_root_count, all.ray_count);
            assert_eq!(pixels.counters().iter().map(|c| c.leaf_visits).collect::<Vec<_>>(), [0, expected]);
        }
    }
}
