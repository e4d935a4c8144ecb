//! A participating medium as a compiled shader graph: closures whose inputs a program computes at each point.

use super::layer::{AnsweredFields, MOST_LAYERS, Source, in_words};
use glam::Vec3A;
use petzval_nodes::{Layer, LayerKind, Program};

/// A phase function, by the names of Blender's nodes.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    /// Henyey and Greenstein 1941.
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle.
        anisotropy: Source,
    },
    /// Fournier and Forand 1994: sea water.
    FournierForand {
        /// Index of refraction of the particles.
        ior: Source,
        /// Part of the light that goes back.
        backscatter: Source,
    },
    /// Draine 2003: dust.
    Draine {
        /// The parameter g, as in Henyey and Greenstein's.
        anisotropy: Source,
        /// 0 is Henyey and Greenstein's; 1 with no anisotropy is Rayleigh's.
        alpha: Source,
    },
    /// Particles much smaller than the wavelength.
    Rayleigh,
    /// Fog, after Jendersie and d'Eon 2023.
    Mie {
        /// Diameter of the droplets, micrometres.
        diameter_um: Source,
    },
}

/// A closure of a volume. Coefficients are per Blender unit.
#[derive(Clone, Debug)]
pub enum VolumeClosure {
    /// Absorbs by 1 less its colour, times its density.
    Absorption {
        /// The colour that is not absorbed.
        color: Source,
        /// Density of the absorption, per Blender unit.
        density: Source,
    },
    /// Scatters its colour times its density, and absorbs nothing.
    Scatter {
        /// Scattering coefficient by channel for a density of 1.
        color: Source,
        /// Density of the scattering, per Blender unit.
        density: Source,
        /// The phase function.
        phase: Phase,
    },
    /// Coefficients as they are.
    Coefficients {
        /// Absorption coefficient by channel.
        absorption: Source,
        /// Scattering coefficient by channel.
        scattering: Source,
        /// Radiance by channel that a Blender unit of length adds.
        emission: Source,
        /// Phase function of the scattering.
        phase: Phase,
    },
    /// Smoke and fire, as Blender's Principled Volume.
    Principled(Box<PrincipledVolume>),
    /// Light that the volume gives out.
    Emission {
        /// Colour of the emission, by channel.
        color: Source,
        /// Radiance that a Blender unit of length adds, times the colour.
        strength: Source,
    },
}

/// The inputs of Blender's Principled Volume.
#[derive(Clone, Debug)]
pub struct PrincipledVolume {
    /// Scattering coefficient by channel for a density of 1.
    pub color: Source,
    /// The grid that the colour is multiplied by, if the object has it.
    pub color_grid: String,
    /// Density per Blender unit, multiplied by the grid.
    pub density: Source,
    /// The grid that the density is multiplied by.
    pub density_grid: String,
    /// Mean cosine of the scattering angle.
    pub anisotropy: Source,
    /// Tint of the light that goes through.
    pub absorption_color: Source,
    /// Radiance that a Blender unit of length adds, times [`Self::emission_color`].
    pub emission_strength: Source,
    /// Colour of the emission.
    pub emission_color: Source,
    /// Intensity of the emission as a black body, 1 for a black body's own.
    pub blackbody: Source,
    /// Tint of the black body's emission.
    pub blackbody_tint: Source,
    /// Temperature of the black body, kelvin.
    pub temperature: Source,
    /// The grid that the temperature is multiplied by.
    pub temperature_grid: String,
}

impl PrincipledVolume {
    /// The grids that the volume asks for.
    pub fn grids(&self) -> [&str; 3] {
        [&self.color_grid, &self.density_grid, &self.temperature_grid]
    }
}

/// A closure and its weight.
#[derive(Clone, Debug)]
pub struct VolumeLayer {
    /// Weight, 0 to 1.
    pub weight: Source,
    /// The closure, its inputs as sources of values.
    pub closure: VolumeClosure,
}

/// A program and the closures whose inputs it computes.
#[derive(Debug)]
pub struct Volume {
    /// The program, to be run at each point.
    pub program: Program,
    /// The layers, which add up.
    pub layers: Vec<VolumeLayer>,
    /// Pass index of the material.
    pub pass_index: i32,
    /// True if no node asks for the place, so that the volume is constant along a ray, unless grids make it vary.
    pub is_even: bool,
}

