//! Ways from the film to the scene and back: which rays are followed, and where their light is added up.

pub mod aiming;
pub mod bake;
pub mod bidirectional;
pub mod film_first;
pub mod hero;
pub mod motion;
pub mod scene_first;
mod stretch;

use crate::Rgb;
use crate::accel::Ray;
use crate::camera::Camera;
use crate::camera::clip::Clip;
use crate::camera::lens::real_lens::RealLens;
use crate::camera::lens::real_lens::packet::Splats;
use crate::camera::shutter::Exposure;
use crate::film::{TileAccumulator, TileRect};
use crate::integrator::PreparedScene;
use crate::integrator::aimed::AimedLights;
use crate::integrator::bidirectional::{LightPath, Techniques};
use crate::integrator::path::parts::Parts;
use crate::integrator::path::{self, Limits, PathResult};
use crate::sampler::{PathSampler, pattern::Pattern, raster::Raster};
use crate::scene::motion::moment;
use bake::{Bake, BakePoints};
use film_first::FilmFirst;
use hero::Hero;
use motion::Motion;
use scene_first::SceneFirst;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// One in this many samples that are taken one by one is timed, to know the lens' share of the time without spending any.
const TIMED_EVERY: u64 = 61;

/// The order in which a sample is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Pipeline {
    /// Hero where the lens disperses, else film-first.
    #[default]
    Auto,
    /// Rays from a point of the film through the lens into the scene, one wavelength a path: [`film_first`].
    #[serde(rename = "FILM")]
    FilmFirst,
    /// Rays from a sharp point of the scene through the lens to the film: [`scene_first`].
    #[serde(rename = "SCENE")]
    SceneFirst,
    /// Film-first for one wavelength, whose light is carried back to the film at the others of its set: [`hero`].
    Hero,
}

impl Pipeline {
    /// The pipeline that a camera can run instead of the one that was asked for: hero with one wavelength is film-first, and only a lens
    /// that is traced can be entered from the scene.
    pub fn with(self, camera: &Camera) -> Self {
        self.of_packets(camera.traced_lens().map(RealLens::packet_size))
    }

    /// The pipeline for a camera by the number of wavelengths in a packet of its traced lens; `None` if it traces no lens. See
    /// [`Self::with`].
    pub fn of_packets(self, size: Option<usize>) -> Self {
        match (self, size) {
            (Self::SceneFirst, Some(_)) => Self::SceneFirst,
            (Self::Auto | Self::Hero, Some(2..)) => Self::Hero,
            _ => Self::FilmFirst,
        }
    }

    /// Name of the pipeline in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::FilmFirst => "film",
            Self::SceneFirst => "scene",
            Self::Hero => "hero",
        }
    }
}

/// The data that all samples of a render share.
pub struct RenderContext<'a> {
    /// The prepared scene that is rendered.
    pub stage: &'a PreparedScene,
    /// The camera at times that lie evenly over the time that the shutter is open; one, if the camera does not move.
    pub cameras: &'a [Camera],
    /// The clip planes of their rays; `None`: none.
    pub clip: Option<Clip>,
    /// The pipeline: one that the camera supports.
    pub pipeline: Pipeline,
    /// The techniques of light paths, if these are traced: with the real lens alone.
    pub light_paths: Option<Techniques>,
    /// The picture's pixels and their filter.
    pub raster: &'a Raster,
    /// Limits of light transport.
    pub limits: Limits,
    /// The source of all random numbers.
    pub pattern: Pattern,
    /// The motion of surfaces over the picture, if it is asked for.
    pub motion: Option<&'a Motion>,
    /// Times of samples, where anything but the lens moves, or the shutter is not simply open.
    pub exposure: Option<&'a Exposure>,
    /// The parts of the paths' light that are kept beside the whole and the groups.
    pub parts: &'a Parts,
    /// The lights that send rays to the lens: in [`Pipeline::Hero`] and with light paths alone.
    pub aimed: Option<Arc<AimedLights>>,
    /// The points of a surface on which paths start instead of in the camera.
    pub bake: Option<&'a BakePoints>,
}

