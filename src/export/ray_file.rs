//! Files of rays and of their answers, for exchange with other programs: little-endian, a count in front.
//!
//! Rays: u32 count, then a ray each of eight f32 (origin x y z, t_min, direction x y z, t_max). Answers: u32 count, then
//! an f32 each (the hit's t, infinity for a miss; for `occluded` 1 or 0).

use std::path::Path;

use glam::Vec3;

use super::{ExportError, atomic};
use crate::geometry::Ray;

const RAY_BYTES: usize = 32;
const ANSWER_BYTES: usize = 4;
/// Largest share of itself by which an answer may differ.
const TOLERANCE: f32 = 1e-3;

/// Reads a file of rays.
///
/// # Errors
/// [`ExportError::Read`]: the file cannot be read, its length does not fit its count, or a ray cannot be traced.
pub fn read_rays(path: &Path) -> Result<Vec<Ray>, ExportError> {
    let bytes = read(path)?;
    let records = records::<RAY_BYTES>(&bytes, "rays").map_err(|reason| fail(path, reason))?;
    let rays = records.enumerate().map(|(i, record)| {
        let number =
            |k: usize| f32::from_le_bytes(record[4 * k..4 * k + 4].try_into().expect("four bytes of 32"));
        let vector = |k: usize| Vec3::new(number(k), number(k + 1), number(k + 2));
        let ray = Ray { origin: vector(0), t_min: number(3), direction: vector(4), t_max: number(7) };
        match ray_fault(&ray) {
            None => Ok(ray),
            Some(fault) => Err(fail(path, format!("ray {i} (counted from 0) {fault}"))),
        }
    });
    rays.collect()
}

/// Writes a file of rays.
///
/// # Errors
/// [`ExportError::Write`]
pub fn write_rays(path: &Path, rays: &[Ray]) -> Result<(), ExportError> {
    let numbers = rays.iter().flat_map(|ray| {
        let (o, d) = (ray.origin, ray.direction);
        [o.x, o.y, o.z, ray.t_min, d.x, d.y, d.z, ray.t_max]
    });
    atomic::write_bytes(path, &encode(rays.len(), numbers))
}

/// Reads a file of answers.
///
/// # Errors
/// [`ExportError::Read`]
pub fn read_answers(path: &Path) -> Result<Vec<f32>, ExportError> {
    let bytes = read(path)?;
    let records = records::<ANSWER_BYTES>(&bytes, "answers").map_err(|reason| fail(path, reason))?;
    Ok(records.map(f32::from_le_bytes).collect())
}

/// Writes a file of answers.
///
/// # Errors
/// [`ExportError::Write`]
pub fn write_answers(path: &Path, answers: &[f32]) -> Result<(), ExportError> {
    atomic::write_bytes(path, &encode(answers.len(), answers.iter().copied()))
}

/// How many answers differ: a hit against a miss, or t off by more than a thousandth of itself.
pub fn mismatches(answers: &[f32], expected: &[f32]) -> usize {
    let differs = |(answer, expected): (&f32, &f32)| {
        if answer.is_finite() && expected.is_finite() {
            (answer - expected).abs() > TOLERANCE * expected.abs()
        } else {
            answer.is_finite() != expected.is_finite()
        }
    };
    answers.iter().zip(expected).filter(|pair| differs(*pair)).count()
}

fn ray_fault(ray: &Ray) -> Option<&'static str> {
    if !(ray.origin.is_finite() && ray.direction.is_finite()) {
        Some("has an origin or a direction that is no number")
    } else if ray.direction == Vec3::ZERO {
        Some("has no direction")
    } else if ray.t_min.is_nan() || ray.t_max.is_nan() {
        Some("has a t_min or a t_max that is no number")
    } else {
        None
    }
}

fn read(path: &Path) -> Result<Vec<u8>, ExportError> {
    std::fs::read(path).map_err(|error| {
        let reason = match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
            _ => error.to_string(),
        };
        fail(path, reason)
    })
}

fn fail(path: &Path, reason: String) -> ExportError {
    ExportError::Read { path: path.to_owned(), reason }
}

/// The records behind the count, whose number must be the count's.
fn records<'a, const SIZE: usize>(
    bytes: &'a [u8],
    what: &str,
) -> Result<impl Iterator<Item = [u8; SIZE]> + use<'a, SIZE>, String> {
    let Some((count, body)) = bytes.split_first_chunk::<4>() else {
        return Err(format!("it is too short for a file of {what}: {} bytes", bytes.len()));
    };
    let count = u32::from_le_bytes(*count) as usize;
    if body.len() != count * SIZE {
        return Err(format!(
            "it says that it holds {count} {what}, which take {} bytes, but {} follow",
            count * SIZE,
            body.len()
        ));
    }
    Ok(body.chunks_exact(SIZE).map(|chunk| chunk.try_into().expect("exact chunks")))
}

fn encode(count: usize, numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    let count = u32::try_from(count).expect("no more rays than a u32 counts");
    let mut bytes = count.to_le_bytes().to_vec();
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(direction: Vec3) -> Ray {
        Ray { origin: Vec3::new(1.0, -2.0, 3.5), direction, t_min: 0.25, t_max: f32::INFINITY }
    }

    #[test]
    fn rays_and_answers_come_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rays.bin");
        let rays = [ray(Vec3::X), ray(Vec3::new(0.1, 0.2, -3.0))];
        write_rays(&path, &rays).expect("written");
        assert_eq!(std::fs::metadata(&path).expect("a file").len(), 4 + 2 * 32);
        assert_eq!(read_rays(&path).expect("rays"), rays);
        let answers = [1.5, f32::INFINITY, 0.0];
        write_answers(&path, &answers).expect("written");
        assert_eq!(read_answers(&path).expect("answers"), answers);
    }

    #[test]
    fn broken_files_are_refused_with_what_is_wrong() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rays.bin");
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            read_rays(&path).expect_err("refused").to_string()
        };
        assert!(message(b"").contains("too short"));
        assert!(message(&[1, 0, 0, 0, 9]).contains("holds 1 rays, which take 32 bytes, but 1 follow"));
        assert!(message(&[255; 40]).contains("but 36 follow"));
        for (bad, expected) in [
            (ray(Vec3::ZERO), "ray 1 (counted from 0) has no direction"),
            (ray(Vec3::NAN), "no number"),
            (Ray { t_min: f32::NAN, ..ray(Vec3::X) }, "t_min"),
        ] {
            write_rays(&path, &[ray(Vec3::X), bad]).expect("written");
            let message = read_rays(&path).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message}");
        }
        let missing = read_answers(&folder.path().join("none")).expect_err("missing").to_string();
        assert!(missing.ends_with("there is no such file"), "{missing}");
    }

    #[test]
    fn a_thousandth_is_no_mismatch_and_a_miss_against_a_hit_is_one() {
        let inf = f32::INFINITY;
        assert_eq!(mismatches(&[1.0, 2.0, inf, 0.0], &[1.0005, 2.0, inf, 0.0]), 0);
        assert_eq!(mismatches(&[1.0, inf, 2.0, 1.0], &[1.01, 2.0, inf, 0.0]), 4);
        assert_eq!(mismatches(&[f32::NAN], &[1.0]), 1);
    }
}
