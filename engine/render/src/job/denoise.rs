//! Denoising of a picture, before the stray light is laid over.

use super::{Job, Shared, catcher, lock};
use crate::integrator::path::parts::LightPass;
pub use petzval_denoise::{DenoiseError, Prefilter, Quality};
use petzval_denoise::{Denoiser, Request, Work};
use serde::Deserialize;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Settings of denoising.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Denoising {
    /// The file of Open Image Denoise.
    pub library: PathBuf,
    /// True if [`LightPass::DenoisingAlbedo`] guides, where the render keeps it.
    pub by_albedo: bool,
    /// True if [`LightPass::DenoisingNormal`] does so beside albedo.
    pub by_normal: bool,
    /// The treatment of the noise of both.
    pub prefilter: Prefilter,
    /// The quality.
    pub quality: Quality,
    /// True if a graphics card may compute.
    pub use_gpu: bool,
    /// Megabytes that the filter may take for itself; 0 as it wants.
    pub memory_mb: usize,
}

impl Denoising {
    /// The passes that guide, albedo and normal.
    fn guides(&self) -> [Option<LightPass>; 2] {
        let albedo = self.by_albedo.then_some(LightPass::DenoisingAlbedo);
        [albedo, albedo.filter(|_| self.by_normal).map(|_| LightPass::DenoisingNormal)]
    }

    /// Wall time that [`Job::denoise`] will take, s, about.
    pub fn expected_seconds(&self, pixels: usize, threads: usize) -> f64 {
        let guides = self.guides().iter().flatten().count();
        let &Self { quality, prefilter, use_gpu, .. } = self;
        petzval_denoise::expected_seconds(Work { quality, prefilter, guides, pixels, use_gpu, threads })
    }
}

/// Pictures without their noise, rows from below.
pub(super) struct Denoised {
    picture: Vec<[f32; 3]>,
    /// [`LightPass::Caught`], where the render keeps it.
    caught: Option<Vec<[f32; 3]>>,
    seconds: f64,
}

impl Job {
    /// Denoises the picture as it is now, for [`Self::picture`] and pictures made of it; to be called after the end, before
    /// [`Self::develop`]. Only the part that is wanted is denoised: pixels outside are unfinished. [`Self::stop_developing`] ends it
    /// without a result.
    ///
    /// # Errors
    /// [`DenoiseError`]; the picture then is as it was.
    pub fn denoise(&self, how: &Denoising) -> Result<(), DenoiseError> {
        let (began, shared) = (Instant::now(), &self.shared);
        let caught = self.part(catcher::PARTS[0]);
        let share = if caught.is_some() { 0.5 } else { 1.0 };
        let of_bake = self.some_light();
        let is_whole = caught.is_none() && of_bake.is_none();
        let noisy = of_bake.unwrap_or_else(|| shared.colour());
        let mut picture = self.shared.cleaned(how, &noisy, &|part| self.may_go_on(part * share))?;
        // The shadow on a catcher is a ratio of two pictures: both are denoised alike. The variance is that of all light.
        if is_whole {
            petzval_denoise::combine(&mut picture, &noisy, &shared.film.variances(), self.columns());
        }
        let caught = caught
            .map(|noisy| self.shared.cleaned(how, &noisy, &|part| self.may_go_on(0.5 + part * share)))
            .transpose()?;
        *lock(&shared.denoised) = Some(Arc::new(Denoised { picture, caught, seconds: began.elapsed().as_secs_f64() }));
        shared.developed.store(0, Ordering::Relaxed);
        Ok(())
    }

