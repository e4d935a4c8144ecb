//! A render: raw settings become checked ones, threads share out the tiles, and the outside watches and may stop it.
//!
//! The picture is refined in passes over all tiles. A tile's passes are added in order, whichever threads make
//! them, so that the same seed gives the same bits for any number of threads.

mod adaptive;
mod aimed;
pub mod bake;
pub mod catcher;
pub mod checkpoint;
pub mod denoise;
mod develop;
mod error;
mod film_file;
pub mod forecast;
pub mod joining;
mod parts;
mod remaining;
mod report;
pub mod request;
mod settings;
pub mod share;

use crate::camera::clip::Clip;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::shutter::Exposure;
use crate::camera::{Camera, CameraDescription};
use crate::film::cryptomatte::{MatteLayer, Mattes};
use crate::film::data::{DataPass, FARTHEST, VectorSums};
use crate::film::{Film, FilmChannels, TilePixels};
use crate::integrator::aimed::AimedLights;
use crate::integrator::path::parts::Parts;
use crate::integrator::path::{self, Limits};
use crate::integrator::{Integrator, PreparedScene, bidirectional::Techniques};
use crate::pipeline::aiming::AimedReport;
use crate::pipeline::bake::BakePoints;
use crate::pipeline::motion::Motion;
use crate::pipeline::{Counts, Pipeline, RenderContext, render_pixels, render_tile};
use crate::plan::Plan;
use crate::sampler::{PathSampler, raster::Raster, warp::PixelFilter};
use crate::stray::StrayLight;
use adaptive::Adaptive;
use checkpoint::{Checkpoints, Keeper, Kept, OwnFile};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
pub use report::RenderReport;
pub use settings::{MIN_SAMPLES, Settings, SettingsError};
use share::Share;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError, RwLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The most samples a pixel gets in one pass. More cost less overhead; fewer show a picture and stop sooner.
const MOST_PER_PASS: u32 = 16;

/// The results of a render beside the picture and [`Settings::with_data`].
#[derive(Default)]
pub struct OutputOptions {
    /// The mattes for [`Job::matte`].
    pub mattes: Vec<MatteLayer>,
    /// Names that a pixel of a matte holds.
    pub matte_levels: u32,
    /// The motion for [`DataPass::Vector`].
    pub motion: Option<Motion>,
    /// The clip planes of the camera's rays; `None`: none.
    pub clip: Option<Clip>,
    /// Factor of each pixel's light, rows from below; `None`: one ([`crate::camera::tools::shade`]).
    pub gains: Option<Vec<f32>>,
    /// Groups of emitters, from number 1 on, for [`Film::groups`]; bidirectional paths leave them black.
    pub light_groups: u16,
    /// The parts for [`Job::part`]; bidirectional paths leave them black.
    pub parts: Parts,
    /// The file in which the render is kept while it goes on, and from which it is resumed; `None`: none.
    pub checkpoints: Option<Checkpoints>,
    /// Times of the samples, and places of the camera; `None`: all in the middle of the exposure, but for changes of the lens.
    pub exposure: Option<Exposure>,
    /// The points of a surface that are baked instead of a photograph; no other output is about the camera then.
    pub bake: Option<BakePoints>,
    /// The tiles that are rendered of those that the picture has.
    pub share: Share,
}

impl OutputOptions {
    /// The data that the film of a render keeps.
    fn channels(&self, stage: &PreparedScene, settings: &Settings) -> FilmChannels {
        FilmChannels {
            surfaces: settings.with_data,
            vectors: self.motion.is_some(),
            mattes: Mattes::new(&stage.scene, &self.mattes, self.matte_levels),
            halves: settings.noise_threshold > 0.0,
            groups: self.light_groups,
            parts: self.parts.list().len(),
            variance: true,
        }
    }
}

