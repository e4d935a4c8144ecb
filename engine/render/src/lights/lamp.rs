//! Blender's point, spot, sun and area lamps, with the brightness that Cycles gives them.

use super::bounds::LightBounds;
use super::{Leaving, LightSample};
use crate::nodes::PathState;
use crate::nodes::lamp::{LampPoint, even_radiance, radiance};
use crate::scene::Scene;
use crate::scene::graph::Graph;
use crate::scene::lamp::{Lamp, LampKind};
use crate::scene::visibility::{LightSets, Rays};
use crate::{Rgb, luminance, sampler::warp};
use glam::{Affine3A, Mat3A, Vec2, Vec3A};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

pub(super) mod emission;

/// A lamp with its constants worked out.
#[derive(Clone, Debug)]
pub struct PreparedLamp {
    kind: LampKind,
    color: Rgb,
    axes: Mat3A,
    center: Vec3A,
    reaches: Rays,
    sets: LightSets,
    max_bounces: u32,
    cast_shadow: bool,
    /// Radiance of a lamp with extent; radiant intensity of one without (sun: irradiance). The factor of its nodes is not included.
    strength: Rgb,
    graph: Option<Arc<Graph>>,
    /// The origin of render space, in Blender's world.
    origin: Vec3A,
    /// Bound of the rounding error of a surface beside the lamp that stands in the lamp's plane, Blender units.
    rounding: f32,
}

/// Roundings of coordinates between a lamp's place and the hit of a surface there, in units of the last place.
const ROUNDINGS: f32 = 16.0;

/// The slant up to which a lamp without extent lights points past the plane that it stands in: its cosine.
const LEAST_SLANT: f32 = 0.1;

impl PreparedLamp {
    pub(super) fn new(lamp: &Lamp, origin: Vec3A) -> Self {
        // Nodes that say the same everywhere are done with.
        let even = lamp.graph.as_ref().and_then(|graph| even_radiance(graph));
        let graph = lamp.graph.clone().filter(|_| even.is_none());
        let color = lamp.color * even.unwrap_or(Rgb::ONE);
        let strength = match lamp.kind {
            // A watt is spread over the whole sphere; a spot is a point light seen through a hole.
            LampKind::Point { radius, .. } | LampKind::Spot { radius, .. } => {
                if radius > 0.0 {
                    color / (4.0 * PI * PI * radius * radius)
                } else {
                    color / (4.0 * PI)
                }
            }
            LampKind::Sun { half_angle_rad } => {
                // Its irradiance on a surface that faces it: radiance times the projected solid angle.
                let sin = half_angle_rad.min(FRAC_PI_2).sin();
                if sin > 0.0 { color / (PI * sin * sin) } else { color }
            }
            // A Lambert emitter sends pi times its radiance from each unit of area.
            LampKind::Area { size, ellipse, .. } => {
                let area = area_of(size, ellipse);
                if area > 0.0 { color / (PI * area) } else { Rgb::ZERO }
            }
        };
        let center = lamp.to_render.translation;
        let size = match lamp.kind {
            LampKind::Area { size, .. } => size[0].max(size[1]),
            _ => 0.0,
        };
        Self {
            rounding: ROUNDINGS * f32::EPSILON * (center.abs().max_element() + size),
            kind: lamp.kind,
            color,
            axes: lamp.to_render.matrix3,
            center,
            reaches: lamp.reaches,
            sets: lamp.sets,
            max_bounces: lamp.max_bounces,
            cast_shadow: lamp.cast_shadow,
            strength,
            graph,
            origin,
        }
    }

    pub(super) fn kind(&self) -> LampKind {
        self.kind
    }

    /// Unit vector to the middle of a sun, and half of its angle.
    pub(super) fn as_sun(&self) -> Option<(Vec3A, f32)> {
        let LampKind::Sun { half_angle_rad } = self.kind else { return None };
        Some((self.axes.z_axis, half_angle_rad))
    }

    /// True if a ray of a path in this state may find it. How many bounces it had is not asked, as in Cycles.
    pub(super) fn is_found_by(&self, way: PathState) -> bool {
        self.reaches.all_of(way.finds())
    }

    /// The objects that the lamp lights, and those that throw shadows in its light.
    pub(super) fn sets(&self) -> LightSets {
        self.sets
    }

    /// This lamp, if it still lights a path after so many bounces; else `None`.
    pub(super) fn lit_after(&self, way: PathState) -> Option<&Self> {
        (u32::from(way.depth) <= self.max_bounces).then_some(self)
    }

    /// Watts, for choosing; a sun's, per unit of area. Positive where it takes light away, too.
    pub(super) fn power(&self) -> f32 {
        luminance(self.color.abs()) * self.graph.as_ref().map_or(1.0, |graph| graph.brightness())
    }

