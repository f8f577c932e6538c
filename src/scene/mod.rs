//! What there is to see: shapes, materials, lights, a camera, and how they move. Knows nothing of trees.

pub mod animation;
mod assembly;
pub mod builtin;
pub mod camera;
mod ground;
pub mod light;
pub mod load;
pub mod material;
pub mod mesh;
pub mod reference;
pub mod surface;

use std::sync::Arc;

use crate::geometry::{Aabb, Cuboid, Plane, Quad, Shape, ShapeKind, Sphere, Torus, Triangle};

pub use animation::{Motion, Track};
pub use camera::{Camera, UpAxis};
pub use light::{Light, Sky};
pub use load::{LoadError, Loaded};
pub use material::{Color, Image, Material, MaterialKind, Pixels, ShadowRule};
pub use mesh::{Mesh, MeshTriangle};
pub use reference::SceneRef;
pub use surface::Surface;

/// Where a shape's geometry lies: the index in the scene's array of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapeSlot {
    pub kind: ShapeKind,
    pub index: u32,
}

/// A scene at one moment. Frozen behind an `Arc` once loaded; [`Scene::at`] makes the scene of another moment.
///
/// A shape's index is its place in [`Scene::shapes`]: for a file, the order in the file after triangulation.
/// Indices from `shape_count()` on name the planes, then the staged ground.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub name: String,
    /// Every bounded shape, in order.
    pub shapes: Vec<ShapeSlot>,
    /// Index into `materials`, for each of `shapes`.
    pub shape_materials: Vec<u32>,
    pub mesh: Mesh,
    pub spheres: Vec<Sphere>,
    pub cuboids: Vec<Cuboid>,
    pub quads: Vec<Quad>,
    pub tori: Vec<Torus>,
    /// Unbounded, with the index of their material; outside every tree and figure.
    pub planes: Vec<(Plane, u32)>,
    /// A ground that the program added; outside every tree and figure.
    pub ground: Option<(Plane, u32)>,
    pub materials: Arc<Vec<Material>>,
    pub images: Arc<Vec<Image>>,
    /// Emissive shapes, and lights without a shape.
    pub lights: Vec<Light>,
    pub sky: Sky,
    /// The camera that frames the scene.
    pub camera: Camera,
    pub animation: Arc<Vec<Track>>,
    /// The moment that this scene shows, in seconds.
    pub time: f32,
    /// The scene of t = 0, of one that has moved.
    pub still: Option<Arc<Scene>>,
    /// For scenes read from a file: the file's own index of each shape's face, where shapes were removed or cut.
    pub file_faces: Option<Arc<Vec<u32>>>,
}

impl Scene {
    pub fn shape_count(&self) -> usize {
        self.shapes.len()
    }

    /// The geometry of a bounded shape.
    #[inline]
    pub fn shape(&self, shape: u32) -> Shape {
        self.shape_in(self.shapes[shape as usize])
    }

    #[inline]
    fn shape_in(&self, slot: ShapeSlot) -> Shape {
        let i = slot.index as usize;
        match slot.kind {
            ShapeKind::Triangle => Shape::Triangle(self.triangle(slot.index)),
            ShapeKind::Sphere => Shape::Sphere(self.spheres[i]),
            ShapeKind::Cuboid => Shape::Cuboid(self.cuboids[i]),
            ShapeKind::Quad => Shape::Quad(self.quads[i]),
            ShapeKind::Torus => Shape::Torus(self.tori[i]),
        }
    }

    /// The geometry of many bounded shapes, in any order. A pass for each step from the shape to its corners, so that many
    /// of the memory's answers are waited for at a time, and not one after the other.
    pub fn gather(&self, shapes: &[u32]) -> Vec<Shape> {
        let slots: Vec<ShapeSlot> = shapes.iter().map(|&shape| self.shapes[shape as usize]).collect();
        let corners = slots.iter().map(|slot| match slot.kind {
            ShapeKind::Triangle => self.mesh.triangles[slot.index as usize].position,
            ShapeKind::Sphere | ShapeKind::Cuboid | ShapeKind::Quad | ShapeKind::Torus => [0; 3],
        });
        let corners: Vec<[u32; 3]> = corners.collect();
        let shapes = slots.iter().zip(corners).map(|(&slot, corners)| match slot.kind {
            ShapeKind::Triangle => {
                Shape::Triangle(Triangle { v: corners.map(|i| self.mesh.positions[i as usize]) })
            }
            ShapeKind::Sphere | ShapeKind::Cuboid | ShapeKind::Quad | ShapeKind::Torus => self.shape_in(slot),
        });
        shapes.collect()
    }

    /// A triangle of the mesh by its index there (not its shape index).
    #[inline]
    pub fn triangle(&self, triangle: u32) -> Triangle {
        let p = self.mesh.triangles[triangle as usize].position;
        Triangle { v: p.map(|i| self.mesh.positions[i as usize]) }
    }

    /// The box of every shape, in order of the shapes.
    pub fn shape_bounds(&self) -> Vec<Aabb> {
        use rayon::prelude::*;
        (0..self.shape_count() as u32).into_par_iter().map(|i| self.shape(i).bounds()).collect()
    }

    /// The box around all bounded shapes.
    pub fn bounds(&self) -> Aabb {
        self.shape_bounds().into_iter().fold(Aabb::EMPTY, Aabb::union)
    }

    /// All unbounded surfaces, each with the shape index that its hits report and its material.
    pub fn unbounded(&self) -> impl Iterator<Item = (u32, &Plane, u32)> {
        let first = self.shapes.len() as u32;
        self.planes
            .iter()
            .chain(self.ground.iter())
            .enumerate()
            .map(move |(i, (plane, m))| (first + i as u32, plane, *m))
    }

    /// The index of the material of a shape, a plane or the ground.
    #[inline]
    pub fn material_index(&self, shape: u32) -> u32 {
        let i = shape as usize;
        match self.shape_materials.get(i) {
            Some(&m) => m,
            None => match self.planes.get(i - self.shapes.len()) {
                Some((_, m)) => *m,
                None => self.ground.as_ref().expect("shape index out of range").1,
            },
        }
    }

    #[inline]
    pub fn material(&self, shape: u32) -> &Material {
        &self.materials[self.material_index(shape) as usize]
    }
}
