//! Pictures as PNG, with the session that they show in a text chunk.

use std::io::{BufRead, Seek};

use image::RgbaImage;

use super::ExportError;

/// The keyword of the `iTXt` chunk that carries a session's text.
pub const SESSION_KEYWORD: &str = "bvhscope-session";
/// Most bytes that a decoder may take for a picture's header and texts.
const TEXT_LIMIT: usize = 16 << 20;

/// The bytes of a PNG file, RGBA with 8 bits a channel in sRGB; `session` is carried along.
///
/// # Errors
/// [`ExportError::Encode`], for a picture without pixels.
pub fn encode(picture: &RgbaImage, session: Option<&str>) -> Result<Vec<u8>, ExportError> {
    let encode = || -> Result<Vec<u8>, ::png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, picture.width(), picture.height());
        encoder.set_color(::png::ColorType::Rgba);
        encoder.set_depth(::png::BitDepth::Eight);
        encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Software".to_owned(), "bvhscope".to_owned())?;
        if let Some(text) = session {
            encoder.add_itxt_chunk(SESSION_KEYWORD.to_owned(), text.to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(picture.as_raw())?;
        writer.finish()?;
        Ok(bytes)
    };
    encode().map_err(|error| ExportError::Encode { reason: error.to_string() })
}

/// The session's text that a PNG file carries; `None` if it carries none. Reads no pixels.
///
/// # Errors
/// A reason, for what is not a PNG file or is cut off before its pixels.
pub fn session_text(file: impl BufRead + Seek) -> Result<Option<String>, String> {
    let limits = ::png::Limits { bytes: TEXT_LIMIT };
    let reader =
        ::png::Decoder::new_with_limits(file, limits).read_info().map_err(|error| error.to_string())?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == SESSION_KEYWORD);
    chunk.map(|chunk| chunk.get_text().map_err(|error| error.to_string())).transpose()
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::Rgba;

    use super::*;

    #[test]
    fn picture_and_text_come_back() {
        let picture = RgbaImage::from_fn(5, 3, |x, y| Rgba([x as u8 * 50, y as u8 * 80, 7, 255]));
        let text = "(version: 1)\nmit Umlaut: äöü, and more".repeat(100);
        let bytes = encode(&picture, Some(&text)).expect("encoded");
        assert_eq!(session_text(Cursor::new(&bytes)), Ok(Some(text)));
        let decoded = image::load_from_memory(&bytes).expect("a picture").to_rgba8();
        assert_eq!(decoded, picture);
    }

    #[test]
    fn a_png_without_a_session_has_none_and_garbage_is_refused() {
        let bytes = encode(&RgbaImage::new(1, 1), None).expect("encoded");
        assert_eq!(session_text(Cursor::new(&bytes)), Ok(None));
        for cut in [0, 4, 20, 50] {
            assert!(session_text(Cursor::new(&bytes[..cut])).is_err(), "{cut}");
        }
        assert!(session_text(Cursor::new(b"not a picture at all")).is_err());
        assert!(encode(&RgbaImage::new(0, 0), None).is_err());
    }
}
