//! Who looks on while an integrator traces rays: nobody, a counter, or a recorder. One walk of the ray tree for all.

use crate::accel::traverse::hits_root;
use crate::accel::{Probe, RayCounters, Tree};
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

/// Is told of every ray, and gives the probe that looks on while it walks the tree. `()` does nothing and costs nothing.
pub trait RayObserver {
    type Probe: Probe;
    /// A ray is about to be traced.
    fn begin(&mut self, kind: RayKind, ray: &Ray) -> &mut Self::Probe;
    /// The ray was traced.
    fn end(&mut self);
}

impl RayObserver for () {
    type Probe = ();
    #[inline(always)]
    fn begin(&mut self, _: RayKind, _: &Ray) -> &mut () {
        self
    }
    #[inline(always)]
    fn end(&mut self) {}
}

/// Adds up the counters of the rays of some kinds.
#[derive(Clone, Debug)]
pub struct CountRays<'t> {
    count: CountKind,
    /// To tell which rays miss its root.
    tree: Option<&'t Tree>,
    counting: bool,
    current: RayCounters,
    /// Sums over the counted rays.
    pub counters: RayCounters,
    pub ray_count: u64,
    /// Rays that miss the root's box; counted by [`CountRays::at_root`] alone.
    pub missed_root_count: u64,
    /// Sum of the squares of the leaf visits.
    pub squared_leaf_visits: u64,
}

impl<'t> CountRays<'t> {
    pub fn new(count: CountKind) -> Self {
        Self {
            count,
            tree: None,
            counting: false,
            current: RayCounters::default(),
            counters: RayCounters::default(),
            ray_count: 0,
            missed_root_count: 0,
            squared_leaf_visits: 0,
        }
    }

    /// Looks at which rays miss the root's box of `tree`, too.
    pub fn at_root(count: CountKind, tree: &'t Tree) -> Self {
        Self { tree: Some(tree), ..Self::new(count) }
    }

    /// Whether rays after the camera ray need not be traced.
    #[inline]
    pub fn counts_camera_rays_alone(&self) -> bool {
        self.count == CountKind::Camera
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
    type Probe = RayCounters;

    #[inline]
    fn begin(&mut self, kind: RayKind, ray: &Ray) -> &mut RayCounters {
        self.counting = self.count.includes(kind);
        self.current = RayCounters::default();
        if self.counting && self.tree.is_some_and(|tree| !hits_root(tree, ray)) {
            self.missed_root_count += 1;
        }
        &mut self.current
    }

    #[inline]
    fn end(&mut self) {
        if self.counting {
            self.counters += self.current;
            self.ray_count += 1;
            self.squared_leaf_visits += self.current.leaf_visits * self.current.leaf_visits;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn only_rays_of_the_asked_kind_are_added_up() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        for (count, expected) in
            [(CountKind::Camera, 2), (CountKind::Bounce, 3), (CountKind::Shadow, 4), (CountKind::All, 9)]
        {
            let mut observer = CountRays::new(count);
            for (kind, leaves) in [(RayKind::Camera, 2), (RayKind::Bounce, 3), (RayKind::Shadow, 4)] {
                let probe = observer.begin(kind, &ray);
                for leaf in 0..leaves {
                    probe.leaf_visited(leaf);
                }
                observer.end();
            }
            assert_eq!(observer.counters.leaf_visits, expected);
            assert_eq!(observer.ray_count, if count == CountKind::All { 3 } else { 1 });
        }
    }
}
