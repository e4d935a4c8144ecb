//! The report of a file of calibrations.

use super::ReportError;
use crate::camera::{CalibrationSettings, CameraDescription};
use glam::DVec2;
use petzval_optics::calibration::Calibration;
use petzval_optics::formats::calibration::{self, CalibrationFile};
use petzval_optics::lensfun::calibrated_lens::CalibrationSet;
use petzval_optics::lensfun::lateral_colour::Channel;
use petzval_optics::lensfun::{Body, CalibratedLens, Database};
use serde::Serialize;
use serde_json::{Map, Value};

/// The report of a file of calibrations. Angles in degrees, null where there is none.
#[derive(Serialize)]
pub struct CalibrationReport {
    format: &'static str,
    remarks: Vec<String>,
    cameras: Vec<CameraReport>,
    /// Lenses of a lensfun database.
    lenses: Vec<LensEntry>,
    /// Names of the camera bodies of a lensfun database.
    bodies: Vec<String>,
}

/// A lens of a lensfun database.
#[derive(Serialize)]
struct LensEntry {
    name: String,
    mounts: Vec<String>,
    focal_range_mm: [f64; 2],
    /// Crop factors of the sensors with which it was measured.
    crop_factors: Vec<f64>,
    /// Numbers of measurements of distortion, vignetting and lateral colour.
    measured: [usize; 3],
}

/// The report of a lens of a lensfun database at a setting.
#[derive(Serialize)]
pub struct PhotographicReport {
    #[serde(flatten)]
    camera: CameraReport,
    /// The focal length that the lens is marked with at this setting.
    marked_mm: f64,
    film_width_mm: f64,
    /// The illumination of the corner over that of the middle, stops; null: not measured, or dark.
    corner_stops: Option<f64>,
    /// The distances of red and blue from green in the corner, outwards, pixels; null: not measured.
    corner_lateral_px: Option<[f64; 2]>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct CameraReport {
    name: String,
    model: &'static str,
    size_px: [u32; 2],
    parameters: Map<String, Value>,
    /// The part of the picture that shows something.
    covered: f64,
    /// The reason why the rest shows nothing.
    reason: Option<String>,
    horizontal_field_deg: Option<f64>,
    vertical_field_deg: Option<f64>,
    /// Largest angle from the axis in the picture.
    largest_angle_deg: f64,
    /// The angle from the axis up to which the model is valid all around; null: it has no fold.
    valid_to_deg: Option<f64>,
    /// Focal lengths across and down, pixels.
    focal_px: Option<[f64; 2]>,
}

/// The report of a file of calibrations or of a lensfun database.
///
/// # Errors
/// [`ReportError`]: there is none, or it cannot be read.
pub fn of_settings(settings: &CalibrationSettings) -> Result<CalibrationReport, ReportError> {
    if settings.is_of_lensfun() {
        Ok(of_database(&settings.database()?))
    } else {
        Ok(report(&calibration::read(&settings.path)?))
    }
}

/// The report of a lens of a lensfun database at a camera's setting, for a picture of that many pixels.
///
/// # Errors
/// [`ReportError`]: there is no such lens, or it makes no camera at this setting.
pub fn of_lens(d: &CameraDescription, size_px: [u32; 2]) -> Result<PhotographicReport, ReportError> {
    let lens = d.photographic_lens(size_px)?;
    let lens =
        lens.ok_or_else(|| ReportError::OutOfRange("this calibration is no lens of a lensfun database".into()))?;
    let corner = DVec2::from_array(size_px.map(f64::from));
    let lateral = [Channel::Red, Channel::Blue].map(|channel| lens.lateral_px(corner, channel));
    let stops = lens.illumination(corner).map(f64::log2);
    Ok(PhotographicReport {
        marked_mm: lens.marked_mm,
        film_width_mm: lens.film_width_mm(),
        corner_stops: stops.filter(|_| lens.has_vignetting()),
        corner_lateral_px: lens.has_lateral_colour().then_some(lateral),
        camera: of_camera(&lens.name, &lens.calibration),
        remarks: lens.remarks,
    })
}

fn of_database(database: &Database) -> CalibrationReport {
    let mut lenses: Vec<LensEntry> = database.lenses().iter().map(entry).collect();
    lenses.sort_by(|a, b| a.name.cmp(&b.name));
    // Entries of one name are one lens, measured with several sensors.
    lenses.dedup_by(|next, first| {
        let is_same = next.name == first.name;
        if is_same {
            first.crop_factors.append(&mut next.crop_factors);
            first.measured = std::array::from_fn(|i| first.measured[i] + next.measured[i]);
        }
        is_same
    });
    let mut bodies: Vec<String> = database.bodies().iter().map(Body::name).collect();
    bodies.sort_unstable();
    bodies.dedup();
    CalibrationReport { format: "a lensfun database", remarks: Vec::new(), cameras: Vec::new(), lenses, bodies }
}

fn entry(lens: &CalibratedLens) -> LensEntry {
    let count = |of: &dyn Fn(&CalibrationSet) -> usize| lens.sets.iter().map(of).sum();
    LensEntry {
        name: lens.name(),
        mounts: lens.mounts.clone(),
        focal_range_mm: lens.focal_range_mm,
        crop_factors: lens.sets.iter().map(|set| set.sensor.crop_factor).collect(),
        measured: [
            count(&|set| set.distortion.len()),
            count(&|set| set.vignetting.len()),
            count(&|set| set.lateral_colour.len()),
        ],
    }
}

/// Reports the content of a file of calibrations.
pub fn report(file: &CalibrationFile) -> CalibrationReport {
    let cameras = file.cameras.iter().map(|camera| of_camera(&camera.name, &camera.calibration)).collect();
    let (lenses, bodies) = (Vec::new(), Vec::new());
    CalibrationReport { format: file.format.name(), remarks: file.remarks.clone(), cameras, lenses, bodies }
}

fn of_camera(name: &str, calibration: &Calibration) -> CameraReport {
    let survey = calibration.survey();
    let [horizontal, vertical] = survey.field_rad.map(|field| field.map(f64::to_degrees));
    CameraReport {
        name: name.to_owned(),
        model: calibration.model().name(),
        size_px: calibration.size_px(),
        parameters: parameters(calibration),
        covered: survey.covered,
        reason: survey.reason.map(|reason| reason.to_string()),
        horizontal_field_deg: horizontal,
        vertical_field_deg: vertical,
        largest_angle_deg: survey.largest_angle_rad.to_degrees(),
        valid_to_deg: survey.fold_rad.map(f64::to_degrees),
        focal_px: calibration.focal_px(),
    }
}

/// The parameters by name.
pub(super) fn parameters(calibration: &Calibration) -> Map<String, Value> {
    let names = calibration.model().parameter_names().iter();
    names.zip(calibration.parameters()).map(|(name, value)| ((*name).to_owned(), Value::from(*value))).collect()
}
