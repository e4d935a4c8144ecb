//! Evaluating a material's inputs at a point of a surface.
//!
//! Knows textures and texture coordinates, not how the values are used.

mod around;
mod ball;
pub mod displacement;
pub mod lamp;
mod layers;
mod point;
mod strand;
pub mod volume;
mod way;
pub mod world;

pub use around::Around;
pub use layers::{
    EvaluatedLayer, Layers, Opening, aovs, emission, emission_at, hole, layers, opening, plain_values, transmittance,
};
pub use point::View;
pub use way::{OF_BOUNCES, Way};
