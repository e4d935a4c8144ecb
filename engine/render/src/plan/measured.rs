//! How large each effect is in this picture, and what is said of it.

use super::motion::SceneMotion;
use super::words::{size, worst};
use super::{Effect, Unit};
use crate::camera::CameraDescription;
use crate::camera::survey::{LensMeasures, Survey, Worst};

/// Veiling glare index: in a world that is as bright everywhere, the part of the picture's light that comes from elsewhere than
/// it should (ISO 9358, integral method). Of photographic lenses it is about one per cent; that of this one is not known.
const GLARE_INDEX: f64 = 0.01;

/// What is known when it is decided.
pub(super) struct Known<'a> {
    pub(super) d: &'a CameraDescription,
    pub(super) survey: &'a Survey,
    pub(super) lens: LensMeasures,
    /// `None` where the lens stands still.
    pub(super) motion: Option<Worst>,
    /// `None` where nothing else moves either.
    pub(super) scene_motion: Option<SceneMotion>,
    /// Ghosts of the brightest source, as a part of the exposure.
    pub(super) ghosts: Option<f64>,
    /// Irradiance on the front over that of a world as bright as the picture all over; `None` of a black picture.
    pub(super) front_light: Option<f64>,
    /// Light paths end in a lens that is traced.
    pub(super) needs_lens: bool,
}

/// An effect's size, and what is said of it.
pub(super) struct Measured {
    /// As [`super::Decision::measure`].
    pub(super) value: Option<f64>,
    /// The size and what goes with it.
    pub(super) text: String,
}

/// The size of an effect in this picture.
pub(super) fn measure(known: &Known<'_>, effect: Effect) -> Measured {
    let Known { survey, lens, .. } = known;
    let of = |one: Worst| Measured { value: Some(one.value), text: worst(one, effect) };
    match effect {
        Effect::Defocus => of(lens.defocus),
        Effect::Aberration => of(lens.aberration),
        Effect::Distortion => of(lens.distortion),
        Effect::LateralColour | Effect::AxialColour if !survey.has_colours() => {
            let text = match known.d.wavelength_nm {
                Some(nm) => format!("the camera photographs at {nm:.0} nm alone"),
                None => "nothing in the lens disperses".to_owned(),
            };
            Measured { value: Some(0.0), text }
        }
        Effect::LateralColour => of(lens.lateral_colour),
        Effect::AxialColour => of(lens.axial_colour),
        Effect::Vignetting => {
            let cut = match lens.cats_eye.value {
                v if v >= 0.1 => format!(", rims narrow blur by {}", size(v, Unit::Pixels)),
                _ => String::new(),
            };
            let one = of(lens.vignetting);
            Measured { text: one.text + &cut, ..one }
        }
        Effect::Diaphragm if lens.diaphragm_part == 0.0 => {
            Measured { value: Some(0.0), text: "the opening is round".to_owned() }
        }
        Effect::Diaphragm => {
            let value = lens.diaphragm_part * (lens.defocus.value + lens.aberration.value);
            Measured { value: Some(value), text: size(value, Unit::Pixels) }
        }
        Effect::MotionBlur => match (known.motion, &known.scene_motion) {
            (Some(lens), None) => of(lens),
            (Some(lens), Some(motion)) if lens.value > motion.px => of(lens),
            (_, Some(SceneMotion { px, text })) => Measured { value: Some(*px), text: text.clone() },
            (None, None) => Measured { value: Some(0.0), text: "everything stands still".to_owned() },
        },
        Effect::Transmission => {
            let value = lens.tint_stops.abs();
            let colour = if lens.tint_stops > 0.0 { "blue" } else { "red" };
            Measured {
                value: Some(value),
                text: format!("uncoated, it would take {} more of {colour}", size(value, Unit::Stops)),
            }
        }
        Effect::Ghosts => match known.ghosts {
            Some(value) => Measured {
                value: Some(value),
                text: format!("uncoated, the brightest is {}", size(value, Unit::Exposure)),
            },
            None => Measured { value: Some(0.0), text: "no bright source in the field or near it".to_owned() },
        },
        Effect::Glare => match known.front_light {
            Some(light) => {
                let value = GLARE_INDEX * light;
                let what = size(value, Unit::Exposure);
                Measured { value: Some(value), text: format!("a lens that scatters 1 % would lay a veil of {what}") }
            }
            None => Measured { value: None, text: "the picture is black: not measured".to_owned() },
        },
        Effect::Diffraction => Measured {
            value: Some(lens.airy_px),
            text: format!("the first dark ring is {} wide", size(lens.airy_px, Unit::Pixels)),
        },
        Effect::SpectralMaterials => {
            Measured { value: Some(0.0), text: "all of the scene is described in three colours".to_owned() }
        }
    }
}