/// Statistics of a render.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Wall time from the start to now or to the end, s.
    pub render_seconds: f64,
    /// Samples that every pixel has.
    pub samples: u32,
    /// The mean over the pixels.
    pub mean_samples: f64,
    /// Samples of the pixel that has most.
    pub most_samples: u32,
    /// Counts over all threads.
    pub counts: Counts,
    /// Number of threads used.
    pub threads: usize,
    /// The failure of a thread; the picture then holds the samples before it.
    pub failure: Option<String>,
    /// Statistics of keeping and resuming the render; `None` if not asked for.
    pub kept: Option<Kept>,
}

/// State that the threads share.
struct Shared {
    stage: Arc<PreparedScene>,
    cameras: Vec<Camera>,
    settings: Settings,
    pipeline: Pipeline,
    raster: Raster,
    clip: Option<Clip>,
    motion: Option<Motion>,
    exposure: Option<Exposure>,
    bake: Option<BakePoints>,
    parts: Parts,
    /// Limits of light transport, found by the first thread that asks.
    limits: OnceLock<Limits>,
    /// The lights that send rays to the lens, and the decision on them, found likewise.
    aimed: OnceLock<(Option<Arc<AimedLights>>, AimedReport)>,
    film: Film,
    /// The tiles that are rendered, in their order, where these have as many samples as others.
    tiles: Vec<usize>,
    share: Share,
    /// The tiles of the share, in their order.
    own: Vec<usize>,
    /// First sample and count of each pass.
    passes: Vec<(u32, u32)>,
    /// The decisions by which pixels get as many samples as they need; `None` where all get as many.
    adaptive: Option<Adaptive>,
    /// Held by the thread that decides for all blocks.
    deciding: Mutex<()>,
    next: AtomicUsize,
    stop: AtomicBool,
    counts: Mutex<Counts>,
    failure: Mutex<Option<String>>,
    /// Whoever adds a tile's pass shares it; who keeps the whole film has it alone.
    gate: RwLock<()>,
    keeper: Option<Keeper>,
    strayed: Mutex<Option<Arc<StrayLight>>>,
    denoised: Mutex<Option<Arc<denoise::Denoised>>>,
    stop_developing: AtomicBool,
    /// The bits of the part of the stray light that is found, or of the picture that is denoised.
    developed: AtomicU64,
    running: Mutex<usize>,
    ended: Condvar,
    started: Instant,
    ended_at: Mutex<Option<Duration>>,
}

/// A render under way.
pub struct Job {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// The thread that writes checkpoints, if there is one.
    keeping: Mutex<Option<JoinHandle<()>>>,
    /// The plan that decides on stray light, and the camera before it.
    stray_light: Option<(Plan, CameraDescription)>,
    /// The bake that the film keeps.
    baked: Option<bake::Baked>,
}

impl Job {
    /// Starts rendering in threads of its own.
    ///
    /// # Errors
    /// [`SettingsError`].
    pub fn start(stage: Arc<PreparedScene>, camera: Camera, settings: Settings) -> Result<Self, SettingsError> {
        Self::start_moving(stage, vec![camera], settings)
    }

    /// Starts rendering with a camera that changes while the shutter is open: `cameras` has its states at times that lie evenly over the
    /// exposure, each the middle of an equal part. Every sample has one of them.
    ///
    /// # Errors
    /// [`SettingsError`], also if there is no camera.
    pub fn start_moving(
        stage: Arc<PreparedScene>,
        cameras: Vec<Camera>,
        settings: Settings,
    ) -> Result<Self, SettingsError> {
        Self::start_with(stage, cameras, settings, OutputOptions::default())
    }

    /// Starts rendering like [`Self::start_moving`], with more to be found: `beside`.
    ///
    /// # Errors
    /// [`SettingsError`].
    pub fn start_with(
        stage: Arc<PreparedScene>,
        cameras: Vec<Camera>,
        settings: Settings,
        beside: OutputOptions,
    ) -> Result<Self, SettingsError> {
        let threads = settings.thread_count();
        let shared = Arc::new(Shared::new(stage, cameras, settings, beside)?);
        let start = |work: fn(&Shared)| {
            let shared = shared.clone();
            std::thread::spawn(move || work(&shared))
        };
        let threads = (0..threads).map(|_| start(Shared::work)).collect();
        let keeping = Mutex::new(shared.keeper.is_some().then(|| start(Shared::keep)));
        Ok(Self { shared, threads, keeping, stray_light: None, baked: None })
    }

