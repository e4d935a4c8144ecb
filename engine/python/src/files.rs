//! Files that are replaced only by complete ones, and checkpoints, for Python.

use crate::error::{Error, invalid};
use crate::gil::without_gil;
use petzval_files::{Replacement, check_place};
use petzval_render::job::checkpoint::{OwnFile, check_file};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::io;
use std::path::{Path, PathBuf};

/// An error of the system as Python has it: its number, its words and the file.
pub(crate) fn os_error(error: &io::Error, file: &Path) -> PyErr {
    let text = error.to_string();
    match error.raw_os_error() {
        Some(number) => {
            let words = text.rsplit_once(" (os error").map_or(text.as_str(), |(words, _)| words).to_owned();
            PyOSError::new_err((number, words, file.to_owned()))
        }
        None => PyOSError::new_err((0, text, file.to_owned())),
    }
}

/// See the stub.
#[pyclass]
pub(crate) struct FileReplacement {
    place: PathBuf,
    /// The replacement, until it is committed or abandoned.
    replacement: Option<Replacement>,
}

#[pymethods]
impl FileReplacement {
    #[new]
    fn new(place: PathBuf) -> PyResult<Self> {
        let replacement = Replacement::new(&place).map_err(|error| os_error(&error, &place))?;
        Ok(Self { place, replacement: Some(replacement) })
    }

    #[getter]
    fn part(&self) -> Result<PathBuf, Error> {
        self.replacement.as_ref().map(|made| made.part().to_owned()).ok_or_else(gone)
    }

    fn commit(&mut self, py: Python<'_>) -> Result<(), Error> {
        let replacement = self.replacement.take().ok_or_else(gone)?;
        without_gil(py, || replacement.commit())?.map_err(|error| os_error(&error, &self.place).into())
    }

    fn abandon(&mut self) {
        self.replacement = None;
    }
}

fn gone() -> Error {
    invalid("the temporary file is gone: it was committed or abandoned")
}

/// See the stub.
#[pyfunction]
pub(crate) fn check_replaceable(file: PathBuf) -> PyResult<()> {
    check_place(&file).map_err(|error| os_error(&error, &file))
}

/// See the stub.
#[pyfunction]
pub(crate) fn checkpoint_problem(file: PathBuf) -> Option<String> {
    check_file(&file).err()
}

/// See the stub.
#[pyclass(frozen)]
pub(crate) struct Checkpoint(pub(crate) OwnFile);

#[pymethods]
impl Checkpoint {
    #[getter]
    fn path(&self) -> PathBuf {
        self.0.path.clone()
    }

    fn delete(&self) -> bool {
        self.0.delete()
    }
}

/// See the stub.
#[pyfunction]
pub(crate) fn read_bounded<'py>(py: Python<'py>, file: PathBuf, most: u64) -> PyResult<Bound<'py, PyBytes>> {
    let bytes =
        without_gil(py, || petzval_files::read_bounded(&file, most))?.map_err(|error| os_error(&error, &file))?;
    Ok(PyBytes::new(py, &bytes))
}
