//! Draws the chosen boxes in bands of rows, side by side, in one order; the same picture at any thread count.

use image::RgbaImage;
use rayon::prelude::*;

use super::band::{BAND_ROWS, Band, Canvas};
use super::hidden::FarthestSurfaces;
use super::project::Projector;
use super::select::{Selection, ShownBox, Stage, select};
use super::{BoxStyle, NodesShown, Overlay, OverlaySettings};
use crate::accel::Tree;
use crate::render::display::ColorMap;
use crate::scene::camera::CameraFrame;
use crate::task::{Cancelled, Task};

/// Through which the density of boxes is shown, on a logarithmic scale.
pub const DENSITY_MAP: ColorMap = ColorMap::Inferno;

/// Opacity of the density where the fewest and where the most boxes lie.
const DENSITY_ALPHA: [f32; 2] = [0.62, 0.94];

/// Where a number of boxes lies on the colour map of a density ([`Overlay::density_range`]), in 0..=1: logarithmic, from
/// the fewest over any pixel on, since all pixels of a room share the boxes around it.
pub fn density_position(n: u32, [fewest, most]: [u32; 2]) -> f32 {
    let scale = |n: u32| (n.max(fewest) as f32).ln_1p() - (fewest as f32).ln_1p();
    if most > fewest { (scale(n) / scale(most)).min(1.0) } else { 0.0 }
}

/// Draws the boxes of a tree. `nodes`: as in [`select`].
pub fn draw_tree(
    tree: &Tree,
    nodes: NodesShown,
    frame: CameraFrame,
    settings: &OverlaySettings,
    depth: &[f32],
    task: &Task,
) -> Result<Overlay, Cancelled> {
    let (width, height) = (frame.size.x as u32, frame.size.y as u32);
    assert_eq!(depth.len(), width as usize * height as usize, "one distance a pixel");
    let projector = Projector::new(frame, &tree.bounds());
    let surfaces = (!settings.show_hidden).then(|| FarthestSurfaces::new(&projector, depth));
    let stage = Stage { projector: &projector, surfaces: surfaces.as_ref() };
    let selection = select(tree, nodes, stage, settings, task)?;
    let mut overlay = Overlay {
        image: RgbaImage::new(width, height),
        selected: selection.selected,
        drawn: selection.boxes.len() + selection.hidden,
        outside: selection.outside,
        too_small: selection.too_small,
        over_budget: selection.over_budget,
        color_range: selection.color_range.filter(|_| settings.style != BoxStyle::Density),
        density_range: None,
    };
    // Otherwise all are outside, too small, or hidden.
    if !selection.boxes.is_empty() {
        let canvas =
            Canvas { projector: &projector, width, height, depth, show_hidden: settings.show_hidden };
        overlay.density_range = draw_selection(&canvas, &selection, settings, &mut overlay.image, task)?;
    } else if settings.style == BoxStyle::Density {
        overlay.density_range = Some([0, 0]);
    }
    Ok(overlay)
}

/// Returns the fewest and the most boxes over one pixel, if the style asks for it.
fn draw_selection(
    canvas: &Canvas,
    selection: &Selection,
    settings: &OverlaySettings,
    image: &mut RgbaImage,
    task: &Task,
) -> Result<Option<[u32; 2]>, Cancelled> {
    match settings.style {
        BoxStyle::Wire | BoxStyle::Fill => {
            draw_lines_and_sides(canvas, selection, settings, image, task).map(|()| None)
        }
        BoxStyle::Density => draw_density(canvas, selection, image, task).map(Some),
    }
}

fn draw_lines_and_sides(
    canvas: &Canvas,
    selection: &Selection,
    settings: &OverlaySettings,
    image: &mut RgbaImage,
    task: &Task,
) -> Result<(), Cancelled> {
    let range = selection.color_range.unwrap_or([0.0, 1.0]);
    let fill = settings.style == BoxStyle::Fill;
    let rows = 4 * canvas.width as usize * BAND_ROWS as usize;
    let bins = bin_by_band(canvas, &selection.boxes);
    let bands = image.par_chunks_mut(rows).zip(bins).enumerate();
    bands.try_for_each_init(
        || Band::new(canvas),
        |band, (i, (pixels, bin))| {
            band.begin(i as u32 * BAND_ROWS);
            for (n, &box_idx) in bin.iter().enumerate() {
                if n % 64 == 0 {
                    task.check()?;
                }
                let shown = &selection.boxes[box_idx as usize];
                let color = settings.color.color(shown.value, range);
                if fill {
                    band.fill_box(shown, color);
                } else {
                    band.outline_box(shown, color);
                }
            }
            band.finish(pixels);
            Ok(())
        },
    )
}

