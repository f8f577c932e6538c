//! Improvers: steps after a build that make a better binary tree of the one that a builder found.

mod refit;
mod reinsertion;
mod rotations;

use crate::task::{Cancelled, Task};

use super::build::Onlooker;
use super::bvh2::{Bvh2, Bvh2Node};
use super::config::{BuildConfig, Improver};
use super::quality::binary_sah_cost;

pub use refit::refit;

/// The least gain worth a round, as a share of the sum of all areas.
const WORTHWHILE: f64 = 1e-7;

/// Improves a tree by the configuration's improver, in place, round by round, until one gains nothing. Answers the SAH cost
/// before, and after each round that changed anything; `None` where it is undefined.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn improve(
    bvh: &mut Bvh2,
    config: &BuildConfig,
    onlooker: &mut Onlooker,
    task: &Task,
) -> Result<Vec<Option<f64>>, Cancelled> {
    let cost = |bvh: &Bvh2| binary_sah_cost(bvh, config.traversal_cost, config.intersection_cost);
    let round = match config.improver {
        Improver::None => return Ok(Vec::new()),
        Improver::Reinsertion => reinsertion::round,
        Improver::Rotations => rotations::round,
    };
    let mut costs = vec![cost(bvh)];
    onlooker.improved(bvh);
    // A root and its two children leave nothing to choose.
    let rounds = if bvh.nodes.len() < 5 { 0 } else { config.rounds };
    for _ in 0..rounds {
        let before = sum_of_areas(&bvh.nodes);
        let Some(nodes) = round(&bvh.nodes, config, task)? else { break };
        let gained = before - sum_of_areas(&nodes);
        let better = Bvh2 { nodes, refs: std::mem::take(&mut bvh.refs) };
        if gained <= WORTHWHILE * before || better.depth_max() > BuildConfig::MAX_DEPTH {
            bvh.refs = better.refs;
            break;
        }
        *bvh = better.in_depth_first_order();
        costs.push(cost(bvh));
        onlooker.improved(bvh);
    }
    Ok(costs)
}

/// Of all inner nodes, as half areas.
fn sum_of_areas(nodes: &[Bvh2Node]) -> f64 {
    nodes.iter().filter(|node| !node.is_leaf()).map(|node| f64::from(node.bounds.half_area())).sum()
}
