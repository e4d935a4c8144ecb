//! Reports of a lens, for `petzval lens spots`, `fans`, `mtf`, `psf`, `distortion` and `illumination`.

use crate::described::Described;
use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::lens::{Lens, check_wavelength};
use petzval_optics::analysis::Analysis;
use petzval_optics::analysis::fan::FanLine;
use petzval_optics::analysis::illumination::Illumination;
use petzval_optics::analysis::mtf::{Curve, MtfError};
use petzval_optics::analysis::psf::PsfError;
use petzval_optics::analysis::transmission::FieldTransmission;
use petzval_optics::focus::{Focus, focused};
use petzval_optics::glass::line_nm;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::system::{LensSettings, System};
use petzval_render::camera::t_number;
use pyo3::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};

/// Largest number of fields, wavelengths, rays, steps or heights of a report.
const MOST: usize = 2000;
const MOST_RAYS_OF_A_SIDE: usize = 500;

/// The settings of a lens report.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Look {
    /// Angles to the axis; none: the report's own.
    fields_deg: Vec<f64>,
    /// Wavelengths in vacuum; that nearest the d line is the main one. None: F, d and C.
    wavelengths_nm: Vec<f64>,
    /// Azimuth of the fields, from right to up.
    azimuth_deg: f64,
    focus_distance_mm: Option<f64>,
    /// True if the film is where the axis is sharpest, instead of where paraxial rays meet.
    best_focus: bool,
    /// Displacement of the film from that place.
    defocus_mm: f64,
}

impl Look {
    /// The wavelengths asked for.
    fn lines(&self) -> &[f64] {
        match self.wavelengths_nm.as_slice() {
            [] => &[line_nm::F, line_nm::D, line_nm::C],
            given => given,
        }
    }

    /// The main wavelength, at which the lens is focused.
    fn main_nm(&self) -> f64 {
        let lines = self.lines();
        lines[self.main(lines)]
    }

    /// The analysis that was asked for, checked.
    fn analysis<'a>(&self, system: &'a System) -> Result<Analysis<'a>, Error> {
        let lines = self.lines();
        lines.iter().try_for_each(|&nm| check_wavelength(nm))?;
        if let Some(angle) = self.fields_deg.iter().find(|angle| !(-180.0..=180.0).contains(*angle)) {
            return Err(invalid(format!("a field of {angle} degrees: give angles from -180 to 180")));
        }
        if lines.len().max(self.fields_deg.len()) > MOST || !self.defocus_mm.is_finite() {
            return Err(invalid(format!(
                "more than {MOST} fields or wavelengths, or a defocus without end: give less"
            )));
        }
        let main = self.main(lines);
        let focus = Focus::new(system, lines[main], self.focus_distance_mm)?;
        let azimuth = self.azimuth_deg.to_radians();
        let analysis = Analysis::new(system, focus, lines, main, azimuth).ok_or_else(|| {
            invalid(format!(
                "lens '{}': its entrance pupil lies at infinity, so there is nothing to count fields from: only `lens draw` and `lens trace` show it",
                system.name()
            ))
        })?;
        let analysis =
            if self.best_focus { analysis.at_best_focus().map_err(|e| invalid(e.to_string()))? } else { analysis };
        let film_z_mm = analysis.film().z_mm + self.defocus_mm;
        Ok(analysis.with_film_at(film_z_mm))
    }

    fn main(&self, lines: &[f64]) -> usize {
        let from_d = |i: &usize| (lines[*i] - line_nm::D).abs();
        (0..lines.len()).min_by(|a, b| from_d(a).total_cmp(&from_d(b))).unwrap_or(0)
    }

    /// The lens looked at, its fields, those asked for or else some parts of the half field, and what every report says of it.
    fn open<'a>(&self, system: &'a System, parts: &[f64]) -> Result<(Analysis<'a>, Vec<f64>, Value), Error> {
        let analysis = self.analysis(system)?;
        let half_field_deg = analysis.half_field_deg();
        let fields = match self.fields_deg.as_slice() {
            [] if half_field_deg > 0.0 => parts.iter().map(|part| part * half_field_deg).collect(),
            [] => vec![0.0],
            given => given.to_vec(),
        };
        let p = Paraxial::new(system, self.main_nm());
        let head = json!({
            "name": system.name(),
            "efl_mm": p.efl_mm,
            "f_number": p.f_number,
            "focus_distance_mm": self.focus_distance_mm.filter(|d| d.is_finite()),
            "film_z_mm": analysis.film().z_mm,
            "wavelengths_nm": self.lines(),
            "main_wavelength": self.main(self.lines()),
            "azimuth_deg": self.azimuth_deg,
            "airy_radius_mm": analysis.airy_radius_mm(),
            "half_field_deg": half_field_deg,
        });
        Ok((analysis, fields, head))
    }

    /// The lens set and focused for this look.
    fn system(&self, lens: &Lens, settings: &LensSettings) -> Result<System, Error> {
        Ok(focused(&lens.prescription, settings, self.main_nm(), self.focus_distance_mm)?.0)
    }
}

