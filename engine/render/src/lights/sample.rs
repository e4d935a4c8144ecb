//! A sample of the lights.

use crate::Rgb;
use crate::scene::visibility::{LightSets, Rays};
use glam::Vec3A;

/// Light that reaches a point from one direction, if nothing stands in between.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, towards the light.
    pub wi: Vec3A,
    /// Distance of the light, Blender units; infinite for suns and the world.
    pub distance: f32,
    /// Radiance; for a light without extent, radiance times the solid angle that it has not.
    pub radiance: Rgb,
    /// Density per steradian, the choice of the light included; for a light without extent the choice alone.
    pub pdf: f32,
    /// True if the light has no extent: no ray can hit it.
    pub point_like: bool,
    /// True if objects cast shadows in the light.
    pub cast_shadow: bool,
    /// The kinds of ray that find it, and so the closures that it lights.
    pub reaches: Rays,
    /// The objects that the light lights, and those that cast shadows in it.
    pub sets: LightSets,
    /// The departure of light from the surface that emits, or from an area lamp or a lamp without extent: a surface at the light's
    /// distance, but for rounding, does not hide it.
    pub leaves: Option<Leaving>,
}

/// The departure of light from a surface.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    /// The cosine to the emitter's normal, positive.
    pub cos: f32,
    /// Bound of the rounding error of the surface's position, Blender units.
    pub error: f32,
}

impl LightSample {
    /// Length of a shadow ray to this light, whose start may be `error` from the place that the light arrives at. Blender units.
    #[inline]
    pub fn reach(&self, error: f32) -> f32 {
        (self.distance - self.gap(error)).max(0.0)
    }

    /// Distance of the shadow ray's end from the light: before the surface that it comes from, which must not shadow itself.
    #[inline]
    pub fn gap(&self, error: f32) -> f32 {
        self.leaves.map_or(0.0, |leaves| (leaves.error + error) / leaves.cos)
    }
}
