//! Samples in stretches: the camera does its part for all of a stretch, then the rays are followed together.

use super::{Counts, RenderContext, Sample};
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::Camera;
use crate::camera::lens::real_lens::packet::Request;
use crate::film::TileAccumulator;
use crate::integrator::aimed::{AimedLights, AimedRay};
use crate::integrator::path::{AovBuffers, AovSink, NoAovs, SurfaceStart, Wavefront};
use crate::sampler::{KeptScramble, PathSampler};
use crate::scene::motion::{MIDDLE, moment};
use std::time::Instant;

/// Samples in a stretch. More fill the registers better; fewer stay in the nearest caches.
const STRETCH: usize = 512;
/// Samples that a camera is asked for at a time.
const ASKED: usize = 64;

/// A pipeline's requests of camera rays, and its use of the light along them.
pub(super) trait CameraSampler {
    /// A ray, and the pixels where its light counts.
    type Lead: Clone;

    /// Appends a lead for each request to camera number `camera`; `None` where it is lost in the lens.
    fn ask(&mut self, camera: usize, requests: &[Request], leads: &mut Vec<Option<Self::Lead>>);

    /// The ray into the scene.
    fn ray(lead: &Self::Lead) -> Ray;

    /// The surface where the ray ends; `None` where it is to be traced.
    fn start(_: &Self::Lead) -> Option<SurfaceStart> {
        None
    }

    /// The density of the ray's choice per unit of etendue; `None` where that is not known.
    fn density(&self, _camera: usize, _: &Self::Lead) -> Option<f32> {
        None
    }

    /// Number of wavelengths at which light of a sample is carried back through the lens of camera number `camera`.
    fn carried(&self, _camera: usize) -> usize {
        0
    }

    /// True if the surface that the ray hits is one that its pixel sees.
    fn sees_its_pixel(&self, _: &Request) -> bool {
        true
    }

    /// Adds the radiance that was found.
    fn add(&self, camera: usize, request: &Request, lead: &Self::Lead, radiance: Rgb, light: &mut TileAccumulator);
}

/// Follows `samples`, pixel and index, in their order. `None` where `stopped` said so.
pub(super) fn render<L: CameraSampler>(
    pipeline: L,
    shot: &RenderContext<'_>,
    samples: impl Iterator<Item = ([u32; 2], u32)>,
    light: &mut TileAccumulator,
    stopped: &dyn Fn() -> bool,
) -> Option<Counts> {
    let count = light.group_count().saturating_sub(shot.parts.list().len());
    let noted = || AovBuffers::new(count as u16, shot.parts.clone());
    match (light.group_count(), shot.stage.media.is_empty()) {
        (0, true) => follow(Wavefront::<_, false>::noting(NoAovs), pipeline, shot, samples, light, stopped),
        (_, true) => follow(Wavefront::<_, false>::noting(noted()), pipeline, shot, samples, light, stopped),
        (0, false) => follow(Wavefront::<_, true>::noting(NoAovs), pipeline, shot, samples, light, stopped),
        (_, false) => follow(Wavefront::<_, true>::noting(noted()), pipeline, shot, samples, light, stopped),
    }
}

