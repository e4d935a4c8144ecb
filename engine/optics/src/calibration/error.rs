//! The faults of a calibration, and the reasons why a point or direction has no other.

use super::Model;
use thiserror::Error;

/// An error in the numbers of a calibration.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationError {
    /// There are too few or too many numbers.
    #[error("{found} parameters where the model {} has {expected}", .model.name())]
    Count {
        /// The model.
        model: Model,
        /// The number of its parameters.
        expected: usize,
        /// The number that was given.
        found: usize,
    },
    /// A number is infinite or none.
    #[error("{name} is {value}, no finite number")]
    NotFinite {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// A number is out of the range in which the model means something.
    #[error("{name} is {value}; {expected}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// The condition that it breaks.
        expected: &'static str,
    },
    /// The numbers seem to count something else than pixels.
    #[error(
        "{name} is {value} in a picture {side_px} pixels wide or high: it counts pixels, not parts of the picture or millimetres"
    )]
    Units {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// The picture's side along it.
        side_px: u32,
    },
    /// The picture has no pixels.
    #[error("the picture is {0} x {1} pixels; both must be above zero")]
    NoPixels(u32, u32),
    /// The distortion turns the picture over or flattens it in its middle already.
    #[error(
        "the distortion folds already in the middle of the picture: look at the signs and units of its coefficients"
    )]
    FoldsAtCentre,
    /// The sensor is turned so far that it is seen from the side.
    #[error("the sensor is tilted by {tau_x} and {tau_y} rad, so that it is seen edge on; a tilt is well below 1.57")]
    SingularTilt {
        /// Turn about the x axis.
        tau_x: f64,
        /// Turn about the y axis.
        tau_y: f64,
    },
    /// An ST map has no values to speak of.
    #[error("the ST map {0}")]
    StMap(&'static str),
}

/// The reason why a direction has no point in the plane of the picture, or a point no direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Outside {
    /// The model's projection has no such direction or point: as behind a pinhole.
    #[error("the model's projection ends before")]
    Projection,
    /// The distortion folds back nearer to the middle, or reaches no such point.
    #[error("the distortion folds back before")]
    Fold,
    /// The point lies beyond the horizon of a tilted sensor.
    #[error("it is beyond the horizon of the tilted sensor")]
    Horizon,
    /// The direction or point is not finite, or has no length.
    #[error("it is not finite, or has no length")]
    NotFinite,
}
