//! 3DEqualizer's lens distortion nodes in scripts of Nuke, as 3DEqualizer exports them (Science-D-Visions, Lens Distortion Plugin Kit,
//! `nuke_ld_3de4_base.h`).

use super::problem::{CalibrationProblem, Placed, malformed, unsupported};
use super::tree::number;
use super::{CalibratedCamera, made};
use crate::calibration::Model;
use crate::formats::text::tokens;
use crate::prescription::Place;

/// The prefix of all names of 3DEqualizer's nodes.
const ANY: &str = "LD_3DE";
const RADIAL: &str = "LD_3DE4_Radial_Standard_Degree_4";
const ANAMORPHIC: &str = "LD_3DE4_Anamorphic_Standard_Degree_4";
/// A picture's width where the script has none: any picture of the film back's shape is taken with it.
const WIDTH_PX: f64 = 10_000.0;

const FILM: [&str; 5] = [
    "tde4_focal_length_cm",
    "tde4_filmback_width_cm",
    "tde4_filmback_height_cm",
    "tde4_lens_center_offset_x_cm",
    "tde4_lens_center_offset_y_cm",
];
const OF_RADIAL: [&str; 8] = [
    "Distortion_Degree_2",
    "U_Degree_2",
    "V_Degree_2",
    "Quartic_Distortion_Degree_4",
    "U_Degree_4",
    "V_Degree_4",
    "Phi_Cylindric_Direction",
    "B_Cylindric_Bending",
];
const OF_ANAMORPHIC: [&str; 13] = [
    "Cx02_Degree_2",
    "Cy02_Degree_2",
    "Cx22_Degree_2",
    "Cy22_Degree_2",
    "Cx04_Degree_4",
    "Cy04_Degree_4",
    "Cx24_Degree_4",
    "Cy24_Degree_4",
    "Cx44_Degree_4",
    "Cy44_Degree_4",
    "Lens_Rotation",
    "Squeeze_X",
    "Squeeze_Y",
];

/// True of a script with a node of 3DEqualizer's.
pub(super) fn is_script(text: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with(ANY))
}

/// A node while it is read: its class, its place, and its knobs with theirs.
struct Script<'a> {
    class: &'a str,
    place: Place,
    knobs: Vec<(&'a str, &'a str, Place)>,
}

pub(super) fn cameras(text: &str) -> Result<Vec<CalibratedCamera>, Placed> {
    let mut found = Vec::new();
    let mut size = None;
    let mut node: Option<Script<'_>> = None;
    let mut last = Place { line: 1, column: 1 };
    for (i, line) in text.lines().enumerate() {
        let words = tokens(line);
        let Some(first) = words.first() else { continue };
        let place = Place { line: i + 1, column: first.column };
        last = place;
        match (&mut node, words.as_slice()) {
            (None, [class, brace]) if class.text.starts_with(ANY) && brace.text == "{" => {
                node = Some(Script { class: class.text, place, knobs: Vec::new() });
            }
            // Root's format: width, height, ...
            (None, [knob, rest @ ..]) if knob.text == "format" && rest.len() >= 2 => {
                let side = |i: usize| rest[i].text.trim_matches('"').parse::<u32>().ok();
                size = side(0).zip(side(1)).map(|(width, height)| [width, height]);
            }
            (Some(_), [brace]) if brace.text == "}" => {
                if let Some(done) = node.take() {
                    found.push(camera(&done, size)?);
                }
            }
            (Some(node), [knob, value, ..]) => node.knobs.push((
                knob.text,
                value.text.trim_matches(['"', '{', '}']),
                Place { line: i + 1, column: value.column },
            )),
            _ => {}
        }
    }
    match node {
        Some(node) => Err((last, CalibrationProblem::Syntax(format!("{} has no end", node.class)))),
        None => Ok(found),
    }
}

fn camera(node: &Script<'_>, size: Option<[u32; 2]>) -> Result<CalibratedCamera, Placed> {
    let knob = |name: &str| node.knobs.iter().find(|(known, ..)| *known == name);
    let name = knob("name").map_or(node.class, |(_, name, _)| name);
    let or = |name: &str, default: f64| match knob(name) {
        None => Ok(default),
        Some((_, text, place)) => number(text).ok_or_else(|| malformed(*place, text, "a number, without animation")),
    };
    for (edge, whole) in [("xa", 0.0), ("ya", 0.0), ("xb", 1.0), ("yb", 1.0)] {
        let edge = format!("field_of_view_{edge}_unit");
        if or(&edge, whole)? != whole {
            let place = knob(&edge).map_or(node.place, |(.., place)| *place);
            return Err(unsupported(
                place,
                format!("{edge} is not {whole}: only the whole film back can be the picture"),
            ));
        }
    }
    let mut p = Vec::new();
    for name in FILM {
        let missing = CalibrationProblem::Missing { camera: format!("node '{}'", node.class), what: name };
        let default = if name.contains("offset") { 0.0 } else { f64::NAN };
        let value = or(name, default)?;
        if value.is_nan() {
            return Err((node.place, missing));
        }
        p.push(value);
    }
    let aspect = or("tde4_pixel_aspect", 1.0)?;
    let (model, knobs): (Model, &[&str]) = match node.class {
        RADIAL => (Model::TdeRadial, &OF_RADIAL),
        ANAMORPHIC => (Model::TdeAnamorphic, &OF_ANAMORPHIC),
        other => {
            let what = format!("the model {other} is not known; export {RADIAL} or {ANAMORPHIC}, or an ST map");
            return Err(unsupported(node.place, what));
        }
    };
    if model == Model::TdeAnamorphic {
        p.push(aspect);
    }
    for name in knobs {
        p.push(or(name, if name.starts_with("Squeeze") { 1.0 } else { 0.0 })?);
    }
    let height_px = (WIDTH_PX * p[2] / p[1] * aspect).round();
    let is_picture = p[1] > 0.0 && p[2] > 0.0 && (1.0..=1e6).contains(&height_px);
    let size = match size {
        Some(size) => size,
        None if is_picture => [WIDTH_PX as u32, height_px as u32],
        // What is wrong with the film back is said by the check of its numbers.
        None => [1, 1],
    };
    made(name, model, size, &p, node.place)
}