/// Returns the fewest and the most boxes over one pixel.
fn draw_density(
    canvas: &Canvas,
    selection: &Selection,
    image: &mut RgbaImage,
    task: &Task,
) -> Result<[u32; 2], Cancelled> {
    let mut counts = vec![0u32; canvas.depth.len()];
    let bins = bin_by_band(canvas, &selection.boxes);
    let rows = canvas.width as usize * BAND_ROWS as usize;
    counts.par_chunks_mut(rows).zip(bins).enumerate().try_for_each_init(
        || Band::new(canvas),
        |band, (i, (counts, bin))| {
            band.begin(i as u32 * BAND_ROWS);
            for (n, &box_idx) in bin.iter().enumerate() {
                if n % 64 == 0 {
                    task.check()?;
                }
                band.count_box(&selection.boxes[box_idx as usize], counts);
            }
            Ok(())
        },
    )?;
    let range = [counts.par_iter().min(), counts.par_iter().max()].map(|n| n.copied().unwrap_or(0));
    let colors: Vec<[u8; 4]> = (0..=range[1]).map(|n| density_color(n, range)).collect();
    let pixels: &mut [[u8; 4]] = bytemuck::cast_slice_mut(image.as_mut());
    pixels.par_iter_mut().zip(&counts).for_each(|(pixel, &n)| *pixel = colors[n as usize]);
    Ok(range)
}

/// Premultiplied; nothing where there is no box.
fn density_color(n: u32, range: [u32; 2]) -> [u8; 4] {
    if n == 0 {
        return [0; 4];
    }
    let t = density_position(n, range);
    let alpha = DENSITY_ALPHA[0] + t * (DENSITY_ALPHA[1] - DENSITY_ALPHA[0]);
    let [r, g, b] = DENSITY_MAP.color(t).map(|c| (f32::from(c) * alpha) as u8);
    [r, g, b, (255.0 * alpha) as u8]
}

