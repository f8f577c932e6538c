//! glTF and GLB through the `gltf` crate: nodes, materials, textures of the base colour.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use glam::{Mat3, Mat4, Vec2, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Document, Gltf, Primitive};

use super::fault::{Fault, counted, guarded};
use super::model::{Corner, Model};
use super::texture;
use crate::scene::{Color, Image, Material, MaterialKind, Pixels};
use crate::task::Task;

/// More values than this in one accessor are taken for damage; some need no bytes in the file.
const MAX_COUNT: usize = 1 << 28;
/// Extensions without which the geometry cannot be read.
const GEOMETRY_EXTENSIONS: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization"];

/// Reads the default scene (or the first, or all nodes); files that it names lie in `folder`. The faces are the triangles
/// in the order in which the nodes are walked.
pub(super) fn read(bytes: &[u8], folder: &Path, task: &Task) -> Result<Model, Fault> {
    guarded("glTF", || {
        let (document, blob) = parse(bytes)?;
        let buffers = read_buffers(&document, blob, folder)?;
        task.check()?;
        let mut reader =
            ModelReader { buffers: &buffers, model: Model::new(), faces: 0, skipped: Skipped::default() };
        reader.read_materials(&document, folder, task)?;
        for (matrix, mesh) in placed_meshes(&document) {
            for primitive in mesh.primitives() {
                task.check()?;
                reader.add_primitive(&primitive, matrix);
            }
        }
        Ok(reader.finish())
    })?
}

/// The document, checked, and the binary part of a GLB.
fn parse(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), Fault> {
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|error| {
        let advice = "the file is truncated, damaged, or no glTF; export the model again";
        match &error {
            gltf::Error::Deserialize(json) => Fault::at_line(json.line(), format!("{json}: {advice}")),
            _ => Fault::of_file(format!("{error}: {advice}")),
        }
    })?;
    let mut json = document.into_json();
    let needed = json.extensions_required.iter().find(|name| GEOMETRY_EXTENSIONS.contains(&name.as_str()));
    if let Some(name) = needed {
        return Err(Fault::of_file(format!(
            "its meshes are compressed ({name}), which this program does not read; export the model without compression"
        )));
    }
    // Whatever else is required concerns looks alone: shown as well as can be.
    json.extensions_required.clear();
    let document = Document::from_json(json).map_err(|error| match &error {
        gltf::Error::Validation(faults) => {
            let first = faults.first().map(|(path, fault)| format!("{path}: {fault}")).unwrap_or_default();
            Fault::of_file(format!("{first}: the file breaks the rules of glTF; export the model again"))
        }
        _ => Fault::of_file(format!("{error}; export the model again")),
    })?;
    Ok((document, blob))
}

fn read_buffers(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    folder: &Path,
) -> Result<Vec<Vec<u8>>, Fault> {
    let read = |buffer: gltf::Buffer| {
        let what = match buffer.source() {
            gltf::buffer::Source::Uri(uri) if !uri.starts_with("data:") => format!("its data file '{uri}'"),
            _ => format!("its data (buffer {})", buffer.index()),
        };
        let data = gltf::buffer::Data::from_source_and_blob(buffer.source(), Some(folder), &mut blob)
            .map_err(|error| {
                Fault::of_file(format!("{what} cannot be read ({error}); put it beside the model"))
            })?;
        if data.0.len() < buffer.length() {
            let (has, needs) = (data.0.len(), buffer.length());
            let reason =
                format!("{what} holds {has} of {needs} bytes: it is truncated; export the model again");
            return Err(Fault::of_file(reason));
        }
        Ok(data.0)
    };
    document.buffers().map(read).collect()
}

