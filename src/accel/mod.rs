//! Trees over boxes: how they are built, walked, measured and checked. Never names a scene, a shape or a material;
//! a builder sees boxes, and traversal asks a [`traverse::LeafIntersector`] about what lies in a leaf.

pub mod build;
mod bvh2;
mod choices;
pub mod compressed;
pub mod config;
pub mod exchange;
mod family;
mod optimize;
mod optimum;
pub mod quality;
pub mod simd;
pub mod split_costs;
pub mod traverse;
pub mod tree;
pub mod validate;
pub mod widen;

pub use build::{BuildPhase, BuildReport, Shapes, build, build_over, build_watched};
pub use bvh2::{Bvh2, Bvh2Node};
pub use compressed::CompressedBvh;
pub use config::{
    Block, BuildConfig, Builder, ConfigError, Improver, Layout, Morton, StopRule, Update, Widen, Width,
};
pub use exchange::{FormError, RawTree};
pub use family::Family;
pub use optimize::refit;
pub use traverse::{LeafIntersector, Probe, RayCounters};
pub use tree::{ChildRef, NodeId, NodeKind, NodeView, Nodes, Tree, WideBvh};
