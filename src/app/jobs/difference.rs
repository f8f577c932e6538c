//! Subtracting one film from another, and what that adds up to.

use std::sync::Arc;

use egui::ColorImage;

use super::newest::Patience;
use super::{Job, PoolKind};
use crate::app::ab::DifferencePicture;
use crate::inspect::difference::DifferenceSummary;
use crate::render::Film;
use crate::render::difference::Difference;

#[derive(Clone)]
pub struct DifferenceRequest {
    /// A and B.
    pub films: [Arc<Film>; 2],
    pub version: u64,
}

pub type DifferenceJob = Job<DifferenceRequest, DifferencePicture>;

pub fn job() -> DifferenceJob {
    Job::new(Patience::Within(std::time::Duration::MAX), PoolKind::Draw, |run| {
        let DifferenceRequest { films, version } = run.request;
        let [a, b] = films;
        let Some(difference) = Difference::of(a, b) else { return };
        let picture = difference.picture(difference.limit());
        let size = [picture.width() as usize, picture.height() as usize];
        run.emit(DifferencePicture {
            // Opaque, so that premultiplied and not are the same.
            image: ColorImage::from_rgba_premultiplied(size, picture.as_raw()).into(),
            summary: DifferenceSummary::of(&difference, a.subject.view),
            version: *version,
        });
    })
}
