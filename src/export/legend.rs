//! A legend under a picture: what it shows, the colour bar with its numbers, and the settings.

use image::{Rgba, RgbaImage};

use super::text;
use crate::inspect::shadow_difference::ClassCounts;
use crate::render::difference::difference_color;
use crate::render::display::effective_range;
use crate::render::shadow::ShadowClass;
use crate::render::{BoxStyle, ColorMap, ColorScale, DisplaySettings, Film, ViewClass};
use crate::session::Session;
use crate::world::World;

const GROUND: Rgba<u8> = Rgba([24, 25, 29, 255]);
const BRIGHT: [u8; 3] = [236, 238, 242];
const MUTED: [u8; 3] = [164, 169, 180];
/// Size of a letter for a picture 1280 pixels wide, and the smallest one that can be read, in pixels.
const LETTER: f32 = 15.0;
const SMALLEST_LETTER: f32 = 11.0;
const LARGEST_LETTER: f32 = 64.0;

/// A square of colour and the gap behind it, in letters.
const SWATCH: f32 = 1.5;

/// What the legend says.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    pub title: String,
    pub key: LegendKey,
    /// Settings and figures, a sentence each.
    pub lines: Vec<String>,
}

/// How colours are to be read.
#[derive(Clone, Debug, PartialEq)]
pub enum LegendKey {
    /// Colours are colours.
    None,
    /// A colour map over a range.
    Bar { colormap: ColorMap, scale: ColorScale, range: [f32; 2] },
    /// Differences from `-limit` to `limit`.
    Difference { limit: f32 },
    /// Colours that stand for classes, each with its share of the pixels in its name.
    Classes(Vec<(String, [u8; 3])>),
}

impl Legend {
    /// The legend of a session's picture: of its film, made of this world.
    pub fn of(session: &Session, film: &Film, world: &World) -> Self {
        let view = session.view;
        let key = match view.class() {
            ViewClass::Class => LegendKey::Classes(shadow_classes(film)),
            ViewClass::Heat | ViewClass::Leaf | ViewClass::Distance => {
                match effective_range(film, &session.display) {
                    Some(range) => {
                        let DisplaySettings { colormap, scale, .. } = session.display;
                        LegendKey::Bar { colormap, scale, range }
                    }
                    None => LegendKey::None,
                }
            }
            ViewClass::Radiance | ViewClass::Data => LegendKey::None,
        };
        let title = match view.counts_rays() {
            true => format!("{} ({} rays)", view.description(), session.count.name()),
            false => view.description().to_owned(),
        };
        Self { title, key, lines: settings_lines(session, film, world) }
    }

    /// The picture with the legend below it, as wide as the picture.
    pub fn below(&self, picture: &RgbaImage) -> RgbaImage {
        let layout = Layout::of(self, picture.width());
        let mut whole = RgbaImage::from_pixel(picture.width(), picture.height() + layout.height, GROUND);
        image::imageops::replace(&mut whole, picture, 0, 0);
        self.draw(&mut whole, picture.height() as f32, &layout);
        whole
    }

    fn draw(&self, whole: &mut RgbaImage, top: f32, layout: &Layout) {
        let mut y = top + layout.margin;
        for line in &layout.title {
            text::draw(whole, (layout.margin, y), line, layout.letter * 1.15, BRIGHT);
            y += layout.letter * 1.5;
        }
        match &self.key {
            LegendKey::None => {}
            LegendKey::Bar { colormap, scale, range } => {
                draw_bar(whole, y, layout, |share| colormap.color(share), (*scale, *range));
            }
            LegendKey::Difference { limit } => {
                let color = |share: f32| difference_color(2.0 * share - 1.0);
                draw_bar(whole, y, layout, color, (ColorScale::Linear, [-limit, *limit]));
            }
            LegendKey::Classes(classes) => {
                for ((name, color), [x, line]) in
                    classes.iter().zip(flow(classes, layout.letter, layout.room))
                {
                    let (x, y) = (layout.margin + x, y + line * layout.letter * 1.5);
                    fill(whole, [x, y + 0.02 * layout.letter, layout.letter, layout.letter], |_| *color);
                    text::draw(whole, (x + SWATCH * layout.letter, y), name, layout.letter, BRIGHT);
                }
            }
        }
        y += layout.key_height;
        for line in &layout.lines {
            text::draw(whole, (layout.margin, y), line, layout.letter, MUTED);
            y += layout.letter * 1.35;
        }
    }
}