/// The meshes of the scene with their `world_from_object` matrices, depth first. A node that is met again, as it must
/// not, is not walked again.
fn placed_meshes(document: &Document) -> Vec<(Mat4, gltf::Mesh<'_>)> {
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let roots: Vec<_> = match scene {
        Some(scene) => scene.nodes().collect(),
        None => {
            let children: HashSet<usize> =
                document.nodes().flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>()).collect();
            document.nodes().filter(|n| !children.contains(&n.index())).collect()
        }
    };
    let mut meshes = Vec::new();
    let mut met = HashSet::new();
    let mut open: Vec<_> = roots.into_iter().rev().map(|node| (Mat4::IDENTITY, node)).collect();
    while let Some((parent, node)) = open.pop() {
        if !met.insert(node.index()) {
            continue;
        }
        let matrix = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        let children: Vec<_> = node.children().map(|child| (matrix, child)).collect();
        open.extend(children.into_iter().rev());
        meshes.extend(node.mesh().map(|mesh| (matrix, mesh)));
    }
    meshes
}

/// Primitives that could not be read.
#[derive(Default)]
struct Skipped {
    points_and_lines: usize,
    damaged: usize,
}

struct ModelReader<'a> {
    buffers: &'a [Vec<u8>],
    model: Model,
    /// Triangles so far.
    faces: usize,
    skipped: Skipped,
}

impl ModelReader<'_> {
    fn add_primitive(&mut self, primitive: &Primitive, world_from_object: Mat4) {
        let mode = primitive.mode();
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            self.skipped.points_and_lines += 1;
            return;
        }
        let Some(vertices) = Vertices::read(primitive, self.buffers) else {
            self.skipped.damaged += 1;
            return;
        };
        let mesh = &mut self.model.mesh;
        let first = [mesh.positions.len(), mesh.normals.len(), mesh.uvs.len()].map(|length| length as u32);
        let has = [!vertices.normals.is_empty(), !vertices.uvs.is_empty()];
        let turned = Mat3::from_mat4(world_from_object);
        let is_mirrored = turned.determinant() < 0.0;
        let for_normals = turned.inverse().transpose();
        mesh.positions.extend(vertices.positions.iter().map(|p| world_from_object.transform_point3(*p)));
        mesh.normals.extend(vertices.normals.iter().map(|n| (for_normals * *n).normalize_or_zero()));
        mesh.uvs.extend(&vertices.uvs);
        if !vertices.colors.is_empty() {
            self.model.colors.resize(first[0] as usize, Vec3::ONE);
            self.model.colors.extend(&vertices.colors);
        }
        let corner = |i: u32| Corner {
            // Indices near the largest stand for none; `min` keeps the sum from wrapping into range.
            position: first[0].saturating_add(i),
            normal: if has[0] { first[1].saturating_add(i) } else { Corner::NONE },
            uv: if has[1] { first[2].saturating_add(i) } else { Corner::NONE },
        };
        let count = vertices.positions.len() as u32;
        let material = primitive.material().index().map_or(Model::NO_MATERIAL, |i| i as u32);
        for [a, b, c] in triangles(mode, &vertices.indices) {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            // An index beyond this primitive's vertices may lie within another's.
            let corners = [a, b, c].map(|i| corner(if i < count { i } else { u32::MAX }));
            self.model.add_face(self.faces as u32, &corners, material);
            self.faces += 1;
        }
    }

    fn finish(mut self) -> Model {
        let mut model = self.model;
        if !model.colors.is_empty() {
            model.colors.resize(model.mesh.positions.len(), Vec3::ONE);
        }
        model.set_face_count(self.faces);
        for (count, why) in [
            (
                std::mem::take(&mut self.skipped.points_and_lines),
                "of points or lines left out: they have no surface",
            ),
            (
                self.skipped.damaged,
                "left out, whose data lie outside the file's buffers or are of a wrong type",
            ),
        ] {
            if count > 0 {
                model.warn(format!("{} {why}", counted(count, "primitive")));
            }
        }
        model
    }

    /// Fills the materials, in the order of the file, and the images that they need.
    fn read_materials(&mut self, document: &Document, folder: &Path, task: &Task) -> Result<(), Fault> {
        let mut images = BTreeMap::new();
        for material in document.materials() {
            task.check()?;
            let converted = convert_material(&material, |image| {
                let next = images.len() as u32;
                *images.entry(image).or_insert(next)
            });
            self.model.materials.push(converted);
        }
        let mut ordered: Vec<_> = images.into_iter().collect();
        ordered.sort_by_key(|(_, place)| *place);
        for (index, _) in ordered {
            task.check()?;
            let image = document.images().nth(index).ok_or("it is not in the file".to_owned());
            let image = image.and_then(|image| self.read_image(&image, folder)).unwrap_or_else(|reason| {
                let reason = super::fault::one_line(&reason);
                self.model.warn(format!("texture {index} cannot be read ({reason}); shown without it"));
                texture::white()
            });
            self.model.images.push(image);
        }
        Ok(())
    }

    fn read_image(&self, image: &gltf::Image, folder: &Path) -> Result<Image, String> {
        match image.source() {
            gltf::image::Source::View { view, .. } => {
                let end = view.offset().saturating_add(view.length());
                let bytes =
                    self.buffers.get(view.buffer().index()).and_then(|data| data.get(view.offset()..end));
                texture::decode(bytes.ok_or("it lies outside the file's buffers")?, None)
            }
            // The crate decodes both embedded and named files, of the two formats that the standard allows.
            source @ gltf::image::Source::Uri { .. } => {
                let data =
                    gltf::image::Data::from_source(source, Some(folder), &[]).map_err(|e| e.to_string())?;
                from_data(&data).ok_or_else(|| format!("pixels of the kind {:?} are not read", data.format))
            }
        }
    }
}

