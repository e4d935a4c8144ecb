//! Renders, watched from Python.

use crate::camera::{Matrix4, PyCamera};
use crate::error::{Error, invalid};
use crate::files::Checkpoint;
use crate::gil::without_gil;
use crate::parts::part;
use crate::plan::Plan;
use crate::scene::Scene;
use glam::{DMat4, DVec3};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use petzval_render::camera::clip::Clip;
use petzval_render::camera::imaging::Imaging;
use petzval_render::camera::precision::TOLERANCE_PX;
use petzval_render::camera::shade;
use petzval_render::camera::{Camera, CameraDescription};
use petzval_render::film;
use petzval_render::film::cryptomatte::{self, MatteLayer};
use petzval_render::film::data::DataPass;
use petzval_render::integrator::Integrator;
use petzval_render::integrator::path::parts::{LightPass, Parts, Seen};
use petzval_render::integrator::path::{Approximations, FastGi, KindLimits};
use petzval_render::job::catcher::{self, Laying};
use petzval_render::job::checkpoint::Checkpoints;
use petzval_render::job::{self as engine, OutputOptions, Settings};
use petzval_render::pipeline::Pipeline;
use petzval_render::pipeline::exposure::{Exposure, Shutter};
use petzval_render::pipeline::motion::Motion;
use petzval_render::plan as engine_plan;
use petzval_render::sampler::warp::Filter;
use petzval_render::shading::Caustics;
use petzval_render::stray::StrayPass;
use pyo3::prelude::*;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

#[derive(FromPyObject)]
pub(crate) struct PySettings {
    width: u32,
    height: u32,
    samples: u32,
    noise_threshold: f32,
    min_samples: u32,
    seed: u32,
    blue_noise: bool,
    film_exposure: f32,
    window: Option<(u32, u32, u32, u32)>,
    sample_offset: u32,
    threads: usize,
    max_bounces: u32,
    diffuse_bounces: u32,
    glossy_bounces: u32,
    transmission_bounces: u32,
    volume_bounces: u32,
    transparent_bounces: u32,
    transparent_shadows: u32,
    reflective_caustics: bool,
    refractive_caustics: bool,
    clamp_direct: f32,
    clamp_indirect: f32,
    filter: String,
    filter_glossy: f32,
    fast_gi: String,
    fast_gi_bounces: u32,
    fast_gi_distance: f32,
    fast_gi_factor: f32,
    filter_width_px: f32,
    transparent_film: bool,
    pipeline: String,
    with_data: bool,
    integrator: String,
}

impl TryFrom<PySettings> for Settings {
    type Error = Error;

    fn try_from(s: PySettings) -> Result<Self, Error> {
        let pipeline = match s.pipeline.as_str() {
            "AUTO" => Pipeline::Auto,
            "FILM" => Pipeline::FilmFirst,
            "SCENE" => Pipeline::SceneFirst,
            "HERO" => Pipeline::Hero,
            other => return Err(invalid(format!("there is no pipeline '{other}'; use AUTO, FILM, SCENE or HERO"))),
        };
        let integrator = match s.integrator.as_str() {
            "PATH" => Integrator::Path,
            "BIDIRECTIONAL" => Integrator::Bidirectional,
            other => return Err(invalid(format!("there is no integrator '{other}'; use PATH or BIDIRECTIONAL"))),
        };
        let filter = match s.filter.as_str() {
            "BOX" => Filter::Box,
            "GAUSSIAN" => Filter::Gaussian(s.filter_width_px),
            "BLACKMAN_HARRIS" => Filter::BlackmanHarris(s.filter_width_px),
            other => {
                return Err(invalid(format!(
                    "there is no pixel filter '{other}'; use BOX, GAUSSIAN or BLACKMAN_HARRIS"
                )));
            }
        };
        let (distance, factor) = (s.fast_gi_distance, s.fast_gi_factor);
        let fast_gi = match s.fast_gi.as_str() {
            "OFF" => FastGi::Off,
            "REPLACE" => FastGi::Replace { bounces: s.fast_gi_bounces, distance, factor },
            "ADD" => FastGi::Add { distance, factor },
            other => return Err(invalid(format!("there is no fast GI '{other}'; use OFF, REPLACE or ADD"))),
        };
        Ok(Self {
            width: s.width,
            height: s.height,
            samples: s.samples,
            noise_threshold: s.noise_threshold,
            min_samples: s.min_samples,
            seed: s.seed,
            blue_noise: s.blue_noise,
            film_exposure: s.film_exposure,
            window: s.window.map(Into::into),
            sample_offset: s.sample_offset,
            threads: s.threads,
            max_bounces: s.max_bounces,
            kinds: KindLimits {
                diffuse: s.diffuse_bounces,
                glossy: s.glossy_bounces,
                transmission: s.transmission_bounces,
                volume: s.volume_bounces,
                transparent: s.transparent_bounces,
                transparent_shadows: s.transparent_shadows,
                caustics: Caustics { reflective: s.reflective_caustics, refractive: s.refractive_caustics },
            },
            clamp_direct: s.clamp_direct,
            clamp_indirect: s.clamp_indirect,
            filter,
            approximations: Approximations { filter_glossy: s.filter_glossy, fast_gi },
            transparent_film: s.transparent_film,
            pipeline,
            with_data: s.with_data,
            integrator,
        })
    }
}

