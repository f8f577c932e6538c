//! The compressed 8-wide tree: nodes of 80 bytes, whose children's boxes are kept as bytes on a grid over the node (Ylitie,
//! Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).
//!
//! A side is `origin + byte * quantum`, computed in single precision: the product is exact, since the quantum is a power of
//! two, and the sum is rounded once. Bytes are chosen by this very arithmetic so that a box is never smaller than what it
//! holds.

use glam::Vec3;

use crate::geometry::Aabb;

use super::tree::{ChildRef, LeafRange, Nodes, Walked, WideBvh};

/// Children of a node.
const WIDTH: usize = 8;

/// An inner node with up to eight children; filled slots come first. Inner children lie side by side, as leaves do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct CompressedNode {
    /// The lower corner of the node.
    origin: [f32; 3],
    /// Of each axis the exponent of the quantum as a float keeps it; 0 where the node has no extent.
    exponents: [u8; 3],
    /// Bit i for slot i.
    filled: u8,
    /// The first inner child and the first leaf, as [`ChildRef`] keeps them.
    first: [u32; 2],
    /// What a slot holds: its number among the inner children, or [`LEAF`] and its number among the leaves.
    meta: [u8; WIDTH],
    /// Rows as in [`WideNode::sides`](super::tree::WideNode::sides).
    sides: [[u8; WIDTH]; 6],
}

/// Set in [`CompressedNode::meta`] for a leaf.
const LEAF: u8 = 1 << 7;

/// Where the references of some leaves are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LeafGroup {
    /// The first reference of the first leaf.
    first: u32,
    /// Two bits a leaf: how many references it has.
    counts: u32,
}

/// Leaves whose references are found together.
const GROUP: usize = 16;

/// A compressed 8-wide tree, ready to be walked.
#[derive(Clone, Debug, PartialEq)]
pub struct CompressedBvh {
    pub root: ChildRef,
    /// Around the boxes of the root's children.
    pub bounds: Aabb,
    pub nodes: Vec<CompressedNode>,
    leaf_groups: Vec<LeafGroup>,
    leaf_count: usize,
    /// Shape indices in leaf order.
    pub refs: Vec<u32>,
    /// Of the deepest leaf; the root is at depth 0.
    pub depth_max: u32,
}

/// A side, as rays see it.
#[inline(always)]
fn side(origin: f32, quantum: f32, byte: u8) -> f32 {
    origin + f32::from(byte) * quantum
}

/// The power of two with this exponent; 0 for 0.
#[inline(always)]
fn power(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << (f32::MANTISSA_DIGITS - 1))
}

/// The least exponent with which the grid reaches from `min` to `max`.
fn exponent(min: f32, max: f32) -> u8 {
    let reaches = |exponent: u8| side(min, power(exponent), u8::MAX) >= max;
    if reaches(0) {
        return 0;
    }
    // That of a 255th, or a neighbour of it.
    let near = (((max - min) / f32::from(u8::MAX)).to_bits() >> (f32::MANTISSA_DIGITS - 1)) as u8;
    let mut exponent = near.saturating_sub(1).max(1);
    while !reaches(exponent) {
        exponent += 1;
    }
    exponent
}

/// The greatest byte whose side is not above `at`, which is not below the origin.
fn byte_below(origin: f32, quantum: f32, at: f32) -> u8 {
    // What is no number becomes 0.
    let mut byte = ((at - origin) / quantum) as u8;
    while side(origin, quantum, byte) > at {
        byte -= 1;
    }
    byte
}

/// The least byte whose side is not below `at`, which the grid reaches.
fn byte_above(origin: f32, quantum: f32, at: f32) -> u8 {
    let mut byte = ((at - origin) / quantum).ceil() as u8;
    while byte > 0 && side(origin, quantum, byte - 1) >= at {
        byte -= 1;
    }
    while side(origin, quantum, byte) < at {
        byte += 1;
    }
    byte
}

impl CompressedNode {
    /// A node with children of these boxes. What they are is not said yet.
    fn over(children: &[Aabb]) -> Self {
        let bounds = children.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        let origin = bounds.min.to_array();
        let exponents = [0, 1, 2].map(|axis| exponent(origin[axis], bounds.max[axis]));
        let mut sides = [[0; WIDTH]; 6];
        for axis in 0..3 {
            let quantum = power(exponents[axis]);
            for (slot, child) in children.iter().enumerate() {
                sides[axis][slot] = byte_below(origin[axis], quantum, child.min[axis]);
                sides[3 + axis][slot] = byte_above(origin[axis], quantum, child.max[axis]);
            }
        }
        let filled = ((1_u32 << children.len()) - 1) as u8;
        Self { origin, exponents, filled, first: [0; 2], meta: [0; WIDTH], sides }
    }

