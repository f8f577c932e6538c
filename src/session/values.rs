//! How single values stand in text: numbers that read back exactly, ranges, sizes, cameras, and names of closed sets.
//!
//! Every reader answers with the reason alone; the flag that asked puts its name and the given text before it.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use glam::Vec3;

use crate::accel::simd::SimdLevel;
use crate::accel::{Block, Builder, Improver, Layout, Morton, StopRule, Update, Widen, Width};
use crate::render::{BoxStyle, ColorMap, ColorScale, CountKind, ToneMap, View};
use crate::scene::load::TreeFormat;
use crate::scene::{Camera, ShadowRule, UpAxis};
use crate::world::NodeFigure;

/// Longest picture side in pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Fields of view that a pinhole camera can show, in degrees.
pub const FOV: RangeInclusive<f32> = 0.1..=179.0;

/// One of a closed set, as help and `bvhscope list` show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    pub name: &'static str,
    /// One line; empty where the name says it all.
    pub description: &'static str,
}

/// A closed set of named values that a flag can choose from.
pub trait Named: Copy + 'static {
    fn all() -> &'static [Self];
    fn choice(self) -> Choice;
}

macro_rules! named {
    ($($kind:ty: $description:expr;)*) => {$(
        impl Named for $kind {
            fn all() -> &'static [Self] {
                &Self::ALL
            }
            fn choice(self) -> Choice {
                let describe: fn(Self) -> &'static str = $description;
                Choice { name: self.name(), description: describe(self) }
            }
        }
    )*};
}

named! {
    Builder: Self::description;
    Width: |_| "";
    Layout: Self::description;
    Block: Self::description;
    Improver: Self::description;
    Update: Self::description;
    Morton: Self::description;
    Widen: Self::description;
    SimdLevel: Self::description;
    StopRule: Self::description;
    View: Self::description;
    CountKind: Self::description;
    ShadowRule: Self::description;
    ColorMap: Self::description;
    ColorScale: Self::description;
    ToneMap: Self::description;
    BoxStyle: Self::description;
    NodeFigure: Self::description;
    UpAxis: |_| "";
}

/// The choices of a closed set, in order.
pub fn choices<T: Named>() -> Vec<Choice> {
    T::all().iter().map(|value| value.choice()).collect()
}

/// The choices of a setting that is no closed set.
pub fn no_choices() -> Vec<Choice> {
    Vec::new()
}

/// The value of that name.
pub fn read_named<T: Named>(text: &str) -> Result<T, String> {
    let found = T::all().iter().copied().find(|value| value.choice().name == text);
    found.ok_or_else(|| {
        let names: Vec<_> = choices::<T>().iter().map(|choice| choice.name).collect();
        format!("choose one of {}", names.join(", "))
    })
}

/// A whole number in a range.
pub fn read_int<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    match text.trim().parse::<T>() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(format!("allowed is a whole number from {} to {}", range.start(), range.end())),
    }
}

/// A finite number in a range.
pub fn read_float(text: &str, range: RangeInclusive<f32>) -> Result<f32, String> {
    let allowed = || {
        if range == (f32::MIN..=f32::MAX) {
            "allowed is any finite number".to_owned()
        } else {
            let (start, end) = (float_text(*range.start()), float_text(*range.end()));
            format!("allowed is a number from {start} to {end}")
        }
    };
    match text.trim().parse::<f32>() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(allowed()),
    }
}

/// The shortest text that reads back as the same number.
pub fn float_text(value: f32) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

/// `on` or `off`.
pub fn read_switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("allowed is on or off".to_owned()),
    }
}

pub fn switch_text(on: bool) -> String {
    if on { "on" } else { "off" }.to_owned()
}

/// `word` for `None`, else what `read` reads.
pub fn read_optional<T>(
    text: &str,
    word: &str,
    read: impl FnOnce(&str) -> Result<T, String>,
) -> Result<Option<T>, String> {
    if text.trim() == word {
        return Ok(None);
    }
    read(text).map(Some).map_err(|reason| format!("{reason}, or {word}"))
}

pub fn optional_text<T>(value: Option<T>, word: &str, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| word.to_owned(), text)
}

/// The path of a tree's file.
pub fn read_tree(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    TreeFormat::of(&path).map(|_| path).ok_or_else(|| "allowed is a file .npz or .json".to_owned())
}

/// `WIDTHxHEIGHT` in pixels.
pub fn read_size(text: &str) -> Result<[u32; 2], String> {
    let side = |part: &str| read_int(part, 1..=MAX_SIDE).ok();
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("allowed is WIDTHxHEIGHT, each from 1 to {MAX_SIDE} pixels, as in 1280x720"))
}

