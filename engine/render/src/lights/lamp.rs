//! Blender's lamps, with the brightness that Cycles gives them. A kind is a file of its own, an implementation of [`LampShape`], and is
//! listed here: as a module, in [`AnyShape`], in its conversion, and in `with_shape`.
//!
//! Densities of rays that leave a lamp are counted per unit of etendue, Blender units squared times steradians at right angles to the
//! ray, which a ray keeps as it travels: so they are the same wherever it arrives.

mod area;
mod ball;
mod point;
mod rectangle;
pub(super) mod shape;
mod spot;
mod sun;

use super::LightSample;
use super::bounds::LightBounds;
use crate::nodes::PathState;
use crate::nodes::lamp::{LampPoint, even_radiance, radiance};
use crate::scene::Scene;
use crate::scene::graph::Graph;
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::visibility::{LightSets, Rays};
use crate::{Rgb, luminance};
use area::AreaLamp;
use ball::Ball;
use glam::{Affine3A, Vec3A};
use point::PointLamp;
pub(super) use shape::LampExtent;
use shape::{LampFrame, LampRay, LampShape, LampView};
use spot::SpotLamp;
use std::sync::Arc;
use sun::SunLamp;

/// The shape of a lamp of any kind.
#[derive(Clone, Copy, Debug)]
enum AnyShape {
    Point(PointLamp),
    Spot(SpotLamp),
    Sun(SunLamp),
    Area(AreaLamp),
}

impl From<LampKind> for AnyShape {
    fn from(kind: LampKind) -> Self {
        match kind {
            LampKind::Point { radius, soft } => Self::Point(PointLamp(Ball { radius, soft })),
            LampKind::Spot { radius, half_angle_rad, blend, soft } => {
                Self::Spot(SpotLamp { ball: Ball { radius, soft }, half_angle_rad, blend })
            }
            LampKind::Sun { half_angle_rad } => Self::Sun(SunLamp { half_angle_rad }),
            LampKind::Area { size, ellipse, half_spread_rad } => {
                Self::Area(AreaLamp { size, ellipse, half_spread_rad })
            }
        }
    }
}

/// Evaluates an expression of the [`LampShape`] in an [`AnyShape`], compiled for each kind.
macro_rules! with_shape {
    ($any:expr, $shape:ident => $value:expr) => {
        match &$any {
            AnyShape::Point($shape) => $value,
            AnyShape::Spot($shape) => $value,
            AnyShape::Sun($shape) => $value,
            AnyShape::Area($shape) => $value,
        }
    };
}

/// A lamp with its constants worked out.
#[derive(Clone, Debug)]
pub struct PreparedLamp {
    shape: AnyShape,
    frame: LampFrame,
    color: Rgb,
    max_bounces: u32,
    graph: Option<Arc<Graph>>,
    /// The origin of render space, in Blender's world.
    origin: Vec3A,
}

/// Roundings of coordinates between a lamp's place and the hit of a surface there, in units of the last place.
const ROUNDINGS: f32 = 16.0;

impl PreparedLamp {
    pub(super) fn new(lamp: &Lamp, origin: Vec3A) -> Self {
        // Nodes that say the same everywhere are done with.
        let even = lamp.graph.as_ref().and_then(|graph| even_radiance(graph));
        let graph = lamp.graph.clone().filter(|_| even.is_none());
        let color = lamp.color * even.unwrap_or(Rgb::ONE);
        let shape = AnyShape::from(lamp.kind);
        let center = lamp.to_render.translation;
        let size = with_shape!(shape, shape => shape.size());
        let frame = LampFrame {
            axes: lamp.to_render.matrix3,
            center,
            reaches: lamp.reaches,
            sets: lamp.sets,
            cast_shadow: lamp.cast_shadow,
            strength: with_shape!(shape, shape => shape.strength(color)),
            rounding: ROUNDINGS * f32::EPSILON * (center.abs().max_element() + size),
        };
        Self { shape, frame, color, max_bounces: lamp.max_bounces, graph, origin }
    }

    /// True if the lamp is infinitely far away.
    pub(super) fn is_at_infinity(&self) -> bool {
        self.as_sun().is_some()
    }

    /// Unit vector to the middle of a lamp at infinity, and half of its angle.
    pub(super) fn as_sun(&self) -> Option<(Vec3A, f32)> {
        let half_angle_rad = with_shape!(self.shape, shape => shape.half_angle_at_infinity())?;
        Some((self.frame.axes.z_axis, half_angle_rad))
    }

    /// True if no ray can hit the lamp: it has no extent.
    pub(super) fn is_point_like(&self) -> bool {
        with_shape!(self.shape, shape => shape.is_point_like())
    }

    /// The extent of a lamp that stands in the scene and can be hit; else `None`.
    pub(super) fn extent(&self) -> Option<LampExtent> {
        with_shape!(self.shape, shape => shape.extent())
    }

    /// A point of a flat lamp, even by area; the centre of a ball.
    pub(super) fn place(&self, u: [f32; 2]) -> Vec3A {
        with_shape!(self.shape, shape => shape.place(&self.frame, u))
    }

