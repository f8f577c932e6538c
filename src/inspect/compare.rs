//! Two settings side by side: every figure of A, of B, their difference and its percentage.
