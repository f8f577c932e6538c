//! Which boxes lie wholly behind surfaces, asked of coarse maxima of the picture's depth: a hierarchical depth buffer
//! (Greene, Kass, Miller, "Hierarchical Z-Buffer Visibility", 1993).

use rayon::prelude::*;

use super::band::surface_depth;
use super::project::{PixelRect, Projector};

/// Pixels along the side of a tile of the finest level.
const TILE: usize = 8;

/// Tiles looked at along a side of a rectangle, at most.
const TILES_ASKED: usize = 4;

/// For each tile the depth of its farthest surface; each level half as fine as the one before.
#[derive(Debug)]
pub struct FarthestSurfaces {
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    width: usize,
    height: usize,
    farthest: Vec<f32>,
}

impl FarthestSurfaces {
    /// From the distance along each pixel's ray to the first surface.
    pub fn new(projector: &Projector, distances: &[f32]) -> Self {
        let [width, height] = projector.frame.size.to_array().map(|n| n as usize);
        let tiles = width.div_ceil(TILE);
        let farthest = distances
            .par_chunks(width.max(1) * TILE)
            .enumerate()
            .flat_map_iter(|(tile_y, rows)| {
                let mut farthest = vec![f32::NEG_INFINITY; tiles];
                for (y, row) in rows.chunks_exact(width).enumerate() {
                    let v = projector.row_direction((tile_y * TILE + y) as u32);
                    for (x, &distance) in row.iter().enumerate() {
                        let u = projector.column_direction(x as u32);
                        let tile = &mut farthest[x / TILE];
                        *tile = tile.max(surface_depth(distance, u, v));
                    }
                }
                farthest
            })
            .collect();
        let mut levels = vec![Level { width: tiles, height: height.div_ceil(TILE), farthest }];
        while let Some(last) = levels.last().filter(|l| l.width.max(l.height) > TILES_ASKED) {
            let coarser = last.halved();
            levels.push(coarser);
        }
        Self { levels }
    }

    /// Whether everything that is drawn in these pixels at this depth or behind lies behind surfaces.
    pub fn hide(&self, rect: &PixelRect, depth: f32) -> bool {
        let tiles = |max: u16, min: u16, level: usize| {
            (usize::from(max) - 1) / (TILE << level) - usize::from(min) / (TILE << level) + 1
        };
        let spans =
            |level| tiles(rect.max[0], rect.min[0], level).max(tiles(rect.max[1], rect.min[1], level));
        let level_idx =
            (0..self.levels.len() - 1).find(|&l| spans(l) <= TILES_ASKED).unwrap_or(self.levels.len() - 1);
        let level = &self.levels[level_idx];
        let side = TILE << level_idx;
        let [x, y] = [0, 1].map(|i| usize::from(rect.min[i]) / side..=(usize::from(rect.max[i]) - 1) / side);
        y.flat_map(|y| x.clone().map(move |x| (x, y)))
            .all(|(x, y)| level.farthest[y * level.width + x] < depth)
    }
}

impl Level {
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut farthest = vec![f32::NEG_INFINITY; width * height];
        for (i, &depth) in self.farthest.iter().enumerate() {
            let (x, y) = (i % self.width, i / self.width);
            let tile = &mut farthest[y / 2 * width + x / 2];
            *tile = tile.max(depth);
        }
        Self { width, height, farthest }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::project::tests::front_frame;
    use super::*;
    use crate::geometry::Aabb;

    #[test]
    fn only_what_is_behind_every_surface_is_hidden() {
        let projector = Projector::new(front_frame(), &Aabb::new(Vec3::splat(-9.0), Vec3::splat(9.0)));
        // A wall at depth 4, with one pixel open at (70, 20).
        let frame = projector.frame;
        let mut distances: Vec<f32> = (0..100 * 100)
            .map(|i| {
                let ray = frame.ray(Vec2::new((i % 100) as f32, (i / 100) as f32) + 0.5);
                4.0 / ray.direction.dot(frame.forward)
            })
            .collect();
        distances[20 * 100 + 70] = f32::INFINITY;
        let surfaces = FarthestSurfaces::new(&projector, &distances);
        let rect = |x0, y0, x1, y1| PixelRect { min: [x0, y0], max: [x1, y1] };
        assert!(surfaces.hide(&rect(10, 10, 40, 90), 5.0));
        assert!(!surfaces.hide(&rect(10, 10, 40, 90), 3.9));
        assert!(surfaces.hide(&rect(0, 40, 100, 100), 5.0));
        for open in [rect(70, 20, 71, 21), rect(0, 0, 100, 100), rect(60, 10, 90, 30)] {
            assert!(!surfaces.hide(&open, 1e9), "{open:?}");
        }
    }
}
