//! The raw content of a film as CSV: a line a pixel, row by row from the top left.

use std::path::Path;

use super::{ExportError, atomic};
use crate::render::Film;
use crate::render::film::FilmContent;

/// Writes `x,y,value` for a film of numbers (nothing behind the last comma where there is no number), `x,y,r,g,b` in
/// linear light for a film of colours. Means over the samples.
///
/// # Errors
/// [`ExportError::Write`]
pub fn save(film: &Film, path: &Path) -> Result<(), ExportError> {
    atomic::write_with(path, |file| write(film, file).map_err(|error| atomic::refusal(path, &error)))
}

fn write(film: &Film, out: &mut dyn atomic::WriteSeek) -> std::io::Result<()> {
    let name = film.subject.view.name();
    match film.content {
        FilmContent::Color(_) => writeln!(out, "x,y,r,g,b")?,
        FilmContent::Number(_) => writeln!(out, "x,y,{name}")?,
    }
    for y in 0..film.height {
        for x in 0..film.width {
            match (&film.content, film.color(x, y), film.number(x, y)) {
                (FilmContent::Color(_), Some(c), _) => writeln!(out, "{x},{y},{},{},{}", c.x, c.y, c.z)?,
                (FilmContent::Color(_), None, _) => writeln!(out, "{x},{y},,,")?,
                (FilmContent::Number(_), _, Some(value)) => writeln!(out, "{x},{y},{value}")?,
                (FilmContent::Number(_), _, None) => writeln!(out, "{x},{y},")?,
            }
        }
    }
    Ok(())
}
