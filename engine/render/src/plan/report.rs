//! The report of a plan: the output of `petzval plan --json`, and the record that is kept with a picture.

use super::{Decision, Effect, Plan};
use glam::{DVec3, Vec2};
use serde::Serialize;

/// Light sources that a report lists.
const SOURCES: usize = 4;

/// A plan, its measures and its reasons.
#[derive(Clone, Debug, Serialize)]
pub struct PlanReport {
    /// One for each effect, in the order of [`Effect::ALL`].
    pub effects: Vec<EffectReport>,
    /// The quality, by which all tolerances are divided.
    pub quality: f64,
    /// The simulation of the camera.
    pub camera: CameraReport,
    /// The view of the camera.
    pub look: ProbeReport,
    /// Wall time that the plan took, s.
    pub seconds: f64,
    /// The forecast of the render, where it was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted: Option<Predicted>,
}

/// An effect in a report.
#[derive(Clone, Debug, Serialize)]
pub struct EffectReport {
    /// Name of the effect.
    pub effect: &'static str,
    /// Measure of the effect's change of the picture; `None` where it is not measured, or has no bound.
    pub measure: Option<f64>,
    /// True if the measure has no bound.
    pub is_unbounded: bool,
    /// Unit of measure and tolerance.
    pub unit: &'static str,
    /// The largest measure that may be left out.
    pub tolerance: f64,
    /// The user's setting: auto, on or off.
    pub word: &'static str,
    /// The decision: on or off.
    pub decision: &'static str,
    /// False for an effect that cannot be simulated yet.
    pub is_available: bool,
    /// True if the measure may be too small.
    pub is_uncertain: bool,
    /// Time that the effect adds, as a part of the time without it; `None` without a forecast.
    pub predicted_cost: Option<f64>,
    /// Work once a picture, s on one thread.
    pub picture_seconds: f64,
    /// The reason, in a sentence.
    pub why: String,
}

/// The camera in a report.
#[derive(Clone, Debug, Serialize)]
pub struct CameraReport {
    /// Name of the camera model.
    pub model: &'static str,
    /// Number of wavelengths of the film.
    pub wavelengths: usize,
    /// Name of the pipeline.
    pub pipeline: &'static str,
    /// F-number of a round opening of equal area, if the opening's shape does not matter.
    pub round_f_number: Option<f64>,
    /// True if diffraction is simulated.
    pub diffraction: bool,
    /// True if glare is simulated.
    pub glare: bool,
}

/// The view of the camera in a report.
#[derive(Clone, Debug, Serialize)]
pub struct ProbeReport {
    /// The nearest and the farthest along the axis, Blender units; `None` if the camera sees nothing.
    pub depths: Option<[f64; 2]>,
    /// The part of the picture that sees nothing.
    pub open_part: f64,
    /// Mean luminance of the picture, without its brightest spots.
    pub exposure: f32,
    /// The strongest light sources.
    pub brightest: Vec<SourceReport>,
    /// The faces in the picture that lie on each other.
    pub coincident_faces: Vec<CoincidentReport>,
}

/// Coincident faces in a report.
#[derive(Clone, Debug, Serialize)]
pub struct CoincidentReport {
    /// Names of the two objects; one name twice where the faces are of one object.
    pub objects: [String; 2],
    /// The part of the picture that shows such faces.
    pub part: f64,
    /// The message to the user, a line.
    pub text: String,
}

/// A light source in a report.
#[derive(Clone, Debug, Serialize)]
pub struct SourceReport {
    /// Direction towards the source, render space, unit.
    pub towards: DVec3,
    /// Irradiance by the source on a surface that faces it.
    pub irradiance: f32,
    /// The part of all arriving light.
    pub part: f32,
    /// Place in the picture, fractions of the width and height from the centre; `None`: outside of the picture.
    pub place: Option<Vec2>,
}

/// The forecast of a render in a report.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Predicted {
    /// Wall time of the samples and of the stray light, s.
    pub seconds: f64,
    /// Wall time of the stray light alone, once the samples are there, s.
    pub after_seconds: f64,
    /// Samples a pixel.
    pub samples: u32,
    /// Number of threads that the time holds for.
    pub threads: usize,
    /// The part of the time in the camera.
    pub camera_part: f64,
}

/// An effect in the list of effects.
#[derive(Clone, Debug, Serialize)]
pub struct EffectFacts {
    /// Name of the effect.
    pub name: &'static str,
    /// Unit of its measure.
    pub unit: &'static str,
    /// False for an effect that cannot be simulated yet.
    pub is_available: bool,
    /// The tolerance at quality 1.
    pub tolerance: f64,
}

impl Effect {
    /// The effect in the list of effects.
    pub fn facts(self) -> EffectFacts {
        EffectFacts {
            name: self.name(),
            unit: self.unit().name(),
            is_available: self.is_available(),
            tolerance: self.unit().tolerance(1.0),
        }
    }
}

impl Decision {
    fn report(&self) -> EffectReport {
        EffectReport {
            effect: self.effect.name(),
            measure: self.measure.filter(|measure| measure.is_finite()),
            is_unbounded: self.measure.is_some_and(f64::is_infinite),
            unit: self.effect.unit().name(),
            tolerance: self.tolerance,
            word: self.word.name(),
            decision: if self.is_on { "on" } else { "off" },
            is_available: self.effect.is_available(),
            is_uncertain: self.is_uncertain,
            predicted_cost: None,
            picture_seconds: self.picture_s,
            why: self.why.clone(),
        }
    }
}

impl Plan {
    /// The report, without a forecast.
    pub fn report(&self) -> PlanReport {
        let brightest = self.look.brightest.iter().take(SOURCES).map(|one| SourceReport {
            towards: one.towards,
            irradiance: one.irradiance,
            part: one.part,
            place: one.place,
        });
        let coincident = self.look.coincident_faces.iter().map(|one| CoincidentReport {
            objects: one.objects.clone(),
            part: one.part,
            text: one.text(),
        });
        PlanReport {
            effects: self.decisions.iter().map(Decision::report).collect(),
            quality: self.quality,
            camera: CameraReport {
                model: self.camera.way.name(),
                wavelengths: self.camera.wavelengths(),
                pipeline: self.camera.pipeline.name(),
                round_f_number: self.camera.round_f_number,
                diffraction: self.camera.diffraction,
                glare: self.camera.glare,
            },
            look: ProbeReport {
                depths: self.look.depths,
                open_part: self.look.open_part,
                exposure: self.look.exposure,
                brightest: brightest.collect(),
                coincident_faces: coincident.collect(),
            },
            seconds: self.seconds,
            predicted: None,
        }
    }

    /// The report with a forecast of the samples' time, to which the work once a picture is added: the wall times of some effects that
    /// were measured, s, and of the others by their price.
    pub fn report_with(&self, samples: Predicted, measured: &[(Effect, f64)]) -> PlanReport {
        let mut plan = self.clone();
        for &(effect, seconds) in measured {
            plan.decisions[effect as usize].picture_s = seconds * samples.threads as f64;
        }
        plan.report_by_price(samples)
    }

    fn report_by_price(&self, samples: Predicted) -> PlanReport {
        let Predicted { seconds, threads, camera_part, .. } = samples;
        let mut report = self.report();
        for (row, effect) in report.effects.iter_mut().zip(Effect::ALL) {
            row.predicted_cost = Some(self.cost(effect, camera_part, seconds, threads));
        }
        let after_seconds = self.seconds_after(threads);
        report.predicted = Some(Predicted { seconds: seconds + after_seconds, after_seconds, ..samples });
        report
    }
}
