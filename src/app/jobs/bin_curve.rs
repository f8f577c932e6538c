//! What the bins do, point by point, in the background; or, under the lease, timed with nothing else running.

use std::sync::Arc;

use super::gate::OnLease;
use super::keys::SceneKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::{BuildConfig, Builder};
use crate::inspect::bin_sweep::{BinPoint, coarse_bins, measure_bins};
use crate::render::RenderSettings;
use crate::scene::{Camera, Scene};
use crate::task::Cancelled;

/// Camera rays counted for a point, about.
const RAYS: u64 = 10_000;

/// Build times are taken again under the lease only if all of them together take no longer than this: rendering
/// pauses meanwhile.
const MOST_LEASE_MS: f64 = 2500.0;

/// What a curve depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveKey {
    pub scene: SceneKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    /// Without builder and bins, which the curve sets itself.
    pub base: BuildConfig,
}

impl CurveKey {
    pub fn new(scene: SceneKey, camera: &Camera, settings: &RenderSettings, config: &BuildConfig) -> Self {
        let base = BuildConfig { builder: Builder::Binned, bins: BuildConfig::default().bins, ..*config };
        Self { scene, camera: *camera, width: settings.width, height: settings.height, base }
    }
}

/// One stretch of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stretch {
    /// A few numbers of bins, and the full sweep.
    Coarse,
    /// The same, for their build times, with nothing else running.
    Timed,
    /// All other numbers.
    Rest,
}

impl Stretch {
    /// Numbers of bins; `None` for the full sweep.
    pub fn bins(self) -> Vec<Option<usize>> {
        let coarse = coarse_bins();
        match self {
            Self::Coarse | Self::Timed => std::iter::once(None).chain(coarse.into_iter().map(Some)).collect(),
            Self::Rest => BuildConfig::BINS.filter(|b| !coarse.contains(b)).map(Some).collect(),
        }
    }
}

#[derive(Clone)]
pub struct CurveRequest {
    pub key: CurveKey,
    pub scene: Arc<Scene>,
    pub settings: RenderSettings,
    pub stretch: Stretch,
    /// Numbers of bins that are known already.
    pub skip: Vec<Option<usize>>,
}

pub enum CurveMessage {
    Point(BinPoint),
    Done,
}

pub type CurveJob = Job<CurveRequest, CurveMessage>;

pub fn job() -> CurveJob {
    Job::new(Patience::None, PoolKind::Background, |run: &Run<CurveRequest, CurveMessage>| {
        // When something changes the shell cancels, and asks again later.
        let _ = match run.request.stretch {
            Stretch::Coarse | Stretch::Rest => in_background(run),
            Stretch::Timed => alone(run),
        };
    })
}

/// Whether timing these points alone is quick enough for a break in the picture.
pub fn worth_timing(points: &[BinPoint]) -> bool {
    points.iter().map(|p| p.build_ms).sum::<f64>() <= MOST_LEASE_MS
}

fn in_background(run: &Run<CurveRequest, CurveMessage>) -> Result<(), Cancelled> {
    for bins in points(run.request) {
        let pass = run.context.gate.enter(run.task, OnLease::Finish)?;
        let point = measure(run, bins, false)?;
        drop(pass);
        run.emit(CurveMessage::Point(point));
    }
    run.emit(CurveMessage::Done);
    Ok(())
}

fn alone(run: &Run<CurveRequest, CurveMessage>) -> Result<(), Cancelled> {
    let pool = run.context.pools().get(PoolKind::Measure);
    let _lease = run.context.gate.lease(run.task)?;
    for bins in points(run.request) {
        run.emit(CurveMessage::Point(pool.install(|| measure(run, bins, true))?));
    }
    run.emit(CurveMessage::Done);
    Ok(())
}

fn points(request: &CurveRequest) -> impl Iterator<Item = Option<usize>> {
    request.stretch.bins().into_iter().filter(|bins| !request.skip.contains(bins))
}

fn measure(
    run: &Run<CurveRequest, CurveMessage>,
    bins: Option<usize>,
    alone: bool,
) -> Result<BinPoint, Cancelled> {
    let CurveRequest { key, scene, settings, .. } = run.request;
    let settings = RenderSettings { width: key.width, height: key.height, ..*settings };
    let stride = super::figures::stride(&settings, RAYS);
    measure_bins(scene, &key.camera, &key.base, bins, &settings, stride, alone, run.task)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stretches_together_are_every_number_once_and_the_sweep() {
        let mut all = Stretch::Coarse.bins();
        all.extend(Stretch::Rest.bins());
        all.sort_unstable();
        let wanted: Vec<_> = std::iter::once(None).chain(BuildConfig::BINS.map(Some)).collect();
        assert_eq!(all, wanted);
        assert!((20..=30).contains(&Stretch::Coarse.bins().len()));
    }

    #[test]
    fn the_marked_number_does_not_restart_the_curve_but_the_leaf_limit_does() {
        let key = |config: BuildConfig| {
            CurveKey::new(SceneKey::for_tests(1), &Camera::default(), &RenderSettings::default(), &config)
        };
        let base = BuildConfig::default();
        assert_eq!(key(base), key(BuildConfig { bins: 99, builder: Builder::Median, ..base }));
        assert_ne!(key(base), key(BuildConfig { leaf: 9, ..base }));
    }
}
