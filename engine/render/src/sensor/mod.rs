//! A sensor that counts photons: from a picture's linear colours to the numbers of a raw file.
//!
//! The model is that of the EMVA Standard 1288, Release 4.0 Linear. A photosite receives μ_p photons in the exposure time t, of which it turns
//! μ_e = η μ_p into electrons (equation 2; η is the quantum efficiency). The dark current adds μ_I t electrons. Both are counted by a Poisson
//! process (equation 9), up to the full well. Electrons of the read noise σ_d are added, the system gain K, DN per electron, makes numbers of
//! them, and these are rounded to whole ones (σ_q² = 1/12 DN²): σ_y² = K² (σ_d² + μ_e) + σ_q² (equation 11). Photosites differ by a share of
//! their response (PRNU) and by electrons in the dark (DSNU).
//!
//! Modules use only those before them: [`random`] → [`mosaic`] → [`file`] → [`exposure`] → [`response`] → [`film`] → [`expose`] → [`photograph`] → [`report`].

use petzval_pictures::error::MergeError;

pub mod expose;
pub mod exposure;
pub mod file;
pub mod film;
pub mod mosaic;
pub mod photograph;
pub mod random;
pub mod report;
pub mod response;

#[cfg(test)]
mod tests;

/// An error of a sensor's file, its settings or its picture.
#[derive(Debug, thiserror::Error)]
pub enum SensorError {
    /// A name that is neither that of a shipped sensor nor of a file.
    #[error("no such sensor: {name}: name a file, or one of {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The shipped sensors.
        known: String,
    },
    /// A file that cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Read {
        /// The file.
        file: String,
        /// The reason.
        reason: String,
    },
    /// A file with a value that no sensor has.
    #[error("{file}: {what}")]
    File {
        /// The file, or the shipped sensor's name.
        file: String,
        /// The value, and the expected one.
        what: String,
    },
    /// A setting of the exposure that is none.
    #[error("{0}")]
    Exposure(String),
    /// A picture that is none of light.
    #[error("{0}")]
    Picture(String),
    /// A picture or a raw file that cannot be read or written.
    #[error(transparent)]
    Pixels(#[from] MergeError),
}
