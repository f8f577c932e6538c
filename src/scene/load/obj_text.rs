//! Prepares the text of an OBJ file for `tobj`, which fails on one bad line without saying which, and misreads others.
//!
//! Every line is looked at once. A line that no reader could make sense of is a fault with its number. What can be
//! repaired is: faces that point outside, lines and points (`tobj` takes them for faces), continued lines, comments behind
//! numbers, vertex colours on only some vertices. A file without any of that is passed on as it is.
//!
//! `tobj` mixes up the corners of an object in which only some have normals or texture coordinates; so an object ends
//! here where that changes.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::fault::{Fault, counted, excerpt};
use crate::task::Task;

/// Lines between two looks at the task.
const CHECK_EVERY: usize = 4096;

/// A text that `tobj` reads as its author meant it.
pub(super) struct ObjText<'a> {
    pub text: Cow<'a, str>,
    /// The file's index of each face in `text`; `None` where it is the same.
    pub kept_faces: Option<Vec<u32>>,
    pub face_count: usize,
    pub vertex_count: usize,
    /// Faces left out for having less than three. (Those left out for pointing outside are in the warnings.)
    pub too_few_corners: usize,
    pub used_materials: BTreeSet<String>,
    pub warnings: Vec<String>,
}

/// Looks at every line of an OBJ file.
pub(super) fn prepare<'a>(bytes: &'a [u8], task: &Task) -> Result<ObjText<'a>, Fault> {
    if let Some(byte) = bytes.iter().position(|b| *b == 0) {
        return Err(Fault::at_byte(byte, "there is binary data here: this is no OBJ file, or a damaged one"));
    }
    let mut text = String::from_utf8_lossy(bytes);
    let mut warnings = Vec::new();
    if matches!(text, Cow::Owned(_)) {
        warnings.push("the file is not UTF-8; letters that could not be read were replaced".to_owned());
    }
    if !text.contains('\n') && text.contains('\r') {
        text = Cow::Owned(text.replace('\r', "\n"));
    }
    let mut scan = Scan::new(&text);
    let mut rest: &str = &text;
    while !rest.is_empty() {
        if scan.line.is_multiple_of(CHECK_EVERY) {
            task.check()?;
        }
        let end = rest.find('\n').map_or(rest.len(), |i| i + 1);
        let (line, after) = rest.split_at(end);
        rest = after;
        scan.line += 1;
        if line.trim_end().ends_with('\\') {
            rest = scan.continued_line(line, rest)?;
        } else {
            scan.line(line, line)?;
        }
    }
    warnings.append(&mut scan.warnings());
    let (cleaned, kept_faces) = (scan.cleaned, scan.kept_faces);
    Ok(ObjText {
        kept_faces: (scan.outside + scan.too_few_corners > 0).then_some(kept_faces),
        face_count: scan.face_count,
        vertex_count: scan.counts[0],
        too_few_corners: scan.too_few_corners,
        used_materials: scan.used_materials,
        text: cleaned.map_or(text, Cow::Owned),
        warnings,
    })
}

/// What a face's corners have besides a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Attributes {
    uv: bool,
    normal: bool,
}

/// The state of going through a text.
struct Scan<'t> {
    text: &'t str,
    /// How much of `text` was looked at; what `cleaned` replaces once a line had to be changed.
    looked_at: usize,
    cleaned: Option<String>,
    /// The number of the current line, from 1.
    line: usize,
    /// Positions, texture coordinates and normals so far.
    counts: [usize; 3],
    attributes: Option<Attributes>,
    /// Whether the first vertex has a colour: then all get one, else none.
    colored: Option<bool>,
    colors_changed: bool,
    kept_faces: Vec<u32>,
    face_count: usize,
    outside: usize,
    first_outside: usize,
    too_few_corners: usize,
    attributes_outside: usize,
    lines_and_points: usize,
    used_materials: BTreeSet<String>,
}

