//! The leaves' geometry in leaf order: blocks of triangles as structure of arrays, one array for each other shape.

use fearless_simd::Simd;
use rayon::prelude::*;

use crate::accel::simd::Instructions;
use crate::accel::tree::LeafRange;
use crate::accel::{LeafIntersector, Probe, Tree};
use crate::geometry::quad::FlatQuad;
use crate::geometry::{Aabb, Cuboid, PreparedRay, Shape, ShapeHit, Span, Sphere, Torus};
use crate::scene::Scene;
use crate::task::{Cancelled, Task};

use super::best::Best;
use super::block::{LANES, LaneRay, TriangleBlock};

/// Leaves packed by one thread at a time; small enough to look for a cancel between them.
const LEAVES_A_PIECE: usize = 4096;

/// Plain data, owned, that can be copied to a graphics card.
///
/// The block of a leaf's first triangles has the leaf's own index, so that a ray finds it without a detour. What else a
/// leaf holds is found by way of `rest_of`.
#[derive(Clone, Debug, Default)]
pub struct PrimStore {
    blocks: Vec<TriangleBlock>,
    /// A leaf's index in `rests`, [`NO_REST`] for none; empty if no leaf has any.
    rest_of: Vec<u32>,
    rests: Vec<Rest>,
    more_blocks: Vec<TriangleBlock>,
    spheres: Vec<Stored<Sphere>>,
    cuboids: Vec<Stored<Cuboid>>,
    quads: Vec<Stored<FlatQuad>>,
    tori: Vec<Stored<Torus>>,
}

const NO_REST: u32 = u32::MAX;

/// What a leaf holds beside its first block, as ranges of the arrays.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    blocks: Range,
    spheres: Range,
    cuboids: Range,
    quads: Range,
    tori: Range,
}

#[derive(Clone, Copy, Debug, Default)]
struct Range {
    first: u32,
    count: u32,
}

impl Range {
    #[inline]
    fn of<T>(self, all: &[T]) -> &[T] {
        &all[self.first as usize..][..self.count as usize]
    }

    /// Adds an element to the array's end and to this range, which is the last one of the array.
    fn push<T>(&mut self, all: &mut Vec<T>, element: T) {
        if self.count == 0 {
            self.first = index(all.len());
        }
        self.count += 1;
        all.push(element);
    }

    fn moved(self, by: usize) -> Self {
        Self { first: self.first + index(by), ..self }
    }
}

/// A shape with its box and its index in the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored<S> {
    pub bounds: Aabb,
    pub geometry: S,
    pub shape: u32,
}

/// Shapes of one leaf, in the order in which they are tested.
#[derive(Clone, Copy, Debug)]
pub(super) struct Others<'a> {
    pub spheres: &'a [Stored<Sphere>],
    pub cuboids: &'a [Stored<Cuboid>],
    pub quads: &'a [Stored<FlatQuad>],
    pub tori: &'a [Stored<Torus>],
}

fn index(len: usize) -> u32 {
    u32::try_from(len).expect("a tree has less than 2^32 references")
}