/// `LO..HI` with `LO <= HI`, both finite. (A range without extent cuts values in two.)
pub fn read_span(text: &str) -> Result<[f32; 2], String> {
    let end = |part: &str| read_float(part, f32::MIN..=f32::MAX).ok();
    text.split_once("..")
        .and_then(|(low, high)| Some([end(low)?, end(high)?]))
        .filter(|[low, high]| low <= high)
        .ok_or_else(|| "allowed is LO..HI with LO not above HI, as in 0..40".to_owned())
}

pub fn span_text([low, high]: [f32; 2]) -> String {
    format!("{}..{}", float_text(low), float_text(high))
}

/// `MIN..MAX`, one depth alone, or `all`.
pub fn read_depths(text: &str, deepest: u32) -> Result<[u32; 2], String> {
    if text.trim() == "all" {
        return Ok([0, deepest]);
    }
    let end = |part: &str| read_int(part, 0..=deepest).ok();
    let span = match text.split_once("..") {
        Some((low, high)) => end(low).zip(end(high)),
        None => end(text).map(|depth| (depth, depth)),
    };
    span.filter(|(low, high)| low <= high)
        .map(|(low, high)| [low, high])
        .ok_or_else(|| format!("allowed is MIN..MAX with depths from 0 to {deepest}, one depth, all"))
}

/// `ex,ey,ez,tx,ty,tz,fov`: eye, target, vertical field of view in degrees.
pub fn read_camera(text: &str, up: UpAxis) -> Result<Camera, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let coordinate = |i: usize| {
        read_float(parts[i], f32::MIN..=f32::MAX).map_err(|_| format!("'{}' is no finite number", parts[i]))
    };
    if parts.len() != 7 {
        return Err(
            "allowed is ex,ey,ez,tx,ty,tz,fov: where the eye is, what it looks at, and the vertical field of \
             view in degrees"
                .to_owned(),
        );
    }
    let camera = Camera {
        eye: Vec3::new(coordinate(0)?, coordinate(1)?, coordinate(2)?),
        target: Vec3::new(coordinate(3)?, coordinate(4)?, coordinate(5)?),
        fov_y_degrees: read_float(parts[6], FOV).map_err(|reason| format!("field of view: {reason}"))?,
        up,
    };
    let distance = camera.eye.distance(camera.target);
    if !(distance > 0.0 && distance.is_finite()) {
        return Err("eye and target must be two points, not the same and not endlessly far apart".to_owned());
    }
    Ok(camera)
}

pub fn camera_text(camera: Camera) -> String {
    let (e, t) = (camera.eye, camera.target);
    [e.x, e.y, e.z, t.x, t.y, t.z, camera.fov_y_degrees].map(float_text).join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_read_back_exactly() {
        let mut bits = 1u32;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let value = f32::from_bits(bits);
            if value.is_finite() {
                assert_eq!(float_text(value).parse::<f32>().map(f32::to_bits), Ok(bits));
            }
        }
        assert_eq!(float_text(0.1), "0.1");
        assert_eq!(float_text(1e-20), "1e-20");
    }

    #[test]
    fn a_refusal_says_what_is_allowed() {
        assert_eq!(read_int("300", 2..=256).unwrap_err(), "allowed is a whole number from 2 to 256");
        assert_eq!(read_int("8.5", 2..=256).unwrap_err(), "allowed is a whole number from 2 to 256");
        assert_eq!(read_float("NaN", 0.0..=1.0).unwrap_err(), "allowed is a number from 0 to 1");
        assert_eq!(
            read_named::<Builder>("best").unwrap_err(),
            "choose one of median, sweep, binned, spatial, lbvh, ploc, midpoint, random"
        );
        assert!(read_size("0x720").unwrap_err().contains("1280x720"));
        assert!(read_span("5..4.9").unwrap_err().contains("LO not above HI"));
        assert_eq!(read_span("5..5"), Ok([5.0, 5.0]));
        assert!(read_span("0..inf").is_err());
    }

    #[test]
    fn depths_are_a_range_one_depth_or_all() {
        assert_eq!(read_depths("2..5", 64), Ok([2, 5]));
        assert_eq!(read_depths("3", 64), Ok([3, 3]));
        assert_eq!(read_depths("all", 64), Ok([0, 64]));
        assert!(read_depths("5..2", 64).is_err());
        assert!(read_depths("0..65", 64).is_err());
    }

    #[test]
    fn a_camera_needs_two_points_and_a_field_of_view() {
        let camera = read_camera("-1, 2,3,0,0,0,45", UpAxis::Z).expect("a camera");
        assert_eq!((camera.eye, camera.up), (Vec3::new(-1.0, 2.0, 3.0), UpAxis::Z));
        for bad in ["1,2,3", "1,2,3,1,2,3,45", "1,2,3,0,0,0,180", "1,2,3,0,0,nan,45", ""] {
            assert!(read_camera(bad, UpAxis::Y).is_err(), "{bad}");
        }
    }
}