impl RenderContext<'_> {
    /// The part of a camera's ray within the clip planes.
    #[inline]
    fn seen(&self, ray: Ray) -> Ray {
        self.clip.map_or(ray, |clip| clip.cut(ray))
    }

    /// The pixel whose random numbers a pixel has: its own but where points of a bake say otherwise.
    fn numbers_of(&self, pixel: [u32; 2]) -> [u32; 2] {
        let of_bake = self.bake.and_then(|points| points.point(pixel));
        of_bake.map_or(pixel, |point| point.numbers_of)
    }

    /// The number of a sample among all of the picture.
    fn number(&self, [x, y]: [u32; 2], index: u32) -> u64 {
        let (width, height) = self.raster.size();
        let [width, height, x, y, index] = [width, height, x, y, index].map(u64::from);
        index * width * height + y * width + x
    }

    /// The time of a sample, as a part of the exposure.
    fn time(&self, [x, y]: [u32; 2], index: u32) -> f32 {
        let mut sampler = self.pattern.pixel(x, y).sampler(index);
        sampler.jump_to(path::TIME_SET);
        let [u, ..] = sampler.next_4d();
        // A row rolls by its lower edge, as in Cycles.
        let up = y as f32 / self.raster.size().1 as f32 - 0.5;
        self.exposure.map_or(u, |exposure| exposure.part(u, up))
    }

    /// The number of the camera at that time.
    fn camera(&self, time: f32) -> usize {
        ((time * self.cameras.len() as f32) as usize).min(self.cameras.len() - 1)
    }

    /// True if samples have times.
    fn is_timed(&self) -> bool {
        self.cameras.len() > 1 || self.exposure.is_some()
    }
}

/// Counts of samples and rays, and times of the timed samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Samples asked of the camera.
    pub camera_rays: u64,
    /// Samples lost in the lens.
    pub camera_rays_lost: u64,
    /// Wavelengths at which light of samples was carried back through the lens.
    pub wavelengths_carried: u64,
    /// Rays traced through the scene.
    pub rays: u64,
    /// Samples that were dropped because they were not finite.
    pub non_finite: u64,
    /// Time of the timed samples in the camera.
    pub camera_time: Duration,
    /// All of the time of the timed samples.
    pub sample_time: Duration,
}

impl Counts {
    /// Adds the counts of `other`. They may come from a file, and be any: the sum then stops at the largest number.
    pub fn add(&mut self, other: &Self) {
        let of = |sum: &mut u64, more: u64| *sum = sum.saturating_add(more);
        of(&mut self.camera_rays, other.camera_rays);
        of(&mut self.camera_rays_lost, other.camera_rays_lost);
        of(&mut self.wavelengths_carried, other.wavelengths_carried);
        of(&mut self.rays, other.rays);
        of(&mut self.non_finite, other.non_finite);
        self.camera_time = self.camera_time.saturating_add(other.camera_time);
        self.sample_time = self.sample_time.saturating_add(other.sample_time);
    }
}

/// Adds samples `first..first + count` of every pixel of a tile to `light`; `None` where `stopped` said so.
pub fn render_tile(
    shot: &RenderContext<'_>,
    rect: TileRect,
    [first, count]: [u32; 2],
    light: &mut TileAccumulator,
    stopped: &dyn Fn() -> bool,
) -> Option<Counts> {
    let columns = rect.x..rect.x + rect.width;
    let pixels = (rect.y..rect.y + rect.height).flat_map(|y| columns.clone().map(move |x| [x, y]));
    render_pixels(shot, pixels, [first, count], light, stopped)
}

/// Adds samples `first..first + count` of any pixels to `light`; `None` where `stopped` said so.
pub fn render_pixels(
    shot: &RenderContext<'_>,
    pixels: impl Iterator<Item = [u32; 2]>,
    [first, count]: [u32; 2],
    light: &mut TileAccumulator,
    stopped: &dyn Fn() -> bool,
) -> Option<Counts> {
    let samples = pixels.flat_map(|pixel| (first..first + count).map(move |index| (pixel, index)));
    if let Some(points) = shot.bake {
        return stretch::render(Bake::new(shot, points), shot, samples, light, stopped);
    }
    match (shot.light_paths, shot.pipeline) {
        (Some(techniques), _) => render_light_paths(shot, techniques, samples, light, stopped),
        (None, Pipeline::Hero) => stretch::render(Hero::new(shot), shot, samples, light, stopped),
        (None, Pipeline::SceneFirst) => stretch::render(SceneFirst::new(shot), shot, samples, light, stopped),
        (None, _) => stretch::render(FilmFirst::new(shot), shot, samples, light, stopped),
    }
}

