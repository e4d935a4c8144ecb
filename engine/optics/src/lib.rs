//! Exact and paraxial optics of real lenses.
