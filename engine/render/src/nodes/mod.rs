//! Evaluating a material's inputs at a point of a surface.
//!
//! Knows textures and texture coordinates, not how the values are used.

mod around;
mod ball;
pub mod displacement;
pub mod lamp;
mod layers;
mod path_state;
mod point;
mod strand;
pub mod volume;
pub mod world;

pub use around::SceneQueries;
pub use layers::{
    EvaluatedLayer, Layers, Transparency, aovs, emission, emission_at, holdout, layers, opening, plain_values,
    transmittance,
};
pub use path_state::{OF_BOUNCES, PathState};
pub use point::View;
