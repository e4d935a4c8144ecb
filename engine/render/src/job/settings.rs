//! Settings of a render, and the errors of wrong ones.

use super::denoise::Denoising;
use crate::camera::Camera;
use crate::integrator::{
    Integrator,
    path::{Approximations, FastGi, KindLimits},
};
use crate::pipeline::Pipeline;
use crate::sampler::{pattern::Pattern, warp::Filter};
use serde::Deserialize;

/// The largest picture side, so that sizes fit in memory arithmetic.
const MOST_PIXELS: u32 = 65_536;
/// Default of the least samples: blocks of 64 pixels then know their error to about a tenth.
pub const MIN_SAMPLES: u32 = 16;

/// The settings of a render, unchecked.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Samples a pixel, at most.
    pub samples: u32,
    /// Relative error at which a pixel has samples enough ([`crate::film::halves`] has the formula); 0 gives all the same.
    pub noise_threshold: f32,
    /// The way in which the picture will be denoised: its threshold is then that of the error which denoising leaves. `None`: of the noise.
    pub denoising: Option<Denoising>,
    /// Samples that a pixel has when its error is first looked at; 0 is [`MIN_SAMPLES`].
    pub min_samples: u32,
    /// Seed of all random choices.
    pub seed: u32,
    /// True if the errors of neighbouring pixels are to cancel once all samples are there. Not where pixels get as many as they need: the
    /// test that stops them must not know of their neighbours. Not from a later sample on, either: ranges of samples make the whole picture
    /// only without. Nor scene-first, where the rays of one pixel land in others.
    pub blue_noise: bool,
    /// True if the noise of neighbouring pixels is to be independent, as denoising needs; else the light of a ray is spread over the pixels
    /// whose filters reach where it arrives, for less noise in each. Lenses disperse light over pixels all the same.
    pub independent_pixels: bool,
    /// Factor of the finished light.
    pub film_exposure: f32,
    /// Left, bottom, width and height, in pixels, of the part of the picture that is wanted; `None` is all. Pixels outside may stay
    /// black, and near its edge light that a lens spreads farther than [`crate::film::SPREAD`] pixels may be missing; pixels that get
    /// as many samples as they need, and bidirectional paths, know of no part.
    pub window: Option<[u32; 4]>,
    /// Number of the first sample: renders of one seed and disjoint ranges can be merged.
    pub sample_offset: u32,
    /// Number of threads; 0 is one a core.
    pub threads: usize,
    /// Bounces after the first surface.
    pub max_bounces: u32,
    /// The most bounces of each kind.
    pub kinds: KindLimits,
    /// Most radiance, in the mean of its channels, that light may add to a sample which the camera sees, or which is scattered once; 0
    /// is no limit.
    pub clamp_direct: f32,
    /// Most radiance, in the mean of its channels, that light scattered more than once may add to a sample; 0 is no limit.
    pub clamp_indirect: f32,
    /// Approximations of indirect light; bidirectional paths make none.
    pub approximations: Approximations,
    /// The pixel filter: weights of light about the centre of a pixel.
    pub filter: Filter,
    /// True if the camera does not see the world; its pixels are transparent.
    pub transparent_film: bool,
    /// The most roughness of glass through which a transparent film is seen transparent; `None`: all glass shows the sky.
    pub transparent_glass: Option<f32>,
    /// The pipeline: the order in which the parts of a sample are made.
    pub pipeline: Pipeline,
    /// True to keep the data of the surfaces that the pixels see, for [`Job::data`].
    pub with_data: bool,
    /// The integrator. Light paths carry a set of wavelengths, whatever the pipeline.
    pub integrator: Integrator,
    /// True if small lights far out of focus send rays to the lens, where that is worth it ([`crate::integrator::aimed`]).
    pub light_tracing: bool,
}

/// The defaults of the add-on, for a picture of 1920 x 1080.
impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1920,
            height: 1080,
            samples: 64,
            noise_threshold: 0.0,
            denoising: None,
            min_samples: 0,
            seed: 0,
            blue_noise: false,
            independent_pixels: false,
            film_exposure: 1.0,
            window: None,
            sample_offset: 0,
            threads: 0,
            max_bounces: 12,
            kinds: KindLimits::default(),
            clamp_direct: 0.0,
            clamp_indirect: 0.0,
            approximations: Approximations::default(),
            filter: Filter::BlackmanHarris(1.5),
            transparent_film: false,
            transparent_glass: None,
            pipeline: Pipeline::Auto,
            with_data: false,
            integrator: Integrator::Path,
            light_tracing: true,
        }
    }
}