/// Parts of the half field.
const SOME: [f64; 3] = [0.0, 0.7, 1.0];

fn evenly(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / (count - 1).max(1) as f64).collect()
}

fn with(mut head: Value, entries: Value) -> String {
    if let (Value::Object(head), Value::Object(entries)) = (&mut head, entries) {
        head.extend(entries);
    }
    head.to_string()
}

fn within(count: usize, most: usize, what: &str) -> Result<(), Error> {
    let is_good = (2..=most).contains(&count);
    is_good.then_some(()).ok_or_else(|| invalid(format!("{count} {what}: give 2 to {most}")))
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_spots_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    rays: usize,
    defocus_mm: Vec<f64>,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    within(rays, MOST_RAYS_OF_A_SIDE, "rays over the width of a beam")?;
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (mut analysis, fields, head) = look.open(&system, &SOME)?;
        let film_z_mm = analysis.film().z_mm;
        let mut through = Vec::new();
        for mm in defocus_mm {
            analysis = analysis.with_film_at(film_z_mm + mm);
            let spot = |&angle: &f64| {
                let Some(spot) = analysis.spot(angle, rays) else {
                    return json!({ "angle_deg": angle, "is_dark": true });
                };
                let lines = spot.lines.iter().map(|line| {
                    json!({ "wavelength_nm": line.wavelength_nm, "rms_mm": line.rms_mm, "centroid_mm": line.centroid_mm,
                            "points_mm": line.points_mm })
                });
                json!({
                    "angle_deg": angle,
                    "is_dark": false,
                    "centroid_mm": spot.centroid_mm,
                    "chief_mm": spot.chief_mm,
                    "rms_mm": spot.rms_mm,
                    "largest_mm": spot.largest_mm,
                    "lines": lines.collect::<Vec<_>>(),
                })
            };
            through.push(json!({ "defocus_mm": mm, "fields": fields.iter().map(spot).collect::<Vec<_>>() }));
        }
        Ok(with(head, json!({ "defocus": through })))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_fans_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    rays: usize,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    within(rays, MOST, "rays of a fan")?;
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &SOME)?;
        let fan = |lines: &[FanLine]| -> Vec<Value> {
            let ray = |line: &FanLine| {
                json!({
                    "wavelength_nm": line.wavelength_nm,
                    "pupil": line.rays.iter().map(|ray| ray.pupil).collect::<Vec<_>>(),
                    "error_mm": line.rays.iter().map(|ray| ray.error_mm).collect::<Vec<_>>(),
                    "path_waves": line.rays.iter().map(|ray| ray.path_waves).collect::<Vec<_>>(),
                })
            };
            lines.iter().map(ray).collect()
        };
        let field = |&angle: &f64| match analysis.fans(angle, rays) {
            Some(fans) => json!({ "angle_deg": angle, "is_dark": false, "tangential": fan(&fans.tangential),
                                  "sagittal": fan(&fans.sagittal) }),
            None => json!({ "angle_deg": angle, "is_dark": true }),
        };
        Ok(with(head, json!({ "fields": fields.iter().map(field).collect::<Vec<_>>() })))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_mtf_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    frequencies: (f64, usize),
    heights: (usize, f64),
) -> Result<String, Error> {
    let ((highest_per_mm, steps), (heights, height_step_per_mm)) = (frequencies, heights);
    within(steps, MOST, "steps of the frequency")?;
    within(heights, MOST, "heights")?;
    let is_good = |frequency: f64| (1e-6..=1e6).contains(&frequency);
    if !is_good(highest_per_mm) || !is_good(height_step_per_mm) {
        return Err(invalid(format!(
            "frequencies to {highest_per_mm} and {height_step_per_mm} lines/mm: give more than 0"
        )));
    }
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &SOME)?;
        let curve = |c: &Curve| json!({ "contrast": c.contrast, "geometric": c.geometric, "limit": c.limit });
        let entry = |angle: f64, step_per_mm: f64, count: usize| match analysis.mtf(angle, step_per_mm, count) {
            Ok(mtf) => Ok(json!({ "angle_deg": angle, "is_dark": false, "height_mm": mtf.height_mm,
                                  "sagittal": curve(&mtf.sagittal), "tangential": curve(&mtf.tangential) })),
            Err(MtfError::Dark) => Ok(json!({ "angle_deg": angle, "is_dark": true })),
            Err(error) => Err(invalid(format!("lens '{}': {error}", system.name()))),
        };
        let step = highest_per_mm / steps as f64;
        let by_frequency = fields.iter().map(|&angle| entry(angle, step, steps + 1));
        let by_frequency = by_frequency.collect::<Result<Vec<_>, Error>>()?;
        // Frequencies 0, 1, 2, 3 and 4 steps up.
        let half = fields.iter().fold(0.0, |most: f64, angle| most.max(angle.abs()));
        let angles: Vec<f64> =
            if half > 0.0 { evenly(heights).iter().map(|part| part * half).collect() } else { vec![0.0] };
        let by_height = angles.iter().map(|&angle| entry(angle, height_step_per_mm, 5));
        let by_height = by_height.collect::<Result<Vec<_>, Error>>()?;
        let frequencies = |step: f64, count: usize| (0..count).map(|i| i as f64 * step).collect::<Vec<_>>();
        Ok(with(
            head,
            json!({
                "frequencies_per_mm": frequencies(step, steps + 1),
                "fields": by_frequency,
                "height_frequencies_per_mm": frequencies(height_step_per_mm, 5),
                "heights": by_height,
            }),
        ))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_psf_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &SOME)?;
        let field = |&angle: &f64| match analysis.psf(angle) {
            Ok(psf) => json!({
                "angle_deg": angle,
                "is_dark": false,
                "height_mm": psf.height_mm,
                "strehl": psf.strehl,
                "side": psf.side,
                "step_mm": psf.step_mm,
                "values": psf.values,
                "radii_mm": psf.radii_mm,
                "encircled": psf.encircled,
            }),
            Err(PsfError::Dark) => json!({ "angle_deg": angle, "is_dark": true }),
            Err(PsfError::TooWide { spread_mm, times, .. }) => {
                json!({ "angle_deg": angle, "is_dark": false, "spread_mm": spread_mm, "spread_times": times })
            }
        };
        Ok(with(head, json!({ "fields": fields.iter().map(field).collect::<Vec<_>>() })))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_distortion_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    count: usize,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    within(count, MOST, "fields")?;
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &evenly(count))?;
        let chief = |&angle: &f64| match analysis.chief_ray(angle) {
            Some(ray) => json!({
                "angle_deg": angle,
                "is_dark": false,
                "height_mm": ray.height_mm,
                "straight_height_mm": ray.straight_height_mm,
                "even_height_mm": ray.even_height_mm,
                "tangential_focus_mm": ray.tangential_focus_mm,
                "sagittal_focus_mm": ray.sagittal_focus_mm,
                "colour_mm": ray.colour_mm,
            }),
            None => json!({ "angle_deg": angle, "is_dark": true }),
        };
        let fields: Vec<Value> = fields.iter().map(chief).collect();
        Ok(with(head, json!({ "height_by_slope_mm": analysis.height_by_slope_mm(), "fields": fields })))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_transmission_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    spectrum_nm: Vec<f64>,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    within(spectrum_nm.len(), MOST, "wavelengths")?;
    spectrum_nm.iter().try_for_each(|&nm| check_wavelength(nm))?;
    let is_assumed = settings.coating.is_none() && lens.prescription.assumes_coatings();
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &SOME)?;
        let through = analysis.transmission(&fields, &spectrum_nm);
        let field = |one: &FieldTransmission| json!({ "angle_deg": one.angle_deg, "parts": one.parts, "is_dark": one.parts.is_none() });
        let mut coatings: Vec<Value> = Vec::new();
        for surface in system.surfaces() {
            let is_known = coatings.iter().any(|known| known["name"] == surface.coating.name());
            if !is_known && !surface.split(line_nm::D, 1.0, true).reflected.iter().all(|r| *r == 0.0) {
                let on = surface.element.behind().name();
                let reflected: Vec<f64> =
                    spectrum_nm.iter().map(|nm| surface.split(*nm, 1.0, true).mean_reflected()).collect();
                coatings.push(json!({ "name": surface.coating.name(), "before": on, "reflected": reflected }));
            }
        }
        let t_number = t_number(&system, look.main_nm(), analysis.film().z_mm);
        Ok(with(
            head,
            json!({
                "spectrum_nm": spectrum_nm,
                "t_number": t_number,
                "coating_is_assumed": is_assumed,
                "coatings": coatings,
                "unknown_absorption": system.glasses_of_unknown_absorption(),
                "fields": through.iter().map(field).collect::<Vec<_>>(),
            }),
        ))
    })?
}

/// See the stub.
#[pyfunction]
pub(crate) fn lens_illumination_json(
    py: Python<'_>,
    lens: &Lens,
    settings: Described<LensSettings>,
    look: Described<Look>,
    count: usize,
) -> Result<String, Error> {
    let (settings, look) = (settings.0, look.0);
    within(count, MOST, "fields")?;
    let system = look.system(lens, &settings)?;
    without_gil(py, || {
        let (analysis, fields, head) = look.open(&system, &evenly(count))?;
        let lit = analysis.illumination(&fields);
        let field = |light: &Illumination| {
            json!({ "angle_deg": light.angle_deg, "height_mm": light.height_mm, "relative": light.relative,
                    "projected_sr": light.projected_sr })
        };
        Ok(with(head, json!({ "fields": lit.iter().map(field).collect::<Vec<_>>() })))
    })?
}
