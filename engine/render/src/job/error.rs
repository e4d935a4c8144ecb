//! The errors that keep a render from starting.

use super::SettingsError;
use super::bake::BakeError;
use crate::camera::CameraError;

/// An error by which a render does not start.
#[derive(Debug, thiserror::Error)]
pub enum RequestError {
    /// A camera makes no picture.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Points are not of the baked object.
    #[error(transparent)]
    Bake(#[from] BakeError),
}
