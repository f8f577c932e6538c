//! End-point overlap (EPO): what boxes cost that hold surfaces which do not belong to them, where rays end all the same.
//!
//! Aila, Karras, Laine, "On Quality Metrics of Bounding Volume Hierarchies", 2013, equation 2:
//! `EPO = sum over nodes of C * (area of shapes not below the node that lies inside its box) / total area`,
//! C = `C_t` for an inner node, `C_i * N` for a leaf.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::World;
use crate::accel::tree::{Nodes as _, Visit};
use crate::accel::{NodeId, Tree};
use crate::each_width;
use crate::geometry::{Aabb, Polygon, Shape};
use crate::task::{Cancelled, Task};

/// Shapes that a thread takes at once; few enough that a cancel is seen in time.
const CHUNK: usize = 64;

/// Boxes that are held against shapes, at most; beyond, EPO is left undefined. A tree over a million triangles that is worth
/// its name needs a fifth of it; one that was built at random grows with the square of its shapes.
const MOST_TESTS: u64 = 1_500_000_000;

/// A share of the total area as an integer, so that sums are the same in any order.
const WHOLE: f64 = (1_u64 << 62) as f64;

/// EPO of a tree, and every node's part in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Epo {
    /// Each node's own summand, by [`NodeId`].
    pub nodes: Vec<f32>,
    pub total: f64,
    /// Whether areas of spheres or tori, which are sampled, are in it.
    pub sampled: bool,
}

impl World {
    /// EPO of the tree: computed once, then kept. `None` where the shapes have no area, or so many boxes overlap that it
    /// would take minutes.
    ///
    /// Triangles and quads are clipped exactly, cuboids by their faces; spheres and tori are sampled on fixed points.
    /// Progress on `task` in shapes.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn epo(&self, task: &Task) -> Result<Option<&Epo>, Cancelled> {
        if self.epo.get().is_none() {
            let epo = measure(self, task)?;
            // Whoever else came first has found the same.
            let _ = self.epo.set(epo);
        }
        Ok(self.known_epo())
    }

    /// The same, if it has been computed.
    pub fn known_epo(&self) -> Option<&Epo> {
        self.epo.get().and_then(Option::as_ref)
    }
}

fn measure(world: &World, task: &Task) -> Result<Option<Epo>, Cancelled> {
    let World { scene, tree, .. } = world;
    let count = scene.shape_count();
    task.start(count as u64);
    let total_area: f64 = (0..count as u32).map(|shape| f64::from(scene.shape(shape).area())).sum();
    if total_area <= 0.0 {
        return Ok(None);
    }
    let nodes = Nodes::of(tree, count);
    let sums: Vec<AtomicU64> = (0..tree.node_count()).map(|_| AtomicU64::new(0)).collect();
    let tests = AtomicU64::new(0);
    // In leaf order, so that shapes that follow each other meet the same nodes; a shape at the first of its leaves.
    let chunks = tree.refs().par_chunks(CHUNK).enumerate();
    chunks.try_for_each_init(Vec::new, |open, (chunk, shapes)| {
        task.check()?;
        if tests.load(Ordering::Relaxed) > MOST_TESTS {
            return Ok(());
        }
        let mut tested = 0;
        for (i, &shape) in shapes.iter().enumerate() {
            if nodes.first_ref[shape as usize] == (chunk * CHUNK + i) as u32 {
                let add = |node: NodeId, area: f64| {
                    let share = (area / total_area * WHOLE) as u64;
                    sums[node.0 as usize].fetch_add(share, Ordering::Relaxed);
                };
                tested += nodes.overlaps(&scene.shape(shape), shape, open, add);
            }
        }
        tests.fetch_add(tested, Ordering::Relaxed);
        task.advance(shapes.len() as u64);
        Ok(())
    })?;
    if tests.into_inner() > MOST_TESTS {
        return Ok(None);
    }
    let config = &world.report.config;
    let costs = sums.into_iter().enumerate().map(|(id, sum)| {
        let cost = match tree.leaf_index(NodeId(id as u32)) {
            Some(leaf_idx) => {
                f64::from(config.intersection_cost) * f64::from(tree.leaf_range(leaf_idx).count)
            }
            None => f64::from(config.traversal_cost),
        };
        cost * (sum.into_inner() as f64 / WHOLE)
    });
    let costs: Vec<f64> = costs.collect();
    Ok(Some(Epo {
        total: costs.iter().sum(),
        nodes: costs.into_iter().map(|cost| cost as f32).collect(),
        sampled: (0..count as u32).any(|shape| scene.shape(shape).area_is_sampled()),
    }))
}

