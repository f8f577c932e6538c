//! What a node's splits would cost: at every position of its references sorted by centroid, and at the planes between
//! bins. Written out plainly, box by box, so that it also checks what the builders find.
//!
//! Costs are as the stop rule weighs them, over the area of the node's box: `C_t + C_i * (N_left * A_left + N_right *
//! A_right) / A` for a split, `C_i * N` for a leaf (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
//! 2007).

use rayon::prelude::*;

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::build::bin_index;
use super::config::BuildConfig;

/// References between two looks for a cancel.
const CHUNK: usize = 1 << 16;

/// A way to tell a node's references apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitCandidate {
    pub axis: usize,
    /// Where the plane lies: between two centroids, or between two bins.
    pub position: f32,
    pub left_count: usize,
    /// Over the area of the node's box; infinite where one side is empty.
    pub cost: f32,
}

/// The split costs along one axis, by position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisCosts {
    /// Between every two neighbouring centroids that differ.
    pub exact: Vec<SplitCandidate>,
    /// Least and largest centroid; equal ones cannot be told apart along this axis.
    pub centers: [f32; 2],
}

/// The references of a node, and what they weigh.
#[derive(Clone, Debug)]
pub struct SplitCosts {
    /// A box a reference.
    boxes: Vec<Aabb>,
    bounds: Aabb,
    costs: [f32; 2],
    pub axes: [AxisCosts; 3],
}

impl SplitCosts {
    /// Sorts the references along each axis and weighs every position. `bounds`: the node's own box.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn of(boxes: Vec<Aabb>, bounds: Aabb, config: &BuildConfig, task: &Task) -> Result<Self, Cancelled> {
        let costs = [config.traversal_cost, config.intersection_cost];
        let mut split_costs = Self { boxes, bounds, costs, axes: Default::default() };
        let axes = (0..3).into_par_iter().map(|axis| split_costs.exact(axis, task));
        let axes: Vec<AxisCosts> = axes.collect::<Result<_, _>>()?;
        for (slot, axis) in split_costs.axes.iter_mut().zip(axes) {
            *slot = axis;
        }
        Ok(split_costs)
    }

    pub fn len(&self) -> usize {
        self.boxes.len()
    }

    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// `C_i * N`.
    pub fn leaf_cost(&self) -> f32 {
        self.costs[1] * self.boxes.len() as f32
    }

    /// The cheapest exact split of all axes; of equally cheap ones that of the first axis and position.
    pub fn best(&self) -> Option<SplitCandidate> {
        least(self.axes.iter().flat_map(|axis| &axis.exact))
    }

    /// The planes between `bins` bins over the centroids' bounds, along an axis; none where it has no extent.
    pub fn binned(&self, axis: usize, bins: usize) -> Vec<SplitCandidate> {
        let [origin, last] = self.axes[axis].centers;
        let scale = bins as f32 / (last - origin);
        if !(last > origin && scale > 0.0 && scale < f32::INFINITY) {
            return Vec::new();
        }
        let mut filled = vec![(0_usize, Aabb::EMPTY); bins];
        for bounds in &self.boxes {
            let (count, bin) = &mut filled[bin_index(bounds.center()[axis], origin, scale, bins)];
            *count += 1;
            *bin = bin.union(*bounds);
        }
        let mut rights = vec![Aabb::EMPTY; bins];
        for i in (1..bins).rev() {
            let after = rights.get(i + 1).copied().unwrap_or(Aabb::EMPTY);
            rights[i] = after.union(filled[i].1);
        }
        let (mut left_count, mut left) = (0, Aabb::EMPTY);
        (1..bins)
            .map(|i| {
                left_count += filled[i - 1].0;
                left = left.union(filled[i - 1].1);
                let position = origin + i as f32 / scale;
                let cost = self.cost(left_count, &left, &rights[i]);
                SplitCandidate { axis, position, left_count, cost }
            })
            .collect()
    }

    /// The cheapest plane between `bins` bins.
    pub fn best_binned(&self, bins: usize) -> Option<SplitCandidate> {
        let planes: Vec<SplitCandidate> = (0..3).flat_map(|axis| self.binned(axis, bins)).collect();
        least(planes.iter())
    }

    /// The boxes of the two sides when references go left whose centroid lies before `position`.
    pub fn sides(&self, axis: usize, position: f32) -> [(usize, Aabb); 2] {
        let mut sides = [(0, Aabb::EMPTY); 2];
        for bounds in &self.boxes {
            let (count, side) = &mut sides[usize::from(bounds.center()[axis] >= position)];
            *count += 1;
            *side = side.union(*bounds);
        }
        sides
    }

    /// What children with these references and boxes cost, of however many the node has.
    pub fn of_children(&self, children: &[(usize, Aabb)]) -> f32 {
        let weights = children.iter().map(|(count, bounds)| *count as f32 * bounds.area());
        self.costs[0] + self.costs[1] * weights.sum::<f32>() / self.bounds.area()
    }

    fn cost(&self, left_count: usize, left: &Aabb, right: &Aabb) -> f32 {
        let right_count = self.boxes.len() - left_count;
        if left_count == 0 || right_count == 0 {
            return f32::INFINITY;
        }
        self.of_children(&[(left_count, *left), (right_count, *right)])
    }

    fn exact(&self, axis: usize, task: &Task) -> Result<AxisCosts, Cancelled> {
        let mut order: Vec<(f32, u32)> =
            self.boxes.iter().zip(0..).map(|(bounds, i)| (bounds.center()[axis], i)).collect();
        task.check()?;
        order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        task.check()?;
        let box_of = |i: usize| self.boxes[order[i].1 as usize];
        let mut rights = vec![0.0_f32; order.len()];
        let mut right = Aabb::EMPTY;
        for i in (1..order.len()).rev() {
            right = right.union(box_of(i));
            rights[i] = right.area();
            if i % CHUNK == 0 {
                task.check()?;
            }
        }
        let (mut left, mut exact) = (Aabb::EMPTY, Vec::new());
        let [traversal, intersection] = self.costs;
        let own = self.bounds.area();
        for i in 1..order.len() {
            left = left.union(box_of(i - 1));
            if i % CHUNK == 0 {
                task.check()?;
            }
            let (before, after) = (order[i - 1].0, order[i].0);
            // Equal centroids cannot be told apart by a plane.
            if before == after {
                continue;
            }
            let weight = i as f32 * left.area() + (order.len() - i) as f32 * rights[i];
            let position = before + 0.5 * (after - before);
            // Of neighbouring floats the middle is the first one.
            let position = if position > before { position } else { after };
            let cost = traversal + intersection * weight / own;
            exact.push(SplitCandidate { axis, position, left_count: i, cost });
        }
        let end = |at: Option<&(f32, u32)>| at.map_or(0.0, |(center, _)| *center);
        Ok(AxisCosts { exact, centers: [end(order.first()), end(order.last())] })
    }
}

