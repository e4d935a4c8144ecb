//! Lens files for `petzval lens`.

use crate::doorway::away;
use crate::error::{Error, refused};
use glam::DVec3;
use petzval_optics::focus;
use petzval_optics::formats::lens;
use petzval_optics::glass::Catalogue;
use petzval_optics::paraxial::{Paraxial, Pupil};
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{FocalLength, System, SystemSettings};
use petzval_optics::trace::{Ray, Tracer};
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

/// A checked lens prescription.
#[pyclass(frozen)]
pub(crate) struct Lens {
    prescription: Prescription,
}

#[pymethods]
impl Lens {
    #[new]
    fn new(path: &str) -> Result<Self, Error> {
        Ok(Self { prescription: lens::read(Path::new(path), Catalogue::shipped())? })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.prescription.name
    }

    #[getter]
    fn surface_count(&self) -> usize {
        self.prescription.surfaces.len()
    }

    #[pyo3(signature = (*, wavelength_nm = 587.5618, scale = None, focal_length_mm = None, f_number = None,
        focus_distance_mm = None))]
    fn info_json(
        &self,
        wavelength_nm: f64,
        scale: Option<f64>,
        focal_length_mm: Option<f64>,
        f_number: Option<f64>,
        focus_distance_mm: Option<f64>,
    ) -> Result<String, Error> {
        check_wavelength(wavelength_nm)?;
        let system = self.system(scale, focal_length_mm, f_number)?;
        let p = Paraxial::new(&system, wavelength_nm);
        let film_z_mm = match focus_distance_mm {
            Some(d) if d.is_finite() => focus::film_z_for_focus_mm(&system, wavelength_nm, d)?,
            _ => p.film_z_mm,
        };
        let pupil = |p: &Pupil| json!({ "z_mm": p.z_mm, "diameter_mm": p.diameter_mm });
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
            "stop_diameter_mm": p.stop_diameter_mm,
            "film_z_mm": film_z_mm,
            "petzval_radius_mm": p.petzval_radius_mm,
            "seidel": p.seidel,
            "seidel_field_deg": p.seidel_field_deg,
            "total_track_mm": p.total_track_mm,
            "surfaces": p.surfaces,
        })
        .to_string())
    }

    #[pyo3(signature = (rays_json, *, from_film = false, precision = "f64", scale = None, focal_length_mm = None,
        f_number = None))]
    #[allow(clippy::too_many_arguments)]
    fn trace_json(
        &self,
        py: Python<'_>,
        rays_json: &str,
        from_film: bool,
        precision: &str,
        scale: Option<f64>,
        focal_length_mm: Option<f64>,
        f_number: Option<f64>,
    ) -> Result<String, Error> {
        if precision != "f64" {
            return Err(refused(format!("precision {precision}: only f64 is built so far; leave --precision out")));
        }
        let system = self.system(scale, focal_length_mm, f_number)?;
        let document: Value =
            serde_json::from_str(rays_json).map_err(|e| refused(format!("the rays are not JSON: {e}")))?;
        let rays = document["rays"]
            .as_array()
            .ok_or_else(|| refused("the rays' JSON has no list \"rays\"; see `petzval lens trace --help`"))?
            .iter()
            .enumerate()
            .map(|(i, ray)| parse_ray(i, ray))
            .collect::<Result<Vec<_>, Error>>()?;
        let out = away(py, || {
            let mut tracers: HashMap<u64, Tracer> = HashMap::new();
            rays.iter()
                .map(|(ray, nm)| {
                    let tracer = tracers.entry(nm.to_bits()).or_insert_with(|| system.at_wavelength(*nm));
                    traced(tracer, *ray, from_film)
                })
                .collect::<Vec<Value>>()
        })?;
        Ok(json!({ "rays": out }).to_string())
    }
}

impl Lens {
    fn system(&self, scale: Option<f64>, focal_mm: Option<f64>, f_number: Option<f64>) -> Result<System, Error> {
        let focal_length = match (focal_mm, scale) {
            (Some(mm), _) => FocalLength::Millimetres(mm),
            (None, Some(s)) => FocalLength::Scale(s),
            (None, None) => FocalLength::AsPublished,
        };
        let settings = SystemSettings { focal_length, f_number, ..SystemSettings::default() };
        Ok(System::new(&self.prescription, &settings)?)
    }
}

fn check_wavelength(nm: f64) -> Result<(), Error> {
    if (100.0..=20_000.0).contains(&nm) {
        return Ok(());
    }
    Err(refused(format!("wavelength {nm} nm: give nanometres; visible light is 380 to 780")))
}

fn parse_ray(index: usize, ray: &Value) -> Result<(Ray, f64), Error> {
    let bad = |what: &str| refused(format!("ray {index}: {what}; see `petzval lens trace --help`"));
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

fn traced(tracer: &Tracer, ray: Ray, from_film: bool) -> Value {
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
