//! bvhscope: an inspector for bounding volume hierarchies.
//!
//! The folders are layers, each importing only what stands above it in this list:
//! `geometry` and `task`, `scene` and `accel`, `world`, `render`, `inspect`, `session`, `export`,
//! `app` and `cli`. `ARCHITECTURE.md` draws the map; `tests/layering.rs` holds it.
#![deny(unsafe_code)]

pub mod accel;
pub mod app;
pub mod cli;
pub mod export;
pub mod geometry;
pub mod inspect;
pub mod render;
pub mod scene;
pub mod session;
pub mod task;
pub mod world;