    /// The factor of the lamp's nodes on its light that arrives at `from` along a ray towards it.
    pub(super) fn shine(&self, scene: &Scene, from: Vec3A, wi: Vec3A, distance: f32, way: PathState) -> Rgb {
        let Some(graph) = &self.graph else { return Rgb::ONE };
        let is_sun = matches!(self.kind, LampKind::Sun { .. });
        // Blender puts what shines from infinity at its own direction.
        let place = if is_sun { -wi } else { from + wi * distance };
        let normal = match self.kind {
            LampKind::Point { radius, soft: false } | LampKind::Spot { radius, soft: false, .. } if radius > 0.0 => {
                (place - self.center).normalize_or(-wi)
            }
            LampKind::Area { .. } => -self.axes.z_axis,
            _ => -wi,
        };
        let point = LampPoint {
            position: if is_sun { place } else { place + self.origin },
            normal,
            direction: wi,
            distance,
            uv: self.uv(place, normal, wi),
            to_world: Affine3A { matrix3: self.axes, translation: self.center + self.origin },
            way,
        };
        radiance(graph, &scene.textures, &point)
    }

    /// Blender's coordinates for images on lamps.
    fn uv(&self, place: Vec3A, normal: Vec3A, wi: Vec3A) -> Vec2 {
        let local = |v: Vec3A| self.axes.transpose() * v;
        match self.kind {
            LampKind::Point { .. } => {
                let n = local(normal);
                let turn = if n.x == 0.0 && n.y == 0.0 { 0.0 } else { 0.5 - n.x.atan2(n.y) / TAU };
                Vec2::new(turn, 1.0 - n.z.clamp(-1.0, 1.0).acos() / PI)
            }
            LampKind::Spot { half_angle_rad, .. } => {
                let d = local(-wi);
                let scale = 0.5 / (half_angle_rad.tan() * d.z.abs());
                Vec2::new(0.5 + d.x * scale, 0.5 + d.y * scale)
            }
            LampKind::Area { size, .. } => {
                let p = local(place - self.center);
                Vec2::new(0.5 + p.x / size[0], 0.5 + p.y / size[1])
            }
            LampKind::Sun { half_angle_rad } => {
                let d = local(wi);
                let scale = 0.5 / half_angle_rad.sin().max(1e-6);
                Vec2::new(0.5 + d.x * scale, 0.5 + d.y * scale)
            }
        }
    }

    /// The lamp's position and directions of emission; not for suns.
    pub(super) fn bounds(&self) -> LightBounds {
        // Pi times the intensity in the brightest direction, which for a surface that emits is its power.
        let power = match self.kind {
            LampKind::Point { .. } | LampKind::Spot { .. } => 0.25 * self.power(),
            _ => self.power(),
        };
        let everywhere = |radius: f32| LightBounds {
            min: self.center - Vec3A::splat(radius),
            max: self.center + Vec3A::splat(radius),
            power,
            axis: -self.axes.z_axis,
            normal_spread_rad: PI,
            emission_spread_rad: FRAC_PI_2,
            two_sided: false,
        };
        match self.kind {
            LampKind::Spot { radius, half_angle_rad, .. } => LightBounds {
                normal_spread_rad: 0.0,
                emission_spread_rad: half_angle_rad.min(PI),
                ..everywhere(radius)
            },
            LampKind::Area { size, .. } => {
                let half = self.axes.x_axis.abs() * (0.5 * size[0]) + self.axes.y_axis.abs() * (0.5 * size[1]);
                LightBounds {
                    min: self.center - half,
                    max: self.center + half,
                    normal_spread_rad: 0.0,
                    ..everywhere(0.0)
                }
            }
            LampKind::Point { radius, .. } => everywhere(radius),
            LampKind::Sun { .. } => everywhere(0.0),
        }
    }

    /// Light at `from`, where a path came to by `way`.
    pub(super) fn light(&self, scene: &Scene, from: Vec3A, u: [f32; 2], way: PathState) -> Option<LightSample> {
        let mut sample = self.lit_after(way)?.sample(from, u)?;
        sample.radiance *= self.shine(scene, from, sample.wi, sample.distance, way.light());
        Some(sample)
    }

