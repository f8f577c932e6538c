//! The walk against testing every box, with boxes as the leaves' content.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::*;
use crate::accel::config::{Builder, Widen};
use crate::accel::{BuildConfig, build};
use crate::geometry::{Aabb, Hit, Ray, Slabs};
use crate::task::Task;

const LEVEL: SimdToken = SimdToken::Scalar(Fallback::new());

/// Leaves whose shapes are the boxes themselves, entered at their near side.
struct Boxes<'a> {
    tree: &'a Tree,
    boxes: &'a [Aabb],
}

fn box_entry(bounds: &Aabb, ray: &PreparedRay) -> Option<f32> {
    let (enter, leave) = Slabs::new(ray, bounds).interval(bounds);
    let entry = if enter > ray.ray.t_min { enter } else { ray.ray.t_min };
    (entry <= leave.min(ray.ray.t_max)).then_some(entry)
}

impl LeafIntersector for Boxes<'_> {
    type Best<'a>
        = Hit
    where
        Self: 'a;

    fn t_max(best: &Hit) -> f32 {
        best.t
    }

    fn intersect<S: Simd, P: Probe>(
        &self,
        _: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        hit: &mut Hit,
        probe: &mut P,
    ) {
        for &shape in self.tree.leaf_shapes(leaf_idx) {
            probe.shapes_tested(1);
            if let Some(t) = box_entry(&self.boxes[shape as usize], ray)
                && hit.is_beaten_by(t, shape)
            {
                *hit = Hit { t, shape, u: 0.0, v: 0.0 };
            }
        }
    }

    fn occluded<S: Simd, P: Probe>(
        &self,
        _: S,
        leaf_idx: u32,
        ray: &PreparedRay,
        blocks: &impl Fn(u32) -> bool,
        probe: &mut P,
    ) -> Option<u32> {
        self.tree.leaf_shapes(leaf_idx).iter().copied().find(|&shape| {
            probe.shapes_tested(1);
            blocks(shape) && box_entry(&self.boxes[shape as usize], ray).is_some()
        })
    }
}

fn random_vec(rng: &mut Pcg32) -> Vec3 {
    Vec3::new(rng.random(), rng.random(), rng.random()) - 0.5
}

fn boxes(count: usize) -> Vec<Aabb> {
    let mut rng = Pcg32::seed_from_u64(3);
    (0..count)
        .map(|_| {
            let min = random_vec(&mut rng) * 10.0;
            Aabb::new(min, min + (random_vec(&mut rng) + 0.5) * 0.7)
        })
        .collect()
}

/// Rays in all directions, along the axes, with zero and negative zero components, and in the planes of box sides.
fn rays(boxes: &[Aabb]) -> Vec<PreparedRay> {
    let mut rng = Pcg32::seed_from_u64(4);
    let mut rays = Vec::new();
    for i in 0..400 {
        let origin = random_vec(&mut rng) * 14.0;
        rays.push(Ray::new(origin, random_vec(&mut rng)));
        let mut direction = Vec3::ZERO;
        direction[i % 3] = if i % 2 == 0 { 1.0 } else { -1.0 };
        rays.push(Ray::new(
            origin,
            if i % 4 < 2 { direction } else { direction * Vec3::new(1.0, -1.0, 1.0) },
        ));
        let b = &boxes[i % boxes.len()];
        rays.push(Ray::new(b.min - direction * 20.0, direction));
        rays.push(Ray { t_min: 1.0, t_max: 6.0, ..Ray::new(origin, (b.max - origin).normalize()) });
    }
    rays.into_iter().map(PreparedRay::new).collect()
}

fn nearest(boxes: &[Aabb], ray: &PreparedRay) -> Hit {
    let mut hit = Hit::none(ray.ray.t_max);
    for (shape, bounds) in boxes.iter().enumerate() {
        if let Some(t) = box_entry(bounds, ray)
            && hit.is_beaten_by(t, shape as u32)
        {
            hit = Hit { t, shape: shape as u32, u: 0.0, v: 0.0 };
        }
    }
    hit
}

