//! What a surface is made of where it is more than the one Principled BSDF of [`super::material::Material`]: closures,
//! each with a weight, summed. A material holds their inputs as [`Input`]s; what they are at a point of a surface are
//! plain [`Rgb`] and `f32`.

use super::closure::Closure;
use super::material::Input;
use super::texture::Texture;
use crate::{Rgb, luminance};
use std::cell::{Cell, RefCell};
use std::sync::Arc;

/// Layers that a material may have; what comes after is left out.
pub const MOST_LAYERS: usize = 32;

/// What a layer counts: a number times shares that may vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Weight {
    /// The part that stands still.
    pub scale: f32,
    /// The rest, each between 0 and 1; as it is, or what it leaves of 1.
    pub shares: Vec<(Input<f32>, bool)>,
}

/// One closure of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What it counts.
    pub weight: Weight,
    /// What it does.
    pub closure: Closure<Input<Rgb>, Input<f32>>,
}

impl Layer {
    /// The images that it uses.
    pub(super) fn textures(&self) -> Vec<u32> {
        let found =
            RefCell::new(self.weight.shares.iter().filter_map(|(share, _)| share.texture()).collect::<Vec<u32>>());
        self.closure.map(|c| found.borrow_mut().extend(c.texture()), |n| found.borrow_mut().extend(n.texture()));
        found.into_inner()
    }

    /// Whether nothing in it varies over the surface.
    pub fn is_constant(&self) -> bool {
        let varies = Cell::new(!self.weight.shares.is_empty());
        let see = |is_image: bool| varies.set(varies.get() || is_image);
        self.closure.map(|c| see(c.texture().is_some()), |n| see(n.texture().is_some()));
        !varies.get()
    }

    /// What is not a number becomes 0.
    pub(super) fn sanitise(&mut self) {
        let number = |v: f32| if v.is_finite() { v } else { 0.0 };
        self.weight.scale = number(self.weight.scale).max(0.0);
        self.closure = self.closure.map(
            |c| match c {
                Input::Constant(c) => Input::Constant(if c.is_finite() { *c } else { Rgb::ZERO }),
                image => image.clone(),
            },
            |n| match n {
                Input::Constant(v) => Input::Constant(number(*v)),
                image => image.clone(),
            },
        );
    }

    /// Whether it may scatter light.
    pub fn scatters(&self) -> bool {
        !matches!(self.closure, Closure::Emission { .. } | Closure::Transparent { .. } | Closure::Holdout)
    }

    /// Whether any of it may shine.
    pub fn emits(&self) -> bool {
        let shines = |color: &Input<Rgb>, strength: &Input<f32>| {
            *color != Input::Constant(Rgb::ZERO) && *strength != Input::Constant(0.0)
        };
        self.weight.scale > 0.0
            && match &self.closure {
                Closure::Emission { color, strength } => shines(color, strength),
                Closure::Principled(p) => shines(&p.emission_color, &p.emission_strength),
                _ => false,
            }
    }

    /// About what it emits: for choosing between lights.
    pub fn brightness(&self, textures: &[Arc<Texture>]) -> f32 {
        let colour = |input: &Input<Rgb>| match input {
            Input::Constant(colour) => *colour,
            Input::Image(image) => textures[image.texture as usize].average(),
        };
        let number = |input: &Input<f32>| match input {
            Input::Constant(value) => *value,
            Input::Image(image) => luminance(textures[image.texture as usize].average()),
        };
        let radiance = match &self.closure {
            Closure::Emission { color, strength } => colour(color) * number(strength),
            Closure::Principled(p) => colour(&p.emission_color) * number(&p.emission_strength),
            _ => return 0.0,
        };
        luminance(radiance.abs()) * self.weight.scale
    }

    /// Whether any of it may let light through unbent.
    pub fn may_be_transparent(&self) -> bool {
        match &self.closure {
            Closure::Transparent { .. } | Closure::Holdout => true,
            Closure::Principled(p) => p.alpha != Input::Constant(1.0),
            _ => false,
        }
    }
}