    /// Light of the lamp at `from`, before the lamp's nodes.
    pub(super) fn sample(&self, from: Vec3A, u: [f32; 2]) -> Option<LightSample> {
        match self.kind {
            LampKind::Point { radius, soft: true } if radius > 0.0 => self.sample_facing_disk(from, radius, u),
            LampKind::Point { radius, .. } => self.sample_sphere(from, radius, u),
            LampKind::Spot { radius, half_angle_rad, blend, soft } => {
                let mut s = if soft && radius > 0.0 {
                    self.sample_facing_disk(from, radius, u)?
                } else {
                    self.sample_sphere(from, radius, u)?
                };
                s.radiance *= self.cone(-s.wi, half_angle_rad, blend);
                Some(s)
            }
            LampKind::Sun { half_angle_rad } => Some(self.sample_sun(half_angle_rad, u)),
            LampKind::Area { size, ellipse, half_spread_rad } => {
                let p = if ellipse { warp::sample_disk(u) * 0.5 } else { Vec2::new(u[0] - 0.5, u[1] - 0.5) };
                let point = self.center + self.axes.x_axis * (p.x * size[0]) + self.axes.y_axis * (p.y * size[1]);
                let to = point - from;
                let distance = to.length();
                let wi = to / distance;
                let cos = wi.dot(self.axes.z_axis);
                if !(cos > 0.0 && distance > 0.0) {
                    return None;
                }
                Some(LightSample {
                    wi,
                    distance,
                    radiance: self.strength * spread(cos, half_spread_rad),
                    pdf: distance * distance / (cos * area_of(size, ellipse)),
                    point_like: false,
                    cast_shadow: self.cast_shadow,
                    reaches: self.reaches,
                    sets: self.sets,
                    leaves: Some(Leaving { cos, error: self.rounding }),
                })
            }
        }
    }

    /// Radiance along a ray that hits the lamp before `t_max`, the density of [`PreparedLamp::sample`], and how far it is.
    pub(super) fn hit(&self, origin: Vec3A, d: Vec3A, t_max: f32) -> Option<(Rgb, f32, f32)> {
        match self.kind {
            LampKind::Point { radius, soft: true } => self.hit_facing_disk(origin, d, t_max, radius),
            LampKind::Point { radius, .. } => self.hit_sphere(origin, d, t_max, radius),
            LampKind::Spot { radius, half_angle_rad, blend, soft } => {
                let (radiance, pdf, t) = if soft {
                    self.hit_facing_disk(origin, d, t_max, radius)?
                } else {
                    self.hit_sphere(origin, d, t_max, radius)?
                };
                Some((radiance * self.cone(-d, half_angle_rad, blend), pdf, t))
            }
            LampKind::Sun { .. } => None,
            LampKind::Area { size, ellipse, half_spread_rad } => {
                let cos = d.dot(self.axes.z_axis);
                if cos <= 0.0 {
                    return None;
                }
                let t = (self.center - origin).dot(self.axes.z_axis) / cos;
                // A surface in the lamp's plane does not hide it: it is as far away but for rounding.
                if !(t > 0.0 && t < t_max + self.rounding / cos) {
                    return None;
                }
                let p = origin + d * t - self.center;
                let (x, y) = (2.0 * p.dot(self.axes.x_axis) / size[0], 2.0 * p.dot(self.axes.y_axis) / size[1]);
                let inside = if ellipse { x * x + y * y <= 1.0 } else { x.abs() <= 1.0 && y.abs() <= 1.0 };
                inside.then(|| {
                    let pdf = t * t / (cos * area_of(size, ellipse));
                    (self.strength * spread(cos, half_spread_rad), pdf, t)
                })
            }
        }
    }

    /// Radiance of a sun with extent along `d`, and the density of its samples.
    pub(super) fn hit_sun(&self, d: Vec3A) -> Option<(Rgb, f32)> {
        let LampKind::Sun { half_angle_rad } = self.kind else { return None };
        if half_angle_rad <= 0.0 {
            return None;
        }
        let limit = one_minus_cos(half_angle_rad);
        // 1 - cos from the difference of unit vectors keeps its digits for small angles.
        let off = 0.5 * (d - self.axes.z_axis).length_squared();
        (off <= limit).then(|| (self.strength, warp::cone_pdf(limit)))
    }

    fn sample_sun(&self, half_angle_rad: f32, u: [f32; 2]) -> LightSample {
        let axis = self.axes.z_axis;
        let base = LightSample {
            wi: axis,
            distance: f32::INFINITY,
            radiance: self.strength,
            pdf: 1.0,
            point_like: true,
            cast_shadow: self.cast_shadow,
            reaches: self.reaches,
            sets: self.sets,
            leaves: None,
        };
        if half_angle_rad <= 0.0 {
            return base;
        }
        let limit = one_minus_cos(half_angle_rad);
        let wi = warp::to_world(&warp::frame(axis), warp::sample_cone(u, limit)).normalize();
        LightSample { wi, pdf: warp::cone_pdf(limit), point_like: false, ..base }
    }

