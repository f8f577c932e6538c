//! One file per builder behind [`Builder`](super::Builder); boxes and a configuration in, a tree and a report out.

use crate::geometry::Aabb;
use crate::task::{Cancelled, Task};

use super::config::BuildConfig;
use super::tree::Tree;

/// A stage of a build, with its wall time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct BuildPhase {
    /// `prepare`, `split`, `widen`, `layout` ...
    pub name: &'static str,
    pub ms: f64,
}

/// What a build says of itself; times are wall times in milliseconds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct BuildReport {
    pub config: BuildConfig,
    pub phases: Vec<BuildPhase>,
    /// The sum of the phases.
    pub build_ms: f64,
    pub threads: usize,
}

/// Builds a tree over `boxes`; the index of a box is the index of its shape. The tree is the same at any thread count.
///
/// # Errors
/// [`Cancelled`] when the task was.
///
/// # Panics
/// If `config` is out of range ([`BuildConfig::check`]) or a box is empty or not finite.
pub fn build(boxes: &[Aabb], config: &BuildConfig, task: &Task) -> Result<(Tree, BuildReport), Cancelled> {
    let _ = (boxes, config, task);
    todo!()
}
