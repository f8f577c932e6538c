//! The box test of one ray against all children of a node at once: the arithmetic of [`Slabs`], lane by lane.

use fearless_simd::{Simd, SimdFloat, f32x4, f32x8, f32x16, prelude::*};
use glam::Vec3;

use crate::accel::compressed::CompressedNode;
use crate::accel::simd::{greater_or, less_or};
use crate::accel::tree::{ChildRef, WideNode};
use crate::geometry::{Aabb, Ray, Slabs};

use super::packet::Interval;

/// A ray before it enters a tree: [`Slabs`] for the tree's box, computed on all axes at once.
#[derive(Clone, Copy)]
pub struct TreeRay {
    near_origin: [f32; 4],
    far_origin: [f32; 4],
    inv_direction: [f32; 4],
    t_min: f32,
    /// Bit i is set if the ray enters boxes through their maximum along axis i. Also for a direction of -0, whose inverse
    /// is -infinity.
    flipped: usize,
}

impl TreeRay {
    /// `None` for a ray that is nowhere inside the box between its `t_min` and `t_max`.
    ///
    /// Straight through, all axes at once: for a ray that visits few nodes this is a good part of the work.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, ray: &Ray, bounds: &Aabb, t_max: f32) -> Option<Self> {
        let spread = |value: f32| f32x4::simd_from(simd, value);
        let (origin, direction) = (lanes(simd, ray.origin), lanes(simd, ray.direction));
        let (min, max) = (lanes(simd, bounds.min), lanes(simd, bounds.max));
        let inv = spread(1.0) / direction;
        let reach = most((min - origin).abs().max((max - origin).abs()));
        let margin = reach * spread(Slabs::MARGIN) + origin.abs() * spread(f32::EPSILON);
        let outwards = margin.copysign(inv);
        let (near_origin, far_origin) = (origin + outwards, origin - outwards);
        let flipped = inv.simd_lt(spread(0.0));
        let near = (flipped.select(max, min) - near_origin) * inv;
        let far = (flipped.select(min, max) - far_origin) * inv;
        // A NaN (0 * infinity) says nothing.
        let enter = most(greater_or(simd, near, spread(ray.t_min)));
        let leave = least(less_or(simd, far, spread(t_max)));
        let inside = enter.simd_le(leave).to_bitmask() & 1 != 0;
        inside.then_some(Self {
            near_origin: near_origin.to_array(),
            far_origin: far_origin.to_array(),
            inv_direction: inv.to_array(),
            t_min: ray.t_min,
            flipped: flipped.to_bitmask() as usize,
        })
    }

    /// A ray of a packet.
    #[inline(always)]
    pub fn from_parts(near: [f32; 3], far: [f32; 3], inv: [f32; 3], t_min: f32, flipped: usize) -> Self {
        let four = |[x, y, z]: [f32; 3]| [x, y, z, z];
        Self { near_origin: four(near), far_origin: four(far), inv_direction: four(inv), t_min, flipped }
    }

    /// Rows of [`WideNode::sides`] through which the ray enters, an axis each.
    #[inline(always)]
    fn near_side(&self, axis: usize) -> usize {
        axis + 3 * (self.flipped >> axis & 1)
    }

    /// Rows of [`WideNode::sides`] through which the ray leaves, an axis each.
    #[inline(always)]
    fn far_side(&self, axis: usize) -> usize {
        axis + 3 * (!self.flipped >> axis & 1)
    }
}

/// An axis in each lane, the last one twice.
#[inline(always)]
fn lanes<S: Simd>(simd: S, v: Vec3) -> f32x4<S> {
    f32x4::simd_from(simd, [v.x, v.y, v.z, v.z])
}

/// The largest lane, in all lanes.
#[inline(always)]
fn most<S: Simd>(v: f32x4<S>) -> f32x4<S> {
    let pairs = v.max(v.rotate_elements_left::<2>());
    pairs.max(pairs.rotate_elements_left::<1>())
}

/// The smallest lane, in all lanes.
#[inline(always)]
fn least<S: Simd>(v: f32x4<S>) -> f32x4<S> {
    let pairs = v.min(v.rotate_elements_left::<2>());
    pairs.min(pairs.rotate_elements_left::<1>())
}

/// The children of a node that a ray enters before its end.
pub struct Entered<const N: usize> {
    /// Bit i for slot i.
    pub slots: u32,
    /// Where it enters each; without meaning for the others.
    pub entries: [f32; N],
}

/// What stands in the slots of a node.
pub trait Slots {
    /// What stands in a slot that is filled.
    fn child(&self, slot: usize) -> ChildRef;

    fn child_count(&self) -> usize;

    /// The sides of a child's box, minima first.
    fn child_sides(&self, slot: usize) -> [f32; 6];
}

impl<const N: usize> Slots for WideNode<N> {
    #[inline(always)]
    fn child(&self, slot: usize) -> ChildRef {
        self.children[slot]
    }

    #[inline(always)]
    fn child_count(&self) -> usize {
        WideNode::child_count(self)
    }

    #[inline(always)]
    fn child_sides(&self, slot: usize) -> [f32; 6] {
        self.slot_sides(slot)
    }
}

