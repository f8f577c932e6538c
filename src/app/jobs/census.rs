//! What the Tree panel and the selection need to know of every node, found out piece by piece.

use std::sync::Arc;

use super::gate::OnLease;
use super::keys::TreeKey;
use super::newest::Patience;
use super::{Job, PoolKind, Run};
use crate::inspect::census::{Census, Visits};
use crate::inspect::overlaps::{OverlapMeasure, OverlappingPair, worst_pairs};
use crate::render::visits::node_visits;
use crate::render::{CountKind, RenderSettings};
use crate::scene::Camera;
use crate::task::Cancelled;
use crate::world::{NodeFigure, World};

/// Pairs that the list of overlaps holds at most.
pub const MOST_PAIRS: usize = 1000;

/// What visits depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisitsKey {
    pub tree: TreeKey,
    pub camera: Camera,
    pub width: u32,
    pub height: u32,
    pub count: CountKind,
}

/// What is to be found out besides the family.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CensusWants {
    pub figure: Option<NodeFigure>,
    pub sah_below: bool,
    pub overlaps: Option<OverlapMeasure>,
    pub visits: Option<VisitsKey>,
}

impl CensusWants {
    /// Whether a request for `asked` finds out all of this, too.
    pub fn is_within(&self, asked: &Self) -> bool {
        fn of<T: PartialEq>(wanted: Option<T>, asked: Option<T>) -> bool {
            wanted.is_none() || wanted == asked
        }
        of(self.figure, asked.figure)
            && (asked.sah_below || !self.sah_below)
            && of(self.overlaps, asked.overlaps)
            && of(self.visits, asked.visits)
    }
}

#[derive(Clone)]
pub struct CensusRequest {
    pub tree: TreeKey,
    pub world: Arc<World>,
    /// What is known already.
    pub census: Option<Arc<Census>>,
    pub settings: RenderSettings,
    pub wants: CensusWants,
}

pub enum CensusMessage {
    /// Something more is known.
    Census {
        tree: TreeKey,
        census: Arc<Census>,
    },
    Overlaps {
        tree: TreeKey,
        measure: OverlapMeasure,
        pairs: Vec<OverlappingPair>,
    },
    Visits {
        key: VisitsKey,
        visits: Visits,
    },
}

pub type CensusJob = Job<CensusRequest, CensusMessage>;

pub fn job() -> CensusJob {
    Job::new(Patience::None, PoolKind::Background, |run: &Run<CensusRequest, CensusMessage>| {
        // A cancelled one says no more; the next one is on its way.
        let _ = find(run);
    })
}

fn find(run: &Run<CensusRequest, CensusMessage>) -> Result<(), Cancelled> {
    let _pass = run.context.gate.enter(run.task, OnLease::Finish)?;
    let CensusRequest { tree, world, census, settings, wants } = run.request;
    let census = match census {
        Some(census) => Arc::clone(census),
        None => Arc::new(Census::of(world, run.task)?),
    };
    let tell = || run.emit(CensusMessage::Census { tree: *tree, census: Arc::clone(&census) });
    tell();
    if let Some(figure) = wants.figure {
        census.values(world, figure, &run.task.step())?;
        tell();
    }
    if wants.sah_below {
        census.find_sah_below(world, &run.task.step())?;
        tell();
    }
    if let Some(measure) = wants.overlaps {
        let pairs = worst_pairs(world.shown_tree(), measure, MOST_PAIRS, run.task)?;
        run.emit(CensusMessage::Overlaps { tree: *tree, measure, pairs });
    }
    if let Some(key) = wants.visits {
        let settings = RenderSettings { width: key.width, height: key.height, ..*settings };
        let visits = node_visits(world, &key.camera, &settings, key.count, &run.task.step())?;
        run.emit(CensusMessage::Visits { key, visits: Visits::new(&census, &visits) });
    }
    Ok(())
}
