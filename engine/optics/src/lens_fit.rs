//! A lens adjusted to a measured calibration: focal length, focus, film and gaps in air by which its chief rays come nearest to the
//! directions that a real camera sees.
//!
//! Residuals are in pixels: from a point of the sensor to the place where the calibration sees the direction of the lens from that point.
//! The axis stands at the calibration's principal point, for a sensor is never quite in its middle; parts of the calibration that are not
//! symmetric about it remain as residuals. A parameter that hardly changes the picture stays where it was: a change by all of its tolerance
//! costs a thousandth of a pixel.

mod error;
mod gaps;
mod set_lens;

use crate::calibration::Calibration;
use crate::chief_rays::FilmChiefRays;
use crate::focus::{FilmPlane, focused};
use crate::least_squares::{Minimum, Parameter, minimise};
use crate::paraxial::Paraxial;
use crate::prescription::Prescription;
use crate::prescription::moving::MovingParts;
use crate::system::{FocalLength, LensSettings, System};
use glam::{DVec2, DVec3};

pub use error::LensFitError;
use gaps::gaps_of;
use set_lens::SetLens;

/// Cells over the larger side of the picture, at whose corners the lens is compared.
const CELLS: f64 = 24.0;
/// Pixels that a change by all of a tolerance costs.
const PULL_PX: f64 = 1e-3;
/// Focal lengths, and film distances by the focal length, are sought within this part, and focus distances from so many focal lengths on.
const WIDEST_PART: f64 = 0.3;
const NEAREST: f64 = 4.0;
/// Two adjustments have the same effect on the picture where the sine of the angle between their effects is less than this.
const SAME: f64 = 0.02;

/// A quantity that is adjusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adjusted {
    /// The size of the whole lens; its film stays where the focus distance is sharp.
    FocalLength,
    /// The focus distance.
    Focus,
    /// The film's distance from the film place at which the focus distance is sharp.
    FilmDistance,
}

/// The tolerance of a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Millimetres of the published lens.
    Millimetres(f64),
    /// A part of the gap.
    Part(f64),
}

/// Gaps that are adjusted.
#[derive(Clone, Debug, PartialEq)]
pub struct GapsToFit {
    /// The tolerance of each.
    pub tolerance: Tolerance,
    /// The surfaces before the gaps; `None`: all gaps in air inside of the lens that do not move.
    pub surfaces: Option<Vec<usize>>,
}

/// A lens and the calibration that it is adjusted to.
#[derive(Clone, Debug)]
pub struct LensToFit<'a> {
    /// The lens.
    pub prescription: &'a Prescription,
    /// The settings at the start; a zoom stays at this focal length, and others start from it.
    pub settings: &'a LensSettings,
    /// The calibration.
    pub calibration: &'a Calibration,
    /// Width and height of a pixel on the sensor, mm.
    pub pitch_mm: [f64; 2],
    /// Vacuum wavelength of the rays.
    pub wavelength_nm: f64,
    /// The distance from the entrance pupil at which the camera was focused when it was calibrated, and at which its scene stood; `None`:
    /// infinity.
    pub focus_distance_mm: Option<f64>,
    /// The adjustments besides gaps.
    pub adjusted: &'a [Adjusted],
    /// Gaps that are adjusted; `None`: they stay.
    pub gaps: Option<GapsToFit>,
}

/// The difference of a lens from a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensMisfit {
    /// Root of the mean square over the picture, pixels and mm on the sensor.
    pub rms_px: f64,
    /// [`Self::rms_px`] on the sensor, mm.
    pub rms_mm: f64,
    /// The largest, pixels.
    pub worst_px: f64,
    /// The largest, on the sensor.
    pub worst_mm: f64,
    /// The point of the largest residual, pixels from the picture's upper left corner.
    pub worst_at_px: DVec2,
}

