//! Points of a sweep as a plot: two figures across and up, a third as colour, and the front that no tree beats.

use super::{SweepPoint, same_tree};
use crate::accel::BuildConfig;
use crate::inspect::columns::{Column, Row};
use crate::inspect::pareto;
use crate::inspect::plot::{Axis, ColorKey, Ink, Mark, Plot, Point, Series};
use crate::render::ColorMap;

/// Colours that a key shows.
const STEPS: usize = 48;

/// Which figures, and whether their logarithms.
#[derive(Clone, Copy)]
pub struct SweepPlot {
    pub x: &'static Column,
    pub y: &'static Column,
    pub color: &'static Column,
    pub log: [bool; 2],
}

impl Default for SweepPlot {
    fn default() -> Self {
        let of = |key| Column::of(key).expect("the key of a column");
        Self { x: of("build_ms"), y: of("ray_cost_mean"), color: of("leaf"), log: [false; 2] }
    }
}

impl SweepPlot {
    pub fn columns(&self) -> [&'static Column; 2] {
        [self.x, self.y]
    }

    /// The points on the front of the two figures.
    pub fn front(&self, points: &[SweepPoint]) -> Vec<usize> {
        pareto::front(points, &self.columns())
    }

    /// The values of a point across and up, in the units of the axes; `None` if it has no place.
    pub fn place(&self, point: &SweepPoint) -> Option<[f64; 2]> {
        let of = |column: &Column, log: bool| {
            let value = point.value(column).number()? / column.shown_unit;
            (!log || value > 0.0).then_some(value)
        };
        Some([of(self.x, self.log[0])?, of(self.y, self.log[1])?])
    }

    /// The plot; the tree of `current` settings, if it is among them, is marked.
    pub fn plot(&self, points: &[SweepPoint], current: Option<&BuildConfig>) -> Plot {
        let places: Vec<Option<[f64; 2]>> = points.iter().map(|p| self.place(p)).collect();
        let axis = |i: usize| {
            let values = places.iter().flatten().map(|place| place[i]);
            let axis = if self.log[i] { Axis::log10_around(values) } else { Axis::around(values) };
            let column = self.columns()[i];
            axis.labelled(column.title).unit(column.unit)
        };
        let mut front: Vec<[f64; 2]> = self.front(points).into_iter().filter_map(|i| places[i]).collect();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let colors = Colors::of(points, self.color);
        let trees = points.iter().zip(&places).filter_map(|(point, place)| {
            let [x, y] = (*place)?;
            let number = point.value(self.color).number().map(|n| n / self.color.shown_unit);
            Some(Point { x, y, color: colors.color(point), number, ..Point::default() })
        });
        let here = current.and_then(|config| {
            let at = points.iter().position(|p| same_tree(&p.config, config))?;
            places[at]
        });
        let trees = Series {
            points: trees.collect(),
            ..Series::new("trees", Mark::Dots { radius: 3.0, filled: true }, Ink::Muted)
        };
        let ring = Series::new("Pareto front", Mark::Dots { radius: 5.5, filled: false }, Ink::Second)
            .at(front.clone());
        let mut plot = Plot::new("Plot", axis(0), axis(1))
            .with(Series::new("front", Mark::Line { width: 1.5 }, Ink::Second).at(front).decoration())
            .with(ring)
            .with(trees);
        if let Some(here) = here {
            plot = plot
                .with(Series::new("current settings", Mark::Squares { radius: 7.0 }, Ink::Accent).at([here]));
        }
        plot.key = colors.key();
        plot
    }
}

/// Whether a figure's values lie so far apart that their logarithms show more.
pub fn spans_a_decade(points: &[SweepPoint], column: &Column) -> bool {
    ends(points, column).is_some_and(|[low, high]| low > 0.0 && high >= 10.0 * low)
}

fn ends(points: &[SweepPoint], column: &Column) -> Option<[f64; 2]> {
    let values = || points.iter().filter_map(|p| p.value(column).number());
    Some([values().reduce(f64::min)?, values().reduce(f64::max)?])
}

/// Colours of a figure from its least to its highest value.
struct Colors {
    column: &'static Column,
    ends: Option<[f64; 2]>,
}

impl Colors {
    fn of(points: &[SweepPoint], column: &'static Column) -> Self {
        Self { column, ends: ends(points, column) }
    }

    fn color(&self, point: &SweepPoint) -> Option<[u8; 3]> {
        let ([low, high], value) = (self.ends?, point.value(self.column).number()?);
        Some(at((value - low) / (high - low).max(f64::MIN_POSITIVE)))
    }

    fn key(&self) -> Option<ColorKey> {
        let ends = self.ends?.map(|value| self.column.show_number(value));
        let colors = (0..STEPS).map(|i| at((i as f64 + 0.5) / STEPS as f64)).collect();
        Some(ColorKey { label: self.column.heading(), ends, colors })
    }
}

/// Neither end of the map, which one of the looks would swallow.
fn at(t: f64) -> [u8; 3] {
    ColorMap::Viridis.color((0.12 + 0.8 * t.clamp(0.0, 1.0)) as f32)
}
