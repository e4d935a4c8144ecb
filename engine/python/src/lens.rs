//! Lens files for `petzval lens`.

use crate::described::Described;
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use crate::questions::{scaled, unknown_key};
use glam::DVec3;
use petzval_optics::focus::focused;
use petzval_optics::formats;
use petzval_optics::glass::{Catalogue, Medium, VISIBLE_NM};
use petzval_optics::lane::Real;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System};
use petzval_optics::trace::{Ray, Tracer};
use petzval_render::reports::check_wavelength;
use petzval_render::reports::info::info;
use petzval_render::reports::summary::summary;
use pyo3::prelude::*;
use serde::Serialize;
use serde_json::Value;
use std::collections::HashMap;
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
        json(&summary(&self.prescription)?)
    }

    #[pyo3(signature = (settings = None, *, wavelength_nm = 587.5618, focus_distance_mm = None))]
    fn info_json(
        &self,
        py: Python<'_>,
        settings: Option<Described<LensSettings>>,
        wavelength_nm: f64,
        focus_distance_mm: Option<f64>,
    ) -> Result<String, Error> {
        let settings = settings.map(|settings| settings.0).unwrap_or_default();
        json(&without_gil(py, || info(&self.prescription, &settings, wavelength_nm, focus_distance_mm))??)
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
        if let Some(complaint) = unknown_key(&document, &["rays", "from"], &["note"]) {
            return Err(invalid(format!("the rays' JSON: {complaint}; see `petzval lens trace --help`")));
        }
        let rays = document["rays"]
            .as_array()
            .ok_or_else(|| invalid("the rays' JSON has no list \"rays\"; see `petzval lens trace --help`"))?
            .iter()
            .enumerate()
            .map(|(i, ray)| parse_ray(i, ray))
            .collect::<Result<Vec<_>, Error>>()?;
        let out = without_gil(py, || trace(&system, &rays, from_film))?;
        json(&Rays { rays: out })
    }
}

fn parse_ray(index: usize, ray: &Value) -> Result<(Ray, f64), Error> {
    let bad = |what: &str| invalid(format!("ray {index}: {what}; see `petzval lens trace --help`"));
    let vector = |key: &str| -> Result<DVec3, Error> {
        let list = ray[key].as_array().filter(|l| l.len() == 3);
        let numbers: Option<Vec<f64>> = list.and_then(|l| l.iter().map(Value::as_f64).collect());
        let v = numbers.ok_or_else(|| bad(&format!("\"{key}\" is not three numbers")))?;
        Ok(DVec3::from_slice(&v))
    };
    if let Some(complaint) = unknown_key(ray, &["origin", "direction", "wavelength_nm"], &["id", "note"]) {
        return Err(bad(&complaint));
    }
    let origin = vector("origin")?;
    let direction = scaled(vector("direction")?).ok_or_else(|| bad("its direction has no length"))?.normalize();
    let nm = match &ray["wavelength_nm"] {
        Value::Null => 587.5618,
        value => value.as_f64().ok_or_else(|| bad("\"wavelength_nm\" is not a number"))?,
    };
    check_wavelength(nm).map_err(|_| bad(&format!("wavelength {nm} nm is out of range")))?;
    Ok((Ray { origin, direction }, nm))
}

/// Traced rays as they are written.
#[derive(Serialize)]
struct Rays {
    rays: Vec<Traced>,
}

/// A traced ray: its end behind the last surface, or the reason and the surface at which it was lost.
#[derive(Serialize)]
struct Traced {
    status: &'static str,
    surface: Option<usize>,
    hits: Vec<[f64; 3]>,
    origin: Option<[f64; 3]>,
    direction: Option<[f64; 3]>,
}

fn trace_all<R: Real>(system: &System, rays: &[(Ray, f64)], from_film: bool) -> Vec<Traced> {
    let mut tracers: HashMap<u64, Tracer<R>> = HashMap::new();
    rays.iter()
        .map(|(ray, nm)| {
            let tracer = tracers.entry(nm.to_bits()).or_insert_with(|| system.at_wavelength(*nm).cast());
            traced(tracer, *ray, from_film)
        })
        .collect()
}

fn traced<R: Real>(tracer: &Tracer<R>, ray: Ray, from_film: bool) -> Traced {
    let mut hits = Vec::new();
    let result = if from_film {
        tracer.from_film_recording(ray, &mut hits)
    } else {
        tracer.from_scene_recording(ray, &mut hits)
    };
    let hits = hits.iter().map(DVec3::to_array).collect();
    let (status, surface) = match &result {
        Ok(_) => ("ok", None),
        Err(lost) => (lost.reason.name(), Some(lost.surface)),
    };
    let out = result.ok();
    let (origin, direction) = (out.map(|ray| ray.origin.to_array()), out.map(|ray| ray.direction.to_array()));
    Traced { status, surface, hits, origin, direction }
}
