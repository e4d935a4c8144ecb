//! The reasons why a lens cannot be adjusted to a calibration.

use thiserror::Error;

use crate::chief_rays::ChiefRayError;
use crate::focus::GroupsError;
use crate::system::SystemError;

/// The reason why a lens cannot be adjusted.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LensFitError {
    /// The lens has no chief rays.
    #[error(transparent)]
    ChiefRays(#[from] ChiefRayError),
    /// The lens cannot be set.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The lens cannot be focused.
    #[error(transparent)]
    Groups(#[from] GroupsError),
    /// The calibration does not see straight ahead.
    #[error("the calibration does not see straight ahead, so it has no principal point to put the lens's axis on")]
    NoAxis,
    /// Lens and calibration have no part of the picture in common.
    #[error(
        "lens and calibration have {points} of {all} places of the picture in common; look at the pixels' size and the focal length"
    )]
    TooLittle {
        /// Places that both see.
        points: usize,
        /// Places that were looked at.
        all: usize,
    },
    /// No adjustment is asked for.
    #[error("nothing is to be adjusted; name focal-length, focus, film-distance, or gaps")]
    Nothing,
    /// Film distance and focus are one.
    #[error(
        "focus and film-distance are one quantity of a lens that is focused by moving its film: adjust one of them"
    )]
    FocusIsFilm,
    /// A surface has no such gap.
    #[error("behind surface {surface} is no fixed gap in air inside of the lens; there are {there}")]
    NoGap {
        /// The surface that was named.
        surface: usize,
        /// The surfaces before gaps.
        there: String,
    },
    /// The tolerance is no positive number.
    #[error("a tolerance of {0} for gaps; give one above zero, and as a part less than all of the gap")]
    Tolerance(f64),
}
