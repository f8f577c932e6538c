//! The pictures of a comparison: A and B side by side under their names, and B - A, each with its legend.

use image::{Rgba, RgbaImage, imageops};

use super::legend::{Legend, LegendKey, tree_line};
use super::text;
use crate::inspect::difference::DifferenceSummary;
use crate::render::difference::{Difference, shared_range};
use crate::render::{DisplaySettings, Film, display};
use crate::session::Session;
use crate::world::World;

const GROUND: Rgba<u8> = Rgba([24, 25, 29, 255]);
const BRIGHT: [u8; 3] = [236, 238, 242];
/// Between the two pictures, in pixels.
const GAP: u32 = 4;

/// One side of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct ComparedSide<'a> {
    pub name: &'a str,
    pub session: &'a Session,
    pub film: &'a Film,
    pub world: &'a World,
}

impl ComparedSide<'_> {
    fn line(&self) -> String {
        let time =
            if self.session.time == 0.0 { String::new() } else { format!(" at {} s", self.session.time) };
        format!("{}{time}: {}", self.name, tree_line(self.world))
    }
}

/// Both pictures on one range, the left one 0 and the right one 1 to what is drawn over them, with the legend below.
pub fn side_by_side(sides: [ComparedSide; 2], draw_over: impl Fn(usize, &mut RgbaImage)) -> RgbaImage {
    let [a, b] = sides;
    let range = (a.film.subject == b.film.subject)
        .then(|| shared_range([a.film, b.film], &a.session.display))
        .flatten();
    let mut pictures = [0, 1].map(|i| {
        let side = &sides[i];
        let own = side.session.display;
        let settings = DisplaySettings { range: range.or(own.range), ..own };
        let mut picture = display::picture(side.film, &settings);
        draw_over(i, &mut picture);
        picture
    });
    for (picture, side) in pictures.iter_mut().zip(&sides) {
        draw_name(picture, side.name);
    }
    let [left, right] = &pictures;
    let size = [left.width() + GAP + right.width(), left.height().max(right.height())];
    let mut whole = RgbaImage::from_pixel(size[0], size[1], GROUND);
    imageops::replace(&mut whole, left, 0, 0);
    imageops::replace(&mut whole, right, i64::from(left.width() + GAP), 0);
    let shown = Session { display: DisplaySettings { range, ..a.session.display }, ..a.session.clone() };
    let legend = Legend::of(&shown, a.film, a.world);
    // The last line is that of the picture: size and samples.
    let picture_line = legend.lines.last().cloned();
    let lines = [a.line(), b.line()].into_iter().chain(picture_line).collect();
    Legend { lines, ..legend }.below(&whole)
}

/// B - A with its legend; `None` if the two cannot be subtracted.
pub fn difference(sides: [ComparedSide; 2]) -> Option<RgbaImage> {
    let [a, b] = sides;
    let difference = Difference::of(a.film, b.film)?;
    let limit = difference.limit();
    let mut lines = vec![a.line(), b.line()];
    if let Some(summary) = DifferenceSummary::of(&difference, a.film.subject.view) {
        lines.insert(0, format!("{}; mean {:+.3}", summary.shares(), summary.histogram.mean));
    }
    let view = Legend::of(a.session, a.film, a.world).title;
    let title = format!("{} - {}: {view}", b.name, a.name);
    let legend = Legend { title, key: LegendKey::Difference { limit }, lines };
    Some(legend.below(&difference.picture(limit)))
}

/// A name in the upper left corner, on a dark ground so that it can be read over anything.
fn draw_name(picture: &mut RgbaImage, name: &str) {
    let size = (picture.height() as f32 / 30.0).clamp(12.0, 48.0);
    let (width, height) = (text::width(name, size) + size, 1.5 * size);
    for y in 0..(height as u32).min(picture.height()) {
        for x in 0..(width as u32).min(picture.width()) {
            let pixel = picture.get_pixel_mut(x, y);
            pixel.0 = [pixel.0[0] / 3, pixel.0[1] / 3, pixel.0[2] / 3, 255];
        }
    }
    text::draw(picture, (0.5 * size, 0.2 * size), name, size, BRIGHT);
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{BuildConfig, Builder};
    use crate::render::integrate::render;
    use crate::render::{RenderSettings, View};
    use crate::scene::builtin;
    use crate::task::Task;

    #[test]
    fn both_pictures_have_one_range_and_the_difference_has_its_colours() {
        let scene = Arc::new(builtin::make("bunny").expect("a built-in scene"));
        let task = Task::new();
        let mut session = Session { view: View::RayCost, ..Session::default() };
        session.render = RenderSettings { width: 160, height: 90, ..session.render };
        let camera = scene.camera;
        let of = |builder, view| {
            let config = BuildConfig { builder, ..BuildConfig::default() };
            let world = World::build(Arc::clone(&scene), &config, &task).expect("nobody cancels");
            let subject = Session { view, ..session.clone() }.film_subject();
            let film = render(subject, &world, &camera, &session.render, 1, &task).expect("nobody cancels");
            (world, film)
        };
        let ((world_a, a), (world_b, b)) =
            (of(Builder::Binned, View::RayCost), of(Builder::Random, View::RayCost));
        let side = |name, film, world| ComparedSide { name, session: &session, film, world };
        let sides = [side("A", &a, &world_a), side("B", &b, &world_b)];
        let whole = side_by_side(sides, |_, _| ());
        assert_eq!(whole.width(), 2 * 160 + GAP);
        assert!(whole.height() > 90);
        let range = shared_range([&a, &b], &session.display);
        let settings = DisplaySettings { range, ..session.display };
        let (left, right) = (display::picture(&a, &settings), display::picture(&b, &settings));
        // Away from the names.
        for (x, y) in [(150, 80), (80, 45), (10, 85)] {
            assert_eq!(whole.get_pixel(x, y), left.get_pixel(x, y));
            assert_eq!(whole.get_pixel(160 + GAP + x, y), right.get_pixel(x, y));
        }
        let picture = difference(sides).expect("two heatmaps");
        assert_eq!(picture.width(), 160);
        let red = (0..90).flat_map(|y| (0..160).map(move |x| (x, y)));
        let red = red.filter(|&(x, y)| picture.get_pixel(x, y).0[0] > picture.get_pixel(x, y).0[2]).count();
        assert!(red > 160 * 90 / 2, "a random tree is dearer nearly everywhere: {red}");
        let (_, light) = of(Builder::Binned, View::Whitted);
        let sides = [side("A", &light, &world_a), side("B", &light, &world_b)];
        assert_eq!(difference(sides), None);
    }
}
