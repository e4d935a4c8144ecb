//! Denoising by Intel's Open Image Denoise, which is loaded at run time: Blender ships it beside itself.
//!
//! Nothing is linked when the engine is compiled, and no copy is bundled: [`Denoiser::open`] takes the path of
//! `libOpenImageDenoise.so.2`, `OpenImageDenoise.dll` or `libOpenImageDenoise.dylib`. Versions 2.0 and later have one interface.

mod api;
mod combine;

use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use api::{Buffer, Device, Functions};
pub use combine::{combine, moved, remaining};
use serde::Deserialize;
use thiserror::Error;

/// The oldest major version of the library whose interface is known.
const MAJOR: i32 = 2;
/// The first minor version that knows [`Quality::Fast`].
const FAST_MINOR: i32 = 3;

/// An error of denoising. The picture is as it was.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DenoiseError {
    /// The library cannot be loaded, or is none.
    #[error("Open Image Denoise cannot be loaded from {path:?}: {why}")]
    NoLibrary {
        /// The library's file.
        path: PathBuf,
        /// The system's message.
        why: String,
    },
    /// The library is of another interface.
    #[error("Open Image Denoise {major}.{minor} is too old; version 2 or later is needed")]
    TooOld {
        /// The major version.
        major: i32,
        /// The minor version.
        minor: i32,
    },
    /// There is not enough memory for it.
    #[error("there is not enough memory to denoise the picture")]
    OutOfMemory,
    /// It was stopped.
    #[error("denoising was stopped")]
    Stopped,
    /// The library reports another error.
    #[error("Open Image Denoise failed: {message} (error {code})")]
    Failed {
        /// The library's number of the error.
        code: i32,
        /// The library's message.
        message: String,
    },
    /// An image has not three numbers for each pixel.
    #[error("{name} has {found} numbers; {expected} are needed for {width} x {height} pixels")]
    Size {
        /// The image's name.
        name: &'static str,
        /// The numbers.
        found: usize,
        /// The numbers of its size.
        expected: usize,
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// The time that is spent on a better picture.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Quality {
    /// The quality for previews.
    Fast,
    /// Between both.
    Balanced,
    /// The quality for final pictures.
    #[default]
    High,
}

impl Quality {
    /// The quality in which guides are filtered first: at [`Self::High`] the picture would be no better, and take half as long again.
    fn of_guides(self) -> Self {
        match self {
            Self::High => Self::Balanced,
            quality => quality,
        }
    }

    /// Number of runs of the filter on the picture. At [`Self::High`] a second run filters the picture turned by 180 degrees, and the mean
    /// of both is taken: the filter's own errors are partly others then.
    fn runs(self) -> usize {
        if self == Self::High { 2 } else { 1 }
    }
}

/// The treatment of noise in albedo and normal before they guide the filter. Cycles' words.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Prefilter {
    /// Albedo and normal are taken for free of noise.
    None,
    /// Albedo and normal are filtered together with the picture.
    Fast,
    /// Albedo and normal are filtered first, each alone.
    #[default]
    Accurate,
}

/// A picture and the guides of the filter. Images hold red, green and blue of each pixel, rows after each other.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The picture: radiance, of any brightness.
    pub colour: &'a [f32],
    /// Albedo, 0 to 1; with [`Self::normal`] or alone.
    pub albedo: Option<&'a [f32]>,
    /// Normal, -1 to 1; only beside albedo.
    pub normal: Option<&'a [f32]>,
    /// The treatment of the noise of both.
    pub prefilter: Prefilter,
    /// The quality.
    pub quality: Quality,
    /// True if a graphics card may compute, where there is one.
    pub use_gpu: bool,
    /// Threads that compute where none does.
    pub threads: usize,
    /// Megabytes that the filter may take for itself; `None` as it wants.
    pub memory_mb: Option<usize>,
}

/// Time of a pixel in one run of the filter, s, of each quality.
struct PixelTimes {
    /// Times of one thread of the processor: as measured last, or on two cores of an AMD EPYC of 2023.
    processor: [f64; 3],
    /// Times of a graphics card, as measured last.
    card: [Option<f64>; 3],
}

static PIXEL_S: Mutex<PixelTimes> = Mutex::new(PixelTimes { processor: [2.0e-6, 2.8e-6, 5.2e-6], card: [None; 3] });
/// Pictures with fewer pixels say nothing of the time of a pixel.
const LEAST_PIXELS: usize = 50_000;

impl PixelTimes {
    /// Time of a pixel in one run at a quality, s; a card of which none is known yet is taken for the processor.
    fn of(&self, quality: Quality, use_gpu: bool, threads: usize) -> f64 {
        let card = self.card[quality as usize].filter(|_| use_gpu);
        card.unwrap_or_else(|| self.processor[quality as usize] / threads.max(1) as f64)
    }

