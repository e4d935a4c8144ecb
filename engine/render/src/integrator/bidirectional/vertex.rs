//! A place where a path from either side scatters, and the stretch of a ray that leads to one.

use super::weights::Partial;
use crate::accel::{Hit, Ray, offset_origin};
use crate::integrator::PreparedScene;
use crate::integrator::path::{MOST_STEPS, leave, mix, opening};
use crate::nodes::{self, Layers, PathState, RayCone, Transparency, View};
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::scene::plain::PlainValues;
use crate::scene::visibility::Rays;
use crate::shading::mixture::Mixture;
use crate::shading::principled::Bsdf;
use crate::shading::{BsdfSample, Scattering};
use crate::surface::SurfacePoint;
use crate::{Rgb, scene::material::Material};
use glam::Vec3A;

/// The sampler's sets of four numbers used at each surface.
const SETS_PER_STEP: u32 = 3;

/// A point where a path scatters.
pub(super) struct Vertex {
    /// The point, seen from the side that made it.
    pub(super) point: SurfacePoint,
    /// Inputs of a plain surface.
    values: Option<PlainValues>,
    /// Weight of the surface over the probability that it was not passed.
    kept: f32,
    /// BSDF, seen from the direction that the path came from.
    pub(super) bsdf: VertexSurface,
    /// Unit direction back along the path.
    pub(super) back: Vec3A,
    /// The weight of radiance that leaves towards the camera, on a path from it; the power that arrives, on a path from the light.
    pub(super) carried: Rgb,
    pub(super) partial: Partial,
    /// The state in which a path from the camera comes to the vertex: on a path from the light, which cannot know it, after a diffuse
    /// reflection.
    pub(super) way: PathState,
    /// The kinds of rays of a path from the camera that may leave a vertex of a light path along `back`.
    pub(super) kinds: Rays,
}

impl Vertex {
    /// `back` and the state in which a path from the camera comes to the vertex.
    pub(super) fn new(
        stage: &PreparedScene,
        met: (SurfacePoint, f32),
        (back, way): (Vec3A, PathState),
        carried: Rgb,
        partial: Partial,
        kinds: Rays,
    ) -> Self {
        let (point, kept) = met;
        let values = plain(stage, &point, back, way);
        let bsdf = VertexSurface::new(stage, values.as_ref(), kept, &point, back, way);
        Self { point, values, kept, bsdf, back, carried, partial, way, kinds }
    }

    /// The scattering at the vertex, seen from the other end of `d`.
    pub(super) fn seen_from(&self, stage: &PreparedScene, d: Vec3A) -> VertexSurface {
        VertexSurface::new(stage, self.values.as_ref(), self.kept, &self.point.seen_from(d), d, self.way)
    }

    /// The scattering at the vertex, seen from the other end of `d` by a path from the camera in the state `way`.
    fn seen_in(&self, stage: &PreparedScene, d: Vec3A, way: PathState) -> VertexSurface {
        if way == self.way || !material(stage, &self.point).asks_path {
            return self.seen_from(stage, d);
        }
        let point = self.point.seen_from(d);
        VertexSurface::new(stage, plain(stage, &point, d, way).as_ref(), self.kept, &point, d, way)
    }

    /// Cosine to the triangle's own normal.
    pub(super) fn cos(&self, d: Vec3A) -> f32 {
        self.point.geometric_normal.dot(d).abs()
    }

    /// A ray that leaves it.
    pub(super) fn ray(&self, d: Vec3A) -> Ray {
        self.point.leaving(leave(&self.point, d), d)
    }

    /// Power that arrived from a light and leaves along `d`, towards the camera, as radiance times area at right angles
    /// to the ray; and the density per steradian with which a path from the camera, which comes in the state `way`, would go on to the light.
    ///
    /// The scattering function is taken in the camera's sense, as it is not symmetric; the cosines are those that turn
    /// radiance into power and back, of the triangle itself (Veach 1997, section 5.3).
    pub(super) fn sent(&self, stage: &PreparedScene, d: Vec3A, way: PathState) -> (Rgb, f32) {
        let seen = self.seen_in(stage, d, way);
        let (value, pdf) = seen.evaluate_kinds(self.back, self.kinds);
        (self.carried * value * (self.cos(d) / self.cos(self.back)), pdf)
    }
}

