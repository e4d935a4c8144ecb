//! Tests that only whole renders can make, in one program: the generic code of the engine is compiled once.

mod adaptive_sampling;
mod cameras;
mod corpora;
mod exact_pictures;
mod light_paths;
mod light_tracing;
mod plans;
mod scenes;
