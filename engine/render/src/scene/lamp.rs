//! Blender's lamps as described: point, spot, sun and area.

use super::graph::Graph;
use super::visibility::{LightSets, Rays};
use crate::Rgb;
use glam::{Affine3A, Vec3A};
use std::sync::Arc;

/// The shapes of light that a lamp can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampKind {
    /// A sphere, or a disk that faces whoever looks at it, that emits alike in all directions.
    Point {
        /// Radius of the sphere or disk, Blender units.
        radius: f32,
        /// True for a disk that faces whoever looks at it, false for a sphere.
        soft: bool,
    },
    /// A sphere, or a disk that faces whoever looks at it, that emits into a cone about the lamp's -z.
    Spot {
        /// Radius of the sphere or disk, Blender units.
        radius: f32,
        /// Half of the cone's angle.
        half_angle_rad: f32,
        /// 0 hard to 1 soft.
        blend: f32,
        /// True for a disk that faces whoever looks at it, false for a sphere.
        soft: bool,
    },
    /// A disk infinitely far along the lamp's +z.
    Sun {
        /// Half of the sun's angular diameter.
        half_angle_rad: f32,
    },
    /// A flat shape in the lamp's xy plane that emits along -z.
    Area {
        /// Full sides in lamp space.
        size: [f32; 2],
        /// True for an ellipse with these diameters, false for a rectangle.
        ellipse: bool,
        /// Half of the angle that it emits into; pi/2 is a plain Lambert emitter.
        half_spread_rad: f32,
    },
}

impl LampKind {
    /// The size or angle that is no number of zero or more, and its name; `None` if all are.
    pub(super) fn wrong_number(&self) -> Option<(&'static str, f32)> {
        let numbers = match *self {
            Self::Point { radius, .. } => vec![("radius", radius)],
            // The blend is a result of angles, which may round to a little below zero.
            Self::Spot { radius, half_angle_rad, blend, .. } => {
                let blend = if blend.is_finite() { blend.max(0.0) } else { blend };
                vec![("radius", radius), ("half of the spot's angle", half_angle_rad), ("blend", blend)]
            }
            Self::Sun { half_angle_rad } => vec![("half of the sun's angle", half_angle_rad)],
            Self::Area { size: [x, y], half_spread_rad, .. } => {
                vec![("size", x), ("size", y), ("half of the spread", half_spread_rad)]
            }
        };
        numbers.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
    }
}

/// A lamp. In a finished scene its frame is in render space.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Name of the lamp's object in Blender.
    pub object_name: String,
    /// Shape of the lamp.
    pub kind: LampKind,
    /// Watts by channel; for a sun, watts per square metre.
    pub color: Rgb,
    /// The nodes that change the colour; `None` where they leave it as it is.
    pub graph: Option<Arc<Graph>>,
    /// The kinds of ray that find it: of those that a surface scatters, the closures that it lights.
    pub reaches: Rays,
    /// The objects that the lamp lights, and those that cast shadows in its light.
    pub sets: LightSets,
    /// The number of the lamp's light group; 0 is none.
    pub light_group: u16,
    /// Scatterings after which the lamp no longer lights anything.
    pub max_bounces: u32,
    /// True if objects shadow the lamp's light.
    pub cast_shadow: bool,
    /// Lamp axes to render space.
    pub to_render: Affine3A,
}

impl Default for Lamp {
    fn default() -> Self {
        Self {
            object_name: String::new(),
            kind: LampKind::Point { radius: 0.0, soft: false },
            color: Rgb::ONE,
            graph: None,
            reaches: Rays::ALL,
            sets: LightSets::EVERYTHING,
            light_group: 0,
            max_bounces: u32::MAX,
            cast_shadow: true,
            to_render: Affine3A::IDENTITY,
        }
    }
}

impl Lamp {
    /// The lamp with its frame set. Blender's lamps other than area lights ignore the object's scale.
    pub(super) fn placed(mut self, to_render: Affine3A) -> Self {
        let m = to_render.matrix3;
        let unit = |v: Vec3A, otherwise: Vec3A| v.try_normalize().unwrap_or(otherwise);
        let axes = [unit(m.x_axis, Vec3A::X), unit(m.y_axis, Vec3A::Y), unit(m.z_axis, Vec3A::Z)];
        if let LampKind::Area { size, .. } = &mut self.kind {
            size[0] *= m.x_axis.length();
            size[1] *= m.y_axis.length();
        }
        self.to_render =
            Affine3A { matrix3: glam::Mat3A::from_cols(axes[0], axes[1], axes[2]), translation: to_render.translation };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneBuilder, SceneError};
    use glam::DMat4;

    /// A light's size of no number, or below zero, is an error that names it; sampling such a rectangle would be a panic.
    #[test]
    fn sizes_of_lights_are_numbers_of_zero_or_more() {
        let area =
            |x: f32, y: f32, half_spread_rad: f32| LampKind::Area { size: [x, y], ellipse: false, half_spread_rad };
        let point = |radius: f32| LampKind::Point { radius, soft: true };
        let added = |kind: LampKind| {
            let lamp = Lamp { object_name: "lamp".to_owned(), kind, ..Lamp::default() };
            SceneBuilder::new().add_lamp(lamp, DMat4::IDENTITY)
        };
        let spot = |blend: f32| LampKind::Spot { radius: 0.1, half_angle_rad: 0.4, blend, soft: true };
        for kind in [area(0.0, 2.0, 1.5), point(0.0), LampKind::Sun { half_angle_rad: 0.1 }, spot(-4.7e-16)] {
            assert!(added(kind).is_ok(), "{kind:?}");
        }
        for kind in
            [spot(f32::NAN), area(-1.0, 3.0, 1.5), area(1.0, f32::NAN, 1.5), area(1.0, 1.0, f32::INFINITY), point(-0.1)]
        {
            let error = added(kind).unwrap_err();
            assert!(matches!(error, SceneError::BadLightSize { .. }), "{kind:?}: {error}");
        }
    }
}
