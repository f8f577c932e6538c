//! Which trees a sweep is about: the product of some settings, without those that would be the same tree again.

use crate::accel::{Block, BuildConfig, Builder, Improver, Layout, StopRule, Widen, Width};

/// Most points of a grid.
pub const MOST_POINTS: usize = 100_000;

/// The values of every setting that is varied. What is not in here has the value of the settings that the sweep starts
/// from.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepGrid {
    pub builders: Vec<Builder>,
    pub widths: Vec<Width>,
    pub widens: Vec<Widen>,
    pub stops: Vec<StopRule>,
    pub bins: Vec<usize>,
    pub leaf: Vec<usize>,
    pub blocks: Vec<Block>,
    pub improvers: Vec<Improver>,
    /// C_t and C_i: where the stop rule or the widening weighs them.
    pub traversal_costs: Vec<f32>,
    pub intersection_costs: Vec<f32>,
}

impl Default for SweepGrid {
    fn default() -> Self {
        Self::around(&BuildConfig::default())
    }
}

/// The layout of the settings that the sweep starts from, where a node of this width can have it.
fn layout_of(width: Width, base: &BuildConfig) -> Layout {
    if BuildConfig::NODES.contains(&(width, base.layout)) { base.layout } else { Layout::Full }
}

/// The settings that choose what else matters.
#[derive(Clone, Copy)]
struct Kind {
    builder: Builder,
    width: Width,
    widen: Widen,
    improver: Improver,
    block: Block,
    stop: StopRule,
}

impl SweepGrid {
    /// Bins times leaf limits, with everything else as it is.
    pub fn around(base: &BuildConfig) -> Self {
        Self {
            builders: vec![base.builder],
            widths: vec![base.width],
            widens: vec![base.widen],
            stops: vec![base.stop],
            bins: vec![2, 4, 8, 16, 32, 64, 128, 256],
            leaf: vec![1, 2, 4, 8, 16],
            blocks: vec![base.block],
            improvers: vec![base.improver],
            traversal_costs: vec![base.traversal_cost],
            intersection_costs: vec![base.intersection_cost],
        }
    }

    /// How many points it has.
    pub fn count(&self, base: &BuildConfig) -> usize {
        let of = |kind: Kind| {
            let bins = self.bins_of(kind, base).len();
            bins.saturating_mul(self.costs_of(kind, base).len())
                .saturating_mul(self.leaf_of(kind, base).len())
        };
        self.kinds(base).into_iter().map(of).fold(0, usize::saturating_add)
    }

    /// The trees, with `base`'s other settings. A setting that does not matter to a tree has `base`'s value, once.
    ///
    /// # Panics
    /// If there are more than [`MOST_POINTS`].
    pub fn points(&self, base: &BuildConfig) -> Vec<BuildConfig> {
        assert!(self.count(base) <= MOST_POINTS, "who makes a grid looks at its size first");
        let mut points = Vec::with_capacity(self.count(base));
        for kind in self.kinds(base) {
            let Kind { builder, width, widen, improver, block, stop } = kind;
            for (traversal_cost, intersection_cost) in self.costs_of(kind, base) {
                for leaf in self.leaf_of(kind, base) {
                    for bins in self.bins_of(kind, base) {
                        points.push(BuildConfig {
                            builder,
                            width,
                            layout: layout_of(width, base),
                            widen,
                            improver,
                            block,
                            stop,
                            traversal_cost,
                            intersection_cost,
                            leaf,
                            bins,
                            ..*base
                        });
                    }
                }
            }
        }
        points
    }

    /// Other libraries have leaves of their own, and a layout may have no room for large ones.
    fn leaf_of(&self, kind: Kind, base: &BuildConfig) -> Vec<usize> {
        if kind.builder.is_peer() {
            return vec![base.leaf];
        }
        let layout = layout_of(kind.width, base);
        let fits = |&leaf: &usize| BuildConfig { leaf, layout, ..*base }.leaf_limit();
        unique(&self.leaf.iter().map(fits).collect::<Vec<_>>())
    }

