//! The data of each lens in a list of lenses.

use crate::error::Error;
use petzval_optics::axial_beam;
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::{LensGroup, Prescription};
use petzval_optics::published;
use petzval_optics::system::{LensSettings, System};
use pyo3::prelude::*;
use serde_json::json;

/// See the stub.
#[pyfunction]
pub(crate) fn lens_groups() -> Vec<&'static str> {
    LensGroup::ALL.map(LensGroup::word).to_vec()
}

/// The JSON object of one lens in `petzval lens list --json`.
pub(crate) fn summary(lens: &Prescription) -> Result<String, Error> {
    let system = System::new(lens, &LensSettings::default())?;
    let p = Paraxial::new(&system, line_nm::D);
    let metadata = &lens.metadata;
    let published = published::compare(lens)?;
    let published = published.iter().map(|one| {
        json!({
            "key": one.key,
            "text": one.text,
            "published": one.value,
            "computed": one.computed,
            "agrees": one.agrees,
            "why": one.why,
        })
    });
    Ok(json!({
        "name": lens.name,
        "group": metadata.group.map(LensGroup::word),
        "is_first_choice": metadata.is_first_choice,
        "source": metadata.source,
        "design": metadata.text("design"),
        "notes": metadata.text("notes"),
        "focal_length_mm": axial_beam::front_focal_length_mm(&system, line_nm::D),
        "zoom_range_mm": lens.moving.as_ref().and_then(|moving| moving.zoom_range_mm()),
        "focuses_inside": lens.moving.as_ref().is_some_and(|moving| moving.focuses()),
        "f_number": axial_beam::f_number(&system, line_nm::D),
        "back_focus_mm": p.bfd_mm,
        "half_field_deg": metadata.half_field_deg,
        "film_mm": metadata.film_mm,
        "published": published.collect::<Vec<_>>(),
    })
    .to_string())
}
