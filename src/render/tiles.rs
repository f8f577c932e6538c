//! Pictures in tiles: the pieces of work of the threads.

use std::ops::AddAssign;

use rayon::prelude::*;

use super::pass::Pass;
use crate::accel::RayCounters;
use crate::accel::traverse::packet::PACKET;
use crate::geometry::{Hit, Ray};
use crate::task::{Cancelled, Task};
use crate::world::Packets;

/// Pixels along the side of a tile, the piece of work of one thread.
const TILE: usize = 16;

/// Pixels along the side of the square whose rays are a packet.
pub(super) const BLOCK: usize = PACKET.isqrt();

/// Values of all pixels, tile by tile; tiles at the right and lower edge are padded.
///
/// An allocation a tile: memory of that size is kept by the allocator, while that of a whole picture would come from the
/// system anew, page by page, for every sample.
pub(super) struct Tiled<T> {
    tiles: Vec<Vec<T>>,
    columns: usize,
}

/// Evaluates every pixel, a tile a piece of work, with a `state` that a thread keeps for many. `tile` is given the pixels of
/// one, in squares that make good packets, and a place for the value of each. `finished` is told the pixels of every
/// finished tile.
pub(super) fn tiles<T, S>(
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
    state: impl Fn() -> S + Sync,
    tile: impl Fn(&mut S, &[[u32; 2]], &mut [T]) -> Result<(), Cancelled> + Sync,
) -> Result<Tiled<T>, Cancelled>
where
    T: Copy + Default + Send + Sync,
{
    let [width, height] = size.map(|s| s as usize);
    let columns = width.div_ceil(TILE);
    let kept = || (state(), Vec::new(), Vec::new());
    let one = |(state, pixels, found): &mut (S, Vec<[u32; 2]>, Vec<T>), index: usize| {
        task.check()?;
        let (left, top) = (index % columns * TILE, index / columns * TILE);
        pixels.clear();
        in_blocks([left, top], [(left + TILE).min(width), (top + TILE).min(height)], pixels);
        found.clear();
        found.resize(pixels.len(), T::default());
        tile(state, pixels, found)?;
        let mut values = vec![T::default(); TILE * TILE];
        for (&[x, y], &value) in pixels.iter().zip(&*found) {
            values[(y as usize - top) * TILE + x as usize - left] = value;
        }
        finished(pixels.len() as u64);
        Ok(values)
    };
    let count = columns * height.div_ceil(TILE);
    let tiles = (0..count).into_par_iter().map_init(kept, one).collect::<Result<_, _>>()?;
    Ok(Tiled { tiles, columns })
}

/// Adds the pixels from `from` to before `to`, square by square, each of which makes a packet.
pub(super) fn in_blocks(from: [usize; 2], to: [usize; 2], pixels: &mut Vec<[u32; 2]>) {
    for top in (from[1]..to[1]).step_by(BLOCK) {
        for left in (from[0]..to[0]).step_by(BLOCK) {
            for y in top..to[1].min(top + BLOCK) {
                // Loops instead of one chain of iterators, which took a tenth of a heatmap's time.
                pixels.extend((left..to[0].min(left + BLOCK)).map(|x| [x as u32, y as u32]));
            }
        }
    }
}

/// As [`tiles`], pixel by pixel.
pub(super) fn tiled<T, S>(
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
    state: impl Fn() -> S + Sync,
    pixel: impl Fn(&mut S, u32, u32) -> T + Sync,
) -> Result<Tiled<T>, Cancelled>
where
    T: Copy + Default + Send + Sync,
{
    tiles(size, task, finished, state, |state, pixels, values| {
        for (&[x, y], value) in pixels.iter().zip(values) {
            task.check()?;
            *value = pixel(state, x, y);
        }
        Ok(())
    })
}

/// As [`tiles`], pixel by pixel, with the camera ray of each and what it hits. The rays are traced in packets.
pub(super) fn camera_tiled<T>(
    pass: &Pass,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
    pixel: impl Fn([u32; 2], &Ray, Option<Hit>) -> T + Sync,
) -> Result<Tiled<T>, Cancelled>
where
    T: Copy + Default + Send + Sync,
{
    let state = || CameraRays::new(pass);
    tiles(size, task, finished, state, |rays, pixels, values| {
        let (rays, hits) = rays.intersect(pixels);
        for (((&at, ray), &hit), value) in pixels.iter().zip(rays).zip(hits).zip(values) {
            task.check()?;
            *value = pixel(at, ray, hit);
        }
        Ok(())
    })
}

