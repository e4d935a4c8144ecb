//! Decisions on the effects of a calibrated camera's lens beside its rays.

use super::decide::{MARGIN, tolerance};
use super::effects::Effect;
use super::words::size;
use super::{Decision, EffectMode, PlanOptions};
use crate::camera::{Camera, EnabledEffects};

/// The decisions on vignetting and lateral colour of a calibrated camera, where a lensfun database has them; none of other cameras.
pub(super) fn decisions(camera: &Camera, wishes: &PlanOptions) -> Vec<Decision> {
    let Camera::Calibrated(calibrated) = camera else { return Vec::new() };
    let effects = [Effect::Vignetting, Effect::LateralColour];
    let measured = effects.into_iter().zip(calibrated.beside_rays());
    measured.filter_map(|(effect, measure)| Some(decision(effect, measure?, wishes))).collect()
}

/// The effects of a calibrated camera that are shown.
pub(super) fn shown(decisions: &[Decision]) -> EnabledEffects {
    let is_on = |effect: Effect| decisions.iter().all(|one| one.effect != effect || one.is_on);
    EnabledEffects {
        vignetting: is_on(Effect::Vignetting),
        lateral_colour: is_on(Effect::LateralColour),
        ..EnabledEffects::default()
    }
}

fn decision(effect: Effect, measure: f64, wishes: &PlanOptions) -> Decision {
    let (word, tolerance) = (wishes.word(effect), tolerance(effect, wishes));
    let is_large = measure * MARGIN > tolerance;
    let is_on = word == EffectMode::On || (word == EffectMode::Auto && is_large);
    let outcome = match (word, is_on) {
        (EffectMode::On, _) => "simulated, as asked",
        (EffectMode::Off, _) => "left out, as asked",
        (EffectMode::Auto, true) => "simulated",
        (EffectMode::Auto, false) => "left out",
    };
    let than = if is_large { "more" } else { "less" };
    let [found, limit] = [measure, tolerance].map(|value| size(value, effect.unit()));
    Decision {
        effect,
        measure: Some(measure),
        tolerance,
        word,
        is_on,
        is_uncertain: false,
        why: format!("{found} by the calibration, {than} than {limit}: {outcome}"),
        cost_ns: 0.0,
        picture_s: 0.0,
    }
}
