//! Questions about a scene's trees, and answers as plain data. No window, no printing.

pub mod best;
pub mod bin_sweep;
pub mod columns;
pub mod compare;
pub mod histogram;
pub mod pareto;
pub mod prediction;
pub mod shadow_difference;
pub mod stats;
pub mod sweep;
pub mod table;
