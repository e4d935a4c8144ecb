//! Closures of a shader graph, the sources of their inputs, and the slices of its program.

use super::closure::{Closure, Principled};
use glam::Vec3A;
use petzval_nodes::{Field, LaneRegisters, Operand, Program, Registers, Slice};

/// Closures that a material may have; further ones are left out.
pub const MOST_LAYERS: usize = 32;

/// The fields that are answered where a graph is evaluated. The points that answer are made of scenes: they tell this to the graph.
#[derive(Clone, Copy, Debug)]
pub struct AnsweredFields {
    /// True of a field that a surface answers, or the world in a direction.
    pub on_surfaces: fn(Field) -> bool,
    /// True of a field that a point in a volume answers.
    pub in_volumes: fn(Field) -> bool,
    /// True of a field that may differ between two points of a ray through a volume.
    pub along_rays: fn(Field) -> bool,
}

/// The name of a field in words, as "Random per island".
pub(super) fn in_words(field: Field) -> String {
    let name = format!("{field:?}");
    let words = name.char_indices().flat_map(|(i, c)| {
        let gap = (i > 0 && c.is_uppercase()).then_some(' ');
        gap.into_iter().chain([if i > 0 { c.to_ascii_lowercase() } else { c }])
    });
    words.collect()
}

/// The source of a closure's input.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// A result of the program, or a constant of it.
    Of(Operand),
    /// A finite value for all points: a constant, or the default of a socket that this Blender does not have.
    Always(Vec3A),
}

impl Source {
    /// The source's value once the program has run. A number stands in all three parts.
    #[inline]
    pub fn value(self, program: &Program, registers: &Registers) -> Vec3A {
        match self {
            Self::Of(operand) => program.value(operand, registers),
            Self::Always(value) => value,
        }
    }

    /// The source's value at the point of a lane once the program has run over lanes.
    #[inline]
    pub fn value_at(self, program: &Program, registers: &LaneRegisters, lane: usize) -> Vec3A {
        match self {
            Self::Of(operand) => program.value_at(operand, registers, lane),
            Self::Always(value) => value,
        }
    }

    /// The source's value if that is spatially constant.
    pub fn constant(self, program: &Program) -> Option<Vec3A> {
        match self {
            Self::Of(operand) => program.constant(operand),
            Self::Always(value) => Some(value),
        }
    }

    /// This source by its value, if it is a constant.
    pub(super) fn settled(self, program: &Program) -> Self {
        match self.constant(program) {
            Some(value) if value.is_finite() => Self::Always(value),
            Some(_) => Self::Always(Vec3A::ZERO),
            None => self,
        }
    }

    pub(super) fn operand(self) -> Option<Operand> {
        match self {
            Self::Of(operand) => Some(operand),
            Self::Always(_) => None,
        }
    }
}

/// A closure and its weight.
#[derive(Clone, Debug)]
pub struct GraphLayer {
    /// Weight, 0 to 1.
    pub weight: Source,
    /// The closure, its inputs as sources of values.
    pub closure: Closure<Source, Source>,
    /// A normal of its own, world space.
    pub normal: Option<Source>,
    /// The coat's own normal, world space, where it has one.
    pub coat_normal: Option<Source>,
    /// A direction of its own that brushed metal follows, world space.
    pub tangent: Option<Source>,
    /// True of the emission of a colour that is plugged in where a shader belongs.
    pub is_bare_colour: bool,
}

impl GraphLayer {
    /// The sources of the layer's weight, inputs and directions.
    pub(super) fn sources(&self) -> Vec<Source> {
        let (mut colors, mut numbers) = (Vec::new(), Vec::new());
        self.closure.map(|color| colors.push(*color), |number| numbers.push(*number));
        let directions = [self.normal, self.coat_normal, self.tangent].into_iter().flatten();
        std::iter::once(self.weight).chain(directions).chain(colors).chain(numbers).collect()
    }

    /// This layer without emission; `None` of a closure that does not scatter.
    pub(super) fn scattering(&self) -> Option<Self> {
        let closure = match self.closure {
            Closure::Emission { .. } | Closure::Transparent { .. } | Closure::Holdout => return None,
            Closure::Principled(principled) => {
                let [emission_color, emission_strength] = [Source::Always(Vec3A::ZERO); 2];
                Closure::Principled(Principled { emission_color, emission_strength, ..principled })
            }
            closure => closure,
        };
        Some(Self { closure, ..self.clone() })
    }

    /// This layer with values for the inputs that are spatially constant.
    pub(super) fn settled(&self, program: &Program) -> Self {
        let settle = |source: &Source| source.settled(program);
        Self {
            weight: settle(&self.weight),
            closure: self.closure.map(settle, settle),
            normal: self.normal.as_ref().map(settle),
            coat_normal: self.coat_normal.as_ref().map(settle),
            tangent: self.tangent.as_ref().map(settle),
            is_bare_colour: self.is_bare_colour,
        }
    }
}

/// Slices of a graph's program, one for each question that is asked of a point.
#[derive(Debug)]
pub struct Slices {
    /// Instructions of the weights and inputs of the closures that scatter.
    pub scattering: Slice,
    /// Instructions of the weights of holdouts.
    pub holdout: Slice,
    /// Instructions of the displacement.
    pub displacement: Slice,
    /// Instructions of the probability that a path passes unbent, and of its throughput then.
    pub opening: Slice,
    /// Instructions of a shadow ray's transmittance.
    pub transmittance: Slice,
    /// Instructions of the emitted radiance.
    pub emission: Slice,
}

impl Slices {
    pub(super) fn new(program: &Program, layers: &[GraphLayer], scattering: &[GraphLayer]) -> Self {
        let slice = |sources: Vec<Source>| program.slice(sources.into_iter().filter_map(Source::operand));
        let mut opening: Vec<Source> = layers.iter().map(|layer| layer.weight).collect();
        let (mut transmittance, mut emission) = (Vec::new(), Vec::new());
        for layer in layers {
            match &layer.closure {
                Closure::Transparent { color } => {
                    transmittance.extend([layer.weight, *color]);
                    opening.push(*color);
                }
                Closure::Emission { color, strength } => emission.extend([layer.weight, *color, *strength]),
                Closure::Principled(p) => {
                    if p.is_clear(program) {
                        transmittance.extend([layer.weight, p.alpha]);
                    }
                    if p.shines(program) {
                        emission.extend([layer.weight, p.emission_color, p.emission_strength, p.alpha]);
                    }
                    opening.push(p.alpha);
                }
                _ => {}
            }
            opening.extend(layer.closure.tint());
        }
        Self {
            // Closures without a normal of their own have the point's.
            scattering: slice(scattering.iter().flat_map(GraphLayer::sources).collect()).with_normal(),
            holdout: slice(
                layers
                    .iter()
                    .filter(|layer| matches!(layer.closure, Closure::Holdout))
                    .map(|layer| layer.weight)
                    .collect(),
            ),
            displacement: program.slice(program.displacement),
            opening: slice(opening),
            transmittance: slice(transmittance),
            emission: slice(emission),
        }
    }
}
