//! Who looks on while a ray walks: nobody, a counter, or somebody who wants to be told of every step.

use crate::accel::tree::ChildRef;

/// Looks on while a ray walks a tree. The empty probe `()` costs nothing.
pub trait Probe {
    /// An inner node whose `box_tests` valid children's boxes are tested.
    fn inner_visited(&mut self, node_idx: u32, box_tests: u32);
    /// A leaf whose shapes are tested.
    fn leaf_visited(&mut self, leaf_idx: u32);
    /// `count` shapes (valid lanes of a block) are tested.
    fn shapes_tested(&mut self, count: u32);
    /// The children of an inner node were tested up to `t_max`: bit i of `entered` for slot i, and where the ray enters it
    /// (without meaning for the others).
    #[inline(always)]
    fn boxes_tested(&mut self, _node_idx: u32, _t_max: f32, _entered: u32, _entries: &[f32]) {}
    /// A child that waited is taken from the stack; it is dropped if it begins behind `t_max`.
    #[inline(always)]
    fn popped(&mut self, _child: ChildRef, _entry: f32, _t_max: f32) {}
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

/// One thing that happens on a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<'a> {
    /// The children of an inner node were tested up to `t_max`: bit i of `entered` for slot i, and where the ray enters it
    /// (without meaning for the others). It goes on in the nearest; the others wait.
    Boxes { node_idx: u32, t_max: f32, entered: u32, entries: &'a [f32] },
    /// A leaf whose shapes are tested.
    Leaf { leaf_idx: u32 },
    /// So many of its shapes are.
    Shapes { count: u32 },
    /// A child that waited is taken from the stack; it is dropped if its `entry` lies behind `t_max`.
    Popped { child: ChildRef, entry: f32, t_max: f32 },
}

/// Tells somebody of every step.
pub struct Watch<'w>(pub &'w mut dyn FnMut(Step));

impl Probe for Watch<'_> {
    #[inline]
    fn inner_visited(&mut self, _: u32, _: u32) {}

    #[inline]
    fn leaf_visited(&mut self, leaf_idx: u32) {
        (self.0)(Step::Leaf { leaf_idx });
    }

    #[inline]
    fn shapes_tested(&mut self, count: u32) {
        (self.0)(Step::Shapes { count });
    }

    #[inline]
    fn boxes_tested(&mut self, node_idx: u32, t_max: f32, entered: u32, entries: &[f32]) {
        (self.0)(Step::Boxes { node_idx, t_max, entered, entries });
    }

    #[inline]
    fn popped(&mut self, child: ChildRef, entry: f32, t_max: f32) {
        // Below all that waits lies the end of the walk.
        if !child.is_empty() {
            (self.0)(Step::Popped { child, entry, t_max });
        }
    }
}
