//! Plots leave the program: SVG, PNG, and their data as CSV.

mod svg;

use std::path::Path;
use std::sync::OnceLock;

use image::RgbaImage;
use resvg::usvg;

use super::{ExportError, atomic, png};
use crate::inspect::plot::{Mark, Plot, Point};

pub use svg::{Look, svg};

/// Pixels of a PNG for each unit of the drawing, so that it is sharp in print, too.
const PIXELS_A_UNIT: f32 = 2.0;

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotFormat {
    Png,
    Svg,
    Csv,
}

impl PlotFormat {
    pub const ALL: [Self; 3] = [Self::Png, Self::Svg, Self::Csv];

    /// As in a menu.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "as PNG",
            Self::Svg => "as SVG",
            Self::Csv => "data as CSV",
        }
    }

    pub fn about(self) -> &'static str {
        match self {
            Self::Png => "A picture of 1600 by 960 pixels.",
            Self::Svg => "A drawing that is sharp at any size, for papers and pages.",
            Self::Csv => "The values, a line each, for spreadsheets and programs.",
        }
    }

    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Svg => "svg",
            Self::Csv => "csv",
        }
    }

    /// By the file's extension.
    ///
    /// # Errors
    /// [`ExportError::Write`] that names the ones that are known.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.extension() == extension).ok_or_else(|| {
            ExportError::Write {
                path: path.to_owned(),
                reason: format!("the extension '{extension}' is unknown; use .png, .svg or .csv"),
            }
        })
    }
}

/// Writes a plot in the format of the path's extension.
///
/// # Errors
/// [`ExportError`]
pub fn save(plot: &Plot, look: Look, path: &Path) -> Result<(), ExportError> {
    let bytes = match PlotFormat::of(path)? {
        PlotFormat::Png => png::encode(&picture(plot, look)?, None)?,
        PlotFormat::Svg => svg(plot, look).into_bytes(),
        PlotFormat::Csv => csv(plot).into_bytes(),
    };
    atomic::write_bytes(path, &bytes)
}

/// The drawing as a picture; letters are those of the window's font.
///
/// # Errors
/// [`ExportError::Encode`]
pub fn picture(plot: &Plot, look: Look) -> Result<RgbaImage, ExportError> {
    static FONTS: OnceLock<std::sync::Arc<usvg::fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let family =
            fonts.faces().next().and_then(|face| face.families.first()).map(|(name, _)| name.clone());
        if let Some(family) = family {
            fonts.set_sans_serif_family(family.clone());
            fonts.set_serif_family(family);
        }
        std::sync::Arc::new(fonts)
    });
    let fail = |reason: String| ExportError::Encode { reason };
    let options = usvg::Options { fontdb: std::sync::Arc::clone(fonts), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(&svg(plot, look), &options).map_err(|error| fail(error.to_string()))?;
    let size = tree.size();
    let [width, height] = [size.width(), size.height()].map(|side| (side * PIXELS_A_UNIT).round() as u32);
    let mut pixels =
        resvg::tiny_skia::Pixmap::new(width, height).ok_or_else(|| fail("it has no size".to_owned()))?;
    let scale = resvg::tiny_skia::Transform::from_scale(PIXELS_A_UNIT, PIXELS_A_UNIT);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    // Opaque everywhere, so that premultiplied colours are colours.
    RgbaImage::from_raw(width, height, pixels.take()).ok_or_else(|| fail("it is cut off".to_owned()))
}