/// For each band of rows, the boxes that touch it, in their order.
fn bin_by_band(canvas: &Canvas, boxes: &[ShownBox]) -> Vec<Vec<u32>> {
    let mut bins = vec![Vec::new(); canvas.height.div_ceil(BAND_ROWS) as usize];
    for (i, shown) in boxes.iter().enumerate() {
        let [first, end] = [shown.rect.min[1], shown.rect.max[1]].map(u32::from);
        for bin in &mut bins[(first / BAND_ROWS) as usize..end.div_ceil(BAND_ROWS) as usize] {
            bin.push(i as u32);
        }
    }
    bins
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::project::tests::front_frame;
    use super::*;
    use crate::accel::quality::nodes;
    use crate::accel::tree::LeafRange;
    use crate::accel::{BuildConfig, ChildRef, WideBvh, Width, tree::WideNode};
    use crate::geometry::Aabb;
    use crate::world::NodeFigure;

    const SIDE: usize = 100;

    /// Two leaves side by side, each a cube of side 2 before the eye at depth 4 to 6, below a root.
    fn pair() -> Tree {
        let boxes = [cube(Vec3::new(-1.5, 0.0, -5.0)), cube(Vec3::new(1.5, 0.0, -5.0))];
        let mut node = WideNode { children: [ChildRef::leaf(0), ChildRef::leaf(1)], ..WideNode::EMPTY };
        boxes.iter().enumerate().for_each(|(slot, bounds)| node.set_bounds(slot, bounds));
        Tree::W2(WideBvh {
            root: ChildRef::inner(0),
            bounds: boxes[0].union(boxes[1]),
            nodes: vec![node],
            leaves: vec![LeafRange { first: 0, count: 1 }, LeafRange { first: 1, count: 3 }],
            refs: vec![0, 1, 2, 3],
            depth_max: 1,
        })
    }

    fn cube(center: Vec3) -> Aabb {
        Aabb::new(center - 1.0, center + 1.0)
    }

    fn settings(style: BoxStyle) -> OverlaySettings {
        OverlaySettings { depths: Some([0, 9]), style, ..OverlaySettings::default() }
    }

    /// Distances to a wall at this depth along the camera's axis.
    fn wall(z: f32) -> Vec<f32> {
        let frame = front_frame();
        let pixels = (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5);
        pixels.map(|p| z / frame.ray(p).direction.dot(frame.forward)).collect()
    }

    fn draw(tree: &Tree, settings: &OverlaySettings, depth: &[f32]) -> Overlay {
        let values = match settings.color {
            NodeFigure::LeafSize => nodes::leaf_sizes(tree),
            NodeFigure::Fill => nodes::fills(tree),
            _ => nodes::sah_shares(tree, 1.0, 1.0),
        };
        draw_tree(
            tree,
            NodesShown { values: &values, shown: None },
            front_frame(),
            settings,
            depth,
            &Task::new(),
        )
        .expect("nobody cancels")
    }

    fn alpha(overlay: &Overlay, x: u32, y: u32) -> u8 {
        overlay.image.get_pixel(x, y)[3]
    }

    fn painted(overlay: &Overlay) -> usize {
        overlay.image.pixels().filter(|p| p[3] > 0).count()
    }

    #[test]
    fn without_a_range_of_depths_nothing_is_drawn() {
        let overlay = draw(&pair(), &OverlaySettings::default(), &wall(50.0));
        assert_eq!((overlay.selected, overlay.drawn, painted(&overlay)), (0, 0, 0));
    }

    #[test]
    fn depth_range_and_leaves_only_select() {
        let far = wall(50.0);
        let count = |settings: OverlaySettings| {
            let o = draw(&pair(), &settings, &far);
            assert_eq!(o.selected, o.drawn + o.outside + o.too_small + o.over_budget);
            (o.selected, o.drawn)
        };
        let all = settings(BoxStyle::Wire);
        assert_eq!(count(all), (3, 3));
        assert_eq!(count(OverlaySettings { depths: Some([0, 0]), ..all }), (1, 1));
        assert_eq!(count(OverlaySettings { depths: Some([1, 1]), ..all }), (2, 2));
        assert_eq!(count(OverlaySettings { leaves_only: true, ..all }), (2, 2));
        assert_eq!(count(OverlaySettings { depths: Some([5, 9]), ..all }), (0, 0));
    }

    #[test]
    fn the_budget_keeps_the_largest() {
        let one = OverlaySettings { budget: 1, ..settings(BoxStyle::Wire) };
        let overlay = draw(&pair(), &one, &wall(50.0));
        assert_eq!((overlay.drawn, overlay.over_budget), (1, 2));
        let root = OverlaySettings { depths: Some([0, 0]), ..settings(BoxStyle::Wire) };
        assert_eq!(painted(&overlay), painted(&draw(&pair(), &root, &wall(50.0))), "the root is left");
        assert_eq!(overlay.color_range, Some([0.0, 1.0]), "colours mean the same as with a larger budget");
        let none = draw(&pair(), &OverlaySettings { budget: 0, ..one }, &wall(50.0));
        assert_eq!((none.drawn, none.over_budget, painted(&none)), (0, 3, 0));
    }

    /// The near side of the left cube reaches from x = 18.75 to 43.75 and from y = 37.5 to 62.5.
    #[test]
    fn edges_lie_where_the_camera_sees_them() {
        let leaves = OverlaySettings { leaves_only: true, ..settings(BoxStyle::Wire) };
        let overlay = draw(&pair(), &leaves, &wall(50.0));
        for y in 38..62 {
            assert!(alpha(&overlay, 18, y) > 60, "near left edge at row {y}");
            assert!(alpha(&overlay, 43, y) > 60, "near right edge at row {y}");
        }
        for x in 19..43 {
            assert!(alpha(&overlay, x, 37).max(alpha(&overlay, x, 36)) > 60, "near top edge at column {x}");
        }
        assert_eq!(alpha(&overlay, 10, 50), 0);
        assert_eq!(alpha(&overlay, 22, 55), 0, "inside a side there is nothing");
        let mirrored =
            |x: u32, y: u32| i32::from(alpha(&overlay, x, y)) - i32::from(alpha(&overlay, 99 - x, y));
        assert!((0..50).all(|x| (0..100).all(|y| mirrored(x, y).abs() <= 2)), "two cubes, two equal halves");
    }

    #[test]
    fn what_a_wall_hides_is_dropped_or_dimmed() {
        let wire = settings(BoxStyle::Wire);
        let through = OverlaySettings { show_hidden: true, ..wire };
        let before = painted(&draw(&pair(), &wire, &wall(50.0)));
        let behind = draw(&pair(), &wire, &wall(2.0));
        assert_eq!((behind.drawn, painted(&behind)), (3, 0), "all behind the wall");
        let dimmed = draw(&pair(), &through, &wall(2.0));
        let open = draw(&pair(), &through, &wall(50.0));
        assert_eq!(painted(&dimmed), before);
        assert!(u32::from(alpha(&dimmed, 18, 50)) * 2 < u32::from(alpha(&open, 18, 50)));
        // The wall cuts the cubes: their near edges are seen, the far ones not.
        let cut = draw(&pair(), &wire, &wall(5.0));
        assert!(alpha(&cut, 18, 50) > 60 && painted(&cut) < before);
        assert!(before > 300);
    }

    #[test]
    fn a_line_on_a_surface_is_visible_also_when_the_surface_tilts() {
        // A floor at y = -1: the lower sides of the cubes lie in it.
        let frame = front_frame();
        let floor: Vec<f32> = (0..SIDE * SIDE)
            .map(|i| {
                let down = -frame.ray(Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5).direction.y;
                if down > 0.0 { 1.0 / down } else { f32::INFINITY }
            })
            .collect();
        let root = OverlaySettings { depths: Some([0, 0]), ..settings(BoxStyle::Wire) };
        let (with, without) = (draw(&pair(), &root, &floor), draw(&pair(), &root, &wall(50.0)));
        // Only caps of the standing lines, half a line's width long, reach into the floor.
        let differ = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| a[3].abs_diff(b[3]) > 40;
        assert_eq!(with.image.pixels().zip(without.image.pixels()).filter(|&p| differ(p)).count(), 0);
        assert!(painted(&with) > 200);
    }

    #[test]
    fn sides_are_translucent_and_the_near_ones_cover_the_far() {
        let fill = OverlaySettings { leaves_only: true, ..settings(BoxStyle::Fill) };
        let open = draw(&pair(), &fill, &wall(50.0));
        let cut = draw(&pair(), &fill, &wall(5.0));
        let hidden = draw(&pair(), &fill, &wall(2.0));
        let inside = [30, 50];
        let at = |o: &Overlay| alpha(o, inside[0], inside[1]);
        assert!(at(&open) > at(&cut) && at(&cut) > 20 && at(&open) < 120, "{} {}", at(&open), at(&cut));
        assert_eq!(painted(&hidden), 0);
        assert_eq!(alpha(&open, 50, 10), 0);
    }

    #[test]
    fn density_counts_boxes_over_a_pixel() {
        let density = settings(BoxStyle::Density);
        let open = draw(&pair(), &density, &wall(50.0));
        assert_eq!(open.density_range, Some([0, 2]), "the root and a leaf");
        assert_eq!(open.color_range, None);
        // Between the cubes there is only the root.
        let colors =
            [open.image.get_pixel(30, 50).0, open.image.get_pixel(50, 50).0, open.image.get_pixel(2, 2).0];
        assert_eq!(colors, [density_color(2, [0, 2]), density_color(1, [0, 2]), [0; 4]]);
        let hidden = draw(&pair(), &density, &wall(2.0));
        assert_eq!((hidden.density_range, painted(&hidden)), (Some([0, 0]), 0));
        let through = draw(&pair(), &OverlaySettings { show_hidden: true, ..density }, &wall(2.0));
        assert!(through.image == open.image);
    }

    #[test]
    fn the_scale_of_a_density_begins_at_the_fewest() {
        assert_eq!(density_position(4, [4, 80]), 0.0);
        assert_eq!(density_position(80, [4, 80]), 1.0);
        assert!(density_position(1, [0, 80]) > 0.1, "one box is told from none");
        assert_eq!(density_position(5, [5, 5]), 0.0);
    }

    #[test]
    fn colours_say_depth_leaf_size_and_share() {
        let far = wall(50.0);
        let range =
            |color| draw(&pair(), &OverlaySettings { color, ..settings(BoxStyle::Wire) }, &far).color_range;
        assert_eq!(range(NodeFigure::Depth), Some([0.0, 1.0]));
        assert_eq!(range(NodeFigure::LeafSize), Some([1.0, 3.0]));
        // The root 24, the leaves 12 and 3 * 12.
        let share = range(NodeFigure::SahShare).expect("shares are known")[1];
        assert!((share - 0.5).abs() < 1e-6, "{share}");
        assert_eq!(range(NodeFigure::Fill), Some([0.0, 1.0]));
    }

    /// A tree of one level below the root, with boxes anywhere around the eye.
    fn scattered(seed: u64) -> Tree {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        let mut point =
            |scale: f32| Vec3::from_array(std::array::from_fn(|_| scale * rng.random_range(-1.0..1.0)));
        let boxes: Vec<Aabb> = (0..200).map(|_| Aabb::from_points([point(8.0)])).collect();
        let boxes: Vec<Aabb> = boxes.iter().map(|b| b.grown(b.min + point(3.0))).collect();
        let config = BuildConfig { width: Width::W2, ..BuildConfig::default() };
        crate::accel::build(&boxes, &config, &Task::new()).expect("nobody cancels").0
    }

    #[test]
    fn boxes_anywhere_around_the_eye_give_a_valid_picture() {
        for seed in 0..6 {
            let tree = scattered(seed);
            for style in BoxStyle::ALL {
                let open = OverlaySettings { show_hidden: true, ..settings(style) };
                let [all, seen] = [open, settings(style)].map(|s| draw(&tree, &s, &wall(4.0)));
                assert!(all.drawn > 50 && painted(&all) >= painted(&seen) && painted(&seen) > 0);
                for (all, seen) in all.image.pixels().zip(seen.image.pixels()) {
                    assert!(all.0[..3].iter().all(|&c| c <= all[3]), "premultiplied: {all:?}");
                    // A density has a scale of its own.
                    assert!(style == BoxStyle::Density || seen[3] <= all[3], "{seen:?} {all:?}");
                }
            }
        }
    }

    #[test]
    fn leaving_out_what_is_hidden_changes_nothing() {
        let frame = front_frame();
        for seed in 0..6 {
            let tree = scattered(seed);
            // A wall with a window.
            let mut depth = wall(3.0);
            for (i, distance) in depth.iter_mut().enumerate() {
                if (30..47).contains(&(i % SIDE)) && (40..90).contains(&(i / SIDE)) {
                    *distance = f32::INFINITY;
                }
            }
            let projector = Projector::new(frame, &tree.bounds());
            let stage = Stage { projector: &projector, surfaces: None };
            let canvas =
                Canvas { projector: &projector, width: 100, height: 100, depth: &depth, show_hidden: false };
            for style in BoxStyle::ALL {
                let settings = settings(style);
                let all = select(&tree, NodesShown::default(), stage, &settings, &Task::new())
                    .expect("nobody cancels");
                let mut image = RgbaImage::new(100, 100);
                draw_selection(&canvas, &all, &settings, &mut image, &Task::new()).expect("nobody cancels");
                let culled = draw(&tree, &settings, &depth);
                assert!(culled.image == image, "{style:?}, seed {seed}");
                // What is too small inside a hidden box counts as hidden.
                assert!(culled.drawn >= all.boxes.len());
            }
        }
    }

    #[test]
    fn the_budget_keeps_the_same_boxes_as_sorting_all() {
        let frame = front_frame();
        for seed in 0..4 {
            let tree = scattered(seed);
            let projector = Projector::new(frame, &tree.bounds());
            let stage = Stage { projector: &projector, surfaces: None };
            let pick = |budget| {
                let settings = OverlaySettings { budget, ..settings(BoxStyle::Wire) };
                select(&tree, NodesShown::default(), stage, &settings, &Task::new()).expect("nobody cancels")
            };
            let all = pick(u32::MAX);
            for budget in [1, 7, 40, 80] {
                let some = pick(budget);
                assert_eq!(some.boxes.len(), budget as usize);
                let mut sizes: Vec<f32> = all.boxes.iter().map(|b| b.size).collect();
                sizes.sort_by(|a, b| b.total_cmp(a));
                let mut kept: Vec<f32> = some.boxes.iter().map(|b| b.size).collect();
                kept.sort_by(|a, b| b.total_cmp(a));
                assert_eq!(kept, sizes[..budget as usize]);
                let left_out = some.outside + some.too_small + some.over_budget;
                assert_eq!(some.selected, some.boxes.len() + left_out);
            }
        }
    }

    #[test]
    fn an_empty_tree_draws_nothing() {
        let empty = Tree::W4(WideBvh {
            root: ChildRef::EMPTY,
            bounds: Aabb::EMPTY,
            nodes: Vec::new(),
            leaves: Vec::new(),
            refs: Vec::new(),
            depth_max: 0,
        });
        for style in BoxStyle::ALL {
            assert_eq!(draw(&empty, &settings(style), &wall(50.0)).selected, 0);
        }
    }

    #[test]
    fn the_picture_is_the_same_at_any_thread_count() {
        let through = |style| OverlaySettings { show_hidden: true, ..settings(style) };
        for style in BoxStyle::ALL {
            let images = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
                pool.install(|| draw(&pair(), &through(style), &wall(5.0)).image)
            });
            assert!(images[0] == images[1], "{style:?}");
        }
    }

    #[test]
    fn a_cancelled_task_stops_it() {
        let task = Task::new();
        task.cancel();
        let drawn = draw_tree(
            &pair(),
            NodesShown::default(),
            front_frame(),
            &settings(BoxStyle::Wire),
            &wall(5.0),
            &task,
        );
        assert!(matches!(drawn, Err(Cancelled)));
    }
}
