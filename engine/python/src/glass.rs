//! Glasses, for `petzval glass`.

use crate::error::{Error, invalid};
use petzval_optics::formats;
use petzval_optics::glass::{Catalogue, Medium, line_nm};
use petzval_render::reports::check_wavelength;
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

/// Null where there is none.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The glasses of a file, and the entries that could not be used.
///
/// Other threads of Python go on meanwhile: a catalogue may hold millions of lines.
fn of_file(py: Python<'_>, path: &str) -> Result<(Vec<Medium>, Vec<String>), Error> {
    let (media, remarks) = py.detach(|| formats::read_glasses(Path::new(path)))?;
    Ok((media, remarks.iter().map(ToString::to_string).collect()))
}

/// See the stub.
#[pyfunction]
pub(crate) fn glass_json(
    py: Python<'_>,
    name: &str,
    catalogue: Option<&str>,
    wavelengths_nm: Vec<f64>,
    thickness_mm: f64,
) -> Result<String, Error> {
    wavelengths_nm.iter().try_for_each(|&nm| check_wavelength(nm))?;
    if !(thickness_mm > 0.0 && thickness_mm.is_finite()) {
        return Err(invalid(format!("a thickness of {thickness_mm} mm: give more than 0")));
    }
    let (medium, remarks) = match catalogue {
        None => (Catalogue::shipped().medium(name).map_err(|e| invalid(e.to_string()))?, Vec::new()),
        Some(path) => {
            let (media, remarks) = of_file(py, path)?;
            let found = media.iter().find(|medium| medium.name().eq_ignore_ascii_case(name));
            let found = found.ok_or_else(|| invalid(format!("{path}: it has no usable glass '{name}': see --list")))?;
            (found.clone(), remarks)
        }
    };
    let bare = medium.name().rsplit(':').next().unwrap_or_default();
    let makers = if catalogue.is_none() { Catalogue::shipped().makers_of(bare) } else { Vec::new() };
    let words = medium.dispersion().words();
    let row = |&nm: &f64| {
        json!({
            "wavelength_nm": nm,
            "index": medium.index(nm),
            "is_known": medium.is_known_between(nm, nm),
            "transmittance": medium.internal_transmittance(nm, thickness_mm),
        })
    };
    Ok(json!({
        "name": medium.name(),
        "source": medium.source(),
        "makers": makers,
        "formula": words.as_ref().map(|(word, _)| word),
        "coefficients": words.as_ref().map(|(_, numbers)| numbers),
        "range_nm": medium.range_nm().map(finite),
        "nd": medium.index(line_nm::D),
        "abbe": finite(medium.abbe()),
        "transmittance_is_known": medium.transmittance().is_some(),
        "thickness_mm": thickness_mm,
        "range_note": (!wavelengths_nm.iter().all(|&nm| medium.is_known_between(nm, nm))).then(|| medium.range_note()),
        "indices": wavelengths_nm.iter().map(row).collect::<Vec<Value>>(),
        "remarks": remarks,
    })
    .to_string())
}

/// See the stub.
#[pyfunction]
pub(crate) fn glasses_json(py: Python<'_>, catalogue: Option<&str>) -> Result<String, Error> {
    let row = |token: &str, medium: &Medium| json!({ "token": token, "nd": medium.index(line_nm::D), "abbe": finite(medium.abbe()) });
    let (rows, remarks): (Vec<Value>, Vec<String>) = match catalogue {
        Some(path) => {
            let (media, remarks) = of_file(py, path)?;
            (media.iter().map(|medium| row(medium.name(), medium)).collect(), remarks)
        }
        None => {
            let shipped = Catalogue::shipped();
            let rows = shipped.names().into_iter().filter_map(|token| Some(row(&token, &shipped.medium(&token).ok()?)));
            (rows.collect(), Vec::new())
        }
    };
    Ok(json!({ "glasses": rows, "remarks": remarks }).to_string())
}