/// As [`tiles`], pixel by pixel, with what the camera ray of each counts.
pub(super) fn counted_tiled<T>(
    pass: &Pass,
    size: [u32; 2],
    task: &Task,
    finished: &(impl Fn(u64) + Sync),
    pixel: impl Fn(&RayCounters) -> T + Sync,
) -> Result<Tiled<T>, Cancelled>
where
    T: Copy + Default + Send + Sync,
{
    let state = || CameraRays::new(pass);
    tiles(size, task, finished, state, |rays, pixels, values| {
        for (counters, value) in rays.count(pixels).iter().zip(values) {
            *value = pixel(counters);
        }
        Ok(())
    })
}

/// The camera rays of some pixels.
struct CameraRays<'p, 'w> {
    pass: &'p Pass<'w>,
    packets: Packets<'w>,
    rays: Vec<Ray>,
}

impl<'p, 'w> CameraRays<'p, 'w> {
    fn new(pass: &'p Pass<'w>) -> Self {
        Self { pass, packets: Packets::new(pass.world), rays: Vec::new() }
    }

    fn aim(&mut self, pixels: &[[u32; 2]]) {
        self.rays.clear();
        self.rays.extend(pixels.iter().map(|&[x, y]| self.pass.camera_ray(x, y)));
    }

    fn intersect(&mut self, pixels: &[[u32; 2]]) -> (&[Ray], &[Option<Hit>]) {
        self.aim(pixels);
        (&self.rays, self.packets.intersect(&self.rays))
    }

    fn count(&mut self, pixels: &[[u32; 2]]) -> &[RayCounters] {
        self.aim(pixels);
        self.packets.count(&self.rays)
    }
}

/// Adds a sample of every pixel to the sums.
pub(super) fn add<T: Copy + AddAssign + Send + Sync>(sums: &mut [T], sample: &Tiled<T>, size: [u32; 2]) {
    let width = (size[0] as usize).max(1);
    sums.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let tiles = &sample.tiles[y / TILE * sample.columns..];
        for (sums, tile) in row.chunks_mut(TILE).zip(tiles) {
            for (sum, &value) in sums.iter_mut().zip(&tile[y % TILE * TILE..]) {
                *sum += value;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinates(size: [u32; 2]) -> Vec<f32> {
        let tiles = tiled(size, &Task::new(), &|_| (), || (), |(), x, y| (x + 1000 * y) as f32)
            .expect("nobody cancels");
        let mut sums = vec![0.0; size[0] as usize * size[1] as usize];
        add(&mut sums, &tiles, size);
        sums
    }

    #[test]
    fn tiles_put_every_pixel_in_its_place() {
        for size in [[1, 1], [16, 16], [17, 33], [50, 3], [0, 0], [5, 0]] {
            let expected: Vec<f32> =
                (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x + 1000 * y) as f32)).collect();
            assert_eq!(coordinates(size), expected, "{size:?}");
        }
    }

    #[test]
    fn a_tile_s_pixels_come_in_squares_that_fill_packets() {
        let mut pixels = Vec::new();
        in_blocks([16, 32], [32, 48], &mut pixels);
        assert_eq!(pixels.len(), TILE * TILE);
        for block in pixels.chunks(PACKET) {
            let [x, y] = block[0];
            assert!(block.iter().all(|p| p[0] / 8 == x / 8 && p[1] / 8 == y / 8), "{block:?}");
        }
        pixels.clear();
        in_blocks([32, 48], [40, 60], &mut pixels);
        assert_eq!(pixels.len(), 8 * 12);
    }

    #[test]
    fn every_pixel_is_reported_once() {
        let pixels = std::sync::atomic::AtomicU64::new(0);
        let count = |n| {
            pixels.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
        };
        tiled([37, 21], &Task::new(), &count, || (), |(), _, _| 0.0).map(|_| ()).expect("nobody cancels");
        assert_eq!(pixels.into_inner(), 37 * 21);
    }

    #[test]
    fn a_cancelled_task_stops_the_tiles() {
        let task = Task::new();
        let stopped = tiled(
            [64, 64],
            &task,
            &|_| (),
            || (),
            |(), x, y| {
                if (x, y) == (20, 20) {
                    task.cancel();
                }
                0.0
            },
        );
        assert!(stopped.is_err());
    }
}
