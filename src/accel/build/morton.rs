//! Shapes along a Morton curve (Morton 1966): the bits of a centroid's three coordinates, one after the other.

use rayon::prelude::*;
use rdst::{RadixKey, RadixSort};

use crate::accel::config::Morton;
use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::order::{BuildRef, PARALLEL_MIN};

/// A place on the curve, and which reference is there.
#[derive(Clone, Copy, Debug)]
struct Coded {
    code: u64,
    index: u32,
}

impl RadixKey for Coded {
    const LEVELS: usize = size_of::<u64>();

    #[inline]
    fn get_level(&self, level: usize) -> u8 {
        self.code.get_level(level)
    }
}

/// The references in the order of their codes, by shape where they are equal, and the codes.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn sorted(
    refs: &[BuildRef],
    morton: Morton,
    task: &Task,
) -> Result<(Vec<u64>, Vec<BuildRef>), Cancelled> {
    let center = |r: &BuildRef| r.bound.aabb().center();
    let around = |refs: &[BuildRef]| Aabb::from_points(refs.iter().map(center));
    let bounds = refs.par_chunks(PARALLEL_MIN).map(around).reduce(|| Aabb::EMPTY, Aabb::union);
    task.check()?;
    let axis_bits = morton.get() as u32 / 3;
    let cells = f64::from(1_u32 << axis_bits);
    let (min, extent) = (bounds.min.as_dvec3(), bounds.max.as_dvec3() - bounds.min.as_dvec3());
    let cell = |r: &BuildRef| {
        let at = (center(r).as_dvec3() - min) / extent * cells;
        // No number, where all lie in one plane, becomes 0.
        at.to_array().map(|x| (x as u64).min((1 << axis_bits) - 1))
    };
    let coded = |(index, r): (usize, &BuildRef)| Coded { code: interleaved(cell(r)), index: index as u32 };
    let mut order: Vec<Coded> = refs.par_iter().with_min_len(PARALLEL_MIN).enumerate().map(coded).collect();
    task.check()?;
    order.radix_sort_unstable();
    for alike in order.chunk_by_mut(|a, b| a.code == b.code) {
        alike.sort_unstable_by_key(|coded| coded.index);
    }
    task.check()?;
    let refs = order.par_iter().with_min_len(PARALLEL_MIN).map(|coded| refs[coded.index as usize]).collect();
    Ok((order.iter().map(|coded| coded.code).collect(), refs))
}

/// The bits of three numbers in turns, x above y above z.
#[inline]
fn interleaved([x, y, z]: [u64; 3]) -> u64 {
    spread(x) << 2 | spread(y) << 1 | spread(z)
}

/// The lowest 21 bits with two zeros between each: halves move apart, then their halves.
#[inline]
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn bits_take_turns() {
        let slow = |cell: [u64; 3]| {
            (0..21).fold(0, |code, bit| {
                let [x, y, z] = cell.map(|c| c >> bit & 1);
                code | (x << 2 | y << 1 | z) << (3 * bit)
            })
        };
        for cell in [[0, 0, 0], [1, 0, 0], [5, 3, 6], [0x1f_ffff, 0, 0x15_5555], [0xa_bcde, 0x12_3456, 1]] {
            assert_eq!(interleaved(cell), slow(cell), "{cell:?}");
        }
    }

    #[test]
    fn cells_are_halves_of_the_box_around_all_centroids() {
        let at = |x, y, z| Vec3::new(x, y, z);
        let points =
            [at(8.0, 4.0, 2.0), at(0.0, 0.0, 0.0), at(0.0, 4.0, 0.0), at(8.0, 0.0, 0.0), at(0.0, 0.0, 2.0)];
        let refs: Vec<_> = (0..5).map(|i| BuildRef::new(&Aabb::from_points([points[i]]), i as u32)).collect();
        for morton in Morton::ALL {
            let (codes, refs) = sorted(&refs, morton, &Task::new()).expect("not cancelled");
            let order: Vec<_> = refs.iter().map(BuildRef::shape).collect();
            assert_eq!(order, [1, 4, 2, 3, 0]);
            let top = codes.iter().map(|code| code >> (morton.get() - 3)).collect::<Vec<_>>();
            assert_eq!(top, [0b000, 0b001, 0b010, 0b100, 0b111]);
        }
    }

    #[test]
    fn equal_codes_keep_the_order_of_the_shapes_also_where_there_is_no_extent() {
        let same = Aabb::from_points([Vec3::splat(3.0)]);
        let refs: Vec<_> = (0..1000).map(|i| BuildRef::new(&same, i)).collect();
        let (codes, refs) = sorted(&refs, Morton::Bits63, &Task::new()).expect("not cancelled");
        assert!(codes.iter().all(|&code| code == 0));
        assert!(refs.iter().map(BuildRef::shape).eq(0..1000));
    }
}
