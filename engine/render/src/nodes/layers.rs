//! Evaluating the layers of a material at a point of a surface.

use super::{colour, number};
use crate::scene::closure::Closure;
use crate::scene::layer::{Layer, MOST_LAYERS, Weight};
use crate::scene::material::Material;
use crate::scene::mesh::Mesh;
use crate::scene::texture::Texture;
use crate::scene::{Scene, material::Input};
use crate::surface::{SurfacePoint, mesh_of};
use crate::{Rgb, luminance};
use arrayvec::ArrayVec;

/// The layers of a material at one point.
pub type Layers = ArrayVec<(f32, Closure<Rgb, f32>), MOST_LAYERS>;

/// Where on which mesh, and the images to look at.
#[derive(Clone, Copy)]
struct Place<'a> {
    textures: &'a [Texture],
    mesh: &'a Mesh,
    triangle: u32,
    barycentric: [f32; 2],
}

impl Place<'_> {
    fn colour(&self, input: &Input<Rgb>) -> Rgb {
        colour(input, self.textures, self.mesh, self.triangle, self.barycentric)
    }

    fn number(&self, input: &Input<f32>) -> f32 {
        number(input, self.textures, self.mesh, self.triangle, self.barycentric)
    }

    fn weight(&self, weight: &Weight) -> f32 {
        let share = |(input, is_rest): &(Input<f32>, bool)| {
            let share = self.number(input).clamp(0.0, 1.0);
            if *is_rest { 1.0 - share } else { share }
        };
        weight.shares.iter().map(share).fold(weight.scale, |product, share| product * share)
    }
}

/// What the layers of a material are at a point. Those that count nothing are left out.
pub fn layers(material: &Material, scene: &Scene, point: &SurfacePoint, to: &mut Layers) {
    let SurfacePoint { instance, triangle, barycentric, .. } = *point;
    let place = Place { textures: &scene.textures, mesh: mesh_of(scene, instance), triangle, barycentric };
    to.clear();
    for Layer { weight, closure } in material.layers.iter().take(MOST_LAYERS) {
        let weight = place.weight(weight);
        if weight > 0.0 {
            to.push((weight, closure.map(|c| place.colour(c), |n| place.number(n))));
        }
    }
}

/// How a surface lets light through unbent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// What of it.
    pub light: Rgb,
    /// The chance with which a path goes through; it then carries `light` over this.
    pub chance: f32,
    /// What the rest of the surface counts for a path that does not.
    pub kept: f32,
}

impl Opening {
    /// Of a surface that lets nothing through.
    pub const NONE: Self = Self { light: Rgb::ZERO, chance: 0.0, kept: 1.0 };

    /// Of one that takes a share of the light, and does all else to that share.
    pub fn of_alpha(alpha: f32) -> Self {
        Self { light: Rgb::splat(1.0 - alpha), chance: 1.0 - alpha, kept: 1.0 }
    }
}

/// Of a material at a point of a triangle.
pub fn opening(material: &Material, scene: &Scene, instance: u32, triangle: u32, barycentric: [f32; 2]) -> Opening {
    if !material.is_layered() {
        return Opening::of_alpha(super::alpha(scene, instance, triangle, barycentric));
    }
    let place = Place { textures: &scene.textures, mesh: mesh_of(scene, instance), triangle, barycentric };
    let (mut light, mut rest) = (Rgb::ZERO, 0.0);
    for Layer { weight, closure } in material.layers.iter().take(MOST_LAYERS) {
        let weight = place.weight(weight);
        match closure {
            Closure::Transparent { color } => light += place.colour(color).max(Rgb::ZERO) * weight,
            Closure::Principled(p) => {
                let alpha = place.number(&p.alpha).clamp(0.0, 1.0);
                light += Rgb::splat(weight * (1.0 - alpha));
                rest += weight * alpha;
            }
            _ => rest += weight,
        }
    }
    let through = luminance(light);
    if through <= 0.0 {
        return Opening::NONE;
    }
    let chance = through / (through + rest);
    Opening { light, chance, kept: if rest > 0.0 { 1.0 / (1.0 - chance) } else { 0.0 } }
}

/// Emitted radiance, what lies over it not taken off.
pub(super) fn emission(
    material: &Material,
    textures: &[Texture],
    mesh: &Mesh,
    triangle: u32,
    barycentric: [f32; 2],
) -> Rgb {
    let place = Place { textures, mesh, triangle, barycentric };
    let mut sum = Rgb::ZERO;
    for Layer { weight, closure } in material.layers.iter().take(MOST_LAYERS) {
        let radiance = match closure {
            Closure::Emission { color, strength } => place.colour(color) * place.number(strength),
            Closure::Principled(p) if p.emission_strength != Input::Constant(0.0) => {
                let alpha = place.number(&p.alpha).clamp(0.0, 1.0);
                place.colour(&p.emission_color) * (place.number(&p.emission_strength) * alpha)
            }
            _ => continue,
        };
        sum += radiance.max(Rgb::ZERO) * place.weight(weight);
    }
    sum
}
