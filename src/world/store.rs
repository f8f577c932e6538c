//! The leaves' geometry in leaf order: blocks of triangles as structure of arrays, one array for each other shape.

use rayon::prelude::*;

use crate::accel::tree::LeafRange;
use crate::accel::{LeafIntersector, Probe, Tree};
use crate::geometry::{Cuboid, Hit, PreparedRay, Quad, Shape, ShapeHit, Sphere, Torus};
use crate::scene::Scene;
use crate::task::{Cancelled, Task};

use super::block::{LANES, LaneRay, TriangleBlock};

/// Leaves packed by one thread at a time; small enough to look for a cancel between them.
const LEAVES_A_PIECE: usize = 4096;

/// Plain data, owned, that can be copied to a graphics card.
#[derive(Clone, Debug, Default)]
pub struct PrimStore {
    leaves: Vec<Leaf>,
    blocks: Vec<TriangleBlock>,
    /// For the leaves that hold other shapes than triangles.
    others: Vec<Others>,
    spheres: Vec<Stored<Sphere>>,
    cuboids: Vec<Stored<Cuboid>>,
    quads: Vec<Stored<Quad>>,
    tori: Vec<Stored<Torus>>,
}

/// Where a leaf's shapes lie.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    /// Its triangles fill blocks from here on; only the last one may have lanes left.
    first_block: u32,
    triangle_count: u32,
    /// Index into [`PrimStore::others`], or [`Leaf::NO_OTHERS`].
    others: u32,
}

impl Leaf {
    const NO_OTHERS: u32 = u32::MAX;
}

/// A leaf's ranges in the arrays of the other shapes.
#[derive(Clone, Copy, Debug, Default)]
struct Others {
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
}

/// A shape with its index in the scene.
#[derive(Clone, Copy, Debug)]
struct Stored<S> {
    geometry: S,
    shape: u32,
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
        let pieces = tree
            .leaves()
            .par_chunks(LEAVES_A_PIECE)
            .map(|leaves| task.check().map(|()| Self::piece(scene, tree.refs(), leaves)))
            .collect::<Result<Vec<Self>, Cancelled>>()?;
        let mut store = Self::default();
        store.leaves.reserve_exact(tree.leaf_count());
        store.blocks.reserve_exact(pieces.iter().map(|piece| piece.blocks.len()).sum());
        for piece in pieces {
            store.append(piece);
        }
        Ok(store)
    }

    fn piece(scene: &Scene, refs: &[u32], leaves: &[LeafRange]) -> Self {
        let mut piece = Self::default();
        let mut triangles = Vec::new();
        for leaf in leaves {
            let (mut others, mut has_others) = (Others::default(), false);
            triangles.clear();
            for &shape in &refs[leaf.first as usize..][..leaf.count as usize] {
                let geometry = scene.shape(shape);
                has_others |= !matches!(geometry, Shape::Triangle(_));
                match geometry {
                    Shape::Triangle(triangle) => triangles.push((shape, triangle)),
                    Shape::Sphere(geometry) => {
                        others.spheres.push(&mut piece.spheres, Stored { geometry, shape });
                    }
                    Shape::Cuboid(geometry) => {
                        others.cuboids.push(&mut piece.cuboids, Stored { geometry, shape });
                    }
                    Shape::Quad(geometry) => others.quads.push(&mut piece.quads, Stored { geometry, shape }),
                    Shape::Torus(geometry) => others.tori.push(&mut piece.tori, Stored { geometry, shape }),
                }
            }
            piece.leaves.push(Leaf {
                first_block: index(piece.blocks.len()),
                triangle_count: index(triangles.len()),
                others: if has_others { index(piece.others.len()) } else { Leaf::NO_OTHERS },
            });
            piece.blocks.extend(triangles.chunks(LANES).map(TriangleBlock::new));
            if has_others {
                piece.others.push(others);
            }
        }
        piece
    }

    fn append(&mut self, piece: Self) {
        let (blocks, others) = (index(self.blocks.len()), index(self.others.len()));
        self.leaves.extend(piece.leaves.iter().map(|leaf| Leaf {
            first_block: leaf.first_block + blocks,
            triangle_count: leaf.triangle_count,
            others: if leaf.others == Leaf::NO_OTHERS { Leaf::NO_OTHERS } else { leaf.others + others },
        }));
        let moved = |range: Range, by: usize| Range { first: range.first + index(by), ..range };
        self.others.extend(piece.others.iter().map(|others| Others {
            spheres: moved(others.spheres, self.spheres.len()),
            cuboids: moved(others.cuboids, self.cuboids.len()),
            quads: moved(others.quads, self.quads.len()),
            tori: moved(others.tori, self.tori.len()),
        }));
        self.blocks.extend(piece.blocks);
        self.spheres.extend(piece.spheres);
        self.cuboids.extend(piece.cuboids);
        self.quads.extend(piece.quads);
        self.tori.extend(piece.tori);
    }

    /// Bytes of the shapes in leaf order and of what finds them.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.leaves[..])
            + size_of_val(&self.blocks[..])
            + size_of_val(&self.others[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.cuboids[..])
            + size_of_val(&self.quads[..])
            + size_of_val(&self.tori[..])
    }

    /// The blocks of a leaf, each with the number of its triangles.
    #[inline]
    fn blocks_of(&self, leaf: &Leaf) -> impl Iterator<Item = (&TriangleBlock, u32)> {
        let count = leaf.triangle_count as usize;
        let blocks = &self.blocks[leaf.first_block as usize..][..count.div_ceil(LANES)];
        blocks.iter().enumerate().map(move |(i, block)| (block, (count - i * LANES).min(LANES) as u32))
    }

    /// Tests every shape of a leaf and keeps the nearest. `t_min` is the start of the interval in which a shape counts.
    #[inline]
    fn nearest<P: Probe>(
        &self,
        leaf_idx: u32,
        ray: &PreparedRay,
        t_min: impl Fn(u32) -> f32 + Copy,
        hit: &mut Hit,
        probe: &mut P,
    ) {
        let leaf = &self.leaves[leaf_idx as usize];
        let lane_ray = LaneRay::new(ray);
        for (block, count) in self.blocks_of(leaf) {
            probe.shapes_tested(count);
            let candidates = block.candidates(&lane_ray);
            for lane in candidates.lanes() {
                let shape = block.shape(lane);
                keep(hit, shape, block.confirm(&candidates, lane, &lane_ray, t_min(shape), hit.t));
            }
        }
        if leaf.others != Leaf::NO_OTHERS {
            let others = &self.others[leaf.others as usize];
            let query = Nearest { ray, t_min };
            query.among(others.spheres.of(&self.spheres), Sphere::intersect_within, hit, probe);
            query.among(others.cuboids.of(&self.cuboids), Cuboid::intersect_within, hit, probe);
            query.among(others.quads.of(&self.quads), Quad::intersect_within, hit, probe);
            query.among(others.tori.of(&self.tori), Torus::intersect_within, hit, probe);
        }
    }

    /// The first shape of a leaf that blocks and is hit. Shapes other than triangles that do not block are not tested.
    #[inline]
    fn any<P: Probe>(
        &self,
        leaf_idx: u32,
        ray: &PreparedRay,
        t_min: impl Fn(u32) -> f32 + Copy,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        let leaf = &self.leaves[leaf_idx as usize];
        let lane_ray = LaneRay::new(ray);
        let t_max = ray.ray.t_max;
        for (block, count) in self.blocks_of(leaf) {
            probe.shapes_tested(count);
            let candidates = block.candidates(&lane_ray);
            for lane in candidates.lanes() {
                let shape = block.shape(lane);
                let stops = || block.confirm(&candidates, lane, &lane_ray, t_min(shape), t_max).is_some();
                if blocks(shape) && stops() {
                    return Some(shape);
                }
            }
        }
        if leaf.others == Leaf::NO_OTHERS {
            return None;
        }
        let others = &self.others[leaf.others as usize];
        let query = Any { ray, t_min, blocks };
        query
            .among(others.spheres.of(&self.spheres), Sphere::intersect_within, probe)
            .or_else(|| query.among(others.cuboids.of(&self.cuboids), Cuboid::intersect_within, probe))
            .or_else(|| query.among(others.quads.of(&self.quads), Quad::intersect_within, probe))
            .or_else(|| query.among(others.tori.of(&self.tori), Torus::intersect_within, probe))
    }
}