/// A gap that was adjusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedGap {
    /// The surface before it.
    pub surface: usize,
    /// The gap before and after, mm; after without the change of the whole lens's size.
    pub gap_mm: [f64; 2],
    /// The tolerance, mm.
    pub tolerance_mm: f64,
    /// Root mean square effect on the picture of a change by all of its tolerance, pixels.
    pub effect_px: f64,
}

/// The state of a lens as it was compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensState {
    /// Focal length at the wavelength.
    pub efl_mm: Option<f64>,
    /// Focus distance from the entrance pupil; `None`: infinity.
    pub focus_distance_mm: Option<f64>,
    /// The film from the last vertex.
    pub film_distance_mm: f64,
}

/// A lens that was adjusted.
#[derive(Clone, Debug)]
pub struct LensFit {
    /// The lens; the thickness behind its last surface is the film's distance.
    pub prescription: Prescription,
    /// The size of the lens, from that at the start.
    pub scale: f64,
    /// The misfit before and after.
    pub misfit: [LensMisfit; 2],
    /// The state of the lens before and after.
    pub state: [LensState; 2],
    /// The gaps that were adjusted.
    pub gaps: Vec<FittedGap>,
    /// Places of the picture that were compared, and the part of all that they are.
    pub points: usize,
    /// The part of the picture that was compared.
    pub part: f64,
    /// Pairs of adjustments with the same effect on the picture, but for less than this part of it.
    pub alike: Vec<(String, String, f64)>,
    /// Steps of the search.
    pub steps: usize,
}

/// The adjustments in their order, and the data that all of them share.
struct Search<'a> {
    task: &'a LensToFit<'a>,
    /// The lens at the start: a zoom stands still, and the size is that of the settings.
    base: Prescription,
    settings: LensSettings,
    adjusted: Vec<Adjusted>,
    /// Surface, gap and tolerance, mm.
    gaps: Vec<(usize, f64, f64)>,
    axis_px: DVec2,
    points: Vec<DVec2>,
}

/// Adjusts a lens to a calibration.
///
/// # Errors
/// [`LensFitError`].
pub fn fit(task: &LensToFit<'_>) -> Result<LensFit, LensFitError> {
    let mut search = Search::new(task)?;
    let parameters = search.parameters();
    if parameters.is_empty() {
        return Err(LensFitError::Nothing);
    }
    let start: Vec<f64> = parameters.iter().map(|p| p.start).collect();
    let all = search.all_points();
    search.points = search.set(&start)?.common(&search, &all);
    if search.points.len() * 4 < all.len() {
        return Err(LensFitError::TooLittle { points: search.points.len(), all: all.len() });
    }
    let before = search.misfit(&start);
    let Some(found) = minimise(&parameters, |values| search.residuals(values)) else {
        return Err(LensFitError::TooLittle { points: 0, all: all.len() });
    };
    let after = search.misfit(&found.values);
    let [from, to] = [&start, &found.values].map(|values| search.set(values));
    let (from, to) = (from?, to?);
    let gaps = search.gaps.iter().enumerate().map(|(i, &(surface, gap_mm, tolerance_mm))| {
        let index = search.adjusted.len() + i;
        let effect_px = search.effect_px(&found, index) * tolerance_mm;
        FittedGap { surface, gap_mm: [gap_mm, gap_mm + found.values[index]], tolerance_mm, effect_px }
    });
    Ok(LensFit {
        scale: to.scale,
        misfit: [before, after],
        state: [from.state(task.wavelength_nm), to.state(task.wavelength_nm)],
        gaps: gaps.collect(),
        points: search.points.len(),
        part: search.points.len() as f64 / all.len() as f64,
        alike: search.alike(&found),
        steps: found.steps,
        prescription: to.into_prescription(),
    })
}

