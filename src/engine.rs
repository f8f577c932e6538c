//! The engine of bvhscope: all layers up to `inspect`. It is a crate of its own because it takes minutes to compile, for four
//! kinds of instructions and five kinds of trees, and panels, commands and sessions change far more often.
#![deny(unsafe_code)]

pub mod accel;
pub mod geometry;
pub mod inspect;
pub mod render;
pub mod scene;
pub mod task;
pub mod world;
