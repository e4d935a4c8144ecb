//! Calibrations as files of OpenCV, ROS and COLMAP.

use super::opencv::HALF_PIXEL;
use super::{CalibratedCamera, Format, colmap};
use crate::calibration::{Calibration, Model};
use std::fmt::Write;
use thiserror::Error;

/// The reason why a calibration cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CalibrationWriteError {
    /// The format has no such model.
    #[error("camera '{camera}': {format} has no model like {model}; write an ST map of it, or another format")]
    Model {
        /// The camera.
        camera: String,
        /// The format by name.
        format: &'static str,
        /// The model by name.
        model: &'static str,
    },
    /// The format holds one camera.
    #[error("{format} has one camera a file, and there are {count}; choose one of {there}")]
    Several {
        /// The format by name.
        format: &'static str,
        /// The number of cameras.
        count: usize,
        /// Their names.
        there: String,
    },
    /// The format is only read.
    #[error("{0} is only read; write OpenCV's YAML or JSON, ROS's YAML or COLMAP's cameras.txt")]
    ReadOnly(&'static str),
}

/// Cameras as text; numbers are those that are read again to the last bit.
///
/// # Errors
/// [`CalibrationWriteError`].
pub fn write(cameras: &[CalibratedCamera], format: Format) -> Result<String, CalibrationWriteError> {
    if format == Format::Colmap {
        return colmap_file(cameras);
    }
    if !matches!(format, Format::OpenCvYaml | Format::OpenCvJson | Format::Ros) {
        return Err(CalibrationWriteError::ReadOnly(format.name()));
    }
    let [camera] = cameras else {
        let there = super::names(cameras);
        return Err(CalibrationWriteError::Several { format: format.name(), count: cameras.len(), there });
    };
    let plane = Matrices::of(camera, format)?;
    Ok(match format {
        Format::OpenCvJson => plane.opencv_json(),
        Format::Ros => plane.ros(&camera.name),
        _ => plane.opencv_yaml(),
    })
}

fn colmap_file(cameras: &[CalibratedCamera]) -> Result<String, CalibrationWriteError> {
    let mut text =
        "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n".to_owned();
    let _ = writeln!(text, "# Number of cameras: {}", cameras.len());
    // COLMAP's cameras have numbers, from 1 on.
    let own: Option<Vec<usize>> = cameras.iter().map(|camera| camera.name.parse().ok()).collect();
    for (i, camera) in cameras.iter().enumerate() {
        let id = own.as_ref().map_or(i + 1, |own| own[i]);
        let line = colmap::line(id, &camera.calibration).ok_or_else(|| no_model(camera, Format::Colmap))?;
        text.push_str(&line);
        text.push('\n');
    }
    Ok(text)
}

fn no_model(camera: &CalibratedCamera, format: Format) -> CalibrationWriteError {
    let model = camera.calibration.model().name();
    CalibrationWriteError::Model { camera: camera.name.clone(), format: format.name(), model }
}

/// The parameters of a camera as OpenCV and ROS keep them.
struct Matrices {
    size: [u32; 2],
    matrix: [f64; 9],
    distortion: Vec<f64>,
    is_fisheye: bool,
}

impl Matrices {
    fn of(camera: &CalibratedCamera, format: Format) -> Result<Self, CalibrationWriteError> {
        let calibration: &Calibration = &camera.calibration;
        let p = calibration.parameters();
        let is_fisheye = calibration.model() == Model::Fisheye;
        if !is_fisheye && calibration.model() != Model::OpenCv {
            return Err(no_model(camera, format));
        }
        let skew = if is_fisheye { p[0] * p[8] } else { 0.0 };
        let matrix = [p[0], skew, p[2] - HALF_PIXEL, 0.0, p[1], p[3] - HALF_PIXEL, 0.0, 0.0, 1.0];
        let distortion = if is_fisheye {
            p[4..8].to_vec()
        } else {
            let used = p[4..].iter().rposition(|k| *k != 0.0).map_or(0, |last| last + 1);
            // OpenCV takes 5, 8, 12 or 14; ROS calls those of more than 5 rational.
            let count = [5, 8, 12, 14].into_iter().find(|count| *count >= used).unwrap_or(14);
            p[4..4 + count].to_vec()
        };
        Ok(Self { size: calibration.size_px(), matrix, distortion, is_fisheye })
    }

    fn opencv_yaml(&self) -> String {
        let [width, height] = self.size;
        let matrix = |name: &str, rows: usize, cols: usize, data: &[f64]| {
            let data = listed(data);
            format!("{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n")
        };
        let fisheye = if self.is_fisheye { "fisheye_model: 1\n" } else { "" };
        format!(
            "%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\n{fisheye}{}{}",
            matrix("camera_matrix", 3, 3, &self.matrix),
            matrix("distortion_coefficients", self.distortion.len(), 1, &self.distortion),
        )
    }

    fn opencv_json(&self) -> String {
        let [width, height] = self.size;
        let matrix = |rows: usize, cols: usize, data: &[f64]| {
            let data = listed(data);
            format!(
                "{{\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": {rows},\n        \"cols\": {cols},\n        \"dt\": \"d\",\n        \"data\": [ {data} ]\n    }}"
            )
        };
        let fisheye = if self.is_fisheye { "    \"fisheye_model\": 1,\n" } else { "" };
        format!(
            "{{\n    \"image_width\": {width},\n    \"image_height\": {height},\n{fisheye}    \"camera_matrix\": {},\n    \"distortion_coefficients\": {}\n}}\n",
            matrix(3, 3, &self.matrix),
            matrix(self.distortion.len(), 1, &self.distortion),
        )
    }

    fn ros(&self, name: &str) -> String {
        let [width, height] = self.size;
        let matrix = |key: &str, rows: usize, cols: usize, data: &[f64]| {
            format!("{key}:\n  rows: {rows}\n  cols: {cols}\n  data: [{}]\n", listed(data))
        };
        let model = match (self.is_fisheye, self.distortion.len()) {
            (true, _) => "equidistant",
            (false, 5) => "plumb_bob",
            (false, _) => "rational_polynomial",
        };
        let m = &self.matrix;
        let projection = [m[0], m[1], m[2], 0.0, m[3], m[4], m[5], 0.0, m[6], m[7], m[8], 0.0];
        let name = serde_json::Value::from(name).to_string();
        format!(
            "image_width: {width}\nimage_height: {height}\ncamera_name: {name}\n{}distortion_model: {model}\n{}{}{}",
            matrix("camera_matrix", 3, 3, m),
            matrix("distortion_coefficients", 1, self.distortion.len(), &self.distortion),
            matrix("rectification_matrix", 3, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
            matrix("projection_matrix", 3, 4, &projection),
        )
    }
}

/// The shortest numbers that are read again to the last bit.
fn listed(data: &[f64]) -> String {
    data.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ")
}