/// A setting out of range.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The picture's size is out of range.
    #[error("resolution {width} x {height}: set each side from 1 to {MOST_PIXELS} pixels")]
    Resolution {
        /// Width of the picture, pixels.
        width: u32,
        /// Height of the picture, pixels.
        height: u32,
    },
    /// No samples, or more than can be counted.
    #[error("{samples} samples from number {offset}: set at least one, and less than 2^31 in all")]
    Samples {
        /// Number of samples a pixel that was asked for.
        samples: u32,
        /// Number of the first sample.
        offset: u32,
    },
    /// The roughness of transparent glass is out of range.
    #[error("transparent roughness threshold {0}: set it from 0 to 1")]
    TransparentGlass(f32),
    /// The noise threshold is out of range.
    #[error("noise threshold {0}: set the relative error of a pixel, as 0.01, or zero for as many samples everywhere")]
    Noise(f32),
    /// A limit on light is out of range.
    #[error("light clamped at {0}: set a radiance, or zero for no limit")]
    Clamp(f32),
    /// The filter of glossy light is out of range.
    #[error("glossy light filtered at {0}: set a density of directions, as 1, or zero for none")]
    FilterGlossy(f32),
    /// A number of fast global illumination is out of range.
    #[error("fast GI of distance {distance} and factor {factor}: set numbers of zero or more")]
    FastGi {
        /// Length of the occlusion rays.
        distance: f32,
        /// Factor of the light.
        factor: f32,
    },
    /// A share of the tiles is none.
    #[error("share {first} to {end} of {of} of a picture: its end is not before its begin, nor beyond the whole")]
    Share {
        /// The first slot.
        first: u32,
        /// The slot behind the last.
        end: u32,
        /// The number of slots.
        of: u32,
    },
    /// The noise after denoising is known of whole pictures alone.
    #[error(
        "a noise threshold after denoising looks at the whole picture: turn After Denoising off, or render the picture in one part"
    )]
    ShareAfterDenoising,
    /// No camera is given.
    #[error("no camera: give one")]
    Camera,
    /// The width of the pixel filter is out of range.
    #[error("filter width {0} pixels: set it above 0, up to 10")]
    Filter(f32),
    /// Light paths end in a real lens alone.
    #[error(
        "bidirectional path tracing photographs with the real lens, not with '{camera}': choose the lens as camera, or path tracing"
    )]
    NoLensForLight {
        /// The camera in use.
        camera: String,
    },
    /// Etendue is not kept between spaces that are stretched against one another.
    #[error(
        "light tracing needs one scale for all three axes: make the world-to-lens scales equal, or choose path tracing"
    )]
    UnequalScales,
}

impl Settings {
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        let side = 1..=MOST_PIXELS;
        if !side.contains(&self.width) || !side.contains(&self.height) {
            return Err(SettingsError::Resolution { width: self.width, height: self.height });
        }
        let last = self.samples.checked_add(self.sample_offset);
        if self.samples == 0 || last.is_none_or(|n| n > i32::MAX as u32) {
            return Err(SettingsError::Samples { samples: self.samples, offset: self.sample_offset });
        }
        if !(0.0..=f32::MAX).contains(&self.noise_threshold) {
            return Err(SettingsError::Noise(self.noise_threshold));
        }
        let is_limit = |most: &f32| (0.0..=f32::INFINITY).contains(most);
        if let Some(most) = [self.clamp_direct, self.clamp_indirect].into_iter().find(|most| !is_limit(most)) {
            return Err(SettingsError::Clamp(most));
        }
        if !(0.0..=f32::MAX).contains(&self.approximations.filter_glossy) {
            return Err(SettingsError::FilterGlossy(self.approximations.filter_glossy));
        }
        if let FastGi::Replace { distance, factor, .. } | FastGi::Add { distance, factor } = self.approximations.fast_gi
            && !(distance >= 0.0 && (0.0..=f32::MAX).contains(&factor))
        {
            return Err(SettingsError::FastGi { distance, factor });
        }
        if let Some(most) = self.transparent_glass.filter(|most| !(0.0..=1.0).contains(most)) {
            return Err(SettingsError::TransparentGlass(most));
        }
        match self.filter {
            Filter::Gaussian(width) | Filter::BlackmanHarris(width) if !(width > 0.0 && width <= 10.0) => {
                return Err(SettingsError::Filter(width));
            }
            _ => {}
        }
        Ok(())
    }

    pub(super) fn check_integrator(&self, camera: &Camera) -> Result<(), SettingsError> {
        match (self.integrator, camera) {
            (Integrator::Path, _) => Ok(()),
            (Integrator::Bidirectional, Camera::Lens(lens)) if lens.takes_light_paths() => {
                lens.prepare_for_light_paths();
                Ok(())
            }
            (Integrator::Bidirectional, Camera::Lens(_)) => Err(SettingsError::UnequalScales),
            (Integrator::Bidirectional, other) => {
                Err(SettingsError::NoLensForLight { camera: other.name().to_owned() })
            }
        }
    }

    /// The pattern of the points that pixels get.
    pub(super) fn pattern(&self, pipeline: Pipeline) -> Pattern {
        let all_at_once = self.noise_threshold == 0.0 && self.sample_offset == 0;
        if self.blue_noise && all_at_once && pipeline != Pipeline::SceneFirst {
            Pattern::shared(self.seed, self.samples)
        } else {
            Pattern::independent(self.seed)
        }
    }

    /// Number of threads to use.
    pub fn thread_count(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        if self.threads == 0 { cores } else { self.threads.min(1024) }
    }
}