    /// Waits, after the end, until the last checkpoint is written. The checkpoint that this render has written or taken up; `None`
    /// where there is none. The caller deletes it when the picture is safe.
    pub fn end_checkpoints(&self) -> Option<OwnFile> {
        if let Some(thread) = lock(&self.keeping).take() {
            // It reports what goes wrong, and does not panic.
            let _ = thread.join();
        }
        self.shared.keeper.as_ref().and_then(Keeper::own_file)
    }

    /// Waits until the render has ended or `timeout` is over; true if it has ended.
    pub fn wait(&self, timeout: Duration) -> bool {
        let running = lock(&self.shared.running);
        let (running, _) =
            self.shared.ended.wait_timeout_while(running, timeout, |n| *n > 0).unwrap_or_else(PoisonError::into_inner);
        *running == 0
    }

    /// Asks the threads to stop; finished samples stay. Returns at once.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// The part of the work that is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        if let Some(adaptive) = &self.shared.adaptive {
            return adaptive.progress();
        }
        let tiles = self.shared.own.len().max(1);
        let taken = self.shared.next.load(Ordering::Relaxed).min(self.shared.passes.len() * tiles);
        // Passes are unequal: count samples.
        let whole: u32 = self.shared.passes[..taken / tiles].iter().map(|p| p.1).sum();
        let part = self.shared.passes.get(taken / tiles).map_or(0.0, |p| p.1 as f32 * (taken % tiles) as f32);
        (whole as f32 + part / tiles as f32) / self.shared.settings.samples as f32
    }

    /// Samples that every pixel has which is not to have fewer.
    pub fn samples_done(&self) -> u32 {
        let Some(adaptive) = &self.shared.adaptive else {
            let samples = self.shared.own.iter().map(|&tile| self.shared.film.tile(tile).samples);
            return samples.min().unwrap_or(0);
        };
        let pass = self.shared.next.load(Ordering::Relaxed) / self.shared.own.len().max(1);
        adaptive.passes.get(pass).map_or(self.shared.settings.samples, |pass| pass.first)
    }

    /// The film to which the samples are added.
    pub fn film(&self) -> &Film {
        &self.shared.film
    }

    /// A pass of data as it is now, its channels pixel by pixel, rows from below.
    pub fn data(&self, pass: DataPass) -> Vec<f32> {
        let origin = self.shared.stage.scene.origin.as_vec3();
        let film = &self.shared.film;
        let surfaces = || film.data().into_par_iter().map(|sums| sums.mean());
        let of_three = |surface: &(dyn Fn((Vec3, Vec3)) -> Vec3 + Sync)| {
            let values: Vec<_> = surfaces().map(|s| s.map_or([0.0; 3], |found| surface(found).to_array())).collect();
            values.into_flattened()
        };
        match pass {
            DataPass::Depth => {
                surfaces().map(|s| s.map_or(FARTHEST, |(position, _)| self.camera().depth(position))).collect()
            }
            DataPass::Position => of_three(&|(position, _)| position + origin),
            DataPass::Samples => film.sample_counts().into_iter().map(|n| n as f32).collect(),
            DataPass::Vector => film.vectors().par_iter().map(VectorSums::mean).collect::<Vec<_>>().into_flattened(),
            DataPass::Normal => of_three(&|(_, normal)| normal),
        }
    }

    /// A layer of mattes as it is now: the channels of all its passes pixel by pixel, rows from below.
    pub fn matte(&self, layer: MatteLayer) -> Vec<f32> {
        self.shared.film.matte(layer)
    }

    /// The tiles that changed since the last call.
    pub fn take_tiles(&self) -> Vec<TilePixels> {
        self.shared.film.take_changed()
    }

    /// The camera in the middle of the exposure.
    pub fn camera(&self) -> &Camera {
        let cameras = &self.shared.cameras;
        &cameras[cameras.len() / 2]
    }

    /// The way that light is followed.
    pub fn pipeline(&self) -> Pipeline {
        self.shared.pipeline
    }

    /// The settings with which the render was started.
    pub fn settings(&self) -> &Settings {
        &self.shared.settings
    }

    /// The prepared scene that is rendered.
    pub fn stage(&self) -> &PreparedScene {
        &self.shared.stage
    }

    /// The statistics so far.
    pub fn statistics(&self) -> Statistics {
        let ended = *lock(&self.shared.ended_at);
        let counts = self.shared.film.sample_counts();
        let sum: f64 = counts.iter().copied().map(f64::from).sum();
        let area =
            |tile: &usize| self.shared.film.rect(*tile).width as usize * self.shared.film.rect(*tile).height as usize;
        let pixels: usize = self.shared.tiles.iter().map(area).sum();
        Statistics {
            render_seconds: ended.unwrap_or_else(|| self.shared.started.elapsed()).as_secs_f64(),
            samples: self.shared.film.samples_everywhere(&self.shared.tiles),
            mean_samples: sum / pixels.max(1) as f64,
            most_samples: counts.iter().copied().max().unwrap_or(0),
            counts: *lock(&self.shared.counts),
            threads: self.threads.len(),
            failure: lock(&self.shared.failure).clone(),
            kept: self.shared.keeper.as_ref().map(Keeper::kept),
        }
    }
}