/// The first of the cheapest.
fn least<'a>(candidates: impl Iterator<Item = &'a SplitCandidate>) -> Option<SplitCandidate> {
    let finite = candidates.filter(|candidate| candidate.cost.is_finite());
    finite.copied().reduce(|best, other| if other.cost < best.cost { other } else { best })
}

/// A curve with at most about `most` points that looks the same: of every stretch the least and the largest cost, and of all
/// the least.
pub fn thinned(curve: &[SplitCandidate], most: usize) -> Vec<SplitCandidate> {
    let stretch = (2 * curve.len()).div_ceil(most.max(2)).max(1);
    if stretch <= 2 {
        return curve.to_vec();
    }
    let mut thin = Vec::with_capacity(most + 2);
    for part in curve.chunks(stretch) {
        let by_cost = |a: &&SplitCandidate, b: &&SplitCandidate| a.cost.total_cmp(&b.cost);
        let (Some(low), Some(high)) = (part.iter().min_by(by_cost), part.iter().max_by(by_cost)) else {
            continue;
        };
        let (first, second) = if low.left_count <= high.left_count { (low, high) } else { (high, low) };
        thin.push(*first);
        if first.left_count != second.left_count {
            thin.push(*second);
        }
    }
    thin
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::accel::{Builder, NodeKind, Width, build};

    fn boxes(count: usize, seed: u64) -> Vec<Aabb> {
        let mut rng = Pcg32::seed_from_u64(seed);
        let mut point = |scale: f32| Vec3::from_array(std::array::from_fn(|_| scale * rng.random::<f32>()));
        (0..count)
            .map(|_| {
                let min = point(10.0);
                Aabb::new(min, min + point(1.5))
            })
            .collect()
    }

    fn costs(boxes: &[Aabb]) -> SplitCosts {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        let config = BuildConfig { traversal_cost: 1.25, intersection_cost: 0.75, ..BuildConfig::default() };
        SplitCosts::of(boxes.to_vec(), bounds, &config, &Task::new()).expect("nobody cancels")
    }

    #[test]
    fn every_position_costs_what_its_two_sides_do() {
        let costs = costs(&boxes(60, 1));
        for axis in &costs.axes {
            assert_eq!(axis.exact.len(), 59, "all centroids differ");
            for candidate in &axis.exact {
                let sides = costs.sides(candidate.axis, candidate.position);
                assert_eq!(sides[0].0, candidate.left_count);
                let by_hand = costs.of_children(&sides);
                assert!((by_hand / candidate.cost - 1.0).abs() < 1e-5, "{candidate:?}");
            }
        }
        assert_eq!(costs.leaf_cost(), 0.75 * 60.0);
    }

    #[test]
    fn planes_between_bins_cost_what_their_two_sides_do() {
        let costs = costs(&boxes(80, 2));
        for bins in [2, 7, 16, 256] {
            for axis in 0..3 {
                let planes = costs.binned(axis, bins);
                assert_eq!(planes.len(), bins - 1);
                for plane in planes.iter().filter(|plane| plane.cost.is_finite()) {
                    let [(left, a), (right, b)] = costs.sides(axis, plane.position);
                    // At the plane itself rounding may send a centroid to either side.
                    if left == plane.left_count {
                        let by_hand = costs.of_children(&[(left, a), (right, b)]);
                        assert!((by_hand / plane.cost - 1.0).abs() < 1e-5, "{plane:?}");
                    }
                }
            }
            let best = costs.best_binned(bins).expect("a plane");
            assert!(best.cost >= costs.best().expect("a split").cost * 0.999_99, "bins see fewer splits");
        }
    }

    #[test]
    fn the_best_splits_are_those_that_the_builders_make() {
        for (builder, bins) in [(Builder::Sweep, 16), (Builder::Binned, 16), (Builder::Binned, 64)] {
            for seed in 0..8 {
                let boxes = boxes(300, seed);
                let config = BuildConfig { builder, bins, width: Width::W2, ..BuildConfig::default() };
                let (tree, _) = build(&boxes, &config, &Task::new()).expect("nobody cancels");
                let costs = SplitCosts::of(boxes.clone(), tree.bounds(), &config, &Task::new());
                let costs = costs.expect("nobody cancels");
                let mut root = None;
                tree.walk(|node| {
                    if let NodeKind::Inner(children) = node.kind {
                        root = root.take().or(Some(children));
                    }
                    false
                });
                let family = crate::accel::Family::of(&tree, &Task::new()).expect("nobody cancels");
                let children = root.expect("300 boxes are no leaf");
                let children: Vec<_> =
                    children.iter().map(|(node, b)| (family.references(*node) as usize, *b)).collect();
                let made = costs.of_children(&children);
                let best = match builder {
                    Builder::Sweep => costs.best(),
                    _ => costs.best_binned(bins),
                };
                let best = best.expect("a split");
                assert!((made / best.cost - 1.0).abs() < 1e-5, "{builder:?} {bins}: {made} {best:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_told_apart_has_no_split() {
        let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 5];
        let costs = costs(&same);
        assert!(costs.best().is_none() && costs.best_binned(16).is_none());
        let config = BuildConfig::default();
        let none = SplitCosts::of(Vec::new(), Aabb::EMPTY, &config, &Task::new()).expect("nobody cancels");
        assert!(none.is_empty() && none.best().is_none());
    }

    #[test]
    fn a_thin_curve_keeps_the_least_and_the_largest() {
        let costs = costs(&boxes(5000, 3));
        let curve = &costs.axes[0].exact;
        let thin = thinned(curve, 300);
        assert!(thin.len() <= 302 && thin.windows(2).all(|pair| pair[0].left_count < pair[1].left_count));
        let end = |c: &[SplitCandidate], pick: fn(f32, f32) -> f32| c.iter().map(|c| c.cost).reduce(pick);
        assert_eq!(end(&thin, f32::min), end(curve, f32::min));
        assert_eq!(end(&thin, f32::max), end(curve, f32::max));
        assert_eq!(thinned(&curve[..50], 300), curve[..50]);
    }
}
