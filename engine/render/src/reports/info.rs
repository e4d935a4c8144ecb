//! First-order data, aberrations and vignetting of a lens.

use super::{ReportError, check_wavelength};
use crate::camera::{f_number_at_infinity, t_number};
use petzval_optics::focus::focused;
use petzval_optics::paraxial::{Paraxial, Pupil};
use petzval_optics::prescription::{Prescription, SurfaceRow};
use petzval_optics::seidel::Seidel;
use petzval_optics::surface::Section;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::vignetting::Vignetting;
use serde::Serialize;
use std::f64::consts::PI;

/// Data of a lens that is set and focused, at one wavelength. Planes in lens space; `None` is infinite, or does not exist.
#[derive(Serialize)]
pub struct LensFacts {
    name: String,
    wavelength_nm: f64,
    efl_mm: Option<f64>,
    bfd_mm: Option<f64>,
    ffd_mm: Option<f64>,
    object_principal_plane_mm: Option<f64>,
    image_principal_plane_mm: Option<f64>,
    object_focal_plane_mm: Option<f64>,
    image_focal_plane_mm: Option<f64>,
    entrance_pupil: Pupil,
    exit_pupil: Pupil,
    /// F-number at infinity, by the circle that holds the opening.
    f_number: Option<f64>,
    t_number: Option<f64>,
    coatings: Vec<String>,
    coating_is_assumed: bool,
    unknown_absorption: Vec<String>,
    working_f_number: Option<f64>,
    stop_diameter_mm: f64,
    stop_area_mm2: f64,
    /// F-number by a round opening of the area `stop_area_mm2`.
    f_number_by_area: Option<f64>,
    focus_distance_mm: Option<f64>,
    object_plane_mm: Option<f64>,
    magnification: Option<f64>,
    film_z_mm: f64,
    total_track_mm: f64,
    petzval_radius_mm: Option<f64>,
    /// Sums of `seidel_by_surface`, mm.
    seidel: Option<[f64; 5]>,
    seidel_by_surface: Option<Vec<[f64; 5]>>,
    /// Sums of `chromatic_by_surface`, mm.
    chromatic: Option<[f64; 2]>,
    chromatic_by_surface: Option<Vec<[f64; 2]>>,
    /// The reason why there are no sums.
    seidel_missing: Option<&'static str>,
    /// Angle of the chief ray of the sums.
    seidel_field_deg: Option<f64>,
    vignetting_free_field_deg: Option<f64>,
    half_vignetted_field_deg: Option<f64>,
    largest_field_deg: Option<f64>,
    axial_beam_cut_by_surface: Option<usize>,
    /// The section across, where it differs.
    section_x: Option<SectionX>,
    surfaces: usize,
    /// The surfaces that do not stand on the axis, or are tilted.
    misaligned_surfaces: Vec<usize>,
}

/// First-order data in the x-z plane.
#[derive(Serialize)]
struct SectionX {
    efl_mm: Option<f64>,
    image_focal_plane_mm: Option<f64>,
    entrance_pupil: Pupil,
    exit_pupil: Pupil,
    f_number: Option<f64>,
}

/// The data of a lens.
///
/// # Errors
/// [`ReportError`].
pub fn info(
    lens: &Prescription,
    settings: &LensSettings,
    wavelength_nm: f64,
    focus_distance_mm: Option<f64>,
) -> Result<LensFacts, ReportError> {
    check_wavelength(wavelength_nm)?;
    let (system, focus) = focused(lens, settings, wavelength_nm, focus_distance_mm)?;
    let p = Paraxial::new(&system, wavelength_nm);
    let seidel = Seidel::new(&system, wavelength_nm, focus.object_plane_mm);
    let fields = Vignetting::new(&system, wavelength_nm, &focus);
    let f_number = p.f_number.map(|now| f_number_at_infinity(&system, now)).filter(|n| n.is_finite());
    let total = seidel.as_ref().map(Seidel::total);
    let by_surface = seidel.as_ref().map(|sums| &sums.by_surface);
    let across = Paraxial::in_section(&system, Section::X, wavelength_nm);
    let section_x = (across != p).then_some(SectionX {
        efl_mm: across.efl_mm,
        image_focal_plane_mm: across.image_focal_plane_mm,
        entrance_pupil: across.entrance_pupil,
        exit_pupil: across.exit_pupil,
        f_number: across.f_number,
    });
    Ok(LensFacts {
        name: system.name().to_owned(),
        wavelength_nm: p.wavelength_nm,
        efl_mm: p.efl_mm,
        bfd_mm: p.bfd_mm,
        ffd_mm: p.ffd_mm,
        object_principal_plane_mm: p.object_principal_plane_mm,
        image_principal_plane_mm: p.image_principal_plane_mm,
        object_focal_plane_mm: p.object_focal_plane_mm,
        image_focal_plane_mm: p.image_focal_plane_mm,
        entrance_pupil: p.entrance_pupil,
        exit_pupil: p.exit_pupil,
        f_number,
        t_number: t_number(&system, wavelength_nm, focus.film_z_mm),
        coatings: system.coatings(),
        coating_is_assumed: settings.coating.is_none() && lens.assumes_coatings(),
        unknown_absorption: system.glasses_of_unknown_absorption().into_iter().map(str::to_owned).collect(),
        working_f_number: focus.working_f_number,
        stop_diameter_mm: p.stop_diameter_mm,
        stop_area_mm2: system.diaphragm().area_mm2(),
        f_number_by_area: f_number.map(|n| n * rounded(&system)),
        focus_distance_mm: focus_distance_mm.filter(|d| *d != f64::INFINITY),
        object_plane_mm: focus.object_plane_mm,
        magnification: focus.magnification,
        film_z_mm: focus.film_z_mm,
        total_track_mm: focus.film_z_mm,
        petzval_radius_mm: p.petzval_radius_mm,
        seidel: total.map(|sums| sums.seidel),
        seidel_by_surface: by_surface.map(|all| all.iter().map(|sums| sums.seidel).collect()),
        chromatic: total.map(|sums| sums.chromatic),
        chromatic_by_surface: by_surface.map(|all| all.iter().map(|sums| sums.chromatic).collect()),
        seidel_missing: no_seidel(&system, &p),
        seidel_field_deg: seidel.as_ref().map(|sums| sums.field_deg),
        vignetting_free_field_deg: fields.free_field_deg,
        half_vignetted_field_deg: fields.half_field_deg,
        largest_field_deg: fields.largest_field_deg,
        axial_beam_cut_by_surface: fields.axial_beam_cut_by,
        section_x,
        surfaces: p.surfaces,
        misaligned_surfaces: misaligned(&lens.surfaces),
    })
}

/// The numbers of the surfaces that do not stand on the axis, or are tilted.
fn misaligned(surfaces: &[SurfaceRow]) -> Vec<usize> {
    surfaces.iter().enumerate().filter(|(_, row)| !row.pose.is_identity()).map(|(i, _)| i).collect()
}

/// The reason why there are no Seidel sums; `None`: there are.
fn no_seidel(system: &System, p: &Paraxial) -> Option<&'static str> {
    if system.has_gradients() {
        return Some("a medium has a gradient, whose own share is not worked out");
    }
    p.entrance_pupil.z_mm.is_none().then_some("the entrance pupil is at infinity")
}

/// Radius of the circle that holds the diaphragm's opening, over that of a round opening of equal area.
fn rounded(system: &System) -> f64 {
    let diaphragm = system.diaphragm();
    diaphragm.radius_mm() * (PI / diaphragm.area_mm2()).sqrt()
}
