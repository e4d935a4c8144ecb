//! Settings that come from Python whole: the dataclasses of `petzval/description.py`, deserialized into the engine's own types.

use crate::error::invalid;
use pyo3::prelude::*;
use serde::de::DeserializeOwned;

/// An argument that is a dataclass of settings.
pub(crate) struct Described<T>(pub(crate) T);

impl<'py, T: DeserializeOwned> FromPyObject<'_, 'py> for Described<T> {
    type Error = PyErr;

    fn extract(from: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let fields = from.py().import("dataclasses")?.call_method1("asdict", (from,))?;
        pythonize::depythonize(&fields).map(Self).map_err(|error| {
            // A camera says which.
            let owner = from.getattr("object_name").map(|name| format!("camera '{name}': ")).unwrap_or_default();
            invalid(format!("{owner}{error}")).into()
        })
    }
}

/// An argument that is the name of a variant, or a dictionary of values by such names.
pub(crate) struct Named<T>(pub(crate) T);

impl<'py, T: DeserializeOwned> FromPyObject<'_, 'py> for Named<T> {
    type Error = PyErr;

    fn extract(from: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        pythonize::depythonize(&from).map(Self).map_err(|error| invalid(error.to_string()).into())
    }
}
