//! A forecast of a render's time, from rendering a little of it: tiles all over the picture, on as many threads.

use super::error::RequestError;
use super::{Job, OutputOptions, Settings, SettingsError, Shared};
use crate::camera::clip::Clip;
use crate::camera::{Camera, CameraDescription};
use crate::integrator::PreparedScene;
use crate::pipeline::{Counts, Pipeline, render_tile};
use crate::plan::{Effect, Plan};
use crate::stray::StrayPass;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Tiles that are rendered.
const TILES: usize = 12;
/// Samples of a pixel in a row: a render takes more at a time, and the first of them is the slowest.
const PER_PIXEL: u32 = 4;
/// Number of tiles that each thread renders before the clock starts: memory is not there yet, caches and branches know
/// nothing.
const WARM_UP: usize = 2;
/// Least time that the clock runs, so that its own noise is small.
const LEAST: Duration = Duration::from_millis(40);
/// Most time that the clock runs, on scenes where a path takes very long.
const MOST: Duration = Duration::from_millis(120);

/// The forecast time of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Wall time of the samples, s.
    pub seconds: f64,
    /// Samples of the rendered part of the picture; where pixels get as many as they need, the most.
    pub samples: u64,
    /// Number of threads that the time holds for.
    pub threads: usize,
    /// The part of a thread's time in the camera.
    pub camera_part: f64,
    /// The pipeline by which the samples are made.
    pub pipeline: Pipeline,
}

impl Forecast {
    /// Renders a little of the picture of [`super::Job::start_with`] with the same arguments, and discards it.
    ///
    /// # Errors
    /// [`SettingsError`].
    pub fn new(
        stage: Arc<PreparedScene>,
        cameras: Vec<Camera>,
        settings: Settings,
        beside: OutputOptions,
    ) -> Result<Self, SettingsError> {
        let threads = settings.thread_count();
        let samples = u64::from(settings.samples);
        let shared = Shared::new(stage, cameras, settings, beside)?;
        let pixels = |tile: &usize| u64::from(shared.film.rect(*tile).width * shared.film.rect(*tile).height);
        let all = samples * shared.tiles.iter().map(pixels).sum::<u64>();
        let shot = shared.shot();
        let tiles: Vec<usize> = (0..TILES + WARM_UP).map(|i| shared.tile(i)).collect();
        let next = AtomicUsize::new(0);
        let done: Mutex<(Counts, u64)> = Mutex::default();
        let render = |tile: usize, index: u32| {
            let (mut light, rect) = (shared.film.patch(tile), shared.film.rect(tile));
            let counts = render_tile(&shot, rect, [index * PER_PIXEL, PER_PIXEL], &mut light, &|| false);
            (counts.unwrap_or_default(), u64::from(rect.width * rect.height * PER_PIXEL))
        };
        let mut wall = Duration::ZERO;
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    for &tile in &tiles[..WARM_UP] {
                        render(tile, 0);
                    }
                });
            }
        });
        let start = Instant::now();
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads)
                .map(|_| {
                    scope.spawn(|| {
                        loop {
                            let task = next.fetch_add(1, Ordering::Relaxed);
                            let (round, tile) = (task / TILES, task % TILES);
                            // Whole rounds, if there is time: the tiles differ.
                            let is_over = start.elapsed() > if round == 0 { MOST } else { LEAST };
                            if is_over {
                                return start.elapsed();
                            }
                            let (counts, samples) = render(tiles[WARM_UP + tile], round as u32);
                            let mut sum = done.lock().unwrap_or_else(PoisonError::into_inner);
                            sum.0.add(&counts);
                            sum.1 += samples;
                        }
                    })
                })
                .collect();
            // The mean of when they ended: some end while others still work.
            let ends: Vec<Duration> = workers.into_iter().filter_map(|worker| worker.join().ok()).collect();
            wall = ends.iter().sum::<Duration>() / ends.len().max(1) as u32;
        });
        let (counts, samples) = *done.lock().unwrap_or_else(PoisonError::into_inner);
        let timed = counts.sample_time.as_secs_f64();
        Ok(Self {
            seconds: wall.as_secs_f64() * all as f64 / samples.max(1) as f64,
            samples: all,
            threads,
            camera_part: if timed > 0.0 { counts.camera_time.as_secs_f64() / timed } else { 0.0 },
            pipeline: shared.pipeline,
        })
    }
}

/// Pixels of the picture by which the time of stray light is forecast, and samples of each.
const SMALL_PX: f64 = 16_000.0;
const SMALL_SAMPLES: u32 = 4;

/// The forecast wall time of each effect that the plan computes once the samples are there, s: a small picture is rendered, its bright places
/// are the sources of ghosts, and some of these are traced.
///
/// # Errors
/// [`RequestError`].
pub fn stray_light(
    plan: &Plan,
    stage: Arc<PreparedScene>,
    d: &CameraDescription,
    settings: Settings,
) -> Result<Vec<(Effect, f64)>, RequestError> {
    let size = [settings.width, settings.height];
    let Some(strays) = plan.strays(d, size)? else { return Ok(Vec::new()) };
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    let scale = (SMALL_PX / pixels).sqrt().min(1.0);
    let [width, height] = size.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
    let applied = plan.applied(d);
    let camera = Camera::new(&applied, width, height)?;
    let output = OutputOptions { clip: Clip::new(&applied, &camera), ..OutputOptions::default() };
    let samples = settings.samples.min(SMALL_SAMPLES);
    let small = Settings { width, height, samples, noise_threshold: 0.0, window: None, with_data: false, ..settings };
    let of_small = plan.strays(d, [width, height])?.unwrap_or_default();
    let job = Job::start_with(stage, vec![camera], small, output)?;
    job.wait(Duration::MAX);
    let times = job.expected_times(&strays, &of_small);
    let effect = |(pass, seconds): (StrayPass, f64)| {
        let effect = match pass {
            StrayPass::Ghosts => Effect::Ghosts,
            StrayPass::Glare => Effect::Glare,
            StrayPass::Diffraction => Effect::Diffraction,
        };
        (effect, seconds)
    };
    Ok(times.into_iter().map(effect).collect())
}

impl Shared {
    /// The number of a tile: all of them spread evenly over the rendered part.
    fn tile(&self, i: usize) -> usize {
        let place = (0.5 + 0.618_033_988_75 * i as f64).fract();
        self.tiles[(place * self.tiles.len() as f64) as usize]
    }
}
