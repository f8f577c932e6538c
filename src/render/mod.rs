//! Pixels from a world: integrators, views, film, the boxes drawn over it, and what was measured on rays.

pub mod bench;
pub mod bsdf;
pub mod difference;
pub mod display;
pub mod film;
pub mod integrate;
pub mod light_sampling;
pub mod measure;
pub mod observer;
pub mod overlay;
pub mod pass;
pub mod path;
pub mod rank;
pub mod ray_costs;
pub mod sampler;
pub mod shadow;
mod tiles;
pub mod tonemap;
pub mod views;
pub mod visits;
pub mod whitted;

pub use display::{ColorMap, ColorScale, DisplaySettings};
pub use film::{Film, RenderSettings};
pub use overlay::{BoxStyle, Overlay, OverlaySettings};
pub use tonemap::ToneMap;
pub use views::{CountKind, Counter, View, ViewClass};