impl Slots for CompressedNode {
    #[inline(always)]
    fn child(&self, slot: usize) -> ChildRef {
        CompressedNode::child(self, slot)
    }

    #[inline(always)]
    fn child_count(&self) -> usize {
        CompressedNode::child_count(self)
    }

    #[inline(always)]
    fn child_sides(&self, slot: usize) -> [f32; 6] {
        CompressedNode::child_sides(self, slot)
    }
}

/// A node whose children's boxes are tested together.
pub trait BoxLanes<S: Simd, const N: usize>: Slots {
    /// What the test needs of a ray, prepared once for a tree.
    type Ray: Copy;

    fn spread(simd: S, ray: &TreeRay) -> Self::Ray;

    fn enter(&self, simd: S, ray: &Self::Ray, t_max: f32) -> Entered<N>;

    /// The slots whose boxes any ray of a packet may enter before `t_max`.
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; N]);
}

/// The sides of all boxes of a node, row by row.
pub trait SideRows<S: Simd, V> {
    /// Row `row` of [`WideNode::sides`], which lies across `axis`.
    fn row(&self, simd: S, axis: usize, row: usize) -> V;
}

impl<S: Simd, V: SimdFloat<S, Element = f32, Array = [f32; N]>, const N: usize> SideRows<S, V>
    for [[f32; N]; 6]
{
    #[inline(always)]
    fn row(&self, simd: S, _: usize, row: usize) -> V {
        V::load_array_ref(simd, &self[row])
    }
}

/// Decoded, then tested as any box: a conversion, a product and a sum more a side. What it costs: `benches/README.md`.
impl<S: Simd> SideRows<S, f32x8<S>> for CompressedNode {
    #[inline(always)]
    fn row(&self, simd: S, axis: usize, row: usize) -> f32x8<S> {
        let (origin, quantum) = (self.origin(axis), self.quantum(axis));
        f32x8::load_array(simd, self.bytes(row)) * f32x8::simd_from(simd, quantum)
            + f32x8::simd_from(simd, origin)
    }
}

/// A ray spread over the lanes of as many boxes.
#[derive(Clone, Copy)]
pub struct LaneSlabs<V> {
    near_origin: [V; 3],
    far_origin: [V; 3],
    inv_direction: [V; 3],
    t_min: V,
    /// Rows of [`WideNode::sides`] through which the ray enters and leaves, an axis each.
    near_side: [usize; 3],
    far_side: [usize; 3],
}

/// Each axis in all lanes.
#[inline(always)]
fn spread<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, [x, y, z, _]: [f32; 4]) -> [V; 3] {
    [V::simd_from(simd, x), V::simd_from(simd, y), V::simd_from(simd, z)]
}

impl<V> LaneSlabs<V> {
    #[inline(always)]
    fn new<S: Simd>(simd: S, ray: &TreeRay) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        Self {
            near_origin: spread(simd, ray.near_origin),
            far_origin: spread(simd, ray.far_origin),
            inv_direction: spread(simd, ray.inv_direction),
            t_min: V::simd_from(simd, ray.t_min),
            near_side: [ray.near_side(0), ray.near_side(1), ray.near_side(2)],
            far_side: [ray.far_side(0), ray.far_side(1), ray.far_side(2)],
        }
    }

    /// The comparisons keep a NaN out (0 * infinity: the ray lies in a side's plane), so such a side never rejects.
    #[inline(always)]
    fn enter<S: Simd, const N: usize>(&self, simd: S, sides: &impl SideRows<S, V>, t_max: f32) -> Entered<N>
    where
        V: SimdFloat<S, Element = f32, Array = [f32; N]>,
    {
        let mut near = self.t_min;
        let mut far = V::simd_from(simd, t_max);
        for axis in 0..3 {
            let side = sides.row(simd, axis, self.near_side[axis]);
            near = greater_or(simd, (side - self.near_origin[axis]) * self.inv_direction[axis], near);
            let side = sides.row(simd, axis, self.far_side[axis]);
            far = less_or(simd, (side - self.far_origin[axis]) * self.inv_direction[axis], far);
        }
        Entered { slots: near.simd_le(far).to_bitmask() as u32, entries: near.to_array() }
    }
}

impl<S: Simd> BoxLanes<S, 16> for WideNode<16> {
    type Ray = LaneSlabs<f32x16<S>>;

    #[inline(always)]
    fn spread(simd: S, ray: &TreeRay) -> Self::Ray {
        LaneSlabs::new(simd, ray)
    }

    #[inline(always)]
    fn enter(&self, simd: S, ray: &Self::Ray, t_max: f32) -> Entered<16> {
        ray.enter(simd, &self.sides, t_max)
    }

    #[inline(always)]
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; 16]) {
        packet.enter::<S, f32x16<S>, 16>(simd, &self.sides, t_max)
    }
}

impl<S: Simd> BoxLanes<S, 8> for WideNode<8> {
    type Ray = LaneSlabs<f32x8<S>>;

    #[inline(always)]
    fn spread(simd: S, ray: &TreeRay) -> Self::Ray {
        LaneSlabs::new(simd, ray)
    }

