//! What the readers of all formats fill: triangles with materials, the file's own face numbers, and what was repaired.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::fault::{Fault, counted};
use super::polygon::PolygonCutter;
use super::stage;
use crate::scene::assembly::Assembly;
use crate::scene::{Color, Image, Material, MaterialKind, Mesh, MeshTriangle, Scene, UpAxis};

/// Coordinates beyond this are taken for damage: areas and volumes of boxes must stay finite in single precision.
pub(super) const MAX_COORDINATE: f32 = 1e12;

/// Copies of one triangle that are kept. A ray that hits one must ask them all, since each may be the first in the file:
/// a million of them would take hours, and say nothing more.
const MAX_COPIES: usize = 256;

/// A corner of a face: indices into the mesh's arrays, `NO_INDEX` for what it has not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub position: u32,
    pub normal: u32,
    pub uv: u32,
}

impl Corner {
    pub const NONE: u32 = MeshTriangle::NO_INDEX;
}

/// Faces that could not be kept.
#[derive(Debug, Default)]
pub(super) struct Removed {
    pub outside: usize,
    pub not_finite: usize,
    pub too_few_corners: usize,
    pub too_many_corners: usize,
    pub copies: usize,
}

/// A model in the making.
pub(super) struct Model {
    pub mesh: Mesh,
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    /// Linear; one a position, or none at all.
    pub colors: Vec<Vec3>,
    pub removed: Removed,
    pub warnings: Vec<String>,
    shape_materials: Vec<u32>,
    /// The file's index of each triangle's face.
    faces: Vec<u32>,
    /// What the faces are called in messages, and how many the file has.
    face_count: usize,
    cutter: PolygonCutter,
    /// The positions of the face that is being added.
    polygon: Vec<Vec3>,
}

impl Model {
    /// The material of faces that have none.
    pub const NO_MATERIAL: u32 = u32::MAX;

    pub fn new() -> Self {
        Self {
            mesh: Mesh::default(),
            materials: Vec::new(),
            images: Vec::new(),
            colors: Vec::new(),
            removed: Removed::default(),
            warnings: Vec::new(),
            shape_materials: Vec::new(),
            faces: Vec::new(),
            face_count: 0,
            cutter: PolygonCutter::new(),
            polygon: Vec::new(),
        }
    }

    pub fn warn(&mut self, warning: impl Into<String>) {
        self.warnings.push(warning.into());
    }

    /// Says how many faces the file has, those that the reader itself left out included.
    pub fn set_face_count(&mut self, count: usize) {
        self.face_count = count;
    }

    /// Makes room for as many triangles.
    pub fn reserve(&mut self, triangles: usize) {
        self.mesh.triangles.reserve(triangles);
        self.shape_materials.reserve(triangles);
        self.faces.reserve(triangles);
    }