impl<'a> Search<'a> {
    fn new(task: &'a LensToFit<'a>) -> Result<Self, LensFitError> {
        let zooms = task.prescription.moving.as_ref().is_some_and(|moving| moving.zoom_range_mm().is_some());
        let (base, settings) = match zooms {
            true => System::standing(task.prescription, task.settings, 0.0)?,
            false => (task.prescription.clone(), task.settings.clone()),
        };
        // A lens without power has no size to be adjusted.
        let scale = System::new(&base, &settings)?.scale();
        let base = if scale == 1.0 { base } else { base.scaled(scale) };
        let settings = LensSettings { focal_length: FocalLength::AsPublished, ..settings };
        let by_groups = base.moving.as_ref().is_some_and(MovingParts::focuses);
        let has = |wanted| task.adjusted.contains(&wanted);
        if !by_groups && has(Adjusted::Focus) && has(Adjusted::FilmDistance) {
            return Err(LensFitError::FocusIsFilm);
        }
        let mut adjusted = task.adjusted.to_vec();
        adjusted.dedup();
        let gaps = task.gaps.as_ref().map_or(Ok(Vec::new()), |gaps| gaps_of(&base, gaps, scale))?;
        let axis_px = task.calibration.project(DVec3::Z).map_err(|_| LensFitError::NoAxis)?;
        Ok(Self { task, base, settings, adjusted, gaps, axis_px, points: Vec::new() })
    }

    fn focal_mm(&self) -> f64 {
        let system = System::new(&self.base, &self.settings).ok();
        system.and_then(|system| Paraxial::new(&system, self.task.wavelength_nm).efl_mm).map_or(50.0, f64::abs)
    }

    fn parameters(&self) -> Vec<Parameter> {
        let focal = self.focal_mm();
        let one = |adjusted: &Adjusted| match adjusted {
            Adjusted::FocalLength => {
                Parameter { start: 1.0, scale: 0.01, bounds: [1.0 - WIDEST_PART, 1.0 / (1.0 - WIDEST_PART)] }
            }
            Adjusted::Focus => {
                let nearness = self.task.focus_distance_mm.map_or(0.0, f64::recip);
                let nearest = 1.0 / (NEAREST * focal);
                Parameter { start: nearness, scale: 0.01 / focal, bounds: [0.0, nearest.max(nearness)] }
            }
            Adjusted::FilmDistance => {
                Parameter { start: 0.0, scale: 0.01 * focal, bounds: [-WIDEST_PART * focal, WIDEST_PART * focal] }
            }
        };
        let gap = |&(_, _, tolerance): &(usize, f64, f64)| Parameter {
            start: 0.0,
            scale: tolerance,
            bounds: [-tolerance, tolerance],
        };
        self.adjusted.iter().map(one).chain(self.gaps.iter().map(gap)).collect()
    }

    /// Nodes over the picture with its edges, pixels.
    fn all_points(&self) -> Vec<DVec2> {
        let size = self.task.calibration.size_px();
        let larger = f64::from(size[0].max(size[1]));
        let [columns, rows] = size.map(|side| ((CELLS * f64::from(side) / larger).ceil() as u32).max(4));
        let at = |i: u32, n: u32, side: u32| f64::from(side) * f64::from(i) / f64::from(n);
        let node = |i: u32| {
            let (column, row) = (i % (columns + 1), i / (columns + 1));
            DVec2::new(at(column, columns, size[0]), at(row, rows, size[1]))
        };
        (0..(columns + 1) * (rows + 1)).map(node).collect()
    }

    /// The lens with its adjustments.
    fn set(&self, values: &[f64]) -> Result<SetLens, LensFitError> {
        let value = |wanted| self.adjusted.iter().position(|one| *one == wanted).map(|i| values[i]);
        let mut lens = self.base.clone();
        for (&(surface, gap_mm, _), change) in self.gaps.iter().zip(&values[self.adjusted.len()..]) {
            lens.surfaces[surface].thickness_mm = gap_mm + change;
        }
        let scale = value(Adjusted::FocalLength).unwrap_or(1.0);
        let lens = if scale == 1.0 { lens } else { lens.scaled(scale) };
        let distance_mm = match value(Adjusted::Focus) {
            Some(nearness) => (nearness > 0.0).then(|| nearness.recip()),
            None => self.task.focus_distance_mm,
        };
        let nm = self.task.wavelength_nm;
        let (system, focus) = focused(&lens, &self.settings, nm, distance_mm)?;
        let film_z_mm = focus.film_z_mm + value(Adjusted::FilmDistance).unwrap_or(0.0);
        let film = FilmPlane {
            curvature_per_mm: system.film_radius_mm().map_or(0.0, f64::recip),
            ..FilmPlane::upright(film_z_mm)
        };
        let rays = FilmChiefRays::new(&system, nm, film)?;
        let pupil_z_mm = Paraxial::new(&system, nm).entrance_pupil.z_mm.unwrap_or(0.0);
        Ok(SetLens { lens, scale, system, rays, pupil_z_mm, film_z_mm, distance_mm })
    }

