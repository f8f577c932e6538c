//! Plots as plain data: axes, and series of values with names, units and looks. The window draws them, `export` writes them
//! as pictures and tables.

mod axis;
pub mod splits;
pub mod tree;

pub use axis::{Axis, Scale, Tick};

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What it shows; unique within a panel.
    pub title: String,
    /// Of what: scene and settings, in a line; may be empty.
    pub subject: String,
    pub x: Axis,
    pub y: Axis,
    /// In the order of drawing.
    pub series: Vec<Series>,
    /// What colours of single points say.
    pub key: Option<ColorKey>,
}

/// Values that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Unique within a plot.
    pub name: String,
    pub mark: Mark,
    pub ink: Ink,
    /// 0 to 1.
    pub opacity: f32,
    pub points: Vec<Point>,
    /// Only guides the eye over values that another series has: not in legends and tables.
    pub decoration: bool,
}

/// How values are drawn. Sizes are in points of a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// Through all points, in order.
    Line {
        width: f32,
    },
    Dots {
        radius: f32,
        filled: bool,
    },
    Squares {
        radius: f32,
    },
    /// As wide as this, in units of the axis across; from the point's base up.
    Bars {
        width: f64,
    },
    /// Dashed, at the height of each point.
    Across,
    /// At the x of each point.
    Upright,
}

/// A value, or two for what lies in a plane. Values, not places: an axis' scale places them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// Where a bar begins; its `y` is where it ends.
    pub base: f64,
    /// Beside the series' ink: a colour of its own, and the number that it says.
    pub color: Option<[u8; 3]>,
    pub number: Option<f64>,
}

/// What a colour of the window means, so that each look has its own shade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ink {
    Accent,
    Second,
    Third,
    Muted,
    Color([u8; 3]),
}

impl Ink {
    /// On a dark or a light ground.
    pub const fn rgb(self, dark: bool) -> [u8; 3] {
        match (self, dark) {
            (Self::Accent, true) => [94, 178, 255],
            (Self::Accent, false) => [20, 104, 190],
            (Self::Second, true) => [255, 176, 84],
            (Self::Second, false) => [190, 100, 10],
            (Self::Third, true) => [150, 220, 140],
            (Self::Third, false) => [50, 130, 60],
            (Self::Muted, true) => [140, 146, 158],
            (Self::Muted, false) => [100, 106, 116],
            (Self::Color(rgb), _) => rgb,
        }
    }
}

/// A bar of colours with the numbers at its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorKey {
    pub label: String,
    /// How the two ends are written.
    pub ends: [String; 2],
    /// From one end to the other.
    pub colors: Vec<[u8; 3]>,
}

impl Plot {
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), subject: String::new(), x, y, series: Vec::new(), key: None }
    }

    pub fn of(self, subject: impl Into<String>) -> Self {
        Self { subject: subject.into(), ..self }
    }

    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds bars at whole numbers from `first` on, in parts that are stacked.
    pub fn with_stacked_bars<const PARTS: usize>(
        mut self,
        first: f64,
        parts: [(&str, Ink, Vec<f64>); PARTS],
    ) -> Self {
        let mut floor = vec![0.0; parts.iter().map(|part| part.2.len()).max().unwrap_or(0)];
        for (name, ink, heights) in parts {
            let points = heights.iter().zip(&mut floor).enumerate().map(|(i, (height, floor))| {
                let base = std::mem::replace(floor, *floor + height);
                Point { x: first + i as f64, y: base + height, base, ..Point::default() }
            });
            let points: Vec<Point> = points.collect();
            self.series.push(Series { points, ..Series::new(name, Mark::Bars { width: 0.8 }, ink) });
        }
        self
    }
}

impl Series {
    pub fn new(name: impl Into<String>, mark: Mark, ink: Ink) -> Self {
        Self { name: name.into(), mark, ink, opacity: 1.0, points: Vec::new(), decoration: false }
    }

    /// Through or at these points.
    pub fn at(self, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let points = points.into_iter().map(|[x, y]| Point { x, y, ..Point::default() }).collect();
        Self { points, ..self }
    }

    pub fn faint(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }

    pub fn decoration(self) -> Self {
        Self { decoration: true, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacked_bars_stand_on_each_other() {
        let plot = Plot::new("p", Axis::integers(1.0, 2.0, 4), Axis::from_zero(5.0))
            .with_stacked_bars(1.0, [("a", Ink::Accent, vec![1.0, 2.0]), ("b", Ink::Second, vec![3.0, 0.0])]);
        let ends = |i: usize| plot.series[i].points.iter().map(|p| (p.x, p.base, p.y)).collect::<Vec<_>>();
        assert_eq!(ends(0), [(1.0, 0.0, 1.0), (2.0, 0.0, 2.0)]);
        assert_eq!(ends(1), [(1.0, 1.0, 4.0), (2.0, 2.0, 2.0)]);
    }
}
