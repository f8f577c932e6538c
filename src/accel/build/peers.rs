//! Trees that other libraries build, in the form of this program's own, so that they are shown, walked and measured alike.
//!
//! Leaves are what the library makes of them; wider nodes are made by this program's own [`widen`](super::widen).

use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use parry3d::partitioning::{Bvh as ParryBvh, BvhBuildStrategy, BvhNode as ParryNode, TraversalAction};

use crate::accel::bvh2::{Bvh2, Bvh2Node};
use crate::accel::config::{BuildConfig, Builder, Layout};
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::Shapes;
use super::order::BuildRef;

/// By how much of its largest coordinate a leaf that holds parts of shapes is widened, against the rounding of its library's
/// cuts.
const PART_MARGIN: f32 = 4.0 * f32::EPSILON;

/// A node on its way into the tree: its box, and what lies below.
struct Given<T> {
    bounds: Aabb,
    below: Below<T>,
}

enum Below<T> {
    Children([T; 2]),
    /// The shapes of a leaf.
    Shapes(Vec<u32>),
}

/// The tree of the library that `config` names.
///
/// # Errors
/// [`Cancelled`] when the task was: a library's build ends first.
pub fn build<B: Shapes + ?Sized>(
    shapes: &B,
    refs: &[BuildRef],
    config: &BuildConfig,
    task: &Task,
) -> Result<Bvh2, Cancelled> {
    task.check()?;
    let boxes: Vec<Aabb> = refs.iter().map(|r| r.bound.aabb()).collect();
    // Libraries that cut triangles themselves get whole ones.
    let corners = |shape| shapes.corners(shape).filter(|_| config.pre_split == 0.0);
    let triangles: Option<Vec<_>> = (0..shapes.count() as u32).map(corners).collect();
    let mut bvh = match (&boxes[..], config.builder) {
        ([], _) => Bvh2::default(),
        // Not every library knows a tree of one leaf.
        ([bounds], _) => copy((), |()| Given { bounds: *bounds, below: Below::Shapes(vec![0]) }),
        (_, Builder::Bvh) => of_bvh(&boxes),
        (_, Builder::Parry3d) => of_parry(&boxes),
        _ => of_obvhs(triangles.as_deref(), &boxes, config),
    };
    task.check()?;
    name_shapes(&mut bvh, refs);
    bvh.limit_depth(BuildConfig::MAX_DEPTH);
    task.advance(refs.len() as u64);
    Ok(bvh)
}

/// Puts shapes in the place of references. Parts of a shape that lie in one leaf become one.
fn name_shapes(bvh: &mut Bvh2, refs: &[BuildRef]) {
    let mut named = Vec::with_capacity(bvh.refs.len());
    let mut leaves: Vec<_> = bvh.nodes.iter_mut().filter(|node| node.is_leaf()).collect();
    // References stay in depth-first order.
    leaves.sort_unstable_by_key(|leaf| leaf.first);
    for leaf in leaves {
        let mut shapes: Vec<u32> = bvh.refs[leaf.range()].iter().map(|&i| refs[i as usize].shape()).collect();
        shapes.sort_unstable();
        shapes.dedup();
        (leaf.first, leaf.count) = (named.len() as u32, shapes.len() as u32);
        named.append(&mut shapes);
    }
    bvh.refs = named;
}

/// Copies a tree from the root on, in depth-first order. `look_at` tells what a node holds.
fn copy<T>(root: T, mut look_at: impl FnMut(T) -> Given<T>) -> Bvh2 {
    let mut bvh = Bvh2 { nodes: vec![Bvh2::PLACE], refs: Vec::new() };
    let mut open = vec![(root, 0)];
    while let Some((from, to)) = open.pop() {
        let Given { bounds, below } = look_at(from);
        let (first, count) = match below {
            Below::Children([left, right]) => {
                let first = bvh.nodes.len();
                bvh.nodes.extend([Bvh2::PLACE; 2]);
                open.extend([(right, first + 1), (left, first)]);
                (first, 0)
            }
            Below::Shapes(mut shapes) => {
                // A shape that was cut may have several parts in one leaf.
                shapes.sort_unstable();
                shapes.dedup();
                let first = bvh.refs.len();
                bvh.refs.extend_from_slice(&shapes);
                (first, shapes.len())
            }
        };
        bvh.nodes[to] = Bvh2Node { bounds, first: first as u32, count: count as u32 };
    }
    bvh
}

