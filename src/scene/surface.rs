//! What a hit is a hit of.

use glam::{Vec2, Vec3};

use crate::geometry::{Hit, Ray, ShapeHit, ShapeKind, SurfacePoint, leave_surface};

use super::mesh::{Mesh, MeshTriangle};
use super::{Scene, ShapeSlot};

/// A point on a surface with everything that shading asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    pub position: Vec3,
    /// Bound of the absolute error of `position`.
    pub error: Vec3,
    /// Unit normal on the shape's outside, as the geometry has it.
    pub geometric_normal: Vec3,
    /// Interpolated from vertex normals where the mesh has them, on the same side as `geometric_normal`.
    pub shading_normal: Vec3,
    pub uv: Vec2,
    /// Index of the shape (or plane, or ground) and of its material.
    pub shape: u32,
    pub material: u32,
    /// Whether the ray came from outside: `dot(ray.direction, geometric_normal) < 0`.
    pub front: bool,
}

impl Scene {
    /// The surface at `hit`, the answer to `ray`.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let Some(&ShapeSlot { kind, index }) = self.shapes.get(hit.shape as usize) else {
            return self.unbounded_surface(ray, hit);
        };
        let material = self.shape_materials[hit.shape as usize];
        let (shape_hit, i) = (ShapeHit { t: hit.t, u: hit.u, v: hit.v }, index as usize);
        // Kind by kind, not by way of a `Shape`, which would be written and read again before anything is computed.
        let point = match kind {
            ShapeKind::Triangle => {
                let point = self.triangle(index).surface(ray, &shape_hit);
                let (normal, uv) = self.mesh.vertex_attributes(&self.mesh.triangles[i], hit, &point);
                return Surface::new(ray, hit.shape, material, point, normal, uv);
            }
            ShapeKind::Quad => self.quads[i].surface(ray, &shape_hit),
            ShapeKind::Sphere => self.spheres[i].surface(ray, &shape_hit),
            ShapeKind::Cuboid => self.cuboids[i].surface(ray, &shape_hit),
            ShapeKind::Torus => self.tori[i].surface(ray, &shape_hit),
        };
        Surface::new(ray, hit.shape, material, point, point.normal, point.uv)
    }

    fn unbounded_surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let (_, plane, material) = self
            .unbounded()
            .nth(hit.shape as usize - self.shapes.len())
            .expect("a hit names a shape, a plane or the ground");
        let point = plane.surface(ray, &ShapeHit { t: hit.t, u: hit.u, v: hit.v });
        Surface::new(ray, hit.shape, material, point, point.normal, point.uv)
    }
}

impl Mesh {
    /// Shading normal and uv at a hit, from the vertices where they have them, else from the geometry.
    #[inline]
    fn vertex_attributes(&self, triangle: &MeshTriangle, hit: &Hit, point: &SurfacePoint) -> (Vec3, Vec2) {
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let has = |indices: [u32; 3]| !indices.contains(&MeshTriangle::NO_INDEX);
        let normal = if has(triangle.normal) {
            let sum: Vec3 = (0..3).map(|i| weights[i] * self.normals[triangle.normal[i] as usize]).sum();
            // Vertex normals that cancel out, or are not numbers, say nothing.
            let unit = sum.try_normalize().unwrap_or(point.normal);
            if unit.dot(point.normal) < 0.0 { -unit } else { unit }
        } else {
            point.normal
        };
        let uv = if has(triangle.uv) {
            (0..3).map(|i| weights[i] * self.uvs[triangle.uv[i] as usize]).sum()
        } else {
            point.uv
        };
        (normal, uv)
    }
}

impl Surface {
    #[inline(always)]
    fn new(
        ray: &Ray,
        shape: u32,
        material: u32,
        point: SurfacePoint,
        shading_normal: Vec3,
        uv: Vec2,
    ) -> Self {
        Self {
            position: point.position,
            error: point.error,
            geometric_normal: point.normal,
            shading_normal,
            uv,
            shape,
            material,
            front: ray.direction.dot(point.normal) < 0.0,
        }
    }

