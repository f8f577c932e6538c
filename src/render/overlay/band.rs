//! A band of the picture's rows, into which boxes are drawn and tested against the surfaces' depth. Bands are drawn
//! side by side; what a pixel becomes does not depend on them.

use glam::{Vec3, Vec3A, Vec4};

use super::project::Projector;
use super::select::ShownBox;

/// Rows of a band.
pub const BAND_ROWS: u32 = 32;

/// A line or a side counts as visible as long as it lies no farther behind the surface than this share of the distance:
/// boxes touch what they hold, and their lines would flicker.
const DEPTH_BIAS: f32 = 2e-3;

/// In pixels.
const LINE_WIDTH: f32 = 1.2;

/// Pixels around an edge that its line may touch: half its width and half a pixel, both across a diagonal.
const LINE_REACH: f32 = 0.75 * (LINE_WIDTH + 1.0);

/// Opacity of what lies behind surfaces, where it is shown, against what lies before them.
const HIDDEN_ALPHA: f32 = 0.28;

/// Opacity of the lines of the smallest boxes, and of those of at least `LARGE` pixels (width + height): thousands of
/// small boxes would otherwise hide what they hold.
const LINE_ALPHA: [f32; 2] = [0.3, 0.95];
const LARGE: f32 = 64.0;

/// Opacity of the sides towards the viewer of the smallest boxes, and of one that fills the picture.
const FRONT_ALPHA: [f32; 2] = [0.34, 0.035];
/// Opacity of the sides away from the viewer, against those towards him.
const BACK_ALPHA: f32 = 0.35;
/// Opacity of the lines around sides, against lines alone.
const RIM_ALPHA: f32 = 0.6;

/// Brightness of the sides across x, y, z: as if lit from above.
const SIDE_SHADE: [f32; 3] = [0.82, 1.0, 0.68];

/// Rows above and below a band that its lines look at.
const MARGIN: u32 = 3;

/// What all bands draw on.
#[derive(Clone, Copy)]
pub struct Canvas<'a> {
    pub projector: &'a Projector,
    pub width: u32,
    pub height: u32,
    /// Distance along each pixel's ray to the first surface.
    pub depth: &'a [f32],
    pub show_hidden: bool,
}

/// A band with its own sums; reused from band to band.
pub struct Band<'a> {
    canvas: &'a Canvas<'a>,
    /// Rows `rows[0]..rows[1]`.
    rows: [u32; 2],
    /// Depth along the camera's forward axis at which a pixel's surface hides things, for the rows and a margin.
    surface: Vec<f32>,
    surface_row: u32,
    /// Premultiplied colour and alpha of what lies before the surfaces, and behind.
    above: Vec<Vec4>,
    below: Vec<Vec4>,
    /// `x` of the camera-space direction through each column.
    columns: Vec<f32>,
}

/// Where a pixel's ray is inside a box: depths along the forward axis, and the axes of the sides it passes there.
struct Span {
    enter: f32,
    enter_axis: usize,
    exit: f32,
    exit_axis: usize,
}

/// The depth along the forward axis up to which things are visible before a surface at this distance along the ray with
/// direction `(u, v, 1)`.
#[inline]
pub fn surface_depth(distance: f32, u: f32, v: f32) -> f32 {
    let depth = distance / (1.0 + u * u + v * v).sqrt();
    if depth.is_nan() { f32::INFINITY } else { depth * (1.0 + DEPTH_BIAS) }
}

impl<'a> Band<'a> {
    pub fn new(canvas: &'a Canvas<'a>) -> Self {
        Self {
            canvas,
            rows: [0, 0],
            surface: Vec::new(),
            surface_row: 0,
            above: Vec::new(),
            below: Vec::new(),
            columns: (0..canvas.width).map(|x| canvas.projector.column_direction(x)).collect(),
        }
    }

    /// Starts the band whose first row is `row`.
    pub fn begin(&mut self, row: u32) {
        let Canvas { width, height, depth, show_hidden, .. } = *self.canvas;
        self.rows = [row, (row + BAND_ROWS).min(height)];
        let size = (self.rows[1] - row) as usize * width as usize;
        self.above.clear();
        self.above.resize(size, Vec4::ZERO);
        self.below.clear();
        self.below.resize(if show_hidden { size } else { 0 }, Vec4::ZERO);
        self.surface_row = row.saturating_sub(MARGIN);
        self.surface.clear();
        for y in self.surface_row..(self.rows[1] + MARGIN).min(height) {
            let v = self.canvas.projector.row_direction(y);
            let distances = &depth[y as usize * width as usize..][..width as usize];
            self.surface.extend(self.columns.iter().zip(distances).map(|(&u, &d)| surface_depth(d, u, v)));
        }
    }

