//! The plain surface: a material that scatters by one diffuse or Principled closure without coat, sheen, film, subsurface
//! scattering, anisotropy or a normal of its own. Most materials are plain, and have a shorter BSDF,
//! [`crate::shading::principled::Bsdf`].

use super::closure::Closure;
use super::layer::{GraphLayer, Source};
use crate::Rgb;
use glam::Vec3A;
use petzval_nodes::Program;

/// Inputs of a plain surface, before they are evaluated at a point.
#[derive(Clone, Debug)]
pub struct Plain {
    /// Index of refraction of the dielectric.
    pub ior: f32,
    /// 0.5 leaves the reflectance that the index gives.
    pub specular_ior_level: f32,
    /// True if the diffuse base lies under a dielectric, as in Principled; a Diffuse BSDF is a Lambert surface.
    pub is_coated: bool,
    /// The values, if they are spatially constant.
    pub constants: Option<PlainValues>,
    /// True if any of the surface may be glass.
    pub may_transmit: bool,
    weight: Source,
    alpha: Source,
    base_color: Source,
    metallic: Source,
    roughness: Source,
    transmission: Source,
}

/// Inputs of a plain surface at a point, in the range that the shading is defined for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainValues {
    /// Weight of the closure times its alpha, at least 0.
    pub weight: f32,
    /// Albedo of the diffuse base, at least 0. Limited to 1, the albedo of metal, and its square root tints transmission.
    pub base_color: Rgb,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// Perceptual, 0 to 1; the microfacet width alpha is its square.
    pub roughness: f32,
    /// 0 opaque to 1 glass.
    pub transmission: f32,
}

impl Plain {
    /// The plain surface that these closures are; `None` if they are more than that. `layers`: those of a material that scatter light.
    pub(super) fn of(layers: &[GraphLayer], program: &Program) -> Option<Self> {
        let [layer] = layers else { return None };
        if layer.normal.is_some() || layer.coat_normal.is_some() || layer.tangent.is_some() {
            return None;
        }
        let [zero, one] = [Vec3A::ZERO, Vec3A::ONE].map(Source::Always);
        let is = |source: Source, value: Vec3A| source.constant(program) == Some(value);
        let plain = match &layer.closure {
            Closure::Diffuse { color, roughness } if is(*roughness, Vec3A::ZERO) => Self {
                ior: 1.5,
                specular_ior_level: 0.5,
                is_coated: false,
                constants: None,
                may_transmit: false,
                weight: layer.weight,
                alpha: one,
                base_color: *color,
                metallic: zero,
                roughness: one,
                transmission: zero,
            },
            Closure::Principled(p) => {
                let absent = [p.subsurface_weight, p.coat_weight, p.sheen_weight, p.anisotropic, p.diffuse_roughness];
                let is_plain = p.multiscatter
                    && absent.into_iter().chain([p.film.thickness_nm]).all(|source| is(source, Vec3A::ZERO))
                    && is(p.specular_tint, Vec3A::ONE);
                if !is_plain {
                    return None;
                }
                let ior = p.ior.constant(program)?.x;
                let specular_ior_level = p.specular_ior_level.constant(program)?.x;
                if !(1e-3..=1e3).contains(&ior) || !(0.0..=1e3).contains(&specular_ior_level) {
                    return None;
                }
                Self {
                    ior,
                    specular_ior_level,
                    is_coated: true,
                    constants: None,
                    may_transmit: !is(p.transmission, Vec3A::ZERO),
                    weight: layer.weight,
                    alpha: p.alpha,
                    base_color: p.base_color,
                    metallic: p.metallic,
                    roughness: p.roughness,
                    transmission: p.transmission,
                }
            }
            _ => return None,
        };
        let is_constant = plain.sources().iter().all(|source| source.constant(program).is_some());
        let constants = is_constant.then(|| plain.values(&|source| source.constant(program).unwrap_or_default()));
        Some(Self { constants, ..plain })
    }

    fn sources(&self) -> [Source; 6] {
        [self.weight, self.alpha, self.base_color, self.metallic, self.roughness, self.transmission]
    }

    /// The values at a point; `value` gives those of sources there.
    #[inline]
    pub fn values(&self, value: &impl Fn(Source) -> Vec3A) -> PlainValues {
        let finite = |source: Source| {
            let value = value(source);
            if value.is_finite() { value } else { Vec3A::ZERO }
        };
        let number = |source: Source| finite(source).x.clamp(0.0, 1.0);
        PlainValues {
            weight: finite(self.weight).x.max(0.0) * number(self.alpha),
            base_color: finite(self.base_color).max(Vec3A::ZERO).into(),
            metallic: number(self.metallic),
            roughness: number(self.roughness),
            transmission: number(self.transmission),
        }
    }
}
