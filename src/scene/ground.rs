//! The ground that the program can put under a scene; outside every tree and figure.

use std::sync::Arc;

use glam::Vec3;

use super::{Color, Material, MaterialKind, Scene, UpAxis};
use crate::geometry::Plane;

impl Scene {
    /// This scene with or without a ground: a matt grey plane that the scene's bounds stand on, across the up axis.
    /// A scene without bounded shapes gets none.
    #[must_use]
    pub fn with_ground(&self, on: bool, up: UpAxis) -> Scene {
        let mut scene = self.clone();
        let bounds = scene.bounds();
        if !on || bounds.is_empty() {
            scene.ground = None;
            return scene;
        }
        let lowest = bounds.min.dot(up.vector());
        // A little lower, so that a flat underside does not lie in the ground.
        let gap = bounds.extent().max_element() * 1e-4 + lowest.abs() * 1e-6;
        let materials = Arc::make_mut(&mut scene.materials);
        let material = materials.iter().position(|m| m.name == GROUND_NAME).unwrap_or_else(|| {
            materials.push(ground_material());
            materials.len() - 1
        });
        scene.ground = Some((Plane { normal: up.vector(), offset: lowest - gap }, material as u32));
        scene
    }
}

const GROUND_NAME: &str = "(ground)";

fn ground_material() -> Material {
    Material {
        name: GROUND_NAME.to_owned(),
        color: Color::Solid(Vec3::splat(0.5)),
        kind: MaterialKind::Diffuse { reflectivity: 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn a_ground_lies_below_everything_and_in_no_figure() {
        let scene = builtin::make("soup:100").expect("a built-in scene");
        for up in UpAxis::ALL {
            let grounded = scene.with_ground(true, up);
            let (plane, material) = grounded.ground.expect("a ground");
            assert!(plane.offset < grounded.bounds().min.dot(up.vector()));
            assert_eq!(plane.normal, up.vector());
            assert_eq!(grounded.shape_count(), 100);
            assert_eq!(grounded.material_index(100), material);
            let twice = grounded.with_ground(true, up);
            assert_eq!(twice.materials.len(), grounded.materials.len());
            assert!(twice.with_ground(false, up).ground.is_none());
        }
    }

    #[test]
    fn an_empty_scene_gets_no_ground() {
        assert!(Scene::default().with_ground(true, UpAxis::Y).ground.is_none());
    }
}