/// The classes of a shadow difference, with their shares of the pixels.
fn shadow_classes(film: &Film) -> Vec<(String, [u8; 3])> {
    let counts = ClassCounts::of(film);
    let total = f64::from(film.width) * f64::from(film.height);
    let name = |class: ShadowClass| match &counts {
        Some(counts) => format!("{}: {:.1} %", class.name(), 100.0 * counts.get(class) as f64 / total),
        None => class.name().to_owned(),
    };
    ShadowClass::ALL.map(|class| (name(class), class.color())).to_vec()
}

/// Where each class stands: its distance from the margin in pixels, and its line.
fn flow(classes: &[(String, [u8; 3])], letter: f32, room: f32) -> Vec<[f32; 2]> {
    let (mut x, mut line) = (0.0, 0.0);
    let place = |(name, _): &(String, [u8; 3])| {
        let width = SWATCH * letter + text::width(name, letter);
        if x > 0.0 && x + width > room {
            (x, line) = (0.0, line + 1.0);
        }
        let place = [x, line];
        x += width + 2.0 * letter;
        place
    };
    classes.iter().map(place).collect()
}

/// Where everything goes; lengths in pixels.
struct Layout {
    letter: f32,
    margin: f32,
    /// Between the margins.
    room: f32,
    title: Vec<String>,
    key_height: f32,
    lines: Vec<String>,
    height: u32,
}

impl Layout {
    fn of(legend: &Legend, width: u32) -> Self {
        let letter = (LETTER * width as f32 / 1280.0).clamp(SMALLEST_LETTER, LARGEST_LETTER);
        let margin = letter;
        let room = width as f32 - 2.0 * margin;
        let title = text::wrap(&legend.title, letter * 1.15, room);
        let lines: Vec<_> = legend.lines.iter().flat_map(|line| text::wrap(line, letter, room)).collect();
        let key_height = match &legend.key {
            LegendKey::None => 0.0,
            LegendKey::Bar { .. } | LegendKey::Difference { .. } => letter * 3.2,
            LegendKey::Classes(classes) => {
                let lines = flow(classes, letter, room).last().map_or(0.0, |[_, line]| line + 1.0);
                letter * (1.5 * lines + 0.4)
            }
        };
        let height = 2.0 * margin
            + title.len() as f32 * letter * 1.5
            + key_height
            + lines.len() as f32 * letter * 1.35;
        Self { letter, margin, room, title, key_height, lines, height: height.ceil() as u32 }
    }
}

/// The scene and its tree in a sentence.
pub fn tree_line(world: &World) -> String {
    let build = &world.report.config;
    let mut tree = match world.traced_file() {
        Some(file) => format!("imported from {}, width {}", file.name, file.raw.width),
        None => {
            let mut tree = format!("{} builder", build.builder.name());
            if build.builder.uses_bins() {
                tree += &format!(" with {} bins", build.bins);
            }
            tree + &format!(", width {}, at most {} shapes a leaf", build.width.name(), build.leaf)
        }
    };
    tree += &format!(", {} nodes", world.figures.node_count);
    if let Some(cost) = world.figures.sah_cost {
        tree += &format!(", SAH cost {:.2}", cost.total());
    }
    format!("{}, {} shapes; {tree}", world.scene.name, world.scene.shape_count())
}

