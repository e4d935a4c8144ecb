//! Path tracing with next-event estimation: at every surface one light is sampled and one direction, each
//! weighted by how well the other technique would have found the same light (power heuristic, Veach 1995).
//!
//! Many paths go on together: see [`Wavefront`].

mod approximations;
mod by_part;
mod choice;
mod notes;
pub mod parts;
mod pilot;
mod terminator;
mod wave;

pub use approximations::{Approximations, FastGi};
pub use notes::{AovBuffers, AovSink, NoAovs};
pub use pilot::{openness, roulette};
pub use wave::{SurfaceStart, Wavefront};

use super::PreparedScene;
use crate::Rgb;
use crate::accel::{Hit, Ray, offset_origin};
use crate::nodes::{self, Layers, PathState, SceneQueries, Transparency, View};
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::shading::{Caustics, Past, mixture::Mixture};
use crate::surface::{SurfacePoint, strand, tangent_about_z};
use glam::Vec3A;
use serde::Deserialize;

/// Bounces before Russian roulette may end a path of light.
pub(super) const SURE_BOUNCES: u32 = 3;
/// Surfaces that a path may pass unbent or scatter at, in all: a bound for stacks of transparent leaves.
pub(super) const MOST_STEPS: u32 = 512;
/// The sampler's sets of four numbers that the camera uses before the path begins.
pub const CAMERA_SETS: u32 = 3;
/// The last of the sampler's sets for the camera: its first number is the time.
pub const TIME_SET: u32 = 2;
/// Sets used at each surface.
const SETS_PER_STEP: u32 = 2;

/// The result of one path.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathResult {
    /// Radiance along the camera ray.
    pub radiance: Rgb,
    /// True if the ray reached something other than the world directly behind transparent surfaces.
    pub hit: bool,
    /// The part of the first hit that is a hole.
    pub hole: f32,
    /// Rays traced, shadow rays included.
    pub rays: u32,
    /// The first surface that the ray did not pass.
    pub first: Option<FirstSurface>,
}

/// A surface that a camera ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSurface {
    /// Position of the hit in render space, Blender units.
    pub position: Vec3A,
    /// Unit, towards the ray's origin.
    pub normal: Vec3A,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Index of the material.
    pub material: u32,
    /// Barycentric weights of the second and third corner.
    pub barycentric: [f32; 2],
}

impl From<&SurfacePoint> for FirstSurface {
    fn from(p: &SurfacePoint) -> Self {
        let SurfacePoint { position, instance, triangle, material, barycentric, .. } = *p;
        Self { position, normal: p.shading_normal, instance, triangle, material, barycentric }
    }
}

/// Limits and settings of light transport.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Bounces after the first surface.
    pub max_bounces: u32,
    /// The most bounces of each kind.
    pub kinds: KindLimits,
    /// Most radiance, in the mean of its channels, that light may add which the camera sees, or which is scattered once: fewer bright
    /// specks for less light. Infinite: no limit.
    pub clamp_direct: f32,
    /// Most radiance, in the mean of its channels, that light scattered more than once may add. Infinite: no limit.
    pub clamp_indirect: f32,
    /// Approximations of indirect light.
    pub approximations: Approximations,
    /// True if the world and suns light the scene but the camera does not see them.
    pub hide_sky: bool,
    /// The most product of the widths of facets through which a path that is refracted still counts as one that only passed: where the
    /// sky is hidden, the film is transparent behind such glass, too. `None`: no glass is such.
    pub film_glass: Option<f32>,
    /// The part of the sky that is seen from a surface, on average: see [`openness`]. Only noise depends on it.
    pub openness: f32,
    /// Factor of Russian roulette: a path from the camera goes on with a probability of this times its throughput over that of its first
    /// scattering, at most 1: see [`roulette`].
    pub roulette: f32,
}

/// The most scatterings of each kind, and the caustics that are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KindLimits {
    /// Reflections without a peak.
    pub diffuse: u32,
    /// Reflections about a peak, or mirrored.
    pub glossy: u32,
    /// Transmissions that scatter light; unbent ones count as `transparent`.
    pub transmission: u32,
    /// Scatterings in volumes.
    pub volume: u32,
    /// Surfaces that a path passes unbent.
    pub transparent: u32,
    /// Surfaces that a shadow ray may pass unbent, those of the path before it included.
    pub transparent_shadows: u32,
    /// The surfaces that reflect and refract light after a diffuse scattering.
    pub caustics: Caustics,
}

impl Default for KindLimits {
    fn default() -> Self {
        let [diffuse, glossy, transmission, volume, transparent, transparent_shadows] = [u32::MAX; 6];
        Self { diffuse, glossy, transmission, volume, transparent, transparent_shadows, caustics: Caustics::ALL }
    }
}

impl Limits {
    /// True if a path may be scattered by the next surface and by volumes before it.
    #[inline]
    pub(super) fn scatters(&self, way: PathState) -> bool {
        self.scatters_before_the_sky(way) && self.approximations.fast_gi.last_ray(way).is_none()
    }

    /// True if a path may be scattered by volumes on the way to infinity.
    #[inline]
    pub(super) fn scatters_before_the_sky(&self, way: PathState) -> bool {
        let KindLimits { diffuse, glossy, transmission, .. } = self.kinds;
        u32::from(way.depth) <= self.max_bounces
            && u32::from(way.diffuse) <= diffuse
            && u32::from(way.glossy) <= glossy
            && u32::from(way.transmission) <= transmission
            && self.goes_on(way)
    }

    /// True if a path may pass or be scattered by the next surface. As in Cycles, it passes the first surface in any case.
    #[inline]
    pub(super) fn goes_on(&self, way: PathState) -> bool {
        way.transparent == 0 || u32::from(way.transparent) < self.kinds.transparent
    }