    fn sample_sphere(&self, from: Vec3A, radius: f32, u: [f32; 2]) -> Option<LightSample> {
        let to = self.center - from;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        if distance <= radius || distance <= 0.0 {
            return None;
        }
        let axis = to / distance;
        let base = LightSample {
            wi: axis,
            distance,
            radiance: self.strength / distance2,
            pdf: 1.0,
            point_like: true,
            cast_shadow: self.cast_shadow,
            reaches: self.reaches,
            sets: self.sets,
            leaves: None,
        };
        if radius <= 0.0 {
            return Some(LightSample { leaves: Some(Leaving { cos: LEAST_SLANT, error: self.rounding }), ..base });
        }
        let sin2_max = radius * radius / distance2;
        let limit = sin2_max / (1.0 + (1.0 - sin2_max).max(0.0).sqrt());
        let local = warp::sample_cone(u, limit);
        let wi = warp::to_world(&warp::frame(axis), local).normalize();
        // Distance to the near side of the sphere.
        let sin2 = local.x * local.x + local.y * local.y;
        let half_chord = (radius * radius - distance2 * sin2).max(0.0).sqrt();
        Some(LightSample {
            wi,
            distance: distance * local.z - half_chord,
            radiance: self.strength,
            pdf: warp::cone_pdf(limit),
            point_like: false,
            ..base
        })
    }

    fn hit_sphere(&self, origin: Vec3A, d: Vec3A, t_max: f32, radius: f32) -> Option<(Rgb, f32, f32)> {
        if radius <= 0.0 {
            return None;
        }
        let to = self.center - origin;
        let distance2 = to.length_squared();
        let along = to.dot(d);
        let off2 = (to - d * along).length_squared();
        if distance2 <= radius * radius || along <= 0.0 || off2 > radius * radius {
            return None;
        }
        let t = along - (radius * radius - off2).max(0.0).sqrt();
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let sin2_max = radius * radius / distance2;
        let limit = sin2_max / (1.0 + (1.0 - sin2_max).max(0.0).sqrt());
        Some((self.strength, warp::cone_pdf(limit), t))
    }

    /// The lamp as a disk that faces whoever looks at it: Blender's soft falloff, which has no edge where the
    /// sphere would cut into a surface.
    fn sample_facing_disk(&self, from: Vec3A, radius: f32, u: [f32; 2]) -> Option<LightSample> {
        let axis = (self.center - from).try_normalize()?;
        let [x, y, _] = warp::frame(axis);
        let p = warp::sample_disk(u) * radius;
        let to = self.center + x * p.x + y * p.y - from;
        let distance = to.length();
        let wi = to / distance;
        let cos = wi.dot(axis);
        (cos > 0.0).then(|| LightSample {
            wi,
            distance,
            radiance: self.strength,
            pdf: distance * distance / (cos * PI * radius * radius),
            point_like: false,
            cast_shadow: self.cast_shadow,
            reaches: self.reaches,
            sets: self.sets,
            leaves: None,
        })
    }

    fn hit_facing_disk(&self, origin: Vec3A, d: Vec3A, t_max: f32, radius: f32) -> Option<(Rgb, f32, f32)> {
        if radius <= 0.0 {
            return None;
        }
        let to = self.center - origin;
        let distance = to.length();
        let cos = d.dot(to) / distance;
        let t = distance / cos;
        // Refuses NaN, too: the start may be the lamp's very centre.
        let ahead = cos > 0.0 && t < t_max;
        let inside = (d * t - to).length_squared() <= radius * radius;
        (ahead && inside).then(|| (self.strength, t * t / (cos * PI * radius * radius), t))
    }

    /// The part of a spot's light along `d` (away from the lamp).
    fn cone(&self, d: Vec3A, half_angle_rad: f32, blend: f32) -> f32 {
        let cos = -d.dot(self.axes.z_axis);
        let limit = half_angle_rad.cos();
        let x = ((cos - limit) / ((1.0 - limit) * blend).max(1e-4)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}

fn area_of(size: [f32; 2], ellipse: bool) -> f32 {
    size[0] * size[1] * if ellipse { PI / 4.0 } else { 1.0 }
}

fn one_minus_cos(half_angle_rad: f32) -> f32 {
    2.0 * (0.5 * half_angle_rad).sin().powi(2)
}

/// The factor of an area lamp's spread on light that leaves it at `cos` to its normal, brighter on axis for less spread.
fn spread(cos: f32, half_spread_rad: f32) -> f32 {
    if half_spread_rad >= FRAC_PI_2 - 1e-4 {
        return 1.0;
    }
    let tan_limit = half_spread_rad.tan();
    let tan = (1.0 - cos * cos).max(0.0).sqrt() / cos;
    let normalise = tan_limit - half_spread_rad;
    if normalise <= 1e-9 { 0.0 } else { ((tan_limit - tan) / normalise).max(0.0) }
}
