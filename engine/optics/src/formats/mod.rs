//! File formats of lenses, one a file.

pub mod lens;