impl PrimStore {
    /// Packs the shapes that the tree's leaves refer to.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn new(scene: &Scene, tree: &Tree, task: &Task) -> Result<Self, Cancelled> {
        // Of pages that are first touched where they are filled.
        let mut store = Self { blocks: bytemuck::zeroed_vec(tree.leaf_count()), ..Self::default() };
        let leaves = tree.leaf_ranges();
        let leaves = leaves.par_chunks(LEAVES_A_PIECE);
        let pieces = store.blocks.par_chunks_mut(LEAVES_A_PIECE).zip(leaves).map(|(blocks, leaves)| {
            task.check()?;
            Ok(Self::pack(scene, tree.refs(), leaves, blocks))
        });
        let pieces = pieces.collect::<Result<Vec<Self>, Cancelled>>()?;
        if pieces.iter().any(|piece| !piece.rests.is_empty()) {
            store.rest_of = vec![NO_REST; tree.leaf_count()];
            for (i, piece) in pieces.into_iter().enumerate() {
                store.append(piece, i * LEAVES_A_PIECE);
            }
        }
        Ok(store)
    }

    /// Fills the blocks of some leaves and answers the rests of those that have one, `rest_of` by leaf.
    fn pack(scene: &Scene, refs: &[u32], leaves: &[LeafRange], blocks: &mut [TriangleBlock]) -> Self {
        let mut piece = Self::default();
        let of_leaf = |leaf: &LeafRange| &refs[leaf.first as usize..][..leaf.count as usize];
        let shapes: Vec<u32> = leaves.iter().flat_map(of_leaf).copied().collect();
        let mut geometry = scene.gather(&shapes).into_iter();
        let mut triangles = Vec::new();
        for (i, (leaf, block)) in leaves.iter().zip(blocks).enumerate() {
            let mut rest = Rest::default();
            triangles.clear();
            for (&shape, geometry) in of_leaf(leaf).iter().zip(geometry.by_ref()) {
                match geometry {
                    Shape::Triangle(triangle) => triangles.push((shape, triangle)),
                    Shape::Sphere(geometry) => {
                        rest.spheres
                            .push(&mut piece.spheres, Stored { bounds: geometry.bounds(), geometry, shape });
                    }
                    Shape::Cuboid(geometry) => {
                        rest.cuboids
                            .push(&mut piece.cuboids, Stored { bounds: geometry.bounds(), geometry, shape });
                    }
                    Shape::Quad(quad) => {
                        let geometry = quad.flat();
                        rest.quads.push(&mut piece.quads, Stored { bounds: quad.bounds(), geometry, shape });
                    }
                    Shape::Torus(geometry) => {
                        rest.tori.push(&mut piece.tori, Stored { bounds: geometry.bounds(), geometry, shape })
                    }
                }
            }
            let goes_on = triangles.len() < leaf.count as usize || triangles.len() > LANES;
            let (first, others) = triangles.split_at(triangles.len().min(LANES));
            *block = TriangleBlock::new(first, goes_on);
            if goes_on {
                for others in others.chunks(LANES) {
                    rest.blocks.push(&mut piece.more_blocks, TriangleBlock::new(others, false));
                }
                piece.rest_of.push(index(i));
                piece.rests.push(rest);
            }
        }
        piece
    }

    /// Adds the rests of the leaves from `first_leaf` on.
    fn append(&mut self, piece: Self, first_leaf: usize) {
        for (leaf, rest) in piece.rest_of.into_iter().zip(piece.rests) {
            self.rest_of[first_leaf + leaf as usize] = index(self.rests.len());
            self.rests.push(Rest {
                blocks: rest.blocks.moved(self.more_blocks.len()),
                spheres: rest.spheres.moved(self.spheres.len()),
                cuboids: rest.cuboids.moved(self.cuboids.len()),
                quads: rest.quads.moved(self.quads.len()),
                tori: rest.tori.moved(self.tori.len()),
            });
        }
        self.more_blocks.extend(piece.more_blocks);
        self.spheres.extend(piece.spheres);
        self.cuboids.extend(piece.cuboids);
        self.quads.extend(piece.quads);
        self.tori.extend(piece.tori);
    }

    /// Bytes of the shapes in leaf order and of what finds them.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.blocks[..])
            + size_of_val(&self.rest_of[..])
            + size_of_val(&self.rests[..])
            + size_of_val(&self.more_blocks[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.cuboids[..])
            + size_of_val(&self.quads[..])
            + size_of_val(&self.tori[..])
    }

    /// The first block of a leaf.
    #[inline(always)]
    pub(super) fn block(&self, leaf_idx: u32) -> &TriangleBlock {
        &self.blocks[leaf_idx as usize]
    }

    /// The other blocks of a leaf that [goes on](TriangleBlock::goes_on).
    #[inline(always)]
    pub(super) fn further_blocks(&self, leaf_idx: u32) -> &[TriangleBlock] {
        self.rest(leaf_idx).blocks.of(&self.more_blocks)
    }

    /// What the leaf of this first block holds beside it.
    #[inline]
    fn rest(&self, leaf_idx: u32) -> &Rest {
        &self.rests[self.rest_of[leaf_idx as usize] as usize]
    }

    /// Tests every shape of a leaf and keeps the nearest. `t_min` is the start of the interval in which a shape counts, the
    /// ray's or later.
    #[inline(always)]
    fn nearest<'a, S: Simd, P: Probe>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        t_min: impl Fn(u32) -> f32 + Copy,
        best: &mut Best<'a>,
        probe: &mut P,
    ) {
        let lane_ray = LaneRay::new(simd, ray);
        let block = &self.blocks[leaf_idx as usize];
        nearest_of_block(block, &lane_ray, t_min, best, probe);
        if block.goes_on() {
            for block in self.further_blocks(leaf_idx) {
                nearest_of_block(block, &lane_ray, t_min, best, probe);
            }
            let (others, query) = (self.others(leaf_idx), Nearest { ray, t_min });
            query.among(others.spheres, Sphere::intersect_in, best, probe);
            query.among(others.cuboids, Cuboid::intersect_in, best, probe);
            query.among(others.quads, FlatQuad::intersect_in, best, probe);
            query.among(others.tori, Torus::intersect_in, best, probe);
        }
    }

    /// The first shape of a leaf that blocks and is hit. Shapes other than triangles that do not block are not tested.
    #[inline(always)]
    fn any<S: Simd, P: Probe>(
        &self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        t_min: impl Fn(u32) -> f32 + Copy,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        let lane_ray = LaneRay::new(simd, ray);
        let block = &self.blocks[leaf_idx as usize];
        let found = any_of_block(block, &lane_ray, t_min, blocks, probe);
        if found.is_some() || !block.goes_on() {
            return found;
        }
        for block in self.further_blocks(leaf_idx) {
            let found = any_of_block(block, &lane_ray, t_min, blocks, probe);
            if found.is_some() {
                return found;
            }
        }
        let (others, query) = (self.others(leaf_idx), Any { ray, t_min, blocks });
        query
            .among(others.spheres, Sphere::intersect_in, probe)
            .or_else(|| query.among(others.cuboids, Cuboid::intersect_in, probe))
            .or_else(|| query.among(others.quads, FlatQuad::intersect_in, probe))
            .or_else(|| query.among(others.tori, Torus::intersect_in, probe))
    }

    /// The shapes of a leaf that [goes on](TriangleBlock::goes_on) that are no triangles.
    #[inline(always)]
    pub(super) fn others(&self, leaf_idx: u32) -> Others<'_> {
        let rest = self.rest(leaf_idx);
        Others {
            spheres: rest.spheres.of(&self.spheres),
            cuboids: rest.cuboids.of(&self.cuboids),
            quads: rest.quads.of(&self.quads),
            tori: rest.tori.of(&self.tori),
        }
    }
}