/// The opening of the shutter, and the camera's places meanwhile.
#[derive(FromPyObject)]
pub(crate) struct PyShutter {
    openness: Vec<f32>,
    rolling: Option<f32>,
    camera_keys: Vec<Matrix4>,
}

impl PyShutter {
    pub(crate) fn exposure(self, origin: DVec3) -> Exposure {
        let Self { openness, rolling, camera_keys } = self;
        let exposure = Exposure::new(&Shutter { openness, rolling });
        let keys: Vec<DMat4> = camera_keys.into_iter().map(Into::into).collect();
        if keys.is_empty() { exposure } else { exposure.along(&keys, origin) }
    }
}

type PyTile<'py> = (u32, u32, u32, u32, Bound<'py, PyArray3<f32>>);

/// One render.
/// See the stub.
#[pyfunction]
#[pyo3(signature = (*, surfaces = false, vectors = false, mattes = false, halves = false, groups = 0))]
pub(crate) fn film_bytes_a_pixel(surfaces: bool, vectors: bool, mattes: bool, halves: bool, groups: usize) -> usize {
    film::bytes_a_pixel(surfaces, vectors, mattes, halves, groups)
}

#[pyclass(frozen)]
pub(crate) struct Job {
    job: engine::Job,
    /// Seconds that planning took.
    plan_seconds: f64,
    /// The plan that decides on stray light, and the camera before its decisions.
    strays: Option<(engine_plan::Plan, CameraDescription)>,
}

