//! Calibrations of OpenCV and ROS, in YAML and JSON.
//!
//! OpenCV's programs write no format but matrices under keys of their own (`FileStorage`): those of its samples and tutorials are known here.
//! ROS writes `camera_info` with `distortion_model`. Both count pixels from the middle of the first.

use super::problem::{CalibrationProblem, Placed, malformed, unsupported};
use super::tree::Node;
use super::{CalibratedCamera, made};
use crate::calibration::Model;

/// The distance from the middle of the first pixel to its corner, pixels.
pub(super) const HALF_PIXEL: f64 = 0.5;

const MATRIX: &[&str] =
    &["camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "CameraMatrix", "K", "k", "M"];
const DISTORTION: &[&str] = &[
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distortion_coeffs",
    "distCoeffs",
    "dist_coeffs",
    "dist_coeff",
    "distortion",
    "DistCoeffs",
    "D",
    "d",
];
const MODEL: &[&str] = &["distortion_model", "camera_model", "model", "fisheye_model"];
const WIDTH: &[&str] = &["image_width", "image_Width", "imageWidth", "width"];
const HEIGHT: &[&str] = &["image_height", "image_Height", "imageHeight", "height"];
const SIZE: &[&str] = &["image_size", "imageSize", "resolution", "img_size", "size"];
/// Keys that do not change where things are seen.
const PASSED_OVER: &[&str] = &[
    "camera_name",
    "name",
    "calibration_time",
    "nframes",
    "nr_of_frames",
    "board_width",
    "board_height",
    "square_size",
    "marker_size",
    "aspectRatio",
    "fix_aspect_ratio",
    "fixAspectRatio",
    "flags",
    "avg_reprojection_error",
    "Avg_Reprojection_Error",
    "avg_reprojection_err",
    "per_view_reprojection_errors",
    "extrinsic_parameters",
    "image_points",
    "grid_points",
    "header",
    "frame_id",
    "rectification_matrix",
    "projection_matrix",
    "R",
    "P",
    "r",
    "p",
    "seq",
];

/// True of a mapping that has a camera's matrix.
fn is_camera(node: &Node, suffix: &str) -> bool {
    MATRIX.iter().any(|key| node.get(&format!("{key}{suffix}")).is_some())
}

/// The cameras of a document, and remarks; none if there is no camera's matrix in it.
pub(super) fn cameras(root: &Node) -> Result<(Vec<CalibratedCamera>, Vec<String>), Placed> {
    let (mut found, mut remarks) = (Vec::new(), Vec::new());
    if is_camera(root, "") {
        let name = root.any(&["camera_name", "name"]).and_then(Node::text).unwrap_or("camera");
        found.push(camera(root, root, "", name)?);
        remarks.extend(without_distortion(root, root, "", name));
        remarks.extend(left_out(root));
    }
    for suffix in ["1", "2", "3", "4"] {
        if is_camera(root, suffix) {
            found.push(camera(root, root, suffix, suffix)?);
            remarks.extend(without_distortion(root, root, suffix, suffix));
        }
    }
    for (name, inner) in root.entries() {
        if is_camera(inner, "") {
            found.push(camera(inner, root, "", name)?);
            remarks.extend(without_distortion(inner, root, "", name));
        }
    }
    Ok((found, remarks))
}

fn left_out(root: &Node) -> Vec<String> {
    let known = [MATRIX, DISTORTION, MODEL, WIDTH, HEIGHT, SIZE, PASSED_OVER].concat();
    let parts = ["binning_x", "binning_y", "roi"];
    let is_unknown = |key: &str| !known.contains(&key) && !parts.contains(&key);
    let unknown = root.entries().iter().filter(|(key, _)| is_unknown(key));
    unknown.take(20).map(|(key, node)| format!("line {}: {key:?} is left out", node.place.line)).collect()
}

/// The remark on a camera whose distortion does not stand in the file: nothing tells a pinhole from a file that is broken off there.
fn without_distortion(node: &Node, root: &Node, suffix: &str, name: &str) -> Option<String> {
    let has = |node: &Node, suffix: &str| DISTORTION.iter().any(|key| node.get(&format!("{key}{suffix}")).is_some());
    let is_there = has(node, suffix) || has(node, "") || has(root, "");
    (!is_there).then(|| format!("camera '{name}' has no distortion coefficients: it is taken for a pinhole"))
}

/// A camera of the keys of `node` with a suffix; keys of all cameras stand in `root`.
fn camera(node: &Node, root: &Node, suffix: &str, name: &str) -> Result<CalibratedCamera, Placed> {
    let any = |keys: &[&str]| {
        let own = keys.iter().find_map(|key| node.get(&format!("{key}{suffix}")));
        own.or_else(|| node.any(keys)).or_else(|| root.any(keys))
    };
    let missing = |what| (node.place, CalibrationProblem::Missing { camera: format!("camera '{name}'"), what });
    let matrix_node = any(MATRIX).ok_or_else(|| missing("camera_matrix"))?;
    let k = matrix_node.counted(&[9])?;
    let is_upper = k[3] == 0.0 && k[6] == 0.0 && k[7] == 0.0 && k[8] == 1.0;
    if !is_upper {
        return Err(unsupported(
            matrix_node.place,
            "the camera matrix is not [fx s cx; 0 fy cy; 0 0 1]; give it row by row, scaled to end in 1",
        ));
    }
    whole_picture(node)?;
    let size = match (any(WIDTH), any(HEIGHT), any(SIZE)) {
        (Some(width), Some(height), _) => [width.pixels()?, height.pixels()?],
        (_, _, Some(size)) if size.items().len() == 2 => [size.items()[0].pixels()?, size.items()[1].pixels()?],
        _ => return Err(missing("size of its picture (image_width and image_height)")),
    };
    let d = match any(DISTORTION) {
        Some(node) => node.numbers()?,
        None => Vec::new(),
    };
    let d_place = any(DISTORTION).map_or(node.place, |node| node.place);
    let centre = [k[2] + HALF_PIXEL, k[5] + HALF_PIXEL];
    let (model, skew) = (any(MODEL), k[1]);
    if is_fisheye(model, &d)? {
        let mut p = vec![k[0], k[4], centre[0], centre[1]];
        if !d.is_empty() && d.len() != 4 {
            return Err((d_place, CalibrationProblem::Count { found: d.len(), expected: "4 of a fisheye".to_owned() }));
        }
        p.extend(if d.is_empty() { vec![0.0; 4] } else { d });
        p.push(skew / k[0]);
        return made(name, Model::Fisheye, size, &p, matrix_node.place);
    }
    if skew != 0.0 {
        return Err(unsupported(
            matrix_node.place,
            format!("the camera matrix has a skew of {skew}, which OpenCV leaves out of pictures; set it to 0"),
        ));
    }
    if ![0, 4, 5, 8, 12, 14].contains(&d.len()) {
        let expected = "one of 0, 4, 5, 8, 12 or 14".to_owned();
        return Err((d_place, CalibrationProblem::Count { found: d.len(), expected }));
    }
    let mut p = vec![k[0], k[4], centre[0], centre[1]];
    p.extend(d);
    p.resize(Model::OpenCv.parameter_names().len(), 0.0);
    made(name, Model::OpenCv, size, &p, matrix_node.place)
}

/// Refuses pictures of which ROS sends a part, or fewer pixels than were calibrated.
fn whole_picture(node: &Node) -> Result<(), Placed> {
    for key in ["binning_x", "binning_y"] {
        if let Some(binning) = node.get(key)
            && binning.number()? > 1.0
        {
            return Err(unsupported(binning.place, format!("{key} is {}: calibrate without binning", binning.shown())));
        }
    }
    if let Some(roi) = node.get("roi") {
        for key in ["x_offset", "y_offset"] {
            if let Some(offset) = roi.get(key)
                && offset.number()? != 0.0
            {
                return Err(unsupported(offset.place, "the region of interest is a part: give the whole picture's"));
            }
        }
    }
    Ok(())
}

fn is_fisheye(model: Option<&Node>, d: &[f64]) -> Result<bool, Placed> {
    let Some(node) = model else { return Ok(false) };
    match node.text().unwrap_or_default().to_lowercase().as_str() {
        "plumb_bob"
        | "radtan"
        | "rational_polynomial"
        | "thin_prism"
        | "pinhole"
        | "perspective"
        | "opencv"
        | "brown_conrady"
        | "0"
        | "false" => Ok(false),
        "equidistant" | "fisheye" | "kannala_brandt" | "kannala_brandt4" | "opencv_fisheye" | "1" | "true" => Ok(true),
        // As ROS's drivers of ideal cameras have it.
        "" | "none" if d.iter().all(|d| *d == 0.0) => Ok(false),
        _ => Err(malformed(node.place, node.shown(), "plumb_bob, rational_polynomial or equidistant")),
    }
}
