//! From double to single precision: rounded outwards for boxes, and with a bound of the error for points.
//!
//! Shapes compute in double precision, so what is lost is the last rounding and a little that their own magnitudes
//! leave behind.

use glam::{DVec3, Vec3};

use super::Aabb;

/// What a dozen operations in double precision lose at most, relative to the largest value in them.
const DOUBLE_LOSS: f64 = 1.0 / (1u64 << 47) as f64;

/// The largest `f32` that is not above `x`.
#[inline]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest `f32` that is not below `x`.
#[inline]
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The smallest box in single precision around the one from `min` to `max`.
#[inline]
pub fn outward_box(min: DVec3, max: DVec3) -> Aabb {
    Aabb {
        min: Vec3::new(round_down(min.x), round_down(min.y), round_down(min.z)),
        max: Vec3::new(round_up(max.x), round_up(max.y), round_up(max.z)),
    }
}

/// A point in single precision with a bound of the error of each component. `magnitude` is the largest length that
/// went into the point: distances, radii, coordinates.
#[inline]
pub fn rounded_point(point: DVec3, magnitude: f64) -> (Vec3, Vec3) {
    let position = point.as_vec3();
    // Half a unit in the last place is at most 2^-24 of the value. Rounded up without a branch, which nobody could guess: by
    // more than rounding may have taken away, also below the normal numbers.
    let bound = |x: f64| {
        let exact = x.abs() * (1.0 / (1 << 24) as f64) + magnitude * DOUBLE_LOSS;
        exact as f32 * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE
    };
    (position, Vec3::new(bound(point.x), bound(point.y), bound(point.z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_outwards_brackets_and_keeps_what_is_exact() {
        for x in [0.1, -0.1, 1.0, 1e-50, -1e-50, 1e300, -1e300, 16_777_217.0] {
            assert!(f64::from(round_down(x)) <= x && x <= f64::from(round_up(x)), "{x}");
        }
        assert_eq!((round_down(0.25), round_up(0.25)), (0.25, 0.25));
        assert_eq!((round_down(1e300), round_up(-1e300)), (f32::MAX, f32::MIN));
    }

    #[test]
    fn the_error_bound_covers_the_rounding() {
        for i in 1..1000 {
            let p = DVec3::new(0.1, -1.0 / 3.0, 1e-30) * f64::from(i).powi(3);
            let (position, error) = rounded_point(p, 0.0);
            assert!((position.as_dvec3() - p).abs().cmple(error.as_dvec3()).all());
        }
    }
}