#[pymethods]
impl Job {
    #[new]
    #[pyo3(signature = (
        scene, camera, settings, over_the_shutter=Vec::new(), *, plan=None, mattes=Vec::new(), matte_levels=6,
        neighbours=None, light_groups=0, parts=Vec::new(), mist=[0.0, 1.0, 1.0], catches=false, checkpoint=None,
        shutter=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        camera: PyCamera,
        settings: PySettings,
        over_the_shutter: Vec<PyCamera>,
        plan: Option<&Plan>,
        mattes: Vec<String>,
        matte_levels: u32,
        neighbours: Option<[PyCamera; 2]>,
        light_groups: u16,
        parts: Vec<String>,
        mist: [f32; 3],
        catches: bool,
        checkpoint: Option<(PathBuf, String, f64)>,
        shutter: Option<PyShutter>,
    ) -> Result<Self, Error> {
        let checkpoints = match checkpoint {
            Some((file, fingerprint, every_s)) => {
                let every = Duration::try_from_secs_f64(every_s)
                    .map_err(|_| invalid(format!("checkpoints every {every_s} s: name a time of 0 s or more")))?;
                Some(Checkpoints { file, fingerprint, every })
            }
            None => None,
        };
        let now: CameraDescription = camera.try_into()?;
        let is_moving = plan.is_none_or(|plan| plan.plan.camera.is_moving);
        let descriptions = if over_the_shutter.is_empty() || !is_moving {
            vec![now.clone()]
        } else {
            over_the_shutter.into_iter().map(TryInto::try_into).collect::<Result<Vec<CameraDescription>, Error>>()?
        };
        let planned = |d: &CameraDescription| plan.map_or_else(|| d.clone(), |plan| plan.plan.applied(d));
        let descriptions: Vec<CameraDescription> = descriptions.iter().map(planned).collect();
        let neighbours = match neighbours {
            Some([before, after]) => Some([before.try_into()?, after.try_into()?]),
            None => None,
        };
        let mattes = mattes.iter().map(|name| matte_layer(name)).collect::<Result<Vec<_>, Error>>()?;
        let mut parts = parts.iter().map(|name| part(name)).collect::<Result<Vec<LightPass>, Error>>()?;
        if catches {
            parts.extend(catcher::PARTS);
        }
        let mut settings: Settings = settings.try_into()?;
        if let Some(plan) = plan {
            settings.pipeline = plan.plan.pipeline();
        }
        let (now, unplanned) = (planned(&now), now);
        let plan_seconds = plan.map_or(0.0, |plan| plan.plan.seconds);
        let stage = scene.stage.clone();
        without_gil(py, || -> Result<Self, Error> {
            let camera = |d| Camera::new(d, settings.width, settings.height);
            let cameras = descriptions.iter().map(camera).collect::<Result<Vec<Camera>, _>>()?;
            let imaging = |d: &CameraDescription| Imaging::new(d, settings.width, settings.height, stage.scene.origin);
            let motion = match &neighbours {
                Some([before, after]) => {
                    let neighbours = [imaging(before)?, imaging(after)?];
                    Some(Motion::new(imaging(&now)?, neighbours, settings.width, settings.height))
                }
                None => None,
            };
            let clip = Clip::new(&now, &cameras[0]);
            let gains = shade::gains(&now, &cameras[cameras.len() / 2], settings.width, settings.height)?;
            let exposure = shutter.filter(|_| is_moving).map(|shutter| shutter.exposure(stage.scene.origin));
            let beside = now.position() - stage.scene.origin;
            let exposure = match exposure {
                None if beside == DVec3::ZERO => None,
                exposure => Some(exposure.unwrap_or_default().displaced(beside)),
            };
            let seen =
                Seen::by(now.matrix_world, stage.scene.origin, matches!(cameras[0], Camera::Orthographic(_)), mist);
            let parts = Parts::new(&parts, seen);
            let beside =
                OutputOptions { mattes, matte_levels, motion, clip, gains, light_groups, parts, checkpoints, exposure };
            let strays = plan.map(|plan| (plan.plan.clone(), unplanned));
            Ok(Self { job: engine::Job::start_with(stage, cameras, settings, beside)?, plan_seconds, strays })
        })?
    }

    fn wait(&self, py: Python<'_>, timeout_s: f64) -> Result<bool, Error> {
        let timeout = Duration::try_from_secs_f64(timeout_s.clamp(0.0, 1e6))
            .map_err(|_| invalid("the time to wait is not a number"))?;
        without_gil(py, || self.job.wait(timeout))
    }

    fn progress(&self) -> f32 {
        self.job.progress()
    }

    fn samples_done(&self) -> u32 {
        self.job.samples_done()
    }

    fn take_tiles<'py>(&self, py: Python<'py>) -> Result<Vec<PyTile<'py>>, Error> {
        let tiles = without_gil(py, || self.job.take_tiles())?;
        tiles
            .into_iter()
            .map(|t| {
                let r = t.rect;
                let pixels = array(py, t.pixels, r.width, r.height)?;
                Ok((r.x, r.y, r.width, r.height, pixels))
            })
            .collect()
    }

    fn image<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let pixels = without_gil(py, || self.job.picture())?;
        array(py, pixels, width, height)
    }

    fn data<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        if let Some(place) = ["REMAINDER", "REMAINDER_FINE"].iter().position(|known| *known == name) {
            // With light that strays the picture is no sum of samples.
            let rest = without_gil(py, || match self.job.strayed() {
                Some(_) => vec![[[0.0; 4]; 2]; width as usize * height as usize],
                None => self.job.film().remainders(),
            })?;
            return array(py, rest.into_iter().map(|both| both[place]).collect(), width, height);
        }
        let (pass, channels) = match name {
            "DEPTH" => (DataPass::Depth, 1),
            "POSITION" => (DataPass::Position, 3),
            "NORMAL" => (DataPass::Normal, 3),
            "VECTOR" => (DataPass::Vector, 4),
            "SAMPLES" => (DataPass::Samples, 1),
            other => {
                let names = "DEPTH, POSITION, NORMAL, VECTOR, SAMPLES, REMAINDER or REMAINDER_FINE";
                return Err(invalid(format!("there is no pass '{other}'; use {names}")));
            }
        };
        let flat = PyArray1::from_vec(py, without_gil(py, || self.job.data(pass))?);
        Ok(flat.reshape([height as usize, width as usize, channels])?)
    }

    fn matte<'py>(&self, py: Python<'py>, layer: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let layer = matte_layer(layer)?;
        let film = self.job.film();
        let (width, height) = film.size();
        let channels = 4 * film.mattes().passes();
        let flat = PyArray1::from_vec(py, without_gil(py, || self.job.matte(layer))?);
        Ok(flat.reshape([height as usize, width as usize, channels])?)
    }

    fn light_group<'py>(&self, py: Python<'py>, number: usize) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let film = self.job.film();
        let group = number.checked_sub(1).and_then(|place| film.groups().get(place));
        let group = group.ok_or_else(|| invalid(format!("there is no light group of number {number}")))?;
        let (width, height) = film.size();
        let pixels = without_gil(py, || group.picture())?;
        array(py, pixels, width, height)
    }

    fn index<'py>(&self, py: Python<'py>, layer: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let layer = matte_layer(layer)?;
        let film = self.job.film();
        let (width, height) = film.size();
        let flat = PyArray1::from_vec(py, without_gil(py, || film.most_seen(layer))?);
        Ok(flat.reshape([height as usize, width as usize, 1])?)
    }

    fn part<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let asked = part(name)?;
        let pixels = without_gil(py, || self.job.part(asked))?;
        let pixels = pixels.ok_or_else(|| invalid(format!("'{name}' is not kept")))?;
        self.array_of_three(py, pixels)
    }

    fn shadow<'py>(&self, py: Python<'py>, alone: &Self) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let pixels = without_gil(py, || self.job.shadow(&alone.job))?;
        self.array_of_three(py, pixels.ok_or_else(keeps_no_shadows)?)
    }

    #[pyo3(signature = (alone, sky, *, is_opaque, is_apart))]
    fn over_photograph<'py>(
        &self,
        py: Python<'py>,
        alone: &Self,
        sky: Option<&Self>,
        is_opaque: bool,
        is_apart: bool,
    ) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let laying = Laying { is_opaque, is_apart };
        let pixels = without_gil(py, || self.job.over_photograph(&alone.job, sky.map(|sky| &sky.job), laying))?;
        let (width, height) = self.job.film().size();
        array(py, pixels.ok_or_else(keeps_no_shadows)?, width, height)
    }

    fn matte_metadata(&self, layer: &str, name: &str) -> Result<Vec<(String, String)>, Error> {
        let Some(names) = self.job.film().mattes().names(matte_layer(layer)?) else { return Ok(Vec::new()) };
        let hex = |id: u32| format!("{id:08x}");
        let manifest: BTreeMap<&String, String> = names.iter().map(|(name, &id)| (name, hex(id))).collect();
        let key = &hex(cryptomatte::id(name))[..7];
        let said = [
            ("name", name.to_owned()),
            ("hash", "MurmurHash3_32".to_owned()),
            ("conversion", "uint32_to_float32".to_owned()),
            ("manifest", json!(manifest).to_string()),
        ];
        Ok(said.into_iter().map(|(what, value)| (format!("cryptomatte/{key}/{what}"), value)).collect())
    }

    fn stop(&self) {
        self.job.stop();
    }

    fn develop(&self, py: Python<'_>) -> Result<(), Error> {
        let Some((plan, camera)) = &self.strays else { return Ok(()) };
        let settings = self.job.settings();
        without_gil(py, || {
            if let Some(strays) = plan.strays(camera, [settings.width, settings.height])? {
                self.job.develop(&strays);
            }
            Ok(())
        })?
    }

    fn stop_developing(&self) {
        self.job.stop_developing();
    }

    fn stray<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let pass = StrayPass::ALL.into_iter().find(|pass| pass.name() == name);
        let pass = pass.ok_or_else(|| invalid(format!("no light strays by the name of '{name}'")))?;
        let pixels = without_gil(py, || self.job.stray_pass(pass).iter().map(|light| light.to_array()).collect())?;
        self.array_of_three(py, pixels)
    }

    fn end_checkpoints(&self, py: Python<'_>) -> Result<Option<Checkpoint>, Error> {
        Ok(without_gil(py, || self.job.end_checkpoints())?.map(Checkpoint))
    }

    fn stats_json(&self) -> String {
        let s = self.job.statistics();
        let strayed = self.job.strayed();
        let settings = self.job.settings();
        let timed = s.counts.sample_time.as_secs_f64();
        let lens_share = if timed > 0.0 { s.counts.camera_time.as_secs_f64() / timed } else { 0.0 };
        let mut seconds = json!({
            "bvh": self.job.stage().build_seconds,
            "plan": self.plan_seconds,
            "render": s.render_seconds,
        });
        if let Some(strayed) = &strayed {
            let times = strayed.times().map(|(pass, seconds)| (pass.name().to_lowercase(), seconds));
            seconds["strays"] = json!(times.collect::<BTreeMap<String, f64>>());
        }
        if let Some(lens) = self.job.camera().traced_lens() {
            seconds["pupil_map"] = json!(lens.map_seconds());
        }
        let precision = self.job.camera().traced_lens().map(|lens| {
            let chosen = lens.precision();
            json!({
                "asked": chosen.asked.name(),
                "chosen": chosen.name(),
                "f32_error_px": chosen.error_px.is_finite().then_some(chosen.error_px),
                "tolerance_px": TOLERANCE_PX,
            })
        });
        json!({
            "seconds": seconds,
            "trees_refitted": self.job.stage().accel.refitted(),
            "samples": s.samples,
            "samples_mean": s.mean_samples,
            "samples_most": s.most_samples,
            "camera_rays": s.counts.camera_rays,
            "camera_rays_lost": s.counts.camera_rays_lost,
            "wavelengths_carried": s.counts.wavelengths_carried,
            "rays": s.counts.rays,
            "lens_share": lens_share,
            "non_finite_samples": s.counts.non_finite,
            "seed": settings.seed,
            "threads": s.threads,
            "lens": self.job.camera().name(),
            "precision": precision,
            "pipeline": self.job.pipeline().name(),
            "integrator": settings.integrator.name(),
            "width": settings.width,
            "height": settings.height,
            "ghosts": strayed.and_then(|strayed| strayed.ghosts.clone()).map(|ghosts| json!({
                "sources": ghosts.sources,
                "found": ghosts.found,
                "simulated": ghosts.simulated,
                "left_out": ghosts.left_out,
            })),
            "failure": s.failure,
            "checkpoint": s.kept.map(|kept| json!({
                "resumed_samples": kept.resumed_samples,
                "resumed_seconds": kept.resumed_seconds,
                "written": kept.written,
                "longest_stop_s": kept.longest_stop_s,
                "problem": kept.problem,
            })),
        })
        .to_string()
    }
}