impl Drop for Job {
    /// Ends the threads before the data that they use are freed.
    fn drop(&mut self) {
        self.stop();
        for thread in self.threads.drain(..) {
            // A panic was caught and recorded inside.
            let _ = thread.join();
        }
        let _ = self.end_checkpoints();
    }
}

impl Shared {
    /// The state before the first thread.
    fn new(
        stage: Arc<PreparedScene>,
        cameras: Vec<Camera>,
        settings: Settings,
        beside: OutputOptions,
    ) -> Result<Self, SettingsError> {
        settings.check()?;
        beside.share.check(&settings)?;
        let first = cameras.first().ok_or(SettingsError::Camera)?;
        settings.check_integrator(first)?;
        let is_bidirectional = settings.integrator == Integrator::Bidirectional;
        let pipeline = aimed::pipeline(&stage, &cameras, first, &settings, beside.exposure.as_ref());
        let spreads = is_bidirectional || pipeline != Pipeline::FilmFirst;
        let (width, height) = (settings.width, settings.height);
        let adapts = settings.noise_threshold > 0.0;
        let film = Film::keeping(width, height, spreads, beside.channels(&stage, &settings))
            .exposed(settings.film_exposure)
            .shaded(beside.gains.unwrap_or_default().into());
        let window = settings.window.filter(|_| !is_bidirectional);
        let tiles = film.tiles_about(window.unwrap_or([0, 0, width, height]), spreads);
        let (own, own_pixels) = share::own(beside.share, &film, &tiles);
        let film = if own.is_empty() { film.for_joining(spreads) } else { film };
        let mut shared = Self {
            tiles,
            share: beside.share,
            own,
            raster: Raster::new(width, height, PixelFilter::new(settings.filter))
                .independent(settings.independent_pixels),
            adaptive: adapts.then(|| Adaptive::new(&settings, film.tile_count(), own_pixels)),
            film,
            motion: beside.motion,
            exposure: beside.exposure,
            bake: beside.bake,
            parts: beside.parts,
            clip: beside.clip,
            limits: OnceLock::new(),
            aimed: OnceLock::new(),
            pipeline,
            passes: passes(settings.samples),
            running: Mutex::new(settings.thread_count()),
            stage,
            cameras,
            settings,
            deciding: Mutex::default(),
            next: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
            counts: Mutex::default(),
            failure: Mutex::default(),
            ended: Condvar::new(),
            started: Instant::now(),
            ended_at: Mutex::default(),
            gate: RwLock::new(()),
            keeper: None,
            strayed: Mutex::default(),
            denoised: Mutex::default(),
            stop_developing: AtomicBool::new(false),
            developed: AtomicU64::new(0),
        };
        shared.keeper = beside.checkpoints.map(|checkpoints| Keeper::new(checkpoints, &mut shared));
        Ok(shared)
    }

