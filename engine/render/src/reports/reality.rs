//! A lens beside photographers' measurements of its product, by a lensfun database.

use std::path::PathBuf;

use super::{MOST, ReportError, ReportSettings};
use petzval_optics::focus::focused;
use petzval_optics::glass::line_nm;
use petzval_optics::lensfun::{CalibratedLens, Database};
use petzval_optics::paraxial::Paraxial;
use petzval_optics::prescription::Prescription;
use petzval_optics::reality::{
    ColourRow, DistortionBeside, VignettingRow, colour_beside, distortion_beside, fields_to, vignetting_beside,
};
use petzval_optics::sensitivity::Sensitivities;
use petzval_optics::system::{LensSettings, System};
use serde::Serialize;

/// The options of a comparison.
#[derive(Clone, Debug)]
pub struct RealityOptions {
    /// A lensfun database: a file, or a folder of them; `None`: the installed one.
    pub lensfun: Option<PathBuf>,
    /// The product's name there; `None`: that of the lens file's header, `# lensfun:`.
    pub product: Option<String>,
    /// The marked focal length of the measurement; `None`: the measured one nearest to the lens's focal length as it is set.
    pub marked_mm: Option<f64>,
    /// The crop factor of the camera; `None`: that of the film in the lens file's header, or 1.
    pub crop_factor: Option<f64>,
    /// The f-numbers of vignetting; none: wide open and F/8.
    pub f_numbers: Vec<f64>,
    /// The distance of focus, mm, from the entrance pupil; `None`: infinity.
    pub focus_distance_mm: Option<f64>,
    /// The word of the camera whose channels see lateral colour.
    pub sensor: String,
    /// The f-number of lateral colour.
    pub colour_f_number: f64,
    /// Number of fields from the axis to the corner.
    pub count: usize,
}

/// A lens beside its calibration.
#[derive(Serialize)]
pub struct Reality {
    name: String,
    efl_mm: Option<f64>,
    f_number: Option<f64>,
    focus_distance_mm: Option<f64>,
    /// The product in the database, and the file and line it stands in.
    product: String,
    place: (String, u32),
    marked_mm: f64,
    crop_factor: f64,
    corner_mm: f64,
    distortion: Option<DistortionBeside>,
    vignetting: Vec<VignettingAt>,
    sensor: String,
    colour_f_number: f64,
    colour: Vec<ColourRow>,
}

/// Vignetting at an f-number.
#[derive(Serialize)]
struct VignettingAt {
    f_number: f64,
    /// The distance from the nearest measurement, in lensfun's measure; the values are interpolated if it is not 0.
    apart: f64,
    rows: Vec<VignettingRow>,
}

/// Lensfun's distance of infinity, m.
const FAR_M: f64 = 1000.0;

impl RealityOptions {
    fn check(&self) -> Result<(), ReportError> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let what = if !(3..=MOST).contains(&self.count) {
            format!("{} fields: give 3 to {MOST}", self.count)
        } else if !self.f_numbers.iter().chain([&self.colour_f_number]).all(|n| positive(*n)) {
            "an f-number that is not above zero: give one such as 8".to_owned()
        } else if !self.marked_mm.into_iter().chain(self.crop_factor).all(positive) {
            "a focal length or a crop factor that is not above zero: give one".to_owned()
        } else if self.focus_distance_mm.is_some_and(|mm| mm.is_nan() || mm <= 0.0) {
            "a distance that is not above zero: give millimetres, or inf".to_owned()
        } else {
            return Ok(());
        };
        Err(ReportError::OutOfRange(what))
    }

    fn product(&self, lens: &Prescription) -> Result<CalibratedLens, ReportError> {
        let named = self.product.as_deref().or_else(|| lens.metadata.text("lensfun"));
        let name = named.ok_or_else(|| ReportError::Lens {
            lens: lens.name.clone(),
            why: "its file names no product of lensfun (# lensfun: NAME); give --product NAME".to_owned(),
        })?;
        let database = match &self.lensfun {
            Some(path) => Database::read(path)?,
            None => Database::installed()?,
        };
        Ok(database.find(name)?)
    }

    fn camera(&self) -> Result<&'static Sensitivities, ReportError> {
        Sensitivities::shipped(&self.sensor).ok_or_else(|| {
            let known = Sensitivities::words().join(", ");
            ReportError::OutOfRange(format!("no camera's sensitivities are called '{}': give {known}", self.sensor))
        })
    }

    /// The focused lens at an f-number; wide open where that is no larger than its own.
    fn stopped_down(
        &self,
        lens: &Prescription,
        settings: &LensSettings,
        wide_open: Option<f64>,
        f_number: f64,
    ) -> Result<System, ReportError> {
        let opened = settings.clone().opened(wide_open.filter(|widest| f_number > *widest).map(|_| f_number));
        Ok(focused(lens, &opened, line_nm::D, self.focus_distance_mm)?.0)
    }

    fn report_settings(&self, wavelengths_nm: Vec<f64>) -> ReportSettings {
        ReportSettings {
            fields_deg: Vec::new(),
            wavelengths_nm,
            azimuth_deg: 90.0,
            focus_distance_mm: self.focus_distance_mm,
            best_focus: false,
            defocus_mm: 0.0,
        }
    }
}

