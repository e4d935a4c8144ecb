//! Decisions from measures and wishes: the cheapest camera that leaves out nothing that can be seen.

use super::choice::{CameraChoice, CameraKind};
use super::measured::Known;
use super::motion::SceneMotion;
use super::price::{Price, sample_ns, transmission_ns};
use super::words::size;
use super::{Decision, Effect, EffectMode, LensNeed, PlanError, PlanOptions};
use crate::camera::lens::setup::LensInfo;
use crate::camera::{EnabledEffects, Spectrum};
use crate::spectrum::{SET_SIZE, SPECTRAL_COUNT};

/// Measures are taken at some places and for some rays of all: the worst may lie between them.
pub(super) const MARGIN: f64 = 1.25;
/// The part of the places without light from which on their content is taken as unknown.
const DARK: f64 = 0.02;

pub(super) fn decide(known: &Known<'_>, wishes: &PlanOptions) -> Result<(Vec<Decision>, CameraChoice, f64), PlanError> {
    if let Some(effect) = Effect::ALL.into_iter().find(|e| wishes.word(*e) == EffectMode::On && !e.is_available()) {
        return Err(PlanError::NotYet(effect));
    }
    let (choice, price) = choose(known, wishes)?;
    let decisions = Effect::ALL.into_iter().map(|effect| decision(effect, known, wishes, &choice, price)).collect();
    let lossy_ns = if choice.transmission { transmission_ns(price) } else { 0.0 };
    Ok((decisions, choice, sample_ns(price, known.survey.shape()) + lossy_ns))
}

pub(super) fn tolerance(effect: Effect, wishes: &PlanOptions) -> f64 {
    effect.unit().tolerance(wishes.quality)
}

/// True if an effect is called for.
fn is_wanted(effect: Effect, known: &Known<'_>, wishes: &PlanOptions) -> bool {
    let is_large = || {
        let with = beside(effect, known, wishes).map_or(0.0, |(_, value)| value);
        effect.measure(known).value.is_some_and(|m| (m + with) * MARGIN > tolerance(effect, wishes))
    };
    match wishes.word(effect) {
        EffectMode::On => true,
        EffectMode::Off => false,
        EffectMode::Auto => effect.is_available() && is_large(),
    }
}

/// The effect whose measure is added to that of an effect that is left out with it: to the larger of both errors of colour the other, for
/// they part the same light, and one spectral film shows both.
fn beside(effect: Effect, known: &Known<'_>, wishes: &PlanOptions) -> Option<(Effect, f64)> {
    let other = match effect {
        Effect::LateralColour => Effect::AxialColour,
        Effect::AxialColour => Effect::LateralColour,
        _ => return None,
    };
    let (own, others) = (effect.measure(known).value?, other.measure(known).value?);
    // Of equal ones that which comes first.
    let is_larger = own > others || (own == others && effect == Effect::LateralColour);
    (is_larger && others > 0.0 && wishes.word(other) != EffectMode::Off).then_some((other, others))
}

/// The number of wavelengths whose images lie closer together than can be told apart, where the camera leaves their number open.
fn bands(Known { d, lens, .. }: &Known<'_>, wishes: &PlanOptions) -> Spectrum {
    match d.spectrum {
        Spectrum::Visible => {
            let spread = lens.lateral_colour.value.max(lens.axial_colour.value);
            let needed = (MARGIN * spread / tolerance(Effect::LateralColour, wishes)).ceil();
            let sets = ((needed / SET_SIZE as f64).ceil() as usize).clamp(1, SPECTRAL_COUNT / SET_SIZE);
            Spectrum::Bands(sets * SET_SIZE)
        }
        given => given,
    }
}

