//! bvhscope: an inspector for bounding volume hierarchies.
//!
//! The folders are layers, each importing only what stands above it in this list:
//! `geometry` and `task`, `scene` and `accel`, `world`, `render`, `inspect`, `session`, `export`,
//! `app` and `cli`. `ARCHITECTURE.md` draws the map; `tests/layering.rs` holds it. All up to `inspect` are compiled as a
//! crate of their own, `engine.rs`.
#![deny(unsafe_code)]

pub use bvhscope_engine::{accel, geometry, inspect, render, scene, task, world};

pub mod app;
pub mod cli;
pub mod export;
pub mod session;