fn settings_lines(session: &Session, film: &Film, world: &World) -> Vec<String> {
    let samples = if film.samples == 1 { "1 sample".to_owned() } else { format!("{} samples", film.samples) };
    let mut picture = format!("{} x {} pixels, {samples} a pixel", film.width, film.height);
    if session.view.class() == ViewClass::Radiance {
        let display = session.display;
        picture += &format!(", exposure {:+} EV, tone curve {}", display.exposure, display.tonemap.name());
    }
    if session.time != 0.0 {
        picture += &format!(", at {} s", session.time);
    }
    if let Some([min, max]) = session.overlay.depths {
        let which = if session.overlay.leaves_only { "leaves" } else { "boxes" };
        let how = match session.overlay.style {
            BoxStyle::Density => "counted".to_owned(),
            BoxStyle::Wire | BoxStyle::Fill => format!("coloured {}", session.overlay.color.description()),
        };
        picture += &format!("; {which} of depths {min} to {max}, {how}");
    }
    vec![tree_line(world), picture]
}

fn draw_bar(
    whole: &mut RgbaImage,
    top: f32,
    layout: &Layout,
    color: impl Fn(f32) -> [u8; 3],
    (scale, range): (ColorScale, [f32; 2]),
) {
    let left = layout.margin;
    let length = (whole.width() as f32 - 2.0 * layout.margin).max(1.0);
    fill(whole, [left, top, length, layout.letter], color);
    let below = top + layout.letter * 1.1;
    let mut free = f32::NEG_INFINITY;
    let mut label = |whole: &mut RgbaImage, value: f32, step: f32, end: f32| {
        let name = tick_text(value, step);
        let share = scale.place(value, range).clamp(0.0, 1.0);
        let width = text::width(&name, layout.letter);
        let x = (left + share * length - width / 2.0).clamp(left, (left + length - width).max(left));
        if x < free || x + width > end {
            return x;
        }
        fill(whole, [left + share * (length - 1.0), top + layout.letter, 1.0, layout.letter * 0.25], |_| {
            MUTED
        });
        text::draw(whole, (x, below + layout.letter * 0.15), &name, layout.letter, BRIGHT);
        free = x + width + layout.letter;
        x
    };
    let step = tick_step(range, (length / (6.0 * layout.letter)).clamp(1.0, 10.0));
    let mut end = left + length;
    label(whole, range[0], step, end + 1.0);
    // The upper end keeps its place; ticks between come as far as they fit.
    let name = tick_text(range[1], step);
    end -= text::width(&name, layout.letter) + layout.letter;
    match scale {
        ColorScale::Linear => {
            ticks(range, step).into_iter().for_each(|value| _ = label(whole, value, step, end))
        }
        ColorScale::Log => {
            decades(range).for_each(|value| _ = label(whole, value, value.abs().min(step), end));
        }
    }
    label(whole, range[1], step, f32::INFINITY);
}

/// A step of 1, 2 or 5 times a power of ten that gives at most `count` ticks.
fn tick_step([low, high]: [f32; 2], count: f32) -> f32 {
    let rough = (high - low) / count;
    if !(rough > 0.0 && rough.is_finite()) {
        return 1.0;
    }
    let power = 10f32.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|step| *step >= rough).unwrap_or(10.0 * power)
}

/// Multiples of the step strictly inside the range.
fn ticks([low, high]: [f32; 2], step: f32) -> Vec<f32> {
    let first = (low / step).floor() as i64 + 1;
    (first..first + 100).map(|i| i as f32 * step).take_while(|value| *value < high).collect()
}

/// 1, 2 and 5 times powers of ten strictly inside the range, of either sign, in order: over the decades of a logarithmic scale
/// and one more.
fn decades([low, high]: [f32; 2]) -> impl Iterator<Item = f32> {
    let top = low.abs().max(high.abs()).max(f32::MIN_POSITIVE).log10().floor() as i32;
    let sizes = (top - 4..=top).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f32.powi(power)));
    let mut values: Vec<f32> =
        sizes.flat_map(|size| [size, -size]).filter(|v| low < *v && *v < high).collect();
    values.sort_by(f32::total_cmp);
    values.into_iter()
}

/// A number with no more digits than the step between ticks asks for.
fn tick_text(value: f32, step: f32) -> String {
    let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let size = value.abs();
    if size >= 1e7 || (size > 0.0 && size < 1e-5) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.digits$}");
    // An end of the range that lies between ticks keeps one digit more.
    if text.parse::<f32>().is_ok_and(|t| (t - value).abs() > step * 1e-3) {
        return format!("{value:.*}", digits + 1);
    }
    text
}

