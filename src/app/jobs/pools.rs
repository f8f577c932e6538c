//! The threads that compute: separate pools, so that what the user waits for never queues behind what can wait.

use std::sync::{Arc, OnceLock};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// What a pool is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PoolKind {
    /// Samples of the picture.
    Render,
    /// Trees: a build must not wait for the sample that runs.
    Build,
    /// Boxes and pictures for the screen.
    Draw,
    /// Loading and exporting.
    Work,
    /// Everything that nobody waits for.
    Background,
    /// Timed measurements, under the lease.
    Measure,
}

impl PoolKind {
    pub const ALL: [Self; 6] =
        [Self::Render, Self::Build, Self::Draw, Self::Work, Self::Background, Self::Measure];

    fn name(self) -> &'static str {
        match self {
            Self::Render => "render",
            Self::Build => "build",
            Self::Draw => "draw",
            Self::Work => "work",
            Self::Background => "background",
            Self::Measure => "measure",
        }
    }

    fn threads(self, all: usize) -> usize {
        match self {
            Self::Render | Self::Build | Self::Work | Self::Measure => all,
            Self::Draw => all.min(8),
            Self::Background => (all / 4).max(1),
        }
    }
}

/// The pools, each made when it is first used.
#[derive(Debug)]
pub struct Pools {
    threads: usize,
    pools: [OnceLock<Arc<ThreadPool>>; PoolKind::ALL.len()],
}

impl Pools {
    /// `threads`: as in the session, 0 for all.
    pub fn new(threads: usize) -> Self {
        Self { threads, pools: Default::default() }
    }

    pub fn threads(&self) -> usize {
        self.threads
    }

    pub fn get(&self, kind: PoolKind) -> Arc<ThreadPool> {
        let all = match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let pool = self.pools[kind as usize].get_or_init(|| {
            let pool = ThreadPoolBuilder::new()
                .num_threads(kind.threads(all))
                .thread_name(move |i| format!("{}-{i}", kind.name()))
                .build()
                .expect("the system gives threads");
            Arc::new(pool)
        });
        Arc::clone(pool)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_background_is_small_and_every_pool_has_a_thread() {
        for all in [1, 2, 8, 64] {
            for kind in PoolKind::ALL {
                assert!((1..=all).contains(&kind.threads(all)));
            }
            assert!(PoolKind::Background.threads(all) <= (all / 4).max(1));
        }
        let pools = Pools::new(3);
        assert_eq!(pools.get(PoolKind::Build).current_num_threads(), 3);
        assert!(Arc::ptr_eq(&pools.get(PoolKind::Build), &pools.get(PoolKind::Build)));
    }
}