    /// What a tree of this grid is called: the settings that vary, and matter to it.
    pub fn name(&self, config: &BuildConfig) -> String {
        let mut parts = Vec::new();
        let several_bins = unique(&self.bins).len() > 1;
        if unique(&self.builders).len() > 1 || (several_bins && !config.builder.uses_bins()) {
            parts.push(config.builder.name().to_owned());
        }
        if unique(&self.widths).len() > 1 {
            parts.push(format!("width {}", config.width.name()));
        }
        if unique(&self.widens).len() > 1 && config.width != Width::W2 {
            parts.push(config.widen.name().to_owned());
        }
        if unique(&self.improvers).len() > 1 && config.improver != Improver::None {
            parts.push(config.improver.name().to_owned());
        }
        if unique(&self.blocks).len() > 1 && config.builder.weighs_cost() {
            parts.push(format!("blocks of {}", config.block.name()));
        }
        if several_bins && config.builder.uses_bins() {
            parts.push(format!("{} bins", config.bins));
        }
        if unique(&self.leaf).len() > 1 {
            parts.push(format!("leaf {}", config.leaf));
        }
        if unique(&self.stops).len() > 1 && weighs_stop(config) {
            parts.push(format!("stop {}", config.stop.name()));
        }
        if costs_matter(config) && unique(&self.traversal_costs).len() > 1 {
            parts.push(format!("C_t {}", config.traversal_cost));
        }
        if costs_matter(config) && unique(&self.intersection_costs).len() > 1 {
            parts.push(format!("C_i {}", config.intersection_cost));
        }
        if parts.is_empty() { config.builder.name().to_owned() } else { parts.join(", ") }
    }

    fn kinds(&self, base: &BuildConfig) -> Vec<Kind> {
        let mut kinds = Vec::new();
        for builder in unique(&self.builders) {
            let blocks = if builder.weighs_cost() { unique(&self.blocks) } else { vec![base.block] };
            for width in unique(&self.widths) {
                let widens = if width == Width::W2 { vec![base.widen] } else { unique(&self.widens) };
                for &widen in &widens {
                    let config = BuildConfig { builder, width, widen, ..*base };
                    let stops = if weighs_stop(&config) { unique(&self.stops) } else { vec![base.stop] };
                    for improver in unique(&self.improvers) {
                        for &block in &blocks {
                            let kind = |&stop| Kind { builder, width, widen, improver, block, stop };
                            kinds.extend(stops.iter().map(kind));
                        }
                    }
                }
            }
        }
        kinds
    }

    fn bins_of(&self, kind: Kind, base: &BuildConfig) -> Vec<usize> {
        if kind.builder.uses_bins() { unique(&self.bins) } else { vec![base.bins] }
    }

    /// Pairs of C_t and C_i, one a ratio.
    fn costs_of(&self, kind: Kind, base: &BuildConfig) -> Vec<(f32, f32)> {
        let Kind { builder, width, widen, stop, .. } = kind;
        if !costs_matter(&BuildConfig { builder, width, widen, stop, ..*base }) {
            return vec![(base.traversal_cost, base.intersection_cost)];
        }
        let mut pairs: Vec<(f32, f32)> = Vec::new();
        for c_t in unique(&self.traversal_costs) {
            for c_i in unique(&self.intersection_costs) {
                if !pairs.iter().any(|(t, i)| t / i == c_t / c_i) {
                    pairs.push((c_t, c_i));
                }
            }
        }
        pairs
    }
}

/// Each value once, in the order of their first places.
fn unique<T: Copy + PartialEq>(values: &[T]) -> Vec<T> {
    let mut unique = Vec::with_capacity(values.len());
    for &value in values {
        if !unique.contains(&value) {
            unique.push(value);
        }
    }
    unique
}

