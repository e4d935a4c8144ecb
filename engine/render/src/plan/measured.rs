//! The measure of each effect in this picture, and its text.

use super::motion::SceneMotion;
use super::words::{size, worst};
use super::{Effect, GhostLook, Unit};
use crate::camera::CameraDescription;
use crate::camera::survey::{LensMeasures, Survey, Worst};

/// The data on which decisions are based.
pub(super) struct Known<'a> {
    pub(super) d: &'a CameraDescription,
    pub(super) survey: &'a Survey,
    pub(super) lens: LensMeasures,
    /// The motion by changes of the lens; `None` where it stands still.
    pub(super) motion: Option<Worst>,
    /// The motion of the scene or the camera; `None` where neither moves.
    pub(super) scene_motion: Option<SceneMotion>,
    /// Ghosts of the brightest sources.
    pub(super) ghosts: Option<GhostLook>,
    /// Irradiance on the front over that of a world as bright as the picture all over; `None` of a black picture.
    pub(super) front_light: Option<f64>,
    /// The part of the light that the lens scatters.
    pub(super) glare: f64,
    /// Distance from the edge of the brightest source up to which diffraction's light is seen, px.
    pub(super) seen_px: f64,
    /// Number of pixels of the picture.
    pub(super) pixels: f64,
    /// True if light paths end in a lens that is traced.
    pub(super) needs_lens: bool,
}

/// The size of an effect, and its description.
pub(super) struct Measured {
    /// The measure, as [`super::Decision::measure`].
    pub(super) value: Option<f64>,
    /// The size, in words.
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
            let (info, changed) = (survey.info(), worst(lens.transmission, effect));
            let coat = match info.coatings.as_slice() {
                [] => String::new(),
                [one] if one == "none" => "uncoated, ".to_owned(),
                names if info.coating_is_assumed => format!("coated with {} (assumed), ", names.join(", ")),
                names => format!("coated with {}, ", names.join(", ")),
            };
            let exposed = if known.d.exposes_by_f_number { "by its f-number" } else { "for that" };
            let passed = 100.0 * lens.luminous;
            let text =
                format!("{coat}it lets {passed:.0} % through and, exposed {exposed}, changes colours by {changed}");
            Measured { value: Some(lens.transmission.value), text }
        }
        Effect::Ghosts => match &known.ghosts {
            Some(ghosts) => Measured {
                value: Some(ghosts.value),
                text: format!("the brightest is {}", size(ghosts.value, Unit::Exposure)),
            },
            None => Measured { value: Some(0.0), text: "no bright source before the lens".to_owned() },
        },
        Effect::Glare => match known.front_light {
            Some(light) => {
                let value = known.glare * light;
                let (what, part) = (size(value, Unit::Exposure), 100.0 * known.glare);
                Measured {
                    value: Some(value),
                    text: format!("{part:.2} % of the light is scattered: a veil of {what}"),
                }
            }
            None => Measured { value: None, text: "the picture is black: not measured".to_owned() },
        },
        Effect::Diffraction if known.seen_px > lens.airy_px => Measured {
            value: Some(known.seen_px),
            text: format!("the brightest source is seen {} around itself", size(known.seen_px, Unit::Pixels)),
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
