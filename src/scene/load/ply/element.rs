//! The elements of PLY files that make a mesh, filled property by property.

use glam::{Vec2, Vec3};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};

use crate::scene::material::srgb_to_linear;

pub(super) const U_NAMES: &[&str] = &["u", "s", "texture_u", "texture_s", "texcoord_u"];
const V_NAMES: &[&str] = &["v", "t", "texture_v", "texture_t", "texcoord_v"];
pub(super) const RED_NAMES: &[&str] = &["red", "r", "diffuse_red"];
const GREEN_NAMES: &[&str] = &["green", "g", "diffuse_green"];
const BLUE_NAMES: &[&str] = &["blue", "b", "diffuse_blue"];
const INDEX_NAMES: &[&str] = &["vertex_indices", "vertex_index"];

/// A vertex; what the file does not say is zero.
#[derive(Default)]
pub(super) struct VertexElement {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
    /// Linear.
    pub color: Vec3,
}

impl PropertyAccess for VertexElement {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::Ignored };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value,
            "ny" => self.normal.y = value,
            "nz" => self.normal.z = value,
            _ if U_NAMES.contains(&name) => self.uv.x = value,
            _ if V_NAMES.contains(&name) => self.uv.y = value,
            _ if RED_NAMES.contains(&name) => self.color.x = light(&property, value),
            _ if GREEN_NAMES.contains(&name) => self.color.y = light(&property, value),
            _ if BLUE_NAMES.contains(&name) => self.color.z = light(&property, value),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A colour's component as linear light: integers are encoded in sRGB, floats are not.
fn light(property: &Property, value: f32) -> f32 {
    match property {
        Property::UChar(_) => srgb_to_linear(value / 255.0),
        Property::UShort(_) => srgb_to_linear(value / 65535.0),
        _ => value,
    }
}

/// A face or a strip: vertex indices (`u32::MAX` for a negative one), and a texture coordinate a corner.
#[derive(Default)]
pub(super) struct FaceElement {
    pub indices: Vec<u32>,
    pub uvs: Vec<f32>,
}

impl PropertyAccess for FaceElement {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if INDEX_NAMES.contains(&name) {
            self.indices = indices(property);
        } else if name == "texcoord" {
            match property {
                Property::ListFloat(uvs) => self.uvs = uvs,
                Property::ListDouble(uvs) => self.uvs = uvs.into_iter().map(|c| c as f32).collect(),
                _ => return PropertyAccessResult::Ignored,
            }
        } else {
            return PropertyAccessResult::Ignored;
        }
        PropertyAccessResult::Set
    }
}

fn indices(property: Property) -> Vec<u32> {
    fn convert<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
        list.into_iter().map(|i| i.try_into().unwrap_or(u32::MAX)).collect()
    }
    match property {
        Property::ListChar(list) => convert(list),
        Property::ListUChar(list) => convert(list),
        Property::ListShort(list) => convert(list),
        Property::ListUShort(list) => convert(list),
        Property::ListInt(list) => convert(list),
        Property::ListUInt(list) => list,
        Property::ListFloat(list) => list.into_iter().map(|i| whole(f64::from(i))).collect(),
        Property::ListDouble(list) => list.into_iter().map(whole).collect(),
        _ => Vec::new(),
    }
}

/// A number that should be an index.
fn whole(number: f64) -> u32 {
    if number >= 0.0 && number < f64::from(u32::MAX) { number as u32 } else { u32::MAX }
}

/// An element of which nothing is kept.
pub(super) struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// An element from a line of text; `None` if a number is missing or is none.
pub(super) fn from_text<E: PropertyAccess>(line: &[u8], definition: &ElementDef) -> Option<E> {
    let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace();
    let mut number = || words.next()?.parse::<f64>().ok();
    let mut element = E::new();
    for (name, property) in &definition.properties {
        let value = match &property.data_type {
            PropertyType::Scalar(ScalarType::UChar) => Property::UChar(number()? as u8),
            PropertyType::Scalar(ScalarType::UShort) => Property::UShort(number()? as u16),
            PropertyType::Scalar(_) => Property::Double(number()?),
            PropertyType::List(..) => {
                let count = whole(number()?);
                // Collecting stops where the line does, whatever the count claims.
                Property::ListDouble((0..count).map(|_| number()).collect::<Option<_>>()?)
            }
        };
        element.set_property(name, value);
    }
    Some(element)
}
