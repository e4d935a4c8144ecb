//! A material as a compiled shader graph: closures whose inputs a program computes at each point.

use super::closure::{
    Closure, Distribution, HairModel, MetalKind, Pigment, Principled, PrincipledHair, SubsurfaceMethod, ThinFilm,
};
use super::layer::{AnsweredFields, GraphLayer, MOST_LAYERS, Slices, Source, in_words};
use super::plain::Plain;
use super::volume::Volume;
use crate::{Rgb, luminance};
use glam::Vec3A;
use petzval_nodes::{Field, Graph as Shaders, Layer, LayerKind, Program, compile};

/// The shader graph of a material or of the world, compiled: a program, and the closures whose inputs it computes.
#[derive(Debug)]
pub struct Graph {
    /// The program, to be run at each point.
    pub program: Program,
    /// The parts of the program that are run.
    pub slices: Slices,
    /// The closures, which add up.
    pub layers: Vec<GraphLayer>,
    /// The closures that scatter light, without their emission.
    pub scattering: Vec<GraphLayer>,
    /// The scattering closures as a plain surface, if they are one.
    pub plain: Option<Plain>,
    /// Pass index of the material.
    pub pass_index: i32,
    /// The method of displacement.
    pub displacement: Displacement,
    /// The medium behind the surface; of the world, in all space.
    pub volume: Option<Volume>,
}

impl Principled<Source, Source> {
    /// True if light may pass it unbent.
    pub fn is_clear(&self, program: &Program) -> bool {
        self.alpha.constant(program) != Some(Vec3A::ONE)
    }

    /// True if the closure may emit.
    pub fn shines(&self, program: &Program) -> bool {
        self.emission_strength.constant(program) != Some(Vec3A::ZERO)
    }
}

/// The effect of a material's displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Displacement {
    /// Bends normals, and moves nothing.
    #[default]
    Bump,
    /// Moves the mesh's vertices.
    Vertices,
    /// Moves vertices, and bends normals.
    Both,
}

impl Displacement {
    /// True if the displacement bends normals.
    pub fn bends(self) -> bool {
        self != Self::Vertices
    }

    /// True if the displacement moves vertices.
    pub fn moves(self) -> bool {
        self != Self::Bump
    }
}

/// Two graphs are the same if they are one.
impl PartialEq for Graph {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Graph {
    /// The graph of a compiled program; and reports on parts of it that the engine evaluates otherwise than Blender, or not at all.
    pub fn new(program: Program, pass_index: i32, answered: AnsweredFields) -> (Self, Vec<String>) {
        let mut reports = Vec::new();
        let mut report = |what: &str| {
            if !reports.iter().any(|known| known == what) {
                reports.push(what.to_owned());
            }
        };
        if program.surface.len() > MOST_LAYERS {
            report(&format!(
                "it has {} closures, those after the first {MOST_LAYERS} are left out",
                program.surface.len()
            ));
        }
        let layers: Vec<GraphLayer> = program
            .surface
            .iter()
            .take(MOST_LAYERS)
            .filter_map(|layer| LayerInputs(layer).layer(&mut report))
            .map(|layer| layer.settled(&program))
            .collect();
        for field in program.reads().filter(|&field| !(answered.on_surfaces)(field)) {
            report(&format!("{} is not supported yet, it is 0", in_words(field)));
        }
        (Self::assembled(program, layers, pass_index), reports)
    }

    /// A spatially constant graph of closures with weights.
    pub fn even(closures: impl IntoIterator<Item = (f32, Closure<Rgb, f32>)>) -> Self {
        let color = |color: &Rgb| Source::Always(Vec3A::from(*color));
        let number = |number: &f32| Source::Always(Vec3A::splat(*number));
        let layers = closures.into_iter().map(|(weight, closure)| GraphLayer {
            weight: number(&weight),
            closure: closure.map(color, number),
            normal: None,
            coat_normal: None,
            tangent: None,
            is_bare_colour: false,
        });
        Self::assembled(Program::default(), layers.collect(), 0)
    }

    fn assembled(program: Program, layers: Vec<GraphLayer>, pass_index: i32) -> Self {
        let scattering: Vec<GraphLayer> = layers.iter().filter_map(GraphLayer::scattering).collect();
        let slices = Slices::new(&program, &layers, &scattering);
        // A displacement may bend the normal.
        let plain = program.displacement.is_none().then(|| Plain::of(&scattering, &program)).flatten();
        let displacement = Displacement::default();
        Self { program, slices, layers, scattering, plain, pass_index, displacement, volume: None }
    }