    /// Time of a pixel in all runs, s: those of the guides and of the picture.
    fn of_runs(&self, work: Work) -> [f64; 2] {
        let of = |quality| self.of(quality, work.use_gpu, work.threads);
        let filtered = if work.prefilter == Prefilter::Accurate { work.guides } else { 0 };
        [filtered as f64 * of(work.quality.of_guides()), work.quality.runs() as f64 * of(work.quality)]
    }

    /// Takes the times of this work's runs for those that it took in all; small pictures say nothing.
    fn learn(&mut self, work: Work, is_cpu: bool, seconds: f64) {
        if work.pixels < LEAST_PIXELS {
            return;
        }
        let work = Work { use_gpu: !is_cpu, ..work };
        let runs = self.of_runs(work);
        let ratio = seconds / (runs.iter().sum::<f64>() * work.pixels as f64);
        let of_guides = Some(work.quality.of_guides()).filter(|&quality| runs[0] > 0.0 && quality != work.quality);
        for quality in [Some(work.quality), of_guides].into_iter().flatten() {
            let pixel_s = ratio * self.of(quality, work.use_gpu, work.threads);
            match is_cpu {
                true => self.processor[quality as usize] = pixel_s * work.threads.max(1) as f64,
                false => self.card[quality as usize] = Some(pixel_s),
            }
        }
    }
}

/// The work of denoising a picture, for [`expected_seconds`].
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// The quality.
    pub quality: Quality,
    /// Treatment of the guides' noise.
    pub prefilter: Prefilter,
    /// Albedo and normal, as many as there are.
    pub guides: usize,
    /// Pixels of the picture.
    pub pixels: usize,
    /// True if a graphics card may compute.
    pub use_gpu: bool,
    /// Threads that compute where none does.
    pub threads: usize,
}

/// Wall time that [`Denoiser::denoise`] will take, s, about: by the last picture of this quality. A card of which none is known yet is
/// taken for the processor.
pub fn expected_seconds(work: Work) -> f64 {
    pixel_times().of_runs(work).iter().sum::<f64>() * work.pixels as f64
}

fn pixel_times() -> MutexGuard<'static, PixelTimes> {
    PIXEL_S.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The library, loaded.
pub struct Denoiser {
    functions: &'static Functions,
    version: [i32; 3],
    /// The graphics card, once it is used: it is ready after a fifth of a second, in which a view would have been denoised.
    card: Mutex<Option<Arc<Device>>>,
}

/// The libraries that are loaded. They stay so: loading takes longer than a small picture, and their threads outlive a render.
static LOADED: Mutex<Vec<(PathBuf, Arc<Denoiser>)>> = Mutex::new(Vec::new());

impl Denoiser {
    /// The library of a file, loaded if it is not yet.
    ///
    /// # Errors
    /// [`DenoiseError::NoLibrary`], [`DenoiseError::TooOld`], or the error that its device reports.
    pub fn open(path: &Path) -> Result<Arc<Self>, DenoiseError> {
        let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = loaded.iter().find(|(known, _)| known == path) {
            return Ok(Arc::clone(found));
        }
        // It is never unloaded.
        let functions: &'static Functions = Box::leak(Box::new(Functions::load(path)?));
        let version = Device::new(functions, false, 1)?.version();
        let [major, minor, _] = version;
        if major < MAJOR {
            return Err(DenoiseError::TooOld { major, minor });
        }
        let found = Arc::new(Self { functions, version, card: Mutex::new(None) });
        loaded.push((path.to_owned(), Arc::clone(&found)));
        Ok(found)
    }

    /// Major, minor and patch version.
    pub fn version(&self) -> [i32; 3] {
        self.version
    }