/// The values: series, across, up, and what colours say. A bar has the height of its own part.
pub fn csv(plot: &Plot) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let name =
        |heading: String, otherwise: &str| if heading.is_empty() { otherwise.to_owned() } else { heading };
    let mut header =
        vec!["series".to_owned(), name(plot.x.heading(), "x"), name(plot.y.heading(), &plot.title)];
    header.extend(plot.key.as_ref().map(|key| key.label.clone()));
    writer.write_record(&header).expect("memory takes every row");
    for series in plot.series.iter().filter(|series| !series.decoration) {
        for point in &series.points {
            let Point { x, y, base, .. } = *point;
            let [x, y] = match series.mark {
                Mark::Across => [None, Some(y)],
                Mark::Upright => [Some(x), None],
                Mark::Bars { .. } => [Some(x), Some(y - base)],
                Mark::Line { .. } | Mark::Dots { .. } | Mark::Squares { .. } => [Some(x), Some(y)],
            };
            let text = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            let mut row = vec![series.name.clone(), text(x), text(y)];
            row.extend(plot.key.as_ref().map(|_| text(point.number)));
            writer.write_record(&row).expect("memory takes every row");
        }
    }
    let bytes = writer.into_inner().expect("memory takes every row");
    String::from_utf8(bytes).expect("plots are text")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::plot::{Axis, Ink, Series};

    fn plot() -> Plot {
        let x = Axis::powers_of_two(1, 8).labelled("bins");
        let y = Axis::around([3.0, 5.0]).labelled("SAH <cost>").unit("\"ms\"");
        Plot::new("Cost & bins", x, y)
            .of("bunny, binned")
            .with(
                Series::new("curve", Mark::Line { width: 1.5 }, Ink::Accent)
                    .at([[2.0, 5.0], [256.0, 3.0]])
                    .decoration(),
            )
            .with(
                Series::new("measured", Mark::Dots { radius: 2.5, filled: true }, Ink::Accent)
                    .at([[2.0, 5.0], [256.0, 3.0]]),
            )
            .with(Series::new("full sweep", Mark::Across, Ink::Muted).at([[0.0, 3.5]]))
            .with(Series::new("now", Mark::Upright, Ink::Second).at([[16.0, 0.0]]))
    }

    #[test]
    fn data_are_values_with_names_and_units() {
        let expected = "series,bins,\"SAH <cost> (\"\"ms\"\")\"\nmeasured,2,5\nmeasured,256,3\nfull sweep,,3.5\nnow,16,\n";
        assert_eq!(csv(&plot()), expected);
        let bars = Plot::new("Leaves", Axis::integers(1.0, 2.0, 4), Axis::from_zero(5.0))
            .with_stacked_bars(1.0, [("a", Ink::Accent, vec![1.0]), ("b", Ink::Second, vec![3.0])]);
        assert_eq!(csv(&bars), "series,x,Leaves\na,1,1\nb,1,3\n");
    }

    #[test]
    fn a_drawing_is_well_formed_and_says_what_the_plot_does() {
        for look in [Look::Dark, Look::Light, Look::Page] {
            let text = svg(&plot(), look);
            let read = usvg::roxmltree::Document::parse(&text).expect("well-formed XML");
            let words: Vec<_> =
                read.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect();
            for expected in [
                "Cost & bins",
                "bunny, binned",
                "bins",
                "SAH <cost> (\"ms\")",
                "256",
                "measured",
                "full sweep",
            ] {
                assert!(words.contains(&expected), "{expected}: {words:?}");
            }
            assert!(!words.contains(&"curve"), "what guides the eye is not in the legend");
            assert!(!text.contains("NaN") && !text.contains("inf"));
        }
    }

    #[test]
    fn a_picture_has_ground_ink_and_letters() {
        for (look, bright) in [(Look::Dark, false), (Look::Light, true)] {
            let picture = picture(&plot(), look).expect("drawn");
            assert_eq!(picture.dimensions(), (1600, 960));
            assert!(picture.pixels().all(|p| p.0[3] == 255));
            let ground = picture.get_pixel(3, 3).0;
            assert_eq!(ground[0] > 128, bright);
            let [r, g, b] = Ink::Accent.rgb(!bright);
            assert!(picture.pixels().filter(|p| p.0[..3] == [r, g, b]).count() > 100, "no ink");
            // The title at the top left is letters, not a bar.
            let title = image::imageops::crop_imm(&picture, 0, 0, 500, 70).to_image();
            let other = title.pixels().filter(|p| p.0 != ground).count();
            assert!((200..20_000).contains(&other), "{other} pixels of the title");
        }
    }

    #[test]
    fn each_extension_has_its_form_and_another_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, begins) in [("a.PNG", &b"\x89PNG"[..]), ("a.svg", b"<svg"), ("a.csv", b"series")] {
            let path = folder.path().join(name);
            save(&plot(), Look::Light, &path).expect("saved");
            assert!(std::fs::read(&path).expect("a file").starts_with(begins), "{name}");
        }
        let message =
            save(&plot(), Look::Light, &folder.path().join("a.pdf")).expect_err("unknown").to_string();
        assert!(message.contains("use .png, .svg or .csv"), "{message}");
    }
}