/// What the walk needs of a tree: who is whose child, and who lies below whom.
struct Nodes {
    /// Of inner node i: `children[firsts[i]..firsts[i + 1]]`.
    firsts: Vec<u32>,
    children: Vec<(NodeId, Aabb)>,
    /// By node id: its place in depth-first order, and the number of nodes at and below it.
    span: Vec<[u32; 2]>,
    /// By shape: places of its leaves, `leaves[leaf_firsts[s]..leaf_firsts[s + 1]]`.
    leaf_firsts: Vec<u32>,
    leaves: Vec<u32>,
    /// By shape: its first place among the tree's references; `u32::MAX` for none.
    first_ref: Vec<u32>,
}

impl Nodes {
    fn of(tree: &Tree, shape_count: usize) -> Self {
        let inner_count = tree.inner_count();
        let (mut firsts, mut children) = (vec![0], Vec::with_capacity(tree.node_count()));
        for node_idx in 0..inner_count as u32 {
            each_width!(tree, t => children.extend(t.children(node_idx)));
            firsts.push(children.len() as u32);
        }
        let mut span = vec![[0, 1]; tree.node_count()];
        let mut order = Vec::with_capacity(tree.node_count());
        tree.walk_nodes(|Visit { id, parent, .. }| {
            span[id.0 as usize][0] = order.len() as u32;
            order.push((id, parent));
            true
        });
        for (id, parent) in order.into_iter().rev() {
            if let Some(parent) = parent {
                span[parent.0 as usize][1] += span[id.0 as usize][1];
            }
        }
        let mut leaf_firsts = vec![0_u32; shape_count + 1];
        let mut first_ref = vec![u32::MAX; shape_count];
        for (place, &shape) in tree.refs().iter().enumerate() {
            leaf_firsts[shape as usize + 1] += 1;
            let first = &mut first_ref[shape as usize];
            *first = (*first).min(place as u32);
        }
        for shape in 0..shape_count {
            leaf_firsts[shape + 1] += leaf_firsts[shape];
        }
        let mut next = leaf_firsts.clone();
        let mut leaves = vec![0; tree.refs().len()];
        for leaf_idx in 0..tree.leaf_count() {
            for &shape in tree.leaf_shapes(leaf_idx as u32) {
                leaves[next[shape as usize] as usize] = span[inner_count + leaf_idx][0];
                next[shape as usize] += 1;
            }
        }
        Self { firsts, children, span, leaf_firsts, leaves, first_ref }
    }

    /// Whether the shape with these leaves lies below a node, or is in it.
    fn is_below(&self, leaves: &[u32], node: NodeId) -> bool {
        let [place, count] = self.span[node.0 as usize];
        leaves.iter().any(|leaf| leaf.wrapping_sub(place) < count)
    }

