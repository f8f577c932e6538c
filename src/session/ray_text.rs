//! The text of a ray: origin, direction, and perhaps where it begins and ends.

use glam::Vec3;

use super::values::{float_text, read_float};
use crate::geometry::Ray;

/// Reads `ox,oy,oz,dx,dy,dz`, perhaps with `,t_min,t_max`; commas or spaces between the numbers.
///
/// # Errors
/// A sentence that says what is wrong, or what is allowed.
pub fn read_ray(text: &str) -> Result<Ray, String> {
    let parts: Vec<&str> =
        text.split(|c: char| c == ',' || c.is_whitespace()).filter(|part| !part.is_empty()).collect();
    if parts.len() != 6 && parts.len() != 8 {
        return Err(format!(
            "a ray is ox,oy,oz,dx,dy,dz, or that with t_min,t_max: 6 or 8 numbers, here are {}",
            parts.len()
        ));
    }
    let number = |i: usize| {
        read_float(parts[i], f32::MIN..=f32::MAX).map_err(|_| format!("'{}' is no finite number", parts[i]))
    };
    let origin = Vec3::new(number(0)?, number(1)?, number(2)?);
    let direction = Vec3::new(number(3)?, number(4)?, number(5)?);
    if direction == Vec3::ZERO {
        return Err("the direction 0,0,0 leads nowhere".to_owned());
    }
    let mut ray = Ray::new(origin, direction);
    if parts.len() == 8 {
        ray.t_min = number(6)?;
        ray.t_max = if parts[7] == "inf" { f32::INFINITY } else { number(7)? };
        if ray.t_min < 0.0 || ray.t_max < ray.t_min {
            return Err("t_min must be at least 0, and t_max at least t_min".to_owned());
        }
    }
    Ok(ray)
}

/// The text that [`read_ray`] reads back exactly.
pub fn ray_text(ray: &Ray) -> String {
    let (o, d) = (ray.origin, ray.direction);
    let mut numbers: Vec<String> = [o.x, o.y, o.z, d.x, d.y, d.z].map(float_text).into();
    if ray.t_min != 0.0 || ray.t_max != f32::INFINITY {
        let end = if ray.t_max.is_finite() { float_text(ray.t_max) } else { "inf".to_owned() };
        numbers.extend([float_text(ray.t_min), end]);
    }
    numbers.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_read_back_exactly() {
        let ray = Ray { t_min: 0.125, t_max: 7.3, ..Ray::new(Vec3::new(0.1, -2e-9, 3.0), Vec3::X) };
        for ray in [ray, Ray { t_max: f32::INFINITY, ..ray }, Ray::new(Vec3::ONE, Vec3::NEG_Y)] {
            assert_eq!(read_ray(&ray_text(&ray)), Ok(ray));
        }
        assert_eq!(read_ray("0 0 0  1, 0 ,0"), Ok(Ray::new(Vec3::ZERO, Vec3::X)));
    }

    #[test]
    fn what_is_no_ray_is_refused_in_words() {
        for (text, says) in [
            ("", "6 or 8 numbers"),
            ("1,2,3", "here are 3"),
            ("0,0,0,0,0,0", "leads nowhere"),
            ("0,0,0,1,0,x", "'x'"),
            ("0,0,0,1,0,nan", "'nan'"),
            ("0,0,0,1,0,0,5,2", "t_max"),
            ("0,0,0,1,0,0,-1,2", "t_min"),
        ] {
            let error = read_ray(text).expect_err(text);
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
