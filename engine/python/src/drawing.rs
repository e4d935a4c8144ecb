//! Drawings of lenses, for `petzval lens draw`.

use crate::described::Described;
use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::lens::{Lens, check_wavelength};
use petzval_optics::drawing::Drawing;
use petzval_optics::focus::focused;
use petzval_optics::paraxial::{Paraxial, Pupil};
use petzval_optics::system::LensSettings;
use pyo3::prelude::*;
use serde_json::json;

/// Largest number of rays: more make no drawing.
const MOST_RAYS: usize = 1000;

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
    check_wavelength(wavelength_nm)?;
    if !(1..=MOST_RAYS).contains(&rays) {
        return Err(invalid(format!("{rays} rays a field: give 1 to {MOST_RAYS}")));
    }
    if let Some(angle) = fields_deg.iter().find(|angle| !(-180.0..=180.0).contains(*angle)) {
        return Err(invalid(format!("a field of {angle} degrees: give angles from -180 to 180")));
    }
    let settings = settings.map(|settings| settings.0).unwrap_or_default();
    let (system, focus) = focused(&lens.prescription, &settings, wavelength_nm, focus_distance_mm)?;
    let drawing = without_gil(py, || {
        let usual = || Drawing::usual_angles_deg(&system, &focus, wavelength_nm);
        let angles = if fields_deg.is_empty() { usual() } else { fields_deg };
        Drawing::new(&system, &focus, wavelength_nm, &angles, rays)
    })?;
    let p = Paraxial::new(&system, wavelength_nm);
    let pupil = |p: &Pupil| json!({ "z_mm": p.z_mm, "diameter_mm": p.diameter_mm });
    let surfaces = drawing.surfaces.iter().map(|s| {
        json!({ "points": s.points, "hole_mm": s.hole_mm, "is_mirror": s.is_mirror, "glass_behind": s.glass_behind })
    });
    let fields = drawing.fields.iter().map(|field| json!({ "angle_deg": field.angle_deg, "rays": field.rays }));
    Ok(json!({
        "name": system.name(),
        "wavelength_nm": wavelength_nm,
        "efl_mm": p.efl_mm,
        "f_number": p.f_number,
        "focus_distance_mm": focus_distance_mm.filter(|d| d.is_finite()),
        "film_z_mm": focus.film_z_mm,
        "object_principal_plane_mm": p.object_principal_plane_mm,
        "image_principal_plane_mm": p.image_principal_plane_mm,
        "entrance_pupil": pupil(&p.entrance_pupil),
        "exit_pupil": pupil(&p.exit_pupil),
        "surfaces": surfaces.collect::<Vec<_>>(),
        "stop": drawing.stop,
        "stop_semi_diameter_mm": drawing.stop_semi_diameter_mm,
        "fields": fields.collect::<Vec<_>>(),
        "film": drawing.film,
    })
    .to_string())
}
