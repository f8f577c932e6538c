//! Seeded random numbers, reproducible by pixel and sample at any thread count.
//!
//! A pixel's numbers are a function of (seed, pixel, sample) alone: a PCG stream (O'Neill, "PCG: A Family of Simple Fast
//! Space-Efficient Statistically Good Algorithms for Random Number Generation", 2014) started from a hash of the three.

use glam::Vec2;
use rand::Rng;
use rand_pcg::Pcg32;

/// The numbers of one sample of one pixel.
#[derive(Clone, Debug)]
pub struct Sampler {
    rng: Pcg32,
}

impl Sampler {
    pub fn new(seed: u64, pixel: [u32; 2], sample: u32) -> Self {
        let pixel = u64::from(pixel[0]) | u64::from(pixel[1]) << 32;
        let state = scramble(scramble(scramble(seed) ^ pixel) ^ u64::from(sample));
        Self { rng: Pcg32::new(state, scramble(state)) }
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-24.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        (self.rng.next_u32() >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
    }

    /// Two of [`Sampler::next_1d`].
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        let x = self.next_1d();
        Vec2::new(x, self.next_1d())
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-32: fine enough to pick one of a million lights.
    #[inline]
    pub fn next_fine(&mut self) -> f64 {
        f64::from(self.rng.next_u32()) * (1.0 / (1u64 << 32) as f64)
    }
}

/// Where sample number `sample` lies in its pixel, in `[0, 1)^2`. Sample 0 is the centre; the others fill the pixel evenly
/// at any number of them (the additive recurrence R2: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences",
/// 2018). The same in every pixel, so that a surface seen at an angle stays free of noise.
pub fn pixel_offset(sample: u32) -> Vec2 {
    // 1 / p and 1 / p^2 with p the real root of p^3 = p + 1, as fractions of 2^32: exact for any sample number.
    const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414];
    let at = |step: u32| {
        let fraction = (1u32 << 31).wrapping_add(sample.wrapping_mul(step));
        (fraction >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
    };
    Vec2::new(at(STEP[0]), at(STEP[1]))
}

/// A bijection of 64 bits in which every input bit moves every output bit (the finaliser of SplitMix64: Steele, Lea, Flood,
/// "Fast Splittable Pseudorandom Number Generators", 2014).
pub fn scramble(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_depend_on_seed_pixel_and_sample_and_on_nothing_else() {
        let take = |seed, pixel, sample| {
            let mut s = Sampler::new(seed, pixel, sample);
            [s.next_1d(), s.next_1d(), s.next_1d()]
        };
        let first = take(1, [2, 3], 4);
        assert_eq!(first, take(1, [2, 3], 4));
        for other in [take(2, [2, 3], 4), take(1, [3, 2], 4), take(1, [2, 4], 4), take(1, [2, 3], 5)] {
            assert_ne!(first, other);
        }
    }

    #[test]
    fn numbers_lie_in_range_and_have_the_right_mean_over_neighbouring_pixels() {
        let mut sum = 0.0;
        let mut product = 0.0;
        for x in 0..100 {
            for y in 0..100 {
                let u = Sampler::new(7, [x, y], 0).next_2d();
                assert!((0.0..1.0).contains(&u.x) && (0.0..1.0).contains(&u.y));
                sum += f64::from(u.x);
                product += f64::from(u.x) * f64::from(u.y);
            }
        }
        assert!((sum / 1e4 - 0.5).abs() < 0.01, "mean {}", sum / 1e4);
        assert!((product / 1e4 - 0.25).abs() < 0.01, "two numbers of a pixel are related: {}", product / 1e4);
    }

    #[test]
    fn pixel_offsets_start_at_the_centre_and_fill_the_pixel() {
        assert_eq!(pixel_offset(0), Vec2::splat(0.5));
        let mut cells = [0u32; 64];
        for i in 0..1024 {
            let p = pixel_offset(i);
            assert!((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y));
            cells[(p.x * 8.0) as usize * 8 + (p.y * 8.0) as usize] += 1;
        }
        assert!(cells.iter().all(|c| (13..=19).contains(c)), "{cells:?}");
    }
}
