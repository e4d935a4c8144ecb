//! The data on which decisions are based, and the form of a measure.

use super::motion::SceneMotion;
use super::unit::Unit;
use super::words::worst;
use super::{GhostLook, LensNeed};
use crate::camera::CameraDescription;
use crate::camera::tools::survey::{LensMeasures, Survey, Worst};

/// The data on which decisions are based.
pub(super) struct Known<'a> {
    pub(super) d: &'a CameraDescription,
    pub(super) survey: &'a Survey,
    pub(super) lens: LensMeasures,
    /// The motion by changes of the lens; `None` where it stands still.
    pub(super) motion: Option<Worst>,
    /// The motion of the scene or the camera; `None` where neither moves.
    pub(super) scene_motion: Option<SceneMotion>,
    /// Ghosts of the brightest sources.
    pub(super) ghosts: Option<GhostLook>,
    /// Irradiance on the front over that of a world as bright as the picture all over; `None` of a black picture.
    pub(super) front_light: Option<f64>,
    /// The part of the light that the lens scatters.
    pub(super) glare: f64,
    /// Distance from the edge of the brightest source up to which diffraction's light is seen, px.
    pub(super) seen_px: f64,
    /// Number of pixels of the picture.
    pub(super) pixels: f64,
    /// The need for a traced lens in which rays from lights end.
    pub(super) lens_need: LensNeed,
}

/// The size of an effect, and its description.
pub(super) struct Measured {
    /// The measure, as [`super::Decision::measure`].
    pub(super) value: Option<f64>,
    /// The size, in words.
    pub(super) text: String,
}

impl Measured {
    /// The measure of the worst place in the picture.
    pub(super) fn at(one: Worst, unit: Unit) -> Self {
        Self { value: Some(one.value), text: worst(one, unit) }
    }

    /// The measure of an effect that changes nothing, and the reason.
    pub(super) fn nothing(why: impl Into<String>) -> Self {
        Self { value: Some(0.0), text: why.into() }
    }

    /// A measure with its text.
    pub(super) fn new(value: f64, text: impl Into<String>) -> Self {
        Self { value: Some(value), text: text.into() }
    }
}
