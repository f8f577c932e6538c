//! Binary to wide: children with the largest area opened first.
