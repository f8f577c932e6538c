//! A grid over bins and leaf limits.
