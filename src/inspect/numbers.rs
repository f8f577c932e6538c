//! How numbers are written for people: thousands separators, fixed decimals so that columns align, a dash for what is undefined.

use std::time::Duration;

use super::columns::grouped;

pub use super::columns::DASH;

/// A whole number with separators, as in `4,977`.
pub fn count(n: impl TryInto<u64>) -> String {
    n.try_into().map_or_else(|_| DASH.to_owned(), |n| grouped(n as f64, 0))
}

/// A number with so many decimals and separators; a dash for `None` and for what is not finite.
pub fn decimal(x: impl Into<Option<f64>>, decimals: usize) -> String {
    match x.into() {
        Some(x) if x.is_finite() => grouped(x, decimals).replace('-', "−"),
        _ => DASH.to_owned(),
    }
}

/// A number with about four digits, for quantities of any size.
pub fn short(x: impl Into<Option<f64>>) -> String {
    let x = x.into();
    let size = x.map_or(0.0, f64::abs);
    if size != 0.0 && size.is_finite() && !(1e-3..1e9).contains(&size) {
        return x.map_or_else(|| DASH.to_owned(), |x| format!("{x:.2e}").replace('-', "−"));
    }
    let decimals = match size {
        s if s >= 1000.0 || s == 0.0 => 0,
        s if s >= 100.0 => 1,
        s if s >= 1.0 => 2,
        _ => 4,
    };
    decimal(x, decimals)
}

/// A share of one in percent, as in `12.5`.
pub fn percent(part: f64, whole: f64) -> String {
    decimal((whole > 0.0).then(|| 100.0 * part / whole), 1)
}

/// A number of bytes with its unit.
pub fn bytes(n: usize) -> (String, &'static str) {
    let n = n as f64;
    match n {
        n if n < 1024.0 => (decimal(n, 0), "B"),
        n if n < 1024.0 * 1024.0 => (decimal(n / 1024.0, 1), "KiB"),
        n if n < 1024.0 * 1024.0 * 1024.0 => (decimal(n / (1024.0 * 1024.0), 1), "MiB"),
        n => (decimal(n / (1024.0 * 1024.0 * 1024.0), 2), "GiB"),
    }
}

/// A change in percent with its sign, `None` where there is nothing to compare with or nothing changed.
pub fn change(now: f64, before: f64) -> Option<String> {
    let share = 100.0 * (now - before) / before.abs();
    if !share.is_finite() || share == 0.0 {
        return None;
    }
    let sign = if share < 0.0 { "−" } else { "+" };
    let share = share.abs();
    Some(match share {
        s if s < 0.1 => format!("{sign}<0.1 %"),
        s if s < 100.0 => format!("{sign}{s:.1} %"),
        s if s < 10_000.0 => format!("{sign}{s:.0} %"),
        _ => format!("{sign}>9,999 %"),
    })
}

/// A time span for people, as in `3.2 s`.
pub fn elapsed(time: Duration) -> String {
    let s = time.as_secs_f64();
    if s < 60.0 { format!("{s:.1} s") } else { format!("{:.0} min {:02.0} s", (s / 60.0).floor(), s % 60.0) }
}

/// A number at an axis' tick, as short as the step between two ticks allows.
pub fn tick(x: f64, step: f64) -> String {
    let size = x.abs();
    if size >= 1e6 {
        return format!("{}M", trimmed(x / 1e6, 2));
    }
    if size >= 1e4 {
        return format!("{}k", trimmed(x / 1e3, 1));
    }
    let decimals = if step >= 1.0 { 0 } else { (-step.log10()).ceil().clamp(0.0, 6.0) as usize };
    decimal(x, decimals)
}

fn trimmed(x: f64, decimals: usize) -> String {
    let text = decimal(x, decimals);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_separators() {
        assert_eq!(
            [0u64, 999, 1000, 4977, 1_234_567].map(count),
            ["0", "999", "1,000", "4,977", "1,234,567"]
        );
    }

    #[test]
    fn decimals_align_and_undefined_is_a_dash() {
        assert_eq!(decimal(1234.5, 2), "1,234.50");
        assert_eq!(decimal(-0.001, 2), "0.00", "no sign before a zero");
        assert_eq!(decimal(-1234.5, 1), "−1,234.5");
        assert_eq!([None, Some(f64::NAN), Some(f64::INFINITY)].map(|x| decimal(x, 1)), [DASH; 3]);
    }

    #[test]
    fn short_numbers_keep_about_four_digits() {
        let cases =
            [(0.0, "0"), (12345.6, "12,346"), (123.45, "123.5"), (1.234, "1.23"), (0.01234, "0.0123")];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
        assert_eq!(short(1.5e12), "1.50e12");
        assert_eq!(short(-1.5e-7), "−1.50e−7");
        assert_eq!(short(None), DASH);
    }

    #[test]
    fn changes_have_a_sign_and_none_means_the_same() {
        assert_eq!(change(99.0, 100.0).as_deref(), Some("−1.0 %"));
        assert_eq!(change(250.0, 100.0).as_deref(), Some("+150 %"));
        assert_eq!(change(1.00001, 1.0).as_deref(), Some("+<0.1 %"));
        assert_eq!((change(1.0, 1.0), change(1.0, 0.0)), (None, None));
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!(tick(2_500_000.0, 500_000.0), "2.5M");
        assert_eq!(tick(20_000.0, 5000.0), "20k");
        assert_eq!(tick(0.25, 0.05), "0.25");
        assert_eq!(tick(1500.0, 500.0), "1,500");
    }

    #[test]
    fn bytes_and_times_have_units() {
        assert_eq!(bytes(1536), ("1.5".to_owned(), "KiB"));
        assert_eq!(elapsed(Duration::from_millis(61_400)), "1 min 01 s");
        assert_eq!(elapsed(Duration::from_millis(250)), "0.2 s");
    }
}