    /// The work of one thread.
    fn work(&self) {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| self.render())) {
            let text = panic
                .downcast_ref::<String>()
                .cloned()
                .or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()))
                .unwrap_or_default();
            *lock(&self.failure) = Some(format!("the renderer failed ({text}); please report this with the scene"));
            self.stop.store(true, Ordering::Relaxed);
        }
        let mut running = lock(&self.running);
        *running -= 1;
        if *running == 0 {
            *lock(&self.ended_at) = Some(self.started.elapsed());
        }
        self.ended.notify_all();
    }

    /// The limits, with statistics from rays that lie evenly over the picture.
    fn find_limits(&self) -> Limits {
        let unless_zero = |most: f32| if most > 0.0 { most } else { f32::INFINITY };
        const SIDE: u32 = 16;
        let s = &self.settings;
        let camera = &self.cameras[self.cameras.len() / 2];
        let ray = |i: u32| {
            let [u0, u1, u2, u3] = PathSampler::new(i, 0, 0, 0).next_4d();
            let (column, row) = ((i % SIDE) as f32 + u0, (i / SIDE) as f32 + u1);
            let place = Vec2::new(column, row) / SIDE as f32 - 0.5;
            camera.sample(place, [u2, u3], (i as f32 + 0.5) / (SIDE * SIDE) as f32).map(|found| found.ray)
        };
        let ray = |i: u32| {
            let sent = ray(i)?;
            Some(self.exposure.as_ref().map_or(sent, |exposure| exposure.sent(sent, sent.moment)))
        };
        let rays: Vec<_> = match &self.bake {
            Some(points) => points.some_rays(&self.stage.scene, (SIDE * SIDE) as usize),
            None => (0..SIDE * SIDE).filter_map(ray).collect(),
        };
        let limits = Limits {
            max_bounces: s.max_bounces,
            kinds: s.kinds,
            clamp_direct: unless_zero(s.clamp_direct),
            clamp_indirect: unless_zero(s.clamp_indirect),
            approximations: s.approximations,
            hide_sky: s.transparent_film,
            // As roughness is squared for facets; here their widths along both axes are multiplied.
            film_glass: s.transparent_glass.filter(|_| s.transparent_film).map(|roughness| roughness.powi(4)),
            openness: path::openness(&self.stage, &rays),
            roulette: f32::INFINITY,
        };
        Limits { roulette: path::roulette(&self.stage, &limits, &rays), ..limits }
    }

    /// The data that all samples share.
    fn shot(&self) -> RenderContext<'_> {
        let s = &self.settings;
        if self.pipeline == Pipeline::SceneFirst {
            self.cameras.iter().filter_map(Camera::traced_lens).for_each(RealLens::prepare_for_scene_first);
        }
        RenderContext {
            stage: &self.stage,
            cameras: &self.cameras,
            clip: self.clip,
            pipeline: self.pipeline,
            light_paths: (s.integrator == Integrator::Bidirectional).then_some(Techniques::All),
            raster: &self.raster,
            limits: self.limits(),
            pattern: s.pattern(self.pipeline),
            motion: self.motion.as_ref(),
            exposure: self.exposure.as_ref(),
            parts: &self.parts,
            aimed: self.aimed.get_or_init(|| self.find_aimed()).0.clone(),
            bake: self.bake.as_ref(),
        }
    }

    fn limits(&self) -> Limits {
        *self.limits.get_or_init(|| self.find_limits())
    }

    fn render(&self) {
        let s = &self.settings;
        let shot = self.shot();
        let stopped = || self.stop.load(Ordering::Relaxed);
        if let Some(adaptive) = &self.adaptive {
            while !stopped() && self.render_next(&shot, adaptive, &stopped).is_some() {}
            return;
        }
        let tiles = self.own.len();
        if tiles == 0 {
            return;
        }
        loop {
            let task = self.next.fetch_add(1, Ordering::Relaxed);
            let (pass, tile) = (task / tiles, self.own[task % tiles]);
            let Some(&(first, count)) = self.passes.get(pass) else { return };
            if self.film.tile(tile).passes > pass as u32 {
                // Kept from before.
                continue;
            }
            let first = s.sample_offset + first;
            let mut light = self.film.patch(tile);
            let counts = render_tile(&shot, self.film.rect(tile), [first, count], &mut light, &stopped);
            let Some(counts) = counts else { return };
            // The pass before may still be under way in another thread.
            loop {
                let _shared = self.gate.read().unwrap_or_else(PoisonError::into_inner);
                match self.film.add_pass(tile, pass as u32, light, count) {
                    Ok(()) => break lock(&self.counts).add(&counts),
                    Err(early) => light = *early,
                }
                if stopped() {
                    return;
                }
                std::thread::yield_now();
            }
        }
    }

    /// The next pass of a tile whose pixels get as many samples as they need; `None` at the end, or where `stopped` said so.
    fn render_next(&self, shot: &RenderContext<'_>, adaptive: &Adaptive, stopped: &dyn Fn() -> bool) -> Option<()> {
        let (s, tiles) = (&self.settings, self.own.len());
        let task = self.next.fetch_add(1, Ordering::Relaxed);
        let (pass, tile) = (task.checked_div(tiles)?, self.own[task % tiles]);
        let now = *adaptive.passes.get(pass)?;
        // What is left to do depends on the pass before, which may still be under way in another thread, and on the decisions after it.
        let before = pass.checked_sub(1).map(|number| (number as u32, adaptive.passes[number]));
        loop {
            let passes = self.film.tile(tile).passes;
            // Kept from before.
            if passes > pass as u32 {
                return Some(());
            }
            let undecided = before.filter(|(_, pass)| !adaptive.has_decided(tile, *pass));
            match undecided.filter(|_| passes == pass as u32) {
                None if passes == pass as u32 => break,
                Some(before) if self.decide_together(adaptive, before, stopped) => continue,
                Some(_) => remaining::wait(),
                None => std::thread::yield_now(),
            }
            if stopped() {
                return None;
            }
        }
        let mut found = [[None, None], [None, None]];
        let mut sum = Counts::default();
        for (half, parts) in found.iter_mut().enumerate() {
            for (part, range) in parts.iter_mut().zip(adaptive.batch(tile, half, now)) {
                let Some([first, count]) = range else { continue };
                let mut light = self.film.patch(tile);
                let pixels = self.film.rect(tile).pixels_of(half).map(|(x, y)| [x, y]);
                let counts = render_pixels(shot, pixels, [s.sample_offset + first, count], &mut light, stopped)?;
                sum.add(&counts);
                *part = Some((light, count));
            }
        }
        let _shared = self.gate.read().unwrap_or_else(PoisonError::into_inner);
        lock(&self.counts).add(&sum);
        for (half, parts) in found.iter().enumerate() {
            let [counted, beyond] = parts.each_ref().map(|part| part.as_ref().map(|(light, count)| (light, *count)));
            if counted.is_some() || beyond.is_some() {
                self.film.add_batch(tile, half, counted, beyond);
            }
            adaptive.count(&self.film, tile, half, counted.map_or(0, |(_, count)| count));
        }
        if s.denoising.is_none() {
            let errors = [0, 1].map(|half| self.film.squared_error(tile, half));
            adaptive.look(&self.film, tile, now, errors);
        }
        self.film.end_pass(tile);
        Some(())
    }
}

/// First sample and count of each pass: one sample first, for something to look at, then twice as many each time.
fn passes(samples: u32) -> Vec<(u32, u32)> {
    let mut list = Vec::new();
    let mut first = 0;
    while first < samples {
        let count = first.clamp(1, MOST_PER_PASS).min(samples - first);
        list.push((first, count));
        first += count;
    }
    list
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