impl<'t> Scan<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text,
            looked_at: 0,
            cleaned: None,
            line: 0,
            counts: [0; 3],
            attributes: None,
            colored: None,
            colors_changed: false,
            kept_faces: Vec::new(),
            face_count: 0,
            outside: 0,
            first_outside: 0,
            too_few_corners: 0,
            attributes_outside: 0,
            lines_and_points: 0,
            used_materials: BTreeSet::new(),
        }
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let mut warn = |count: usize, text: String| {
            if count > 0 {
                warnings.push(text);
            }
        };
        warn(
            self.outside,
            format!(
                "{} left out, pointing to a vertex that the file does not have before it (the first in line {})",
                counted(self.outside, "face"),
                self.first_outside
            ),
        );
        let bad = counted(self.attributes_outside, "face");
        warn(
            self.attributes_outside,
            format!("{bad} with a bad index of a normal or texture coordinate shown without"),
        );
        let mixed = "only some vertices have a colour; the others are shown white, or all without".to_owned();
        warn(usize::from(self.colors_changed), mixed);
        let lines = counted(self.lines_and_points, "line or point element");
        warn(self.lines_and_points, format!("{lines} left out: they have no surface"));
        warnings
    }

    /// Joins the line with those that continue it; answers what follows.
    fn continued_line(&mut self, first: &str, mut rest: &'t str) -> Result<&'t str, Fault> {
        let mut joined = String::new();
        let mut length = first.len();
        let mut part = first;
        let first_number = self.line;
        loop {
            let content = part.trim_end();
            let Some(content) = content.strip_suffix('\\') else {
                joined.push_str(content);
                break;
            };
            joined.push_str(content);
            joined.push(' ');
            if rest.is_empty() {
                break;
            }
            let end = rest.find('\n').map_or(rest.len(), |i| i + 1);
            (part, rest) = rest.split_at(end);
            length += part.len();
            self.line += 1;
        }
        joined.push('\n');
        let last_number = std::mem::replace(&mut self.line, first_number);
        let original = &self.text[self.looked_at..self.looked_at + length];
        self.line(original, &joined)?;
        self.line = last_number;
        Ok(rest)
    }

    /// Takes a logical line: `original` as it is in the text, `line` as it reads.
    fn line(&mut self, original: &str, line: &str) -> Result<(), Fault> {
        let mut words = line.split_whitespace();
        let keyword = words.next().unwrap_or_default();
        let replaced = match keyword {
            "v" => self.vertex(words).ok_or(3),
            "vt" => self.texture_coordinate(words).ok_or(1),
            "vn" => self.normal(words).ok_or(3),
            "f" | "fo" => Ok(self.face(line, keyword)?),
            "l" | "p" => {
                self.lines_and_points += 1;
                Ok(Some(String::new()))
            }
            "usemtl" => Ok(self.use_material(line)),
            // `tobj` looks for the name behind the first space of the line.
            "mtllib" if !line.starts_with("mtllib ") => {
                Ok(Some(format!("mtllib {}\n", line.trim_start()[keyword.len()..].trim())))
            }
            _ => Ok(None),
        };
        let replaced = replaced.map_err(|count| {
            let what = format!("'{}' does not hold {}", excerpt(line), counted(count, "number"));
            Fault::at_line(self.line, format!("{what}; correct the line, or export the model again"))
        })?;
        // A joined line is passed on joined.
        match replaced.or_else(|| (!std::ptr::eq(original, line)).then(|| line.to_owned())) {
            Some(new) if new != original => {
                let text = self.text;
                let looked_at = self.looked_at;
                self.cleaned.get_or_insert_with(|| text[..looked_at].to_owned()).push_str(&new);
            }
            _ => {
                if let Some(cleaned) = &mut self.cleaned {
                    cleaned.push_str(original);
                }
            }
        }
        self.looked_at += original.len();
        Ok(())
    }

    /// `v x y z`, `v x y z w` or `v x y z r g b`. The outer `None` is a bad line, the inner one stands as it is.
    fn vertex<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Option<Option<String>> {
        let (numbers, had_comment) = numbers::<7>(words)?;
        self.counts[0] += 1;
        let colored = *self.colored.get_or_insert(numbers.len() == 6);
        let plain = match (numbers.as_slice(), colored) {
            ([_, _, _], false) | ([_, _, _, _, _, _], true) => !had_comment,
            // The fourth is a weight that polygons have no use for unless it scales.
            ([_, _, _, w], false) => !had_comment && *w != 0.0,
            _ => false,
        };
        if plain {
            return Some(None);
        }
        let [x, y, z, ..] = numbers[..] else { return None };
        let color = match (numbers.as_slice(), colored) {
            ([_, _, _, r, g, b], true) => format!(" {r} {g} {b}"),
            (_, true) => " 1 1 1".to_owned(),
            (_, false) => String::new(),
        };
        self.colors_changed |= colored != (numbers.len() == 6);
        Some(Some(format!("v {x} {y} {z}{color}\n")))
    }

    fn texture_coordinate<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Option<Option<String>> {
        let (numbers, _) = numbers::<3>(words)?;
        self.counts[1] += 1;
        match numbers[..] {
            [] => None,
            [u] => Some(Some(format!("vt {u} 0\n"))),
            [..] => Some(None),
        }
    }

    fn normal<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Option<Option<String>> {
        let (numbers, _) = numbers::<3>(words)?;
        self.counts[2] += 1;
        (numbers.len() == 3).then_some(None)
    }

    /// The face's line if it must change: empty to leave it out, or with an end of the object before it.
    fn face(&mut self, line: &str, keyword: &str) -> Result<Option<String>, Fault> {
        let face = self.face_count as u32;
        self.face_count += 1;
        let (mut corners, mut rewrite) = (0, keyword != "f");
        let (mut is_outside, mut bad_attribute) = (false, false);
        let mut seen: Option<Attributes> = None;
        let mut all = Attributes { uv: true, normal: true };
        for word in line.split_whitespace().skip(1) {
            if word.starts_with('#') {
                rewrite = true;
                break;
            }
            let [position, uv, normal] = corner(word).ok_or_else(|| {
                let what = format!("'{}' is no corner of a face", excerpt(word));
                Fault::at_line(self.line, format!("{what}; correct the line, or export the model again"))
            })?;
            corners += 1;
            is_outside |= position.is_none_or(|i| !is_inside(i, self.counts[0]));
            let here = Attributes { uv: uv.is_some(), normal: normal.is_some() };
            let uv_inside = uv.is_none_or(|i| is_inside(i, self.counts[1]));
            let normal_inside = normal.is_none_or(|i| is_inside(i, self.counts[2]));
            bad_attribute |= !uv_inside || !normal_inside;
            rewrite |= bad_attribute || seen.is_some_and(|s| s != here);
            all.uv &= here.uv && uv_inside;
            all.normal &= here.normal && normal_inside;
            seen = Some(here);
        }
        if corners < 3 || is_outside {
            if corners < 3 {
                self.too_few_corners += 1;
            } else {
                self.first_outside = if self.outside == 0 { self.line } else { self.first_outside };
                self.outside += 1;
            }
            return Ok(Some(String::new()));
        }
        self.attributes_outside += usize::from(bad_attribute);
        self.kept_faces.push(face);
        let object_ends = self.attributes.is_some_and(|before| before != all);
        self.attributes = Some(all);
        if !rewrite && !object_ends {
            return Ok(None);
        }
        let object = if object_ends { "o\n" } else { "" };
        Ok(Some(format!("{object}{}", if rewrite { face_line(line, all) } else { line.to_owned() })))
    }

    fn use_material(&mut self, line: &str) -> Option<String> {
        let name = line.trim_start()["usemtl".len()..].trim();
        if name.is_empty() {
            return Some(String::new());
        }
        if !self.used_materials.contains(name) {
            self.used_materials.insert(name.to_owned());
        }
        (!line.starts_with("usemtl ")).then(|| format!("usemtl {name}\n"))
    }
}

