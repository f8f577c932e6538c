//! Showing the film at hand with other display settings, without waiting for its next sample.

use std::sync::Arc;

use super::newest::Patience;
use super::render::Presented;
use super::render::present::present;
use super::{Job, PoolKind};
use crate::render::{DisplaySettings, Film};

#[derive(Clone)]
pub struct PresentRequest {
    pub slot: usize,
    pub film: Arc<Film>,
    pub display: DisplaySettings,
}

/// The slot, the film that was shown, and what it looks like.
pub type PresentDone = (usize, Arc<Film>, Presented);

pub type PresentJob = Job<PresentRequest, PresentDone>;

pub fn job() -> PresentJob {
    Job::new(Patience::Within(std::time::Duration::MAX), PoolKind::Draw, |run| {
        let PresentRequest { slot, film, display } = run.request;
        run.emit((*slot, Arc::clone(film), present(film, display)));
    })
}
