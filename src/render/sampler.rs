//! Seeded random numbers, reproducible by pixel and sample at any thread count.
//!
//! A pixel's numbers are a function of (seed, pixel, sample) alone. Over the samples of a pixel each draw follows the first
//! two dimensions of Sobol's sequence, shuffled and scrambled anew for every pixel and draw (Burley, "Practical Hash-based
//! Owen Scrambling", 2020): any 2^n samples in a row fill the square evenly, and different draws know nothing of each other.

use glam::Vec2;

/// The numbers of one sample of one pixel, drawn one after the other.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Of seed and pixel.
    key: u64,
    sample: u32,
    /// Draws so far.
    drawn: u64,
}

impl Sampler {
    pub fn new(seed: u64, pixel: [u32; 2], sample: u32) -> Self {
        let pixel = u64::from(pixel[0]) | u64::from(pixel[1]) << 32;
        Self { key: scramble(scramble(seed) ^ pixel), sample, drawn: 0 }
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-24.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        unit(self.draw())
    }

    /// Uniform in `[0, 1)^2`; a draw of its own.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        let (index, key) = self.draw_index();
        let x = owen_reversed(index, key as u32).reverse_bits();
        let y = owen_reversed(sobol_reversed(index), (key >> 32) as u32).reverse_bits();
        Vec2::new(unit(x), unit(y))
    }

    /// Uniform in `[0, 1)`, a multiple of 2^-32: fine enough to pick one of a million lights.
    #[inline]
    pub fn next_fine(&mut self) -> f64 {
        f64::from(self.draw()) * (1.0 / (1u64 << 32) as f64)
    }

    /// 32 bits, the highest first.
    #[inline]
    fn draw(&mut self) -> u32 {
        let (index, key) = self.draw_index();
        owen_reversed(index, key as u32).reverse_bits()
    }

    /// The place of this sample in the next draw's own order of samples, and the key to scramble with.
    #[inline]
    fn draw_index(&mut self) -> (u32, u64) {
        self.drawn += 1;
        let key = scramble(self.key ^ self.drawn.wrapping_mul(0xd6e8_feb8_6659_fd93));
        let shuffle = scramble(key) as u32;
        // Blocks of 2^n samples in a row stay blocks of 2^n in a row.
        (owen_reversed(self.sample.reverse_bits(), shuffle).reverse_bits(), key)
    }
}

/// The fraction of 32 bits, cut to what f32 holds.
#[inline]
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1u32 << 24) as f32)
}

/// The second dimension of Sobol's sequence with its digits in reverse. Its matrix is Pascal's triangle modulo 2: digit j
/// is the sum of the index's digits i that have all bits of j, taken here one bit of i and j at a time.
#[inline]
fn sobol_reversed(index: u32) -> u32 {
    let mut x = index;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^ (x & 0xffff_0000) >> 16
}

