//! The real roots of a polynomial in an interval, by bracketing between the roots of its derivative: every root that
//! changes the sign is found, and none is found twice.

/// Up to four roots, ascending.
#[derive(Clone, Copy, Debug, Default)]
pub struct Roots {
    values: [f64; 4],
    len: usize,
}

impl Roots {
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.len]
    }

    fn push(&mut self, root: f64) {
        let is_new = self.as_slice().last().is_none_or(|&last| last < root);
        if is_new && self.len < self.values.len() {
            self.values[self.len] = root;
            self.len += 1;
        }
    }
}

/// The roots of `coefficients[0] + coefficients[1] x + ...` in `lo..=hi`, ascending, up to degree four. A root without
/// a change of sign (where the curve touches zero) may be found or not.
pub fn roots_in(coefficients: &[f64], lo: f64, hi: f64) -> Roots {
    debug_assert!((2..=5).contains(&coefficients.len()));
    let mut roots = Roots::default();
    let degree = coefficients.len() - 1;
    if degree == 1 {
        let root = -coefficients[0] / coefficients[1];
        if root >= lo && root <= hi {
            roots.push(root);
        }
        return roots;
    }
    let mut derivative = [0.0; 4];
    for i in 0..degree {
        derivative[i] = coefficients[i + 1] * (i + 1) as f64;
    }
    let turning_points = roots_in(&derivative[..degree], lo, hi);
    let mut from = (lo, value(coefficients, lo));
    for &x in turning_points.as_slice().iter().chain([&hi]) {
        let to = (x, value(coefficients, x));
        if from.1 == 0.0 {
            roots.push(from.0);
        } else if (from.1 < 0.0) != (to.1 < 0.0) && to.1 != 0.0 {
            roots.push(bracketed_newton(coefficients, from, to));
        }
        from = to;
    }
    if from.1 == 0.0 {
        roots.push(from.0);
    }
    roots
}

fn value(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

fn value_and_slope(coefficients: &[f64], x: f64) -> (f64, f64) {
    coefficients.iter().rev().fold((0.0, 0.0), |(sum, slope), c| (sum * x + c, slope * x + sum))
}

/// The root between two points of different signs: Newton's steps where they stay between, else halving.
fn bracketed_newton(coefficients: &[f64], from: (f64, f64), to: (f64, f64)) -> f64 {
    let rising = from.1 < 0.0;
    let (mut lo, mut hi) = (from.0, to.0);
    let mut x = 0.5 * (lo + hi);
    for _ in 0..80 {
        let (y, slope) = value_and_slope(coefficients, x);
        if y == 0.0 {
            return x;
        }
        if (y < 0.0) == rising {
            lo = x;
        } else {
            hi = x;
        }
        let newton = x - y / slope;
        let next = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
        if (next - x).abs() <= 1e-16 * (1.0 + x.abs()) {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(roots: &[f64], lo: f64, hi: f64) {
        let mut polynomial = vec![1.0];
        for r in roots {
            let mut next = vec![0.0; polynomial.len() + 1];
            for (i, c) in polynomial.iter().enumerate() {
                next[i] -= r * c;
                next[i + 1] += c;
            }
            polynomial = next;
        }
        let found = roots_in(&polynomial, lo, hi);
        let expected: Vec<f64> = roots.iter().copied().filter(|r| (lo..=hi).contains(r)).collect();
        assert_eq!(found.as_slice().len(), expected.len(), "{roots:?}: {found:?}");
        for (a, b) in found.as_slice().iter().zip(&expected) {
            assert!((a - b).abs() < 1e-9, "{roots:?}: {found:?}");
        }
    }

    #[test]
    fn every_root_inside_the_interval_once() {
        check(&[-0.5], -1.0, 1.0);
        check(&[-0.5, 0.25], -1.0, 1.0);
        check(&[-0.9, -0.5, 0.25], -1.0, 1.0);
        check(&[-0.9, -0.5, 0.25, 0.26], -1.0, 1.0);
        check(&[-3.0, -0.5, 0.25, 7.0], -1.0, 1.0);
        check(&[-3.0, -2.0, 2.0, 7.0], -1.0, 1.0);
        check(&[-1.0, 0.0, 0.5, 1.0], -1.0, 1.0);
        check(&[-0.001, -0.0005, 0.0005, 0.001], -1.0, 1.0);
    }

    #[test]
    fn a_curve_that_never_reaches_zero_has_no_root() {
        assert!(roots_in(&[1.0, 0.0, 1.0, 0.0, 1.0], -1.0, 1.0).as_slice().is_empty());
        assert!(roots_in(&[f64::NAN; 5], -1.0, 1.0).as_slice().is_empty());
    }
}
