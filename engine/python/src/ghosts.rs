//! The ghosts of a source, for `petzval lens ghosts`.

use crate::described::Described;
use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::lens::{Lens, check_wavelength};
use glam::{DVec2, DVec3};
use petzval_optics::focus::{FilmPlane, focused};
use petzval_optics::ghosts::beam::{Beam, Source};
use petzval_optics::ghosts::{brute, ranking};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::LensSettings;
use pyo3::prelude::*;
use serde_json::json;

/// Largest number of rays: more take hours.
const MOST_RAYS: usize = 100_000_000;
/// A disc is told apart from a point where its radius is this part of the film's diagonal.
const LEAST_PART: f64 = 1e-3;

/// See the stub.
#[pyfunction]
#[pyo3(signature = (lens, settings, *, angle_deg = 0.0, azimuth_deg = 90.0, wavelength_nm = 550.0, focus_distance_mm = None,
    film_mm = None, reflections = 2, brute_force_rays = 0, seed = 0))]
#[allow(clippy::too_many_arguments)]
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
    check_wavelength(wavelength_nm)?;
    if !(-90.0..=90.0).contains(&angle_deg) || !azimuth_deg.is_finite() {
        return Err(invalid(format!("a source at {angle_deg} degrees: give an angle from -90 to 90 to the axis")));
    }
    if ![2, 4].contains(&reflections) {
        return Err(invalid(format!("{reflections} reflections: give 2 or 4")));
    }
    if brute_force_rays > MOST_RAYS {
        return Err(invalid(format!("{brute_force_rays} rays: give {MOST_RAYS} at most")));
    }
    let film_mm = film_mm.or(lens.prescription.metadata.film_mm).unwrap_or([36.0, 24.0]);
    if !film_mm.iter().all(|side| *side > 0.0 && side.is_finite()) {
        return Err(invalid(format!("a film of {} x {} mm: give two lengths", film_mm[0], film_mm[1])));
    }
    let (system, focus) = focused(&lens.prescription, &settings.0, wavelength_nm, focus_distance_mm)?;
    let half = DVec2::from(film_mm) * 0.5;
    let is_film = |at: DVec2| at.abs().cmple(half).all();
    let curvature_per_mm = system.film_radius_mm().map_or(0.0, f64::recip);
    let film = FilmPlane { curvature_per_mm, ..FilmPlane::upright(focus.film_z_mm) }.frame();
    let across = DVec2::from_angle(azimuth_deg.to_radians()) * angle_deg.to_radians().sin();
    let towards = DVec3::new(across.x, across.y, -angle_deg.to_radians().cos());
    let beam = Beam::new(&system, Source::Far(towards)).ok_or_else(|| invalid("the lens has no front glass"))?;
    let tracer = system.at_wavelength(wavelength_nm);
    let paraxial = Paraxial::new(&system, wavelength_nm);
    let front_mm = 2.0 * system.surfaces()[0].semi_diameter_mm;
    let part = paraxial.entrance_pupil.diameter_mm.map_or(1.0, |mm| (mm / front_mm).min(1.0));
    without_gil(py, || {
        let least_mm = LEAST_PART * DVec2::from(film_mm).length();
        let found = ranking::ranked(&system, &tracer, &beam, (&film, is_film), reflections, part, least_mm);
        let ghosts: Vec<_> = found
            .iter()
            .map(|ghost| {
                json!({
                    "surfaces": ghost.turns,
                    "irradiance": ghost.irradiance,
                    "radius_mm": ghost.radius_mm,
                    "centre_mm": [-ghost.centre_mm.x, -ghost.centre_mm.y],
                    "light_mm2": ghost.light_mm2,
                    "on_film_mm2": ghost.on_film_mm2,
                })
            })
            .collect();
        let brute_force = (brute_force_rays > 0).then(|| {
            let mut state = seed;
            let random = move || {
                // splitmix64 (Steele, Lea and Flood 2014).
                state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mut z = state;
                z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
            };
            let arrived = brute::arrived(&system, &tracer, &beam, &film, is_film, brute_force_rays, random);
            json!({ "rays": brute_force_rays, "on_film_mm2": arrived.light_mm2, "error_mm2": arrived.error_mm2 })
        });
        Ok(json!({
            "name": system.name(),
            "wavelength_nm": wavelength_nm,
            "f_number": paraxial.f_number,
            "focus_distance_mm": focus_distance_mm.filter(|mm| mm.is_finite()),
            "angle_deg": angle_deg,
            "azimuth_deg": azimuth_deg,
            "film_mm": film_mm,
            "reflections": reflections,
            "on_film_mm2": found.iter().map(|ghost| ghost.on_film_mm2).sum::<f64>(),
            "ghosts": ghosts,
            "brute_force": brute_force,
        })
        .to_string())
    })?
}