    /// The graph of shaders: surface and volume become programs of their own, since they are evaluated at different places. Fields that
    /// nothing answers there are reported.
    pub fn of(shaders: &Shaders, pass_index: i32, answered: AnsweredFields) -> (Self, Vec<String>) {
        let (program, told) = compile(&Shaders { volume: None, ..shaders.clone() });
        let (mut graph, mut reports) = Self::new(program, pass_index, answered);
        reports.splice(0..0, told.iter().map(ToString::to_string));
        if shaders.volume.is_some() {
            let (program, told) = compile(&Shaders { surface: None, displacement: None, ..shaders.clone() });
            let (volume, more) = Volume::new(program, pass_index, answered);
            let told = told.iter().map(ToString::to_string).chain(more);
            for what in told {
                if !reports.contains(&what) {
                    reports.push(what);
                }
            }
            if graph.program.surface.is_empty() && volume.is_some() {
                // Nothing to see but the volume's border.
                let [color, weight] = [Source::Always(Vec3A::ONE); 2];
                let closure = Closure::Transparent { color };
                graph.layers.push(GraphLayer {
                    weight,
                    closure,
                    normal: None,
                    coat_normal: None,
                    tangent: None,
                    is_bare_colour: false,
                });
            }
            graph.volume = volume;
        }
        (graph, reports)
    }

    /// True if there is nothing but a volume: light passes its border as if it were not there.
    #[inline]
    pub fn is_only_volume(&self) -> bool {
        self.volume.is_some() && self.program.surface.is_empty()
    }

    /// True if the graph's displacement bends normals.
    pub fn bends_normals(&self) -> bool {
        // A height that is the same everywhere bends the normals of a mesh that was moved alone, to those that it had.
        let bends = self.displacement == Displacement::Both || self.slices.displacement.varies_beside();
        self.displacement.bends() && self.program.displacement.is_some() && bends
    }

    /// True if the graph's values depend on the footprint of the ray that hits the surface.
    pub fn needs_footprint(&self) -> bool {
        let is_huang = |layer: &GraphLayer| matches!(&layer.closure, Closure::PrincipledHair(hair) if hair.model == HairModel::Huang);
        self.bends_normals() || self.program.needs_footprint() || self.layers.iter().any(is_huang)
    }

    /// True if the graph's closures are spatially constant.
    pub fn is_even(&self) -> bool {
        self.slices.scattering.is_empty() && !self.bends_normals()
    }

    /// True if the graph's displacement moves the vertices of meshes.
    pub fn moves_vertices(&self) -> bool {
        self.displacement.moves() && self.program.displacement.is_some()
    }

    /// True if the graph's program reads any of these fields.
    pub fn reads_any(&self, fields: &[Field]) -> bool {
        self.program.reads().any(|field| fields.contains(&field))
    }

    /// True if the light that the surface lets through unbent depends on any of these fields.
    pub fn transmittance_reads_any(&self, fields: &[Field]) -> bool {
        self.slices.transmittance.reads().any(|field| fields.contains(&field))
    }

    /// True if any of its surface may emit.
    pub fn emits(&self) -> bool {
        let shines = |color: Source, strength: Source| {
            [color, strength].iter().all(|source| source.constant(&self.program) != Some(Vec3A::ZERO))
        };
        self.layers.iter().any(|layer| match &layer.closure {
            Closure::Emission { color, strength } => shines(*color, *strength),
            Closure::Principled(p) => shines(p.emission_color, p.emission_strength),
            _ => false,
        })
    }

    /// Luminance of the emitted radiance, inputs that vary taken as white: for choosing between lights.
    pub fn brightness(&self) -> f32 {
        self.layers.iter().map(|layer| luminance(self.emission_of(layer).into())).sum::<f32>().max(1e-6)
    }

    /// True if the emission is bright enough for light samples, by Cycles' rule (`estimate_emission` and `EMISSION_SAMPLING_AUTO` of its
    /// `shader.cpp`): a dim surface is found by closure samples well enough, and would take light samples from lamps. A colour that is
    /// plugged in where a shader belongs counts for a tenth.
    pub fn is_worth_light_samples(&self) -> bool {
        const LEAST_RADIANCE: f32 = 0.5;
        const BARE_COLOUR: f32 = 0.1;
        let counted =
            |layer: &GraphLayer| self.emission_of(layer) * if layer.is_bare_colour { BARE_COLOUR } else { 1.0 };
        self.layers.iter().map(counted).sum::<Vec3A>().max_element() > LEAST_RADIANCE
    }

    /// The size of a layer's emitted radiance, inputs that vary taken as white.
    fn emission_of(&self, layer: &GraphLayer) -> Vec3A {
        let about = |source: Source| source.constant(&self.program).unwrap_or(Vec3A::ONE);
        let radiance = match &layer.closure {
            Closure::Emission { color, strength } => about(*color) * about(*strength),
            Closure::Principled(p) => about(p.emission_color) * about(p.emission_strength),
            _ => return Vec3A::ZERO,
        };
        radiance.abs() * about(layer.weight).x
    }