/// The lens by rays beside the calibration of its product.
///
/// # Errors
/// [`ReportError`].
pub fn reality(lens: &Prescription, settings: &LensSettings, options: &RealityOptions) -> Result<Reality, ReportError> {
    options.check()?;
    let camera = options.camera()?;
    let product = options.product(lens)?;
    let film_mm = lens.metadata.film_mm.unwrap_or([36.0, 24.0]);
    let of_film = 36.0_f64.hypot(24.0) / film_mm[0].hypot(film_mm[1]);
    let crop_factor = options.crop_factor.unwrap_or(of_film);
    let corner_mm = 0.5 * 36.0_f64.hypot(24.0) / crop_factor;

    let main = options.report_settings(vec![line_nm::D]);
    let (system, _) = focused(lens, settings, line_nm::D, options.focus_distance_mm)?;
    let analysis = main.analysis(&system)?;
    let fields = fields_to(&analysis, corner_mm, options.count);
    let paraxial = Paraxial::new(&system, line_nm::D);
    let marked_mm = options.marked_mm.unwrap_or_else(|| product.nearest_marked_mm(analysis.height_by_slope_mm().abs()));
    let measured = product.distortion(crop_factor, marked_mm).zip(product.projection);
    let distortion = measured.and_then(|(measured, projection)| {
        distortion_beside(&fields, analysis.height_by_slope_mm().abs(), &measured, projection)
    });

    let angles_deg: Vec<f64> = fields.iter().map(|field| field.angle_deg).collect();
    let wide_open = paraxial.f_number;
    let f_numbers = match options.f_numbers.as_slice() {
        [] => wide_open.into_iter().chain([8.0]).collect(),
        given => given.to_vec(),
    };
    let distance_m = options.focus_distance_mm.filter(|mm| mm.is_finite()).map_or(FAR_M, |mm| mm * 1e-3);
    let mut vignetting = Vec::new();
    for f_number in f_numbers {
        let Some(measured) = product.vignetting(crop_factor, marked_mm, f_number, distance_m) else { continue };
        // A product may be marked with a rounder number than the patent's.
        let system = options.stopped_down(lens, settings, wide_open, f_number)?;
        let analysis = main.analysis(&system)?;
        vignetting.push(VignettingAt {
            f_number,
            apart: measured.apart,
            rows: vignetting_beside(&analysis, &angles_deg, &measured),
        });
    }

    let colour = match product.lateral_colour(crop_factor, marked_mm) {
        None => Vec::new(),
        Some(measured) => {
            let system = options.stopped_down(lens, settings, wide_open, options.colour_f_number)?;
            let seen = options.report_settings(camera.samples().map(|(nm, _)| nm).collect());
            colour_beside(&seen.analysis(&system)?, &angles_deg, camera, &measured)
        }
    };
    Ok(Reality {
        name: system.name().to_owned(),
        efl_mm: paraxial.efl_mm,
        f_number: paraxial.f_number,
        focus_distance_mm: options.focus_distance_mm.filter(|mm| mm.is_finite()),
        product: product.name(),
        place: product.place.clone(),
        marked_mm,
        crop_factor,
        corner_mm,
        distortion,
        vignetting,
        sensor: camera.name.clone(),
        colour_f_number: options.colour_f_number,
        colour,
    })
}