    /// The origin of a ray that leaves along `direction`: `position` moved along the geometric normal by the error
    /// bound to the side that `direction` points to (Waechter and Binder, "A Fast and Robust Method for Avoiding
    /// Self-Intersection", 2019).
    #[inline]
    pub fn ray_origin(&self, direction: Vec3) -> Vec3 {
        leave_surface(self.position, self.error, self.geometric_normal, direction)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::{Plane, PreparedRay, Sphere};
    use crate::scene::{Color, Material, MaterialKind};

    fn material(name: &str) -> Material {
        let kind = MaterialKind::Diffuse { reflectivity: 0.0 };
        Material { name: name.to_owned(), color: Color::Solid(Vec3::ONE), kind }
    }

    /// One triangle in z = 0 with vertex normals and uvs, a sphere, a plane and a ground, each of its own material.
    fn scene(triangle: MeshTriangle) -> Scene {
        Scene {
            shapes: vec![
                ShapeSlot { kind: ShapeKind::Sphere, index: 0 },
                ShapeSlot { kind: ShapeKind::Triangle, index: 0 },
            ],
            shape_materials: vec![1, 0],
            mesh: Mesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                normals: vec![Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.6, 0.0, 0.8), Vec3::Z],
                uvs: vec![Vec2::ZERO, Vec2::new(4.0, 0.0), Vec2::new(0.0, 8.0)],
                triangles: vec![triangle],
            },
            spheres: vec![Sphere { center: Vec3::new(5.0, 0.0, 0.0), radius: 1.0 }],
            planes: vec![(Plane { normal: Vec3::Y, offset: -3.0 }, 2)],
            ground: Some((Plane { normal: Vec3::Y, offset: -4.0 }, 3)),
            materials: Arc::new(["mesh", "ball", "plane", "ground"].map(material).to_vec()),
            ..Scene::default()
        }
    }

    const ALL: MeshTriangle = MeshTriangle { position: [0, 1, 2], normal: [0, 1, 2], uv: [0, 1, 2] };

    fn surface_of(scene: &Scene, ray: Ray, shape: u32) -> Surface {
        let prepared = PreparedRay::new(ray);
        let found = if (shape as usize) < scene.shape_count() {
            scene.shape(shape).intersect(&prepared)
        } else {
            scene.unbounded().find(|(index, ..)| *index == shape).unwrap().1.intersect(&prepared)
        }
        .expect("the ray is aimed at the shape");
        scene.surface(&ray, &Hit { t: found.t, shape, u: found.u, v: found.v })
    }

    #[test]
    fn vertex_normals_and_uvs_are_interpolated_on_the_side_of_the_geometry() {
        let ray = Ray::new(Vec3::new(0.25, 0.5, -1.0), Vec3::Z);
        let s = surface_of(&scene(ALL), ray, 1);
        assert_eq!((s.geometric_normal, s.uv, s.front, s.material), (Vec3::Z, Vec2::new(1.0, 4.0), false, 0));
        assert!((s.shading_normal - Vec3::Z).length() < 1e-6, "{s:?}");
        let turned = MeshTriangle { position: [0, 2, 1], normal: [0, 0, 0], ..ALL };
        let s = surface_of(&scene(turned), ray, 1);
        assert_eq!((s.geometric_normal, s.front), (Vec3::NEG_Z, true));
        assert!((s.shading_normal - Vec3::new(-0.6, 0.0, -0.8)).length() < 1e-6, "{s:?}");
    }

    #[test]
    fn without_vertex_attributes_the_geometry_answers() {
        let bare = MeshTriangle { normal: [0, 1, u32::MAX], uv: [MeshTriangle::NO_INDEX; 3], ..ALL };
        let s = surface_of(&scene(bare), Ray::new(Vec3::new(0.25, 0.5, 1.0), Vec3::NEG_Z), 1);
        assert_eq!((s.shading_normal, s.uv, s.front), (Vec3::Z, Vec2::new(0.25, 0.5), true));
    }

    #[test]
    fn shapes_planes_and_ground_have_their_own_material() {
        let scene = scene(ALL);
        let down = Ray::new(Vec3::new(5.0, 3.0, 0.0), Vec3::NEG_Y);
        for (shape, y, material) in [(0, 1.0, 1), (2, -3.0, 2), (3, -4.0, 3)] {
            let s = surface_of(&scene, down, shape);
            assert_eq!(
                (s.position.y, s.material, s.shape, s.geometric_normal),
                (y, material, shape, Vec3::Y)
            );
            assert!(s.ray_origin(Vec3::ONE).y > y && s.ray_origin(Vec3::NEG_ONE).y < y);
        }
    }
}