    /// Bit i for slot i: the slots that hold a child.
    #[inline(always)]
    pub fn filled(&self) -> u32 {
        self.filled.into()
    }

    /// Children that are there.
    #[inline(always)]
    pub fn child_count(&self) -> usize {
        self.filled.count_ones() as usize
    }

    /// What a slot holds that is filled.
    #[inline(always)]
    pub fn child(&self, slot: usize) -> ChildRef {
        let meta = self.meta[slot];
        ChildRef(self.first[usize::from(meta >> 7)] + u32::from(meta & !LEAF))
    }

    #[inline(always)]
    pub fn origin(&self, axis: usize) -> f32 {
        self.origin[axis]
    }

    #[inline(always)]
    pub fn quantum(&self, axis: usize) -> f32 {
        power(self.exponents[axis])
    }

    /// The bytes of a row of [`WideNode::sides`](super::tree::WideNode::sides) as numbers, exactly.
    #[inline(always)]
    pub fn bytes(&self, row: usize) -> [f32; WIDTH] {
        let [a, b, c, d, e, f, g, h] = self.sides[row];
        [a.into(), b.into(), c.into(), d.into(), e.into(), f.into(), g.into(), h.into()]
    }

    /// The six sides of a child's box, in the order of the rows.
    #[inline(always)]
    pub fn child_sides(&self, slot: usize) -> [f32; 6] {
        let one = |row: usize| side(self.origin[row % 3], self.quantum(row % 3), self.sides[row][slot]);
        [one(0), one(1), one(2), one(3), one(4), one(5)]
    }

    pub fn child_bounds(&self, slot: usize) -> Aabb {
        let [min_x, min_y, min_z, max_x, max_y, max_z] = self.child_sides(slot);
        Aabb { min: Vec3::new(min_x, min_y, min_z), max: Vec3::new(max_x, max_y, max_z) }
    }
}

impl CompressedBvh {
    /// Most references in a leaf.
    pub const LEAF: usize = 3;

    /// The same tree, compressed. Boxes grow by less than a quantum a side, and each still lies inside its parent's: a node's
    /// grid is laid over the boxes that its children have after they were compressed.
    ///
    /// # Panics
    /// If a leaf holds more than [`CompressedBvh::LEAF`] references.
    pub fn new(tree: &WideBvh<WIDTH>) -> Self {
        let (mut nodes, bounds) = compressed_nodes(tree);
        let mut out = Self {
            root: tree.root,
            bounds,
            nodes: Vec::with_capacity(nodes.len()),
            leaf_groups: Vec::with_capacity(tree.leaves.len().div_ceil(GROUP)),
            leaf_count: 0,
            refs: Vec::with_capacity(tree.refs.len()),
            depth_max: tree.depth_max,
        };
        if let Some(leaf_idx) = tree.root.as_leaf() {
            out.push_leaf(tree, leaf_idx);
        }
        // Wide nodes in the order in which they are written: siblings side by side, else depth first.
        let mut order = vec![0_u32; nodes.len()];
        let mut next = 1;
        let mut open = if nodes.is_empty() { Vec::new() } else { vec![0_u32] };
        while let Some(at) = open.pop() {
            let wide_idx = order[at as usize] as usize;
            let node = &mut nodes[wide_idx];
            let first_child = next;
            node.first = [first_child, ChildRef::leaf(out.leaf_count as u32).0];
            let mut leaves = 0;
            for (slot, child) in tree.nodes[wide_idx].children.into_iter().enumerate() {
                if let Some(child_idx) = child.as_inner() {
                    node.meta[slot] = (next - first_child) as u8;
                    order[next as usize] = child_idx;
                    next += 1;
                } else if let Some(leaf_idx) = child.as_leaf() {
                    node.meta[slot] = LEAF | leaves;
                    leaves += 1;
                    out.push_leaf(tree, leaf_idx);
                }
            }
            open.extend((first_child..next).rev());
        }
        out.nodes.extend(order.iter().map(|&wide_idx| nodes[wide_idx as usize]));
        out
    }

