//! How far a sweep is, and how long the rest will take.

use std::time::{Duration, Instant};

use crate::accel::{BuildConfig, Builder, Improver, Widen, Width};

/// What is known of a running sweep's time.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// Trees still to be measured; known only where nothing depends on what comes out.
    rest: Vec<BuildConfig>,
    /// What points took, in seconds.
    took: Vec<(BuildConfig, f64)>,
    current: Option<(String, Instant)>,
}

/// Points that take about as long as each other.
type Group = (Builder, Width, Widen, Improver);

impl Progress {
    /// Of a sweep of these trees.
    pub fn of(rest: Vec<BuildConfig>) -> Self {
        Self { rest, ..Self::default() }
    }

    pub fn started(&mut self, name: &str, now: Instant) {
        self.current = Some((name.to_owned(), now));
    }

    /// A point is there, after so long; `None` where it was known already.
    pub fn finished(&mut self, config: &BuildConfig, took: Option<Duration>) {
        if let Some(took) = took {
            self.took.push((*config, took.as_secs_f64()));
        }
        self.current = None;
        if let Some(i) = self.rest.iter().position(|c| c == config) {
            self.rest.remove(i);
        }
    }

    /// Trees of which nothing is known yet, the one that is being measured among them.
    pub fn rest(&self) -> usize {
        self.rest.len()
    }

    /// The point that is being measured.
    pub fn current(&self) -> Option<&str> {
        self.current.as_ref().map(|(name, _)| &**name)
    }

    /// How long the rest takes, by what points of the same builder, width, widening and improver took, and for others by
    /// what all points took for their weight. `None` until a point is there.
    pub fn time_left(&self, now: Instant) -> Option<Duration> {
        let seconds: f64 = self.rest.iter().map(|config| self.expected(config)).sum::<Option<f64>>()?;
        let spent = self.current.as_ref().map_or(0.0, |(_, since)| (now - *since).as_secs_f64());
        // What the current point took longer than expected says nothing of those after it.
        let current = self.rest.first().and_then(|config| self.expected(config)).unwrap_or(0.0);
        Some(Duration::from_secs_f64(seconds - spent.min(current)))
    }

    /// How long so many more points like those so far take at most.
    pub fn time_for(&self, points: usize) -> Option<Duration> {
        let total: f64 = self.took.iter().map(|(_, seconds)| seconds).sum();
        let mean = (!self.took.is_empty()).then(|| total / self.took.len() as f64)?;
        Some(Duration::from_secs_f64(mean * points as f64))
    }

    fn expected(&self, config: &BuildConfig) -> Option<f64> {
        let like = self.took.iter().filter(|(c, _)| group(c) == group(config));
        let (count, sum) = like.fold((0, 0.0), |(n, sum), (_, seconds)| (n + 1, sum + seconds));
        if count > 0 {
            return Some(sum / f64::from(count));
        }
        let weights: f64 = self.took.iter().map(|(c, _)| 1.0 + weight(c)).sum();
        let seconds: f64 = self.took.iter().map(|(_, seconds)| seconds).sum();
        (weights > 0.0).then(|| seconds / weights * (1.0 + weight(config)))
    }
}

fn group(config: &BuildConfig) -> Group {
    (config.builder, config.width, config.widen, config.improver)
}

/// A time for people who wait, as in `12 s`, `3 min 20 s` or `2 h 5 min`.
pub fn rough_time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds.round() as u64 {
        0 => "less than a second".to_owned(),
        s if s < 60 => format!("{s} s"),
        s if s < 3600 => format!("{} min {} s", s / 60, s % 60 / 10 * 10),
        s => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

/// How long a build takes about, where a binned one over 16 bins takes 1. Good enough for orders and guesses.
pub fn weight(config: &BuildConfig) -> f64 {
    let bins = (config.bins as f64 / 16.0).powf(0.6);
    let builder = match config.builder {
        Builder::Median => 0.8,
        Builder::Sweep => 4.0,
        Builder::Binned => bins,
        Builder::Spatial => 4.0 * bins,
        Builder::Lbvh => 0.4,
        Builder::Ploc => 0.8,
        Builder::Midpoint => 0.5,
        Builder::Random => 0.6,
        Builder::ObvhsFast => 1.5,
        Builder::ObvhsMedium => 3.0,
        Builder::ObvhsVerySlow => 30.0,
        Builder::Bvh => 4.0,
        Builder::Parry3d => 4.0,
    };
    let improver = match config.improver {
        Improver::None => 0.0,
        Improver::Rotations => 1.0,
        Improver::Reinsertion => 0.5 * config.rounds as f64,
    };
    builder + improver + if config.is_optimal() { 0.5 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(builder: Builder, bins: usize) -> BuildConfig {
        BuildConfig { builder, bins, ..BuildConfig::default() }
    }

    #[test]
    fn nothing_is_said_before_a_point_is_there() {
        let now = Instant::now();
        let mut progress = Progress::of(vec![config(Builder::Binned, 4), config(Builder::Binned, 8)]);
        progress.started("4 bins", now);
        assert_eq!((progress.time_left(now), progress.current()), (None, Some("4 bins")));
        progress.finished(&config(Builder::Binned, 4), Some(Duration::from_secs(2)));
        assert_eq!((progress.time_left(now), progress.rest()), (Some(Duration::from_secs(2)), 1));
        progress.started("8 bins", now);
        let later = |seconds| now + Duration::from_secs(seconds);
        assert_eq!(progress.time_left(later(1)), Some(Duration::from_secs(1)));
        assert_eq!(progress.time_left(later(9)), Some(Duration::ZERO), "late, but never negative");
        progress.finished(&config(Builder::Binned, 8), None);
        assert_eq!(progress.time_left(later(9)), Some(Duration::ZERO));
    }

    #[test]
    fn times_are_rough() {
        let texts = [0.2, 12.4, 205.0, 7500.0].map(|s| rough_time(Duration::from_secs_f64(s)));
        assert_eq!(texts, ["less than a second", "12 s", "3 min 20 s", "2 h 5 min"]);
    }

    #[test]
    fn slow_builders_count_for_more_and_what_was_measured_counts_most() {
        let now = Instant::now();
        let rest = vec![config(Builder::Binned, 16), config(Builder::Sweep, 16), config(Builder::Lbvh, 16)];
        let mut progress = Progress::of(rest);
        progress.finished(&config(Builder::Binned, 16), Some(Duration::from_secs(2)));
        let guess = progress.time_left(now).expect("a guess").as_secs_f64();
        assert!((guess - (5.0 + 1.4)).abs() < 1e-9, "{guess}");
        progress.took.push((config(Builder::Sweep, 16), 30.0));
        let known = progress.time_left(now).expect("a guess").as_secs_f64();
        assert!(known > 30.0, "{known}");
        assert_eq!(progress.time_for(2), Some(Duration::from_secs(32)));
    }
}
