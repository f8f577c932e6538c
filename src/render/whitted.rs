//! Whitted ray tracing: direct light, mirrors and glass.