    /// The direction in which a flat lamp shines, unit.
    pub(super) fn axis(&self) -> Vec3A {
        -self.frame.axes.z_axis
    }

    /// Bound of the rounding of coordinates about the lamp, Blender units.
    pub(super) fn rounding(&self) -> f32 {
        self.frame.rounding
    }

    /// The centre of the lamp, render space.
    pub(super) fn center(&self) -> Vec3A {
        self.frame.center
    }

    /// True if light paths leave the lamp: not from one without shadows, for where its rays should end is undefined.
    pub(super) fn emits_rays(&self) -> bool {
        self.frame.cast_shadow
    }

    /// The kinds of ray that may find it.
    pub(super) fn reaches(&self) -> Rays {
        self.frame.reaches
    }

    /// True if a ray of a path in this state may find it. How many bounces it had is not asked, as in Cycles.
    pub(super) fn is_found_by(&self, way: PathState) -> bool {
        self.frame.reaches.all_of(way.finds())
    }

    /// The objects that the lamp lights, and those that cast shadows in its light.
    pub(super) fn sets(&self) -> LightSets {
        self.frame.sets
    }

    /// The most bounces of a path that it still lights.
    pub(super) fn most_bounces(&self) -> u32 {
        self.max_bounces
    }

    /// This lamp, if it still lights a path after so many bounces; else `None`.
    pub(super) fn lit_after(&self, way: PathState) -> Option<&Self> {
        (u32::from(way.depth) <= self.max_bounces).then_some(self)
    }

    /// Watts, for choosing; a sun's, per unit of area. Positive where it takes light away, too.
    pub(super) fn power(&self) -> f32 {
        luminance(self.color.abs()) * self.graph.as_ref().map_or(1.0, |graph| graph.brightness())
    }

    /// The lamp's position and directions of emission; not for suns.
    pub(super) fn bounds(&self) -> LightBounds {
        with_shape!(self.shape, shape => shape.bounds(&self.frame, self.power()))
    }

    /// The factor of the lamp's nodes on its light that arrives at `from` along a ray towards it.
    pub(super) fn shine(&self, scene: &Scene, from: Vec3A, wi: Vec3A, distance: f32, way: PathState) -> Rgb {
        let Some(graph) = &self.graph else { return Rgb::ONE };
        let is_far = self.is_at_infinity();
        // Blender puts what shines from infinity at its own direction.
        let place = if is_far { -wi } else { from + wi * distance };
        let normal = with_shape!(self.shape, shape => shape.normal(&self.frame, place, wi));
        let seen = LampView { place, normal, wi };
        let point = LampPoint {
            position: if is_far { place } else { place + self.origin },
            normal,
            direction: wi,
            distance,
            uv: with_shape!(self.shape, shape => shape.uv(&self.frame, &seen)),
            to_world: Affine3A { matrix3: self.frame.axes, translation: self.frame.center + self.origin },
            way,
        };
        radiance(graph, &scene.textures, &point)
    }

    /// Light at `from`, where a path came to by `way`.
    pub(super) fn light(&self, scene: &Scene, from: Vec3A, u: [f32; 2], way: PathState) -> Option<LightSample> {
        let mut sample = self.lit_after(way)?.sample(from, u)?;
        sample.radiance *= self.shine(scene, from, sample.wi, sample.distance, way.light());
        Some(sample)
    }

    /// Light of the lamp at `from`, before the lamp's nodes.
    pub(super) fn sample(&self, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        with_shape!(self.shape, shape => shape.sample(&self.frame, from, u))
    }

    /// Radiance along a ray that hits the lamp before `t_max`, the density of [`PreparedLamp::sample`], and its distance.
    pub(super) fn hit(&self, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        with_shape!(self.shape, shape => shape.hit(&self.frame, origin, d, t_max))
    }

    /// Radiance of a sun with extent along `d`, and the density of its samples.
    pub(super) fn hit_sun(&self, d: Vec3A) -> Option<(Rgb, f32)> {
        with_shape!(self.shape, shape => shape.hit_at_infinity(&self.frame, d))
    }

    /// A ray chosen by four uniform numbers; a sun's crosses the ball of a radius about a center, `scene`, which holds the scene.
    pub(super) fn emit(&self, u_place: [f32; 2], u_direction: [f32; 2], scene: (Vec3A, f32)) -> LampRay {
        with_shape!(self.shape, shape => shape.emit(&self.frame, u_place, u_direction, scene))
    }

    /// The density of [`PreparedLamp::emit`] per unit of etendue. Of a lamp without extent, the density per unit of area
    /// at right angles to the ray, `distance` from it.
    pub(super) fn emission_density(&self, distance: f32, scene_radius: f32) -> f32 {
        with_shape!(self.shape, shape => shape.emission_density(distance, scene_radius))
    }

    /// The density per steradian with which [`PreparedLamp::sample`] at a place chooses a ray along `direction` that left the lamp and
    /// arrives there after `distance`. `None` where the lamp, seen from that place, is not there.
    pub(super) fn arrival_pdf(&self, at: Vec3A, direction: Vec3A, distance: f32) -> Option<f32> {
        with_shape!(self.shape, shape => shape.arrival_pdf(&self.frame, at, direction, distance))
    }
}