/// The BSDF at a vertex.
// Vertices are kept one after the other, and most materials of a scene are of the small kind.
#[allow(clippy::large_enum_variant)]
pub(super) enum VertexSurface {
    Plain(Bsdf),
    Layers(Mixture),
}

/// Inputs of a plain surface; `None` of any other.
fn plain(stage: &PreparedScene, point: &SurfacePoint, back: Vec3A, way: PathState) -> Option<PlainValues> {
    let material = material(stage, point);
    material.plain().map(|plain| {
        let at_point =
            || nodes::plain_values(material, plain, stage.around(), point, &seen(&stage.scene, point, back, way));
        plain.constants.unwrap_or_else(at_point)
    })
}

/// The view of a point by a path in a state, `wo` towards the ray's origin. The footprint is that of a pixel that shows the point itself,
/// whichever end the path began at.
fn seen(scene: &Scene, point: &SurfacePoint, wo: Vec3A, way: PathState) -> View {
    let distance = point.position.length();
    let cone = RayCone::pixel(&scene.viewport);
    let is_blurry = !way.is_camera();
    View { direction: -wo, distance, way, moment: point.moment, is_blurry, cone }
}

impl VertexSurface {
    fn new(
        stage: &PreparedScene,
        values: Option<&PlainValues>,
        kept: f32,
        point: &SurfacePoint,
        wo: Vec3A,
        way: PathState,
    ) -> Self {
        if let Some((values, tables)) = values.zip(stage.plain_tables[point.material as usize].as_deref()) {
            let mut bsdf = Bsdf::new(tables, values, point, wo);
            bsdf.scale(values.weight * kept);
            return Self::Plain(bsdf);
        }
        let mut layers = Layers::default();
        nodes::layers(material(stage, point), stage.around(), point, &seen(&stage.scene, point, wo, way), &mut layers);
        let mut mixture = Mixture::empty();
        mix(&mut mixture, stage, &layers, point, wo, kept, None);
        Self::Layers(mixture)
    }
}

impl VertexSurface {
    /// [`Scattering::evaluate`] for rays of these kinds.
    pub(super) fn evaluate_kinds(&self, wi: Vec3A, kinds: Rays) -> (Rgb, f32) {
        if kinds.all_of(Rays::BOUNCE) { self.evaluate(wi) } else { self.evaluate_some(wi, kinds) }
    }
}

/// Calls a method of the BSDF of either kind.
macro_rules! ask {
    ($surface:expr, $bsdf:ident => $answer:expr) => {
        match $surface {
            VertexSurface::Plain($bsdf) => $answer,
            VertexSurface::Layers($bsdf) => $answer,
        }
    };
}

impl Scattering for VertexSurface {
    fn receiving_normal(&self) -> Option<Vec3A> {
        ask!(self, bsdf => bsdf.receiving_normal())
    }

    fn is_mirror(&self) -> bool {
        ask!(self, bsdf => bsdf.is_mirror())
    }

    fn evaluate(&self, wi: Vec3A) -> (Rgb, f32) {
        ask!(self, bsdf => bsdf.evaluate(wi))
    }

    fn evaluate_some(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        ask!(self, bsdf => bsdf.evaluate_some(wi, rays))
    }

    fn evaluate_smooth(&self, wi: Vec3A, rays: Rays) -> (Rgb, f32) {
        ask!(self, bsdf => bsdf.evaluate_smooth(wi, rays))
    }

    fn sample(&self, u_split: f32, u: [f32; 2]) -> Option<BsdfSample> {
        ask!(self, bsdf => bsdf.sample(u_split, u))
    }

    fn mirror(&self, transmitted: bool, wi: Vec3A) -> (Rgb, f32) {
        ask!(self, bsdf => bsdf.mirror(transmitted, wi))
    }

    fn relative_index(&self) -> f32 {
        ask!(self, bsdf => bsdf.relative_index())
    }

