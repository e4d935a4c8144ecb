//! The one map from the engine's errors to Python's exceptions.

use petzval_nodes::Parsing;
use petzval_optics::focus::{FocusError, GroupsError};
use petzval_optics::formats::calibration::CalibrationFileError;
use petzval_optics::formats::lens::LensFileError;
use petzval_optics::system::SystemError;
use petzval_pictures::error::MergeError;
use petzval_render::camera::CameraError;
use petzval_render::job::SettingsError;
use petzval_render::job::bake::BakeError;
use petzval_render::job::denoise::DenoiseError;
use petzval_render::job::request::RequestError;
use petzval_render::plan::PlanError;
use petzval_render::reports::ReportError;
use petzval_render::scene::SceneError;
use petzval_render::sensor::SensorError;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use serde::Serialize;

create_exception!(_native, PetzvalError, PyException, "Anything the engine refuses: what, where, what to do.");
create_exception!(_native, LensError, PetzvalError, "A lens file that cannot be read, or a lens that cannot be set.");
create_exception!(_native, SceneError_, PetzvalError, "A piece of a scene that does not fit.");
create_exception!(_native, CameraError_, PetzvalError, "A camera that cannot photograph.");

pub(crate) fn register(m: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = m.py();
    m.add("PetzvalError", py.get_type::<PetzvalError>())?;
    m.add("LensError", py.get_type::<LensError>())?;
    m.add("SceneError", py.get_type::<SceneError_>())?;
    m.add("CameraError", py.get_type::<CameraError_>())?;
    Ok(())
}

/// An engine error on its way to Python.
pub(crate) struct Error(PyErr);

impl From<Error> for PyErr {
    fn from(e: Error) -> Self {
        e.0
    }
}

impl From<PyErr> for Error {
    fn from(e: PyErr) -> Self {
        Self(e)
    }
}

macro_rules! maps {
    ($($engine:ty => $python:ty),* $(,)?) => {
        $(impl From<$engine> for Error {
            fn from(e: $engine) -> Self {
                Self(PyErr::new::<$python, _>(e.to_string()))
            }
        })*
    };
}

maps! {
    LensFileError => LensError,
    SystemError => LensError,
    FocusError => LensError,
    GroupsError => LensError,
    SceneError => SceneError_,
    MergeError => PetzvalError,
    Parsing => SceneError_,
    CameraError => CameraError_,
    CalibrationFileError => CameraError_,
    SettingsError => PetzvalError,
    DenoiseError => PetzvalError,
    BakeError => PetzvalError,
    PlanError => PetzvalError,
    SensorError => PetzvalError,
}

/// A report as JSON. Numbers that are not finite are null.
pub(crate) fn json(report: &impl Serialize) -> Result<String, Error> {
    serde_json::to_string(report).map_err(|error| invalid(format!("the report is no JSON: {error}")))
}

/// An argument from Python is not of the expected kind.
pub(crate) fn invalid(what: impl Into<String>) -> Error {
    Error(PyErr::new::<PetzvalError, _>(what.into()))
}

/// A piece of a scene from Python is not of the expected kind.
pub(crate) fn bad_scene(what: impl Into<String>) -> Error {
    Error(PyErr::new::<SceneError_, _>(what.into()))
}

impl From<ReportError> for Error {
    fn from(e: ReportError) -> Self {
        match e {
            ReportError::System(e) => e.into(),
            ReportError::Focus(e) => e.into(),
            ReportError::Groups(e) => e.into(),
            ReportError::Calibration(e) => e.into(),
            ReportError::Camera(e) => e.into(),
            other => invalid(other.to_string()),
        }
    }
}

impl From<RequestError> for Error {
    fn from(e: RequestError) -> Self {
        match e {
            RequestError::Camera(e) => e.into(),
            RequestError::Settings(e) => e.into(),
            RequestError::Bake(e) => e.into(),
        }
    }
}
