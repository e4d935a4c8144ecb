//! The effects of cameras without a lens, and of simpler models of one.

use super::{Decision, Effect, EffectMode, PlanError, PlanOptions};
use crate::camera::Model;

/// The effects of a camera without a lens, or of a simpler model of one: the model decides all but its colours and its transmission.
pub(super) struct ModelEffects {
    model: Model,
    /// True if the model shows colours where they are apart.
    pub(super) colours: bool,
    /// True if the model shows the colour of the light on the axis.
    pub(super) transmission: bool,
}

impl ModelEffects {
    /// Checks that the user's wishes are those of the decided effects.
    pub(super) fn new(model: Model, decided: &[Decision], wishes: &PlanOptions) -> Result<Self, PlanError> {
        if let Some(effect) = Effect::ALL.into_iter().find(|e| wishes.word(*e) == EffectMode::On && !e.is_available()) {
            return Err(PlanError::NotYet(effect));
        }
        let colours = [Effect::LateralColour, Effect::AxialColour].map(|effect| wishes.word(effect));
        let may_transmit = matches!(model, Model::Thick | Model::Paraxial | Model::ImageBased);
        let effects = Self {
            model,
            colours: Effect::LateralColour.is_in(model) && colours != [EffectMode::Off; 2],
            transmission: may_transmit && wishes.word(Effect::Transmission) != EffectMode::Off,
        };
        let is_against = |effect: &Effect| {
            *effect != Effect::MotionBlur
                && !decided.iter().any(|one| one.effect == *effect)
                && match wishes.word(*effect) {
                    EffectMode::Auto => false,
                    EffectMode::On => !effects.has(*effect),
                    EffectMode::Off => effects.has(*effect),
                }
        };
        match Effect::ALL.into_iter().find(is_against) {
            None => Ok(effects),
            Some(effect) => Err(PlanError::Conflict(format!(
                "{}={}: the camera's model decides this one; set it to auto, or choose the lens as model",
                effect.name(),
                wishes.word(effect).name()
            ))),
        }
    }

    /// True if the model shows an effect.
    pub(super) fn has(&self, effect: Effect) -> bool {
        match effect {
            Effect::LateralColour | Effect::AxialColour => self.colours,
            Effect::Transmission => self.transmission,
            _ => effect.is_in(self.model),
        }
    }
}
