//! A plot as an SVG drawing: title, axes, series, legend. Sizes are in the drawing's units.

use std::fmt::Write as _;

use crate::inspect::plot::{Axis, ColorKey, Ink, Mark, Plot, Point, Series};

const SIZE: [f64; 2] = [800.0, 480.0];
/// Left, top, right and bottom of the area within the axes.
const MARGINS: [f64; 4] = [76.0, 64.0, 24.0, 58.0];
const TITLE: f64 = 19.0;
const LETTER: f64 = 13.0;
/// Width of a letter in the mean, as a share of its height: enough for where things of a legend begin.
const LETTER_WIDTH: f64 = 0.52;
/// What is a point on the screen is so much here, where all is larger.
const SCREEN: f64 = 1.5;

/// The colours of ground and letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    Dark,
    Light,
    /// Within a page: no ground, and letters in the page's colour.
    Page,
}

impl Look {
    pub fn of(dark: bool) -> Self {
        if dark { Self::Dark } else { Self::Light }
    }

    fn ground(self) -> Option<&'static str> {
        match self {
            Self::Dark => Some("#131519"),
            Self::Light => Some("#ffffff"),
            Self::Page => None,
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Dark => "#e2e5ea",
            Self::Light => "#1a1c20",
            Self::Page => "currentColor",
        }
    }

    /// On a page either ground may come: the shades of the dark one are seen on both.
    fn ink(self, ink: Ink) -> String {
        let [r, g, b] = match self {
            Self::Dark => ink.rgb(true),
            Self::Light => ink.rgb(false),
            Self::Page => {
                let (dark, light) = (ink.rgb(true), ink.rgb(false));
                [0, 1, 2].map(|i| ((u16::from(dark[i]) + u16::from(light[i])) / 2) as u8)
            }
        };
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// The drawing.
pub fn svg(plot: &Plot, look: Look) -> String {
    let mut out = Drawing { text: String::new(), look };
    let [width, height] = SIZE;
    out.line(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"Ubuntu, system-ui, sans-serif\" font-size=\"{LETTER}\" fill=\"{}\">",
        look.text()
    ));
    out.line(&format!("<title>{}</title>", escaped(&plot.title)));
    if let Some(ground) = look.ground() {
        out.line(&format!("<rect width=\"{width}\" height=\"{height}\" fill=\"{ground}\"/>"));
    }
    let area = Area { plot };
    heading(&mut out, plot);
    axes(&mut out, &area);
    let [left, top, right, bottom] = area.edges();
    out.line(&format!(
        "<clipPath id=\"area\"><rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\"/></clipPath>",
        right - left,
        bottom - top
    ));
    out.line("<g clip-path=\"url(#area)\">");
    for series in &plot.series {
        draw(&mut out, &area, series);
    }
    out.line("</g>");
    out.line("</svg>");
    out.text
}

struct Drawing {
    text: String,
    look: Look,
}

impl Drawing {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Letters at a place; `more` are further attributes.
    fn letters(&mut self, [x, y]: [f64; 2], text: &str, more: &str) {
        self.line(&format!("<text x=\"{}\" y=\"{}\" {more}>{}</text>", short(x), short(y), escaped(text)));
    }
}

/// Where values lie in the drawing.
struct Area<'a> {
    plot: &'a Plot,
}

impl Area<'_> {
    fn edges(&self) -> [f64; 4] {
        [MARGINS[0], MARGINS[1], SIZE[0] - MARGINS[2], SIZE[1] - MARGINS[3]]
    }

    fn across(&self, place: f64) -> f64 {
        let [left, _, right, _] = self.edges();
        left + share(place, &self.plot.x) * (right - left)
    }

    fn up(&self, place: f64) -> f64 {
        let [_, top, _, bottom] = self.edges();
        bottom - share(place, &self.plot.y) * (bottom - top)
    }

    fn point(&self, point: &Point) -> [f64; 2] {
        let (x, y) = (self.plot.x.scale.place(point.x), self.plot.y.scale.place(point.y));
        [self.across(x), self.up(y)]
    }
}

