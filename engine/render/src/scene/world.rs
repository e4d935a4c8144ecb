//! Light from infinity: one colour, or an equirectangular image.

use super::graph::Graph;
use super::material::Aovs;
use super::texture::{Extension, Interpolation, Texture};
use super::visibility::Rays;
use crate::Rgb;
use glam::{Mat3A, Vec2, Vec3A, Vec4Swizzles};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;
use wide::f32x4;

/// The light around the scene: one colour or an equirectangular image.
#[derive(Clone, Debug)]
pub struct World {
    /// Radiance, or the factor of the image.
    pub color: Rgb,
    /// Equirectangular image, index into the scene's textures.
    pub texture: Option<u32>,
    /// World direction to image direction.
    pub rotation: Mat3A,
    /// The kinds of ray that see it.
    pub visible: Rays,
    /// The number of the world's light group; 0 is none.
    pub light_group: u16,
    /// The most scatterings of a path that takes light samples of the world; hits of its rays count after any number of scatterings.
    pub max_bounces: u32,
    /// True if objects cast shadows in light samples of the world.
    pub cast_shadow: bool,
    /// True if nodes look an image up; an image that is missing, and one colour, counts.
    pub has_image: bool,
    /// The world as the camera sees it, where nodes compute it; the rest is then the world as surfaces see it.
    pub graph: Option<Arc<Graph>>,
    /// Shader AOVs, where the world's nodes have AOV Output nodes that the view layer names.
    pub aovs: Option<Aovs>,
}

impl Default for World {
    fn default() -> Self {
        Self {
            color: Rgb::ZERO,
            texture: None,
            rotation: Mat3A::IDENTITY,
            visible: Rays::ALL,
            light_group: 0,
            max_bounces: u32::MAX,
            cast_shadow: true,
            has_image: false,
            graph: None,
            aovs: None,
        }
    }
}

impl World {
    /// Radiance that arrives from the direction `d` (unit, pointing away from the scene).
    pub fn radiance(&self, d: Vec3A, textures: &[Arc<Texture>]) -> Rgb {
        match self.texture {
            None => self.color,
            Some(_) => self.radiance_at(direction_to_equirectangular(self.rotation * d), textures),
        }
    }

    /// Radiance from a place of the image.
    pub fn radiance_at(&self, uv: Vec2, textures: &[Arc<Texture>]) -> Rgb {
        let Some(texture) = self.texture else { return self.color };
        let texel = textures[texture as usize].lookup(uv, Interpolation::Linear, Extension::Repeat);
        self.color * texel.xyz()
    }
}

/// The place of a direction on Blender's equirectangular images: the middle is +x, u falls with the azimuth from +x
/// towards +y, v rises with the elevation.
#[inline]
pub fn direction_to_equirectangular(d: Vec3A) -> Vec2 {
    // Both angles at once, in the lanes of a register.
    let along = (d.x * d.x + d.y * d.y).sqrt();
    let angles = f32x4::from([d.y, d.z, 0.0, 0.0]).atan2(f32x4::from([d.x, along, 1.0, 1.0])).to_array();
    Vec2::new(0.5 - angles[0] / TAU, angles[1] / PI + 0.5)
}

/// The inverse of [`direction_to_equirectangular`].
#[inline]
pub fn equirectangular_to_direction(uv: Vec2) -> Vec3A {
    let (sines, cosines) = f32x4::from([(0.5 - uv.x) * TAU, (uv.y - 0.5) * PI, 0.0, 0.0]).sin_cos();
    let ([sa, s, ..], [ca, c, ..]) = (sines.to_array(), cosines.to_array());
    Vec3A::new(c * ca, c * sa, s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_inverts() {
        for i in 0..100 {
            let uv = Vec2::new(0.05 + 0.009 * i as f32, 0.02 + 0.0096 * i as f32);
            let back = direction_to_equirectangular(equirectangular_to_direction(uv));
            assert!((back - uv).length() < 1e-5, "{uv} {back}");
        }
    }
}
