//! Materials as described: Blender's Principled BSDF with constant or image-driven inputs.

use super::closure::Closure;
use super::graph::Graph;
use super::layer::{Layer, MOST_LAYERS};
use super::texture::{Extension, Interpolation};
use super::volume::Volume;
use crate::Rgb;
use std::sync::Arc;

/// Which value of an image an input takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// The colour; its luminance where a number is wanted.
    #[default]
    Color,
    /// Alpha.
    Alpha,
    /// One of the three.
    Red,
    /// One of the three.
    Green,
    /// One of the three.
    Blue,
}

/// An image that drives an input.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageInput {
    /// Index into the scene's textures.
    pub texture: u32,
    /// `None` is the mesh's first map.
    pub uv_map: Option<String>,
    /// Rows of the affine map from UV to texture coordinates.
    pub mapping: [[f32; 3]; 2],
    /// Between pixels.
    pub interpolation: Interpolation,
    /// Outside of the picture.
    pub extension: Extension,
    /// Which value.
    pub channel: Channel,
}

/// A value that may vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Input<T> {
    /// The same everywhere.
    Constant(T),
    /// From an image.
    Image(ImageInput),
}

impl<T> Input<T> {
    pub(super) fn texture(&self) -> Option<u32> {
        match self {
            Self::Constant(_) => None,
            Self::Image(image) => Some(image.texture),
        }
    }
}

/// Blender's Principled BSDF (4.x and 5.x), as far as this engine goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Albedo of the diffuse base and of metal; its square root tints transmission.
    pub base_color: Input<Rgb>,
    /// 0 dielectric to 1 metal.
    pub metallic: Input<f32>,
    /// Perceptual; the microfacet width alpha is its square.
    pub roughness: Input<f32>,
    /// Index of refraction.
    pub ior: f32,
    /// 0.5 leaves the reflection that the index gives.
    pub specular_ior_level: f32,
    /// Tint of reflections at normal incidence (dielectric), at grazing angles (metal).
    pub specular_tint: Rgb,
    /// 0 opaque to 1 glass.
    pub transmission: Input<f32>,
    /// 0 lets everything through unbent.
    pub alpha: Input<f32>,
    /// Emitted colour.
    pub emission_color: Input<Rgb>,
    /// Emitted radiance is colour times this.
    pub emission_strength: f32,
    /// Whether the diffuse base has its dielectric coat; false is a plain Lambert surface.
    pub specular: bool,
    /// What the surface is made of instead of all the above, where that cannot say it. The above is for most materials
    /// all there is, and takes a shorter way.
    pub layers: Vec<Layer>,
    /// What it is made of instead of all that, where nodes compute it.
    pub graph: Option<Arc<Graph>>,
    /// For masks.
    pub pass_index: i32,
    /// What its nodes give out beside the surface.
    pub aovs: Option<Aovs>,
    /// The camera sees a hole instead, all else the surface.
    pub holds_out: bool,
    /// There is more to ask of it where it is met than how it scatters: a scene's builder finds out.
    pub speaks: bool,
    /// Any of its closures may scatter light: a scene's builder finds out.
    pub scatters: bool,
}

/// Values that nodes give out: a graph with a layer of emission for each, and their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// What computes them.
    pub graph: Arc<Graph>,
    /// By layer.
    pub numbers: Vec<u16>,
}

impl Material {
    /// What Blender gives an object without material.
    pub fn default_grey() -> Self {
        Self {
            name: "(default)".into(),
            base_color: Input::Constant(Rgb::splat(0.8)),
            metallic: Input::Constant(0.0),
            roughness: Input::Constant(0.5),
            ior: 1.5,
            specular_ior_level: 0.5,
            specular_tint: Rgb::ONE,
            transmission: Input::Constant(0.0),
            alpha: Input::Constant(1.0),
            emission_color: Input::Constant(Rgb::ONE),
            emission_strength: 0.0,
            specular: true,
            layers: Vec::new(),
            graph: None,
            pass_index: 0,
            aovs: None,
            holds_out: false,
            speaks: false,
            scatters: true,
        }
    }