/// Replaces `hit` by what `shape` answered if that is nearer.
#[inline]
pub(super) fn keep(hit: &mut Hit, shape: u32, answer: Option<ShapeHit>) {
    if let Some(ShapeHit { t, u, v }) = answer
        && hit.is_beaten_by(t, shape)
    {
        *hit = Hit { t, shape, u, v };
    }
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
        test: impl Fn(&S, &PreparedRay, f32, f32) -> Option<ShapeHit>,
        hit: &mut Hit,
        probe: &mut P,
    ) {
        for Stored { geometry, shape } in stored {
            probe.shapes_tested(1);
            let answer = test(geometry, self.ray, (self.t_min)(*shape), hit.t);
            keep(hit, *shape, answer);
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
        test: impl Fn(&S, &PreparedRay, f32, f32) -> Option<ShapeHit>,
        probe: &mut P,
    ) -> Option<u32> {
        stored.iter().filter(|s| (self.blocks)(s.shape)).find_map(|Stored { geometry, shape }| {
            probe.shapes_tested(1);
            test(geometry, self.ray, (self.t_min)(*shape), self.ray.ray.t_max).map(|_| *shape)
        })
    }
}

impl LeafIntersector for PrimStore {
    #[inline]
    fn intersect<P: Probe>(&self, leaf_idx: u32, ray: &PreparedRay, hit: &mut Hit, probe: &mut P) {
        let t_min = ray.ray.t_min;
        self.nearest(leaf_idx, ray, |_| t_min, hit, probe);
    }

    #[inline]
    fn occluded<P: Probe>(
        &self,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        let t_min = ray.ray.t_min;
        self.any(leaf_idx, ray, |_| t_min, blocks, probe)
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
    #[inline]
    fn intersect<P: Probe>(&self, leaf_idx: u32, ray: &PreparedRay, hit: &mut Hit, probe: &mut P) {
        self.store.nearest(leaf_idx, ray, |shape| self.t_min(shape), hit, probe);
    }

    fn occluded<P: Probe>(
        &self,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        self.store.any(leaf_idx, ray, |shape| self.t_min(shape), blocks, probe)
    }
}
