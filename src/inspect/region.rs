//! A rectangle of a picture, and the pixels of a picture with the largest numbers.

use super::histogram::Histogram;
use crate::render::Film;

/// Pixels from `from` to before `to`, of a picture of `size`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub from: [u32; 2],
    pub to: [u32; 2],
    pub size: [u32; 2],
}

/// A pixel of a film of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelNumber {
    pub pixel: [u32; 2],
    pub number: f32,
}

impl Region {
    /// The rectangle between two pixels, both included; `None` if it has less than two pixels a side.
    pub fn between(a: [u32; 2], b: [u32; 2], size: [u32; 2]) -> Option<Self> {
        let from = [a[0].min(b[0]), a[1].min(b[1])];
        let to = [(a[0].max(b[0]) + 1).min(size[0]), (a[1].max(b[1]) + 1).min(size[1])];
        (to[0] >= from[0] + 2 && to[1] >= from[1] + 2).then_some(Self { from, to, size })
    }

    /// The whole picture.
    pub fn all(size: [u32; 2]) -> Self {
        Self { from: [0, 0], to: size, size }
    }

    /// The pixels of a film, which may be coarser than the picture.
    fn of_film(&self, film: &Film) -> [std::ops::Range<u32>; 2] {
        let film_size = [film.width, film.height];
        std::array::from_fn(|axis| {
            let (picture, film) = (u64::from(self.size[axis].max(1)), u64::from(film_size[axis]));
            let from = u64::from(self.from[axis]) * film / picture;
            let to = (u64::from(self.to[axis]) * film).div_ceil(picture);
            from as u32..to.min(film) as u32
        })
    }

    /// The histogram of the numbers inside; `None` on a film of colours, or if no pixel has a number.
    pub fn histogram(&self, film: &Film, bins: usize) -> Option<Histogram> {
        let numbers = film.numbers()?;
        let [columns, rows] = self.of_film(film);
        let row = |y: u32| {
            let start = y as usize * film.width as usize;
            &numbers[start + columns.start as usize..start + columns.end as usize]
        };
        let inside: Vec<f32> = rows.flat_map(|y| row(y).iter().copied()).collect();
        Histogram::of(&inside, bins, None)
    }

    /// The `most` pixels inside with the largest numbers, the largest first, none within `apart` pixels of the film of another.
    /// Of equal ones the first in reading order.
    pub fn largest(&self, film: &Film, most: usize, apart: u32) -> Vec<PixelNumber> {
        let Some(numbers) = film.numbers() else { return Vec::new() };
        let [columns, rows] = self.of_film(film);
        let mut order: Vec<(f32, u32)> = rows
            .flat_map(|y| columns.clone().map(move |x| y * film.width + x))
            .map(|i| (numbers[i as usize], i))
            .filter(|(number, _)| number.is_finite())
            .collect();
        // Enough to find that many apart from each other, but for the widest plateaus.
        let enough = (most * (2 * apart as usize + 1).pow(2)).max(most);
        let larger = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if order.len() > enough && enough > 0 {
            order.select_nth_unstable_by(enough - 1, larger);
            order.truncate(enough);
        }
        order.sort_unstable_by(larger);
        let mut picked: Vec<PixelNumber> = Vec::new();
        for (number, i) in order {
            let pixel = [i % film.width, i / film.width];
            let is_near = |other: &PixelNumber| {
                other.pixel[0].abs_diff(pixel[0]).max(other.pixel[1].abs_diff(pixel[1])) <= apart
            };
            if picked.len() < most && !picked.iter().any(is_near) {
                picked.push(PixelNumber { pixel, number });
            }
        }
        picked
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::{FilmContent, FilmSubject};
    use crate::render::{CountKind, View};
    use crate::scene::ShadowRule;

    /// 8 x 4 pixels, numbered in reading order, the third without a number.
    fn film() -> Film {
        let subject = FilmSubject {
            view: View::NodesVisited,
            count: CountKind::Camera,
            shadow_rule: ShadowRule::Glass,
        };
        let mut film = Film::new(8, 4, subject);
        film.samples = 1;
        let mut numbers: Vec<f32> = (0..32).map(|i| i as f32).collect();
        numbers[2] = f32::NAN;
        film.content = FilmContent::Number(numbers);
        film
    }

    #[test]
    fn a_rectangle_has_the_numbers_inside_it() {
        let region = Region::between([5, 3], [2, 1], [8, 4]).expect("large enough");
        assert_eq!((region.from, region.to), ([2, 1], [6, 4]));
        let histogram = region.histogram(&film(), 4).expect("numbers");
        assert_eq!((histogram.value_count, histogram.min, histogram.max), (12, 10.0, 29.0));
        let whole = Region::all([8, 4]).histogram(&film(), 4).expect("numbers");
        assert_eq!(whole.value_count, 31, "one pixel has no number");
        assert_eq!(Region::between([3, 3], [3, 9], [8, 4]), None);
        // The picture has twice as many pixels a side as the film.
        let coarse = Region::between([4, 2], [11, 7], [16, 8]).expect("large enough");
        assert_eq!(coarse.histogram(&film(), 4).map(|h| h.value_count), Some(12));
    }

    #[test]
    fn the_largest_are_apart_from_each_other() {
        let pixels = |most, apart| {
            let largest = Region::all([8, 4]).largest(&film(), most, apart);
            largest.iter().map(|p| p.number as u32).collect::<Vec<_>>()
        };
        assert_eq!(pixels(3, 0), [31, 30, 29]);
        assert_eq!(pixels(3, 1), [31, 29, 27]);
        assert_eq!(pixels(100, 0).len(), 31);
        assert_eq!(pixels(0, 0), Vec::<u32>::new());
    }
}