    /// The images that it uses.
    pub fn textures(&self) -> impl Iterator<Item = u32> + '_ {
        let layered = self.layers.iter().flat_map(Layer::textures);
        let colours = [&self.base_color, &self.emission_color].map(Input::texture);
        let numbers = [&self.metallic, &self.roughness, &self.transmission, &self.alpha].map(Input::texture);
        colours.into_iter().chain(numbers).flatten().chain(layered)
    }

    /// Whether any of its surface may emit.
    pub fn emits(&self) -> bool {
        if let Some(graph) = &self.graph {
            return graph.emits();
        }
        if self.is_layered() {
            return self.layers.iter().any(Layer::emits);
        }
        self.emission_strength != 0.0 && self.emission_color != Input::Constant(Rgb::ZERO)
    }

    /// Whether the camera may see a hole in its place.
    pub fn may_hold_out(&self) -> bool {
        self.holds_out
            || match &self.graph {
                Some(graph) => graph.layers.iter().any(|layer| matches!(layer.closure, Closure::Holdout)),
                None => self.layers.iter().any(|layer| matches!(layer.closure, Closure::Holdout)),
            }
    }

    /// Whether any of its surface may let light through unbent.
    pub fn may_be_transparent(&self) -> bool {
        match &self.graph {
            Some(graph) => graph.may_be_transparent(),
            None => self.alpha != Input::Constant(1.0) || self.layers.iter().any(Layer::may_be_transparent),
        }
    }

    /// What fills the space behind its surface.
    #[inline]
    pub fn volume(&self) -> Option<&Volume> {
        self.graph.as_ref()?.volume.as_ref()
    }

    /// Whether its layers say what it is made of.
    #[inline]
    pub fn is_layered(&self) -> bool {
        !self.layers.is_empty() || self.graph.is_some()
    }

    /// Whether what it emits is the same everywhere on the surface.
    pub fn emits_evenly(&self) -> bool {
        if let Some(graph) = &self.graph {
            return graph.emits_evenly();
        }
        if self.is_layered() {
            return self.layers.iter().all(|layer| !layer.emits() || layer.is_constant());
        }
        matches!(self.emission_color, Input::Constant(_)) && !self.may_be_transparent()
    }

    /// Brings constants into the range that the shading is defined for.
    pub(super) fn sanitise(&mut self) {
        self.layers.truncate(MOST_LAYERS);
        self.layers.iter_mut().for_each(Layer::sanitise);
        let clean = |v: &mut f32, lo: f32, hi: f32, otherwise: f32| {
            *v = if v.is_nan() { otherwise } else { v.clamp(lo, hi) };
        };
        for (input, otherwise) in [
            (&mut self.metallic, 0.0),
            (&mut self.roughness, 0.5),
            (&mut self.transmission, 0.0),
            (&mut self.alpha, 1.0),
        ] {
            if let Input::Constant(v) = input {
                clean(v, 0.0, 1.0, otherwise);
            }
        }
        clean(&mut self.ior, 1e-3, 1e3, 1.5);
        clean(&mut self.specular_ior_level, 0.0, 1e3, 0.5);
        clean(&mut self.emission_strength, -1e30, 1e30, 0.0);
        // Light may be negative; what scatters it may not.
        for (input, least) in [(&mut self.base_color, 0.0), (&mut self.emission_color, f32::MIN)] {
            if let Input::Constant(c) = input {
                *c = if c.is_finite() { c.max(Rgb::splat(least)) } else { Rgb::ZERO };
            }
        }
        self.specular_tint = if self.specular_tint.is_finite() { self.specular_tint.max(Rgb::ZERO) } else { Rgb::ONE };
        self.speaks = self.emits() || self.may_hold_out();
        self.scatters = match &self.graph {
            Some(graph) => !graph.scattering.is_empty(),
            None => self.layers.is_empty() || self.layers.iter().any(Layer::scatters),
        };
    }
}