/// How far along an axis a place is; what is not finite is at its start.
fn share(place: f64, axis: &Axis) -> f64 {
    let [low, high] = axis.range;
    let share = (place - low) / (high - low);
    // Far outside is as good as anywhere outside, and stays a short number.
    if share.is_finite() { share.clamp(-10.0, 10.0) } else { 0.0 }
}

fn heading(out: &mut Drawing, plot: &Plot) {
    let left = 16.0;
    out.letters([left, 28.0], &plot.title, &format!("font-size=\"{TITLE}\""));
    let end = SIZE[0] - MARGINS[2];
    if !plot.subject.is_empty() {
        out.letters([end, 28.0], &plot.subject, "text-anchor=\"end\" opacity=\"0.65\"");
    }
    let named: Vec<&Series> = plot.series.iter().filter(|series| !series.decoration).collect();
    let mut x = left;
    if named.len() > 1 {
        for series in named {
            legend_mark(out, [x, 48.0 - 0.35 * LETTER], series);
            x += 20.0;
            out.letters([x, 48.0], &series.name, "opacity=\"0.85\"");
            x += series.name.chars().count() as f64 * LETTER * LETTER_WIDTH + 20.0;
        }
    }
    if let Some(key) = &plot.key {
        color_key(out, [end, 48.0], key);
    }
}

/// A series' mark beside its name.
fn legend_mark(out: &mut Drawing, [x, y]: [f64; 2], series: &Series) {
    let ink = out.look.ink(series.ink);
    let opacity = series.opacity;
    let middle = x + 7.0;
    let line = match series.mark {
        Mark::Line { width } => format!(
            "<line x1=\"{x}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"{ink}\" stroke-width=\"{}\" opacity=\"{opacity}\"/>",
            x + 14.0,
            f64::from(width) * SCREEN
        ),
        Mark::Across => format!(
            "<line x1=\"{x}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"{ink}\" stroke-dasharray=\"4 3\" stroke-width=\"1.5\"/>",
            x + 14.0
        ),
        Mark::Upright => format!(
            "<line x1=\"{middle}\" y1=\"{}\" x2=\"{middle}\" y2=\"{}\" stroke=\"{ink}\" stroke-width=\"2.2\"/>",
            y - 6.0,
            y + 6.0
        ),
        Mark::Dots { filled, .. } => dot([middle, y], 4.5, filled, &ink, opacity),
        Mark::Squares { .. } => square([middle, y], 5.0, &ink),
        Mark::Bars { .. } => format!(
            "<rect x=\"{}\" y=\"{}\" width=\"10\" height=\"10\" fill=\"{ink}\" opacity=\"{opacity}\"/>",
            x + 2.0,
            y - 5.0
        ),
    };
    out.line(&line);
}

/// What colours say, up to the right end.
fn color_key(out: &mut Drawing, [end, y]: [f64; 2], key: &ColorKey) {
    let width = 120.0;
    let ends =
        [&key.ends[0], &key.ends[1]].map(|text| text.chars().count() as f64 * LETTER * LETTER_WIDTH + 8.0);
    out.letters([end, y], &key.ends[1], "text-anchor=\"end\" opacity=\"0.85\"");
    let left = end - ends[1] - width;
    let count = key.colors.len().max(1) as f64;
    for (i, [r, g, b]) in key.colors.iter().enumerate() {
        let x = left + width * i as f64 / count;
        out.line(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"9\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            short(x),
            y - 9.0,
            short(width / count + 0.6)
        ));
    }
    out.letters([left - 8.0, y], &key.ends[0], "text-anchor=\"end\" opacity=\"0.85\"");
    out.letters([left - 8.0 - ends[0] - 8.0, y], &key.label, "text-anchor=\"end\" opacity=\"0.65\"");
}

