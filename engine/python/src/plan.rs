//! Plans of effects: made of a scene and a camera, told of, and handed to a render.

use crate::described::{Described, Named};
use crate::error::{Error, invalid, json};
use crate::gil::without_gil;
use crate::scene::Scene;
use petzval_render::camera::CameraDescription;
use petzval_render::camera::shutter::Shutter;
use petzval_render::job::Settings;
use petzval_render::plan::{self, Effect, EffectMode, PlanOptions};
use petzval_render::stray::Reflections;
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// A plan: the effects that are simulated in one picture, and the reasons.
#[pyclass(frozen)]
pub(crate) struct Plan {
    pub(crate) plan: plan::Plan,
}

#[pymethods]
impl Plan {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword of Python")]
    #[pyo3(signature = (scene, camera, settings, over_the_shutter=Vec::new(), *, effects=Named(BTreeMap::new()), quality=1.0, ghost_reflections=2, shutter=None))]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        camera: Described<CameraDescription>,
        settings: Described<Settings>,
        over_the_shutter: Vec<Described<CameraDescription>>,
        effects: Named<BTreeMap<Effect, EffectMode>>,
        quality: f64,
        ghost_reflections: usize,
        shutter: Option<Described<Shutter>>,
    ) -> Result<Self, Error> {
        let ghost_reflections = Reflections::of(ghost_reflections)
            .ok_or_else(|| invalid(format!("{ghost_reflections} reflections of ghosts: give 2 or 4")))?;
        let mut options = PlanOptions::new(&effects.0);
        (options.quality, options.ghost_reflections) = (quality, ghost_reflections);
        let moving: Vec<CameraDescription> = over_the_shutter.into_iter().map(|d| d.0).collect();
        let (stage, shutter) = (scene.stage.clone(), shutter.map(|shutter| shutter.0));
        let made = || settings.0.plan(&stage, &camera.0, &moving, options, shutter.as_ref());
        Ok(Self { plan: without_gil(py, made)?? })
    }

    /// The plan with the forecast of the render's time.
    fn forecast(
        &self,
        py: Python<'_>,
        scene: &Scene,
        camera: Described<CameraDescription>,
        settings: Described<Settings>,
    ) -> Result<String, Error> {
        let stage = scene.stage.clone();
        json(&without_gil(py, || settings.0.forecast(&self.plan, stage, &camera.0))??)
    }

    /// The part of a picture to render for a border of it.
    fn window(&self, border: [u32; 4], size: [u32; 2]) -> Option<[u32; 4]> {
        self.plan.window(border, size)
    }

    fn json(&self) -> Result<String, Error> {
        json(&self.plan.report())
    }
}

/// Name, unit and tolerance at quality 1 of each effect, in the order of reports, and true if it can be simulated.
#[pyfunction]
pub(crate) fn effects_json() -> Result<String, Error> {
    json(&Effect::ALL.map(Effect::facts))
}
