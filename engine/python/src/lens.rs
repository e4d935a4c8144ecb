//! Lens files for `petzval lens`.

use crate::described::Described;
use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::library;
use glam::DVec3;
use petzval_optics::focus::focused;
use petzval_optics::formats;
use petzval_optics::glass::{Catalogue, Medium, VISIBLE_NM};
use petzval_optics::lane::Real;
use petzval_optics::paraxial::{Paraxial, Pupil};
use petzval_optics::prescription::Prescription;
use petzval_optics::seidel::Seidel;
use petzval_optics::surface::Section;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};
use petzval_optics::vignetting::Vignetting;
use petzval_render::camera::t_number;
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::PathBuf;

/// A checked lens prescription.
#[pyclass(frozen)]
pub(crate) struct Lens {
    pub(crate) prescription: Prescription,
    remarks: Vec<String>,
}

#[pymethods]
impl Lens {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> Result<Self, Error> {
        let reading = without_gil(py, || formats::read(&path, Catalogue::shipped()))??;
        let remarks = reading.remarks.iter().map(ToString::to_string).collect();
        Ok(Self { prescription: reading.prescription, remarks })
    }

    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    #[pyo3(signature = (wavelengths_nm = VISIBLE_NM.to_vec()))]
    fn range_notes(&self, wavelengths_nm: Vec<f64>) -> Vec<String> {
        let ends = wavelengths_nm.into_iter().map(|nm| (nm, nm));
        let Some((shortest, longest)) = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return Vec::new() };
        self.prescription.media_beyond(shortest, longest).into_iter().map(Medium::range_note).collect()
    }

    fn written(&self, kind: &str) -> Result<(String, Vec<String>), Error> {
        let write = match kind {
            "lens" => formats::lens::write,
            "zmx" => formats::zmx::write,
            other => return Err(invalid(format!("lenses cannot be written as .{other}; give .lens or .zmx"))),
        };
        Ok(write(&self.prescription, Catalogue::shipped()))
    }

    fn identity(&self) -> String {
        self.prescription.identity()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.prescription.name
    }

    #[getter]
    fn surface_count(&self) -> usize {
        self.prescription.surfaces.len()
    }

    fn summary_json(&self) -> Result<String, Error> {
        library::summary(&self.prescription)
    }

    #[pyo3(signature = (settings = None, *, wavelength_nm = 587.5618, focus_distance_mm = None))]
    fn info_json(
        &self,
        py: Python<'_>,
        settings: Option<Described<LensSettings>>,
        wavelength_nm: f64,
        focus_distance_mm: Option<f64>,
    ) -> Result<String, Error> {
        check_wavelength(wavelength_nm)?;
        let settings = settings.map(|settings| settings.0).unwrap_or_default();
        let coating_is_assumed = settings.coating.is_none() && self.prescription.assumes_coatings();
        let (system, focus) = focused(&self.prescription, &settings, wavelength_nm, focus_distance_mm)?;
        let p = Paraxial::new(&system, wavelength_nm);
        let seidel = Seidel::new(&system, wavelength_nm, focus.object_plane_mm);
        let fields = without_gil(py, || Vignetting::new(&system, wavelength_nm, &focus))?;
        let total = seidel.as_ref().map(Seidel::total);
        let by_surface = seidel.as_ref().map(|s| &s.by_surface);
        let pupil = |p: &Pupil| json!({ "z_mm": p.z_mm, "diameter_mm": p.diameter_mm });
        let across = Paraxial::in_section(&system, Section::X, wavelength_nm);
        let across = (across != p).then(|| {
            json!({
                "efl_mm": across.efl_mm,
                "image_focal_plane_mm": across.image_focal_plane_mm,
                "entrance_pupil": pupil(&across.entrance_pupil),
                "exit_pupil": pupil(&across.exit_pupil),
                "f_number": across.f_number,
            })
        });
        Ok(json!({
            "name": system.name(),
            "wavelength_nm": p.wavelength_nm,
            "efl_mm": p.efl_mm,
            "bfd_mm": p.bfd_mm,
            "ffd_mm": p.ffd_mm,
            "object_principal_plane_mm": p.object_principal_plane_mm,
            "image_principal_plane_mm": p.image_principal_plane_mm,
            "object_focal_plane_mm": p.object_focal_plane_mm,
            "image_focal_plane_mm": p.image_focal_plane_mm,
            "entrance_pupil": pupil(&p.entrance_pupil),
            "exit_pupil": pupil(&p.exit_pupil),
            "f_number": p.f_number,
            "t_number": t_number(&system, wavelength_nm, focus.film_z_mm),
            "coatings": system.coatings(),
            "coating_is_assumed": coating_is_assumed,
            "unknown_absorption": system.glasses_of_unknown_absorption(),
            "working_f_number": focus.working_f_number,
            "stop_diameter_mm": p.stop_diameter_mm,
            "stop_area_mm2": system.diaphragm().area_mm2(),
            "f_number_by_area": p.f_number.map(|n| n * rounded(&system)),
            "focus_distance_mm": focus_distance_mm.filter(|d| *d != f64::INFINITY),
            "object_plane_mm": focus.object_plane_mm,
            "magnification": focus.magnification,
            "film_z_mm": focus.film_z_mm,
            "total_track_mm": focus.film_z_mm,
            "petzval_radius_mm": p.petzval_radius_mm,
            "seidel": total.map(|sums| sums.seidel),
            "seidel_by_surface": by_surface.map(|all| all.iter().map(|sums| sums.seidel).collect::<Vec<_>>()),
            "chromatic": total.map(|sums| sums.chromatic),
            "chromatic_by_surface": by_surface.map(|all| all.iter().map(|sums| sums.chromatic).collect::<Vec<_>>()),
            "seidel_missing": no_seidel(&system, &p),
            "seidel_field_deg": seidel.as_ref().map(|s| s.field_deg),
            "vignetting_free_field_deg": fields.free_field_deg,
            "half_vignetted_field_deg": fields.half_field_deg,
            "largest_field_deg": fields.largest_field_deg,
            "axial_beam_cut_by_surface": fields.axial_beam_cut_by,
            "section_x": across,
            "surfaces": p.surfaces,
        })
        .to_string())
    }

    #[pyo3(signature = (rays_json, settings = None, *, from_film = false, precision = "f64", focus = None))]
    fn trace_json(
        &self,
        py: Python<'_>,
        rays_json: &str,
        settings: Option<Described<LensSettings>>,
        from_film: bool,
        precision: &str,
        focus: Option<(f64, f64)>,
    ) -> Result<String, Error> {
        let trace = match precision {
            "f64" => trace_all::<f64>,
            "f32" => trace_all::<f32>,
            _ => return Err(invalid(format!("precision {precision}: there is no such; give f64 or f32"))),
        };
        let settings = settings.map(|settings| settings.0).unwrap_or_default();
        let system = match focus {
            Some((distance_mm, nm)) => {
                check_wavelength(nm)?;
                focused(&self.prescription, &settings, nm, Some(distance_mm))?.0
            }
            None => System::new(&self.prescription, &settings)?,
        };
        let document: Value =
            serde_json::from_str(rays_json).map_err(|e| invalid(format!("the rays are not JSON: {e}")))?;
        let rays = document["rays"]
            .as_array()
            .ok_or_else(|| invalid("the rays' JSON has no list \"rays\"; see `petzval lens trace --help`"))?
            .iter()
            .enumerate()
            .map(|(i, ray)| parse_ray(i, ray))
            .collect::<Result<Vec<_>, Error>>()?;
        let out = without_gil(py, || trace(&system, &rays, from_film))?;
        Ok(json!({ "rays": out }).to_string())
    }
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

