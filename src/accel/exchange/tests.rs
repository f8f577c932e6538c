//! Trees to arrays and back, of every width and depth; and damage, which is found or harmless.

#[path = "../../../tests/exchange/shapes_of_trees.rs"]
mod shapes_of_trees;

use fearless_simd::{Fallback, Simd};
use glam::Vec3;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

use super::*;
use crate::accel::simd::SimdToken;
use crate::accel::traverse::{LeafIntersector, Probe, intersect};
use crate::accel::validate::{Violation, ViolationKind, validate};
use crate::accel::{BuildConfig, Builder, Width, build};
use crate::geometry::{Hit, PreparedRay, Ray, Slabs};
use shapes_of_trees::{list, widened};

fn boxes(count: usize) -> Vec<Aabb> {
    let mut rng = Pcg32::seed_from_u64(3);
    let mut vec = |size: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.0..size)));
    (0..count)
        .map(|_| vec(10.0))
        .collect::<Vec<_>>()
        .into_iter()
        .map(|min| Aabb::new(min, min + vec(0.9)))
        .collect()
}

fn built(boxes: &[Aabb], config: &BuildConfig) -> Tree {
    build(boxes, config, &Task::new()).expect("not cancelled").0
}

fn checked(raw: &RawTree, boxes: &[Aabb]) -> (Findings, Option<Tree>) {
    raw.checked(boxes, &Task::new()).expect("not cancelled")
}

#[test]
fn a_tree_comes_back_as_it_was() {
    let boxes = boxes(300);
    for builder in [Builder::Binned, Builder::Spatial, Builder::Median] {
        for width in Width::ALL {
            let tree = built(&boxes, &BuildConfig { builder, width, ..BuildConfig::default() });
            let raw = RawTree::of(&tree);
            assert_eq!(raw.check_form(), Ok(()));
            let (findings, back) = checked(&raw, &boxes);
            assert_eq!(back.as_ref(), Some(&tree), "{builder:?} {width:?}");
            assert_eq!(findings.violations, [], "{builder:?} {width:?}");
            assert_eq!(findings.extra_references, tree.refs().len() - 300);
        }
    }
}

#[test]
fn trees_of_nothing_and_of_a_leaf_come_back() {
    for count in [0, 1, 2] {
        let boxes = boxes(count);
        let tree = built(&boxes, &BuildConfig::default());
        let raw = RawTree::of(&tree);
        assert_eq!((raw.node_count(), raw.leaf_count()), (0, count.min(1)));
        assert_eq!(checked(&raw, &boxes).1, Some(tree));
    }
    // A leaf below a node, as others write it.
    let one = boxes(1);
    let raw = RawTree {
        width: 2,
        child_min: vec![one[0].min.into(), [0.0; 3]],
        child_max: vec![one[0].max.into(), [0.0; 3]],
        child_index: vec![-2, -1],
        leaf_first: vec![0],
        leaf_count: vec![1],
        shape_index: vec![0],
    };
    let (findings, tree) = checked(&raw, &one);
    assert!(findings.violations.is_empty(), "{findings:?}");
    let tree = tree.expect("it is valid");
    assert_eq!((tree.node_count(), tree.depth_max(), tree.bounds()), (2, Some(1), one[0]));
}

#[test]
fn every_width_finds_room() {
    let boxes = boxes(500);
    let binary = RawTree::of(&built(&boxes, &BuildConfig { width: Width::W2, ..BuildConfig::default() }));
    for (width, room) in [(2, 2), (3, 4), (4, 4), (5, 8), (7, 8), (8, 8), (9, 16), (12, 16), (16, 16)] {
        let raw = widened(&binary, width);
        let (findings, tree) = checked(&raw, &boxes);
        assert!(findings.violations.is_empty(), "{width}: {findings:?}");
        let tree = tree.expect("it is valid");
        assert_eq!(
            (tree.width(), tree.inner_count(), tree.leaf_count()),
            (room, raw.node_count(), raw.leaf_count())
        );
        assert_eq!(validate(&tree, &boxes), []);
        assert_hits_are_those_of_brute_force(&tree, &boxes, 300);
    }
}

