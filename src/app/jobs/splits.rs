//! The split costs of a node: a million references are sorted three times.

use std::sync::Arc;

use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::accel::NodeId;
use crate::app::splitting::FoundSplits;
use crate::inspect::census::Census;
use crate::inspect::split_curve::SplitCurve;
use crate::task::Cancelled;
use crate::world::World;

#[derive(Clone)]
pub struct SplitRequest {
    pub tree: TreeKey,
    pub world: Arc<World>,
    pub census: Arc<Census>,
    pub node: NodeId,
    /// Of the build, and held beside them.
    pub bins: [usize; 2],
    /// The curve, if it is known already.
    pub known: Option<Arc<SplitCurve>>,
}

pub type SplitJob = Job<SplitRequest, FoundSplits>;

pub fn job() -> SplitJob {
    Job::new(Patience::None, PoolKind::Draw, |run: &Run<SplitRequest, FoundSplits>| {
        // A cancelled one says nothing; the next one is on its way.
        if let Ok(found) = find(run) {
            run.emit(found);
        }
    })
}

fn find(run: &Run<SplitRequest, FoundSplits>) -> Result<FoundSplits, Cancelled> {
    let SplitRequest { tree, world, census, node, bins, known } = run.request;
    let curve = match known {
        Some(curve) => Arc::clone(curve),
        None => Arc::new(SplitCurve::of(world, &census.family, *node, run.task)?),
    };
    run.task.check()?;
    let planes = bins.map(|bins| curve.binned(bins));
    Ok(FoundSplits { tree: *tree, curve, planes })
}
