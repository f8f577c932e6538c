//! Improvers: steps after a build that make a better binary tree of the one that a builder found.

mod reinsertion;

use crate::task::{Cancelled, Task};

use super::bvh2::Bvh2;
use super::config::{BuildConfig, Improver};
use super::quality::binary_sah_cost;

/// Improves a tree by the configuration's improver, in place. Answers the SAH cost before, and after each round that
/// changed anything; `None` where it is undefined.
///
/// # Errors
/// [`Cancelled`] when the task was.
pub fn improve(bvh: &mut Bvh2, config: &BuildConfig, task: &Task) -> Result<Vec<Option<f64>>, Cancelled> {
    let cost = |bvh: &Bvh2| binary_sah_cost(bvh, config.traversal_cost, config.intersection_cost);
    let mut costs = Vec::new();
    match config.improver {
        Improver::None => {}
        Improver::Reinsertion => {
            costs.push(cost(bvh));
            reinsertion::reinsert(bvh, config, task, &mut |bvh| costs.push(cost(bvh)))?;
        }
    }
    Ok(costs)
}
