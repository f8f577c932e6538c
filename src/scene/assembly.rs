//! Puts a scene together piece by piece; used by the built-in scenes and the loaders.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

use crate::geometry::{Cuboid, Plane, Quad, Rigid, ShapeKind, Sphere};

use super::{
    Camera, Color, Image, Light, Material, MaterialKind, Mesh, MeshTriangle, Scene, ShapeSlot, Sky, Track,
};

/// A scene being put together. Shapes get their index in the order in which they are added.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    scene: Scene,
    materials: Vec<Material>,
    animation: Vec<Track>,
}

impl Assembly {
    pub fn new(name: &str) -> Self {
        Self { scene: Scene { name: name.to_owned(), ..Scene::default() }, ..Self::default() }
    }

    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// A matt surface of one colour.
    pub fn matt(&mut self, name: &str, color: Vec3) -> u32 {
        self.surface(name, Color::Solid(color), 0.0)
    }

    /// A diffuse surface that reflects a share of the light as a mirror.
    pub fn surface(&mut self, name: &str, color: Color, reflectivity: f32) -> u32 {
        let kind = MaterialKind::Diffuse { reflectivity };
        self.material(Material { name: name.to_owned(), color, kind })
    }

    pub fn mirror(&mut self, name: &str, color: Vec3) -> u32 {
        let color = Color::Solid(color);
        self.material(Material { name: name.to_owned(), color, kind: MaterialKind::Mirror })
    }

    /// Window glass, of index 1.5.
    pub fn glass(&mut self, name: &str, absorption: Vec3) -> u32 {
        let kind = MaterialKind::Glass { ior: 1.5, absorption };
        self.material(Material { name: name.to_owned(), color: Color::Solid(Vec3::ONE), kind })
    }

    pub fn emissive(&mut self, name: &str, radiance: Vec3) -> u32 {
        let color = Color::Solid(Vec3::ONE);
        self.material(Material { name: name.to_owned(), color, kind: MaterialKind::Emissive { radiance } })
    }

    fn shape(&mut self, kind: ShapeKind, index: usize, material: u32) -> u32 {
        self.scene.shapes.push(ShapeSlot { kind, index: index as u32 });
        self.scene.shape_materials.push(material);
        self.scene.shapes.len() as u32 - 1
    }

    pub fn sphere(&mut self, center: Vec3, radius: f32, material: u32) -> u32 {
        self.scene.spheres.push(Sphere { center, radius });
        self.shape(ShapeKind::Sphere, self.scene.spheres.len() - 1, material)
    }

    pub fn cuboid(&mut self, world_from_object: Rigid, half_extent: Vec3, material: u32) -> u32 {
        self.scene.cuboids.push(Cuboid { world_from_object, half_extent });
        self.shape(ShapeKind::Cuboid, self.scene.cuboids.len() - 1, material)
    }

    pub fn quad(&mut self, corner: Vec3, edge_u: Vec3, edge_v: Vec3, material: u32) -> u32 {
        self.scene.quads.push(Quad { corner, edge_u, edge_v });
        self.shape(ShapeKind::Quad, self.scene.quads.len() - 1, material)
    }

    pub fn plane(&mut self, normal: Vec3, offset: f32, material: u32) {
        self.scene.planes.push((Plane { normal, offset }, material));
    }

    /// Adds a mesh, one shape a triangle; answers where its positions and normals lie in the scene's mesh.
    pub fn mesh(&mut self, mesh: Mesh, material: u32) -> (Range<u32>, Range<u32>) {
        let own = &mut self.scene.mesh;
        let starts = [own.positions.len() as u32, own.normals.len() as u32, own.uvs.len() as u32];
        own.positions.extend(mesh.positions);
        own.normals.extend(mesh.normals);
        own.uvs.extend(mesh.uvs);
        let ranges = (starts[0]..own.positions.len() as u32, starts[1]..own.normals.len() as u32);
        for triangle in mesh.triangles {
            let moved = |indices: [u32; 3], start: u32| {
                indices.map(|i| if i == MeshTriangle::NO_INDEX { i } else { i + start })
            };
            self.scene.mesh.triangles.push(MeshTriangle {
                position: moved(triangle.position, starts[0]),
                normal: moved(triangle.normal, starts[1]),
                uv: moved(triangle.uv, starts[2]),
            });
            self.shape(ShapeKind::Triangle, self.scene.mesh.triangles.len() - 1, material);
        }
        ranges
    }

    /// Sets the mesh of a scene that has none, with a material a triangle.
    pub fn whole_mesh(&mut self, mesh: Mesh, shape_materials: Vec<u32>) {
        debug_assert!(self.scene.shapes.is_empty() && mesh.triangles.len() == shape_materials.len());
        let slot = |index| ShapeSlot { kind: ShapeKind::Triangle, index };
        self.scene.shapes = (0..mesh.triangles.len() as u32).map(slot).collect();
        self.scene.shape_materials = shape_materials;
        self.scene.mesh = mesh;
    }

    pub fn images(&mut self, images: Vec<Image>) {
        self.scene.images = Arc::new(images);
    }

    pub fn light(&mut self, light: Light) {
        self.scene.lights.push(light);
    }

    pub fn sky(&mut self, radiance: Vec3) {
        self.scene.sky = Sky { radiance };
    }

    pub fn track(&mut self, track: Track) {
        self.animation.push(track);
    }

    /// The scene, with a light for every emissive shape.
    pub fn finish(self, camera: Camera) -> Scene {
        let mut scene = self.scene;
        let emits =
            |m: &Material| matches!(m.kind, MaterialKind::Emissive { radiance } if radiance != Vec3::ZERO);
        let is_light: Vec<bool> = self.materials.iter().map(emits).collect();
        if is_light.contains(&true) {
            let shapes = scene.shape_materials.iter().enumerate();
            let emissive = shapes.filter(|(_, m)| is_light[**m as usize]);
            scene.lights.extend(emissive.map(|(shape, _)| Light::Shape { shape: shape as u32 }));
        }
        scene.materials = Arc::new(self.materials);
        scene.animation = Arc::new(self.animation);
        scene.camera = camera;
        scene
    }
}
