//! COLMAP's `cameras.txt`: `ID MODEL WIDTH HEIGHT PARAMETERS`, a camera a line, `#` before remarks. It counts pixels from the corner of the first.
//!
//! COLMAP, `src/colmap/sensor/models.h`: the models and the order of their parameters.

use super::problem::{CalibrationProblem, Placed, malformed};
use super::tree::number;
use super::{CalibratedCamera, made};
use crate::calibration::{Calibration, Model};
use crate::formats::text::{Token, tokens};
use crate::prescription::Place;

/// COLMAP's models: its name, ours, and ours' parameters that it has, in its order; `f` stands for both focal lengths. From the one with
/// the fewest parameters on.
const MODELS: [(&str, Model, &[&str]); 19] = [
    ("SIMPLE_PINHOLE", Model::OpenCv, &["f", "cx", "cy"]),
    ("PINHOLE", Model::OpenCv, &["fx", "fy", "cx", "cy"]),
    ("SIMPLE_RADIAL", Model::OpenCv, &["f", "cx", "cy", "k1"]),
    ("RADIAL", Model::OpenCv, &["f", "cx", "cy", "k1", "k2"]),
    ("OPENCV", Model::OpenCv, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]),
    ("FULL_OPENCV", Model::OpenCv, &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
    ("SIMPLE_FISHEYE", Model::Fisheye, &["f", "cx", "cy"]),
    ("FISHEYE", Model::Fisheye, &["fx", "fy", "cx", "cy"]),
    ("SIMPLE_RADIAL_FISHEYE", Model::Fisheye, &["f", "cx", "cy", "k1"]),
    ("RADIAL_FISHEYE", Model::Fisheye, &["f", "cx", "cy", "k1", "k2"]),
    ("OPENCV_FISHEYE", Model::Fisheye, &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"]),
    (
        "THIN_PRISM_FISHEYE",
        Model::ThinPrismFisheye,
        &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "sx1", "sy1"],
    ),
    (
        "RAD_TAN_THIN_PRISM_FISHEYE",
        Model::RadTanThinPrismFisheye,
        &["fx", "fy", "cx", "cy", "k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1", "s2", "s3"],
    ),
    ("FOV", Model::Fov, &["fx", "fy", "cx", "cy", "omega"]),
    ("SIMPLE_DIVISION", Model::Division, &["f", "cx", "cy", "k"]),
    ("DIVISION", Model::Division, &["fx", "fy", "cx", "cy", "k"]),
    ("EUCM", Model::Eucm, &["fx", "fy", "cx", "cy", "alpha", "beta"]),
    // By an older name, which some programs write.
    ("PERSPECTIVE", Model::OpenCv, &["fx", "fy", "cx", "cy"]),
    ("EQUIRECTANGULAR", Model::Equirectangular, &["w", "h"]),
];

/// True of a line that is a camera's.
pub(super) fn is_camera(line: &str) -> bool {
    let words: Vec<&str> = line.split_whitespace().take(4).collect();
    let is_word =
        |word: &str| word.chars().all(|c| c.is_ascii_uppercase() || c == '_') && word.contains(char::is_alphabetic);
    words.len() == 4 && words[0].parse::<u64>().is_ok() && is_word(words[1])
}

pub(super) fn cameras(text: &str) -> Result<Vec<CalibratedCamera>, Placed> {
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line);
        if words.first().is_none_or(|word| word.text.starts_with('#')) {
            continue;
        }
        found.push(camera(&words, i + 1)?);
    }
    Ok(found)
}

fn camera(words: &[Token<'_>], line: usize) -> Result<CalibratedCamera, Placed> {
    let end = words.last().map_or(1, |word| word.column + word.text.chars().count());
    let at = |i: usize| Place { line, column: words.get(i).map_or(end, |word| word.column) };
    let [id, name, width, height, numbers @ ..] = words else {
        return Err(malformed(at(0), words[0].text, "ID MODEL WIDTH HEIGHT PARAMETERS"));
    };
    let Some((_, model, names)) = MODELS.iter().find(|(known, ..)| *known == name.text) else {
        let known = MODELS.map(|(known, ..)| known).join(", ");
        return Err(malformed(at(1), name.text, format!("a model of COLMAP, one of {known},")));
    };
    let side = |word: &Token<'_>, i: usize| {
        let count = word.text.parse::<u32>().ok().filter(|side| (1..=1_000_000).contains(side));
        count.ok_or_else(|| malformed(at(i), word.text, "a number of pixels"))
    };
    let size = [side(width, 2)?, side(height, 3)?];
    if numbers.len() != names.len() {
        let expected = format!("{} of {} ({})", names.len(), name.text, names.join(" "));
        return Err((
            at(4 + names.len().min(numbers.len())),
            CalibrationProblem::Count { found: numbers.len(), expected },
        ));
    }
    let mut p = vec![0.0; model.parameter_names().len()];
    if let Some(beta) = place_of(*model, "beta") {
        p[beta] = 1.0;
    }
    for (i, (word, name)) in numbers.iter().zip(*names).enumerate() {
        let value = number(word.text).ok_or_else(|| malformed(at(4 + i), word.text, "a number"))?;
        match *name {
            "f" => p[..2].fill(value),
            "w" | "h" => {
                let side = size[usize::from(*name == "h")];
                if value != f64::from(side) {
                    return Err(malformed(at(4 + i), word.text, "the picture's own size"));
                }
            }
            _ => p[place_of(*model, name).ok_or_else(|| malformed(at(1), name, "a parameter"))?] = value,
        }
    }
    made(id.text, *model, size, &p, at(1))
}

fn place_of(model: Model, name: &str) -> Option<usize> {
    model.parameter_names().iter().position(|known| *known == name)
}

/// A camera's line; `None`: COLMAP has no model that is the same.
pub(super) fn line(id: usize, camera: &Calibration) -> Option<String> {
    let value = |name: &str| camera.parameter(name).unwrap_or_default();
    let [width, height] = camera.size_px();
    let holds = |names: &[&str]| {
        let is_zero = |name: &&str| names.contains(name) || camera.parameter(name) == Some(0.0);
        let same_focal = !names.contains(&"f") || value("fx") == value("fy");
        let unnamed = |name: &&&str| !(names.contains(&"f") && (**name == "fx" || **name == "fy"));
        same_focal && camera.model().parameter_names().iter().filter(unnamed).all(is_zero)
    };
    let (name, _, names) = MODELS.iter().find(|(_, model, names)| *model == camera.model() && holds(names))?;
    let number = |name: &&str| match *name {
        "f" => value("fx"),
        "w" => f64::from(width),
        "h" => f64::from(height),
        other => value(other),
    };
    let numbers: Vec<String> = names.iter().map(|name| number(name).to_string()).collect();
    Some(format!("{id} {name} {width} {height} {}", numbers.join(" ")))
}
