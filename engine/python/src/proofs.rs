//! Proofs about lenses, for `petzval lens prove`.

use crate::described::{Described, Named};
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use crate::lens::Lens;
use petzval_optics::system::LensSettings;
use petzval_proof::{CertificateOptions, certificate};
use pyo3::prelude::*;

/// See the stub.
#[pyfunction]
pub(crate) fn lens_proof_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    options: Named<CertificateOptions>,
) -> Result<String, Error> {
    let found = without_gil(py, || certificate(&lens.prescription, &settings.0, &options.0))?;
    json(&found.map_err(|error| invalid(error.to_string()))?)
}