    /// Tells `add` every node that the shape is not below, with the area of the shape inside its box, if there is any.
    /// Answers how many boxes were tested.
    fn overlaps(
        &self,
        geometry: &Shape,
        shape: u32,
        open: &mut Vec<(u32, Part)>,
        mut add: impl FnMut(NodeId, f64),
    ) -> u64 {
        let own = self.leaf_firsts[shape as usize] as usize..self.leaf_firsts[shape as usize + 1] as usize;
        let own = &self.leaves[own];
        let whole = Part::whole(geometry);
        if whole.area <= 0.0 || self.firsts.len() == 1 {
            return 0;
        }
        let mut tested = 0;
        open.push((0, whole));
        while let Some((node_idx, part)) = open.pop() {
            let (first, end) = (self.firsts[node_idx as usize], self.firsts[node_idx as usize + 1]);
            tested += u64::from(end - first);
            for &(child, bounds) in &self.children[first as usize..end as usize] {
                if bounds.intersection(part.bounds).is_empty() {
                    continue;
                }
                let (below, inner) = (self.is_below(own, child), (child.0 as usize) < self.firsts.len() - 1);
                if below && !inner {
                    continue;
                }
                let inside = part.inside(geometry, &bounds);
                // What only touches the box has no surface in any box inside it.
                if inside.area <= 0.0 {
                    continue;
                }
                if !below {
                    add(child, inside.area);
                }
                if inner {
                    open.push((child.0, inside));
                }
            }
        }
        tested
    }
}

/// The part of a shape inside a box.
#[derive(Clone, Copy)]
struct Part {
    /// `None` for shapes that are not flat: they are clipped as a whole.
    polygon: Option<Polygon>,
    bounds: Aabb,
    area: f64,
}

impl Part {
    fn whole(shape: &Shape) -> Self {
        let polygon = shape.polygon();
        let area = polygon.map_or_else(|| f64::from(shape.area()), |polygon| polygon.area());
        Self { polygon, bounds: shape.bounds(), area }
    }