impl Volume {
    /// The volume of a compiled graph, `None` where that has none; and reports on parts of it that are evaluated
    /// otherwise than in Blender.
    pub fn new(program: Program, pass_index: i32, answered: AnsweredFields) -> (Option<Self>, Vec<String>) {
        let mut reports = Vec::new();
        let layers: Vec<VolumeLayer> =
            program.volume.iter().take(MOST_LAYERS).filter_map(|layer| VolumeInputs(layer).layer()).collect();
        if program.volume.len() > MOST_LAYERS {
            let (count, most) = (program.volume.len(), MOST_LAYERS);
            reports.push(format!("its volume has {count} closures, those after the first {most} are left out"));
        }
        if layers.len() < program.volume.len().min(MOST_LAYERS) {
            reports.push("a surface's shader shows nothing in a volume".into());
        }
        for field in program.reads().filter(|&field| !(answered.in_volumes)(field)) {
            let what = format!("{} is not supported in volumes yet, it is 0", in_words(field));
            if !reports.contains(&what) {
                reports.push(what);
            }
        }
        let is_even = program.attributes.is_empty() && !program.reads().any(answered.along_rays);
        ((!layers.is_empty()).then_some(Self { program, layers, pass_index, is_even }), reports)
    }

    /// The names of the grids that closures ask for, beside those that nodes read as attributes.
    pub fn grids(&self) -> impl Iterator<Item = &str> {
        let principled = self.layers.iter().filter_map(|layer| match &layer.closure {
            VolumeClosure::Principled(principled) => Some(principled),
            _ => None,
        });
        principled.flat_map(|principled| principled.grids()).filter(|name| !name.is_empty())
    }

    /// True if any closure of the volume may emit.
    pub fn emits(&self) -> bool {
        let is_dark = |source: Source| source.constant(&self.program) == Some(Vec3A::ZERO);
        self.layers.iter().any(|layer| match &layer.closure {
            VolumeClosure::Absorption { .. } | VolumeClosure::Scatter { .. } => false,
            VolumeClosure::Coefficients { emission, .. } => !is_dark(*emission),
            VolumeClosure::Principled(p) => !is_dark(p.emission_strength) || !is_dark(p.blackbody),
            VolumeClosure::Emission { color, strength } => !is_dark(*color) && !is_dark(*strength),
        })
    }
}

/// A layer as Blender names its inputs.
struct VolumeInputs<'a>(&'a Layer);

impl VolumeInputs<'_> {
    fn layer(&self) -> Option<VolumeLayer> {
        Some(VolumeLayer { weight: Source::Of(self.0.weight), closure: self.closure()? })
    }

    fn input(&self, identifier: &str, otherwise: f32) -> Source {
        self.0.input(identifier).map_or(Source::Always(Vec3A::splat(otherwise)), Source::Of)
    }

    fn word(&self, name: &str, otherwise: &str) -> String {
        self.0.option(name).unwrap_or(otherwise).to_owned()
    }

    fn closure(&self) -> Option<VolumeClosure> {
        let (color, density) = (self.input("Color", 0.8), self.input("Density", 1.0));
        Some(match self.0.kind {
            LayerKind::VolumeAbsorption => VolumeClosure::Absorption { color, density },
            LayerKind::VolumeScatter => VolumeClosure::Scatter { color, density, phase: self.phase() },
            LayerKind::VolumeCoefficients => VolumeClosure::Coefficients {
                absorption: self.input("Absorption Coefficients", 1.0),
                scattering: self.input("Scatter Coefficients", 1.0),
                emission: self.input("Emission Coefficients", 0.0),
                phase: self.phase(),
            },
            LayerKind::PrincipledVolume => VolumeClosure::Principled(Box::new(PrincipledVolume {
                color: self.input("Color", 0.5),
                color_grid: self.word("Color Attribute", ""),
                density,
                density_grid: self.word("Density Attribute", "density"),
                anisotropy: self.input("Anisotropy", 0.0),
                absorption_color: self.input("Absorption Color", 0.0),
                emission_strength: self.input("Emission Strength", 0.0),
                emission_color: self.input("Emission Color", 1.0),
                blackbody: self.input("Blackbody Intensity", 0.0),
                blackbody_tint: self.input("Blackbody Tint", 1.0),
                temperature: self.input("Temperature", 1000.0),
                temperature_grid: self.word("Temperature Attribute", "temperature"),
            })),
            LayerKind::Emission => VolumeClosure::Emission { color, strength: self.input("Strength", 1.0) },
            _ => return None,
        })
    }

    fn phase(&self) -> Phase {
        let anisotropy = self.input("Anisotropy", 0.0);
        match self.0.option("phase") {
            Some("FOURNIER_FORAND") => {
                Phase::FournierForand { ior: self.input("IOR", 1.33), backscatter: self.input("Backscatter", 0.1) }
            }
            Some("DRAINE") => Phase::Draine { anisotropy, alpha: self.input("Alpha", 0.5) },
            Some("RAYLEIGH") => Phase::Rayleigh,
            Some("MIE") => Phase::Mie { diameter_um: self.input("Diameter", 20.0) },
            _ => Phase::HenyeyGreenstein { anisotropy },
        }
    }
}