/// Renders one sample after the other, with a path from the camera and one from a light; `None` where `stopped` said so.
fn render_light_paths(
    shot: &RenderContext<'_>,
    techniques: Techniques,
    samples: impl Iterator<Item = ([u32; 2], u32)>,
    light: &mut TileAccumulator,
    stopped: &dyn Fn() -> bool,
) -> Option<Counts> {
    let mut counts = Counts::default();
    let mut light_path = LightPath::default();
    for ([x, y], index) in samples {
        if stopped() {
            return None;
        }
        let timed = counts.camera_rays.is_multiple_of(TIMED_EVERY).then(Instant::now);
        let time = if shot.is_timed() { shot.time([x, y], index) } else { 0.5 };
        let Some(lens) = shot.cameras[shot.camera(time)].traced_lens() else { continue };
        light_path.set_moment(moment(time));
        let one = Sample { shot, x, y, index, timed, counts: &mut counts, light };
        bidirectional::sample(lens, techniques, &mut light_path, one);
        if let Some(start) = timed {
            counts.sample_time += start.elapsed();
        }
    }
    Some(counts)
}

/// One sample of one pixel under way.
struct Sample<'a> {
    shot: &'a RenderContext<'a>,
    x: u32,
    y: u32,
    index: u32,
    timed: Option<Instant>,
    counts: &'a mut Counts,
    light: &'a mut TileAccumulator,
}

impl Sample<'_> {
    fn sampler(&self) -> PathSampler {
        self.shot.pattern.pixel(self.x, self.y).sampler(self.index)
    }

    /// Counts a camera ray; to be called when the camera has done its part.
    fn count_camera(&mut self, is_lost: bool) {
        self.counts.camera_rays += 1;
        self.counts.camera_rays_lost += u64::from(is_lost);
        if let Some(start) = self.timed {
            self.counts.camera_time += start.elapsed();
        }
    }

    /// Counts a path that was followed; false if its light is not finite.
    fn count_path(&mut self, found: &PathResult) -> bool {
        self.counts.rays += u64::from(found.rays);
        let is_finite = found.radiance.is_finite();
        self.counts.non_finite += u64::from(!is_finite);
        is_finite
    }

    /// Notes alpha and surface of the sample's ray, of the wavelength that `u_wavelength` chose, for the pixel that it belongs to.
    fn note(&mut self, found: &PathResult, ray: &Ray, u_wavelength: f32) {
        self.note_alpha(found);
        self.note_surface(found, ray, u_wavelength);
    }

    fn note_alpha(&mut self, found: &PathResult) {
        let seen = f32::from(u8::from(found.hit || !self.shot.limits.hide_sky));
        let alpha = seen - found.hole;
        self.light.add_alpha(self.x, self.y, alpha);
    }

    /// Notes the surface that the sample's ray found for the pixel that it belongs to.
    fn note_surface(&mut self, found: &PathResult, ray: &Ray, u_wavelength: f32) {
        self.light.add_data(self.x, self.y, found.first);
        if let Some(motion) = self.shot.motion {
            let vector = motion.vector(&self.shot.stage.scene, ray, u_wavelength, found.first.as_ref());
            if let Some(vector) = vector {
                self.light.add_vector(self.x, self.y, vector);
            }
        }
    }

    /// Adds the light of a ray to the pixels where it arrives.
    fn splat(&mut self, lens: &RealLens, splats: &Splats, radiance: Rgb) {
        add_splats(self.light, lens, splats, radiance);
    }

    /// Notes a sample that was lost in the lens: black, not transparent, for the lens is in the way.
    fn lost(&mut self) {
        self.light.add_alpha(self.x, self.y, if self.shot.limits.hide_sky { 0.0 } else { 1.0 });
    }
}

/// Adds radiance along a ray to the pixels where it arrives.
fn add_splats(light: &mut TileAccumulator, lens: &RealLens, splats: &Splats, radiance: Rgb) {
    lens.expose(splats, radiance, |x, y, light_there| light.add_wide(x, y, light_there));
}

#[cfg(test)]
mod tests;
