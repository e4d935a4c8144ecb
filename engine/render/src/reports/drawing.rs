//! A lens drawn in section, with the light through it.

use super::{ReportError, check_fields, check_wavelength};
use petzval_optics::drawing::{Drawing, FieldRays, SurfaceProfile};
use petzval_optics::focus::focused;
use petzval_optics::paraxial::{Paraxial, Pupil};
use petzval_optics::prescription::Prescription;
use petzval_optics::system::LensSettings;
use serde::Serialize;

/// Largest number of rays: more make no drawing.
const MOST_RAYS: usize = 1000;

/// The light of a drawing.
#[derive(Clone, Debug)]
pub struct DrawnLight {
    /// Angles to the axis; none: the axis, 0.7 of the design's half field, and that.
    pub fields_deg: Vec<f64>,
    /// Rays of each field.
    pub rays: usize,
    /// Vacuum wavelength of the rays.
    pub wavelength_nm: f64,
    /// Focus distance from the entrance pupil; `None` is infinity.
    pub focus_distance_mm: Option<f64>,
}

/// A lens in the y-z plane; places are [z, y] in lens space.
#[derive(Serialize)]
pub struct LensDrawing {
    name: String,
    wavelength_nm: f64,
    efl_mm: Option<f64>,
    f_number: Option<f64>,
    focus_distance_mm: Option<f64>,
    film_z_mm: f64,
    object_principal_plane_mm: Option<f64>,
    image_principal_plane_mm: Option<f64>,
    entrance_pupil: Pupil,
    exit_pupil: Pupil,
    surfaces: Vec<SurfaceProfile>,
    /// Index of the surface with the diaphragm.
    stop: usize,
    stop_semi_diameter_mm: f64,
    fields: Vec<FieldRays>,
    film: Vec<[f64; 2]>,
}

/// Draws a lens.
///
/// # Errors
/// [`ReportError`].
pub fn drawing(lens: &Prescription, settings: &LensSettings, light: &DrawnLight) -> Result<LensDrawing, ReportError> {
    let DrawnLight { fields_deg, rays, wavelength_nm, focus_distance_mm } = light;
    check_wavelength(*wavelength_nm)?;
    check_fields(fields_deg)?;
    if !(1..=MOST_RAYS).contains(rays) {
        return Err(ReportError::OutOfRange(format!("{rays} rays a field: give 1 to {MOST_RAYS}")));
    }
    let (system, focus) = focused(lens, settings, *wavelength_nm, *focus_distance_mm)?;
    let usual = || Drawing::usual_angles_deg(&system, &focus, *wavelength_nm);
    let angles = if fields_deg.is_empty() { usual() } else { fields_deg.clone() };
    let Drawing { surfaces, stop, stop_semi_diameter_mm, fields, film } =
        Drawing::new(&system, &focus, *wavelength_nm, &angles, *rays);
    let p = Paraxial::new(&system, *wavelength_nm);
    Ok(LensDrawing {
        name: system.name().to_owned(),
        wavelength_nm: *wavelength_nm,
        efl_mm: p.efl_mm,
        f_number: p.f_number,
        focus_distance_mm: focus_distance_mm.filter(|d| d.is_finite()),
        film_z_mm: focus.film_z_mm,
        object_principal_plane_mm: p.object_principal_plane_mm,
        image_principal_plane_mm: p.image_principal_plane_mm,
        entrance_pupil: p.entrance_pupil,
        exit_pupil: p.exit_pupil,
        surfaces,
        stop,
        stop_semi_diameter_mm,
        fields,
        film,
    })
}
