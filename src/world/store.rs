//! The leaves' geometry in leaf order: blocks of triangles as structure of arrays, one array for each other shape.

/// Plain data, owned, that can be copied to a graphics card.
#[derive(Clone, Debug, Default)]
pub struct PrimStore {}
