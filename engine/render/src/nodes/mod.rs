//! Evaluating a material's inputs at a point of a surface.
//!
//! Knows textures and texture coordinates, not how the values are used.

mod around;
mod ball;
pub mod displacement;
mod images;
pub mod lamp;
mod lanes;
mod layers;
mod path_state;
mod point;
mod ray_cone;
mod strand;
#[cfg(test)]
mod tests;
pub mod volume;
pub mod world;

use crate::scene::layer::AnsweredFields;
use petzval_nodes::Context;
use point::Point;
use volume::VolumePoint;
use world::Infinity;

pub use around::SceneQueries;
pub use lanes::LaneValues;
pub use layers::{
    EvaluatedLayer, Layers, Transparency, aovs, emission, emission_at, holdout, layers, opening, plain_values,
    transmittance,
};
pub use path_state::{OF_BOUNCES, PathState};
pub use point::View;
pub use ray_cone::RayCone;

/// The fields that are answered where materials are evaluated.
pub const OF_MATERIALS: AnsweredFields =
    AnsweredFields { on_surfaces: Point::knows, in_volumes: VolumePoint::knows, along_rays: volume::varies };
/// The fields that are answered where a world is evaluated.
pub const OF_WORLDS: AnsweredFields = AnsweredFields { on_surfaces: Infinity::knows, ..OF_MATERIALS };