    fn film_mm(&self, point: DVec2) -> DVec2 {
        let from_axis = (point - self.axis_px) * DVec2::from(self.task.pitch_mm);
        DVec2::new(-from_axis.x, from_axis.y)
    }

    /// The residual at each point, pixels; `None`: somewhere the calibration sees nothing.
    fn off(&self, values: &[f64]) -> Option<Vec<DVec2>> {
        let set = self.set(values).ok()?;
        self.points.iter().map(|&point| set.off(self, point)).collect()
    }

    fn residuals(&self, values: &[f64]) -> Option<Vec<f64>> {
        let share = (1.0 / self.points.len() as f64).sqrt();
        let mut all: Vec<f64> = self.off(values)?.into_iter().flat_map(|off| [off.x * share, off.y * share]).collect();
        let start = self.parameters();
        all.extend(start.iter().zip(values).map(|(p, value)| PULL_PX * (value - p.start) / p.scale));
        Some(all)
    }

    fn misfit(&self, values: &[f64]) -> LensMisfit {
        let pitch = DVec2::from(self.task.pitch_mm);
        let off = self.off(values).unwrap_or_default();
        let mut found = LensMisfit::default();
        for (off, at) in off.iter().zip(&self.points) {
            found.rms_px += off.length_squared() / self.points.len() as f64;
            found.rms_mm += (*off * pitch).length_squared() / self.points.len() as f64;
            if off.length() > found.worst_px {
                (found.worst_px, found.worst_mm, found.worst_at_px) = (off.length(), (*off * pitch).length(), *at);
            }
        }
        LensMisfit { rms_px: found.rms_px.sqrt(), rms_mm: found.rms_mm.sqrt(), ..found }
    }

    /// Root mean square effect of a parameter on the picture, pixels by its unit.
    fn effect_px(&self, found: &Minimum, parameter: usize) -> f64 {
        self.column(found, parameter).map(|slope| slope * slope).sum::<f64>().sqrt()
    }

    /// The change of the picture by a parameter, without the cost of that change.
    fn column<'b>(&self, found: &'b Minimum, parameter: usize) -> impl Iterator<Item = f64> + use<'b> {
        found.slopes[parameter].iter().take(2 * self.points.len()).copied()
    }

    fn alike(&self, found: &Minimum) -> Vec<(String, String, f64)> {
        let names: Vec<String> = (self.adjusted.iter().map(|one| one.name().to_owned()))
            .chain(self.gaps.iter().map(|(surface, ..)| format!("gap {surface}")))
            .collect();
        let mut pairs = Vec::new();
        for i in 0..names.len() {
            for j in 0..i {
                let dot: f64 = self.column(found, i).zip(self.column(found, j)).map(|(a, b)| a * b).sum();
                let cosine = dot / (self.effect_px(found, i) * self.effect_px(found, j));
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                if sine < SAME {
                    pairs.push((names[j].clone(), names[i].clone(), sine));
                }
            }
        }
        pairs
    }
}

impl Adjusted {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::FocalLength, Self::Focus, Self::FilmDistance];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::FocalLength => "focal-length",
            Self::Focus => "focus",
            Self::FilmDistance => "film-distance",
        }
    }
}

#[cfg(test)]
mod tests;