pub(crate) fn check_wavelength(nm: f64) -> Result<(), Error> {
    if (100.0..=20_000.0).contains(&nm) {
        return Ok(());
    }
    Err(invalid(format!("wavelength {nm} nm: give nanometres; visible light is 380 to 780")))
}

fn parse_ray(index: usize, ray: &Value) -> Result<(Ray, f64), Error> {
    let bad = |what: &str| invalid(format!("ray {index}: {what}; see `petzval lens trace --help`"));
    let vector = |key: &str| -> Result<DVec3, Error> {
        let list = ray[key].as_array().filter(|l| l.len() == 3);
        let numbers: Option<Vec<f64>> = list.and_then(|l| l.iter().map(Value::as_f64).collect());
        let v = numbers.ok_or_else(|| bad(&format!("\"{key}\" is not three numbers")))?;
        Ok(DVec3::from_slice(&v))
    };
    let origin = vector("origin")?;
    let direction = vector("direction")?.try_normalize().ok_or_else(|| bad("its direction has no length"))?;
    let nm = match &ray["wavelength_nm"] {
        Value::Null => 587.5618,
        value => value.as_f64().ok_or_else(|| bad("\"wavelength_nm\" is not a number"))?,
    };
    check_wavelength(nm).map_err(|_| bad(&format!("wavelength {nm} nm is out of range")))?;
    Ok((Ray { origin, direction }, nm))
}

fn trace_all<R: Real>(system: &System, rays: &[(Ray, f64)], from_film: bool) -> Vec<Value> {
    let mut tracers: HashMap<u64, Tracer<R>> = HashMap::new();
    rays.iter()
        .map(|(ray, nm)| {
            let tracer = tracers.entry(nm.to_bits()).or_insert_with(|| system.at_wavelength(*nm).cast());
            traced(tracer, *ray, from_film)
        })
        .collect()
}

fn traced<R: Real>(tracer: &Tracer<R>, ray: Ray, from_film: bool) -> Value {
    let mut hits = Vec::new();
    let result = if from_film {
        tracer.from_film_recording(ray, &mut hits)
    } else {
        tracer.from_scene_recording(ray, &mut hits)
    };
    let hits: Vec<[f64; 3]> = hits.iter().map(DVec3::to_array).collect();
    match result {
        Ok(out) => json!({
            "status": "ok",
            "surface": null,
            "hits": hits,
            "origin": out.origin.to_array(),
            "direction": out.direction.to_array(),
        }),
        Err(lost) => json!({
            "status": lost.reason.name(),
            "surface": lost.surface,
            "hits": hits,
            "origin": null,
            "direction": null,
        }),
    }
}
