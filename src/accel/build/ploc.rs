//! Parallel locally-ordered clustering: shapes along the Morton curve are clusters, and of neighbours those pairs are merged
//! that are each other's nearest, until one is left (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding
//! Volume Hierarchy Construction", 2018). The distance is the area of the box around both.

use std::ops::Range;

use fearless_simd::{Simd, f32x8, i32x8, prelude::*};
use rayon::prelude::*;

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::BuildConfig;
use crate::accel::simd::SimdToken;
use crate::at_level;
use crate::task::{Cancelled, Task};

use super::morton::sorted;
use super::onlooker::Onlooker;
use super::order::BuildRef;

/// Clusters whose neighbours are one piece of work.
const PIECE: usize = 2048;
const LANES: usize = 8;

/// Builds the binary tree down to single references, in depth-first order. It is the same at any thread count.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn build(
    refs: &[BuildRef],
    config: &BuildConfig,
    onlooker: &mut Onlooker,
    task: &Task,
) -> Result<Bvh2, Cancelled> {
    if refs.is_empty() {
        return Ok(Bvh2::default());
    }
    let (_, refs) = sorted(refs, config.morton, task)?;
    let leaf = |(i, r): (usize, &BuildRef)| Bvh2Node { bounds: r.bound.aabb(), first: i as u32, count: 1 };
    let mut clusters: Vec<_> = refs.iter().enumerate().map(leaf).collect();
    let mut nodes = vec![Bvh2::PLACE; 2 * refs.len() - 1];
    // Pairs are written from the end on, so that the root comes out first.
    let mut free = nodes.len();
    let mut partners = Vec::new();
    onlooker.merged(&clusters);
    while clusters.len() > 1 {
        find_partners(&clusters, config, task, &mut partners)?;
        let before = clusters.len();
        merge(&mut clusters, &partners, &mut nodes, &mut free);
        if clusters.len() == before {
            // Areas that are no numbers: whatever lies side by side.
            partners.clear();
            partners.extend((0..before as u32).map(|i| if (i ^ 1) < before as u32 { i ^ 1 } else { i }));
            merge(&mut clusters, &partners, &mut nodes, &mut free);
        }
        onlooker.merged(&clusters);
        task.advance((before - clusters.len()) as u64);
    }
    task.advance(1);
    nodes[0] = clusters[0];
    let bvh = Bvh2 { nodes, refs: refs.iter().map(BuildRef::shape).collect() };
    let mut bvh = bvh.in_depth_first_order();
    bvh.limit_depth(BuildConfig::MAX_DEPTH);
    Ok(bvh)
}

/// Finds the nearest neighbour of each cluster, by its index.
fn find_partners(
    clusters: &[Bvh2Node],
    config: &BuildConfig,
    task: &Task,
    partners: &mut Vec<u32>,
) -> Result<(), Cancelled> {
    partners.clear();
    partners.resize(clusters.len(), 0);
    let level = SimdToken::of(config);
    let of_piece = |window: &mut Window, (piece, partners): (usize, &mut [u32])| {
        task.check()?;
        let range = piece * PIECE..piece * PIECE + partners.len();
        at_level!(level, simd => window.find(simd, clusters, range, config.radius, partners));
        Ok(())
    };
    partners.par_chunks_mut(PIECE).enumerate().map_init(Window::default, of_piece).collect()
}

/// Puts each pair of partners into the tree, and a cluster around them in the place of the first.
fn merge(clusters: &mut Vec<Bvh2Node>, partners: &[u32], nodes: &mut [Bvh2Node], free: &mut usize) {
    let mut kept = 0;
    for (i, &partner) in partners.iter().enumerate() {
        let (partner, cluster) = (partner as usize, clusters[i]);
        let is_pair = partner != i && partners[partner] as usize == i;
        if is_pair && partner < i {
            continue;
        }
        clusters[kept] = if is_pair {
            let pair = [cluster, clusters[partner]];
            *free -= 2;
            nodes[*free..*free + 2].copy_from_slice(&pair);
            Bvh2Node { bounds: pair[0].bounds.union(pair[1].bounds), first: *free as u32, count: 0 }
        } else {
            cluster
        };
        kept += 1;
    }
    clusters.truncate(kept);
}