    /// True if the graph's emission is spatially constant.
    pub fn emits_evenly(&self) -> bool {
        let stands = |source: &Source| source.constant(&self.program).is_some();
        self.layers.iter().all(|layer| match &layer.closure {
            Closure::Emission { color, strength } => [color, strength, &layer.weight].into_iter().all(stands),
            Closure::Principled(p) => {
                !p.shines(&self.program)
                    || [&p.emission_color, &p.emission_strength, &p.alpha, &layer.weight].into_iter().all(stands)
            }
            _ => true,
        })
    }

    /// True if any of its surface may let light through unbent.
    pub fn may_be_transparent(&self) -> bool {
        self.layers.iter().any(|layer| match &layer.closure {
            Closure::Transparent { .. } | Closure::Holdout => true,
            Closure::Principled(p) => p.is_clear(&self.program),
            _ => false,
        })
    }
}

/// A layer as Blender names its inputs.
struct LayerInputs<'a>(&'a Layer);

impl LayerInputs<'_> {
    fn input(&self, identifier: &str, otherwise: f32) -> Source {
        self.0.input(identifier).map_or(Source::Always(Vec3A::splat(otherwise)), Source::Of)
    }

    fn direction(&self, identifier: &str) -> Option<Source> {
        self.0.input(identifier).map(Source::Of)
    }

    fn distribution(&self) -> Distribution {
        match self.0.option("distribution") {
            Some("GGX" | "SHARP") => Distribution::Ggx,
            Some("BECKMANN") => Distribution::Beckmann,
            Some("ASHIKHMIN_SHIRLEY") => Distribution::AshikhminShirley,
            _ => Distribution::MultiscatterGgx,
        }
    }

    fn subsurface_method(&self, option: &str) -> SubsurfaceMethod {
        self.0.option(option).and_then(SubsurfaceMethod::named).unwrap_or_default()
    }

    fn film(&self) -> ThinFilm<Source> {
        ThinFilm { thickness_nm: self.input("Thin Film Thickness", 0.0), ior: self.input("Thin Film IOR", 1.33) }
    }

    fn layer(&self, report: &mut impl FnMut(&str)) -> Option<GraphLayer> {
        let closure = self.closure(report)?;
        let [normal, coat_normal, tangent] = ["Normal", "Coat Normal", "Tangent"].map(|name| self.direction(name));
        let (weight, is_bare_colour) = (Source::Of(self.0.weight), self.0.is_bare_colour);
        Some(GraphLayer { weight, closure, normal, coat_normal, tangent, is_bare_colour })
    }

    #[expect(clippy::too_many_lines, reason = "an arm for each shader")]
    fn closure(&self, report: &mut impl FnMut(&str)) -> Option<Closure<Source, Source>> {
        let color = self.input("Color", 0.8);
        let (roughness, distribution) = (self.input("Roughness", 0.0), self.distribution());
        Some(match self.0.kind {
            LayerKind::Principled => Closure::Principled(self.principled()),
            LayerKind::Diffuse => Closure::Diffuse { color, roughness },
            LayerKind::Translucent => Closure::Translucent { color },
            LayerKind::Glossy => {
                let (anisotropy, rotation) = (self.input("Anisotropy", 0.0), self.input("Rotation", 0.0));
                Closure::Glossy { color, roughness, anisotropy, rotation, distribution }
            }
            LayerKind::Metallic => {
                let is_conductor = self.0.option("fresnel_type") == Some("PHYSICAL_CONDUCTOR");
                let names = if is_conductor { ["IOR", "Extinction"] } else { ["Base Color", "Edge Tint"] };
                let [base, edge] = names.map(|name| self.input(name, 1.0));
                Closure::Metal {
                    base,
                    edge,
                    kind: if is_conductor { MetalKind::Conductor } else { MetalKind::Tinted },
                    roughness,
                    anisotropy: self.input("Anisotropy", 0.0),
                    rotation: self.input("Rotation", 0.0),
                    distribution,
                    film: self.film(),
                }
            }
            LayerKind::Glass => {
                Closure::Glass { color, roughness, ior: self.input("IOR", 1.5), distribution, film: self.film() }
            }
            LayerKind::Refraction => {
                Closure::Refraction { color, roughness, ior: self.input("IOR", 1.5), distribution }
            }
            LayerKind::Transparent => Closure::Transparent { color },
            LayerKind::Holdout => Closure::Holdout,
            LayerKind::Emission | LayerKind::Background => {
                Closure::Emission { color, strength: self.input("Strength", 1.0) }
            }
            LayerKind::Sheen => match self.0.option("distribution") {
                Some("ASHIKHMIN") => Closure::Velvet { color, sigma: roughness },
                _ => Closure::Microfiber { color, roughness },
            },
            LayerKind::Toon => Closure::Toon {
                color,
                size: self.input("Size", 0.5),
                smooth: self.input("Smooth", 0.0),
                glossy: self.0.option("component") == Some("GLOSSY"),
            },
            LayerKind::Subsurface => Closure::Subsurface {
                color,
                radius: self.input("Radius", 1.0),
                scale: self.input("Scale", 0.05),
                ior: self.input("IOR", 1.4),
                roughness: self.input("Roughness", 1.0),
                anisotropy: self.input("Anisotropy", 0.0),
                method: self.subsurface_method("falloff"),
            },
            LayerKind::Hair => Closure::Hair {
                color,
                roughness_along: self.input("RoughnessU", 0.1),
                roughness_about: self.input("RoughnessV", 1.0),
                offset: self.input("Offset", 0.0),
                through: self.0.option("component") == Some("Transmission"),
            },
            LayerKind::PrincipledHair => Closure::PrincipledHair(self.hair()),
            LayerKind::RayPortal => {
                report("Ray Portal is not supported yet, it is left out");
                return None;
            }
            LayerKind::PrincipledVolume
            | LayerKind::VolumeScatter
            | LayerKind::VolumeAbsorption
            | LayerKind::VolumeCoefficients => {
                report("a volume's shader shows nothing on a surface");
                return None;
            }
        })
    }

    fn hair(&self) -> PrincipledHair<Source, Source> {
        let (pigment, color) = match self.0.option("parametrization") {
            Some("ABSORPTION") => (Pigment::Absorption, "Absorption Coefficient"),
            Some("MELANIN") => (Pigment::Melanin, "Tint"),
            _ => (Pigment::Color, "Color"),
        };
        let model = if self.0.option("model") == Some("HUANG") { HairModel::Huang } else { HairModel::Chiang };
        PrincipledHair {
            model,
            pigment,
            color: self.input(color, 1.0),
            melanin: self.input("Melanin", 0.8),
            melanin_redness: self.input("Melanin Redness", 1.0),
            roughness: self.input("Roughness", 0.3),
            radial_roughness: self.input("Radial Roughness", 0.3),
            coat: self.input("Coat", 0.0),
            reflection: self.input("R lobe", 1.0),
            transmission: self.input("TT lobe", 1.0),
            secondary_reflection: self.input("TRT lobe", 1.0),
            aspect: self.input("Aspect Ratio", 1.0),
            ior: self.input("IOR", 1.55),
            offset: self.input("Offset", 0.0),
            random_color: self.input("Random Color", 0.0),
            random_roughness: self.input("Random Roughness", 0.0),
            random: self.input("Random", 0.0),
        }
    }

    fn principled(&self) -> Principled<Source, Source> {
        Principled {
            base_color: self.input("Base Color", 0.8),
            metallic: self.input("Metallic", 0.0),
            roughness: self.input("Roughness", 0.5),
            ior: self.input("IOR", 1.5),
            alpha: self.input("Alpha", 1.0),
            diffuse_roughness: self.input("Diffuse Roughness", 0.0),
            subsurface_weight: self.input("Subsurface Weight", 0.0),
            subsurface_radius: self.input("Subsurface Radius", 1.0),
            subsurface_scale: self.input("Subsurface Scale", 0.0),
            subsurface_ior: self.input("Subsurface IOR", 1.4),
            subsurface_anisotropy: self.input("Subsurface Anisotropy", 0.0),
            subsurface_method: self.subsurface_method("subsurface_method"),
            specular_ior_level: self.input("Specular IOR Level", 0.5),
            specular_tint: self.input("Specular Tint", 1.0),
            anisotropic: self.input("Anisotropic", 0.0),
            anisotropic_rotation: self.input("Anisotropic Rotation", 0.0),
            transmission: self.input("Transmission Weight", 0.0),
            coat_weight: self.input("Coat Weight", 0.0),
            coat_roughness: self.input("Coat Roughness", 0.0),
            coat_ior: self.input("Coat IOR", 1.5),
            coat_tint: self.input("Coat Tint", 1.0),
            sheen_weight: self.input("Sheen Weight", 0.0),
            sheen_roughness: self.input("Sheen Roughness", 0.5),
            sheen_tint: self.input("Sheen Tint", 1.0),
            emission_color: self.input("Emission Color", 1.0),
            emission_strength: self.input("Emission Strength", 0.0),
            film: self.film(),
            multiscatter: self.distribution() != Distribution::Ggx,
        }
    }
}
