//! Letters drawn into pictures: anti-aliased glyphs of the fonts that the window uses, too.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use image::{Rgba, RgbaImage};

static PROSE: LazyLock<FontRef<'static>> = LazyLock::new(|| font(epaint_default_fonts::UBUNTU_LIGHT));

fn font(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::try_from_slice(bytes).expect("an embedded font")
}

/// How wide a line of text is, in pixels, at a height of `size` pixels.
pub fn width(text: &str, size: f32) -> f32 {
    let font = PROSE.as_scaled(PxScale::from(size));
    let mut width = 0.0;
    let mut previous = None;
    for glyph in text.chars().map(|c| font.glyph_id(c)) {
        width += previous.map_or(0.0, |p| font.kern(p, glyph)) + font.h_advance(glyph);
        previous = Some(glyph);
    }
    width
}

/// Draws a line of text over an opaque picture, its box's top left corner at `(x, y)`. What lies outside is cut off.
pub fn draw(picture: &mut RgbaImage, (x, y): (f32, f32), text: &str, size: f32, color: [u8; 3]) {
    let font = PROSE.as_scaled(PxScale::from(size));
    let mut at = x;
    let mut previous = None;
    for id in text.chars().map(|c| font.glyph_id(c)) {
        at += previous.map_or(0.0, |p| font.kern(p, id));
        let placed = id.with_scale_and_position(font.scale(), point(at, y + font.ascent()));
        at += font.h_advance(id);
        previous = Some(id);
        let Some(outline) = font.outline_glyph(placed) else { continue };
        let corner = outline.px_bounds().min;
        outline.draw(|dx, dy, coverage| {
            let (px, py) = (corner.x as i64 + i64::from(dx), corner.y as i64 + i64::from(dy));
            if let (Ok(px), Ok(py)) = (u32::try_from(px), u32::try_from(py))
                && let Some(pixel) = picture.get_pixel_mut_checked(px, py)
            {
                blend(pixel, color, coverage);
            }
        });
    }
}

/// Breaks text into lines no wider than `most` pixels, between words; a word wider than that stands alone.
pub fn wrap(text: &str, size: f32, most: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(&format!("{line} {word}"), size) <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Mixes in linear light, so that thin strokes keep their weight on a dark ground.
fn blend(pixel: &mut Rgba<u8>, color: [u8; 3], coverage: f32) {
    let share = coverage.clamp(0.0, 1.0);
    for (channel, over) in pixel.0.iter_mut().zip(color) {
        let linear = |value: u8| (f32::from(value) / 255.0).powi(2);
        let mixed = linear(*channel) + (linear(over) - linear(*channel)) * share;
        *channel = (mixed.sqrt() * 255.0).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn width_grows_with_text_and_size() {
        assert_eq!(width("", 20.0), 0.0);
        assert!(width("boxes", 20.0) < width("boxes tested", 20.0));
        let (small, large) = (width("boxes", 20.0), width("boxes", 40.0));
        assert!((large - 2.0 * small).abs() < 0.5, "{small} {large}");
    }

    #[test]
    fn letters_lie_inside_their_box_and_are_cut_at_the_border() {
        let mut picture = RgbaImage::from_pixel(120, 40, Rgba([0, 0, 0, 255]));
        draw(&mut picture, (10.0, 8.0), "Ag|", 20.0, [255; 3]);
        let right = 10.0 + width("Ag|", 20.0);
        let mut lit = 0;
        for (x, y, pixel) in picture.enumerate_pixels() {
            if pixel.0[0] > 0 {
                lit += 1;
                assert!(x >= 9 && (x as f32) <= right + 1.0 && (7..=30).contains(&y), "{x} {y}");
            }
        }
        assert!(lit > 50, "{lit} pixels lit");
        draw(&mut picture, (-15.0, -10.0), "outside", 30.0, [255; 3]);
        draw(&mut picture, (110.0, 30.0), "outside", 30.0, [255; 3]);
    }

    #[test]
    fn lines_are_no_wider_than_asked() {
        let lines = wrap("one two three four five six seven", 16.0, 80.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| width(line, 16.0) <= 80.0));
        assert_eq!(lines.join(" "), "one two three four five six seven");
        assert_eq!(wrap("incomprehensibilities", 16.0, 10.0), ["incomprehensibilities"]);
    }
}
