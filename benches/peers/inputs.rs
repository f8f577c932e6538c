//! Triangles and rays that every library gets: of a built-in scene, or from the files of the peers' harness.
//!
//! `scenes/X.tri` holds a u32 count, then nine f32 a triangle; `rays/X.KIND.rays` is a file of rays as `bvhscope bench`
//! reads it.

use std::path::Path;
use std::sync::Arc;

use bvhscope::accel::BuildConfig;
use bvhscope::export::ray_file;
use bvhscope::geometry::{Ray, Shape, ShapeKind};
use bvhscope::render::RenderSettings;
use bvhscope::render::bench::{RaySet, RaySetKind, make_rays};
use bvhscope::scene::{Color, Material, MaterialKind, Mesh, Scene, ShapeSlot, builtin};
use bvhscope::task::Task;
use bvhscope::world::World;
use glam::Vec3;

/// Pixels along each side of the picture whose rays are traced through a built-in scene.
const SIZE: u32 = 512;
/// How far rays start from the surface that they leave, in diagonals of the scene: other libraries know no error bounds,
/// and would hit that surface again.
const OFFSET: f32 = 1e-4;

pub struct Input {
    pub name: String,
    pub triangles: Vec<[Vec3; 3]>,
    /// In order of [`RaySetKind::ALL`]. Directions have unit length, and t_min is zero.
    pub sets: [RaySet; 3],
}

impl Input {
    /// The triangles of a built-in scene, its quads cut in two; other shapes are left out. The rays are those of the
    /// whole scene.
    pub fn builtin(name: &str) -> Self {
        let scene = Arc::new(builtin::make(name).expect("a built-in scene"));
        let mut triangles = Vec::new();
        for shape in (0..scene.shape_count() as u32).map(|i| scene.shape(i)) {
            match shape {
                Shape::Triangle(triangle) => triangles.push(triangle.v),
                Shape::Quad(quad) => {
                    let [a, c] = [quad.corner, quad.corner + quad.edge_u + quad.edge_v];
                    triangles.extend([[a, a + quad.edge_u, c], [a, c, a + quad.edge_v]]);
                }
                Shape::Sphere(_) | Shape::Cuboid(_) | Shape::Torus(_) => {}
            }
        }
        let settings = RenderSettings { width: SIZE, height: SIZE, ..RenderSettings::default() };
        let task = Task::new();
        let world = World::build(Arc::clone(&scene), &BuildConfig::default(), &task).expect("nobody cancels");
        let offset = OFFSET * scene.bounds().extent().length();
        let sets = RaySetKind::ALL.map(|kind| {
            let set = make_rays(kind, &world, &scene.camera, &settings, &task).expect("nobody cancels");
            let rays = set.rays.iter().map(|ray| plain_ray(ray, offset)).collect();
            RaySet { rays, ..set }
        });
        Self { name: name.to_owned(), triangles, sets }
    }

    pub fn from_files(work: &Path, name: &str) -> Self {
        let path = work.join(format!("scenes/{name}.tri"));
        let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let numbers = bytes[4..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let numbers: Vec<f32> = numbers.collect();
        let vertices = |t: &[f32]| std::array::from_fn(|k| Vec3::from_slice(&t[3 * k..]));
        let sets = RaySetKind::ALL.map(|kind| {
            let path = rays_path(work, name, kind);
            let rays = ray_file::read_rays(&path).unwrap_or_else(|error| panic!("{error}"));
            RaySet { rays, query: kind.query() }
        });
        Self { name: name.to_owned(), triangles: numbers.chunks_exact(9).map(vertices).collect(), sets }
    }

    /// Writes the files of the harness into a folder.
    pub fn write(&self, work: &Path, name: &str, expected: &[Vec<f32>; 3]) {
        let count = (self.triangles.len() as u32).to_le_bytes();
        let numbers = self.triangles.iter().flatten().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes);
        for folder in ["scenes", "rays"] {
            std::fs::create_dir_all(work.join(folder)).expect("a folder for the inputs");
        }
        let bytes: Vec<u8> = count.into_iter().chain(numbers).collect();
        std::fs::write(work.join(format!("scenes/{name}.tri")), bytes).expect("the triangles are written");
        for (kind, (set, answers)) in RaySetKind::ALL.into_iter().zip(self.sets.iter().zip(expected)) {
            let path = rays_path(work, name, kind);
            ray_file::write_rays(&path, &set.rays).expect("the rays are written");
            ray_file::write_answers(&path.with_extension("ref"), answers).expect("the answers are written");
        }
    }

    /// As a scene of this program.
    pub fn scene(&self) -> Arc<Scene> {
        let count = self.triangles.len() as u32;
        let triangles: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let kind = MaterialKind::Diffuse { reflectivity: 0.0 };
        let material = Material { name: "matt".to_owned(), color: Color::Solid(Vec3::ONE), kind };
        Arc::new(Scene {
            name: self.name.clone(),
            shapes: (0..count).map(|index| ShapeSlot { kind: ShapeKind::Triangle, index }).collect(),
            shape_materials: vec![0; self.triangles.len()],
            mesh: Mesh::flat(self.triangles.concat(), &triangles),
            materials: Arc::new(vec![material]),
            ..Scene::default()
        })
    }
}

/// The scenes of a folder for which there are rays.
pub fn names(work: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(work.join("scenes")) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.strip_suffix(".tri").map(str::to_owned))
        .filter(|name| RaySetKind::ALL.iter().all(|kind| rays_path(work, name, *kind).is_file()))
        .collect();
    names.sort();
    names
}

fn rays_path(work: &Path, name: &str, kind: RaySetKind) -> std::path::PathBuf {
    work.join(format!("rays/{name}.{}.rays", kind.name()))
}

/// The ray with a direction of unit length, begun a little later.
fn plain_ray(ray: &Ray, offset: f32) -> Ray {
    let length = ray.direction.length();
    let direction = ray.direction / length;
    Ray { origin: ray.origin + direction * offset, direction, t_min: 0.0, t_max: ray.t_max * length - offset }
}