    fn push_leaf(&mut self, tree: &WideBvh<WIDTH>, leaf_idx: u32) {
        let LeafRange { first, count } = tree.leaves[leaf_idx as usize];
        assert!(
            (1..=Self::LEAF).contains(&(count as usize)),
            "a leaf of {count} references cannot be compressed"
        );
        let within = self.leaf_count % GROUP;
        if within == 0 {
            self.leaf_groups.push(LeafGroup { first: self.refs.len() as u32, counts: 0 });
        }
        if let Some(group) = self.leaf_groups.last_mut() {
            group.counts |= count << (2 * within);
        }
        self.refs.extend_from_slice(&tree.refs[first as usize..][..count as usize]);
        self.leaf_count += 1;
    }

    /// Bytes of nodes, leaves and references.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaf_groups[..]) + size_of_val(&self.refs[..])
    }

    pub fn walked(&self) -> Walked<'_, CompressedNode> {
        Walked { root: self.root, bounds: &self.bounds, nodes: &self.nodes, depth_max: self.depth_max }
    }
}

/// All nodes, with the numbers that they have in `tree`, and the box around them.
fn compressed_nodes(tree: &WideBvh<WIDTH>) -> (Vec<CompressedNode>, Aabb) {
    let mut boxes = vec![Aabb::EMPTY; tree.nodes.len()];
    let mut nodes = Vec::with_capacity(tree.nodes.len());
    // Children lie behind their parents.
    for (node_idx, wide) in tree.nodes.iter().enumerate().rev() {
        let mut children = [Aabb::EMPTY; WIDTH];
        let count = wide.child_count();
        for (slot, child) in children[..count].iter_mut().enumerate() {
            *child = match wide.children[slot].as_inner() {
                Some(child_idx) => boxes[child_idx as usize],
                None => wide.child_bounds(slot),
            };
        }
        let node = CompressedNode::over(&children[..count]);
        boxes[node_idx] = (0..count).fold(Aabb::EMPTY, |all, slot| all.union(node.child_bounds(slot)));
        nodes.push(node);
    }
    nodes.reverse();
    (nodes, boxes.first().copied().unwrap_or(tree.bounds))
}

impl Nodes for CompressedBvh {
    const WIDTH: usize = WIDTH;

