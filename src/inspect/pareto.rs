//! The Pareto front of rows: those that no other row beats in every column that counts.

use super::columns::{Better, Column, Row};

/// The rows, in their order, that are not dominated: no other row is at least as good in every column and better in one.
/// Rows that are equal in all columns share the front. Columns where no value is better than another do not count, nor do
/// rows without a value in one that counts. Without a column that counts nothing is on a front.
pub fn front<R: Row>(rows: &[R], columns: &[&Column]) -> Vec<usize> {
    let columns: Vec<&Column> = columns.iter().copied().filter(|c| c.better != Better::Neither).collect();
    // The smaller the better, in every place.
    let price = |row: &R| columns.iter().map(|c| price(c, row)).collect::<Option<Vec<f64>>>();
    let mut prices: Vec<(usize, Vec<f64>)> =
        rows.iter().enumerate().filter_map(|(i, row)| Some((i, price(row)?))).collect();
    if columns.is_empty() {
        return Vec::new();
    }
    // Whoever dominates a row comes before it, and is dominated only by what is kept.
    prices.sort_by(|(i, a), (j, b)| compare(a, b).then(i.cmp(j)));
    let mut kept: Vec<(usize, Vec<f64>)> = Vec::new();
    for (i, price) in prices {
        if !kept.iter().any(|(_, other)| dominates(other, &price)) {
            kept.push((i, price));
        }
    }
    let mut front: Vec<usize> = kept.into_iter().map(|(i, _)| i).collect();
    front.sort_unstable();
    front
}

/// The value with its sign turned where higher is better.
fn price<R: Row>(column: &Column, row: &R) -> Option<f64> {
    let value = column.value(row).number()?;
    match column.better {
        Better::Lower | Better::Neither => Some(value),
        Better::Higher => Some(-value),
    }
}

fn compare(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}

fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inspect::stats::TreeStats;
    use crate::render::measure::FrameTimes;

    fn columns(keys: &[&str]) -> Vec<&'static Column> {
        keys.iter().map(|key| Column::of(key).expect("a column")).collect()
    }

    /// Rows of small whole numbers, so that many are equal in something.
    fn rows(count: usize) -> Vec<TreeStats> {
        let mut bits = 7_u32;
        let mut draw = |most: u32| {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from((bits >> 16) % most)
        };
        let mut row = || {
            let mut row = TreeStats::example("A");
            row.build_ms = draw(9);
            row.figures.node_count = draw(9) as usize;
            row.rays.ray_cost_mean = Some(draw(12)).filter(|cost| *cost < 11.0);
            row.times = Some(FrameTimes { traversal_ms: 1.0, frames_per_s: draw(9), threads: 1 });
            row
        };
        (0..count).map(|_| row()).collect()
    }

    /// By the definition: every row against every other.
    fn by_force(rows: &[TreeStats], columns: &[&Column]) -> Vec<usize> {
        let price = |i: usize| {
            let of = |c: &&Column| {
                let value = c.value(&rows[i]).number();
                if c.better == Better::Higher { value.map(|v| -v) } else { value }
            };
            columns.iter().map(of).collect::<Option<Vec<f64>>>()
        };
        let beats = |a: &[f64], b: &[f64]| (0..a.len()).all(|k| a[k] <= b[k]) && a != b;
        (0..rows.len())
            .filter(|&i| {
                price(i).is_some_and(|own| {
                    !(0..rows.len()).any(|j| price(j).is_some_and(|other| beats(&other, &own)))
                })
            })
            .collect()
    }

    #[test]
    fn the_front_is_what_brute_force_finds() {
        for keys in [
            &["build_ms", "ray_cost_mean"][..],
            &["build_ms", "frames_per_s"],
            &["frames_per_s", "node_count", "ray_cost_mean"],
            &["build_ms"],
        ] {
            for count in [0, 1, 2, 5, 60, 300] {
                let (rows, columns) = (rows(count), columns(keys));
                assert_eq!(front(&rows, &columns), by_force(&rows, &columns), "{keys:?} of {count}");
            }
        }
    }

    #[test]
    fn what_has_no_better_does_not_count() {
        let rows = rows(40);
        let with_bins = front(&rows, &columns(&["build_ms", "bins"]));
        assert_eq!(with_bins, front(&rows, &columns(&["build_ms"])));
        assert!(front(&rows, &columns(&["bins"])).is_empty());
        assert!(front(&rows, &columns(&["build_ms", "lcv"])).is_empty(), "none has an LCV");
    }

    #[test]
    fn equal_rows_share_the_front() {
        assert_eq!(
            front(&[TreeStats::example("A"), TreeStats::example("B")], &columns(&["build_ms", "node_count"])),
            [0, 1]
        );
    }
}
