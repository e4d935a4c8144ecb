//! Reports on lenses, for `petzval lens`.

use crate::described::{Described, Named};
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use crate::lens::Lens;
use petzval_optics::prescription::LensGroup;
use petzval_optics::system::LensSettings;
use petzval_render::reports::drawing::{DrawnLight, drawing};
use petzval_render::reports::fitted_lens::{FittedLensOptions, fitted_lens};
use petzval_render::reports::ghosts::{GhostSource, ghosts};
use petzval_render::reports::reality::{RealityOptions, reality};
use petzval_render::reports::{ReportSettings, report};
use pyo3::prelude::*;
use serde_json::Value;
use std::path::PathBuf;

/// See the stub.
#[pyfunction]
pub(crate) fn lens_report_json(
    py: Python<'_>,
    name: &str,
    lens: &Lens,
    lens_settings: Described<LensSettings>,
    settings: Described<ReportSettings>,
    options: Named<Value>,
) -> Result<String, Error> {
    Ok(without_gil(py, || report(name, &lens.prescription, &lens_settings.0, &settings.0, options.0))??)
}

/// See the stub.
#[pyfunction]
#[pyo3(signature = (lens, settings = None, fields_deg = Vec::new(), rays = 7, *, wavelength_nm = 587.5618,
    focus_distance_mm = None))]
pub(crate) fn lens_drawing_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Option<Described<LensSettings>>,
    fields_deg: Vec<f64>,
    rays: usize,
    wavelength_nm: f64,
    focus_distance_mm: Option<f64>,
) -> Result<String, Error> {
    let settings = settings.map(|settings| settings.0).unwrap_or_default();
    let light = DrawnLight { fields_deg, rays, wavelength_nm, focus_distance_mm };
    json(&without_gil(py, || drawing(&lens.prescription, &settings, &light))??)
}

/// See the stub.
#[pyfunction]
#[pyo3(signature = (lens, settings, *, angle_deg = 0.0, azimuth_deg = 90.0, wavelength_nm = 550.0, focus_distance_mm = None,
    film_mm = None, reflections = 2, brute_force_rays = 0, seed = 0))]
#[expect(clippy::too_many_arguments, reason = "each is a keyword of Python")]
pub(crate) fn lens_ghosts_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    angle_deg: f64,
    azimuth_deg: f64,
    wavelength_nm: f64,
    focus_distance_mm: Option<f64>,
    film_mm: Option<[f64; 2]>,
    reflections: usize,
    brute_force_rays: usize,
    seed: u64,
) -> Result<String, Error> {
    let source = GhostSource {
        angle_deg,
        azimuth_deg,
        wavelength_nm,
        focus_distance_mm,
        film_mm,
        reflections,
        brute_force_rays,
        seed,
    };
    json(&without_gil(py, || ghosts(&lens.prescription, &settings.0, &source))??)
}

/// See the stub.
#[pyfunction]
#[pyo3(signature = (lens, settings, *, lensfun = None, product = None, marked_mm = None, crop_factor = None, f_numbers = Vec::new(),
    focus_distance_mm = None, sensor = "sony-a7r2".to_owned(), colour_f_number = 8.0, count = 21))]
#[expect(clippy::too_many_arguments, reason = "each is a keyword of Python")]
pub(crate) fn lens_reality_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    lensfun: Option<PathBuf>,
    product: Option<String>,
    marked_mm: Option<f64>,
    crop_factor: Option<f64>,
    f_numbers: Vec<f64>,
    focus_distance_mm: Option<f64>,
    sensor: String,
    colour_f_number: f64,
    count: usize,
) -> Result<String, Error> {
    let options = RealityOptions {
        lensfun,
        product,
        marked_mm,
        crop_factor,
        f_numbers,
        focus_distance_mm,
        sensor,
        colour_f_number,
        count,
    };
    json(&without_gil(py, || reality(&lens.prescription, &settings.0, &options))??)
}

/// See the stub.
#[pyfunction]
pub(crate) fn fitted_lens_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    options: Named<FittedLensOptions>,
) -> Result<(String, String, Vec<String>), Error> {
    let found = without_gil(py, || fitted_lens(&lens.prescription, &settings.0, &options.0))?;
    let found = found.map_err(|error| invalid(error.to_string()))?;
    Ok((json(&found.report)?, found.text, found.lost))
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_groups() -> Vec<&'static str> {
    LensGroup::ALL.map(LensGroup::word).to_vec()
}