#[expect(clippy::too_many_lines, reason = "one loop over batches: a kernel")]
fn follow<L: CameraSampler, N: AovSink, const VOLUMES: bool>(
    mut wave: Wavefront<N, VOLUMES>,
    mut pipeline: L,
    shot: &RenderContext<'_>,
    mut samples: impl Iterator<Item = ([u32; 2], u32)>,
    light: &mut TileAccumulator,
    stopped: &dyn Fn() -> bool,
) -> Option<Counts> {
    wave = wave.beside(shot.aimed.clone());
    let mut counts = Counts::default();
    let mut stretch = SampleBatch::default();
    let mut leads = Vec::with_capacity(STRETCH);
    let parts = shot.parts.list();
    let groups = light.group_count().saturating_sub(parts.len());
    loop {
        if stopped() {
            return None;
        }
        let start = Instant::now();
        stretch.fill(shot, samples.by_ref().take(STRETCH));
        if stretch.requests.is_empty() {
            return Some(counts);
        }
        stretch.ask(&mut pipeline, shot.cameras.len(), &mut leads);
        counts.camera_time += start.elapsed();
        wave.clear();
        if let Some(aimed) = &shot.aimed {
            for (i, (lead, sampler)) in leads.iter().zip(&stretch.samplers).enumerate() {
                let Some(lead) = lead else { continue };
                let ray = stretch.sent(shot, i, L::ray(lead));
                match pipeline.density(stretch.cameras[i], lead) {
                    Some(density) => wave.start_led(ray, density, sampler.clone()),
                    None => wave.start(ray, sampler.clone()),
                }
            }
            stretch.aim(shot, aimed, &mut wave);
        } else if let Some(exposure) = shot.exposure {
            for ((lead, sampler), time) in leads.iter().zip(&stretch.samplers).zip(&stretch.times) {
                if let Some(lead) = lead {
                    wave.start(exposure.sent(shot.seen(L::ray(lead)), moment(*time)), sampler.clone());
                }
            }
        } else {
            for (lead, sampler) in leads.iter().zip(&stretch.samplers) {
                let Some(lead) = lead else { continue };
                match L::start(lead) {
                    Some(start) => wave.start_at(start, L::ray(lead), sampler.clone()),
                    None => wave.start(shot.seen(L::ray(lead)), sampler.clone()),
                }
            }
        }
        wave.follow(shot.stage, &shot.limits);
        let mut path = 0;
        for (i, (request, lead)) in stretch.requests.iter().zip(&leads).enumerate() {
            let ([x, y], index) = (request.pixel, stretch.indices[i]);
            let mut s = Sample { shot, x, y, index, timed: None, counts: &mut counts, light };
            s.count_camera(lead.is_none());
            let Some(lead) = lead else {
                s.lost();
                continue;
            };
            s.counts.wavelengths_carried += pipeline.carried(stretch.cameras[i]) as u64;
            let found = wave.found(path);
            path += 1;
            if s.count_path(&found) {
                s.note_alpha(&found);
                let sees_its_pixel = pipeline.sees_its_pixel(request);
                if sees_its_pixel {
                    s.note_surface(&found, &L::ray(lead), request.u_wavelength);
                }
                pipeline.add(stretch.cameras[i], request, lead, found.radiance, light);
                let beside = wave.found_beside(path - 1).iter().enumerate();
                for (place, &radiance) in beside.filter(|(_, radiance)| **radiance != Rgb::ZERO) {
                    if place >= groups && parts[place - groups].is_data() {
                        if sees_its_pixel {
                            light.group(place).add(x, y, radiance);
                        }
                        continue;
                    }
                    pipeline.add(stretch.cameras[i], request, lead, radiance, light.group(place));
                }
            }
        }
        for aimed in &stretch.aimed {
            let found = wave.found(path);
            path += 1;
            counts.rays += u64::from(found.rays);
            if !found.radiance.is_finite() {
                counts.non_finite += 1;
                continue;
            }
            let Some(lens) = shot.cameras[0].traced_lens() else { continue };
            let add = |light: &mut TileAccumulator, radiance| {
                lens.expose(&aimed.splats, radiance, |x, y, colour| light.add_aimed(x, y, colour.truncate()));
            };
            add(light, found.radiance);
            for (place, &radiance) in wave.found_beside(path - 1).iter().enumerate() {
                if radiance != Rgb::ZERO && !(place >= groups && parts[place - groups].is_data()) {
                    add(light.group(place), radiance);
                }
            }
        }
        counts.sample_time += start.elapsed();
    }
}

/// Samples on their way to the camera.
#[derive(Default)]
struct SampleBatch {
    requests: Vec<Request>,
    indices: Vec<u32>,
    samplers: Vec<PathSampler>,
    cameras: Vec<usize>,
    /// The time of each sample, as a part of the exposure; empty where that does not matter.
    times: Vec<f32>,
    /// Rays from the lights.
    aimed: Vec<AimedRay>,
}

