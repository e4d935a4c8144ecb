//! Renders, watched from Python.

use crate::bake::{PyBake, request};
use crate::described::Described;
use crate::error::{Error, invalid, json};
use crate::files::{Checkpoint, os_error};
use crate::gil::without_gil;
use crate::parts::part;
use crate::plan::Plan;
use crate::scene::Scene;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use petzval_render::camera::CameraDescription;
use petzval_render::camera::shutter::Shutter;
use petzval_render::film;
use petzval_render::film::cryptomatte::{self, MatteLayer};
use petzval_render::film::data::DataPass;
use petzval_render::job::catcher::Laying;
use petzval_render::job::checkpoint::Checkpoints;
use petzval_render::job::denoise::Denoising;
use petzval_render::job::joining::KeepError;
use petzval_render::job::request::JobRequest;
use petzval_render::job::share::Share;
use petzval_render::job::{self as engine, Settings};
use petzval_render::stray::StrayPass;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

type PyTile<'py> = (u32, u32, u32, u32, Bound<'py, PyArray3<f32>>);

/// See the stub.
#[pyfunction]
#[pyo3(signature = (*, surfaces = false, vectors = false, mattes = false, halves = false, groups = 0))]
pub(crate) fn film_bytes_a_pixel(surfaces: bool, vectors: bool, mattes: bool, halves: bool, groups: usize) -> usize {
    film::bytes_a_pixel(surfaces, vectors, mattes, halves, groups)
}

/// See the stub.
#[pyfunction]
pub(crate) fn denoising_seconds(how: Described<Denoising>, pixels: usize, threads: usize) -> f64 {
    how.0.expected_seconds(pixels, threads)
}

/// One render of a scene: see the stub.
#[pyclass(frozen)]
pub(crate) struct Job {
    job: engine::Job,
}