    /// Adds the face that the file counts as `face`, cut into triangles, or counts it as removed.
    pub fn add_face(&mut self, face: u32, corners: &[Corner], material: u32) {
        self.face_count = self.face_count.max(face as usize + 1);
        if corners.len() < 3 {
            self.removed.too_few_corners += 1;
            return;
        }
        if corners.len() > PolygonCutter::MAX_CORNERS {
            self.removed.too_many_corners += 1;
            return;
        }
        self.polygon.clear();
        for corner in corners {
            match self.mesh.positions.get(corner.position as usize) {
                Some(position) => self.polygon.push(*position),
                None => {
                    self.removed.outside += 1;
                    return;
                }
            }
        }
        // A NaN fails the comparison.
        if !self.polygon.iter().all(|p| p.abs().max_element() <= MAX_COORDINATE && !p.is_nan()) {
            self.removed.not_finite += 1;
            return;
        }
        for triangle in self.cutter.cut(&self.polygon).chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| corners[triangle[i] as usize]);
            self.mesh.triangles.push(MeshTriangle {
                position: [a.position, b.position, c.position],
                normal: [a.normal, b.normal, c.normal],
                uv: [a.uv, b.uv, c.uv],
            });
            self.shape_materials.push(material);
            self.faces.push(face);
        }
    }

    /// The scene, framed and lit, with the warnings.
    pub fn finish(mut self, name: &str, up: UpAxis) -> Result<(Scene, Vec<String>), Fault> {
        self.leave_out_copies();
        self.warn_of_removed();
        if self.mesh.triangles.is_empty() {
            let what = match self.face_count {
                0 => {
                    format!("there are no faces in it (but {})", counted(self.mesh.positions.len(), "vertex"))
                }
                count => format!(
                    "none of its {} can be shown: {}",
                    counted(count, "face"),
                    self.warnings.join("; ")
                ),
            };
            return Err(Fault::of_file(format!("{what}; export the model again, as a mesh of polygons")));
        }
        self.clean_normals_and_uvs();
        self.paint();
        self.give_default_material();
        let file_faces = self.faces.iter().enumerate().any(|(i, face)| *face as usize != i);
        let file_faces = file_faces.then(|| Arc::new(std::mem::take(&mut self.faces)));

        let mut assembly = Assembly::new(name);
        for material in self.materials {
            assembly.material(material);
        }
        assembly.images(self.images);
        assembly.whole_mesh(self.mesh, self.shape_materials);
        let mut scene = stage::finish(assembly, up);
        scene.file_faces = file_faces;
        Ok((scene, self.warnings))
    }

    /// Keeps [`MAX_COPIES`] triangles with the very same corners.
    fn leave_out_copies(&mut self) {
        let positions = &self.mesh.positions;
        let corners =
            |t: &MeshTriangle| t.position.map(|i| positions[i as usize].to_array().map(f32::to_bits));
        let hashes: Vec<u64> = self
            .mesh
            .triangles
            .par_iter()
            .map(|t| BuildHasherDefault::<DefaultHasher>::new().hash_one(corners(t)))
            .collect();
        let mut sorted = hashes.clone();
        sorted.par_sort_unstable();
        // Equal numbers side by side; almost always none is there that often.
        let often: HashSet<u64> =
            sorted.windows(MAX_COPIES + 1).filter(|w| w[0] == w[MAX_COPIES]).map(|w| w[0]).collect();
        if often.is_empty() {
            return;
        }
        let mut seen: HashMap<_, usize> = HashMap::new();
        let keep: Vec<bool> = self
            .mesh
            .triangles
            .iter()
            .zip(&hashes)
            .map(|(triangle, hash)| {
                if !often.contains(hash) {
                    return true;
                }
                let copies = seen.entry(corners(triangle)).or_default();
                *copies += 1;
                *copies <= MAX_COPIES
            })
            .collect();
        fn retain<T>(all: &mut Vec<T>, keep: &[bool]) {
            let mut keep = keep.iter();
            all.retain(|_| keep.next().is_none_or(|k| *k));
        }
        self.removed.copies = keep.iter().filter(|k| !**k).count();
        retain(&mut self.mesh.triangles, &keep);
        retain(&mut self.shape_materials, &keep);
        retain(&mut self.faces, &keep);
    }

    fn warn_of_removed(&mut self) {
        for (count, why) in [
            (self.removed.outside, "pointing to a vertex that the file does not have"),
            (self.removed.not_finite, "with a coordinate that is not a number, infinite, or beyond 1e12"),
            (self.removed.too_few_corners, "with fewer than three corners"),
            (self.removed.too_many_corners, "with more than 65,536 corners"),
            (self.removed.copies, "lying exactly on 256 others"),
        ] {
            if count > 0 {
                self.warn(format!("{} {why} left out", counted(count, "face")));
            }
        }
    }

    /// Makes normals of unit length; a triangle keeps its normals and coordinates only if all three corners have them.
    fn clean_normals_and_uvs(&mut self) {
        let Mesh { normals, uvs, triangles, .. } = &mut self.mesh;
        normals.par_iter_mut().for_each(|n| *n = n.normalize_or_zero());
        triangles.par_iter_mut().for_each(|t| {
            if t.normal.iter().any(|i| normals.get(*i as usize).is_none_or(|n| *n == Vec3::ZERO)) {
                t.normal = [Corner::NONE; 3];
            }
            if t.uv.iter().any(|i| uvs.get(*i as usize).is_none_or(|uv| !uv.is_finite())) {
                t.uv = [Corner::NONE; 3];
            }
        });
    }

    /// Gives triangles over coloured positions a material of their mean colour, rounded so that there are not too many.
    /// Applies to diffuse materials of one colour, which it multiplies.
    fn paint(&mut self) {
        const STEPS: f32 = 31.0;
        if self.colors.is_empty() || self.colors.len() != self.mesh.positions.len() {
            return;
        }
        self.give_default_material();
        let mut palette: HashMap<(u32, [u8; 3]), u32> = HashMap::new();
        for (triangle, material) in self.mesh.triangles.iter().zip(&mut self.shape_materials) {
            let base = &self.materials[*material as usize];
            let (Color::Solid(tint), MaterialKind::Diffuse { .. }) = (&base.color, base.kind) else {
                continue;
            };
            let mean = triangle.position.iter().map(|i| self.colors[*i as usize]).sum::<Vec3>() / 3.0;
            // Rounded where steps look even, not where light adds up.
            let step = mean.clamp(Vec3::ZERO, Vec3::ONE).to_array().map(|c| (c.sqrt() * STEPS).round() as u8);
            let tint = *tint;
            let base_index = *material as usize;
            *material = *palette.entry((*material, step)).or_insert_with(|| {
                let painted = Vec3::from_array(step.map(|c| (f32::from(c) / STEPS).powi(2)));
                let base = &self.materials[base_index];
                self.materials.push(Material { color: Color::Solid(tint * painted), ..base.clone() });
                self.materials.len() as u32 - 1
            });
        }
    }

    /// Replaces missing materials by one grey one, or by white where positions have colours.
    fn give_default_material(&mut self) {
        let known = self.materials.len() as u32;
        if self.shape_materials.iter().all(|m| *m < known) {
            return;
        }
        let painted = !self.colors.is_empty() && self.colors.len() == self.mesh.positions.len();
        self.materials.push(Material {
            name: "(none)".to_owned(),
            color: Color::Solid(if painted { Vec3::ONE } else { Vec3::splat(0.7) }),
            kind: MaterialKind::Diffuse { reflectivity: 0.0 },
        });
        for material in self.shape_materials.iter_mut().filter(|m| **m >= known) {
            *material = known;
        }
    }
}