// ---- obvhs

fn of_obvhs(triangles: Option<&[[Vec3; 3]]>, boxes: &[Aabb], config: &BuildConfig) -> Bvh2 {
    let mut params = match config.builder {
        Builder::ObvhsFast => BvhBuildParams::fast_build(),
        Builder::ObvhsMedium => BvhBuildParams::medium_build(),
        _ => BvhBuildParams::very_slow_build(),
    };
    if config.layout == Layout::Compressed {
        params.max_prims_per_leaf = params.max_prims_per_leaf.min(config.leaf as u32);
    }
    let ignored = &mut Duration::default();
    // It cuts triangles only, and only if there is nothing else.
    let tree = match triangles {
        Some(triangles) => {
            let triangle = |v: &[Vec3; 3]| {
                let [v0, v1, v2] = v.map(Vec3A::from);
                obvhs::triangle::Triangle { v0, v1, v2 }
            };
            build_bvh2_from_tris(&triangles.iter().map(triangle).collect::<Vec<_>>(), params, ignored)
        }
        None => {
            let boxes: Vec<_> = boxes
                .iter()
                .map(|b| obvhs::aabb::Aabb { min: Vec3A::from(b.min), max: Vec3A::from(b.max) })
                .collect();
            build_bvh2(&boxes, params, ignored)
        }
    };
    let mut bvh = copy(0_u32, |node_idx| {
        let node = &tree.nodes[node_idx as usize];
        let aabb = node.aabb();
        let first = node.first_index;
        let below = match node.prim_count {
            0 => Below::Children([first, first + 1]),
            n => Below::Shapes(tree.primitive_indices[first as usize..(first + n) as usize].to_vec()),
        };
        Given { bounds: Aabb::new(aabb.min.into(), aabb.max.into()), below }
    });
    if tree.uses_spatial_splits {
        enclose_parts(&mut bvh, boxes);
    }
    bvh
}

/// Widens leaves with parts of shapes by what their library's cuts may have lost, and fits all other nodes to their content.
fn enclose_parts(bvh: &mut Bvh2, boxes: &[Aabb]) {
    let mut uses = vec![0_u32; boxes.len()];
    bvh.refs.iter().for_each(|&shape| uses[shape as usize] += 1);
    for node_idx in (0..bvh.nodes.len()).rev() {
        let node = bvh.nodes[node_idx];
        let bounds = if node.is_leaf() {
            let shapes = &bvh.refs[node.range()];
            let margin = PART_MARGIN * node.bounds.min.abs().max(node.bounds.max.abs()).max_element();
            let wider = Aabb::new(node.bounds.min - margin, node.bounds.max + margin);
            let content = |&shape: &u32| {
                let whole = boxes[shape as usize];
                if uses[shape as usize] == 1 { whole } else { whole.intersection(wider) }
            };
            shapes.iter().map(content).filter(|part| !part.is_empty()).fold(Aabb::EMPTY, Aabb::union)
        } else {
            let [left, right] = node.children().map(|child| bvh.nodes[child as usize].bounds);
            left.union(right)
        };
        bvh.nodes[node_idx].bounds = bounds;
    }
}

// ---- bvh

struct BvhShape {
    bounds: bvh::aabb::Aabb<f32, 3>,
    node_idx: usize,
}

impl bvh::aabb::Bounded<f32, 3> for BvhShape {
    fn aabb(&self) -> bvh::aabb::Aabb<f32, 3> {
        self.bounds
    }
}

impl bvh::bounding_hierarchy::BHShape<f32, 3> for BvhShape {
    fn set_bh_node_index(&mut self, node_idx: usize) {
        self.node_idx = node_idx;
    }

