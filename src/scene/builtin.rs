//! The scenes that the program carries.

use super::Scene;
use super::load::LoadError;

/// Names with a line on each, as `bvhscope list scenes` prints them.
pub const SCENES: [(&str, &str); 7] = [
    (
        "bunny",
        "the default: a bunny of 4,968 triangles in a room of quads, with a glass cuboid and a mirror sphere",
    ),
    ("room", "the classic teaching room: six planes, a mirror ball, a glass cube, a swinging light"),
    ("cornell", "the Cornell box"),
    ("spheres", "thousands of random spheres"),
    ("soup", "random triangles; soup:1000000 sets how many"),
    ("teapot", "the Utah teapot"),
    ("sliver", "long thin diagonal triangles, the classic enemy of box trees"),
];

/// Whether `text` names a built-in scene, with or without a parameter.
pub fn is_name(text: &str) -> bool {
    let name = text.split(':').next().unwrap_or(text);
    SCENES.iter().any(|(n, _)| *n == name)
}

/// Makes a built-in scene at t = 0.
///
/// # Errors
/// For an unknown name, or a parameter that is not a number in range.
pub fn make(name: &str) -> Result<Scene, LoadError> {
    let _ = name;
    todo!()
}
