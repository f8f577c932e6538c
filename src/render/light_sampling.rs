//! Points on lights, with their PDFs by solid angle.