#[inline(always)]
fn nearest_of_block<'a, S: Simd, P: Probe>(
    block: &'a TriangleBlock,
    ray: &LaneRay<S>,
    t_min: impl Fn(u32) -> f32,
    best: &mut Best<'a>,
    probe: &mut P,
) {
    probe.shapes_tested(block.count());
    let candidates = block.candidates(ray, best.t_max());
    for lane in candidates.lanes() {
        let decided = match candidates.inside(block, lane) {
            Some(passed) => best.pass(passed),
            None => false,
        };
        if !decided {
            let shape = block.shape(lane);
            best.keep(
                &ray.ray().ray,
                shape,
                block.confirm(&candidates, lane, ray, t_min(shape), best.t_max()),
            );
        }
    }
}

#[inline(always)]
fn any_of_block<S: Simd, P: Probe>(
    block: &TriangleBlock,
    ray: &LaneRay<S>,
    t_min: impl Fn(u32) -> f32,
    blocks: &impl Fn(u32) -> bool,
    probe: &mut P,
) -> Option<u32> {
    probe.shapes_tested(block.count());
    let t_max = ray.t_max();
    let candidates = block.candidates(ray, t_max);
    // A loop: a closure would not be compiled for the level's instructions.
    for lane in candidates.lanes() {
        let shape = block.shape(lane);
        if blocks(shape) {
            let t_min = t_min(shape);
            let sure = candidates.is_sure(lane) && t_min == ray.t_min();
            if sure || block.confirm(&candidates, lane, ray, t_min, t_max).is_some() {
                return Some(shape);
            }
        }
    }
    None
}

