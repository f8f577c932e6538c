//! The window. The only place that names egui. Owns its state and asks nothing of the process.
//!
//! A frame is: receive finished work, draw panels, apply commands, start work.

pub mod commands;
pub mod jobs;
pub mod panels;
pub mod theme;
pub mod view;