    fn bh_node_index(&self) -> usize {
        self.node_idx
    }
}

fn of_bvh(boxes: &[Aabb]) -> Bvh2 {
    use bvh::bvh::{Bvh, BvhNode};
    let shape = |b: &Aabb| BvhShape {
        bounds: bvh::aabb::Aabb::with_bounds(b.min.to_array().into(), b.max.to_array().into()),
        node_idx: 0,
    };
    let mut shapes: Vec<BvhShape> = boxes.iter().map(shape).collect();
    let tree = Bvh::build(&mut shapes);
    let of = |b: &bvh::aabb::Aabb<f32, 3>| {
        Aabb::new(Vec3::new(b.min[0], b.min[1], b.min[2]), Vec3::new(b.max[0], b.max[1], b.max[2]))
    };
    // A node's own box stands with its parent.
    let whole = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
    copy((0_usize, whole), |(node_idx, bounds)| match &tree.nodes[node_idx] {
        BvhNode::Leaf { shape_index, .. } => {
            Given { bounds: boxes[*shape_index], below: Below::Shapes(vec![*shape_index as u32]) }
        }
        BvhNode::Node { child_l_index, child_l_aabb, child_r_index, child_r_aabb, .. } => {
            let children = [(*child_l_index, of(child_l_aabb)), (*child_r_index, of(child_r_aabb))];
            Given { bounds, below: Below::Children(children) }
        }
    })
}

// ---- parry3d