impl SampleBatch {
    fn fill(&mut self, shot: &RenderContext<'_>, samples: impl Iterator<Item = ([u32; 2], u32)>) {
        self.requests.clear();
        self.indices.clear();
        self.samplers.clear();
        self.cameras.clear();
        self.times.clear();
        self.aimed.clear();
        let mut at = [0; 2];
        let pattern = |pixel: [u32; 2]| {
            let [x, y] = shot.numbers_of(pixel);
            shot.pattern.pixel(x, y)
        };
        let mut points = pattern(at);
        let mut scrambles = [KeptScramble::default(); 2];
        let has_wavelengths = shot.cameras.iter().any(Camera::has_wavelengths);
        for (pixel, index) in samples {
            if pixel != at {
                (at, points) = (pixel, pattern(pixel));
            }
            let mut sampler = points.sampler(index);
            let [mut u0, mut u1, u2, u3] = sampler.next_4d_kept(&mut scrambles[0]);
            if shot.bake.is_some() && index == 0 {
                // As in Cycles: bakes of one sample show the middles of pixels.
                [u0, u1] = [0.5; 2];
            }
            let [u_wavelength, u_column, u_row, u_beyond] =
                if has_wavelengths { sampler.next_4d_kept(&mut scrambles[1]) } else { sampler.skipped_4d() };
            let place = shot.raster.place(pixel[0], pixel[1], [u0, u1]);
            let (u_place, u_lens, u_pixels) = ([u0, u1], [u2, u3], [u_column, u_row]);
            self.requests.push(Request { pixel, place, u_lens, u_wavelength, u_pixels, u_place, u_beyond });
            self.indices.push(index);
            self.samplers.push(sampler);
            if shot.is_timed() {
                let time = shot.time(pixel, index);
                self.cameras.push(shot.camera(time));
                self.times.push(time);
            } else {
                self.cameras.push(0);
            }
        }
    }

    /// The moment of sample `i`.
    fn moment(&self, i: usize) -> u16 {
        self.times.get(i).map_or(MIDDLE, |time| moment(*time))
    }

    /// The camera's ray of sample `i` as it goes into the scene.
    fn sent(&self, shot: &RenderContext<'_>, i: usize, ray: Ray) -> Ray {
        let seen = shot.seen(ray);
        shot.exposure.map_or(seen, |exposure| exposure.sent(seen, self.moment(i)))
    }

    /// Starts the rays of the lights that belong to the samples.
    fn aim<N: AovSink, const VOLUMES: bool>(
        &mut self,
        shot: &RenderContext<'_>,
        aimed: &AimedLights,
        wave: &mut Wavefront<N, VOLUMES>,
    ) {
        for i in 0..self.requests.len() {
            let number = shot.number(self.requests[i].pixel, self.indices[i]);
            let found = aimed.ray(shot.stage, shot.raster, number, self.moment(i));
            let Some((ray, sampler)) = found else { continue };
            wave.start_aimed(self.sent(shot, i, ray.ray), sampler, ray.source);
            self.aimed.push(ray);
        }
    }

    /// Fills `leads`, each from the camera of its own time.
    fn ask<L: CameraSampler>(&self, pipeline: &mut L, cameras: usize, leads: &mut Vec<Option<L::Lead>>) {
        leads.clear();
        if cameras == 1 {
            return self.requests.chunks(ASKED).for_each(|requests| pipeline.ask(0, requests, leads));
        }
        leads.resize(self.requests.len(), None);
        for camera in 0..cameras {
            let picked: Vec<usize> = (0..self.requests.len()).filter(|&i| self.cameras[i] == camera).collect();
            let requests: Vec<Request> = picked.iter().map(|&i| self.requests[i]).collect();
            let mut answers = Vec::with_capacity(picked.len());
            pipeline.ask(camera, &requests, &mut answers);
            picked.into_iter().zip(answers).for_each(|(i, answer)| leads[i] = answer);
        }
    }
}