    /// The edges of a box.
    pub fn outline_box(&mut self, shown: &ShownBox, color: [u8; 3]) {
        self.draw_edges(shown, rgb(color), line_alpha(shown));
    }

    /// The sides of a box, translucent, and its edges.
    pub fn fill_box(&mut self, shown: &ShownBox, color: [u8; 3]) {
        let color = rgb(color);
        let shades = SIDE_SHADE.map(|shade| color * shade);
        // The more of the picture a side covers, the less it takes to be seen.
        let covered = shown.size / (self.canvas.width + self.canvas.height) as f32;
        let front = mix(FRONT_ALPHA, covered.sqrt());
        self.for_each_pixel_inside(shown, |band, pixel, surface, span| {
            // A flat box has one side only.
            if span.exit > span.enter {
                band.blend(pixel, shades[span.exit_axis], BACK_ALPHA * front, span.exit <= surface);
            }
            if span.enter > 0.0 {
                band.blend(pixel, shades[span.enter_axis], front, span.enter <= surface);
            }
        });
        self.draw_edges(shown, color, RIM_ALPHA * line_alpha(shown));
    }

    /// Adds one to the count of every pixel over which the box lies.
    pub fn count_box(&mut self, shown: &ShownBox, counts: &mut [u32]) {
        self.for_each_pixel_inside(shown, |_, pixel, _, _| counts[pixel] += 1);
    }

