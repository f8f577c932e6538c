//! The linear BVH: shapes are sorted along the Morton curve, and a node is split where the highest bit changes in which its
//! codes differ.
//!
//! The tree is that of Karras, "Maximizing Parallelism in the Construction of BVHs, Octrees, and k-d Trees", 2012: a binary
//! radix tree. There every node finds its range by itself, which suits thousands of threads; here ranges are halved from
//! the root down by searching for the bit, which needs no second pass for the boxes. Where codes are equal the range is
//! halved by count instead of by the bits of the index.

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::{BuildConfig, StopRule};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::morton::sorted;
use super::order::BuildRef;
use super::top_down::{CHECK_MIN, fits_depth};

/// Below this many references the two sides of a node are not shared among threads.
const FORK_MIN: usize = 4096;

struct Context<'a> {
    /// How deep single references may lie.
    single: BuildConfig,
    task: &'a Task,
}

/// References next to each other on the curve.
#[derive(Clone, Copy)]
struct Run<'a> {
    codes: &'a [u64],
    refs: &'a [BuildRef],
    /// The number of the first.
    first: u32,
}

/// Builds the binary tree down to single references, in depth-first order. It is the same at any thread count.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn build(refs: &[BuildRef], config: &BuildConfig, task: &Task) -> Result<Bvh2, Cancelled> {
    if refs.is_empty() {
        return Ok(Bvh2::default());
    }
    let (codes, refs) = sorted(refs, config.morton, task)?;
    let context = Context { single: BuildConfig { leaf: 1, stop: StopRule::Limit, ..*config }, task };
    let mut nodes = vec![Bvh2::PLACE; 2 * refs.len() - 1];
    let (root, below) = nodes.split_at_mut(1);
    let run = Run { codes: &codes, refs: &refs, first: 0 };
    context.grow(run, 0, &mut root[0], below, 1)?;
    Ok(Bvh2 { nodes, refs: refs.iter().map(BuildRef::shape).collect() })
}

impl Context<'_> {
    /// Writes a node and all `below` it, the first of which has the index `at`.
    fn grow(
        &self,
        run: Run,
        depth: usize,
        node: &mut Bvh2Node,
        below: &mut [Bvh2Node],
        at: u32,
    ) -> Result<(), Cancelled> {
        let count = run.refs.len();
        if count == 1 {
            *node = Bvh2Node { bounds: run.refs[0].bound.aabb(), first: run.first, count: 1 };
            return Ok(());
        }
        if count >= CHECK_MIN {
            self.task.check()?;
        }
        let mid = self.split(run.codes, depth);
        let [left, right] = run.halves(mid);
        let (pair, below) = below.split_at_mut(2);
        let [left_node, right_node] = pair else { unreachable!("two were split off") };
        // A tree over n references has 2 n - 1 nodes.
        let (left_below, right_below) = below.split_at_mut(2 * mid - 2);
        let (left_at, right_at) = (at + 2, at + 2 * mid as u32);
        let mut grow_left = || self.grow(left, depth + 1, left_node, left_below, left_at);
        let mut grow_right = || self.grow(right, depth + 1, right_node, right_below, right_at);
        if count >= FORK_MIN {
            let (left, right) = rayon::join(grow_left, grow_right);
            left.and(right)?;
        } else {
            grow_left()?;
            grow_right()?;
        }
        if count >= CHECK_MIN {
            let small = [left.refs.len(), right.refs.len()].into_iter().filter(|&count| count < CHECK_MIN);
            self.task.advance(small.sum::<usize>() as u64);
        }
        let bounds: Aabb = left_node.bounds.union(right_node.bounds);
        *node = Bvh2Node { bounds, first: at, count: 0 };
        Ok(())
    }

    /// How many codes come before the highest bit that they do not share; half where they are equal, or the depth runs out.
    fn split(&self, codes: &[u64], depth: usize) -> usize {
        let count = codes.len();
        let differing = codes[0] ^ codes[count - 1];
        let mid = match differing.checked_ilog2() {
            Some(bit) => codes.partition_point(|code| code >> bit & 1 == 0),
            None => count / 2,
        };
        if fits_depth(&self.single, mid.max(count - mid), depth + 1) { mid } else { count / 2 }
    }
}

impl<'a> Run<'a> {
    fn halves(self, mid: usize) -> [Self; 2] {
        let (left_codes, right_codes) = self.codes.split_at(mid);
        let (left_refs, right_refs) = self.refs.split_at(mid);
        [
            Self { codes: left_codes, refs: left_refs, first: self.first },
            Self { codes: right_codes, refs: right_refs, first: self.first + mid as u32 },
        ]
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn points(points: &[Vec3]) -> Vec<BuildRef> {
        let of = |(i, &p): (usize, &Vec3)| BuildRef::new(&Aabb::from_points([p]), i as u32);
        points.iter().enumerate().map(of).collect()
    }

    #[test]
    fn nodes_split_where_the_highest_bit_changes() {
        // On a line of cells 0 to 1023, at 30 bits: 5 and 6 share more bits than 1 and 5.
        let refs = points(&[0.0, 1.5, 5.5, 6.5, 700.5, 1024.0].map(|x| Vec3::new(x, 0.0, 0.0)));
        let config = BuildConfig { morton: crate::accel::Morton::Bits30, ..BuildConfig::default() };
        let bvh = build(&refs, &config, &Task::new()).expect("not cancelled");
        let below = |node: u32| -> Vec<u32> {
            let (mut found, mut open) = (Vec::new(), vec![node]);
            while let Some(at) = open.pop() {
                let node = bvh.nodes[at as usize];
                if node.is_leaf() {
                    found.extend(&bvh.refs[node.range()])
                } else {
                    open.extend(node.children())
                }
            }
            found.sort_unstable();
            found
        };
        let [low, high] = bvh.nodes[0].children();
        assert_eq!((below(low), below(high)), (vec![0, 1, 2, 3], vec![4, 5]));
        let [low, high] = bvh.nodes[low as usize].children();
        assert_eq!((below(low), below(high)), (vec![0, 1], vec![2, 3]));
        assert_eq!(bvh, bvh.in_depth_first_order());
    }

    #[test]
    fn long_chains_of_bits_stay_within_the_depth_limit() {
        // Every point lies alone in its half, of each axis in turn, and the last cell holds many.
        let mut at: Vec<Vec3> = (0..63)
            .map(|i: i32| {
                let half = |axis: i32| if i % 3 == axis { 0.5_f32.powi(i / 3 + 1) } else { 0.0 };
                Vec3::new(half(0), half(1), half(2))
            })
            .collect();
        at.push(Vec3::ONE);
        at.extend([Vec3::ZERO; 5000]);
        let bvh = build(&points(&at), &BuildConfig::default(), &Task::new()).expect("not cancelled");
        let deepest = bvh.depth_max();
        assert!((40..=BuildConfig::MAX_DEPTH).contains(&deepest), "{deepest}");
    }
}