/// Whether the stop rule changes the tree.
fn weighs_stop(config: &BuildConfig) -> bool {
    config.builder.weighs_cost() && !config.is_optimal()
}

/// Whether C_t and C_i change the tree.
pub fn costs_matter(config: &BuildConfig) -> bool {
    config.is_optimal() || (weighs_stop(config) && config.stop == StopRule::Cost)
}

/// The settings with everything that does not change the tree at its default, and costs as C_t with C_i = 1. Settings
/// with the same are the same tree.
pub fn relevant(config: &BuildConfig) -> BuildConfig {
    let blank = BuildConfig::default();
    let mut relevant = *config;
    if costs_matter(config) {
        relevant.traversal_cost = config.traversal_cost / config.intersection_cost;
        relevant.intersection_cost = 1.0;
    } else {
        (relevant.traversal_cost, relevant.intersection_cost) =
            (blank.traversal_cost, blank.intersection_cost);
    }
    if !config.builder.uses_bins() {
        relevant.bins = blank.bins;
    }
    if !weighs_stop(config) {
        relevant.stop = blank.stop;
    }
    if !config.builder.weighs_cost() {
        relevant.block = blank.block;
    }
    if config.width == Width::W2 {
        relevant.widen = blank.widen;
    }
    if !config.builder.uses_morton() {
        relevant.morton = blank.morton;
    }
    if config.builder != Builder::Ploc {
        relevant.radius = blank.radius;
    }
    if config.builder != Builder::Spatial {
        (relevant.split_alpha, relevant.split_budget) = (blank.split_alpha, blank.split_budget);
    }
    if config.improver == Improver::None {
        relevant.rounds = blank.rounds;
    }
    if config.improver != Improver::Reinsertion {
        relevant.share = blank.share;
    }
    relevant
}