#[test]
fn every_tree_gives_the_answers_of_brute_force() {
    let boxes = boxes(300);
    let rays = rays(&boxes);
    for builder in Builder::ALL {
        for (width, layout) in BuildConfig::NODES {
            for widen in Widen::ALL {
                let config = BuildConfig { builder, width, layout, widen, ..BuildConfig::default() };
                let (tree, _) = build(&boxes, &config, &Task::new()).expect("not cancelled");
                let leaves = Boxes { tree: &tree, boxes: &boxes };
                for ray in &rays {
                    let expected = nearest(&boxes, ray);
                    let mut hit = Hit::none(ray.ray.t_max);
                    intersect(LEVEL, &tree, &leaves, &ray.ray, &mut hit, &mut ());
                    assert_eq!(hit, expected, "{config:?}, {ray:?}");
                    let any = occluded(LEVEL, &tree, &leaves, &ray.ray, &|_| true, &mut ());
                    assert_eq!(any.is_some(), expected.is_some());
                    let even = occluded(LEVEL, &tree, &leaves, &ray.ray, &|shape| shape % 2 == 0, &mut ());
                    let expected_even =
                        (0..boxes.len()).step_by(2).any(|i| box_entry(&boxes[i], ray).is_some());
                    assert_eq!(even.is_some(), expected_even);
                    assert!(even.is_none_or(|shape| shape % 2 == 0));
                }
            }
        }
    }
}

#[test]
fn a_ray_that_misses_the_root_visits_nothing() {
    let boxes = boxes(50);
    let (tree, _) = build(&boxes, &BuildConfig::default(), &Task::new()).expect("not cancelled");
    let ray = PreparedRay::new(Ray::new(Vec3::splat(100.0), Vec3::X));
    let mut counters = RayCounters::default();
    let mut hit = Hit::none(f32::INFINITY);
    intersect(LEVEL, &tree, &Boxes { tree: &tree, boxes: &boxes }, &ray.ray, &mut hit, &mut counters);
    assert!(!hits_root(&tree, &ray.ray) && !hit.is_some());
    assert_eq!(counters, RayCounters::default());
}

#[test]
fn counters_of_a_small_tree_are_those_counted_by_hand() {
    // Two unit cubes in a row; the ray hits the first. The second's leaf is entered later than the hit: culled.
    let boxes = [0.0, 3.0].map(|x| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE));
    let config = BuildConfig { leaf: 1, ..BuildConfig::default() };
    let (tree, _) = build(&boxes, &config, &Task::new()).expect("not cancelled");
    let ray = PreparedRay::new(Ray::new(Vec3::new(-1.0, 0.5, 0.5), Vec3::X));
    let mut counters = RayCounters::default();
    let mut hit = Hit::none(f32::INFINITY);
    intersect(LEVEL, &tree, &Boxes { tree: &tree, boxes: &boxes }, &ray.ray, &mut hit, &mut counters);
    // A box is entered a little early, by the margin of its test.
    assert!(hit.shape == 0 && (hit.t - 1.0).abs() < 1e-5, "{hit:?}");
    assert_eq!(counters, RayCounters { inner_visits: 1, leaf_visits: 1, box_tests: 2, shape_tests: 1 });
    assert_eq!((counters.nodes_visited(), counters.ray_cost(2.0, 3.0)), (2, 5.0));
}

#[test]
fn a_root_that_is_a_leaf_is_visited_as_one() {
    let boxes = [Aabb::new(Vec3::ZERO, Vec3::ONE)];
    let (tree, _) = build(&boxes, &BuildConfig::default(), &Task::new()).expect("not cancelled");
    let ray = PreparedRay::new(Ray::new(Vec3::new(0.5, 0.5, -1.0), Vec3::Z));
    let mut counters = RayCounters::default();
    let mut hit = Hit::none(f32::INFINITY);
    intersect(LEVEL, &tree, &Boxes { tree: &tree, boxes: &boxes }, &ray.ray, &mut hit, &mut counters);
    assert_eq!(counters, RayCounters { inner_visits: 0, leaf_visits: 1, box_tests: 0, shape_tests: 1 });
}
