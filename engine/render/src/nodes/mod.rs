//! Evaluating a material's inputs at a point of a surface.
//!
//! Knows textures and texture coordinates, not how the values are used.

mod around;
mod ball;
pub mod displacement;
pub mod lamp;
mod layers;
mod point;
mod strand;
pub mod volume;
mod way;
pub mod world;

pub use around::Around;
pub use layers::{EvaluatedLayer, Layers, Opening, aovs, hole, layers, opening, transmittance};
pub use point::View;
pub use way::{OF_BOUNCES, Way};

use crate::scene::material::{Channel, ImageInput, Input, Material};
use crate::scene::mesh::Mesh;
use crate::scene::texture::Texture;
use crate::surface::{SurfacePoint, mesh_of, uv};
use crate::{Rgb, luminance, scene::Scene};
use glam::{Vec2, Vec4, Vec4Swizzles};
use std::sync::Arc;

/// A material's inputs at one point, in the range that the shading is defined for.
#[derive(Clone, Copy, Debug)]
pub struct MaterialValues {
    /// Albedo, 0 to 1.
    pub base_color: Rgb,
    /// 0 to 1.
    pub metallic: f32,
    /// Perceptual, 0 to 1.
    pub roughness: f32,
    /// 0 to 1.
    pub transmission: f32,
}

impl MaterialValues {
    fn within_range(base_color: Rgb, metallic: f32, roughness: f32, transmission: f32) -> Self {
        Self {
            base_color: base_color.clamp(Rgb::ZERO, Rgb::ONE),
            metallic: metallic.clamp(0.0, 1.0),
            roughness: roughness.clamp(0.0, 1.0),
            transmission: transmission.clamp(0.0, 1.0),
        }
    }
}

/// What an image gives at a point of a triangle, linear RGBA.
fn image_value(
    input: &ImageInput,
    textures: &[Arc<Texture>],
    mesh: &Mesh,
    triangle: u32,
    barycentric: [f32; 2],
) -> Vec4 {
    let uv = uv(mesh, triangle, barycentric, input.uv_map.as_deref());
    let [r0, r1] = input.mapping;
    let mapped = Vec2::new(r0[0] * uv.x + r0[1] * uv.y + r0[2], r1[0] * uv.x + r1[1] * uv.y + r1[2]);
    textures[input.texture as usize].lookup(mapped, input.interpolation, input.extension)
}

/// The colour that an input takes there.
pub fn colour(input: &Input<Rgb>, textures: &[Arc<Texture>], mesh: &Mesh, triangle: u32, barycentric: [f32; 2]) -> Rgb {
    match input {
        Input::Constant(c) => *c,
        Input::Image(image) => {
            let value = image_value(image, textures, mesh, triangle, barycentric);
            match image.channel {
                Channel::Color => value.xyz(),
                Channel::Alpha => Rgb::splat(value.w),
                Channel::Red => Rgb::splat(value.x),
                Channel::Green => Rgb::splat(value.y),
                Channel::Blue => Rgb::splat(value.z),
            }
        }
    }
}

/// The number that an input takes there.
pub fn number(input: &Input<f32>, textures: &[Arc<Texture>], mesh: &Mesh, triangle: u32, barycentric: [f32; 2]) -> f32 {
    match input {
        Input::Constant(v) => *v,
        Input::Image(image) => {
            let value = image_value(image, textures, mesh, triangle, barycentric);
            match image.channel {
                Channel::Color => luminance(value.xyz()),
                Channel::Alpha => value.w,
                Channel::Red => value.x,
                Channel::Green => value.y,
                Channel::Blue => value.z,
            }
        }
    }
}

/// The same at every point, if no image drives an input that decides how light scatters.
pub fn constants(material: &Material) -> Option<MaterialValues> {
    let value = |input: &Input<f32>| if let Input::Constant(v) = input { Some(*v) } else { None };
    let Input::Constant(base) = material.base_color else { return None };
    let (metallic, roughness) = (value(&material.metallic)?, value(&material.roughness)?);
    Some(MaterialValues::within_range(base, metallic, roughness, value(&material.transmission)?))
}

/// What decides how light scatters at a point.
pub fn evaluate(material: &Material, scene: &Scene, point: &SurfacePoint) -> MaterialValues {
    let mesh = mesh_of(scene, point.instance);
    let value = |input| number(input, &scene.textures, mesh, point.triangle, point.barycentric);
    let base = colour(&material.base_color, &scene.textures, mesh, point.triangle, point.barycentric);
    let (metallic, roughness) = (value(&material.metallic), value(&material.roughness));
    MaterialValues::within_range(base, metallic, roughness, value(&material.transmission))
}

/// The share of light that a point of a surface without layers takes part in, 0 (nothing is there) to 1.
pub fn alpha(scene: &Scene, instance: u32, triangle: u32, barycentric: [f32; 2]) -> f32 {
    let mesh = mesh_of(scene, instance);
    let material = &scene.materials[scene.instances[instance as usize].material(mesh.slot(triangle)) as usize];
    number(&material.alpha, &scene.textures, mesh, triangle, barycentric).clamp(0.0, 1.0)
}

/// Emitted radiance of a point of a triangle, the same on both sides; negative where it takes light away, as in Cycles.
pub fn emission(material: &Material, around: Around<'_>, place: [u32; 2], barycentric: [f32; 2], view: &View) -> Rgb {
    emission_of(material, around, place, barycentric, view, None)
}

/// [`emission`] of a point that is known.
pub fn emission_at(material: &Material, around: Around<'_>, point: &SurfacePoint, view: &View) -> Rgb {
    emission_of(material, around, [point.instance, point.triangle], point.barycentric, view, Some(point))
}

fn emission_of(
    material: &Material,
    around: Around<'_>,
    [instance, triangle]: [u32; 2],
    barycentric: [f32; 2],
    view: &View,
    point: Option<&SurfacePoint>,
) -> Rgb {
    if !material.emits() {
        return Rgb::ZERO;
    }
    let scene = around.scene;
    let mesh = mesh_of(scene, instance);
    if material.is_layered() {
        return layers::emission(material, around, [instance, triangle], barycentric, view, point);
    }
    let color = colour(&material.emission_color, &scene.textures, mesh, triangle, barycentric);
    color * material.emission_strength
}
