//! A lens in a list of lenses.

use super::ReportError;
use petzval_optics::axial_beam;
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::moving::MovingParts;
use petzval_optics::prescription::{LensGroup, Prescription};
use petzval_optics::published::{self, Published};
use petzval_optics::system::{LensSettings, System};
use serde::Serialize;

/// A lens in a list of lenses: its header, and its numbers at the d line as published.
#[derive(Serialize)]
pub struct Summary {
    name: String,
    group: Option<&'static str>,
    is_first_choice: bool,
    source: Option<String>,
    design: Option<String>,
    notes: Option<String>,
    focal_length_mm: Option<f64>,
    zoom_range_mm: Option<[f64; 2]>,
    focuses_inside: bool,
    /// F-number of the beam that comes through wide open.
    f_number: Option<f64>,
    back_focus_mm: Option<f64>,
    half_field_deg: Option<f64>,
    film_mm: Option<[f64; 2]>,
    /// The source's numbers beside the computed ones.
    published: Vec<Published>,
}

/// Summarizes a lens.
///
/// # Errors
/// [`ReportError`].
pub fn summary(lens: &Prescription) -> Result<Summary, ReportError> {
    let system = System::new(lens, &LensSettings::default())?;
    let metadata = &lens.metadata;
    let text = |key: &str| metadata.text(key).map(str::to_owned);
    Ok(Summary {
        name: lens.name.clone(),
        group: metadata.group.map(LensGroup::word),
        is_first_choice: metadata.is_first_choice,
        source: metadata.source.clone(),
        design: text("design"),
        notes: text("notes"),
        focal_length_mm: axial_beam::front_focal_length_mm(&system, line_nm::D),
        zoom_range_mm: lens.moving.as_ref().and_then(MovingParts::zoom_range_mm),
        focuses_inside: lens.moving.as_ref().is_some_and(MovingParts::focuses),
        f_number: axial_beam::f_number(&system, line_nm::D),
        back_focus_mm: Paraxial::new(&system, line_nm::D).bfd_mm,
        half_field_deg: metadata.half_field_deg,
        film_mm: metadata.film_mm,
        published: published::compare(lens)?,
    })
}