    /// What of this part lies inside a box, which lies inside the box of this part.
    fn inside(&self, shape: &Shape, clip: &Aabb) -> Self {
        if clip.contains(&self.bounds) {
            return *self;
        }
        match &self.polygon {
            Some(polygon) => {
                let polygon = polygon.inside(clip);
                Self { bounds: polygon.bounds(), area: polygon.area(), polygon: Some(polygon) }
            }
            None => Self {
                polygon: None,
                bounds: self.bounds.intersection(*clip),
                area: shape.area_inside(clip).into(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;

    use super::*;
    use crate::accel::{BuildConfig, Builder, NodeKind, Width};
    use crate::geometry::{Quad, ShapeKind};
    use crate::scene::{Color, Material, MaterialKind, Scene, ShapeSlot, builtin};

    fn world(scene: &str, config: &BuildConfig) -> World {
        let scene = Arc::new(builtin::make(scene).expect("a built-in scene"));
        World::build(scene, config, &Task::new()).expect("nobody cancels")
    }

    /// The definition, word for word: every node against every shape.
    fn direct(world: &World) -> Vec<f64> {
        let count = world.scene.shape_count() as u32;
        let shapes: Vec<Shape> = (0..count).map(|shape| world.scene.shape(shape)).collect();
        let total: f64 = shapes.iter().map(|shape| f64::from(shape.area())).sum();
        let mut family = vec![(None, Aabb::EMPTY, Vec::new()); world.tree.node_count()];
        world.tree.walk(|node| {
            let own = match node.kind {
                NodeKind::Leaf(shapes) => shapes.to_vec(),
                NodeKind::Inner(_) => Vec::new(),
            };
            family[node.id.0 as usize] = (node.parent, node.bounds, own);
            true
        });
        let mut below = vec![vec![false; shapes.len()]; family.len()];
        for (id, (_, _, own)) in family.iter().enumerate() {
            let mut up = Some(NodeId(id as u32));
            while let Some(node) = up {
                own.iter().for_each(|&shape| below[node.0 as usize][shape as usize] = true);
                up = family[node.0 as usize].0;
            }
        }
        let config = &world.report.config;
        let node_cost = |(id, (_, bounds, own)): (usize, &(Option<NodeId>, Aabb, Vec<u32>))| {
            let cost = match own.len() {
                0 => config.traversal_cost,
                n => config.intersection_cost * n as f32,
            };
            let others = shapes.iter().enumerate().filter(|(shape, _)| !below[id][*shape]);
            let area: f64 = others.map(|(_, shape)| f64::from(shape.area_inside(bounds))).sum();
            f64::from(cost) * area / total
        };
        family.iter().enumerate().map(node_cost).collect()
    }

    #[test]
    fn it_is_what_the_definition_says_for_every_builder_and_width() {
        let scenes = ["soup:150", "cornell", "spheres"];
        for (i, builder) in Builder::ALL.into_iter().enumerate() {
            for width in Width::ALL {
                let config = BuildConfig { builder, width, traversal_cost: 1.25, ..BuildConfig::default() };
                let world = world(scenes[i % scenes.len()], &config);
                let epo = world.epo(&Task::new()).expect("nobody cancels").expect("shapes have areas");
                let direct = direct(&world);
                let total: f64 = direct.iter().sum();
                assert!((epo.total - total).abs() <= 1e-5 * total, "{config:?}: {} {total}", epo.total);
                for (id, (found, expected)) in epo.nodes.iter().zip(&direct).enumerate() {
                    let error = (f64::from(*found) - expected).abs();
                    assert!(error <= 1e-6 * (1.0 + total), "node {id} of {config:?}: {found} {expected}");
                }
            }
        }
    }

    /// Unit squares in one plane.
    fn squares(at: &[f32]) -> Scene {
        let square = |&x: &f32| Quad { corner: Vec3::X * x, edge_u: Vec3::X, edge_v: Vec3::Y };
        let kind = MaterialKind::Diffuse { reflectivity: 0.0 };
        let matt = Material { name: "matt".to_owned(), color: Color::Solid(Vec3::ONE), kind };
        let slot = |index| ShapeSlot { kind: ShapeKind::Quad, index };
        Scene {
            shapes: (0..at.len() as u32).map(slot).collect(),
            shape_materials: vec![0; at.len()],
            quads: at.iter().map(square).collect(),
            materials: Arc::new(vec![matt]),
            ..Scene::default()
        }
    }

    #[test]
    fn small_trees_done_by_hand() {
        let config = BuildConfig { leaf: 1, width: Width::W2, ..BuildConfig::default() };
        let epo = |at: &[f32], config: &BuildConfig| {
            let world = World::build(Arc::new(squares(at)), config, &Task::new()).expect("nobody cancels");
            world.epo(&Task::new()).expect("nobody cancels").expect("squares have areas").total
        };
        // Far apart: nothing lies in a box that it does not belong to.
        assert_eq!(epo(&[0.0, 5.0, 10.0], &config), 0.0);
        // Two squares that cover half of each other: half of each lies in the other's leaf, of two in all.
        assert_eq!(epo(&[0.0, 0.5], &config), 0.5);
        let dear = BuildConfig { intersection_cost: 3.0, ..config };
        assert_eq!(epo(&[0.0, 0.5], &dear), 1.5);
        // In one leaf, both belong to it.
        assert_eq!(epo(&[0.0, 0.5], &BuildConfig { leaf: 2, ..config }), 0.0);
    }

    #[test]
    fn it_is_the_same_at_any_number_of_threads() {
        let config = BuildConfig::default();
        let worlds = [world("bunny", &config), world("bunny", &config)];
        let found = worlds.iter().zip([1, 3]).map(|(world, threads)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| world.epo(&Task::new()).expect("nobody cancels").cloned())
        });
        let found: Vec<_> = found.collect();
        assert_eq!(found[0], found[1]);
        assert!(found[0].as_ref().is_some_and(|epo| epo.total > 0.0 && epo.sampled));
    }

    #[test]
    fn what_has_no_area_has_none_and_a_cancel_is_heard() {
        let empty =
            World::build(Arc::default(), &BuildConfig::default(), &Task::new()).expect("nobody cancels");
        assert_eq!(empty.epo(&Task::new()), Ok(None));
        let cancelled = Task::new();
        cancelled.cancel();
        let bunny = world("bunny", &BuildConfig::default());
        assert_eq!(bunny.epo(&cancelled), Err(Cancelled));
    }
}
