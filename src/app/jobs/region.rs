//! The numbers of a part of the picture, and its most expensive pixels.

use std::sync::Arc;

use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::histogram::Histogram;
use crate::inspect::region::{PixelNumber, Region};
use crate::render::Film;

/// Bars of the histogram.
const BINS: usize = 48;
/// Pixels that are listed.
const MOST_PIXELS: usize = 24;

#[derive(Clone)]
pub struct RegionRequest {
    /// Of the picture.
    pub version: u64,
    pub film: Arc<Film>,
    /// `None` for all of it.
    pub region: Option<Region>,
    pub size: [u32; 2],
}

/// What was found of a version of the picture.
#[derive(Clone, Debug)]
pub struct RegionFigures {
    pub version: u64,
    pub region: Option<Region>,
    /// Of the region; `None` without one.
    pub histogram: Option<Histogram>,
    /// In pixels of the picture, the largest first.
    pub largest: Vec<PixelNumber>,
}

pub type RegionJob = Job<RegionRequest, RegionFigures>;

pub fn job() -> RegionJob {
    let patience = Patience::Within(std::time::Duration::from_secs(2));
    Job::new(patience, PoolKind::Draw, |run: &Run<RegionRequest, RegionFigures>| {
        let RegionRequest { version, film, region, size } = run.request;
        let part = region.unwrap_or(Region::all(*size));
        // As far apart as a twentieth of the picture: a list of places, not of neighbours.
        let apart = film.width.max(film.height) / 20;
        let scale = (size[0] as f32 / film.width as f32).max(1.0);
        let in_picture =
            |n: PixelNumber| PixelNumber { pixel: n.pixel.map(|x| ((x as f32 + 0.5) * scale) as u32), ..n };
        run.emit(RegionFigures {
            version: *version,
            region: *region,
            histogram: region.and_then(|region| region.histogram(film, BINS)),
            largest: part.largest(film, MOST_PIXELS, apart).into_iter().map(in_picture).collect(),
        });
    })
}
