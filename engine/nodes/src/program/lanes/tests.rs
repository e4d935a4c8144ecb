//! Every operation over lanes has the bits that it has at each point alone.

use super::*;
use crate::colour::ColourModel;
use crate::context::{Context, Extension, ImageReading, Interpolation, Occlusion};
use crate::gabor::GaborKind;
use crate::hash::random_of_pair;
use crate::image::{EnvironmentProjection, ImageTexture, Projection};
use crate::mix::Blend;
use crate::noise::{Dimensions, Fractal};
use crate::patterns::{GradientKind, WaveAxis, WaveKind, WaveProfile};
use crate::program::Registers;
use crate::surface::Axis;
use crate::table::Table;
use crate::vector::{MappingKind, RotationKind};
use crate::voronoi::{CellHash, Feature, Metric};
use glam::{Affine3A, Mat3A, Vec2, Vec3Swizzles, Vec4};

/// A number of a kind that operations get: mostly small, at times 0, 1, large, or none.
fn number(seed: [u32; 2]) -> f32 {
    let unit = random_of_pair(seed) * 2.0 - 1.0;
    match (random_of_pair([seed[1], seed[0]]) * 40.0) as u32 {
        0 | 1 => 0.0,
        2 | 3 => 1.0,
        4 => unit * 1e6,
        5 => [f32::NAN, f32::INFINITY, -0.0, -1.0][(unit.abs() * 3.99) as usize],
        _ => unit * 2.5,
    }
}

fn vector(seed: u32, of: u32) -> Vec3A {
    Vec3A::from_array([0, 1, 2].map(|part| number([seed, of * 3 + part])))
}

/// A point of a surface whose answers are hashes.
struct Place(u32);

impl Context for Place {
    fn knows(_: Field) -> bool {
        true
    }
    fn answer(&self, field: Field, shift: Shift) -> Option<Vec3A> {
        Some(match field {
            Field::Backfacing => Vec3A::splat((self.0 & 1) as f32),
            Field::Normal | Field::Incoming | Field::MeshNormal => vector(self.0, field as u32).normalize_or_zero(),
            _ => vector(self.0, field as u32) + shift.x + shift.y,
        })
    }
    fn attribute(&self, index: usize, shift: Shift) -> Vec4 {
        (vector(self.0, 77 + index as u32) + shift.x).extend(shift.y - 0.5)
    }
    fn transform(&self, _: Direction, _: Space, _: Space, vector: Vec3A) -> Vec3A {
        vector.zxy() * 2.0 - Vec3A::splat(self.0 as f32 * 1e-3)
    }
}

struct Picture;

impl Textures for Picture {
    fn lookup(&self, image: usize, uv: Vec2, _: ImageReading) -> Vec4 {
        Vec4::new(uv.x, uv.y, image as f32, 0.5)
    }
}

fn program() -> Program {
    let rows = (0..32).map(|i| Vec4::splat(number([i, 5]).clamp(-2.0, 2.0))).collect();
    let table = Table { rows, interpolate: true, range: [0.0, 1.0], extrapolate: false };
    let matrix3 = Mat3A::from_cols(vector(1, 900), vector(2, 900), Vec3A::new(0.3, -0.2, 1.5));
    let constants = (0..4).map(|i| Vec3A::splat(0.5 + i as f32)).collect();
    let map = Affine3A { matrix3, translation: Vec3A::new(1.0, 2.0, 3.0) };
    Program { tables: vec![table], maps: vec![map], constants, ..Program::default() }
}