/// Fills `[left, top, width, height]` with a colour that may change from left (0) to right (1).
fn fill(whole: &mut RgbaImage, [left, top, width, height]: [f32; 4], color: impl Fn(f32) -> [u8; 3]) {
    let (x0, x1) = (left.round() as u32, (left + width).round().min(whole.width() as f32) as u32);
    let (y0, y1) = (top.round() as u32, (top + height).round().min(whole.height() as f32) as u32);
    for x in x0..x1 {
        let [r, g, b] = color((x as f32 + 0.5 - left) / width);
        for y in y0..y1 {
            whole.put_pixel(x, y, Rgba([r, g, b, 255]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend(key: LegendKey) -> Legend {
        Legend {
            title: "nodes visited: inner nodes whose children's boxes were tested, and leaves (camera rays)"
                .to_owned(),
            key,
            lines: vec![
                "bunny, 4977 shapes; binned builder with 16 bins, at most 2 shapes a leaf".to_owned(),
            ],
        }
    }

    #[test]
    fn the_picture_stays_as_it_is_and_the_legend_lies_below() {
        let picture = RgbaImage::from_fn(320, 180, |x, y| Rgba([x as u8, y as u8, 9, 255]));
        for key in [
            LegendKey::None,
            LegendKey::Bar { colormap: ColorMap::Greys, scale: ColorScale::Linear, range: [0.0, 40.0] },
            LegendKey::Difference { limit: 3.0 },
            LegendKey::Classes(vec![("lit".to_owned(), [200, 0, 0]), ("dark".to_owned(), [0, 200, 0])]),
        ] {
            let whole = legend(key.clone()).below(&picture);
            assert_eq!(whole.width(), 320);
            assert!((200..400).contains(&whole.height()), "{key:?}: {}", whole.height());
            assert!(picture.enumerate_pixels().all(|(x, y, pixel)| whole.get_pixel(x, y) == pixel));
            let written = (180..whole.height()).flat_map(|y| (0..320).map(move |x| (x, y)));
            let bright = written.filter(|&(x, y)| whole.get_pixel(x, y).0[0] > 180).count();
            assert!(bright > 200, "{key:?}: {bright} bright pixels");
        }
    }

    #[test]
    fn the_bar_runs_through_the_colour_map() {
        let key = LegendKey::Bar { colormap: ColorMap::Greys, scale: ColorScale::Linear, range: [0.0, 40.0] };
        let whole = legend(key).below(&RgbaImage::new(1280, 10));
        let column = |x: u32| (10..whole.height()).map(|y| whole.get_pixel(x, y).0[0]).max();
        let middle: Vec<_> = (60..70).map(|y| whole.get_pixel(640, y).0).collect();
        assert!(
            middle.contains(&[127, 127, 127, 255]) || middle.contains(&[128, 128, 128, 255]),
            "{middle:?}"
        );
        assert!(column(1279) == Some(GROUND.0[0]), "the margin is free");
    }

    #[test]
    fn tiny_pictures_have_a_legend_too() {
        for (width, range) in [(1, [0.5, 0.5001]), (16, [0.0, 1e9]), (64, [3.0, 3.0])] {
            let key = LegendKey::Bar { colormap: ColorMap::Greys, scale: ColorScale::Linear, range };
            assert_eq!(legend(key).below(&RgbaImage::new(width, 2)).width(), width);
        }
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        assert_eq!(tick_step([0.0, 40.0], 8.0), 5.0);
        assert_eq!(ticks([0.0, 40.0], 10.0), [10.0, 20.0, 30.0]);
        assert_eq!(ticks([-1.5, 1.5], 1.0), [-1.0, 0.0, 1.0]);
        assert_eq!((tick_text(20.0, 5.0), tick_text(0.25, 0.05)), ("20".to_owned(), "0.25".to_owned()));
        assert_eq!((tick_text(41.5, 5.0), tick_text(2.5e9, 1e9)), ("41.5".to_owned(), "2.50e9".to_owned()));
        assert_eq!(tick_step([1.0, 1.0], 5.0), 1.0);
    }
}
