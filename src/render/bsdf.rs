//! Scattering at a surface: BRDF values, PDFs, and samples of them, explicit.