/// Whether two settings make the same tree over any scene.
pub fn same_tree(a: &BuildConfig, b: &BuildConfig) -> bool {
    relevant(a) == relevant(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by(base: &BuildConfig, leaf: &[usize]) -> SweepGrid {
        SweepGrid { bins: vec![4, 16], leaf: leaf.to_vec(), ..SweepGrid::around(base) }
    }

    #[test]
    fn the_grid_is_the_product_for_a_builder_with_bins() {
        let base = BuildConfig::default();
        let grid = two_by(&base, &[1, 2, 8]);
        let points = grid.points(&base);
        let pairs: Vec<_> = points.iter().map(|c| (c.leaf, c.bins)).collect();
        assert_eq!(pairs, [(1, 4), (1, 16), (2, 4), (2, 16), (8, 4), (8, 16)]);
        assert_eq!((grid.name(&points[5]), grid.count(&base)), ("16 bins, leaf 8".to_owned(), 6));
    }

    #[test]
    fn a_builder_without_bins_has_one_column() {
        let base = BuildConfig { builder: Builder::Sweep, bins: 7, ..BuildConfig::default() };
        let grid = two_by(&base, &[1, 2]);
        let points = grid.points(&base);
        assert_eq!(points.iter().map(|c| (c.leaf, c.bins)).collect::<Vec<_>>(), [(1, 7), (2, 7)]);
        assert_eq!(grid.name(&points[0]), "sweep, leaf 1");
    }

    #[test]
    fn settings_that_do_not_matter_do_not_multiply_points() {
        let base = BuildConfig::default();
        let grid = SweepGrid {
            builders: Builder::ALL.to_vec(),
            widths: Width::ALL.to_vec(),
            widens: Widen::ALL.to_vec(),
            stops: StopRule::ALL.to_vec(),
            blocks: vec![Block::B1, Block::B4],
            improvers: Improver::ALL.to_vec(),
            traversal_costs: vec![1.0, 2.0, 4.0],
            intersection_costs: vec![1.0, 2.0],
            ..two_by(&base, &[1, 2, 1])
        };
        let points = grid.points(&base);
        assert_eq!(points.len(), grid.count(&base));
        for (i, a) in points.iter().enumerate() {
            assert_eq!(a.check(), Ok(()), "{a:?}");
            assert!(points[..i].iter().all(|b| !same_tree(a, b)), "twice: {a:?}");
        }
        // Ratios 1, 1/2, 2 and 4 of the costs; 3 improvers, 2 leaf limits.
        let of = |builder| points.iter().filter(|c| c.builder == builder).count() / (3 * 2);
        let (limit, cost, optimal) = (1, 4, 4);
        // Split and collapse at widths 4 and 8, and width 2: five ways with a stop rule; two optimal ones.
        assert_eq!(of(Builder::Median), 5 + 2 * optimal);
        assert_eq!(of(Builder::Sweep), 2 * (5 * (limit + cost) + 2 * optimal));
        assert_eq!(of(Builder::Binned), 2 * of(Builder::Sweep));
        let mut names: Vec<_> = points.iter().map(|c| grid.name(c)).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), points.len(), "every tree has a name of its own");
    }

    #[test]
    fn only_the_ratio_of_the_costs_makes_a_tree() {
        let config = BuildConfig { stop: StopRule::Cost, ..BuildConfig::default() };
        let twice = BuildConfig { traversal_cost: 2.0, intersection_cost: 2.0, ..config };
        assert!(same_tree(&config, &twice));
        assert!(!same_tree(&config, &BuildConfig { traversal_cost: 2.0, ..config }));
        let limit = BuildConfig { stop: StopRule::Limit, ..config };
        assert!(same_tree(&limit, &BuildConfig { traversal_cost: 2.0, ..limit }));
    }

    #[test]
    fn what_is_said_to_be_the_same_tree_is() {
        use crate::accel::{Shapes, build_over};
        use crate::geometry::Aabb;
        use crate::task::Task;
        use glam::Vec3;

        struct Boxes(Vec<Aabb>);
        impl Shapes for Boxes {
            fn count(&self) -> usize {
                self.0.len()
            }
            fn bounds(&self, shape: u32) -> Aabb {
                self.0[shape as usize]
            }
            fn bounds_between(&self, shape: u32, _: usize, _: f32, _: f32) -> Aabb {
                self.0[shape as usize]
            }
            fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
                self.0[shape as usize].intersection(*clip)
            }
            fn area_in_parts(&self, shape: u32) -> f32 {
                self.0[shape as usize].area()
            }
        }
        let at = |i: u32| {
            let turn = |k: u32| ((i * k + 7) % 101) as f32;
            let low = Vec3::new(turn(13), turn(29), turn(57));
            Aabb { min: low, max: low + Vec3::new(1.0, turn(3) * 0.1, 2.0) }
        };
        let boxes = Boxes((0..150).map(at).collect());
        let tree = |config: &BuildConfig| build_over(&boxes, config, &Task::new()).expect("no cancel").0;
        for builder in Builder::ALL {
            for width in Width::ALL {
                for (widen, improver) in [
                    (Widen::Split, Improver::None),
                    (Widen::Optimal, Improver::Rotations),
                    (Widen::Collapse, Improver::Reinsertion),
                ] {
                    for stop in StopRule::ALL {
                        let config = BuildConfig {
                            builder,
                            width,
                            widen,
                            improver,
                            stop,
                            leaf: 5,
                            bins: 5,
                            block: Block::B4,
                            radius: 3,
                            rounds: 4,
                            share: 0.5,
                            traversal_cost: 3.0,
                            intersection_cost: 2.0,
                            ..BuildConfig::default()
                        };
                        let same =
                            format!("{:?}", tree(&config)) == format!("{:?}", tree(&relevant(&config)));
                        assert!(same, "{config:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_tree_of_the_default_grid_can_be_built() {
        let base = BuildConfig::default();
        let grid = SweepGrid::default();
        assert_eq!(grid.points(&base).len(), 40);
        assert!(grid.points(&base).iter().all(|config| config.check() == Ok(())));
    }
}
