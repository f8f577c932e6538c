//! Exact order statistics of many floats, by counting on the upper half of their bits instead of sorting.

use rayon::prelude::*;

/// Values a task counts; small enough to share, large enough that its table of counters pays.
const CHUNK: usize = 1 << 18;
/// One counter for each upper half of a key.
const BUCKETS: usize = 1 << 16;

/// The finite values at the given shares of their order, by nearest rank: the smallest value that at least `share` of
/// all values do not exceed (share 0 gives the smallest one). `None` if no value is finite.
///
/// Two passes over the values, in parallel, whatever the number of shares.
pub fn nearest_ranks<const N: usize>(values: &[f32], shares: [f64; N]) -> Option<[f32; N]> {
    let counts = count_buckets(values);
    let total: u64 = counts.iter().map(|&n| u64::from(n)).sum();
    if total == 0 {
        return None;
    }
    let places = shares.map(|share| {
        let rank = (share * total as f64).ceil().clamp(1.0, total as f64) as u64;
        find_bucket(&counts, rank)
    });
    let mut wanted: Vec<u32> = places.iter().map(|p| p.bucket).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let mut members = gather(values, &wanted);
    Some(places.map(|place| {
        let slot = wanted.binary_search(&place.bucket).expect("every bucket was gathered");
        let (_, &mut key, _) = members[slot].select_nth_unstable(place.rank_inside);
        value_of(key)
    }))
}

struct Place {
    bucket: u32,
    /// From 0, among the bucket's own values.
    rank_inside: usize,
}

fn find_bucket(counts: &[u32], rank: u64) -> Place {
    let mut before = 0;
    for (bucket, &n) in counts.iter().enumerate() {
        if before + u64::from(n) >= rank {
            return Place { bucket: bucket as u32, rank_inside: (rank - before - 1) as usize };
        }
        before += u64::from(n);
    }
    unreachable!("a rank is never above the number of values")
}

fn count_buckets(values: &[f32]) -> Vec<u32> {
    values
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut counts = vec![0u32; BUCKETS];
            for &value in chunk.iter().filter(|v| v.is_finite()) {
                counts[(key_of(value) >> 16) as usize] += 1;
            }
            counts
        })
        .reduce(
            || vec![0u32; BUCKETS],
            |mut a, b| {
                a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
                a
            },
        )
}

/// The keys in each wanted bucket.
fn gather(values: &[f32], wanted: &[u32]) -> Vec<Vec<u32>> {
    values
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut members = vec![Vec::new(); wanted.len()];
            for &value in chunk.iter().filter(|v| v.is_finite()) {
                let key = key_of(value);
                if let Some(slot) = wanted.iter().position(|&b| b == key >> 16) {
                    members[slot].push(key);
                }
            }
            members
        })
        .reduce(
            || vec![Vec::new(); wanted.len()],
            |mut a, b| {
                a.iter_mut().zip(b).for_each(|(a, mut b)| a.append(&mut b));
                a
            },
        )
}

/// An integer in the order of the floats.
#[inline]
fn key_of(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

#[inline]
fn value_of(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
}

#[cfg(test)]
mod tests {
    use rand::{Rng, RngExt, SeedableRng};

    use super::*;

    fn by_sorting(values: &[f32], share: f64) -> f32 {
        let mut sorted: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f32::total_cmp);
        let rank = (share * sorted.len() as f64).ceil().max(1.0) as usize;
        sorted[rank - 1]
    }

    fn check(values: &[f32]) {
        let shares = [0.0, 0.1, 0.5, 0.95, 0.99, 0.995, 1.0];
        let ranks = nearest_ranks(values, shares).expect("some value is finite");
        for (share, rank) in shares.into_iter().zip(ranks) {
            assert_eq!(rank, by_sorting(values, share), "at {share} of {} values", values.len());
        }
    }

    #[test]
    fn agrees_with_sorting() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        check(&[3.0]);
        check(&[2.0, 1.0]);
        check(&[5.0; 1000]);
        check(&(0..1000).map(|_| rng.random_range(-1.0..1.0)).collect::<Vec<f32>>());
        check(&(0..300_000).map(|_| (rng.next_u32() % 60) as f32).collect::<Vec<f32>>());
        check(&(0..1000).map(|_| f32::from_bits(rng.next_u32())).collect::<Vec<f32>>());
    }

    #[test]
    fn only_finite_values_count() {
        check(&[f32::NAN, 1.0, f32::INFINITY, 4.0, f32::NEG_INFINITY, -2.0]);
        assert_eq!(nearest_ranks(&[f32::NAN, f32::INFINITY], [0.5]), None);
        assert_eq!(nearest_ranks(&[], [0.5]), None);
    }
}
