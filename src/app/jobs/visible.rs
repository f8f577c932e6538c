//! The scene without what is hidden: a tree of its own, for pictures that do not depend on the tree.

use std::sync::Arc;

use super::keys::SceneKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::BuildConfig;
use crate::scene::Scene;
use crate::world::World;

/// One scene without some shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleKey {
    pub scene: SceneKey,
    /// [`Hidden::version`](crate::app::selection::Hidden).
    pub hidden: u64,
}

#[derive(Clone)]
pub struct VisibleRequest {
    pub key: VisibleKey,
    pub scene: Arc<Scene>,
    pub hidden: Arc<Vec<u32>>,
}

pub type VisibleJob = Job<VisibleRequest, (VisibleKey, World)>;

pub fn job() -> VisibleJob {
    Job::new(Patience::None, PoolKind::Build, |run: &Run<VisibleRequest, _>| {
        let VisibleRequest { key, scene, hidden } = run.request;
        // A cancelled one says nothing; the next one is on its way.
        if let Ok(world) = World::without(Arc::clone(scene), hidden, &BuildConfig::default(), run.task) {
            run.emit((*key, world));
        }
    })
}