    /// The picture without its noise. `watch` is called now and then with the part that is done, and returns false to stop.
    ///
    /// Numbers that are not finite are taken for black: the filter would spread them. Where a graphics card has not enough memory, the
    /// processor computes.
    ///
    /// # Errors
    /// [`DenoiseError`]; nothing is lost by one.
    pub fn denoise(&self, request: &Request<'_>, watch: &dyn Fn(f64) -> bool) -> Result<Vec<f32>, DenoiseError> {
        let done = self.attempt(request, watch);
        if request.use_gpu && !matches!(done, Ok(_) | Err(DenoiseError::Stopped)) {
            // Whatever is wrong with the card, the next picture begins with a new device.
            *self.card.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
        match done {
            Err(DenoiseError::OutOfMemory) if request.use_gpu => {
                self.attempt(&Request { use_gpu: false, ..*request }, watch)
            }
            done => done,
        }
    }

    /// The device for a picture.
    fn device(&self, use_gpu: bool, threads: usize) -> Result<Arc<Device>, DenoiseError> {
        let new = || Device::new(self.functions, use_gpu, threads).map(Arc::new);
        if !use_gpu {
            return new();
        }
        let mut card = self.card.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(card) = &*card {
            return Ok(Arc::clone(card));
        }
        let device = new()?;
        // The processor in place of a card has the threads of this picture.
        *card = Some(Arc::clone(&device)).filter(|device| !device.is_cpu());
        Ok(device)
    }

    fn attempt(&self, request: &Request<'_>, watch: &dyn Fn(f64) -> bool) -> Result<Vec<f32>, DenoiseError> {
        let Request { width, height, .. } = *request;
        let expected = width * height * 3;
        let checked = |name: &'static str, pixels: &[f32]| match pixels.len() == expected {
            true => Ok(pixels.iter().map(|x| if x.is_finite() { *x } else { 0.0 }).collect::<Vec<f32>>()),
            false => Err(DenoiseError::Size { name, found: pixels.len(), expected, width, height }),
        };
        let colour = checked("the picture", request.colour)?;
        let mut guides = Vec::new();
        if let Some(albedo) = request.albedo {
            guides.push((c"albedo", checked("the albedo", albedo)?));
            if let Some(normal) = request.normal {
                guides.push((c"normal", checked("the normal", normal)?));
            }
        }
        if width == 0 || height == 0 {
            return Ok(colour);
        }
        let began = Instant::now();
        let device = self.device(request.use_gpu, request.threads)?;
        let Request { prefilter, quality, use_gpu, threads, .. } = *request;
        let is_accurate = prefilter == Prefilter::Accurate;
        let count = guides.len();
        let work = Work { quality, prefilter, guides: count, pixels: width * height, use_gpu, threads };
        // The part of the time that goes to the guides.
        let [of_guides, of_picture] = pixel_times().of_runs(work);
        let first = of_guides / (of_guides + of_picture);
        let mut images = vec![(c"color", device.filled(&colour)?)];
        drop(colour);
        for (done, (name, noisy)) in guides.into_iter().enumerate() {
            let guide = device.filled(&noisy)?;
            drop(noisy);
            let tell = |part: f64| watch(first * (done as f64 + part) / count as f64);
            images.push(match is_accurate {
                true => (name, self.filtered(&device, request, &[(name, guide)], false, &tell)?),
                false => (name, guide),
            });
        }
        let runs = quality.runs() as f64;
        let told = |part: f64| watch(first + (1.0 - first) * part / runs);
        let mut clean = self.filtered(&device, request, &images, true, &told)?.read()?;
        if quality.runs() > 1 {
            for (_, image) in &mut images {
                *image = device.filled(&turned(image.read()?))?;
            }
            let again = self.filtered(&device, request, &images, true, &|part| told(1.0 + part))?.read()?;
            for (one, other) in clean.iter_mut().zip(turned(again)) {
                *one = 0.5 * (*one + other);
            }
        }
        pixel_times().learn(work, device.is_cpu(), began.elapsed().as_secs_f64());
        Ok(clean)
    }

    /// The first of these images, filtered; the others guide.
    fn filtered<'a>(
        &self,
        device: &'a Device,
        request: &Request<'_>,
        images: &[(&CStr, Buffer<'_>)],
        is_picture: bool,
        watch: &dyn Fn(f64) -> bool,
    ) -> Result<Buffer<'a>, DenoiseError> {
        let size = [request.width, request.height];
        let output = device.buffer(request.width * request.height * 3)?;
        let filter = device.filter()?;
        for (name, pixels) in images {
            filter.set_image(name, pixels, size);
        }
        filter.set_image(c"output", &output, size);
        let quality = if is_picture { request.quality } else { request.quality.of_guides() };
        filter.set_int(c"quality", self.quality(quality));
        if let Some(mb) = request.memory_mb {
            filter.set_int(c"maxMemoryMB", i32::try_from(mb).unwrap_or(i32::MAX));
        }
        if is_picture {
            filter.set_bool(c"hdr", true);
            filter.set_bool(c"cleanAux", images.len() > 1 && request.prefilter != Prefilter::Fast);
        }
        filter.execute(watch)?;
        Ok(output)
    }

    /// The library's number of a quality.
    fn quality(&self, quality: Quality) -> i32 {
        let [major, minor, _] = self.version;
        match quality {
            Quality::Fast if major > MAJOR || minor >= FAST_MINOR => 4,
            Quality::Fast | Quality::Balanced => 5,
            Quality::High => 6,
        }
    }
}

/// A picture turned by 180 degrees.
fn turned(mut picture: Vec<f32>) -> Vec<f32> {
    picture.as_chunks_mut::<3>().0.reverse();
    picture
}