/// The effects that the user leaves in a lens that is traced all the same.
fn shown(wishes: &PlanOptions, in_colour: bool) -> EnabledEffects {
    let off = |effect| wishes.word(effect) == EffectMode::Off;
    EnabledEffects {
        defocus: !off(Effect::Defocus),
        aberration: !off(Effect::Aberration),
        distortion: !off(Effect::Distortion),
        vignetting: !off(Effect::Vignetting),
        lateral_colour: !off(Effect::LateralColour) || !in_colour,
        axial_colour: !off(Effect::AxialColour) || !in_colour,
    }
}

/// The cheapest camera that has the effects that are called for.
fn choose(known: &Known<'_>, wishes: &PlanOptions) -> Result<(CameraChoice, Price), PlanError> {
    let Known { d, survey, lens, .. } = known;
    let wanted = |effect: Effect| is_wanted(effect, known, wishes);

    let colours = [Effect::LateralColour, Effect::AxialColour];
    let is_asked = colours.map(|effect| wishes.word(effect)).contains(&EffectMode::On);
    let has_colours = survey.has_colours() || (d.wavelength_nm.is_some() && is_asked);
    let in_colour = has_colours && colours.into_iter().any(wanted);
    let spectrum = in_colour.then(|| bands(known, wishes));

    let shown = shown(wishes, in_colour);
    if known.lens_need == LensNeed::Required && !shown.is_traced_plainly() {
        let what = "bidirectional paths end in the lens as it is; set what is off to auto, or choose path tracing";
        return Err(PlanError::Conflict(what.to_owned()));
    }

    let shape = survey.shape();
    let beside_gauss = [Effect::Aberration, Effect::Distortion, Effect::Vignetting, Effect::Transmission];
    let is_plain = !in_colour
        && known.lens_need == LensNeed::None
        && shown == EnabledEffects::default()
        && Effect::ALL.into_iter().all(|e| wishes.word(e) != EffectMode::On || !e.is_of_rays())
        && !beside_gauss.into_iter().any(wanted)
        && lens.cats_eye.value * MARGIN <= tolerance(Effect::Defocus, wishes)
        && lens.dark_part == 0.0;
    let carried = spectrum.map_or(1, |s| s.count().min(SET_SIZE));
    let exact = Price::Exact { is_single: true, carried };
    let can_be_pinhole = survey.is_upright() && d.exposure.is_none();
    let (way, price) = if is_plain && !wanted(Effect::Defocus) && can_be_pinhole {
        (pinhole(survey.info()), Price::Pinhole)
    } else if is_plain && sample_ns(Price::Gaussian, shape) < sample_ns(exact, shape) {
        (CameraKind::Gaussian, Price::Gaussian)
    } else {
        (CameraKind::Exact, exact)
    };
    let round_f_number = (lens.diaphragm_part > 0.0 && !wanted(Effect::Diaphragm)).then(|| survey.f_number_by_area());
    let moves = known.motion.is_some() || known.scene_motion.is_some();
    let is_moving = moves && wanted(Effect::MotionBlur);
    // Rays that are sent elsewhere on purpose are followed from the film.
    let is_traced = way == CameraKind::Exact && shown.is_traced_plainly();
    let pipeline = wishes.pipeline.of_packets(is_traced.then_some(carried));
    let (ghosts, diffraction, glare) = (wanted(Effect::Ghosts), wanted(Effect::Diffraction), wanted(Effect::Glare));
    let transmission = wanted(Effect::Transmission);
    let choice = CameraChoice {
        way,
        pipeline,
        spectrum,
        round_f_number,
        shown,
        is_moving,
        ghosts,
        diffraction,
        glare,
        transmission,
    };
    Ok((choice, price))
}