/// Every operation, with every option that chooses another way to compute it.
#[expect(clippy::too_many_lines, reason = "a list")]
fn operations() -> Vec<Operation> {
    let shift = Shift { x: 0.1, y: 0.2 };
    let mut all = vec![
        Operation::Read(Field::Position, shift),
        Operation::Attribute(1, shift),
        Operation::Affine(0),
        Operation::Transform(Direction::Normal, Space::Object, Space::World),
        Operation::Luminance,
        Operation::Mean,
        Operation::Part(0),
        Operation::Part(1),
        Operation::Part(2),
        Operation::Combine,
        Operation::Clamp(true),
        Operation::Clamp(false),
        Operation::ClampVector,
        Operation::MixParts,
        Operation::Saturate,
        Operation::Invert,
        Operation::Gamma,
        Operation::BrightContrast,
        Operation::HueSaturation,
        Operation::Ramp(0),
        Operation::Curves(0),
        Operation::FloatCurve(0),
        Operation::Blackbody,
        Operation::Wavelength,
        Operation::Fresnel,
        Operation::LayerFresnel,
        Operation::Facing,
        Operation::Falloff(2),
        Operation::Wireframe(true),
        Operation::Occlusion(Occlusion { samples: 4, inside: false, only_local: false }),
        Operation::Bevel(4),
        Operation::Checker,
        Operation::Brick(2, 2),
        Operation::Bump(0.1),
        Operation::Displacement(Space::Object),
        Operation::VectorDisplacement(NormalSpace::Tangent),
        Operation::RadialTangent(Axis::Z),
    ];
    all.extend(MathKind::ALL.iter().flat_map(|&kind| [Operation::Math(kind, false), Operation::Math(kind, true)]));
    all.extend(VectorMathKind::ALL.iter().map(|&kind| Operation::VectorMath(kind)));
    all.extend(RangeKind::ALL.iter().flat_map(|&kind| [Operation::MapRange(kind), Operation::MapRangeVector(kind)]));
    all.extend(Blend::ALL.iter().map(|&blend| Operation::Mix(blend)));
    all.extend(ColourModel::ALL.iter().flat_map(|&model| [Operation::ToModel(model), Operation::FromModel(model)]));
    all.extend(NormalSpace::ALL.iter().map(|&space| Operation::NormalMap(space)));
    all.extend(GradientKind::ALL.iter().map(|&kind| Operation::Gradient(kind)));
    all.extend(MappingKind::ALL.iter().map(|&kind| Operation::Mapping(kind)));
    all.extend(RotationKind::ALL.iter().map(|&kind| Operation::Rotate(kind, true)));
    all.push(Operation::Wave(WaveKind::Bands, WaveAxis::ALL[0], WaveProfile::ALL[0]));
    all.push(Operation::Gabor(GaborKind::ALL[0]));
    let reading =
        ImageReading { interpolation: Interpolation::Linear, extension: Extension::Repeat, unassociate: true };
    let image = ImageTexture { image: 3, reading };
    all.extend(Projection::ALL.iter().map(|&projection| Operation::Image(image, projection)));
    all.push(Operation::Environment(image, EnvironmentProjection::MirrorBall));
    for &dimensions in Dimensions::ALL {
        all.push(Operation::WhiteNoise(dimensions));
        all.push(Operation::Voronoi(dimensions, Feature::ALL[0], Metric::ALL[0], CellHash::Lookup3, false));
        for &fractal in Fractal::ALL {
            all.extend([false, true].map(|coloured| Operation::Noise(dimensions, fractal, coloured, coloured)));
        }
    }
    all
}

/// Runs an operation on values in registers, or on constants from the third operand on, at points alone and at all of them together.
fn hold(program: &Program, operation: Operation, count: usize, seed: u32, is_even: bool) {
    let operands: [Operand; MOST_OPERANDS] = std::array::from_fn(|i| {
        if is_even && i > 2 { Operand(FIRST_CONSTANT + i as u16 % 4) } else { Operand(i as u16 + 1) }
    });
    // The result takes the place of an operand.
    let into = |result: u16, operation| Instruction { operation, operands, count: MOST_OPERANDS as u8, result };
    let code = [
        into(2, operation),
        into(12, Operation::Further(0)),
        into(13, Operation::Further(1)),
        into(14, Operation::Further(2)),
    ];
    let places: Vec<Place> = (0..count as u32).map(|lane| Place(seed * 8 + lane)).collect();
    let given = |lane: usize, register: u32| vector(seed * 8 + lane as u32, 100 + register);

    let mut at_once = LaneRegisters::default();
    for (lane, register) in (0..LANES).flat_map(|lane| (0..12).map(move |register| (lane, register))) {
        // What is in lanes without a point does not matter.
        let value = if lane < count { given(lane, register) } else { Vec3A::NAN };
        at_once.values[register as usize].put(lane, value);
    }
    code.iter().for_each(|one| program.step_lanes(one, &places[..], &Picture, &mut at_once));
    for (lane, place) in places.iter().enumerate() {
        let mut alone = Registers::default();
        (0..12).for_each(|register| alone.values[register as usize] = given(lane, register));
        code.iter().for_each(|one| program.step(one, place, &Picture, &mut alone));
        for register in [2, 12, 13, 14] {
            let expected = alone.values[register].to_array();
            let found = at_once.values[register].at(lane).to_array();
            let is_same = |(a, b): (f32, f32)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            assert!(
                expected.into_iter().zip(found).all(is_same),
                "{operation:?}, register {register}, lane {lane} of {count}: {found:?}, alone {expected:?}"
            );
        }
    }
}

#[test]
fn a_point_among_others_is_a_point_alone() {
    let program = program();
    for operation in operations() {
        for round in 0..60 {
            hold(&program, operation, 1 + round as usize % LANES, round, round % 3 != 0);
        }
    }
}
