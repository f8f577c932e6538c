//! Questions about a scene's trees, and answers as plain data. No window, no printing.

pub mod best;
pub mod bin_sweep;
pub mod census;
pub mod columns;
pub mod compare;
pub mod construction;
pub mod difference;
pub mod histogram;
pub mod icicle;
pub mod node;
pub mod numbers;
pub mod outline;
pub mod overlaps;
pub mod paired_cost;
pub mod pareto;
pub mod plot;
pub mod prediction;
pub mod ray_history;
pub mod ray_tree;
pub mod region;
pub mod shadow_difference;
pub mod split_curve;
pub mod stats;
pub mod sweep;
pub mod table;
