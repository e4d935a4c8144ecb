//! Calibrations of Kalibr (camchain YAML, and the EuRoC data set's `sensor.yaml`), Basalt (JSON) and NVIDIA's rigs (JSON). All count
//! pixels from the middle of the first.

use super::opencv::HALF_PIXEL;
use super::problem::{CalibrationProblem, Placed, malformed, unsupported};
use super::tree::Node;
use super::{CalibratedCamera, made};
use crate::calibration::Model;

fn needed<'a>(node: &'a Node, keys: &[&'static str], camera: &str) -> Result<&'a Node, Placed> {
    let missing = CalibrationProblem::Missing { camera: format!("camera '{camera}'"), what: keys[0] };
    node.any(keys).ok_or((node.place, missing))
}

fn resolution(node: &Node) -> Result<[u32; 2], Placed> {
    match node.items() {
        [width, height] => Ok([width.pixels()?, height.pixels()?]),
        _ => Err(malformed(node.place, node.shown(), "[width, height]")),
    }
}

/// Focal lengths and principal point as numbers stand there, the latter from the corner.
fn pinhole(numbers: &[f64]) -> Vec<f64> {
    vec![numbers[0], numbers[1], numbers[2] + HALF_PIXEL, numbers[3] + HALF_PIXEL]
}

/// True of a mapping that Kalibr made.
pub(super) fn is_kalibr(node: &Node) -> bool {
    node.get("camera_model").is_some() && node.get("intrinsics").is_some()
}

/// The distortion of a camera of Kalibr.
struct KalibrDistortion<'a> {
    /// The name; "none" where there is none.
    kind: &'a str,
    coefficients: Vec<f64>,
    /// The name's node, or the camera's.
    named: &'a Node,
    /// The coefficients' node, or the camera's.
    listed: &'a Node,
}

impl<'a> KalibrDistortion<'a> {
    fn of(camera: &'a Node) -> Result<Self, Placed> {
        let named = camera.get("distortion_model");
        let listed = camera.any(&["distortion_coeffs", "distortion_coefficients"]);
        let kind = named.and_then(Node::text).unwrap_or("none");
        let coefficients = match listed {
            Some(node) if kind != "none" => node.numbers()?,
            _ => Vec::new(),
        };
        Ok(Self { kind, coefficients, named: named.unwrap_or(camera), listed: listed.unwrap_or(camera) })
    }

    fn is_radial(&self) -> bool {
        matches!(self.kind, "radtan" | "radial-tangential" | "plumb_bob")
    }

    /// The coefficients, of which there must be so many.
    fn counted(&self, count: usize) -> Result<&[f64], Placed> {
        if self.coefficients.len() == count {
            return Ok(&self.coefficients);
        }
        let expected = format!("{count} of {}", self.kind);
        Err((self.listed.place, CalibrationProblem::Count { found: self.coefficients.len(), expected }))
    }

    /// Refuses a distortion for a model that has none.
    fn check_none(&self, model: &Node) -> Result<(), Placed> {
        if self.kind == "none" || self.coefficients.iter().all(|d| *d == 0.0) {
            return Ok(());
        }
        let what = format!("'{}' with the distortion '{}' is no model that is known", model.shown(), self.kind);
        Err(unsupported(self.named.place, what))
    }

    /// The model and the parameters of a pinhole with this distortion.
    fn pinhole(&self, intrinsics: &Node) -> Result<(Model, Vec<f64>), Placed> {
        let mut p = pinhole(&intrinsics.counted(&[4])?);
        let model = match self.kind {
            "none" => Model::OpenCv,
            _ if self.is_radial() => {
                p.extend(self.counted(4)?);
                Model::OpenCv
            }
            "equidistant" | "equi" => {
                p.extend(self.counted(4)?);
                p.push(0.0);
                Model::Fisheye
            }
            "fov" => {
                p.extend(self.counted(1)?);
                Model::Fov
            }
            _ => return Err(malformed(self.named.place, self.kind, "radtan, equidistant, fov or none")),
        };
        p.resize(model.parameter_names().len(), 0.0);
        Ok((model, p))
    }
}

/// A camera of Kalibr (its wiki, "Supported models"; `kalibr_common/ConfigReader.py`).
pub(super) fn kalibr(name: &str, node: &Node) -> Result<CalibratedCamera, Placed> {
    let size = resolution(needed(node, &["resolution"], name)?)?;
    let word = needed(node, &["camera_model"], name)?;
    let numbers = needed(node, &["intrinsics"], name)?;
    let distortion = KalibrDistortion::of(node)?;
    let (model, p) = match word.text().unwrap_or_default() {
        "pinhole" => distortion.pinhole(numbers)?,
        "omni" => {
            let i = numbers.counted(&[5])?;
            let mut p = pinhole(&i[1..]);
            p.push(i[0]);
            if distortion.is_radial() {
                p.extend(distortion.counted(4)?);
            } else {
                distortion.check_none(word)?;
                p.extend([0.0; 4]);
            }
            (Model::Omni, p)
        }
        kind @ ("ds" | "eucm") => {
            let i = numbers.counted(&[6])?;
            distortion.check_none(word)?;
            let mut p = pinhole(&i[2..]);
            p.extend(&i[..2]);
            (if kind == "ds" { Model::DoubleSphere } else { Model::Eucm }, p)
        }
        _ => return Err(malformed(word.place, word.shown(), "pinhole, omni, ds or eucm")),
    };
    made(name, model, size, &p, numbers.place)
}