/// A query for the nearest among the shapes of one kind.
struct Nearest<'a, T> {
    ray: &'a PreparedRay,
    t_min: T,
}

impl<T: Fn(u32) -> f32> Nearest<'_, T> {
    #[inline]
    fn among<S, P: Probe>(
        &self,
        stored: &[Stored<S>],
        test: impl Fn(&S, &PreparedRay, &Span) -> Option<ShapeHit>,
        best: &mut Best<'_>,
        probe: &mut P,
    ) {
        for Stored { bounds, geometry, shape } in stored {
            probe.shapes_tested(1);
            if let Some(span) = Span::new(self.ray, bounds, (self.t_min)(*shape), best.t_max()) {
                best.keep(&self.ray.ray, *shape, test(geometry, self.ray, &span));
            }
        }
    }
}

/// A query for any blocking one among the shapes of one kind.
struct Any<'a, T, B> {
    ray: &'a PreparedRay,
    t_min: T,
    blocks: &'a B,
}

impl<T: Fn(u32) -> f32, B: Fn(u32) -> bool> Any<'_, T, B> {
    #[inline]
    fn among<S, P: Probe>(
        &self,
        stored: &[Stored<S>],
        test: impl Fn(&S, &PreparedRay, &Span) -> Option<ShapeHit>,
        probe: &mut P,
    ) -> Option<u32> {
        let mut blocking = stored.iter().filter(|s| (self.blocks)(s.shape));
        blocking.find_map(|Stored { bounds, geometry, shape }| {
            probe.shapes_tested(1);
            let span = Span::new(self.ray, bounds, (self.t_min)(*shape), self.ray.ray.t_max)?;
            test(geometry, self.ray, &span).map(|_| *shape)
        })
    }
}

impl LeafIntersector for PrimStore {
    type Best<'a>
        = Best<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn prefetch<S: Instructions>(&self, simd: S, leaf_idx: u32) {
        simd.prefetch(&self.blocks, leaf_idx as usize);
    }

    #[inline(always)]
    fn t_max(best: &Best<'_>) -> f32 {
        best.t_max()
    }

    #[inline(always)]
    fn intersect<'a, S: Simd, P: Probe>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        best: &mut Best<'a>,
        probe: &mut P,
    ) {
        let t_min = ray.ray.t_min;
        self.nearest(simd, leaf_idx, ray, |_| t_min, best, probe);
    }

    #[inline(always)]
    fn occluded<S: Simd, P: Probe>(
        &self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        let t_min = ray.ray.t_min;
        self.any(simd, leaf_idx, ray, |_| t_min, blocks, probe)
    }
}

/// The leaves as a ray sees them that has passed the hit of `shape` at `t`: hits count that come after it, in order of
/// t and then of the shape. What lies at the same t is neither lost nor found twice, and every answer comes after the
/// one before, so that going on from hit to hit ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beyond<'a> {
    pub store: &'a PrimStore,
    pub t: f32,
    pub shape: u32,
}

impl Beyond<'_> {
    /// From where on a shape's hits come after the one that was passed.
    #[inline]
    pub fn t_min(&self, shape: u32) -> f32 {
        if shape <= self.shape { self.t.next_up() } else { self.t }
    }
}

impl LeafIntersector for Beyond<'_> {
    type Best<'a>
        = Best<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn t_max(best: &Best<'_>) -> f32 {
        best.t_max()
    }

    #[inline(always)]
    fn intersect<'a, S: Simd, P: Probe>(
        &'a self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        best: &mut Best<'a>,
        probe: &mut P,
    ) {
        self.store.nearest(simd, leaf_idx, ray, |shape| self.t_min(shape), best, probe);
    }

    #[inline(always)]
    fn occluded<S: Simd, P: Probe>(
        &self,
        simd: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        self.store.any(simd, leaf_idx, ray, |shape| self.t_min(shape), blocks, probe)
    }
}
