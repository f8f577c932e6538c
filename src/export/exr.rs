//! Films as OpenEXR: raw numbers or linear colours, 32-bit floats, a named layer each.

use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds,
    Layer, LayerAttributes, SmallVec, Text, WritableImage,
};

use super::{ExportError, atomic, png::SESSION_KEYWORD};
use crate::render::Film;
use crate::render::film::FilmContent;

/// Writes films of one size as the layers of one file. A layer is called by its view; colours have channels R, G, B,
/// numbers one channel Y (NaN where there is none); means over the samples. `session` is carried by each
/// layer as an attribute.
///
/// # Errors
/// [`ExportError`], also for no film at all or films of different sizes.
pub fn save(films: &[&Film], session: Option<&str>, path: &Path) -> Result<(), ExportError> {
    atomic::write_bytes(path, &encode(films, session)?)
}

fn encode(films: &[&Film], session: Option<&str>) -> Result<Vec<u8>, ExportError> {
    let fail = |reason: &str| ExportError::Encode { reason: reason.to_owned() };
    let first = films.first().ok_or_else(|| fail("there is nothing to write"))?;
    if films.iter().any(|film| (film.width, film.height) != (first.width, first.height)) {
        return Err(fail("the layers have different sizes"));
    }
    let size = (first.width as usize, first.height as usize);
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    // The format's strings are bytes; like most programs we write UTF-8.
    let session = session.map(|text| AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())));
    let layers: SmallVec<[_; 2]> = films
        .iter()
        .map(|film| {
            let mut about = LayerAttributes::named(film.subject.view.name());
            about.software_name = Some(Text::from("bvhscope"));
            about.other.extend(session.clone().map(|text| (Text::from(SESSION_KEYWORD), text)));
            about.comments = Some(Text::from(comment(film).as_str()));
            Layer::new(size, about, Encoding::SMALL_LOSSLESS, channels(film))
        })
        .collect();
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layers(attributes, layers).write().to_buffered(&mut bytes);
    written.map_err(|error| fail(&error.to_string()))?;
    Ok(bytes.into_inner())
}

fn comment(film: &Film) -> String {
    let subject = film.subject;
    format!(
        "{}; {} rays; shadow rule {}; {} samples a pixel",
        subject.view.description(),
        subject.count.name(),
        subject.shadow_rule.name(),
        film.samples
    )
}

fn channels(film: &Film) -> AnyChannels<FlatSamples> {
    let pixels = || (0..film.height).flat_map(|y| (0..film.width).map(move |x| (x, y)));
    let channel = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
    let list: SmallVec<[_; 4]> = match &film.content {
        FilmContent::Color(_) => ["R", "G", "B"]
            .into_iter()
            .enumerate()
            .map(|(i, name)| {
                let values = pixels().map(|(x, y)| film.color(x, y).map_or(f32::NAN, |color| color[i]));
                channel(name, values.collect())
            })
            .collect(),
        FilmContent::Number(_) => {
            let values = pixels().map(|(x, y)| film.number(x, y).unwrap_or(f32::NAN));
            std::iter::once(channel("Y", values.collect())).collect()
        }
    };
    AnyChannels::sort(list)
}

#[cfg(test)]
mod tests {
    use ::exr::prelude::{ReadChannels, ReadLayers, read};
    use glam::Vec3;

    use super::*;
    use crate::render::film::FilmSubject;
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    fn film(view: View, content: FilmContent) -> Film {
        let subject = FilmSubject { view, count: CountKind::Camera, shadow_rule: ShadowRule::Glass };
        Film { width: 3, height: 2, subject, samples: 2, content }
    }

    #[test]
    fn numbers_and_colours_come_back_bit_for_bit_by_their_names() {
        let heat = film(View::RayCost, FilmContent::Number(vec![0.2, 4.0, f32::NAN, 1e9, 0.0, 7.0]));
        let colors: Vec<_> = (0..6).map(|i| Vec3::new(i as f32, 0.5, 1e4)).collect();
        let light = film(View::Path, FilmContent::Color(colors));
        let bytes = encode(&[&heat, &light], Some("(version: 1) ä")).expect("encoded");

        let back = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
        let image = back.all_attributes().from_buffered(Cursor::new(bytes)).expect("an EXR file");
        let layer = |name: &str| {
            let found = image
                .layer_data
                .iter()
                .find(|layer| layer.attributes.layer_name.as_ref().is_some_and(|n| n == name));
            &found.expect(name).channel_data.list
        };
        let heat = layer("ray-cost");
        assert_eq!((heat.len(), heat[0].name.to_string().as_str()), (1, "Y"));
        let values: Vec<f32> = heat[0].sample_data.values_as_f32().collect();
        assert_eq!((values[0], values[1], values[3]), (0.1, 2.0, 5e8));
        assert!(values[2].is_nan());
        let light = layer("path");
        let names: Vec<_> = light.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R"]);
        assert_eq!(light[2].sample_data.values_as_f32().collect::<Vec<_>>(), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]);
        let session = image.layer_data[0].attributes.other.get(&Text::from(SESSION_KEYWORD));
        assert!(
            matches!(session, Some(AttributeValue::Text(text)) if text.as_slice() == "(version: 1) ä".as_bytes())
        );
    }

    #[test]
    fn layers_of_different_sizes_are_refused() {
        let a = film(View::Depth, FilmContent::Number(vec![0.0; 6]));
        let b = Film { width: 2, ..a.clone() };
        assert!(encode(&[&a, &b], None).is_err() && encode(&[], None).is_err());
    }
}
