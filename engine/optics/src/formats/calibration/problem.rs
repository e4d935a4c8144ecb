//! Errors in files of calibrations, and their places.

use crate::calibration::CalibrationError;
use crate::formats::problem::write_placed;
use crate::prescription::Place;
use std::fmt;
use thiserror::Error;

/// An error in a file of calibrations.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationProblem {
    /// The file cannot be opened or read.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(String),
    /// The file is not text.
    #[error("this is not text in UTF-8; give a file of a camera calibration")]
    NotText,
    /// The file is no YAML or JSON.
    #[error("{0}; the file is broken off, or not YAML or JSON")]
    Syntax(String),
    /// The file has no camera.
    #[error(
        "there is no camera in it; known are OpenCV's and ROS's YAML and JSON, COLMAP's cameras.txt, Kalibr's camchain, Basalt's JSON, NVIDIA's rig and 3DEqualizer's nodes for Nuke"
    )]
    NoCamera,
    /// Something that must be there is missing.
    #[error("{camera} has no {what}; add it")]
    Missing {
        /// The camera, or the file.
        camera: String,
        /// The missing part.
        what: &'static str,
    },
    /// A text stands where something else belongs.
    #[error("'{found}' where {expected} belongs")]
    Malformed {
        /// The text that the file has there.
        found: String,
        /// The expected content.
        expected: String,
    },
    /// A list has too few or too many numbers.
    #[error("{found} numbers where {expected} belong")]
    Count {
        /// The count in the file.
        found: usize,
        /// The expected count.
        expected: String,
    },
    /// Something that the engine has no means for, without which the camera would be another.
    #[error("{0}")]
    Unsupported(String),
    /// The numbers make no camera.
    #[error("camera '{camera}': {problem}")]
    Calibration {
        /// The camera.
        camera: String,
        /// The fault of its numbers.
        problem: CalibrationError,
    },
    /// The camera that was asked for is not there.
    #[error("there is no camera '{asked}'; there is {there}")]
    NoSuchCamera {
        /// The camera that was asked for.
        asked: String,
        /// The names of the cameras in the file.
        there: String,
    },
    /// There are several cameras, and none is named.
    #[error("there are {count} cameras; choose one of {there}")]
    Several {
        /// The number of cameras.
        count: usize,
        /// Their names.
        there: String,
    },
}

/// A problem, and its place: one line, `FILE:LINE:COLUMN: fault; remedy`.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFileError {
    /// The file, as it was named.
    pub file: String,
    /// The place in the file, counted from 1.
    pub place: Place,
    /// The problem itself, without its place.
    pub problem: CalibrationProblem,
}

impl fmt::Display for CalibrationFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_placed(f, &self.file, self.place, &self.problem)
    }
}

impl std::error::Error for CalibrationFileError {}

/// A problem whose file is not yet named.
pub(super) type Placed = (Place, CalibrationProblem);

pub(super) fn malformed(place: Place, found: &str, expected: impl Into<String>) -> Placed {
    let found = found.chars().take(60).collect();
    (place, CalibrationProblem::Malformed { found, expected: expected.into() })
}

pub(super) fn unsupported(place: Place, what: impl Into<String>) -> Placed {
    (place, CalibrationProblem::Unsupported(what.into()))
}