fn from_data(data: &gltf::image::Data) -> Option<Image> {
    use gltf::image::Format;
    // How many bytes a pixel has, and where its red, green and blue (or their upper bytes) lie.
    let (stride, at) = match data.format {
        Format::R8 => (1, [0, 0, 0]),
        Format::R8G8 => (2, [0, 0, 0]),
        Format::R8G8B8 => (3, [0, 1, 2]),
        Format::R8G8B8A8 => (4, [0, 1, 2]),
        Format::R16 => (2, [1, 1, 1]),
        Format::R16G16 => (4, [1, 1, 1]),
        Format::R16G16B16 => (6, [1, 3, 5]),
        Format::R16G16B16A16 => (8, [1, 3, 5]),
        Format::R32G32B32FLOAT | Format::R32G32B32A32FLOAT => return None,
    };
    let pixels = data.pixels.chunks_exact(stride).map(|p| at.map(|i| p[i])).collect();
    Some(Image { width: data.width, height: data.height, pixels: Pixels::Srgb8(pixels) })
}

/// What a metallic-roughness material comes nearest to. `image_index` answers where an image of the file will lie.
fn convert_material(material: &gltf::Material, mut image_index: impl FnMut(usize) -> u32) -> Material {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = pbr.base_color_factor();
    let base = Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE);
    let radiance = Vec3::from_array(material.emissive_factor()).max(Vec3::ZERO);
    let radiance = radiance * material.emissive_strength().unwrap_or(1.0).max(0.0);
    let ior = material.ior().filter(|ior| *ior > 1.01 && *ior < 10.0).unwrap_or(1.5);
    let has_texture = pbr.base_color_texture().is_some();
    let is_transparent =
        material.alpha_mode() == gltf::material::AlphaMode::Blend && alpha < 0.9 && !has_texture;
    let is_transmissive = material.transmission().is_some_and(|t| t.transmission_factor() > 0.5);
    // A texture says where the factors hold, and is not looked at: better none than everywhere.
    let is_metal = pbr.metallic_roughness_texture().is_none() && pbr.metallic_factor() > 0.9;
    let kind = if radiance.max_element() > 0.0 && material.emissive_texture().is_none() {
        MaterialKind::Emissive { radiance }
    } else if is_transmissive || is_transparent {
        MaterialKind::Glass { ior, absorption: Vec3::ZERO }
    } else if is_metal && pbr.roughness_factor() < 0.2 {
        MaterialKind::Mirror
    } else {
        MaterialKind::Diffuse { reflectivity: 0.0 }
    };
    let color = match pbr.base_color_texture() {
        Some(info) => Color::Image { image: image_index(info.texture().source().index()), tint: base },
        None => Color::Solid(base),
    };
    let name =
        material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned);
    Material { name, color, kind }
}

