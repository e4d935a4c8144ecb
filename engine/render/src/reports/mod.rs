//! Reports on a lens, each in a file of its own. Adding one is a file here with a [`LensReport`], and a line in [`REPORTS`]; the command
//! line and Blender offer those that `petzval/lens_reports` draws.
//!
//! A report's options come as JSON, and its result goes as JSON: lengths in mm, angles in degrees, null where there is no finite number.

pub mod calibration;
mod distortion;
pub mod drawing;
mod fans;
pub mod fitted_camera;
pub mod fitted_lens;
pub mod ghosts;
mod illumination;
pub mod info;
mod mtf;
mod psf;
pub mod reality;
mod spots;
pub mod summary;
mod tolerance;
mod transmission;

use crate::camera::CameraError;
use petzval_optics::analysis::Analysis;
use petzval_optics::focus::{Focus, FocusError, GroupsError, focused};
use petzval_optics::formats::calibration::CalibrationFileError;
use petzval_optics::glass::line_nm;
use petzval_optics::lensfun::LensfunError;
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::system::{LensSettings, System, SystemError};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Largest number of fields, wavelengths, rays, steps or heights of a report.
const MOST: usize = 2000;
/// Parts of the half field of reports that show some fields.
const SOME_FIELDS: [f64; 3] = [0.0, 0.7, 1.0];

/// All reports by name.
pub const REPORTS: [(&str, Run); 8] = [
    entry::<spots::Spots>(),
    entry::<fans::FanOptions>(),
    entry::<mtf::MtfOptions>(),
    entry::<psf::PsfOptions>(),
    entry::<distortion::DistortionOptions>(),
    entry::<illumination::IlluminationOptions>(),
    entry::<transmission::TransmissionOptions>(),
    entry::<tolerance::ToleranceOptions>(),
];

/// A report on a lens, with options as JSON; its result is JSON.
pub type Run = fn(&Prescription, &LensSettings, &ReportSettings, Value) -> Result<String, ReportError>;