    /// Writes the band's pixels: premultiplied, 8 bits.
    pub fn finish(&self, pixels: &mut [u8]) {
        for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
            let above = self.above[i];
            let below = self.below.get(i).copied().unwrap_or(Vec4::ZERO);
            let sum = (above + below * (1.0 - above.w)) * 255.0 + 0.5;
            let alpha = sum.w as u8;
            pixel.copy_from_slice(&[
                (sum.x as u8).min(alpha),
                (sum.y as u8).min(alpha),
                (sum.z as u8).min(alpha),
                alpha,
            ]);
        }
    }

    /// Lays a colour over a pixel of the band, before the surfaces or behind them.
    #[inline]
    fn blend(&mut self, pixel: usize, color: Vec3, alpha: f32, visible: bool) {
        let (sum, alpha) = if visible {
            (&mut self.above[pixel], alpha)
        } else if self.canvas.show_hidden {
            (&mut self.below[pixel], alpha * HIDDEN_ALPHA)
        } else {
            return;
        };
        *sum = color.extend(1.0) * alpha + *sum * (1.0 - alpha);
    }

    /// Calls `visit` with the index in the band, the surface's depth, and the span, of every pixel whose centre's ray
    /// meets the box where it is to be drawn.
    fn for_each_pixel_inside(
        &mut self,
        shown: &ShownBox,
        mut visit: impl FnMut(&mut Self, usize, f32, Span),
    ) {
        let frame = self.canvas.projector.frame;
        let all = self.canvas.show_hidden;
        let [min, max] = [shown.bounds.min, shown.bounds.max].map(|corner| Vec3A::from(corner - frame.eye));
        let right = Vec3A::from(frame.right);
        let first = u32::from(shown.rect.min[1]).max(self.rows[0]);
        let end = u32::from(shown.rect.max[1]).min(self.rows[1]);
        for y in first..end {
            let row = Vec3A::from(frame.forward + self.canvas.projector.row_direction(y) * frame.up);
            let pixel_row = (y - self.rows[0]) as usize * self.canvas.width as usize;
            let surface_row = (y - self.surface_row) as usize * self.canvas.width as usize;
            for x in usize::from(shown.rect.min[0])..usize::from(shown.rect.max[0]) {
                let inv = (row + self.columns[x] * right).recip();
                let (a, b) = (min * inv, max * inv);
                let (near, far) = (a.min(b), a.max(b));
                let (enter, exit) = (near.max_element(), far.min_element());
                let surface = self.surface[surface_row + x];
                if enter <= exit && exit > 0.0 && (all || enter <= surface) {
                    let axis = |side: Vec3A, at: f32| side.cmpeq(Vec3A::splat(at)).bitmask().trailing_zeros();
                    let [enter_axis, exit_axis] =
                        [axis(near, enter), axis(far, exit)].map(|a| a.min(2) as usize);
                    visit(self, pixel_row + x, surface, Span { enter, enter_axis, exit, exit_axis });
                }
            }
        }
    }

    fn draw_edges(&mut self, shown: &ShownBox, color: Vec3, alpha: f32) {
        let projector = self.canvas.projector;
        let rows = [self.rows[0] as f32 - LINE_REACH, self.rows[1] as f32 + LINE_REACH];
        projector.edges(&shown.bounds, shown.clipped, |a, b| {
            if a.y.max(b.y) < rows[0] || a.y.min(b.y) > rows[1] {
                return;
            }
            if (b.x - a.x).abs() >= (b.y - a.y).abs() {
                self.draw_line::<false>(a, b, color, alpha);
            } else {
                self.draw_line::<true>(a, b, color, alpha);
            }
        });
    }

    /// An antialiased line between two points of the screen with 1 / depth as z. `STEEP`: steps along y, else along x.
    fn draw_line<const STEEP: bool>(&mut self, a: Vec3, b: Vec3, color: Vec3, alpha: f32) {
        let turn = |p: Vec3| if STEEP { Vec3::new(p.y, p.x, p.z) } else { p };
        let (a, b) = (turn(a), turn(b));
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let along = b - a;
        // Seen head-on it is a point, which the edges that it joins draw.
        if along.x.is_nan() || along.x <= 1e-3 {
            return;
        }
        let (slope, inv_depth_slope) = (along.y / along.x, along.z / along.x);
        let cos = 1.0 / (1.0 + slope * slope).sqrt();
        // Half a line width beyond both ends, so that lines join at corners.
        let cap = 0.5 * LINE_WIDTH * cos;
        let ends = [a.x - cap, b.x + cap];
        let reach = (0.5 * LINE_WIDTH + 0.5) / cos;
        let Some([first, end]) = self.line_steps::<STEEP>(a, slope, ends, reach) else { return };
        let lane_range = if STEEP { [0, self.canvas.width] } else { self.rows };
        for step in first..end {
            let [from, to] = [ends[0].max(step as f32), ends[1].min(step as f32 + 1.0)];
            let middle = 0.5 * (from + to) - a.x;
            let across = a.y + middle * slope;
            let lanes = [across - reach, across + reach].map(|v| (v + 0.5).max(0.0) as u32);
            let lanes = lanes[0].max(lane_range[0])..lanes[1].min(lane_range[1]);
            if lanes.is_empty() {
                continue;
            }
            let depth = 1.0 / (a.z + middle.clamp(0.0, along.x) * inv_depth_slope);
            let visible = depth <= self.surface_beside::<STEEP>(step, across);
            for lane in lanes {
                let distance = (lane as f32 + 0.5 - across).abs() * cos;
                let cover = (0.5 * LINE_WIDTH + 0.5 - distance).clamp(0.0, 1.0) * (to - from);
                let (x, y) = if STEEP { (lane, step) } else { (step, lane) };
                let pixel = ((y - self.rows[0]) * self.canvas.width + x) as usize;
                self.blend(pixel, color, alpha * cover, visible);
            }
        }
    }

    /// The steps along a line at which it may touch the band.
    fn line_steps<const STEEP: bool>(
        &self,
        a: Vec3,
        slope: f32,
        ends: [f32; 2],
        reach: f32,
    ) -> Option<[u32; 2]> {
        let rows = self.rows.map(|y| y as f32);
        let [mut from, mut to] = ends;
        if STEEP {
            (from, to) = (from.max(rows[0]), to.min(rows[1]));
        } else {
            (from, to) = (from.max(0.0), to.min(self.canvas.width as f32));
            let bounds = [rows[0] - reach, rows[1] + reach];
            if slope.abs() > 1e-6 {
                let at = bounds.map(|y| a.x + (y - a.y) / slope);
                (from, to) = (from.max(at[0].min(at[1]) - 1.0), to.min(at[0].max(at[1]) + 1.0));
            } else if a.y < bounds[0] || a.y > bounds[1] {
                return None;
            }
        }
        (from < to).then(|| [from as u32, to.ceil() as u32])
    }

    /// The depth up to which a line is visible at `step`, where it passes `across` between two pixels' centres: that of
    /// the farther one, since a surface that the line lies on may tilt away between them.
    #[inline]
    fn surface_beside<const STEEP: bool>(&self, step: u32, across: f32) -> f32 {
        let Canvas { width, height, .. } = *self.canvas;
        // The casts take what is below 0 to 0.
        let lanes = [across - 0.5, across + 0.5].map(|lane| lane as u32);
        let at = |lane: u32| {
            let (x, y) = if STEEP { (lane.min(width - 1), step) } else { (step, lane.min(height - 1)) };
            self.surface[((y - self.surface_row) * width + x) as usize]
        };
        at(lanes[0]).max(at(lanes[1]))
    }
}

fn line_alpha(shown: &ShownBox) -> f32 {
    mix(LINE_ALPHA, shown.size / LARGE)
}

/// From the first to the second as `t` goes from 0 to 1, clamped.
fn mix([from, to]: [f32; 2], t: f32) -> f32 {
    from + (to - from) * t.clamp(0.0, 1.0)
}

fn rgb(color: [u8; 3]) -> Vec3 {
    Vec3::from_array(color.map(|c| f32::from(c) / 255.0))
}
