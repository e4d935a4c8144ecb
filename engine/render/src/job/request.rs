//! A render as it is asked for: descriptions, settings, a plan and outputs become the arguments of a [`Job`].

use super::bake::{BakeRequest, Prepared};
use super::checkpoint::Checkpoints;
pub use super::error::RequestError;
use super::forecast::{self, Forecast};
use super::share::Share;
use super::{Job, OutputOptions, Settings, catcher};
use crate::camera::clip::Clip;
use crate::camera::shutter::{Exposure, Shutter};
use crate::camera::tools::imaging::Imaging;
use crate::camera::tools::shade;
use crate::camera::{Camera, CameraDescription, CameraError};
use crate::film::cryptomatte::MatteLayer;
use crate::integrator::path::parts::{LightPass, Parts, Seen};
use crate::integrator::{Integrator, PreparedScene};
use crate::pipeline::motion::Motion;
use crate::pipeline::{Pipeline, aiming};
use crate::plan::report::{PlanReport, Predicted};
use crate::plan::{LensNeed, Plan, PlanError, PlanOptions};
use glam::DVec3;
use std::sync::Arc;

/// All that decides a render, but its scene. The default camera has no lens.
#[derive(Default)]
pub struct JobRequest {
    /// The camera in the middle of the exposure, before its plan.
    pub camera: CameraDescription,
    /// The camera at the middles of equal parts of the exposure, where it changes meanwhile; else empty.
    pub over_the_shutter: Vec<CameraDescription>,
    /// The camera a frame before and a frame after, for [`crate::film::data::DataPass::Vector`].
    pub neighbours: Option<[CameraDescription; 2]>,
    /// The settings of the render itself.
    pub settings: Settings,
    /// The effects that are simulated; `None`: the camera as it is described.
    pub plan: Option<Plan>,
    /// The shutter, where anything but the lens moves.
    pub shutter: Option<Shutter>,
    /// The mattes that are kept.
    pub mattes: Vec<MatteLayer>,
    /// Names that a pixel of a matte holds.
    pub matte_levels: u32,
    /// Number of light groups.
    pub light_groups: u16,
    /// The parts of light that are kept.
    pub parts: Vec<LightPass>,
    /// Start and depth of the mist, Blender units, and the power of its falloff.
    pub mist: [f32; 3],
    /// True to keep the parts that [`Job::shadow`] and [`Job::over_photograph`] need.
    pub catches: bool,
    /// The file in which the render is kept while it goes on.
    pub checkpoints: Option<Checkpoints>,
    /// The tiles that are rendered.
    pub share: Share,
    /// Length of the rays of the ambient occlusion pass, Blender units; `None`: without end.
    pub occlusion_distance: Option<f32>,
    /// The surface that is baked instead of a photograph: plan, shutter, mattes and groups then count nothing, and parts only guide a denoiser.
    pub bake: Option<BakeRequest>,
}

impl Job {
    /// Starts a render in threads of its own.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn request(stage: Arc<PreparedScene>, mut asked: JobRequest) -> Result<Self, RequestError> {
        if let Some(bake) = asked.bake.take() {
            return Self::bake(stage, bake, asked);
        }
        let origin = stage.scene.origin;
        // All read one lens file, once.
        let beside = |d: CameraDescription| d.reading_with(&asked.camera);
        let over_the_shutter: Vec<_> = asked.over_the_shutter.into_iter().map(beside).collect();
        let neighbours = asked.neighbours.map(|both| both.map(beside));
        let size = [asked.settings.width, asked.settings.height];
        let is_moving = asked.plan.as_ref().is_none_or(|plan| plan.camera.is_moving);
        let planned = |d: &CameraDescription| asked.plan.as_ref().map_or_else(|| d.clone(), |plan| plan.applied(d));
        let now = planned(&asked.camera);
        let descriptions = match over_the_shutter.as_slice() {
            moving @ [_, ..] if is_moving => moving.iter().map(planned).collect(),
            _ => vec![now.clone()],
        };
        let camera = |d: &CameraDescription| Camera::new(d, size[0], size[1]);
        let cameras = descriptions.iter().map(camera).collect::<Result<Vec<Camera>, _>>()?;