/// An error by which there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// There is no report of this name.
    #[error("there is no report '{name}'; use one of {known}")]
    Unknown {
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// An option of the report has another type.
    #[error("{0}")]
    Options(#[from] serde_json::Error),
    /// A number is out of range.
    #[error("{0}")]
    OutOfRange(String),
    /// The lens cannot be reported on.
    #[error("lens '{lens}': {why}")]
    Lens {
        /// Name of the lens.
        lens: String,
        /// The reason why there is no report on the lens.
        why: String,
    },
    /// The lensfun database has no calibration of the lens.
    #[error(transparent)]
    Lensfun(#[from] LensfunError),
    /// A file of calibrations cannot be read.
    #[error(transparent)]
    Calibration(#[from] CalibrationFileError),
    /// A camera cannot be made.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The lens cannot be set.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The lens cannot be focused.
    #[error(transparent)]
    Focus(#[from] FocusError),
    /// The groups of the lens cannot focus it.
    #[error(transparent)]
    Groups(#[from] GroupsError),
}

/// A report of that name on a lens.
///
/// # Errors
/// [`ReportError`].
pub fn report(
    name: &str,
    lens: &Prescription,
    lens_settings: &LensSettings,
    settings: &ReportSettings,
    options: Value,
) -> Result<String, ReportError> {
    let known = || REPORTS.map(|(name, _)| name).join(", ");
    let found = REPORTS.iter().find(|(known, _)| *known == name);
    let (_, run) = found.ok_or_else(|| ReportError::Unknown { name: name.to_owned(), known: known() })?;
    run(lens, lens_settings, settings, options)
}

/// A kind of report; the value holds its options.
trait LensReport: DeserializeOwned {
    /// Name of the report on the command line.
    const NAME: &'static str;
    /// Result of the report.
    type Found: Serialize;

    /// Parts of the half field that are reported on where no fields are given.
    fn parts(&self) -> Vec<f64> {
        SOME_FIELDS.to_vec()
    }

    /// Checks the options.
    ///
    /// # Errors
    /// [`ReportError`].
    fn check(&self) -> Result<(), ReportError> {
        Ok(())
    }

    /// The result.
    ///
    /// # Errors
    /// [`ReportError`].
    fn find(&self, subject: ReportedLens<'_>) -> Result<Self::Found, ReportError>;
}

const fn entry<R: LensReport>() -> (&'static str, Run) {
    (R::NAME, run::<R>)
}

fn run<R: LensReport>(
    lens: &Prescription,
    lens_settings: &LensSettings,
    settings: &ReportSettings,
    options: Value,
) -> Result<String, ReportError> {
    let asked: R = serde_json::from_value(options)?;
    asked.check()?;
    let main_nm = settings.main_nm();
    let (system, _) = focused(lens, lens_settings, main_nm, settings.focus_distance_mm)?;
    let analysis = settings.analysis(&system)?;
    let fields_deg = settings.fields_deg(&analysis, &asked.parts());
    let head = settings.head(&system, &analysis);
    let coating_is_assumed = lens_settings.coating.is_none() && lens.assumes_coatings();
    let subject = ReportedLens {
        lens,
        lens_settings,
        settings,
        system: &system,
        analysis,
        fields_deg,
        main_nm,
        coating_is_assumed,
    };
    let found = asked.find(subject)?;
    Ok(serde_json::to_string(&WrittenReport { head, found })?)
}

/// The subject of a report: a lens that is set, focused and looked at.
struct ReportedLens<'a> {
    /// The lens as it was read.
    lens: &'a Prescription,
    lens_settings: &'a LensSettings,
    settings: &'a ReportSettings,
    system: &'a System,
    analysis: Analysis<'a>,
    fields_deg: Vec<f64>,
    /// The main wavelength in vacuum, at which the lens is focused.
    main_nm: f64,
    /// True if nothing is known of a coating, so that one was assumed.
    coating_is_assumed: bool,
}

/// The light and the film of a report.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportSettings {
    /// Angles to the axis, counted at the entrance pupil; none: the report's own.
    pub fields_deg: Vec<f64>,
    /// Wavelengths in vacuum; that nearest the d line is the main one. None: F, d and C.
    pub wavelengths_nm: Vec<f64>,
    /// Azimuth of the fields, from right to up.
    pub azimuth_deg: f64,
    /// Focus distance from the entrance pupil; `None` is infinity.
    pub focus_distance_mm: Option<f64>,
    /// True if the film is at the best focus of the axis, instead of the paraxial image.
    pub best_focus: bool,
    /// Displacement of the film from that place.
    pub defocus_mm: f64,
}

impl ReportSettings {
    fn wavelengths_nm(&self) -> &[f64] {
        match self.wavelengths_nm.as_slice() {
            [] => &[line_nm::F, line_nm::D, line_nm::C],
            given => given,
        }
    }

    /// Index of the main wavelength.
    fn main(&self) -> usize {
        let lines = self.wavelengths_nm();
        let from_d = |i: &usize| (lines[*i] - line_nm::D).abs();
        (0..lines.len()).min_by(|a, b| from_d(a).total_cmp(&from_d(b))).unwrap_or(0)
    }

    /// The main wavelength, at which the lens is focused.
    fn main_nm(&self) -> f64 {
        self.wavelengths_nm()[self.main()]
    }

    fn analysis<'a>(&self, system: &'a System) -> Result<Analysis<'a>, ReportError> {
        let lines = self.wavelengths_nm();
        lines.iter().try_for_each(|&nm| check_wavelength(nm))?;
        check_fields(&self.fields_deg)?;
        if lines.len().max(self.fields_deg.len()) > MOST || !self.defocus_mm.is_finite() {
            let what = format!("more than {MOST} fields or wavelengths, or a defocus without end: give less");
            return Err(ReportError::OutOfRange(what));
        }
        let focus = Focus::new(system, self.main_nm(), self.focus_distance_mm)?;
        let wrong = |why: String| ReportError::Lens { lens: system.name().to_owned(), why };
        let analysis = Analysis::new(system, focus, lines, self.main(), self.azimuth_deg.to_radians());
        let analysis = analysis.ok_or_else(|| {
            let what = "its entrance pupil lies at infinity, so there is nothing to count fields from: only `lens draw` and `lens trace` show it";
            wrong(what.to_owned())
        })?;
        let analysis = match self.best_focus {
            true => analysis.at_best_focus().map_err(|error| wrong(error.to_string()))?,
            false => analysis,
        };
        let film_z_mm = analysis.film().z_mm + self.defocus_mm;
        Ok(analysis.with_film_at(film_z_mm))
    }

    /// The fields that are asked for, or else `parts` of the half field.
    fn fields_deg(&self, analysis: &Analysis<'_>, parts: &[f64]) -> Vec<f64> {
        let half_field_deg = analysis.half_field_deg();
        match self.fields_deg.as_slice() {
            [] if half_field_deg > 0.0 => parts.iter().map(|part| part * half_field_deg).collect(),
            [] => vec![0.0],
            given => given.to_vec(),
        }
    }

    fn head(&self, system: &System, analysis: &Analysis<'_>) -> Head {
        let paraxial = Paraxial::new(system, self.main_nm());
        Head {
            name: system.name().to_owned(),
            efl_mm: paraxial.efl_mm,
            f_number: paraxial.f_number,
            focus_distance_mm: self.focus_distance_mm.filter(|d| d.is_finite()),
            film_z_mm: analysis.film().z_mm,
            wavelengths_nm: self.wavelengths_nm().to_vec(),
            main_wavelength: self.main(),
            azimuth_deg: self.azimuth_deg,
            airy_radius_mm: analysis.airy_radius_mm(),
            half_field_deg: analysis.half_field_deg(),
        }
    }
}

/// A report as it is written.
#[derive(Serialize)]
struct WrittenReport<F> {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    found: F,
}

/// The facts that every report states.
#[derive(Serialize)]
struct Head {
    name: String,
    efl_mm: Option<f64>,
    f_number: Option<f64>,
    focus_distance_mm: Option<f64>,
    film_z_mm: f64,
    wavelengths_nm: Vec<f64>,
    /// Index of the main wavelength.
    main_wavelength: usize,
    azimuth_deg: f64,
    airy_radius_mm: Option<f64>,
    half_field_deg: f64,
}

/// A result by field.
#[derive(Serialize)]
struct Fields<F> {
    fields: Vec<F>,
}

/// The result of a field, or that no light comes from it.
#[derive(Serialize)]
#[serde(untagged)]
enum FieldResult<F> {
    Lit {
        is_dark: bool,
        #[serde(flatten)]
        found: F,
    },
    Dark {
        angle_deg: f64,
        is_dark: bool,
    },
}

impl<F> FieldResult<F> {
    fn new(angle_deg: f64, found: Option<F>) -> Self {
        match found {
            Some(found) => Self::Lit { is_dark: false, found },
            None => Self::Dark { angle_deg, is_dark: true },
        }
    }
}

/// `count` numbers from 0 to 1 at equal steps.
fn evenly(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / (count - 1).max(1) as f64).collect()
}

fn within(count: usize, most: usize, what: &str) -> Result<(), ReportError> {
    let is_good = (2..=most).contains(&count);
    is_good.then_some(()).ok_or_else(|| ReportError::OutOfRange(format!("{count} {what}: give 2 to {most}")))
}

/// Checks a wavelength, nm.
///
/// # Errors
/// [`ReportError::OutOfRange`].
pub fn check_wavelength(nm: f64) -> Result<(), ReportError> {
    let what = || format!("wavelength {nm} nm: give nanometres; visible light is 380 to 780");
    (100.0..=20_000.0).contains(&nm).then_some(()).ok_or_else(|| ReportError::OutOfRange(what()))
}

fn check_fields(fields_deg: &[f64]) -> Result<(), ReportError> {
    match fields_deg.iter().find(|angle| !(-180.0..=180.0).contains(*angle)) {
        Some(angle) => {
            Err(ReportError::OutOfRange(format!("a field of {angle} degrees: give angles from -180 to 180")))
        }
        None => Ok(()),
    }
}
