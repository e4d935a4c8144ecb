//! What a file of calibrations holds.

use petzval_optics::calibration::Calibration;
use petzval_optics::formats::calibration::CalibrationFile;
use serde::Serialize;
use serde_json::{Map, Value};

/// A file of calibrations. Angles in degrees, null where there is none.
#[derive(Serialize)]
pub struct CalibrationReport {
    format: &'static str,
    remarks: Vec<String>,
    cameras: Vec<CameraReport>,
}

#[derive(Serialize)]
struct CameraReport {
    name: String,
    model: &'static str,
    size_px: [u32; 2],
    parameters: Map<String, Value>,
    /// The part of the picture that shows something.
    covered: f64,
    /// Why the rest shows nothing.
    reason: Option<String>,
    horizontal_field_deg: Option<f64>,
    vertical_field_deg: Option<f64>,
    /// Largest angle from the axis in the picture.
    largest_angle_deg: f64,
    /// The angle from the axis up to which the model is valid all around; null: it has no fold.
    valid_to_deg: Option<f64>,
    /// Pixels for a radian about the axis, across and down.
    focal_px: Option<[f64; 2]>,
}

/// Reports what a file of calibrations holds.
pub fn report(file: &CalibrationFile) -> CalibrationReport {
    let cameras = file.cameras.iter().map(|camera| of_camera(&camera.name, &camera.calibration)).collect();
    CalibrationReport { format: file.format.name(), remarks: file.remarks.clone(), cameras }
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