        let mut settings = asked.settings;
        if let Some(plan) = &asked.plan {
            // What was left open is decided again by the camera, which the plan has chosen.
            if !matches!(settings.pipeline, Pipeline::Auto | Pipeline::Hero) {
                settings.pipeline = plan.pipeline();
            }
        }
        let mut passes = asked.parts;
        if asked.catches {
            passes.extend(catcher::PARTS);
        }
        let seen = Seen::by(now.matrix_world, origin, matches!(cameras[0], Camera::Orthographic(_)), asked.mist);
        let output = OutputOptions {
            mattes: asked.mattes,
            matte_levels: asked.matte_levels,
            motion: motion(&now, neighbours.as_ref(), size, origin)?,
            clip: Clip::new(&now, &cameras[0]),
            gains: shade::gains(&now, &cameras[cameras.len() / 2], size[0], size[1])?,
            light_groups: asked.light_groups,
            parts: Parts::new(&passes, seen).occluded_within(asked.occlusion_distance),
            checkpoints: asked.checkpoints,
            share: asked.share,
            exposure: exposure(asked.shutter.as_ref().filter(|_| is_moving), &now, origin),
            bake: None,
        };
        let stray_light = asked.plan.map(|plan| (plan, asked.camera));
        let mut job = Self::start_with(stage, cameras, settings, output)?;
        job.stray_light = stray_light;
        Ok(job)
    }
}

impl Job {
    /// Starts a bake in threads of its own.
    fn bake(stage: Arc<PreparedScene>, bake: BakeRequest, asked: JobRequest) -> Result<Self, RequestError> {
        let JobRequest { camera, settings, parts, occlusion_distance, .. } = asked;
        let Prepared { settings, output, baked } =
            bake.prepared(&stage, &camera, settings, parts, occlusion_distance)?;
        let camera = Camera::new(&camera, settings.width, settings.height)?;
        let mut job = Self::start_with(stage, vec![camera], settings, output)?;
        job.baked = Some(baked);
        Ok(job)
    }
}

impl Settings {
    /// The plan of a render with these settings, whose pipeline goes before that of `options`. `moving` is the camera at times over which
    /// the shutter is open, if the lens changes meanwhile; `shutter`: where anything but the lens moves.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn plan(
        &self,
        stage: &PreparedScene,
        d: &CameraDescription,
        moving: &[CameraDescription],
        mut options: PlanOptions,
        shutter: Option<&Shutter>,
    ) -> Result<Plan, PlanError> {
        options.pipeline = self.pipeline;
        // Small lights need rays that go both ways.
        let is_wanted = || self.light_tracing && aiming::may_be_worth_it_through(stage, d, [self.width, self.height]);
        let lens_need = match self.integrator {
            Integrator::Bidirectional => LensNeed::Required,
            Integrator::Path if is_wanted() => LensNeed::Wanted,
            Integrator::Path => LensNeed::None,
        };
        let exposure = shutter.map(|shutter| Exposure::of(shutter, stage.scene.origin));
        Plan::new(stage, d, moving, [self.width, self.height], &options, lens_need, exposure.as_ref())
    }

    /// The report of a plan with a forecast of the render: a little of it is rendered.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn forecast(
        self,
        plan: &Plan,
        stage: Arc<PreparedScene>,
        d: &CameraDescription,
    ) -> Result<PlanReport, RequestError> {
        let (applied, samples) = (plan.applied(d), self.samples);
        let settings = Self { pipeline: plan.pipeline(), ..self };
        let camera = Camera::new(&applied, settings.width, settings.height)?;
        let output = OutputOptions { clip: Clip::new(&applied, &camera), ..OutputOptions::default() };
        let made = Forecast::new(stage.clone(), vec![camera], settings.clone(), output)?;
        let Forecast { seconds, threads, camera_part, .. } = made;
        let measured = forecast::stray_light(plan, stage, d, settings)?;
        Ok(plan.report_with(Predicted { seconds, after_seconds: 0.0, samples, threads, camera_part }, &measured))
    }
}

/// The motion between two frames; `None` where no frames beside this one are known.
fn motion(
    now: &CameraDescription,
    neighbours: Option<&[CameraDescription; 2]>,
    [width, height]: [u32; 2],
    origin: DVec3,
) -> Result<Option<Motion>, CameraError> {
    let Some([before, after]) = neighbours else { return Ok(None) };
    let imaging = |d: &CameraDescription| Imaging::new(d, width, height, origin);
    let beside = [imaging(before)?, imaging(after)?];
    Ok(Some(Motion::new(imaging(now)?, beside, width, height)))
}

/// The exposure of a camera that may stand beside render space's origin; `None` where nothing moves, and it stands there.
fn exposure(shutter: Option<&Shutter>, now: &CameraDescription, origin: DVec3) -> Option<Exposure> {
    let beside = now.position() - origin;
    match shutter.map(|shutter| Exposure::of(shutter, origin)) {
        None if beside == DVec3::ZERO => None,
        exposure => Some(exposure.unwrap_or_default().displaced(beside)),
    }
}
