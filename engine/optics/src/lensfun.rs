//! Measured calibrations of photographic lenses from a lensfun database: distortion, lateral colour and vignetting.
//!
//! [Lensfun](https://lensfun.github.io) has photographers' measurements of some 1200 lenses in XML files. Petzval reads them from an
//! installed database or from files that a user names; it does not bring them along (their licence is CC BY-SA 3.0). A
//! [`Database`] is read from a file or a folder, [`Database::find`] gives a [`CalibratedLens`] by its name, and that gives calibrations
//! at a focal length, an f-number and a distance, between the measured ones as lensfun interpolates. The formulas are those of
//! lensfun 0.3.95 (`libs/lensfun/lens.cpp`, `mod-coord.cpp`, `mod-subpix.cpp`, `mod-color.cpp`), in `f64`.
//!
//! # Coordinates
//!
//! Points are on the film, in mm from the centre of the calibration, as a real image has them (upright after the camera turned it). Lensfun
//! counts the polynomials' radii in halves of the short side of the calibration's sensor, vignetting's in halves of its diagonal, and Adobe's
//! models in focal lengths; each model here holds its own unit. *Straight* is the picture of the lens's projection without distortion (by the
//! tangent of the field's angle for a rectilinear lens), *distorted* is the real one; both have the same scale on the axis.
//!
//! Modules use only those before them: [`error`] → [`projection`] → [`distortion`] → [`lateral_colour`] → [`vignetting`] →
//! [`calibrated_lens`] → [`body`] → [`xml`] → [`database`].

pub mod body;
pub mod calibrated_lens;
pub mod database;
pub mod distortion;
pub mod error;
pub mod lateral_colour;
pub mod projection;
pub mod vignetting;
mod xml;

pub use body::Body;
pub use calibrated_lens::CalibratedLens;
pub use database::Database;
pub use distortion::Distortion;
pub use error::LensfunError;
pub use lateral_colour::LateralColour;
pub use projection::Projection;
pub use vignetting::Vignetting;

/// Diagonal of a film of 36 by 24 mm, to which crop factors refer.
pub const FULL_DIAGONAL_MM: f64 = 43.266_615_305_567_87;

/// The sensor that a calibration was made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// [`FULL_DIAGONAL_MM`] over the sensor's diagonal.
    pub crop_factor: f64,
    /// The longer side over the shorter.
    pub aspect_ratio: f64,
}

impl Sensor {
    /// Half of the diagonal: the farthest that the calibration was measured.
    pub fn half_diagonal_mm(&self) -> f64 {
        0.5 * FULL_DIAGONAL_MM / self.crop_factor
    }

    /// Half of the short side.
    pub fn half_short_side_mm(&self) -> f64 {
        self.half_diagonal_mm() / self.aspect_ratio.hypot(1.0)
    }
}