/// The decision on an effect, and its reason.
fn decision(effect: Effect, known: &Known<'_>, wishes: &PlanOptions, choice: &CameraChoice, price: Price) -> Decision {
    let (word, tolerance, found) = (wishes.word(effect), tolerance(effect, wishes), effect.measure(known));
    let measure = found.value;
    let beside = beside(effect, known, wishes);
    let with = beside.map_or(0.0, |(_, value)| value);
    let is_large = measure.is_some_and(|value| (value + with) * MARGIN > tolerance);
    let is_on = effect.is_simulated(choice, known);
    let limit = size(tolerance, effect.unit());
    let why = if measure == Some(0.0) && word == EffectMode::Auto && !is_on {
        found.text + ": nothing to simulate"
    } else {
        let sized = match measure {
            Some(value) if value > tolerance => format!("{}, more than {limit}", found.text),
            Some(value) if value * MARGIN > tolerance => format!("{}, too near to {limit}", found.text),
            Some(value) if is_large => {
                let than = if value + with > tolerance { "more than" } else { "too near to" };
                let other = beside.map_or("", |(other, _)| other.name()).replace('_', " ");
                format!("{}, with {} of {other} {than} {limit}", found.text, size(with, effect.unit()))
            }
            Some(_) => format!("{}, less than {limit}", found.text),
            None => found.text,
        };
        let outcome = match (word, is_on) {
            (EffectMode::On, _) => "simulated, as asked".to_owned(),
            (EffectMode::Off, false) => "left out, as asked".to_owned(),
            (_, false) if !effect.is_available() && is_large => {
                "it would be seen, but cannot be simulated yet".to_owned()
            }
            (_, false) => "left out".to_owned(),
            (EffectMode::Off, true) => "comes along, for it cannot be taken out of this lens".to_owned(),
            (EffectMode::Auto, true) if is_large => "simulated".to_owned(),
            (EffectMode::Auto, true) => format!("comes along at no cost with the {} lens", choice.way.name()),
        };
        format!("{sized}: {outcome}")
    };
    let is_uncertain = known.lens.dark_part > DARK || (is_large && measure.is_some_and(|value| value <= tolerance));
    let cost_ns = if is_on { effect.cost_ns(choice, price, known) } else { 0.0 };
    let picture_s = if is_on { effect.picture_s(known) } else { 0.0 };
    Decision { effect, measure, tolerance, word, is_on, is_uncertain, why, cost_ns, picture_s }
}

/// The decision on motion blur for a camera without a lens to be planned. The motion by changes of a simpler lens model is not known.
pub(super) fn motion_without_lens(motion: Option<SceneMotion>, lens_changes: bool, wishes: &PlanOptions) -> Decision {
    let effect = Effect::MotionBlur;
    let (word, tolerance) = (wishes.word(effect), tolerance(effect, wishes));
    let moves = motion.is_some() || lens_changes;
    let px = motion.as_ref().map(|motion| motion.px);
    let is_large = px.is_some_and(|px| px * MARGIN > tolerance);
    let is_on = moves && (word == EffectMode::On || (word == EffectMode::Auto && (is_large || lens_changes)));
    let outcome = match (word, is_on) {
        (EffectMode::On, true) => "simulated, as asked",
        (EffectMode::Off, _) => "left out, as asked",
        (_, true) => "simulated",
        (_, false) if moves => "left out",
        (_, false) => "nothing to simulate",
    };
    let limit = size(tolerance, effect.unit());
    let why = match motion {
        Some(SceneMotion { text, .. }) if is_large => format!("{text}, more than {limit}: {outcome}"),
        Some(_) if lens_changes => format!("the lens changes: {outcome}"),
        Some(SceneMotion { text, .. }) => format!("{text}, less than {limit}: {outcome}"),
        None if lens_changes => format!("the lens changes: {outcome}"),
        None => format!("everything stands still: {outcome}"),
    };
    let measure = if lens_changes && !is_large { None } else { Some(px.unwrap_or(0.0)) };
    Decision { effect, measure, tolerance, word, is_on, is_uncertain: false, why, cost_ns: 0.0, picture_s: 0.0 }
}

fn pinhole(info: &LensInfo) -> CameraKind {
    CameraKind::Pinhole {
        focal_length_mm: info.viewport_focal_length_mm,
        film_width_mm: info.picture_width_mm,
        shift: info.viewport_shift,
    }
}
