//! The effects that a plan decides on, each in a file of its own: its name and unit, its measure in a picture, whether a camera simulates
//! it, and its cost. Adding one is a file here, a variant of [`Effect`] and a line in [`Effect::home`]; `petzval/effects.py` has the label.

mod aberration;
mod colour;
mod defocus;
mod diaphragm;
mod diffraction;
mod distortion;
mod ghosts;
mod glare;
mod motion_blur;
mod sensor;
mod spectral_materials;
mod transmission;
mod vignetting;

use super::choice::CameraChoice;
use super::measured::{Known, Measured};
use super::price::Price;
use super::unit::Unit;
use crate::camera::Model;
use serde::Deserialize;

/// An effect on a picture: of the lens, of the wave nature of light, or of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Blur of subjects that are not at the focus distance.
    Defocus,
    /// Spherical aberration, coma, astigmatism, field curvature.
    Aberration,
    /// Distortion: straight lines are bent.
    Distortion,
    /// Colours of different size.
    LateralColour,
    /// Colours of different focus.
    AxialColour,
    /// Fall-off of light towards the corners.
    Vignetting,
    /// The shape of the opening in blur discs.
    Diaphragm,
    /// Something moves, or the lens changes, while the shutter is open.
    MotionBlur,
    /// Losses in glass and at coatings in each colour.
    Transmission,
    /// Light reflected between surfaces.
    Ghosts,
    /// Light scattered in the lens.
    Glare,
    /// The wave nature of light.
    Diffraction,
    /// Noise of the sensor.
    Sensor,
    /// Materials that are more than three colours.
    SpectralMaterials,
}

impl Effect {
    /// All effects, in the order of panels and reports.
    pub const ALL: [Self; 14] = [
        Self::Defocus,
        Self::Aberration,
        Self::Distortion,
        Self::LateralColour,
        Self::AxialColour,
        Self::Vignetting,
        Self::Diaphragm,
        Self::MotionBlur,
        Self::Transmission,
        Self::Ghosts,
        Self::Glare,
        Self::Diffraction,
        Self::Sensor,
        Self::SpectralMaterials,
    ];

    fn home(self) -> &'static dyn LensEffect {
        match self {
            Self::Defocus => &defocus::Defocus,
            Self::Aberration => &aberration::Aberration,
            Self::Distortion => &distortion::DistortionEffect,
            Self::LateralColour => &colour::LATERAL,
            Self::AxialColour => &colour::AXIAL,
            Self::Vignetting => &vignetting::VignettingEffect,
            Self::Diaphragm => &diaphragm::DiaphragmEffect,
            Self::MotionBlur => &motion_blur::MotionBlur,
            Self::Transmission => &transmission::TransmissionEffect,
            Self::Ghosts => &ghosts::GhostsEffect,
            Self::Glare => &glare::GlareEffect,
            Self::Diffraction => &diffraction::DiffractionEffect,
            Self::Sensor => &sensor::SensorEffect,
            Self::SpectralMaterials => &spectral_materials::SpectralMaterials,
        }
    }

    /// Name of the effect on the command line and in files.
    pub fn name(self) -> &'static str {
        self.home().name()
    }

    /// The unit of the effect's measure.
    pub fn unit(self) -> Unit {
        self.home().unit()
    }

    /// True if the effect needs a lens that is traced: it is a matter of the rays that make the picture, not of stray light.
    pub(super) fn is_of_rays(self) -> bool {
        self.home().is_of_rays()
    }

    /// False for those that this engine cannot simulate yet, or that a setting of the camera decides on: they are measured and reported.
    pub fn is_available(self) -> bool {
        self.home().is_available()
    }

    /// The reason why an effect that is not available cannot be asked for.
    pub(super) fn why_not(self) -> &'static str {
        if self == Self::Sensor {
            "the camera has its sensor by its own setting: choose one there (--sensor NAME)"
        } else {
            "it cannot be simulated yet"
        }
    }

    /// True if a simpler model of a camera has the effect (docs/camera-models.md).
    pub(super) fn is_in(self, model: Model) -> bool {
        self.home().is_in(model)
    }

    /// The size of the effect in this picture.
    pub(super) fn measure(self, known: &Known<'_>) -> Measured {
        self.home().measure(known)
    }

    /// True if a camera simulates the effect.
    pub(super) fn is_simulated(self, choice: &CameraChoice, known: &Known<'_>) -> bool {
        self.home().is_simulated(choice, known)
    }

    /// The cost of the effect beside the simulation without it, ns a sample.
    pub(super) fn cost_ns(self, choice: &CameraChoice, price: Price, known: &Known<'_>) -> f64 {
        self.home().cost_ns(choice, price, known)
    }

    /// The cost of the effect once a picture, after its samples, s.
    pub(super) fn picture_s(self, known: &Known<'_>) -> f64 {
        self.home().picture_s(known)
    }
}

/// The facts of an effect.
trait LensEffect: Sync {
    /// Name of the effect on the command line and in files.
    fn name(&self) -> &'static str;

    /// The unit of the effect's measure.
    fn unit(&self) -> Unit {
        Unit::Pixels
    }

    /// False for an effect that cannot be simulated yet, or that a setting of the camera decides on.
    fn is_available(&self) -> bool {
        true
    }

    /// False for an effect that is laid over the finished picture, or is of time.
    fn is_of_rays(&self) -> bool {
        true
    }

    /// True if a simpler model of a camera has the effect.
    fn is_in(&self, _model: Model) -> bool {
        false
    }

    /// The size of the effect in this picture.
    fn measure(&self, known: &Known<'_>) -> Measured;

    /// True if a camera simulates the effect.
    fn is_simulated(&self, choice: &CameraChoice, known: &Known<'_>) -> bool;

    /// The cost of the effect beside the simulation without it, ns a sample.
    fn cost_ns(&self, _choice: &CameraChoice, _price: Price, _known: &Known<'_>) -> f64 {
        0.0
    }

    /// The cost of the effect once a picture, after its samples, s.
    fn picture_s(&self, _known: &Known<'_>) -> f64 {
        0.0
    }
}
