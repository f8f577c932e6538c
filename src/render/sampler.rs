//! Seeded random numbers, reproducible by pixel and sample at any thread count.