/// Owen's scrambling of a number with its digits in reverse: a hash in which every bit depends on lower ones alone (Laine
/// and Karras, "Stratified Sampling for Stochastic Transparency", 2011, with the constants of Vegdahl, "Building a Better
/// LK Hash", 2021).
#[inline]
fn owen_reversed(reversed: u32, key: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Where sample number `sample` lies in its pixel, in `[0, 1)^2`. Sample 0 is the centre; the others fill the pixel evenly
/// at any number of them (the additive recurrence R2: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences",
/// 2018). The same in every pixel, so that a surface seen at an angle stays free of noise.
pub fn pixel_offset(sample: u32) -> Vec2 {
    // 1 / p and 1 / p^2 with p the real root of p^3 = p + 1.
    recurrence(sample, [3_242_174_889, 2_447_445_414])
}

/// A point in `[0, 1)^2` that all pixels of sample number `sample` share, unrelated to [`pixel_offset`]: what is lit by one
/// point of a light a sample stays free of noise. Sample 0 is the centre.
pub fn shared_point(sample: u32) -> Vec2 {
    // The fractions of the roots of 2 and 3, which no sum of multiples of the numbers above makes.
    recurrence(sample, [1_779_033_704, 3_144_134_277])
}

/// A number in `[0, 1)` that all pixels of sample number `sample` share, unrelated to the points above; 0.5 for sample 0.
pub fn shared_pick(sample: u32) -> f32 {
    // The golden ratio.
    recurrence(sample, [2_654_435_769, 0]).x
}

/// `0.5 + sample * step`, modulo 1, with steps in units of 2^-32: exact for any sample number.
fn recurrence(sample: u32, step: [u32; 2]) -> Vec2 {
    let at = |step: u32| unit((1u32 << 31).wrapping_add(sample.wrapping_mul(step)));
    Vec2::new(at(step[0]), at(step[1]))
}

/// A bijection of 64 bits in which every input bit moves every output bit (the finaliser of SplitMix64: Steele, Lea, Flood,
/// "Fast Splittable Pseudorandom Number Generators", 2014).
#[inline]
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

    /// How far a mean over n numbers of variance 1/12 may be off its value: five standard errors.
    fn bound(n: usize) -> f64 {
        5.0 / (12.0 * n as f64).sqrt()
    }

    /// Checks the mean and the product with the number before.
    fn check_independent(numbers: impl Iterator<Item = f32>, what: &str) {
        let numbers: Vec<f64> = numbers.map(f64::from).collect();
        assert!(numbers.iter().all(|u| (0.0..1.0).contains(u)));
        let n = numbers.len();
        let mean = numbers.iter().sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < bound(n), "{what}: mean {mean}");
        let product = numbers.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1) as f64;
        assert!((product - 0.25).abs() < bound(n), "{what}: neighbours are related, {product}");
    }

    #[test]
    fn pixels_seeds_and_draws_know_nothing_of_each_other() {
        const N: u32 = 4096;
        check_independent((0..N).map(|x| Sampler::new(7, [x, 9], 0).next_1d()), "along x");
        check_independent((0..N).map(|y| Sampler::new(7, [9, y], 3).next_1d()), "along y");
        check_independent((0..N).map(|s| Sampler::new(u64::from(s), [9, 9], 0).next_1d()), "over seeds");
        let mut sampler = Sampler::new(7, [1, 2], 5);
        check_independent((0..N).map(|_| sampler.next_1d()), "over draws");
        let both = (0..N).map(|x| Sampler::new(7, [x, 9], 2).next_2d()).flat_map(|u| [u.x, u.y]);
        check_independent(both, "the two numbers of a draw");
        // Two draws, each over all samples of a pixel: every pair of numbers as often as any other.
        let mut cells = [0u32; 16];
        for sample in 0..N {
            let mut sampler = Sampler::new(7, [3, 4], sample);
            let (a, b) = (sampler.next_1d(), sampler.next_1d());
            cells[(a * 4.0) as usize * 4 + (b * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|c| (200..=312).contains(c)), "{cells:?}");
    }

    #[test]
    fn samples_in_a_row_fill_every_elementary_interval_once() {
        for (pixel, first) in [([0, 0], 0), ([5, 9], 64), ([800, 3], 640)] {
            for draw in 0..3 {
                for columns_log2 in 0..=6 {
                    let (columns, rows) = (1 << columns_log2, 64 >> columns_log2);
                    let mut hit = [false; 64];
                    for sample in first..first + 64 {
                        let mut sampler = Sampler::new(11, pixel, sample);
                        (0..draw).for_each(|_| {
                            sampler.next_2d();
                        });
                        let u = sampler.next_2d();
                        let cell = (u.x * columns as f32) as usize * rows + (u.y * rows as f32) as usize;
                        assert!(!std::mem::replace(&mut hit[cell], true), "{columns} x {rows}, draw {draw}");
                    }
                }
            }
        }
    }

    /// `off`: what each of 64 cells may be off the 16 of 1,024 points that are its share.
    fn check_even(point: impl Fn(u32) -> Vec2, off: u32, what: &str) {
        assert_eq!(point(0), Vec2::splat(0.5), "{what}");
        let mut cells = [0u32; 64];
        for i in 0..1024 {
            let p = point(i);
            assert!((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y));
            cells[(p.x * 8.0) as usize * 8 + (p.y * 8.0) as usize] += 1;
        }
        assert!(cells.iter().all(|c| c.abs_diff(16) <= off), "{what}: {cells:?}");
    }

    #[test]
    fn shared_points_start_at_the_centre_and_fill_the_square() {
        check_even(pixel_offset, 4, "pixel");
        check_even(shared_point, 6, "light");
    }

    #[test]
    fn pixel_and_light_points_are_unrelated() {
        let mut cells = [0u32; 81];
        for i in 0..8100 {
            let (p, q) = (pixel_offset(i), shared_point(i));
            let digit = |x: f32| (x * 3.0) as usize;
            cells[((digit(p.x) * 3 + digit(p.y)) * 3 + digit(q.x)) * 3 + digit(q.y)] += 1;
        }
        assert!(cells.iter().all(|c| (85..=115).contains(c)), "{cells:?}");
    }
}