#[test]
fn a_tree_may_be_thousands_of_levels_deep() {
    let boxes = boxes(3000);
    let (findings, tree) = checked(&list(&boxes), &boxes);
    assert!(findings.is_valid());
    assert_eq!(findings.count(ViolationKind::TooDeep), findings.remark_count());
    assert!(
        findings.violations.len() == Findings::MOST_LISTED && findings.count(ViolationKind::TooDeep) > 5000
    );
    let tree = tree.expect("it is valid");
    assert_eq!(tree.depth_max(), Some(2999));
    assert_hits_are_those_of_brute_force(&tree, &boxes, 200);
}

#[test]
fn numbers_stay_where_they_can() {
    let boxes = boxes(40);
    let config = BuildConfig { width: Width::W2, ..BuildConfig::default() };
    let raw = RawTree::of(&built(&boxes, &config));
    // The last node changes places with the first below the root: children before their parents.
    let (a, b) = (1, raw.node_count() as i32 - 1);
    let mut moved = raw.clone();
    for i in 0..2 {
        let (a, b) = (2 * a as usize + i, 2 * b as usize + i);
        moved.child_index.swap(a, b);
        moved.child_min.swap(a, b);
        moved.child_max.swap(a, b);
    }
    for child in &mut moved.child_index {
        *child = if *child == a {
            b
        } else if *child == b {
            a
        } else {
            *child
        };
    }
    // And a leaf that nothing leads to.
    moved.leaf_first.push(0);
    moved.leaf_count.push(1);
    let (findings, tree) = checked(&moved, &boxes);
    let unreachable = Violation::Unreachable { at: At::Leaf(raw.leaf_count() as u32) };
    assert_eq!(findings.violations, [unreachable]);
    assert_eq!(tree.as_ref().map(Tree::leaf_count), Some(raw.leaf_count()));
    assert_hits_are_those_of_brute_force(&tree.expect("it is valid"), &boxes, 200);
    assert_eq!(checked(&raw, &boxes).1.map(|tree| RawTree::of(&tree)), Some(raw));
}

#[test]
fn broken_trees_can_be_drawn() {
    let boxes = boxes(40);
    let mut raw = RawTree::of(&built(&boxes, &BuildConfig { width: Width::W4, ..BuildConfig::default() }));
    raw.child_index[1] = 0;
    raw.child_index[2] = 999;
    raw.child_min[5] = [f32::NAN; 3];
    raw.leaf_first[0] = -7;
    let (findings, tree) = checked(&raw, &boxes);
    assert!(tree.is_none() && findings.fault_count() > 3, "{findings:?}");
    for kind in [
        ViolationKind::BadLink,
        ViolationKind::ReachedTwice,
        ViolationKind::NotFinite,
        ViolationKind::BadLeaf,
    ] {
        assert!(findings.count(kind) > 0, "{kind:?}");
    }
    let drawn = raw.drawable(&boxes, &Task::new()).expect("not cancelled");
    let mut count = 0;
    drawn.walk(|_| {
        count += 1;
        true
    });
    assert!(count > 5 && count < raw.node_count() + raw.leaf_count());
}

#[test]
fn lengths_that_do_not_fit_are_named() {
    let raw = RawTree { width: 2, child_index: vec![0; 2], ..RawTree::default() };
    let expected = FormError::Length { name: "child_min", len: 0, expected: 2 };
    assert_eq!(raw.check_form(), Err(expected));
    assert_eq!(RawTree::default().check_form(), Err(FormError::Width { width: 0 }));
}

/// Leaves whose shapes are the boxes themselves.
struct Boxes<'a> {
    tree: &'a Tree,
    boxes: &'a [Aabb],
}

fn box_entry(bounds: &Aabb, ray: &PreparedRay) -> Option<f32> {
    let (enter, leave) = Slabs::new(ray, bounds).interval(bounds);
    let entry = enter.max(ray.ray.t_min);
    (entry <= leave.min(ray.ray.t_max)).then_some(entry)
}

fn keep_nearest(hit: &mut Hit, shape: u32, bounds: &Aabb, ray: &PreparedRay) {
    if let Some(t) = box_entry(bounds, ray)
        && hit.is_beaten_by(t, shape)
    {
        *hit = Hit { t, shape, u: 0.0, v: 0.0 };
    }
}