impl Job {
    fn array_of_three<'py>(&self, py: Python<'py>, pixels: Vec<[f32; 3]>) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let flat = PyArray1::from_vec(py, pixels.into_flattened());
        Ok(flat.reshape([height as usize, width as usize, 3])?)
    }
}

fn keeps_no_shadows() -> Error {
    invalid("the render keeps nothing for shadows: make it with catches=True")
}

fn matte_layer(name: &str) -> Result<MatteLayer, Error> {
    match name {
        "OBJECT" => Ok(MatteLayer::Object),
        "MATERIAL" => Ok(MatteLayer::Material),
        "ASSET" => Ok(MatteLayer::Asset),
        "OBJECT_INDEX" => Ok(MatteLayer::ObjectIndex),
        "MATERIAL_INDEX" => Ok(MatteLayer::MaterialIndex),
        other => {
            let names = "OBJECT, MATERIAL, ASSET, OBJECT_INDEX or MATERIAL_INDEX";
            Err(invalid(format!("there are no mattes of '{other}'; use {names}")))
        }
    }
}

fn array(py: Python<'_>, pixels: Vec<[f32; 4]>, width: u32, height: u32) -> Result<Bound<'_, PyArray3<f32>>, Error> {
    let flat = PyArray1::from_vec(py, pixels.into_flattened());
    Ok(flat.reshape([height as usize, width as usize, 4])?)
}
