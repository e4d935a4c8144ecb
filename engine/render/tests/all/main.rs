//! What only whole renders show, in one program: what is generic in the engine is compiled once.

mod adaptive_sampling;
mod cameras;
mod exact_pictures;
mod light_paths;
mod plans;
mod scenes;