    /// The picture as it is now, denoised, without the stray light; rows from below. The render may go on meanwhile, and keeps its
    /// noise. [`Self::stop_developing`] ends it.
    ///
    /// # Errors
    /// As [`Self::denoise`].
    pub fn denoised_picture(&self, how: &Denoising) -> Result<Vec<[f32; 4]>, DenoiseError> {
        // The variance first: it must not be that of more samples.
        let (variance, noisy) = (self.shared.film.variances(), self.shared.film.picture());
        let colour: Vec<[f32; 3]> = noisy.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        let mut clean = self.shared.cleaned(how, &colour, &|part| self.may_go_on(part))?;
        petzval_denoise::combine(&mut clean, &colour, &variance, self.columns());
        Ok(noisy.into_iter().zip(clean).map(|([.., alpha], [r, g, b])| [r, g, b, alpha]).collect())
    }

    fn may_go_on(&self, part: f64) -> bool {
        self.shared.developed.store(part.to_bits(), Ordering::Relaxed);
        !self.shared.stop_developing.load(Ordering::Relaxed)
    }

    /// Pixels in a row of the picture.
    fn columns(&self) -> usize {
        self.shared.film.size().0 as usize
    }

    fn denoised(&self) -> Option<Arc<Denoised>> {
        lock(&self.shared.denoised).clone()
    }

    /// The picture as it is now, denoised if it was, before the stray light; rows from below.
    pub(super) fn straight(&self) -> Vec<[f32; 4]> {
        let mut picture = self.shared.film.picture();
        if let Some(clean) = self.denoised() {
            for (pixel, clean) in picture.iter_mut().zip(&clean.picture) {
                pixel[..3].copy_from_slice(clean);
            }
        }
        picture
    }

    /// [`LightPass::Caught`], denoised if it was.
    pub(super) fn caught(&self) -> Option<Vec<[f32; 3]>> {
        let clean = self.denoised().and_then(|clean| clean.caught.clone());
        clean.or_else(|| self.part(catcher::PARTS[0]))
    }

    /// True if [`Self::denoise`] has denoised the picture.
    pub fn is_denoised(&self) -> bool {
        self.denoised().is_some()
    }

    /// Seconds that [`Self::denoise`] took.
    pub(super) fn denoise_seconds(&self) -> Option<f64> {
        self.denoised().map(|clean| clean.seconds)
    }

    /// The picture with its noise, and with the stray light once that is found; rows from below.
    pub fn noisy_picture(&self) -> Vec<[f32; 4]> {
        self.with_strayed(self.shared.film.picture())
    }
}

impl Shared {
    /// The light of every pixel as it is now; rows from below.
    pub(super) fn colour(&self) -> Vec<[f32; 3]> {
        self.film.picture().into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
    }

    /// Light of every pixel without its noise.
    pub(super) fn cleaned(
        &self,
        how: &Denoising,
        noisy: &[[f32; 3]],
        watch: &dyn Fn(f64) -> bool,
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let denoiser = Denoiser::open(&how.library)?;
        let (width, height) = self.film.size();
        let [left, bottom, columns, rows] =
            self.settings.window.unwrap_or([0, 0, width, height]).map(|pixels| pixels as usize);
        let width = width as usize;
        let place = |row: usize| (bottom + row) * width + left;
        let part = |whole: &[[f32; 3]]| -> Vec<f32> {
            (0..rows).flat_map(|row| whole[place(row)..place(row) + columns].as_flattened().iter().copied()).collect()
        };
        let guide = |pass: LightPass| self.part(pass).map(|whole| part(&whole));
        let [albedo, normal] = how.guides().map(|pass| pass.and_then(guide));
        let request = Request {
            width: columns,
            height: rows,
            colour: &part(noisy),
            albedo: albedo.as_deref(),
            normal: normal.as_deref(),
            prefilter: how.prefilter,
            quality: how.quality,
            use_gpu: how.use_gpu,
            threads: self.settings.thread_count(),
            memory_mb: Some(how.memory_mb).filter(|&mb| mb > 0),
        };
        let clean = denoiser.denoise(&request, watch)?;
        let mut light = noisy.to_vec();
        for (row, pixels) in clean.as_chunks::<3>().0.chunks(columns.max(1)).enumerate() {
            light[place(row)..place(row) + columns].copy_from_slice(pixels);
        }
        Ok(light)
    }
}
