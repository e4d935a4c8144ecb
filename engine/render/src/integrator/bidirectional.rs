//! Bidirectional path tracing (Veach 1997, chapter 10): a path from the camera and one from a light, joined in every way,
//! each way weighted by how likely all the others are to make the same path ([`weights`]).
//!
//! Paths are those of [`super::path`], and so is the picture, but for [`super::path::Approximations`]: none of them is made.
//! The lens takes part as a whole: light paths aim at its
//! entrance pupil and are carried to the film.

mod eye;
mod light;
mod vertex;
mod weights;

use super::PreparedScene;
use super::aimed::AimedLights;
use super::path::{Limits, PathResult};
use crate::Rgb;
use crate::accel::Ray;
use crate::camera::clip::Clip;
use crate::camera::lens::real_lens::RealLens;
use crate::lights::Source;
use crate::sampler::{PathSampler, raster::Raster};
use glam::Affine3A;
use vertex::Vertex;

/// The techniques by which paths are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Techniques {
    /// Every way in which a path from the camera and one from a light can be joined.
    All,
    /// Light that ends in the lens after at least one scattering, and nothing else.
    LightAlone,
}

/// A ray that the camera led to.
pub struct CameraEnd<'a> {
    /// The real lens through which the ray comes.
    pub lens: &'a RealLens,
    /// The ray in render space; as long as the camera sees.
    pub ray: Ray,
    /// Density of the ray's choice, per unit of etendue ([`crate::camera::from_scene`]).
    pub density: f64,
    /// The transform from the lens's place in the middle of the exposure to its present place; `None`: it stands still.
    pub way: Option<Affine3A>,
    /// The lights that send rays to the lens; `None`: the camera alone finds the light that goes straight to it.
    pub aimed: Option<&'a AimedLights>,
}

/// The lens and film that light paths are connected to.
pub struct FilmEnd<'a> {
    /// The lens that light paths aim at.
    pub lens: &'a RealLens,
    /// The picture behind the lens.
    pub raster: &'a Raster,
    /// The clip planes of the camera; `None` if it has none.
    pub clip: Option<Clip>,
    /// The techniques that are in use.
    pub techniques: Techniques,
    /// The transform from the lens's place in the middle of the exposure to its present place; `None`: it stands still.
    pub way: Option<Affine3A>,
}

/// Scattering places of a light path; kept from one path to the next, so that nothing is allocated on the way.
#[derive(Default)]
pub struct LightPath {
    places: Vec<Vertex>,
    /// Bounces of a path from the camera after which the source lights nothing more.
    most_bounces: u32,
    moment: u16,
}

impl LightPath {
    /// Sets the moment of the path's rays, as in [`Ray::moment`].
    pub fn set_moment(&mut self, moment: u16) {
        self.moment = moment;
    }

    /// The moment of the light path.
    pub fn moment(&self) -> u16 {
        self.moment
    }

    /// Follows light from a source. Gives the rays traced.
    pub fn trace(&mut self, stage: &PreparedScene, limits: &Limits, sampler: PathSampler) -> u32 {
        light::trace(stage, limits, sampler, self.moment, self)
    }

    /// Calls `add` with the light for the film, pixel by pixel, for one light path a pixel. Returns the number of rays traced.
    pub fn splat(
        &self,
        stage: &PreparedScene,
        film: &FilmEnd<'_>,
        limits: &Limits,
        sampler: PathSampler,
        add: impl FnMut(u32, u32, Rgb),
    ) -> u32 {
        light::splat(stage, film, limits, sampler, self, add)
    }

    /// Follows a ray from the camera and joins it to this.
    pub fn join(
        &self,
        stage: &PreparedScene,
        camera: &CameraEnd<'_>,
        limits: &Limits,
        sampler: PathSampler,
    ) -> PathResult {
        eye::trace(stage, camera, limits, sampler, self)
    }
}

/// Follows a ray that a source sent straight to the lens, turned round, and finds the light of that source alone.
pub fn see(stage: &PreparedScene, ray: Ray, source: Source, limits: &Limits, sampler: PathSampler) -> PathResult {
    eye::see(stage, ray, source, limits, sampler)
}

/// True if the light is zero or not finite, so that there is nothing to add.
fn is_dark(light: Rgb) -> bool {
    light == Rgb::ZERO || !light.is_finite()
}