/// A face's line with only those attributes that all of its corners have.
fn face_line(line: &str, attributes: Attributes) -> String {
    let mut new = "f".to_owned();
    for word in line.split_whitespace().skip(1).take_while(|word| !word.starts_with('#')) {
        let mut parts = word.split('/');
        let mut next = || parts.next().unwrap_or_default();
        let (position, uv, normal) = (next(), next(), next());
        new.push(' ');
        new.push_str(position);
        match (attributes.uv, attributes.normal) {
            (false, false) => {}
            (true, false) => new.extend(["/", uv]),
            (false, true) => new.extend(["//", normal]),
            (true, true) => new.extend(["/", uv, "/", normal]),
        }
    }
    new.push('\n');
    new
}

/// The indices of a corner as they stand; `None` for a corner that is not one.
fn corner(word: &str) -> Option<[Option<i64>; 3]> {
    let mut indices = [None; 3];
    for (i, part) in word.split('/').enumerate() {
        let index = indices.get_mut(i)?;
        if !part.is_empty() {
            *index = Some(part.parse().ok()?);
        }
    }
    Some(indices)
}

/// Whether an index, counted from 1 or backwards from -1, is one of `count`.
fn is_inside(index: i64, count: usize) -> bool {
    index != 0 && index.unsigned_abs() <= count as u64
}

/// Numbers up to a comment, at most `MAX`, and whether there was more; `None` if a word before is none.
fn numbers<'w, const MAX: usize>(words: impl Iterator<Item = &'w str>) -> Option<(Numbers<MAX>, bool)> {
    let mut numbers = Numbers { values: [0.0; MAX], count: 0 };
    for word in words {
        if word.starts_with('#') {
            return Some((numbers, true));
        }
        if numbers.count == MAX {
            return Some((numbers, true));
        }
        numbers.values[numbers.count] = word.parse().ok()?;
        numbers.count += 1;
    }
    Some((numbers, false))
}

/// A few numbers, without an allocation a line.
struct Numbers<const MAX: usize> {
    values: [f32; MAX],
    count: usize,
}

impl<const MAX: usize> std::ops::Deref for Numbers<MAX> {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.values[..self.count]
    }
}

impl<const MAX: usize> Numbers<MAX> {
    fn as_slice(&self) -> &[f32] {
        self
    }
}