/// Some clusters and their neighbours, side by side for vectors, and what is found about each.
///
/// A pair is compared once, for both. Of equally near ones the pair counts whose indices differ in lower bits, which says
/// the same to both: regular meshes, where all are equally near, are merged in pairs, and not one a round.
#[derive(Default)]
struct Window {
    /// Lower sides and, negated, upper ones.
    sides: [Vec<f32>; 6],
    /// The least area of a box around a cluster and another one.
    areas: Vec<f32>,
    /// The index of that one, in which bits it differs from the cluster's own.
    bits: Vec<i32>,
}

impl Window {
    const NOBODY: i32 = i32::MAX;

    #[inline(always)]
    fn find<S: Simd>(
        &mut self,
        simd: S,
        clusters: &[Bvh2Node],
        range: Range<usize>,
        radius: usize,
        partners: &mut [u32],
    ) {
        let from = range.start.saturating_sub(radius);
        let to = clusters.len().min(range.end + radius);
        self.take(&clusters[from..to]);
        for i in 0..range.end - from {
            self.compare(simd, i, to - from, from as i32, radius);
        }
        for (index, partner) in range.zip(partners) {
            let bits = self.bits[index - from];
            *partner = if bits == Self::NOBODY { index as u32 } else { index as u32 ^ bits as u32 };
        }
    }

    fn take(&mut self, clusters: &[Bvh2Node]) {
        let room = clusters.len() + LANES;
        for (axis, [lower, upper]) in self.sides.as_chunks_mut().0.iter_mut().enumerate() {
            lower.clear();
            upper.clear();
            lower.extend(clusters.iter().map(|c| c.bounds.min[axis]));
            upper.extend(clusters.iter().map(|c| -c.bounds.max[axis]));
            lower.resize(room, 0.0);
            upper.resize(room, 0.0);
        }
        self.areas.clear();
        self.areas.resize(room, f32::INFINITY);
        self.bits.clear();
        self.bits.resize(room, Self::NOBODY);
    }

    /// Compares a cluster of `count` with the `radius` next ones. Its index, counted from 0, is higher by `from`.
    #[inline(always)]
    fn compare<S: Simd>(&mut self, simd: S, i: usize, count: usize, from: i32, radius: usize) {
        let [x_min, x_max, y_min, y_max, z_min, z_max] = &self.sides;
        let own_index = from + i as i32;
        let mut least = f32x8::splat(simd, f32::INFINITY);
        let mut least_bits = i32x8::splat(simd, Self::NOBODY);
        let end = count.min(i + 1 + radius);
        for first in (i + 1..end).step_by(LANES) {
            let x = neg_extent(simd, x_min, x_max, i, first);
            let y = neg_extent(simd, y_min, y_max, i, first);
            let z = neg_extent(simd, z_min, z_max, i, first);
            // The signs cancel.
            let area = x * (y + z) + y * z;
            let lanes = i32x8::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
            let bits = (lanes + (from + first as i32)) ^ own_index;
            let there = lanes.simd_lt((end - first) as i32);
            let bits = there.select(bits, i32x8::splat(simd, Self::NOBODY));
            let area = there.select(area, f32x8::splat(simd, f32::INFINITY));
            let (areas, all_bits) = (&mut self.areas[first..][..LANES], &mut self.bits[first..][..LANES]);
            let (other, other_bits) = (f32x8::from_slice(simd, areas), i32x8::from_slice(simd, all_bits));
            let nearer = area.simd_lt(other) | (area.simd_eq(other) & bits.simd_lt(other_bits));
            nearer.select(area, other).store_slice(areas);
            nearer.select(bits, other_bits).store_slice(all_bits);
            let nearer = area.simd_lt(least) | (area.simd_eq(least) & bits.simd_lt(least_bits));
            least = nearer.select(area, least);
            least_bits = nearer.select(bits, least_bits);
        }
        for (area, bits) in least.to_array().into_iter().zip(least_bits.to_array()) {
            if area < self.areas[i] || (area == self.areas[i] && bits < self.bits[i]) {
                (self.areas[i], self.bits[i]) = (area, bits);
            }
        }
    }
}