    #[inline(always)]
    fn enter(&self, simd: S, ray: &Self::Ray, t_max: f32) -> Entered<8> {
        ray.enter(simd, &self.sides, t_max)
    }

    #[inline(always)]
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; 8]) {
        packet.enter::<S, f32x8<S>, 8>(simd, &self.sides, t_max)
    }
}

impl<S: Simd> BoxLanes<S, 8> for CompressedNode {
    type Ray = LaneSlabs<f32x8<S>>;

    #[inline(always)]
    fn spread(simd: S, ray: &TreeRay) -> Self::Ray {
        LaneSlabs::new(simd, ray)
    }

    #[inline(always)]
    fn enter(&self, simd: S, ray: &Self::Ray, t_max: f32) -> Entered<8> {
        let Entered { slots, entries } = ray.enter(simd, self, t_max);
        Entered { slots: slots & self.filled(), entries }
    }

    #[inline(always)]
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; 8]) {
        let (slots, nears) = packet.enter::<S, f32x8<S>, 8>(simd, self, t_max);
        (slots & self.filled(), nears)
    }
}

impl<S: Simd> BoxLanes<S, 4> for WideNode<4> {
    type Ray = LaneSlabs<f32x4<S>>;

    #[inline(always)]
    fn spread(simd: S, ray: &TreeRay) -> Self::Ray {
        LaneSlabs::new(simd, ray)
    }

    #[inline(always)]
    fn enter(&self, simd: S, ray: &Self::Ray, t_max: f32) -> Entered<4> {
        ray.enter(simd, &self.sides, t_max)
    }

    #[inline(always)]
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; 4]) {
        packet.enter::<S, f32x4<S>, 4>(simd, &self.sides, t_max)
    }
}

#[inline(always)]
fn pairs<S: Simd>(simd: S, a: f32, b: f32) -> f32x4<S> {
    f32x4::simd_from(simd, [a, a, b, b])
}

/// A ray for two boxes, their x beside their y, and their near z beside their far z.
#[derive(Clone, Copy)]
pub struct PairSlabs<S: Simd> {
    near_origin_xy: f32x4<S>,
    far_origin_xy: f32x4<S>,
    origin_z: f32x4<S>,
    inv_direction_xy: f32x4<S>,
    inv_direction_z: f32x4<S>,
    t_min: f32x4<S>,
    near_side: [usize; 3],
    far_side: [usize; 3],
}

impl WideNode<2> {
    /// Two sides of both boxes.
    #[inline(always)]
    fn pair<S: Simd>(&self, simd: S, a: usize, b: usize) -> f32x4<S> {
        let ([a0, a1], [b0, b1]) = (self.sides[a], self.sides[b]);
        f32x4::simd_from(simd, [a0, a1, b0, b1])
    }
}

impl<S: Simd> BoxLanes<S, 2> for WideNode<2> {
    type Ray = PairSlabs<S>;

    #[inline(always)]
    fn spread(simd: S, ray: &TreeRay) -> PairSlabs<S> {
        let TreeRay { near_origin: near, far_origin: far, inv_direction: inv, t_min, .. } = *ray;
        PairSlabs {
            near_origin_xy: pairs(simd, near[0], near[1]),
            far_origin_xy: pairs(simd, far[0], far[1]),
            origin_z: pairs(simd, near[2], far[2]),
            inv_direction_xy: pairs(simd, inv[0], inv[1]),
            inv_direction_z: pairs(simd, inv[2], inv[2]),
            t_min: f32x4::simd_from(simd, t_min),
            near_side: [ray.near_side(0), ray.near_side(1), ray.near_side(2)],
            far_side: [ray.far_side(0), ray.far_side(1), ray.far_side(2)],
        }
    }

    #[inline(always)]
    fn enter(&self, simd: S, ray: &PairSlabs<S>, t_max: f32) -> Entered<2> {
        let [near_x, near_y, near_z] = ray.near_side;
        let [far_x, far_y, far_z] = ray.far_side;
        let near_xy = (self.pair(simd, near_x, near_y) - ray.near_origin_xy) * ray.inv_direction_xy;
        let far_xy = (self.pair(simd, far_x, far_y) - ray.far_origin_xy) * ray.inv_direction_xy;
        let z = (self.pair(simd, near_z, far_z) - ray.origin_z) * ray.inv_direction_z;
        let near = greater_or(simd, near_xy, ray.t_min);
        let near = greater_or(simd, near.rotate_elements_left::<2>(), near);
        let near = greater_or(simd, z, near);
        let far = less_or(simd, far_xy, f32x4::simd_from(simd, t_max));
        let far = less_or(simd, far.rotate_elements_left::<2>(), far);
        let far = less_or(simd, z.rotate_elements_left::<2>(), far);
        let [a, b, _, _] = near.to_array();
        Entered { slots: near.simd_le(far).to_bitmask() as u32 & 0b11, entries: [a, b] }
    }

    #[inline(always)]
    fn may_enter(&self, simd: S, packet: &Interval, t_max: f32) -> (u32, [f32; 2]) {
        packet.enter_pair(simd, &self.sides, t_max)
    }
}