/// The cameras of Basalt (`basalt-headers`, `calibration/calibration.hpp` and `serialization/headers_serialization.h`), named cam0, cam1, ...
pub(super) fn basalt(root: &Node) -> Result<(Vec<CalibratedCamera>, Vec<String>), Placed> {
    let value = root.get("value0").unwrap_or(root);
    let list = needed(value, &["intrinsics"], "cam0")?;
    let sizes = needed(value, &["resolution"], "cam0")?;
    let mut found = Vec::new();
    for (i, camera) in list.items().iter().enumerate() {
        let name = format!("cam{i}");
        let size = sizes.items().get(i).ok_or_else(|| {
            (sizes.place, CalibrationProblem::Missing { camera: format!("camera '{name}'"), what: "resolution" })
        })?;
        found.push(basalt_camera(&name, camera, resolution(size)?)?);
    }
    let has_vignette = value.get("vignette").is_some_and(|vignette| !vignette.items().is_empty());
    let remark = || {
        "Basalt's vignette is left out: its curve is of the picture's brightness, not of where things are seen"
            .to_owned()
    };
    Ok((found, has_vignette.then(remark).into_iter().collect()))
}

fn basalt_camera(name: &str, camera: &Node, size: [u32; 2]) -> Result<CalibratedCamera, Placed> {
    let kind = needed(camera, &["camera_type"], name)?;
    let inner = needed(camera, &["intrinsics"], name)?;
    let value = |key: &'static str| needed(inner, &[key], name)?.number();
    let mut p = pinhole(&[value("fx")?, value("fy")?, value("cx")?, value("cy")?]);
    let (model, more): (Model, &[&'static str]) = match kind.text().unwrap_or_default() {
        "pinhole" => (Model::OpenCv, &[]),
        "pinhole-radtan8" => (Model::OpenCv, &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
        "kb4" => (Model::Fisheye, &["k1", "k2", "k3", "k4"]),
        "ds" => (Model::DoubleSphere, &["xi", "alpha"]),
        "eucm" => (Model::Eucm, &["alpha", "beta"]),
        "ucm" => (Model::Eucm, &["alpha"]),
        "fov" => (Model::Fov, &["w"]),
        _ => return Err(malformed(kind.place, kind.shown(), "pinhole, pinhole-radtan8, kb4, ds, eucm, ucm or fov")),
    };
    for key in more {
        p.push(value(key)?);
    }
    // The unified model is the enhanced one with beta 1.
    if kind.text() == Some("ucm") {
        p.push(1.0);
    }
    p.resize(model.parameter_names().len(), 0.0);
    made(name, model, size, &p, inner.place)
}

/// The f-theta cameras of a rig of NVIDIA's DriveWorks; remarks name its other sensors.
pub(super) fn rig(root: &Node) -> Result<(Vec<CalibratedCamera>, Vec<String>), Placed> {
    let sensors = root.get("rig").and_then(|rig| rig.get("sensors"));
    let (mut found, mut remarks) = (Vec::new(), Vec::new());
    for sensor in sensors.map_or(&[][..], Node::items) {
        let Some(properties) = sensor.get("properties") else { continue };
        let name = sensor.get("name").and_then(Node::text).unwrap_or("camera");
        match properties.any(&["Model", "model"]).and_then(Node::text) {
            Some("ftheta") => found.push(f_theta(name, properties)?),
            Some(other) => remarks.push(format!("sensor {name:?} is left out: its model is {other:?}, not ftheta")),
            None => {}
        }
    }
    Ok((found, remarks))
}

fn f_theta(name: &str, node: &Node) -> Result<CalibratedCamera, Placed> {
    let size = [needed(node, &["width"], name)?.pixels()?, needed(node, &["height"], name)?.pixels()?];
    let value = |key: &'static str| needed(node, &[key], name)?.number();
    let or = |key: &str, default: f64| node.get(key).map_or(Ok(default), Node::number);
    let polynomial = needed(node, &["polynomial", "bw-poly"], name)?;
    let model = match node.get("polynomial-type") {
        None => Model::FThetaToAngle,
        Some(kind) => match kind.text().unwrap_or_default() {
            "pixeldistance-to-angle" => Model::FThetaToAngle,
            "angle-to-pixeldistance" => Model::FThetaToPixels,
            _ => return Err(malformed(kind.place, kind.shown(), "pixeldistance-to-angle or angle-to-pixeldistance")),
        },
    };
    if let Some((key, value)) = node.entries().iter().find(|(key, _)| key.starts_with("windshield")) {
        return Err(unsupported(value.place, format!("{key}: rays bent by a windshield are not known; take it out")));
    }
    let powers = polynomial.numbers()?;
    let most = model.parameter_names().len() - 5;
    if powers.len() < 2 || powers.len() > most + 1 {
        let expected = format!("2 to {}", most + 1);
        return Err((polynomial.place, CalibrationProblem::Count { found: powers.len(), expected }));
    }
    if powers[0] != 0.0 {
        let what = "the polynomial's first number is not 0: the middle of the picture would be no point; set it to 0";
        return Err(unsupported(polynomial.place, what));
    }
    let mut p = vec![value("cx")? + HALF_PIXEL, value("cy")? + HALF_PIXEL];
    p.extend([or("linear-c", 1.0)?, or("linear-d", 0.0)?, or("linear-e", 0.0)?]);
    p.extend(&powers[1..]);
    p.resize(model.parameter_names().len(), 0.0);
    made(name, model, size, &p, polynomial.place)
}