    /// Surfaces that a ray from there to a light may pass.
    #[inline]
    pub(super) fn shadows_pass(&self, way: PathState) -> u32 {
        self.kinds.transparent_shadows.saturating_sub(u32::from(way.transparent))
    }

    /// The surfaces that reflect and refract light for a path in this state.
    #[inline]
    pub(super) fn caustics(&self, way: PathState) -> Caustics {
        if way.is_diffuse() { self.kinds.caustics } else { Caustics::ALL }
    }

    /// Light that a light sample found after `bounce` bounces, as far as it counts.
    #[inline]
    pub(super) fn clamp(&self, light: Rgb, bounce: u32) -> Rgb {
        let most = if bounce > 0 { self.clamp_indirect } else { self.clamp_direct };
        let mean = light.abs().element_sum() / 3.0;
        if mean > most { light * (most / mean) } else { light }
    }

    /// Light of an emitter that a path hit after `bounce` bounces, as far as it counts: a light sample would have found it a bounce
    /// before.
    #[inline]
    pub(super) fn clamp_met(&self, light: Rgb, bounce: u32) -> Rgb {
        self.clamp(light, bounce.saturating_sub(1))
    }
}

/// Follows a ray from the camera.
pub fn trace(stage: &PreparedScene, camera_ray: Ray, limits: &Limits, sampler: &mut PathSampler) -> PathResult {
    let mut found = PathResult::default();
    trace_all(stage, std::iter::once((camera_ray, sampler.clone())), limits, |_, result| found = result);
    found
}

/// Follows rays from the camera together, and returns their results by number.
pub fn trace_all(
    stage: &PreparedScene,
    rays: impl Iterator<Item = (Ray, PathSampler)>,
    limits: &Limits,
    found: impl FnMut(usize, PathResult),
) {
    if stage.media.is_empty() {
        Wavefront::<NoAovs, false>::noting(NoAovs).trace_all(stage, rays, limits, found);
    } else {
        Wavefront::<NoAovs, true>::noting(NoAovs).trace_all(stage, rays, limits, found);
    }
}

impl<const VOLUMES: bool> Wavefront<NoAovs, VOLUMES> {
    fn trace_all(
        mut self,
        stage: &PreparedScene,
        rays: impl Iterator<Item = (Ray, PathSampler)>,
        limits: &Limits,
        mut found: impl FnMut(usize, PathResult),
    ) {
        let mut count = 0;
        for (ray, sampler) in rays {
            self.start(ray, sampler);
            count += 1;
        }
        self.follow(stage, limits);
        (0..count).for_each(|number| found(number, self.found(number)));
    }
}

/// A start for a ray that leaves a surface along `d`, on the side that it goes to.
pub(super) fn leave(point: &SurfacePoint, d: glam::Vec3A) -> glam::Vec3A {
    let n = point.geometric_normal;
    offset_origin(point.position, if n.dot(d) < 0.0 { -n } else { n }, point.position_error)
}

/// The opening of a surface: how it lets light through unbent.
#[inline]
pub(super) fn opening<'a>(around: impl Into<SceneQueries<'a>>, point: &SurfacePoint, view: &View) -> Transparency {
    let around = around.into();
    let material = &around.scene.materials[point.material as usize];
    if material.may_be_transparent() { nodes::opening(material, around, point, view) } else { Transparency::NONE }
}

/// Transmittance of a surface for a shadow ray.
#[inline]
pub(super) fn transmittance(scene: &Scene, hit: &Hit, view: &View) -> Rgb {
    let instance = &scene.instances[hit.instance as usize];
    let slot = scene.meshes[instance.mesh as usize].slot(hit.triangle);
    let material = &scene.materials[instance.material(slot) as usize];
    let shades_fully = material.shades_fully && !material.graph.is_only_volume();
    if shades_fully || !material.may_be_transparent() {
        return Rgb::ZERO;
    }
    nodes::transmittance(material, scene.into(), [hit.instance, hit.triangle], [hit.u, hit.v], view)
}

/// Makes a mixture of the lobes of a surface of these layers at a point; `kept` is its weight. Light goes through bodies where the
/// path's past is given, or is scattered where it enters them.
#[inline(never)]
pub(super) fn mix(
    mixture: &mut Mixture,
    stage: &PreparedScene,
    layers: &Layers,
    point: &SurfacePoint,
    wo: Vec3A,
    kept: f32,
    past: Option<Past>,
) {
    // As in Cycles such a normal is the smooth one, too: light is not dimmed as by a bump on it.
    let bent = layers.bent_normal.map(|normal| SurfacePoint { shading_normal: normal, ..*point });
    let point = bent.as_ref().unwrap_or(point);
    let brushed = layers.closures.iter().any(|layer| layer.closure.is_brushed());
    let tangent = if brushed { tangent_about_z(&stage.scene, point) } else { Vec3A::ZERO };
    mixture.begin(point, wo, tangent, past.is_some());
    mixture.correct_bumps(stage.scene.materials[point.material as usize].corrects_bumps);
    if let Some(past) = past {
        mixture.set_past(past);
    }
    for layer in &layers.closures {
        mixture.set_directions(
            layer.coat_normal.unwrap_or(point.shading_normal),
            layer.tangent.filter(|_| brushed).unwrap_or(tangent),
        );
        if layer.closure.is_hair() {
            mixture.set_strand(strand(&stage.scene, point), layer.tangent);
        }
        mixture.add(layer.weight, &layer.closure, layer.normal.unwrap_or(point.shading_normal));
    }
    mixture.finish(kept);
}

#[cfg(test)]
mod tests;
