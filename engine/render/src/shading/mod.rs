//! Scattering at surfaces: Fresnel terms, microfacets and other lobes, Blender's Principled BSDF made of them, and mixtures of any
//! closures.
//!
//! Each scattering model comes in three: sample, density, evaluate. Directions point away from the surface: `wo`
//! to where the path came from, `wi` to where it goes (pbrt's words).

pub mod albedo;
mod beckmann;
pub mod energy;
pub mod fresnel;
mod hair;
mod layered;
mod lobe;
pub mod microfacet;
pub mod mixture;
pub mod normal;
mod parted;
pub mod principled;
pub mod subsurface;
mod thin_film;

use crate::Rgb;
use crate::scene::visibility::Rays;
use glam::Vec3A;
pub use parted::{Features, LobeDecomposition, LobeShares, SurfaceMeans};
use serde::Deserialize;

/// A direction to go on in.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit, away from the surface.
    pub wi: Vec3A,
    /// BSDF times cosine over density.
    pub weight: Rgb,
    /// Density per steradian; meaningless where `mirror`.
    pub pdf: f32,
    /// True for a single direction, which no light sample can find.
    pub mirror: bool,
    /// True if the direction goes through the surface.
    pub transmitted: bool,
    /// True if a diffuse lobe chose it.
    pub matte: bool,
}

/// The caustics that are computed: light that surfaces reflect or refract after a diffuse scattering of the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Caustics {
    /// True if reflective caustics are computed.
    pub reflective: bool,
    /// True if refractive caustics are computed.
    pub refractive: bool,
}

impl Caustics {
    /// Reflective and refractive caustics are computed.
    pub const ALL: Self = Self { reflective: true, refractive: true };
}

/// The past of a path, as far as the scattering of surfaces depends on it.
#[derive(Clone, Copy, Debug)]
pub struct Past {
    /// The surfaces that reflect and refract light.
    pub caustics: Caustics,
    /// True if one of its scatterings was diffuse.
    pub is_blurred: bool,
    /// Width of the pixel at the surface that the camera sees, Blender units; 0 of a path that was scattered.
    pub pixel_width: f32,
}

/// The scattering of light at one point seen from one direction.
pub trait Scattering {
    /// The normal that scattering is about, where light from behind it does not matter; `None` where light may
    /// come through.
    fn receiving_normal(&self) -> Option<Vec3A>;

    /// True if only mirror lobes scatter here: light samples are of no use.
    fn is_mirror(&self) -> bool;

    /// BSDF times cosine, and the density with which [`Scattering::sample`] chooses `wi`. Mirror lobes count nothing.
    fn evaluate(&self, wi: Vec3A) -> (Rgb, f32);

    /// [`Scattering::evaluate`] of only those closures that light of some kinds of ray reaches: `rays` says which.
    fn evaluate_some(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32);

    /// [`Scattering::evaluate_some`] as if the triangle lay along its smooth normal: light on the side of that normal comes from above.
    fn evaluate_smooth(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32);

    /// A direction chosen roughly in proportion to the light that it scatters; `None` where the light ends here. The first number of `u`
    /// chooses the lobe, and the rest of it a direction in the lobe, with the second: of two numbers of the sequence any part stays
    /// stratified, of three it does not. `u_split` chooses between reflection and refraction.
    fn sample(&self, u_split: f32, u: [f32; 2]) -> Option<BsdfSample>;

    /// A way into the body, where the lobe that [`Scattering::sample`] would choose is one of light that comes out
    /// elsewhere.
    fn enter(&self, _u: [f32; 2]) -> Option<subsurface::Entry> {
        None
    }

    /// The value of the mirror lobes together along one reflected or refracted direction, and the probability with which
    /// [`Scattering::sample`] chooses it. For paths from the light, which know both ends of a mirror before they look at it from the
    /// camera's side.
    fn mirror(&self, transmitted: bool, wi: Vec3A) -> (Rgb, f32);

    /// The index of refraction beyond the surface over that on the side of `wo`.
    fn relative_index(&self) -> f32;

    /// Cosine of a direction to the normal that scattering is about, on either side.
    fn cosine(&self, d: Vec3A) -> f32;
}