fn axes(out: &mut Drawing, area: &Area) {
    let [left, top, right, bottom] = area.edges();
    let mut rules = String::new();
    for tick in &area.plot.x.ticks {
        let x = short(area.across(tick.at));
        write!(rules, "M{x} {top}V{bottom}").expect("memory takes all text");
    }
    for tick in &area.plot.y.ticks {
        let y = short(area.up(tick.at));
        write!(rules, "M{left} {y}H{right}").expect("memory takes all text");
    }
    let ink = out.look.text();
    out.line(&format!("<path d=\"{rules}\" stroke=\"{ink}\" stroke-opacity=\"0.13\" fill=\"none\"/>"));
    out.line(&format!(
        "<path d=\"M{left} {top}V{bottom}H{right}\" stroke=\"{ink}\" stroke-opacity=\"0.45\" fill=\"none\"/>"
    ));
    for tick in &area.plot.x.ticks {
        out.letters(
            [area.across(tick.at), bottom + 19.0],
            &tick.text,
            "text-anchor=\"middle\" opacity=\"0.8\"",
        );
    }
    for tick in &area.plot.y.ticks {
        let y = area.up(tick.at) + 0.35 * LETTER;
        out.letters([left - 8.0, y], &tick.text, "text-anchor=\"end\" opacity=\"0.8\"");
    }
    let x_name = area.plot.x.heading();
    out.letters([0.5 * (left + right), bottom + 43.0], &x_name, "text-anchor=\"middle\"");
    let y_name = area.plot.y.heading();
    let middle = 0.5 * (top + bottom);
    out.letters(
        [18.0, middle],
        &y_name,
        &format!("text-anchor=\"middle\" transform=\"rotate(-90 18 {middle})\""),
    );
}

fn draw(out: &mut Drawing, area: &Area, series: &Series) {
    let ink = out.look.ink(series.ink);
    let opacity = series.opacity;
    let [left, top, right, bottom] = area.edges();
    match series.mark {
        Mark::Line { width } => {
            let points: Vec<String> = series
                .points
                .iter()
                .map(|p| area.point(p))
                .map(|[x, y]| format!("{},{}", short(x), short(y)))
                .collect();
            out.line(&format!(
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"{}\" stroke-linejoin=\"round\" \
                 opacity=\"{opacity}\"/>",
                points.join(" "),
                f64::from(width) * SCREEN
            ));
        }
        Mark::Dots { radius, filled } => {
            for point in &series.points {
                let own = point.color.map_or_else(|| ink.clone(), |rgb| out.look.ink(Ink::Color(rgb)));
                out.line(&dot(area.point(point), f64::from(radius) * SCREEN, filled, &own, opacity));
            }
        }
        Mark::Squares { radius } => {
            for point in &series.points {
                out.line(&square(area.point(point), f64::from(radius) * SCREEN, &ink));
            }
        }
        Mark::Bars { width } => {
            for point in series.points.iter().filter(|p| p.y > p.base) {
                let from = area.across(area.plot.x.scale.place(point.x) - 0.5 * width);
                let to = area.across(area.plot.x.scale.place(point.x) + 0.5 * width);
                let (high, low) = (area.point(point)[1], area.up(area.plot.y.scale.place(point.base)));
                out.line(&format!(
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{ink}\" opacity=\"{opacity}\"/>",
                    short(from),
                    short(high),
                    short(to - from),
                    short(low - high)
                ));
            }
        }
        Mark::Across => {
            for y in series.points.iter().map(|p| short(area.point(p)[1])) {
                out.line(&format!(
                    "<line x1=\"{left}\" y1=\"{y}\" x2=\"{right}\" y2=\"{y}\" stroke=\"{ink}\" stroke-width=\"1.5\" \
                     stroke-dasharray=\"6 4\" opacity=\"{opacity}\"/>"
                ));
            }
        }
        Mark::Upright => {
            for x in series.points.iter().map(|p| short(area.point(p)[0])) {
                out.line(&format!(
                    "<line x1=\"{x}\" y1=\"{top}\" x2=\"{x}\" y2=\"{bottom}\" stroke=\"{ink}\" stroke-width=\"2.2\" \
                     opacity=\"{opacity}\"/>"
                ));
            }
        }
    }
}

fn dot([x, y]: [f64; 2], radius: f64, filled: bool, ink: &str, opacity: f32) -> String {
    let paint = if filled {
        format!("fill=\"{ink}\"")
    } else {
        format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.5\"")
    };
    format!("<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" {paint} opacity=\"{opacity}\"/>", short(x), short(y))
}

fn square([x, y]: [f64; 2], radius: f64, ink: &str) -> String {
    let side = 2.0 * radius;
    format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{side}\" height=\"{side}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"1.5\"/>",
        short(x - radius),
        short(y - radius)
    )
}

/// A coordinate with two decimals at most.
fn short(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
