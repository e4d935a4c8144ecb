//! The instructions of a program.

use crate::colour::ColourModel;
use crate::context::{Direction, Field, Occlusion, Raycast, Shift, Space};
use crate::gabor::GaborKind;
use crate::image::{EnvironmentProjection, ImageTexture, Projection};
use crate::math::{MathKind, RangeKind};
use crate::mix::Blend;
use crate::noise::{Dimensions, Fractal};
use crate::patterns::{GradientKind, WaveAxis, WaveKind, WaveProfile};
use crate::surface::{Axis, NormalSpace};
use crate::vector::{MappingKind, RotationKind, VectorMathKind};
use crate::voronoi::{CellHash, Feature, Metric};

/// The source of an instruction's value: a register, or a constant of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Operand(pub(crate) u16);

/// Registers are below, constants from here on.
pub(crate) const FIRST_CONSTANT: u16 = 256;

/// The most operands that an instruction has.
pub(crate) const MOST_OPERANDS: usize = 10;

/// The operation of an instruction on its operands, which come in the order in which the comments name them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    /// A further result of the instruction before: its number from 0. Operand: that instruction's result.
    Further(u8),
    Read(Field, Shift),
    /// Further: the fourth part.
    Attribute(u16, Shift),
    /// Vector, with the factors of a table's affine map.
    Affine(u16),
    Transform(Direction, Space, Space),
    Luminance,
    Mean,
    /// x, y or z.
    Part(u8),
    /// x, y, z.
    Combine,
    ToModel(ColourModel),
    FromModel(ColourModel),
    Math(MathKind, bool),
    /// a, b, c, scale.
    VectorMath(VectorMathKind),
    /// Value, from, from, to, to, steps.
    MapRange(RangeKind),
    MapRangeVector(RangeKind),
    /// Value, bound, bound; `true`: in either order.
    Clamp(bool),
    /// [`Self::Clamp`] of each part by its own bounds.
    ClampVector,
    /// Factor, a, b.
    Mix(Blend),
    /// [`Self::Mix`] of each part by its own factor.
    MixParts,
    /// Each part clamped to 0 and 1.
    Saturate,
    /// Colour, factor.
    Invert,
    /// Colour, exponent.
    Gamma,
    /// Colour, bright, contrast.
    BrightContrast,
    /// Hue, saturation, value, factor, colour.
    HueSaturation,
    /// Place. Further: alpha.
    Ramp(u16),
    /// Factor, value.
    Curves(u16),
    FloatCurve(u16),
    Blackbody,
    Wavelength,
    /// Index or blend, normal.
    Fresnel,
    LayerFresnel,
    Facing,
    /// Size, distance to the nearest side; `true`: the size is in pixels.
    Wireframe(bool),
    /// Strength, smooth.
    Falloff(i8),
    /// Normal, distance.
    Occlusion(Occlusion),
    /// Normal, radius; number of samples.
    Bevel(u8),
    /// Position, direction, length, shift: whether something is hit, whether it is the object itself, its distance. Further: place, normal,
    /// attribute.
    Raycast(Raycast),
    /// Vector, w, scale, detail, roughness, lacunarity, offset, gain, distortion; with colour or without.
    Noise(Dimensions, Fractal, bool, bool),
    /// Vector, w, scale, detail, roughness, lacunarity, smoothness, exponent, randomness: distance.
    /// Further: colour, position, w.
    Voronoi(Dimensions, Feature, Metric, CellHash, bool),
    /// Vector, scale, distortion, detail, detail scale, detail roughness, phase.
    Wave(WaveKind, WaveAxis, WaveProfile),
    /// Vector, scale, distortion.
    Magic(u8),
    Gradient(GradientKind),
    /// Vector, scale.
    Checker,
    /// Vector, scale, mortar size, mortar smooth, bias, width, row height, offset, squash: mortar. Further: tint.
    Brick(i16, i16),
    /// Vector, w. Further: colour.
    WhiteNoise(Dimensions),
    /// Vector, sides, roundness; `true`: normalized: coordinates. Further: segment, width, rotation.
    RadialTiling(bool),
    /// Vector, scale, frequency, anisotropy, orientation, direction: value. Further: phase, intensity.
    Gabor(GaborKind),
    /// Direction.
    Sky(u16),
    /// Direction, strength.
    Luminaire(u16),
    /// Vector, blend. Further: alpha.
    Image(ImageTexture, Projection),
    Environment(ImageTexture, EnvironmentProjection),
    /// Vector, location, rotation, scale.
    Mapping(MappingKind),
    /// Vector, centre, axis, angle, angles.
    Rotate(RotationKind, bool),
    /// Generated coordinate, normal.
    RadialTangent(Axis),
    /// Height, height beside in x, in y, normal, strength, distance; filter width.
    Bump(f32),
    /// Colour, strength, tangent, sign.
    NormalMap(NormalSpace),
    /// Height, midlevel, scale, normal.
    Displacement(Space),
    /// Vector, midlevel, scale, tangent, sign.
    VectorDisplacement(NormalSpace),
}

impl Operation {
    /// The field of the point that the result depends on, beside the operands.
    pub(crate) fn read_field(self) -> Option<Field> {
        match self {
            Self::Read(field, _) => Some(field),
            Self::Falloff(_) => Some(Field::RayLength),
            _ => None,
        }
    }

    /// True if the result depends on the operands alone.
    pub(crate) fn is_pure(self) -> bool {
        !matches!(
            self,
            Self::Further(_)
                | Self::Read(..)
                | Self::Attribute(..)
                | Self::Transform(..)
                | Self::Fresnel
                | Self::LayerFresnel
                | Self::Facing
                | Self::Falloff(_)
                | Self::Occlusion(_)
                | Self::Bevel(_)
                | Self::Raycast(_)
                | Self::Wireframe(_)
                | Self::Image(..)
                | Self::Environment(..)
                | Self::RadialTangent(_)
                | Self::Bump(_)
                | Self::NormalMap(_)
                | Self::Displacement(_)
                | Self::VectorDisplacement(_)
        )
    }
}

/// An operation, its operands, and the register for its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instruction {
    pub(crate) operation: Operation,
    pub(crate) operands: [Operand; MOST_OPERANDS],
    pub(crate) count: u8,
    pub(crate) result: u16,
}

// Some two to a line of the cache.
const _: () = assert!(size_of::<Instruction>() == 36);

impl Instruction {
    pub(crate) fn operands(&self) -> &[Operand] {
        &self.operands[..usize::from(self.count)]
    }
}
