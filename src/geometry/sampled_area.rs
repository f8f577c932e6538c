//! The area of a curved shape inside a box, estimated on a fixed set of points.

use glam::{DVec3, Vec3};

use super::Aabb;

/// How many points of the surface are looked at; the error is about a hundredth of the shape's area.
const POINTS: usize = 1024;

/// The share of a surface inside `clip`, times `area`. `point` maps the unit square to the surface and gives the
/// density of area there, in any unit. A box that holds all of `bounds` or nothing of it is answered exactly.
pub fn sampled_area_inside(
    bounds: &Aabb,
    area: f32,
    clip: &Aabb,
    point: impl Fn(f64, f64) -> (DVec3, f64),
) -> f32 {
    if clip.contains(bounds) {
        return area;
    }
    if clip.intersection(*bounds).is_empty() {
        return 0.0;
    }
    let (mut inside, mut all) = (0.0, 0.0);
    for (u, v) in lattice(POINTS) {
        let (position, weight) = point(u, v);
        all += weight;
        let position: Vec3 = position.as_vec3();
        if clip.contains_point(position) {
            inside += weight;
        }
    }
    if all > 0.0 { (f64::from(area) * inside / all) as f32 } else { 0.0 }
}

/// Points that lie evenly in the unit square: steps of the golden ratio against equal steps.
fn lattice(count: usize) -> impl Iterator<Item = (f64, f64)> {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    (0..count).map(move |i| {
        let i = i as f64;
        ((i + 0.5) / count as f64, (0.5 + i * INVERSE_GOLDEN_RATIO).fract())
    })
}