#[pymethods]
impl Job {
    #[new]
    #[pyo3(signature = (
        scene, camera, settings, over_the_shutter=Vec::new(), *, plan=None, mattes=Vec::new(), matte_levels=6,
        neighbours=None, light_groups=0, parts=Vec::new(), mist=[0.0, 1.0, 1.0], catches=false, checkpoint=None,
        shutter=None, occlusion_distance=None, bake=None, share=[0, 1, 1]
    ))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword of Python")]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        camera: Described<CameraDescription>,
        settings: Described<Settings>,
        over_the_shutter: Vec<Described<CameraDescription>>,
        plan: Option<&Plan>,
        mattes: Vec<String>,
        matte_levels: u32,
        neighbours: Option<[Described<CameraDescription>; 2]>,
        light_groups: u16,
        parts: Vec<String>,
        mist: [f32; 3],
        catches: bool,
        checkpoint: Option<(PathBuf, String, f64)>,
        shutter: Option<Described<Shutter>>,
        occlusion_distance: Option<f32>,
        bake: Option<PyBake<'_>>,
        share: [u32; 3],
    ) -> Result<Self, Error> {
        let checkpoints = match checkpoint {
            Some((file, fingerprint, every_s)) => {
                let every = Duration::try_from_secs_f64(every_s)
                    .map_err(|_| invalid(format!("checkpoints every {every_s} s: name a time of 0 s or more")))?;
                Some(Checkpoints { file, fingerprint, every })
            }
            None => None,
        };
        let asked = JobRequest {
            camera: camera.0,
            over_the_shutter: over_the_shutter.into_iter().map(|d| d.0).collect(),
            neighbours: neighbours.map(|both| both.map(|d| d.0)),
            settings: settings.0,
            plan: plan.map(|plan| plan.plan.clone()),
            shutter: shutter.map(|shutter| shutter.0),
            mattes: mattes.iter().map(|name| matte_layer(name)).collect::<Result<_, _>>()?,
            matte_levels,
            light_groups,
            parts: parts.iter().map(|name| part(name)).collect::<Result<_, _>>()?,
            mist,
            catches,
            checkpoints,
            share: as_share(share),
            occlusion_distance,
            bake: bake.map(request).transpose()?,
        };
        let stage = scene.stage.clone();
        let job = without_gil(py, || engine::Job::request(stage, asked))??;
        Ok(Self { job })
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
        let pixels = without_gil(py, || self.job.on_threads(|| self.job.picture()))?;
        array(py, pixels, width, height)
    }

    #[pyo3(signature = (alone=None))]
    fn baked<'py>(&self, py: Python<'py>, alone: Option<&Self>) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let pixels = without_gil(py, || self.job.baked(alone.map(|alone| &alone.job)))?;
        let nothing = || invalid("the job bakes nothing, or shadows, for which it needs the bake of the object alone");
        array(py, pixels.ok_or_else(nothing)?, width, height)
    }

    fn data<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        if let Some(place) = ["REMAINDER", "REMAINDER_FINE"].iter().position(|known| *known == name) {
            // Denoised, or with stray light, the picture is no sum of samples.
            let rest = without_gil(py, || match self.job.is_denoised() || self.job.strayed().is_some() {
                true => vec![[[0.0; 4]; 2]; width as usize * height as usize],
                false => self.job.film().remainders(),
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
        let flat = PyArray1::from_vec(py, without_gil(py, || self.job.on_threads(|| self.job.data(pass)))?);
        Ok(flat.reshape([height as usize, width as usize, channels])?)
    }

    fn matte<'py>(&self, py: Python<'py>, layer: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let layer = matte_layer(layer)?;
        let film = self.job.film();
        let (width, height) = film.size();
        let channels = 4 * film.mattes().passes();
        let flat = PyArray1::from_vec(py, without_gil(py, || self.job.on_threads(|| self.job.matte(layer)))?);
        Ok(flat.reshape([height as usize, width as usize, channels])?)
    }

    fn light_group<'py>(&self, py: Python<'py>, number: usize) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let film = self.job.film();
        let group = number.checked_sub(1).and_then(|place| film.groups().get(place));
        let group = group.ok_or_else(|| invalid(format!("there is no light group of number {number}")))?;
        let (width, height) = film.size();
        let pixels = without_gil(py, || self.job.on_threads(|| group.picture()))?;
        array(py, pixels, width, height)
    }

    fn index<'py>(&self, py: Python<'py>, layer: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let layer = matte_layer(layer)?;
        let film = self.job.film();
        let (width, height) = film.size();
        let flat = PyArray1::from_vec(py, without_gil(py, || self.job.on_threads(|| film.most_seen(layer)))?);
        Ok(flat.reshape([height as usize, width as usize, 1])?)
    }

    fn part<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let asked = part(name)?;
        let pixels = without_gil(py, || self.job.on_threads(|| self.job.part(asked)))?;
        let pixels = pixels.ok_or_else(|| invalid(format!("'{name}' is not kept")))?;
        self.array_of_three(py, pixels)
    }

    fn shadow<'py>(&self, py: Python<'py>, alone: &Self) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let pixels = without_gil(py, || self.job.shadow(&alone.job))?;
        self.array_of_three(py, pixels.ok_or_else(keeps_no_shadows)?)
    }

    #[pyo3(signature = (alone, sky, *, is_opaque, is_apart, is_noisy=false))]
    fn over_photograph<'py>(
        &self,
        py: Python<'py>,
        alone: &Self,
        sky: Option<&Self>,
        is_opaque: bool,
        is_apart: bool,
        is_noisy: bool,
    ) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let laying = Laying { is_opaque, is_apart, is_noisy };
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
            ("manifest", json(&manifest)?),
        ];
        Ok(said.into_iter().map(|(what, value)| (format!("cryptomatte/{key}/{what}"), value)).collect())
    }

    fn stop(&self) {
        self.job.stop();
    }

    fn denoise(&self, py: Python<'_>, how: Described<Denoising>) -> Result<(), Error> {
        Ok(without_gil(py, || self.job.denoise(&how.0))??)
    }

    fn denoised_image<'py>(
        &self,
        py: Python<'py>,
        how: Described<Denoising>,
    ) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let pixels = without_gil(py, || self.job.denoised_picture(&how.0))??;
        array(py, pixels, width, height)
    }

    fn noisy_image<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let pixels = without_gil(py, || self.job.on_threads(|| self.job.noisy_picture()))?;
        array(py, pixels, width, height)
    }

    fn develop(&self, py: Python<'_>) -> Result<(), Error> {
        Ok(without_gil(py, || self.job.develop_as_planned())??)
    }

    fn stop_developing(&self) {
        self.job.stop_developing();
    }

    fn developed(&self) -> f64 {
        self.job.developed()
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

    fn write_film(&self, py: Python<'_>, file: PathBuf, fingerprint: &str) -> Result<(), Error> {
        match without_gil(py, || self.job.write_film(&file, fingerprint))? {
            Ok(()) => Ok(()),
            Err(KeepError::Io(error)) => Err(os_error(&error, &file).into()),
            Err(error) => Err(invalid(error.to_string())),
        }
    }

    fn join_film(
        &self,
        py: Python<'_>,
        file: PathBuf,
        fingerprint: &str,
        share: [u32; 3],
    ) -> Result<Option<String>, Error> {
        without_gil(py, || self.job.join_film(&file, fingerprint, as_share(share)))
    }

    fn stats_json(&self) -> Result<String, Error> {
        json(&self.job.report())
    }
}

impl Job {
    fn array_of_three<'py>(&self, py: Python<'py>, pixels: Vec<[f32; 3]>) -> Result<Bound<'py, PyArray3<f32>>, Error> {
        let (width, height) = self.job.film().size();
        let flat = PyArray1::from_vec(py, pixels.into_flattened());
        Ok(flat.reshape([height as usize, width as usize, 3])?)
    }
}

fn as_share([first, end, of]: [u32; 3]) -> Share {
    Share { first, end, of }
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
