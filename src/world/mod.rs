//! The only place where a scene meets its trees: rays are asked here.

pub mod store;

use std::sync::Arc;

use crate::accel::quality::TreeFigures;
use crate::accel::{BuildConfig, BuildReport, Probe, Tree};
use crate::geometry::{Hit, Ray};
use crate::scene::{Scene, ShadowRule};
use crate::task::{Cancelled, Task};

pub use store::PrimStore;

/// A frozen scene with one tree over its bounded shapes. Immutable; share it behind an `Arc`.
#[derive(Debug)]
pub struct World {
    pub scene: Arc<Scene>,
    pub tree: Tree,
    pub report: BuildReport,
    pub figures: TreeFigures,
    store: PrimStore,
}

impl World {
    /// Builds the tree that `config` describes over the scene's bounded shapes. In debug builds the tree is validated.
    ///
    /// # Errors
    /// [`Cancelled`] when the task was.
    pub fn build(scene: Arc<Scene>, config: &BuildConfig, task: &Task) -> Result<Self, Cancelled> {
        let _ = (scene, config, task);
        todo!()
    }

    /// Tree and primitive store together, ready to trace, in bytes.
    pub fn bytes(&self) -> usize {
        todo!()
    }

    /// The nearest hit in `t_min..=t_max`, planes and ground included.
    #[inline]
    pub fn intersect<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let _ = (ray, probe);
        todo!()
    }

    /// Whether anything at all lies in `t_min..=t_max`: the shape that was found first.
    #[inline]
    pub fn occluded<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<u32> {
        let _ = (ray, probe);
        todo!()
    }

    /// Whether a shape lies in `t_min..=t_max` that blocks light under `rule`: the one that was found first.
    #[inline]
    pub fn occluded_filtered<P: Probe>(&self, ray: &Ray, rule: ShadowRule, probe: &mut P) -> Option<u32> {
        let _ = (ray, rule, probe);
        todo!()
    }

    /// The same question answered by nearest hits: while the nearest hit's material lets light pass, goes on along the
    /// same ray by t, past that shape. The blocking shape, if there is one.
    pub fn occluded_by_intersect<P: Probe>(&self, ray: &Ray, rule: ShadowRule, probe: &mut P) -> Option<u32> {
        let _ = (ray, rule, probe);
        todo!()
    }
}
