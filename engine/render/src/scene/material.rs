//! Materials: a compiled shader graph, and Blender's settings of a material beside its nodes.

use super::closure::{Closure, Principled};
use super::graph::Graph;
use super::plain::Plain;
use super::volume::Volume;
use crate::Rgb;
use petzval_nodes::Field;
use std::sync::Arc;

/// A material: its shader graph, and Blender's settings beside the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name for messages.
    pub name: String,
    /// The shader graph: surface, volume and displacement.
    pub graph: Arc<Graph>,
    /// Pass index for masks.
    pub pass_index: i32,
    /// The values that the material's nodes give out beside the surface.
    pub aovs: Option<Aovs>,
    /// True if the camera sees a hole instead, and all else the surface.
    pub holds_out: bool,
    /// True if the material's surface may emit, or be a hole to the camera: a scene's builder sets it.
    pub emits_or_holds_out: bool,
    /// True if any of its closures may scatter light: a scene's builder sets it.
    pub scatters: bool,
    /// True if its surface may emit.
    pub is_emissive: bool,
    /// The choice of light samples for its emission.
    pub emission_sampling: EmissionSampling,
    /// True if its surface may let light through unbent.
    pub is_clear: bool,
    /// True if its surface lets no light through unbent to surfaces that are lit by light samples.
    pub shades_fully: bool,
    /// True if normals that are bent are corrected, so that a mirror does not send light into the surface, and light on a matte surface fades
    /// where it grazes it.
    pub corrects_bumps: bool,
    /// True if its nodes ask how a ray came: Light Path.
    pub asks_path: bool,
}

/// The choice of light samples for a material's emission.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmissionSampling {
    /// Light samples of bright emission; samples of closures alone find the rest.
    #[default]
    Auto,
    /// No light samples.
    Never,
    /// Light samples, however dim it is.
    Always,
}

impl EmissionSampling {
    /// The choice by Blender's name of it; `None` of an unknown one.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "AUTO" => Some(Self::Auto),
            "NONE" => Some(Self::Never),
            // Either side alone is a hint on where its light goes, which the shape of the mesh tells.
            "FRONT" | "BACK" | "FRONT_BACK" => Some(Self::Always),
            _ => None,
        }
    }
}

/// The fields that tell how a ray came.
const OF_PATHS: [Field; 13] = [
    Field::IsCameraRay,
    Field::IsShadowRay,
    Field::IsDiffuseRay,
    Field::IsGlossyRay,
    Field::IsSingularRay,
    Field::IsReflectionRay,
    Field::IsTransmissionRay,
    Field::RayLength,
    Field::RayDepth,
    Field::DiffuseDepth,
    Field::GlossyDepth,
    Field::TransmissionDepth,
    Field::TransparentDepth,
];

/// Values that nodes give out: a graph with a layer of emission for each, and their numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// The graph that computes them.
    pub graph: Arc<Graph>,
    /// The numbers of the values, by layer.
    pub numbers: Vec<u16>,
}

impl Material {
    /// A material of a graph.
    pub fn new(name: impl Into<String>, graph: Arc<Graph>) -> Self {
        // Every ray and shadow ray asks for these.
        let (is_emissive, is_clear) = (graph.emits(), graph.may_be_transparent());
        let asks_path = graph.reads_any(&OF_PATHS);
        Self {
            name: name.into(),
            graph,
            pass_index: 0,
            aovs: None,
            holds_out: false,
            emits_or_holds_out: false,
            scatters: true,
            is_emissive,
            emission_sampling: EmissionSampling::default(),
            is_clear,
            shades_fully: false,
            corrects_bumps: true,
            asks_path,
        }
    }

    /// A spatially constant material of closures with weights.
    pub fn even(name: impl Into<String>, closures: impl IntoIterator<Item = (f32, Closure<Rgb, f32>)>) -> Self {
        Self::new(name, Arc::new(Graph::even(closures)))
    }

    /// A spatially constant Principled BSDF.
    pub fn principled(name: impl Into<String>, principled: Principled<Rgb, f32>) -> Self {
        Self::even(name, [(1.0, Closure::Principled(principled))])
    }

    /// A spatially constant Lambert surface that emits a radiance.
    pub fn diffuse(name: impl Into<String>, color: Rgb, radiance: Rgb) -> Self {
        let emission = Closure::Emission { color: radiance, strength: 1.0 };
        let diffuse = Closure::Diffuse { color, roughness: 0.0 };
        Self::even(name, [(1.0, diffuse), (1.0, emission)])
    }

    /// The surface of an object without material.
    pub fn default_grey() -> Self {
        Self::principled("(default)", Principled::default())
    }

    /// True if any of its surface may emit.
    #[inline]
    pub fn emits(&self) -> bool {
        self.is_emissive
    }

    /// True if light samples are to find its emission, where there is something else that they may find.
    pub fn is_worth_light_samples(&self) -> bool {
        match self.emission_sampling {
            EmissionSampling::Auto => self.graph.is_worth_light_samples(),
            EmissionSampling::Never => false,
            EmissionSampling::Always => true,
        }
    }

    /// The quick form of its surface, where it has one: that of a surface whose normals are corrected.
    #[inline]
    pub fn plain(&self) -> Option<&Plain> {
        self.graph.plain.as_ref().filter(|_| self.corrects_bumps)
    }

    /// True if the camera may see a hole in its place.
    pub fn may_hold_out(&self) -> bool {
        self.holds_out || self.graph.layers.iter().any(|layer| matches!(layer.closure, Closure::Holdout))
    }

    /// True if any of its surface may let light through unbent.
    #[inline]
    pub fn may_be_transparent(&self) -> bool {
        self.is_clear
    }

    /// The volume behind the material's surface.
    #[inline]
    pub fn volume(&self) -> Option<&Volume> {
        self.graph.volume.as_ref()
    }

    /// True if the material's emission is constant over the surface.
    pub fn emits_evenly(&self) -> bool {
        self.graph.emits_evenly()
    }

    /// Finds the properties that a path has to ask the material for.
    pub(super) fn prepare(&mut self) {
        self.emits_or_holds_out = self.emits() || self.may_hold_out();
        self.scatters = !self.graph.scattering.is_empty();
    }
}