fn of_parry(boxes: &[Aabb]) -> Bvh2 {
    let vector = |v: Vec3| parry3d::math::Vector::new(v.x, v.y, v.z);
    let leaves = boxes.iter().map(|b| parry3d::bounding_volume::Aabb::new(vector(b.min), vector(b.max)));
    let tree = ParryBvh::from_iter(BvhBuildStrategy::Binned, leaves.enumerate());
    // Links are private; nodes come in pairs of siblings, and the pair below a left one comes before that below a right one.
    let mut nodes: Vec<ParryNode> = Vec::new();
    tree.traverse(|node| {
        nodes.push(*node);
        TraversalAction::Continue
    });
    let mut pairs = vec![0_usize; nodes.len()];
    let (mut open, mut next) = (Vec::new(), 0);
    while next < nodes.len() {
        open.extend([next + 1, next].into_iter().filter(|&i| !nodes[i].is_leaf()));
        next += 2;
        if let Some(parent) = open.pop() {
            pairs[parent] = next;
        }
    }
    let bounds = |node: &ParryNode| {
        let [min, max] = [node.mins(), node.maxs()].map(|v| Vec3::new(v.x, v.y, v.z));
        Aabb::new(min, max)
    };
    let whole = boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union);
    copy(None, |at: Option<usize>| match at {
        None => Given { bounds: whole, below: Below::Children([Some(0), Some(1)]) },
        Some(i) => {
            let below = match nodes[i].leaf_data() {
                Some(shape) => Below::Shapes(vec![shape]),
                None => Below::Children([Some(pairs[i]), Some(pairs[i] + 1)]),
            };
            Given { bounds: bounds(&nodes[i]), below }
        }
    })
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    use super::super::order::build_refs;
    use super::*;
    use crate::accel::quality::binary_sah_cost;
    use crate::accel::{Widen, Width, build_over, validate::validate};

    struct Triangles(Vec<[Vec3; 3]>);

    impl Shapes for Triangles {
        fn count(&self) -> usize {
            self.0.len()
        }

        fn bounds(&self, shape: u32) -> Aabb {
            Aabb::from_points(self.0[shape as usize])
        }

        fn bounds_between(&self, shape: u32, axis: usize, from: f32, to: f32) -> Aabb {
            crate::geometry::Triangle { v: self.0[shape as usize] }.bounds_between(axis, from, to)
        }

        fn bounds_inside(&self, shape: u32, clip: &Aabb) -> Aabb {
            crate::geometry::Triangle { v: self.0[shape as usize] }.clipped_bounds(clip)
        }

        fn area_in_parts(&self, shape: u32) -> f32 {
            let triangle = crate::geometry::Triangle { v: self.0[shape as usize] };
            crate::geometry::Shape::Triangle(triangle).area_in_parts()
        }

        fn corners(&self, shape: u32) -> Option<[Vec3; 3]> {
            Some(self.0[shape as usize])
        }
    }

    /// Triangles of which some are very long.
    fn triangles(count: usize) -> Triangles {
        let mut rng = Pcg32::seed_from_u64(3);
        let mut vector =
            |scale: f32| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-scale..scale)));
        let triangle = |i: usize| {
            let (at, size) = (vector(10.0), if i.is_multiple_of(9) { 8.0 } else { 0.3 });
            [at, at + vector(size), at + vector(size)]
        };
        Triangles((0..count).map(triangle).collect())
    }

    fn peers() -> impl Iterator<Item = Builder> {
        Builder::ALL.into_iter().filter(|builder| builder.is_peer())
    }

    #[test]
    fn every_library_builds_valid_trees_of_every_width() {
        assert_eq!(peers().count(), 5);
        for builder in peers() {
            for count in [0, 1, 2, 3, 700] {
                let shapes = triangles(count);
                let boxes: Vec<_> = (0..count as u32).map(|i| shapes.bounds(i)).collect();
                for (width, widen, layout, pre_split) in [
                    (Width::W2, Widen::Split, Layout::Full, 0.0),
                    (Width::W4, Widen::Collapse, Layout::Full, 0.3),
                    (Width::W8, Widen::Split, Layout::Compressed, 0.0),
                    (Width::W8, Widen::Optimal, Layout::Full, 0.0),
                ] {
                    let config =
                        BuildConfig { builder, width, widen, layout, pre_split, ..BuildConfig::default() };
                    let (tree, _) = build_over(&shapes, &config, &Task::new()).expect("nobody cancels");
                    assert_eq!(validate(&tree, &boxes), [], "{config:?}, {count}");
                    let (tree, _) =
                        crate::accel::build(&boxes, &config, &Task::new()).expect("nobody cancels");
                    assert_eq!(validate(&tree, &boxes), [], "{config:?}, {count} boxes");
                }
            }
        }
    }

    #[test]
    fn a_copy_has_the_cost_that_the_library_tells() {
        let shapes = triangles(500);
        let boxes: Vec<_> = (0..500).map(|i| shapes.bounds(i)).collect();
        let config = BuildConfig { builder: Builder::ObvhsMedium, ..BuildConfig::default() };
        let refs = build_refs(boxes.len(), |i| boxes[i as usize], &Task::new()).expect("nobody cancels");
        let ours = build(&shapes, &refs, &config, &Task::new()).expect("nobody cancels");
        let triangle =
            |v: &[Vec3; 3]| obvhs::triangle::Triangle { v0: v[0].into(), v1: v[1].into(), v2: v[2].into() };
        let theirs: Vec<_> = shapes.0.iter().map(triangle).collect();
        let theirs = build_bvh2_from_tris(&theirs, BvhBuildParams::medium_build(), &mut Duration::default());
        let root = theirs.nodes[0].aabb().half_area();
        let cost = theirs.nodes.iter().map(|node| match node.prim_count {
            0 => node.aabb().half_area(),
            n => node.aabb().half_area() * n as f32,
        });
        let expected = f64::from(cost.sum::<f32>() / root);
        let found = binary_sah_cost(&ours, 1.0, 1.0).expect("the root has an area");
        assert!((found - expected).abs() < 1e-3 * expected, "{found} {expected}");
    }

    #[test]
    fn very_slow_cuts_long_triangles() {
        let shapes = triangles(600);
        let config = BuildConfig { builder: Builder::ObvhsVerySlow, ..BuildConfig::default() };
        let (tree, _) = build_over(&shapes, &config, &Task::new()).expect("nobody cancels");
        assert!(tree.refs().len() > 600, "{}", tree.refs().len());
    }
}
