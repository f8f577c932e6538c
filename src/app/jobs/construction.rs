//! How a tree came about: what was made in rounds is built once more.

use std::sync::Arc;

use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::construction::Construction;
use crate::world::World;

#[derive(Clone)]
pub struct ConstructionRequest {
    pub tree: TreeKey,
    pub world: Arc<World>,
}

pub type ConstructionJob = Job<ConstructionRequest, (TreeKey, Construction)>;

pub fn job() -> ConstructionJob {
    Job::new(Patience::None, PoolKind::Work, |run: &Run<ConstructionRequest, _>| {
        let ConstructionRequest { tree, world } = run.request;
        // A cancelled one says nothing; the next one is on its way.
        if let Ok(construction) = Construction::of(world, run.task) {
            run.emit((*tree, construction));
        }
    })
}