/// What a primitive's vertices hold; empty for what they have not.
struct Vertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// v points up, as everywhere else here.
    uvs: Vec<Vec2>,
    colors: Vec<Vec3>,
    indices: Vec<u32>,
}

impl Vertices {
    /// `None` if positions or indices are missing, of a wrong type, or not in the buffers.
    fn read(primitive: &Primitive, buffers: &[Vec<u8>]) -> Option<Self> {
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let is = |semantic: &gltf::Semantic, dimensions: &[Dimensions], types: &[DataType]| {
            primitive.get(semantic).is_some_and(|a| is_usable(&a, dimensions, types))
        };
        const UNSIGNED: [DataType; 3] = [DataType::U8, DataType::U16, DataType::U32];
        const NORMALIZED: [DataType; 3] = [DataType::F32, DataType::U8, DataType::U16];
        if !is(&gltf::Semantic::Positions, &[Dimensions::Vec3], &[DataType::F32]) {
            return None;
        }
        let positions: Vec<Vec3> = reader.read_positions()?.map(Vec3::from_array).collect();
        let indices = match primitive.indices() {
            Some(a) if is_usable(&a, &[Dimensions::Scalar], &UNSIGNED) => {
                reader.read_indices()?.into_u32().collect()
            }
            Some(_) => return None,
            None => (0..positions.len() as u32).collect(),
        };
        let mut vertices =
            Self { positions, normals: Vec::new(), uvs: Vec::new(), colors: Vec::new(), indices };
        if is(&gltf::Semantic::Normals, &[Dimensions::Vec3], &[DataType::F32]) {
            vertices.normals = reader.read_normals()?.map(Vec3::from_array).collect();
        }
        let base_color = primitive.material().pbr_metallic_roughness().base_color_texture();
        let set = base_color.map_or(0, |info| info.tex_coord());
        if is(&gltf::Semantic::TexCoords(set), &[Dimensions::Vec2], &NORMALIZED) {
            let uvs = reader.read_tex_coords(set)?.into_f32();
            vertices.uvs = uvs.map(|[u, v]| Vec2::new(u, 1.0 - v)).collect();
        }
        if is(&gltf::Semantic::Colors(0), &[Dimensions::Vec3, Dimensions::Vec4], &NORMALIZED) {
            vertices.colors = reader.read_colors(0)?.into_rgb_f32().map(Vec3::from_array).collect();
        }
        let count = vertices.positions.len();
        for attribute in [&mut vertices.normals, &mut vertices.colors] {
            if attribute.len() != count {
                attribute.clear();
            }
        }
        if vertices.uvs.len() != count {
            vertices.uvs.clear();
        }
        Some(vertices)
    }
}

/// Whether the crate can read an accessor as what it should be: it asserts that, rather than say so.
fn is_usable(accessor: &gltf::Accessor, dimensions: &[Dimensions], types: &[DataType]) -> bool {
    (1..=MAX_COUNT).contains(&accessor.count())
        && dimensions.contains(&accessor.dimensions())
        && types.contains(&accessor.data_type())
}

/// The triangles of a primitive, as the standard's section 3.7.2.1 lists them.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => indices.as_chunks().0.to_vec(),
        Mode::TriangleStrip => {
            let turned =
                |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match indices {
            [first, rest @ ..] => rest.windows(2).map(|w| [w[0], w[1], *first]).collect(),
            [] => Vec::new(),
        },
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[cfg(test)]
mod tests;
