//! Who looks on while a ray walks: nobody, or a counter.

/// Looks on while a ray walks a tree. The empty probe `()` costs nothing.
pub trait Probe {
    /// An inner node whose `box_tests` valid children's boxes are tested.
    fn inner_visited(&mut self, node_idx: u32, box_tests: u32);
    /// A leaf whose shapes are tested.
    fn leaf_visited(&mut self, leaf_idx: u32);
    /// `count` shapes (valid lanes of a block) are tested.
    fn shapes_tested(&mut self, count: u32);
}

impl Probe for () {
    #[inline(always)]
    fn inner_visited(&mut self, _: u32, _: u32) {}
    #[inline(always)]
    fn leaf_visited(&mut self, _: u32) {}
    #[inline(always)]
    fn shapes_tested(&mut self, _: u32) {}
}

/// Counts of one ray, or sums over many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounters {
    pub inner_visits: u64,
    pub leaf_visits: u64,
    pub box_tests: u64,
    pub shape_tests: u64,
}

impl RayCounters {
    /// Inner visits + leaf visits.
    pub fn nodes_visited(&self) -> u64 {
        self.inner_visits + self.leaf_visits
    }

    /// `C_t * inner visits + C_i * shape tests`.
    pub fn ray_cost(&self, traversal_cost: f32, intersection_cost: f32) -> f64 {
        f64::from(traversal_cost) * self.inner_visits as f64
            + f64::from(intersection_cost) * self.shape_tests as f64
    }
}

impl std::ops::AddAssign for RayCounters {
    fn add_assign(&mut self, other: Self) {
        self.inner_visits += other.inner_visits;
        self.leaf_visits += other.leaf_visits;
        self.box_tests += other.box_tests;
        self.shape_tests += other.shape_tests;
    }
}

impl std::ops::Add for RayCounters {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl Probe for RayCounters {
    #[inline]
    fn inner_visited(&mut self, _: u32, box_tests: u32) {
        self.inner_visits += 1;
        self.box_tests += u64::from(box_tests);
    }
    #[inline]
    fn leaf_visited(&mut self, _: u32) {
        self.leaf_visits += 1;
    }
    #[inline]
    fn shapes_tested(&mut self, count: u32) {
        self.shape_tests += u64::from(count);
    }
}
