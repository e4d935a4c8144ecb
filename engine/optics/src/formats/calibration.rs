//! Files of camera calibrations: which cameras are in them, and calibrations written as OpenCV, ROS and COLMAP have them.
//!
//! Programs differ in where pixels are counted from; a [`Calibration`] counts from the corner of the first pixel, and
//! readers and writers convert.

mod chains;
mod colmap;
mod nuke;
mod opencv;
mod problem;
#[cfg(test)]
mod tests;
mod tree;
mod write;

use crate::calibration::{Calibration, Model};
use crate::prescription::Place;
use petzval_files::one_line;
use problem::Placed;
use std::path::Path;

pub use problem::{CalibrationFileError, CalibrationProblem};
pub use write::{CalibrationWriteError, write};

/// Longer files are no calibrations.
const LARGEST_FILE: u64 = 8 << 20;

/// The formats of calibrations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenCV's `FileStorage` as YAML.
    OpenCvYaml,
    /// OpenCV's `FileStorage` as JSON.
    OpenCvJson,
    /// ROS's `camera_info` as YAML.
    Ros,
    /// COLMAP's `cameras.txt`.
    Colmap,
    /// Kalibr's camchain, or the EuRoC data set's `sensor.yaml`.
    Kalibr,
    /// Basalt's `calibration.json`.
    Basalt,
    /// A rig of NVIDIA's DriveWorks.
    NvidiaRig,
    /// A script of Nuke with 3DEqualizer's nodes.
    Nuke,
}

impl Format {
    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenCvYaml => "OpenCV's YAML",
            Self::OpenCvJson => "OpenCV's JSON",
            Self::Ros => "ROS's YAML",
            Self::Colmap => "COLMAP's cameras.txt",
            Self::Kalibr => "Kalibr's camchain",
            Self::Basalt => "Basalt's JSON",
            Self::NvidiaRig => "NVIDIA's rig",
            Self::Nuke => "3DEqualizer's nodes for Nuke",
        }
    }
}

/// A camera of a file.
#[derive(Clone, Debug)]
pub struct CalibratedCamera {
    /// The name or number in the file; "camera" where it has none.
    pub name: String,
    /// The numbers.
    pub calibration: Calibration,
}

/// A file of calibrations.
#[derive(Clone, Debug)]
pub struct CalibrationFile {
    /// The file, as it was named.
    pub file: String,
    /// The format.
    pub format: Format,
    /// The cameras, at least one.
    pub cameras: Vec<CalibratedCamera>,
    /// The parts of the file that were left out, a line each.
    pub remarks: Vec<String>,
}

impl CalibrationFile {
    /// The camera of a name; `None` is the only one.
    ///
    /// # Errors
    /// There is none of that name, or there are several and none is named.
    pub fn camera(&self, name: Option<&str>) -> Result<&CalibratedCamera, CalibrationFileError> {
        let there = || names(&self.cameras);
        let problem = match (name, self.cameras.as_slice()) {
            (None, [only]) => return Ok(only),
            (None, several) => CalibrationProblem::Several { count: several.len(), there: there() },
            (Some(asked), all) => match all.iter().find(|camera| camera.name == asked) {
                Some(camera) => return Ok(camera),
                None => CalibrationProblem::NoSuchCamera { asked: asked.to_owned(), there: there() },
            },
        };
        Err(CalibrationFileError { file: self.file.clone(), place: Place { line: 1, column: 1 }, problem })
    }
}

/// Names of cameras for a message.
fn names(cameras: &[CalibratedCamera]) -> String {
    let some: Vec<&str> = cameras.iter().take(20).map(|camera| camera.name.as_str()).collect();
    let more = if cameras.len() > some.len() { ", ..." } else { "" };
    format!("{}{more}", some.join(", "))
}

/// The cameras of a file of any of the formats; the file's content says which.
///
/// # Errors
/// The first error, with its place.
pub fn read(path: &Path) -> Result<CalibrationFile, CalibrationFileError> {
    let file = path.display().to_string();
    let error = |problem| CalibrationFileError { file: file.clone(), place: Place { line: 1, column: 1 }, problem };
    let bytes = petzval_files::read_bounded(path, LARGEST_FILE)
        .map_err(|failed| error(CalibrationProblem::Unreadable(failed.to_string())))?;
    let text = String::from_utf8(bytes).map_err(|_| error(CalibrationProblem::NotText))?;
    parse(&text, &file)
}

/// The cameras of a text; `file` is its name in errors.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, file: &str) -> Result<CalibrationFile, CalibrationFileError> {
    let found = cameras(text.trim_start_matches('\u{feff}'));
    let (format, cameras, remarks) =
        found.map_err(|(place, problem)| CalibrationFileError { file: file.to_owned(), place, problem })?;
    if cameras.is_empty() {
        let place = Place { line: 1, column: 1 };
        return Err(CalibrationFileError { file: file.to_owned(), place, problem: CalibrationProblem::NoCamera });
    }
    Ok(CalibrationFile { file: file.to_owned(), format, cameras, remarks })
}

type Found = (Format, Vec<CalibratedCamera>, Vec<String>);

fn cameras(text: &str) -> Result<Found, Placed> {
    if nuke::is_script(text) {
        return Ok((Format::Nuke, nuke::cameras(text)?, Vec::new()));
    }
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    if first.is_some_and(colmap::is_camera) {
        return Ok((Format::Colmap, colmap::cameras(text)?, Vec::new()));
    }
    let root = tree::parse(text)?;
    if root.get("value0").is_some_and(|value| value.get("intrinsics").is_some()) {
        let (cameras, remarks) = chains::basalt(&root)?;
        return Ok((Format::Basalt, cameras, remarks));
    }
    if root.get("rig").is_some() {
        let (cameras, remarks) = chains::rig(&root)?;
        return Ok((Format::NvidiaRig, cameras, remarks));
    }
    if chains::is_kalibr(&root) {
        return Ok((Format::Kalibr, vec![chains::kalibr("camera", &root)?], Vec::new()));
    }
    let chain: Result<Vec<_>, _> = root
        .entries()
        .iter()
        .filter(|(_, node)| chains::is_kalibr(node))
        .map(|(name, node)| chains::kalibr(name, node))
        .collect();
    let chain = chain?;
    if !chain.is_empty() {
        return Ok((Format::Kalibr, chain, Vec::new()));
    }
    let (cameras, remarks) = opencv::cameras(&root)?;
    let format = match (root.get("distortion_model"), text.trim_start().starts_with('{')) {
        (_, true) => Format::OpenCvJson,
        (Some(_), false) => Format::Ros,
        (None, false) => Format::OpenCvYaml,
    };
    Ok((format, cameras, remarks))
}

/// A camera whose numbers are checked; `place` is theirs in the file.
fn made(
    name: &str,
    model: Model,
    size_px: [u32; 2],
    parameters: &[f64],
    place: Place,
) -> Result<CalibratedCamera, Placed> {
    let name = one_line(name);
    match Calibration::new(model, size_px, parameters) {
        Ok(calibration) => Ok(CalibratedCamera { name, calibration }),
        Err(problem) => Err((place, CalibrationProblem::Calibration { camera: name, problem })),
    }
}