    fn root(&self) -> ChildRef {
        self.root
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn depth_max(&self) -> u32 {
        self.depth_max
    }

    fn inner_count(&self) -> usize {
        self.nodes.len()
    }

    fn leaf_count(&self) -> usize {
        self.leaf_count
    }

    fn leaf_range(&self, leaf_idx: u32) -> LeafRange {
        let LeafGroup { first, counts } = self.leaf_groups[leaf_idx as usize / GROUP];
        let shift = 2 * (leaf_idx as usize % GROUP);
        let before = counts & ((1_u32 << shift) - 1);
        let ones = (before & 0x5555_5555).count_ones();
        let twos = (before & 0xaaaa_aaaa).count_ones();
        LeafRange { first: first + ones + 2 * twos, count: counts >> shift & 3 }
    }

    fn refs(&self) -> &[u32] {
        &self.refs
    }

    fn slot(&self, node_idx: u32, slot: usize) -> (ChildRef, Aabb) {
        let node = &self.nodes[node_idx as usize];
        match node.filled >> slot & 1 {
            0 => (ChildRef::EMPTY, Aabb::EMPTY),
            _ => (node.child(slot), node.child_bounds(slot)),
        }
    }

    fn box_slack(&self, node_idx: u32) -> Vec3 {
        let node = &self.nodes[node_idx as usize];
        let slack = [0, 1, 2].map(|axis| {
            let (origin, quantum) = (node.origin[axis], node.quantum(axis));
            // A side is rounded, and what is rounded is compared.
            quantum + 2.0 * f32::EPSILON * origin.abs().max(side(origin, quantum, u8::MAX).abs())
        });
        Vec3::from_array(slack)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::accel::validate::validate;
    use crate::accel::{BuildConfig, Layout, Tree, build};
    use crate::task::Task;

    #[test]
    fn a_node_has_80_bytes() {
        assert_eq!(size_of::<CompressedNode>(), 80);
        assert_eq!(size_of::<LeafGroup>(), 8);
    }

    /// Boxes of all sizes: none at all along some axes, next to nothing, or all there is, near and far from the origin.
    fn boxes(rng: &mut Pcg32) -> Vec<Aabb> {
        let count = rng.random_range(1..=WIDTH);
        let number = |rng: &mut Pcg32| f32::from_bits(rng.random::<u32>() & 0x7fff_ffff);
        let finite = |rng: &mut Pcg32| loop {
            let x = number(rng);
            if x <= f32::MAX / 4.0 {
                return x;
            }
        };
        let kind = rng.random_range(0..5);
        let center = Vec3::from_array(std::array::from_fn(|_| match kind {
            0 => 0.0,
            1 => 1000.3,
            2 => finite(rng),
            _ => rng.random_range(-10.0..10.0),
        }));
        let size = if kind == 3 { 1e-6 } else { 1.0 };
        let size: [f32; 3] = std::array::from_fn(|_| match rng.random_range(0..4) {
            0 => 0.0,
            1 if kind < 3 => finite(rng),
            _ => size,
        });
        let point = |rng: &mut Pcg32| {
            let unit = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..=1.0)));
            center + unit * Vec3::from_array(size)
        };
        (0..count).map(|_| Aabb::from_points([point(rng), point(rng)])).collect()
    }

    #[test]
    fn a_box_is_never_smaller_than_what_it_holds_and_less_than_a_quantum_larger() {
        let mut rng = Pcg32::seed_from_u64(11);
        for _ in 0..200_000 {
            let boxes = boxes(&mut rng);
            let node = CompressedNode::over(&boxes);
            assert_eq!(node.child_count(), boxes.len());
            let whole = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
            for (slot, whole_child) in boxes.iter().enumerate() {
                let found = node.child_bounds(slot);
                assert!(found.contains(whole_child), "{found:?} {whole_child:?} {node:?}");
                for axis in 0..3 {
                    let (quantum, origin) = (node.quantum(axis), node.origin(axis));
                    let rounding = 2.0 * f32::EPSILON * origin.abs().max(whole.max[axis].abs());
                    let off = (whole_child.min[axis] - found.min[axis])
                        .max(found.max[axis] - whole_child.max[axis]);
                    assert!(off <= quantum + rounding, "{off} {quantum} {boxes:?}");
                    // No grid is coarser than it must be, but for one that is the finest there is.
                    let half = side(origin, quantum * 0.5, u8::MAX) >= whole.max[axis];
                    assert!(!half || node.exponents[axis] <= 1, "{node:?} {whole:?}");
                }
            }
        }
    }

    fn soup(count: usize) -> Vec<Aabb> {
        let mut rng = Pcg32::seed_from_u64(5);
        let mut vec = |size: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..size)));
        (0..count)
            .map(|_| {
                let min = vec(10.0);
                Aabb::new(min, min + vec(0.5))
            })
            .collect()
    }

    #[test]
    fn a_compressed_tree_is_the_full_one_in_a_third_of_the_bytes() {
        for count in [0, 1, 3, 4, 40, 3000] {
            let boxes = soup(count);
            let full = BuildConfig { leaf: 3, ..BuildConfig::default() };
            let tree = |config| build(&boxes, &config, &Task::new()).expect("not cancelled").0;
            let (full, compressed) = (tree(full), tree(BuildConfig { layout: Layout::Compressed, ..full }));
            assert_eq!(validate(&compressed, &boxes), []);
            assert_eq!(full.inner_count(), compressed.inner_count());
            assert_eq!(full.depth_max(), compressed.depth_max());
            let leaves = |tree: &Tree| {
                let mut leaves: Vec<_> =
                    (0..tree.leaf_count()).map(|i| tree.leaf_shapes(i as u32).to_vec()).collect();
                leaves.sort_unstable();
                leaves
            };
            assert_eq!(leaves(&full), leaves(&compressed), "{count}");
            assert!(
                count < 3000 || compressed.bytes() * 2 < full.bytes(),
                "{} {}",
                compressed.bytes(),
                full.bytes()
            );
        }
    }

    #[test]
    fn leaves_are_capped() {
        let boxes = soup(1000);
        for leaf in [1, 2, 64] {
            let config = BuildConfig { leaf, layout: Layout::Compressed, ..BuildConfig::default() };
            let (tree, report) = build(&boxes, &config, &Task::new()).expect("not cancelled");
            let most = (0..tree.leaf_count()).map(|i| tree.leaf_shapes(i as u32).len()).max();
            assert_eq!(most, Some(leaf.min(CompressedBvh::LEAF)));
            assert_eq!(report.config, config);
        }
    }
}