impl LeafIntersector for Boxes<'_> {
    type Best<'a>
        = Hit
    where
        Self: 'a;

    fn t_max(best: &Hit) -> f32 {
        best.t
    }

    fn intersect<S: Simd, P: Probe>(&self, _: S, leaf_idx: u32, ray: &PreparedRay, hit: &mut Hit, _: &mut P) {
        for &shape in self.tree.leaf_shapes(leaf_idx) {
            keep_nearest(hit, shape, &self.boxes[shape as usize], ray);
        }
    }

    fn occluded<S: Simd, P: Probe>(
        &self,
        _: S,
        _: u32,
        _: &PreparedRay,
        _: &impl Fn(u32) -> bool,
        _: &mut P,
    ) -> Option<u32> {
        unreachable!("not asked here")
    }
}

fn assert_hits_are_those_of_brute_force(tree: &Tree, boxes: &[Aabb], count: usize) {
    let mut rng = Pcg32::seed_from_u64(5);
    for i in 0..count {
        let mut vec =
            |from: f32, to: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(from..to)));
        let mut direction = vec(-1.0, 1.0);
        if i % 4 == 0 {
            direction[i % 3] = 0.0;
        }
        let ray = Ray::new(vec(-2.0, 12.0), direction);
        let prepared = PreparedRay::new(ray);
        let mut expected = Hit::none(f32::INFINITY);
        for (shape, bounds) in boxes.iter().enumerate() {
            keep_nearest(&mut expected, shape as u32, bounds, &prepared);
        }
        let mut hit = Hit::none(f32::INFINITY);
        let leaves = Boxes { tree, boxes };
        intersect(SimdToken::Scalar(Fallback::new()), tree, &leaves, &ray, &mut hit, &mut ());
        assert_eq!(hit, expected, "{ray:?}");
    }
}

/// One number of one array becomes another one.
#[derive(Clone, Debug)]
struct Damage {
    array: usize,
    at: prop::sample::Index,
    value: i32,
    side: f32,
}

fn damage() -> impl Strategy<Value = Damage> {
    let value = prop_oneof![-60..60_i32, any::<i32>()];
    let side = prop_oneof![
        -3.0_f32..13.0,
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(f32::NEG_INFINITY),
        Just(f32::MAX)
    ];
    (0..6_usize, any::<prop::sample::Index>(), value, side).prop_map(|(array, at, value, side)| Damage {
        array,
        at,
        value,
        side,
    })
}

fn damaged(raw: &RawTree, damage: &Damage) -> RawTree {
    let mut raw = raw.clone();
    let Damage { array, at, value, side } = damage;
    match array {
        0 | 1 => {
            let corners = if *array == 0 { &mut raw.child_min } else { &mut raw.child_max };
            let at = at.index(3 * corners.len());
            corners[at / 3][at % 3] = *side;
        }
        _ => {
            let numbers = match array {
                2 => &mut raw.child_index,
                3 => &mut raw.leaf_first,
                4 => &mut raw.leaf_count,
                _ => &mut raw.shape_index,
            };
            let at = at.index(numbers.len());
            numbers[at] = *value;
        }
    }
    raw
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn damage_is_found_or_harmless(damage in damage(), width in 0..3_usize, count in 3..60_usize) {
        let boxes = boxes(count);
        let raw = RawTree::of(&built(&boxes, &BuildConfig { width: Width::ALL[width], ..BuildConfig::default() }));
        prop_assume!(raw.node_count() > 0);
        let raw = damaged(&raw, &damage);
        let (findings, tree) = checked(&raw, &boxes);
        prop_assert_eq!(findings.is_valid(), tree.is_some());
        if let Some(tree) = tree {
            assert_hits_are_those_of_brute_force(&tree, &boxes, 60);
        }
    }

    #[test]
    fn trees_that_are_damaged_all_over_are_checked_and_drawn(
        many in prop::collection::vec(damage(), 1..30),
        width in 0..3_usize,
    ) {
        let boxes = boxes(40);
        let config = BuildConfig { width: Width::ALL[width], ..BuildConfig::default() };
        let mut raw = RawTree::of(&built(&boxes, &config));
        for damage in &many {
            raw = damaged(&raw, damage);
        }
        let (findings, tree) = checked(&raw, &boxes);
        prop_assert_eq!(findings.is_valid(), tree.is_some());
        raw.drawable(&boxes, &Task::new()).expect("not cancelled").walk(|_| true);
    }
}
