//! Models of a camera.

pub mod adapted;
#[cfg(test)]
mod between_models;
pub mod calibrated;
pub mod gaussian;
pub mod image_based;
pub mod orthographic;
pub mod panoramic;
mod photographic;
pub mod pinhole;
pub mod thin;
