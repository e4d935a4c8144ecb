//! Plans of effects: made of a scene and a camera, told of, and handed to a render.

use crate::camera::PyCamera;
use crate::error::{Error, invalid};
use crate::gil::without_gil;
use crate::job::{PySettings, PyShutter};
use crate::scene::Scene;
use petzval_render::camera::clip::Clip;
use petzval_render::camera::{Camera, CameraDescription};
use petzval_render::integrator::Integrator;
use petzval_render::job::forecast::Forecast;
use petzval_render::job::{OutputOptions, Settings};
use petzval_render::plan::{self, Decision, Effect, EffectMode, PlanOptions};
use petzval_render::stray::Reflections;
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A plan: the effects that are simulated in one picture, and the reasons.
#[pyclass(frozen)]
pub(crate) struct Plan {
    pub(crate) plan: plan::Plan,
    quality: f64,
}

#[pymethods]
impl Plan {
    #[new]
    #[allow(clippy::too_many_arguments)]
    #[pyo3(signature = (scene, camera, settings, over_the_shutter=Vec::new(), *, effects=BTreeMap::new(), quality=1.0, ghost_reflections=2, shutter=None))]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        camera: PyCamera,
        settings: PySettings,
        over_the_shutter: Vec<PyCamera>,
        effects: BTreeMap<String, String>,
        quality: f64,
        ghost_reflections: usize,
        shutter: Option<PyShutter>,
    ) -> Result<Self, Error> {
        let description: CameraDescription = camera.try_into()?;
        let moving =
            over_the_shutter.into_iter().map(TryInto::try_into).collect::<Result<Vec<CameraDescription>, _>>()?;
        let settings: Settings = settings.try_into()?;
        let mut wishes = wishes(&effects, quality, &settings)?;
        wishes.ghost_reflections = Reflections::of(ghost_reflections)
            .ok_or_else(|| invalid(format!("{ghost_reflections} reflections of ghosts: give 2 or 4")))?;
        let needs_lens = settings.integrator == Integrator::Bidirectional;
        let size = [settings.width, settings.height];
        let stage = scene.stage.clone();
        let plan = without_gil(py, || {
            let exposure = shutter.map(|shutter| shutter.exposure(stage.scene.origin));
            plan::Plan::new(&stage, &description, &moving, size, &wishes, needs_lens, exposure.as_ref())
        })??;
        Ok(Self { plan, quality })
    }

    /// The plan with what the render will take.
    fn forecast(&self, py: Python<'_>, scene: &Scene, camera: PyCamera, settings: PySettings) -> Result<String, Error> {
        let camera = self.plan.applied(&camera.try_into()?);
        let mut settings: Settings = settings.try_into()?;
        settings.pipeline = self.plan.pipeline();
        let (stage, samples) = (scene.stage.clone(), settings.samples);
        let found = without_gil(py, || -> Result<Forecast, Error> {
            let ready = Camera::new(&camera, settings.width, settings.height)?;
            let beside = OutputOptions { clip: Clip::new(&camera, &ready), ..OutputOptions::default() };
            Ok(Forecast::new(stage, vec![ready], settings, beside)?)
        })??;
        let mut told = self.value();
        told["predicted"] = json!({
            "seconds": found.seconds + self.plan.seconds_after(found.threads),
            "samples": samples,
            "threads": found.threads,
            "camera_part": found.camera_part,
        });
        for (row, effect) in told["effects"].as_array_mut().into_iter().flatten().zip(Effect::ALL) {
            row["predicted_cost"] = json!(self.plan.cost(effect, found.camera_part, found.seconds, found.threads));
        }
        Ok(told.to_string())
    }

    fn json(&self) -> String {
        self.value().to_string()
    }
}

impl Plan {
    /// The report of the plan.
    fn value(&self) -> Value {
        let plan = &self.plan;
        let look = &plan.look;
        let brightest: Vec<Value> = look
            .brightest
            .iter()
            .take(4)
            .map(|one| json!({"towards": one.towards.to_array(), "irradiance": one.irradiance, "part": one.part, "place": one.place.map(|p| p.to_array())}))
            .collect();
        json!({
            "effects": plan.decisions.iter().map(row).collect::<Value>(),
            "quality": self.quality,
            "camera": {
                "model": plan.camera.way.name(),
                "wavelengths": plan.camera.wavelengths(),
                "pipeline": plan.camera.pipeline.name(),
                "round_f_number": plan.camera.round_f_number,
                "diffraction": plan.camera.diffraction,
                "glare": plan.camera.glare,
            },
            "look": {
                "depths": look.depths,
                "open_part": look.open_part,
                "exposure": look.exposure,
                "brightest": brightest,
            },
            "seconds": plan.seconds,
        })
    }
}

fn row(d: &Decision) -> Value {
    json!({
        "effect": d.effect.name(),
        "measure": d.measure.filter(|m| m.is_finite()),
        "is_unbounded": d.measure.is_some_and(f64::is_infinite),
        "unit": d.effect.unit().name(),
        "tolerance": d.tolerance,
        "word": d.word.name(),
        "decision": if d.is_on { "on" } else { "off" },
        "is_available": d.effect.is_available(),
        "is_uncertain": d.is_uncertain,
        "predicted_cost": Value::Null,
        "picture_seconds": d.picture_s,
        "why": d.why,
    })
}

fn wishes(effects: &BTreeMap<String, String>, quality: f64, settings: &Settings) -> Result<PlanOptions, Error> {
    let mut wishes = PlanOptions::default();
    (wishes.quality, wishes.pipeline) = (quality, settings.pipeline);
    for (name, word) in effects {
        let names = || Effect::ALL.map(Effect::name).join(", ");
        let effect = Effect::named(name)
            .ok_or_else(|| invalid(format!("there is no effect '{name}'; use one of {}", names())))?;
        let word = EffectMode::named(word)
            .ok_or_else(|| invalid(format!("effect {name} is '{word}'; use auto, on or off")))?;
        wishes.say(effect, word);
    }
    Ok(wishes)
}

/// Name, unit and tolerance at quality 1 of each effect, in the order of reports, and true if it can be simulated.
#[pyfunction]
pub(crate) fn effects_json() -> String {
    let one = |effect: Effect| {
        json!({"name": effect.name(), "unit": effect.unit().name(), "is_available": effect.is_available(),
               "tolerance": effect.unit().tolerance(1.0)})
    };
    Effect::ALL.map(one).to_vec().into_iter().collect::<Value>().to_string()
}
