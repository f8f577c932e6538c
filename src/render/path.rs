//! The path tracer: the rendering equation by cosine-weighted and light sampling with multiple importance sampling.