/// The extent, negated, of the box around the `i`-th cluster and each of some from `first` on, along one axis.
#[inline(always)]
fn neg_extent<S: Simd>(simd: S, lower: &[f32], upper: &[f32], i: usize, first: usize) -> f32x8<S> {
    let lowest = f32x8::from_slice(simd, &lower[first..][..LANES]).min(f32x8::splat(simd, lower[i]));
    let highest = f32x8::from_slice(simd, &upper[first..][..LANES]).min(f32x8::splat(simd, upper[i]));
    lowest + highest
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::geometry::Aabb;

    fn clusters(count: usize, whole: bool) -> Vec<Bvh2Node> {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(count as u64);
        let mut point = || {
            let p = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..8.0)));
            if whole { p.floor() } else { p }
        };
        (0..count)
            .map(|_| Bvh2Node { bounds: Aabb::from_points([point(), point()]), ..Bvh2::PLACE })
            .collect()
    }

    #[test]
    fn partners_are_the_nearest_of_all_within_the_radius() {
        for (count, whole) in [(2, false), (9, false), (5000, false), (3000, true)] {
            let clusters = clusters(count, whole);
            for radius in [1, 7, 8, 14, 33] {
                let config = BuildConfig { radius, ..BuildConfig::default() };
                let mut partners = Vec::new();
                find_partners(&clusters, &config, &Task::new(), &mut partners).expect("not cancelled");
                for (i, &partner) in partners.iter().enumerate() {
                    let around = i.saturating_sub(radius)..count.min(i + radius + 1);
                    let key = |j: usize| (clusters[i].bounds.union(clusters[j].bounds).half_area(), i ^ j);
                    let least = around.filter(|&j| j != i).map(key).reduce(|a, b| if b < a { b } else { a });
                    let found = key(partner as usize);
                    assert_eq!(Some(found), least, "{count} {radius} {i}");
                }
            }
        }
    }

    #[test]
    fn equally_near_ones_are_merged_side_by_side() {
        // A row of unit boxes: any two neighbours are as near.
        let at = |i: usize| Vec3::X * i as f32;
        let refs: Vec<_> =
            (0..4096).map(|i| BuildRef::new(&Aabb::new(at(i), at(i) + Vec3::ONE), i as u32)).collect();
        for radius in [1, 14] {
            let config = BuildConfig { radius, ..BuildConfig::default() };
            let bvh = build(&refs, &config, &mut Onlooker::nobody(), &Task::new()).expect("not cancelled");
            assert_eq!(bvh.depth_max(), 12, "a balanced tree");
        }
    }

    #[test]
    fn chains_stay_within_the_depth_limit() {
        // Each box is nearer to all before it than to the next.
        let refs: Vec<_> = (0..200)
            .map(|i| {
                let size = Vec3::splat(1.1_f32.powi(i));
                BuildRef::new(&Aabb::new(-size, size), i as u32)
            })
            .collect();
        let bvh = build(&refs, &BuildConfig::default(), &mut Onlooker::nobody(), &Task::new())
            .expect("not cancelled");
        assert!(bvh.depth_max() <= BuildConfig::MAX_DEPTH, "{}", bvh.depth_max());
        assert_eq!((bvh.nodes.len(), bvh.refs.len()), (399, 200));
    }
}
