//! Layers of materials, read by attribute; their inputs by name.

use crate::error::{Error, bad_scene};
use crate::material::{PyColour, PyNumber};
use petzval_render::Rgb;
use petzval_render::scene::closure::{Closure, Distribution, MetalKind, Principled, SubsurfaceMethod, ThinFilm};
use petzval_render::scene::layer::{Layer, Weight};
use petzval_render::scene::material::Input;
use pyo3::prelude::*;
use std::collections::HashMap;

#[derive(FromPyObject)]
pub(crate) struct PyLayer {
    kind: String,
    weight: f32,
    shares: Vec<(PyNumber, bool)>,
    colours: HashMap<String, PyColour>,
    numbers: HashMap<String, PyNumber>,
    distribution: String,
    subsurface_method: String,
}

impl PyLayer {
    pub(crate) fn layer(mut self) -> Result<Layer, Error> {
        let shares = std::mem::take(&mut self.shares);
        let shares = shares.into_iter().map(|(share, is_rest)| Ok((share.input()?, is_rest)));
        let weight = Weight { scale: self.weight, shares: shares.collect::<Result<_, Error>>()? };
        Ok(Layer { weight, closure: self.closure()? })
    }

    fn colour(&mut self, name: &str) -> Result<Input<Rgb>, Error> {
        let given = self.colours.remove(name);
        given.ok_or_else(|| bad_scene(format!("layer {}: it has no colour '{name}'", self.kind)))?.input()
    }

    fn number(&mut self, name: &str) -> Result<Input<f32>, Error> {
        let given = self.numbers.remove(name);
        given.ok_or_else(|| bad_scene(format!("layer {}: it has no number '{name}'", self.kind)))?.input()
    }

    fn subsurface_method(&self) -> Result<SubsurfaceMethod, Error> {
        let unknown = || bad_scene(format!("layer {}: there is no subsurface '{}'", self.kind, self.subsurface_method));
        SubsurfaceMethod::named(&self.subsurface_method).ok_or_else(unknown)
    }

    fn film(&mut self) -> Result<ThinFilm<Input<f32>>, Error> {
        Ok(ThinFilm { thickness_nm: self.number("film_thickness_nm")?, ior: self.number("film_ior")? })
    }

    fn distribution(&self) -> Result<Distribution, Error> {
        Ok(match self.distribution.as_str() {
            "GGX" => Distribution::Ggx,
            "MULTI_GGX" => Distribution::MultiscatterGgx,
            "BECKMANN" => Distribution::Beckmann,
            "ASHIKHMIN_SHIRLEY" => Distribution::AshikhminShirley,
            other => return Err(bad_scene(format!("layer {}: there is no distribution '{other}'", self.kind))),
        })
    }

    fn closure(&mut self) -> Result<Closure<Input<Rgb>, Input<f32>>, Error> {
        let kind = self.kind.clone();
        let distribution = self.distribution()?;
        Ok(match kind.as_str() {
            "DIFFUSE" => Closure::Diffuse { color: self.colour("color")?, roughness: self.number("roughness")? },
            "TRANSLUCENT" => Closure::Translucent { color: self.colour("color")? },
            "GLOSSY" => Closure::Glossy {
                color: self.colour("color")?,
                roughness: self.number("roughness")?,
                anisotropy: self.number("anisotropy")?,
                rotation: self.number("rotation")?,
                distribution,
            },
            "METAL" | "CONDUCTOR" => Closure::Metal {
                base: self.colour("base")?,
                edge: self.colour("edge")?,
                kind: if kind == "METAL" { MetalKind::Tinted } else { MetalKind::Conductor },
                roughness: self.number("roughness")?,
                anisotropy: self.number("anisotropy")?,
                rotation: self.number("rotation")?,
                distribution,
                film: self.film()?,
            },
            "GLASS" => Closure::Glass {
                color: self.colour("color")?,
                roughness: self.number("roughness")?,
                ior: self.number("ior")?,
                distribution,
                film: self.film()?,
            },
            "REFRACTION" => Closure::Refraction {
                color: self.colour("color")?,
                roughness: self.number("roughness")?,
                ior: self.number("ior")?,
                distribution,
            },
            "TRANSPARENT" => Closure::Transparent { color: self.colour("color")? },
            "HOLDOUT" => Closure::Holdout,
            "EMISSION" => Closure::Emission { color: self.colour("color")?, strength: self.number("strength")? },
            "MICROFIBER" => Closure::Microfiber { color: self.colour("color")?, roughness: self.number("roughness")? },
            "VELVET" => Closure::Velvet { color: self.colour("color")?, sigma: self.number("roughness")? },
            "TOON" | "GLOSSY_TOON" => Closure::Toon {
                color: self.colour("color")?,
                size: self.number("size")?,
                smooth: self.number("smooth")?,
                glossy: kind == "GLOSSY_TOON",
            },
            "SUBSURFACE" => Closure::Subsurface {
                color: self.colour("color")?,
                radius: self.colour("radius")?,
                scale: self.number("scale")?,
                ior: self.number("ior")?,
                roughness: self.number("roughness")?,
                anisotropy: self.number("anisotropy")?,
                method: self.subsurface_method()?,
            },
            "PRINCIPLED" => Closure::Principled(self.principled(distribution != Distribution::Ggx)?),
            other => return Err(bad_scene(format!("there is no kind of layer '{other}'"))),
        })
    }

    fn principled(&mut self, multiscatter: bool) -> Result<Principled<Input<Rgb>, Input<f32>>, Error> {
        Ok(Principled {
            base_color: self.colour("base_color")?,
            metallic: self.number("metallic")?,
            roughness: self.number("roughness")?,
            ior: self.number("ior")?,
            alpha: self.number("alpha")?,
            diffuse_roughness: self.number("diffuse_roughness")?,
            subsurface_weight: self.number("subsurface_weight")?,
            subsurface_radius: self.colour("subsurface_radius")?,
            subsurface_scale: self.number("subsurface_scale")?,
            subsurface_ior: self.number("subsurface_ior")?,
            subsurface_anisotropy: self.number("subsurface_anisotropy")?,
            subsurface_method: self.subsurface_method()?,
            specular_ior_level: self.number("specular_ior_level")?,
            specular_tint: self.colour("specular_tint")?,
            anisotropic: self.number("anisotropic")?,
            anisotropic_rotation: self.number("anisotropic_rotation")?,
            transmission: self.number("transmission")?,
            coat_weight: self.number("coat_weight")?,
            coat_roughness: self.number("coat_roughness")?,
            coat_ior: self.number("coat_ior")?,
            coat_tint: self.colour("coat_tint")?,
            sheen_weight: self.number("sheen_weight")?,
            sheen_roughness: self.number("sheen_roughness")?,
            sheen_tint: self.colour("sheen_tint")?,
            emission_color: self.colour("emission_color")?,
            emission_strength: self.number("emission_strength")?,
            film: self.film()?,
            multiscatter,
        })
    }
}