    fn cosine(&self, d: Vec3A) -> f32 {
        ask!(self, bsdf => bsdf.cosine(d))
    }
}

pub(super) fn material<'a>(stage: &'a PreparedScene, point: &SurfacePoint) -> &'a Material {
    &stage.scene.materials[point.material as usize]
}

/// Transmittance of a surface for a ray that goes on unbent and is no shadow ray.
pub(super) fn passed(scene: &Scene, hit: &Hit, view: &View) -> Rgb {
    let point = SurfacePoint::new(scene, hit, view.direction);
    opening(scene, &point, view).light
}

/// A ray from one scattering to the next.
pub(super) struct RayStretch {
    /// The surface interaction at its end, if there is one.
    pub(super) end: Option<(SurfacePoint, Hit)>,
    /// Length of the ray; infinite where it leaves the scene.
    pub(super) distance: f32,
    /// Transmittance of the surfaces that the ray passed, over the probability of passing them.
    pub(super) through: Rgb,
    /// Weight of the surface at its end over the probability that it was not passed.
    pub(super) kept: f32,
    /// Random numbers to choose a light at its end, and a place on it.
    pub(super) u_light: [f32; 3],
}

/// A walk through the scene from either end, with its own random numbers.
pub(super) struct Walk<'a> {
    pub(super) stage: &'a PreparedScene,
    pub(super) sampler: PathSampler,
    /// Set of the sampler with which its first step begins.
    pub(super) first_set: u32,
    pub(super) step: u32,
    pub(super) rays: u32,
}

impl Walk<'_> {
    /// Follows a ray of a path in a state over surfaces that let it pass unbent. `stops` may turn a hit away, given a uniform number.
    pub(super) fn follow(
        &mut self,
        ray: Ray,
        kind: Rays,
        way: PathState,
        stops: impl Fn(&Hit, f32) -> bool,
    ) -> RayStretch {
        let mut ray = ray;
        let mut distance = 0.0;
        let mut through = Rgb::ONE;
        while self.step < MOST_STEPS {
            self.rays += 1;
            let Some(hit) = self.stage.accel.closest(&ray, kind) else { break };
            self.sampler.jump_to(self.first_set + self.step * SETS_PER_STEP);
            self.step += 1;
            let point = SurfacePoint::new(&self.stage.scene, &hit, ray.direction);
            let [u0, u1, u_light, u_alpha] = self.sampler.next_4d();
            distance += hit.t;
            let scene = &self.stage.scene;
            let view = View::along(&ray, RayCone::pixel(&scene.viewport), distance, way);
            let opening = self.opening(&point, &view);
            let stays = 1.0 - opening.chance;
            if u_alpha >= stays {
                through *= opening.light / opening.chance;
            } else if stops(&hit, u_alpha / stays) {
                let (end, kept) = (Some((point, hit)), opening.kept);
                return RayStretch { end, distance, through, kept, u_light: [u_light, u0, u1] };
            }
            let origin = offset_origin(point.position, -point.geometric_normal, point.position_error);
            ray = Ray { t_max: ray.t_max - hit.t, ..point.leaving(origin, ray.direction) };
        }
        let distance = distance + ray.t_max;
        RayStretch { end: None, distance, through, kept: 1.0, u_light: [0.0; 3] }
    }

    /// Transparency of a surface. A ray from a light is a shadow ray for surfaces that it passes, and a bounce of the camera's path for the
    /// surface that it comes to: where the surface tells these apart, chance decides which it is.
    fn opening(&self, point: &SurfacePoint, view: &View) -> Transparency {
        let (scene, material) = (&self.stage.scene, material(self.stage, point));
        if !view.way.is_shadow() || !(material.asks_path || material.shades_fully) {
            return opening(scene, point, view);
        }
        let met = opening(scene, point, &View { way: PathState::BOUNCE, ..*view });
        let kept = met.kept * (1.0 - met.chance);
        let light = if material.shades_fully { Rgb::ZERO } else { opening(scene, point, view).light };
        let chance = if light == Rgb::ZERO { 0.0 } else { 0.5 };
        Transparency { chance, light, kept: kept / (1.0 - chance), ..met }
    }
}
