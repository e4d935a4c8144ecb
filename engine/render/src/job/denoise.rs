//! Denoising of a finished picture, before the light that strays is laid over.

use super::{Job, Shared, lock};
use crate::integrator::path::parts::LightPass;
pub use petzval_denoise::{DenoiseError, Prefilter, Quality};
use petzval_denoise::{Denoiser, Request};
use serde::Deserialize;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// How a picture is denoised.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Denoising {
    /// The file of Open Image Denoise.
    pub library: PathBuf,
    /// True if [`LightPass::DenoisingAlbedo`] guides, where the render keeps it.
    pub by_albedo: bool,
    /// True if [`LightPass::DenoisingNormal`] does so beside albedo.
    pub by_normal: bool,
    /// What becomes of the noise of both.
    pub prefilter: Prefilter,
    /// The quality.
    pub quality: Quality,
}

impl Job {
    /// Denoises the picture as it is now, for [`Self::picture`]; to be called after the end, before [`Self::develop`]. Only the part that is
    /// wanted is denoised: what lies outside is unfinished. [`Self::stop_developing`] ends it without a result.
    ///
    /// # Errors
    /// [`DenoiseError`]; the picture then is as it was.
    pub fn denoise(&self, how: &Denoising) -> Result<(), DenoiseError> {
        let shared: &Shared = &self.shared;
        let (width, height) = shared.film.size();
        let [left, bottom, columns, rows] =
            shared.settings.window.unwrap_or([0, 0, width, height]).map(|pixels| pixels as usize);
        let width = width as usize;
        let place = |row: usize| (bottom + row) * width + left;
        let part = |whole: Vec<[f32; 3]>| -> Vec<f32> {
            (0..rows).flat_map(|row| whole[place(row)..place(row) + columns].as_flattened().to_vec()).collect()
        };
        let guide = |is_asked: bool, pass: LightPass| is_asked.then(|| self.part(pass).map(part)).flatten();
        let colour: Vec<[f32; 3]> = shared.film.picture().into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        let albedo = guide(how.by_albedo, LightPass::DenoisingAlbedo);
        let normal = guide(how.by_albedo && how.by_normal, LightPass::DenoisingNormal);
        let denoiser = Denoiser::open(&how.library)?;
        let request = Request {
            width: columns,
            height: rows,
            colour: &part(colour.clone()),
            albedo: albedo.as_deref(),
            normal: normal.as_deref(),
            prefilter: how.prefilter,
            quality: how.quality,
            threads: self.threads.len(),
            memory_mb: None,
        };
        let watch = |part: f64| {
            shared.developed.store(part.to_bits(), Ordering::Relaxed);
            !shared.stop_developing.load(Ordering::Relaxed)
        };
        let clean = denoiser.denoise(&request, &watch)?;
        let mut whole = colour;
        for (row, pixels) in clean.as_chunks::<3>().0.chunks(columns.max(1)).enumerate() {
            whole[place(row)..place(row) + columns].copy_from_slice(pixels);
        }
        *lock(&shared.denoised) = Some(Arc::new(whole));
        shared.developed.store(0, Ordering::Relaxed);
        Ok(())
    }

    /// The picture as it is now, denoised if it was, before the light that strays; rows from below.
    pub(super) fn straight(&self) -> Vec<[f32; 4]> {
        let mut picture = self.shared.film.picture();
        if let Some(clean) = lock(&self.shared.denoised).as_deref() {
            for (pixel, clean) in picture.iter_mut().zip(clean) {
                pixel[..3].copy_from_slice(clean);
            }
        }
        picture
    }

    /// True if [`Self::denoise`] has denoised the picture.
    pub fn is_denoised(&self) -> bool {
        lock(&self.shared.denoised).is_some()
    }

    /// The picture with its noise, and with the light that strays once that is found; rows from below.
    pub fn noisy_picture(&self) -> Vec<[f32; 4]> {
        self.with_strayed(self.shared.film.picture())
    }
}
