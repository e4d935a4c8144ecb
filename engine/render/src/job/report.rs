//! The report of a render: the file of `petzval render --stats`.

use super::{Job, Kept};
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::precision::TOLERANCE_PX;
use crate::pipeline::aiming::AimedReport;
use crate::stray::ghosts;
use serde::Serialize;
use std::collections::BTreeMap;

/// Times, counts and decisions of a render so far.
#[derive(Clone, Debug, Serialize)]
pub struct RenderReport {
    /// Wall times by phase, s.
    pub seconds: Seconds,
    /// Number of BVHs that were refitted instead of built.
    pub trees_refitted: usize,
    /// Samples that every pixel has.
    pub samples: u32,
    /// Samples of a pixel, the mean.
    pub samples_mean: f64,
    /// Samples of the pixel that has most.
    pub samples_most: u32,
    /// Camera rays that were asked for, lost ones included.
    pub camera_rays: u64,
    /// Camera rays that the lens stopped.
    pub camera_rays_lost: u64,
    /// Wavelengths that camera rays carried.
    pub wavelengths_carried: u64,
    /// Rays in the scene.
    pub rays: u64,
    /// Part of the time in the lens.
    pub lens_share: f64,
    /// Samples that were not finite and were left out.
    pub non_finite_samples: u64,
    /// Seed of all random choices.
    pub seed: u32,
    /// Number of threads that rendered.
    pub threads: usize,
    /// Name of the camera's lens or model.
    pub lens: String,
    /// Precision of the rays in a lens that is traced.
    pub precision: Option<PrecisionReport>,
    /// Name of the pipeline.
    pub pipeline: &'static str,
    /// Name of the integrator.
    pub integrator: &'static str,
    /// Lights that send rays to the lens.
    pub light_tracing: AimedReport,
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Ghosts, once they are simulated.
    pub ghosts: Option<ghosts::GhostReport>,
    /// The failure of a thread.
    pub failure: Option<String>,
    /// Keeping and resuming the render, where it is asked for.
    pub checkpoint: Option<Kept>,
}

/// Wall times of the work on a render, s.
#[derive(Clone, Debug, Serialize)]
pub struct Seconds {
    /// Preparation of the scene: displacement, BVHs, lights, media and tables.
    pub bvh: f64,
    /// Planning of effects, before the render; 0 without a plan.
    pub plan: f64,
    /// The samples, from the start to now or to the end.
    pub render: f64,
    /// Denoising, once it is done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub denoise: Option<f64>,
    /// Stray light, by kind, once it is found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strays: Option<BTreeMap<String, f64>>,
    /// The pupil map of a lens that is traced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pupil_map: Option<f64>,
}

/// The precision of a lens's rays.
#[derive(Clone, Debug, Serialize)]
pub struct PrecisionReport {
    /// The precision that was asked for.
    pub asked: &'static str,
    /// The precision that was chosen.
    pub chosen: &'static str,
    /// Largest displacement of a ray by single precision, pixels; `None` where single precision cannot be used.
    pub f32_error_px: Option<f64>,
    /// Displacement up to which single precision is chosen, pixels.
    pub tolerance_px: f64,
}

impl PrecisionReport {
    fn new(lens: &RealLens) -> Self {
        let chosen = lens.precision();
        Self {
            asked: chosen.asked.name(),
            chosen: chosen.name(),
            f32_error_px: chosen.error_px.is_finite().then_some(chosen.error_px),
            tolerance_px: TOLERANCE_PX,
        }
    }
}

impl Job {
    /// The report so far.
    pub fn report(&self) -> RenderReport {
        let statistics = self.statistics();
        let (counts, settings, camera) = (statistics.counts, self.settings(), self.camera());
        let stray_light = self.strayed();
        let timed_s = counts.sample_time.as_secs_f64();
        RenderReport {
            seconds: Seconds {
                bvh: self.stage().build_seconds,
                plan: self.stray_light.as_ref().map_or(0.0, |(plan, _)| plan.seconds),
                render: statistics.render_seconds,
                denoise: self.denoise_seconds(),
                strays: stray_light
                    .as_ref()
                    .map(|found| found.times().map(|(pass, seconds)| (pass.name().to_lowercase(), seconds)).collect()),
                pupil_map: camera.traced_lens().map(RealLens::map_seconds),
            },
            trees_refitted: self.stage().accel.refitted(),
            samples: statistics.samples,
            samples_mean: statistics.mean_samples,
            samples_most: statistics.most_samples,
            camera_rays: counts.camera_rays,
            camera_rays_lost: counts.camera_rays_lost,
            wavelengths_carried: counts.wavelengths_carried,
            rays: counts.rays,
            lens_share: if timed_s > 0.0 { counts.camera_time.as_secs_f64() / timed_s } else { 0.0 },
            non_finite_samples: counts.non_finite,
            seed: settings.seed,
            threads: statistics.threads,
            lens: camera.name().to_owned(),
            precision: camera.traced_lens().map(PrecisionReport::new),
            pipeline: self.pipeline().name(),
            integrator: settings.integrator.name(),
            light_tracing: self.shared.aimed.get().map(|(_, report)| report.clone()).unwrap_or_default(),
            width: settings.width,
            height: settings.height,
            ghosts: stray_light.and_then(|found| found.ghosts.clone()),
            failure: statistics.failure,
            checkpoint: statistics.kept,
        }
    }
}
