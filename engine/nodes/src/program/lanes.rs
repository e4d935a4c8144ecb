//! A program over up to eight points at once: each instruction is looked at once for all of them. An instruction that is the same function
//! of numbers and of lanes is computed for all lanes; the rest by each lane's own [`Program::compute`]. A point has the bits that it has
//! alone.

use super::evaluate::{Asked, tangent_map};
use super::instruction::{FIRST_CONSTANT, Instruction, MOST_OPERANDS, Operand, Operation};
use super::slice::Slice;
use super::{Program, REGISTERS};
use crate::colour;
use crate::context::{Direction, Field, Places, Shift, Space, Textures};
use crate::lanes::{LANES, Number, Vector, Vectors};
use crate::math::{MathKind, RangeKind, clamp_between, clamp_in_order, map_range};
use crate::mix::interpolate;
use crate::noise::{Octaves, noise_texture};
use crate::surface::NormalSpace;
use crate::vector::VectorMathKind;
use glam::Vec3A;
use wide::f32x8;

/// Working memory of programs over lanes.
pub struct LaneRegisters {
    values: Box<[Vectors; REGISTERS]>,
    /// Further results of the last instruction that has any.
    further: [Vectors; 3],
}

impl Default for LaneRegisters {
    fn default() -> Self {
        Self { values: Box::new([Vectors::ZERO; REGISTERS]), further: [Vectors::ZERO; 3] }
    }
}

/// All points of the lanes.
struct All<'a, P: ?Sized>(&'a P);

impl<P: Places + ?Sized> Asked for All<'_, P> {
    type Vector = Vectors;
    #[inline(always)]
    fn read(&self, field: Field) -> Vectors {
        self.0.read(field, Shift::NONE)
    }
    #[inline(always)]
    fn transform(&self, direction: Direction, from: Space, to: Space, vector: Vectors) -> Vectors {
        self.0.transform(direction, from, to, vector)
    }
}

/// A function of numbers in each lane; the compiler makes one of lanes out of it where it has no branches.
#[inline(always)]
fn each<const N: usize>(operands: [f32x8; N], function: impl Fn([f32; N]) -> f32) -> f32x8 {
    let operands = operands.map(|operand| operand.to_array());
    f32x8::from(std::array::from_fn::<f32, LANES, _>(|lane| function(operands.map(|operand| operand[lane]))))
}

impl Program {
    /// The value of an operand at a lane's point, after [`run_lanes`](Self::run_lanes). A number stands in all three parts.
    #[inline]
    pub fn value_at(&self, operand: Operand, registers: &LaneRegisters, lane: usize) -> Vec3A {
        if operand.0 < FIRST_CONSTANT {
            registers.values[usize::from(operand.0 as u8)].at(lane)
        } else {
            self.constants[usize::from(operand.0 - FIRST_CONSTANT)]
        }
    }

    /// Computes the values of a slice at all points, for each the same bits as [`run_slice`](Self::run_slice) has.
    pub fn run_lanes<P: Places + ?Sized, T: Textures>(
        &self,
        slice: &Slice,
        places: &P,
        textures: &T,
        registers: &mut LaneRegisters,
    ) {
        for instruction in &slice.code {
            self.step_lanes(instruction, places, textures, registers);
        }
    }

    #[inline]
    #[expect(clippy::too_many_lines, reason = "an arm for each operation")]
    fn step_lanes<P: Places + ?Sized, T: Textures>(
        &self,
        instruction: &Instruction,
        places: &P,
        textures: &T,
        registers: &mut LaneRegisters,
    ) {
        let given = &*registers;
        let vector = |i: usize| self.operand(instruction.operands[i], given);
        let number = |i: usize| self.operand(instruction.operands[i], given).x;
        let splat = Vectors::splat;
        let mut fourth = None;
        let result = match instruction.operation {
            Operation::Further(which) => given.further[usize::from(which)],
            Operation::Read(field, shift) => places.read(field, shift),
            Operation::Attribute(index, shift) => {
                let (value, last) = places.attribute(usize::from(index), shift);
                fourth = Some(last);
                value
            }
            Operation::Transform(direction, from, to) => places.transform(direction, from, to, vector(0)),
            Operation::Affine(map) => {
                let map = &self.maps[usize::from(map)];
                let [x, y, z] = vector(0).parts();
                let [a, b, c] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(Vectors::all);
                a.times(x) + b.times(y) + c.times(z) + Vectors::all(map.translation)
            }
            Operation::Luminance => splat(colour::luminance(vector(0))),
            Operation::Mean => {
                let [x, y, z] = vector(0).parts();
                splat((x + y + z) * (1.0 / 3.0))
            }
            Operation::Part(0) => splat(vector(0).x),
            Operation::Part(1) => splat(vector(0).y),
            Operation::Part(_) => splat(vector(0).z),
            Operation::Combine => Vectors { x: number(0), y: number(1), z: number(2) },
            Operation::Math(kind, clamped) => {
                let value = of_numbers(kind, [number(0), number(1), number(2)]);
                splat(if clamped { value.saturated() } else { value })
            }
            Operation::VectorMath(VectorMathKind::Add) => vector(0) + vector(1),
            Operation::VectorMath(VectorMathKind::Subtract) => vector(0) - vector(1),
            Operation::VectorMath(VectorMathKind::Multiply) => vector(0) * vector(1),
            Operation::VectorMath(VectorMathKind::MultiplyAdd) => vector(0) * vector(1) + vector(2),
            Operation::VectorMath(VectorMathKind::Scale) => vector(0).times(number(3)),
            Operation::VectorMath(VectorMathKind::Dot) => splat(vector(0).inner(vector(1))),
            Operation::VectorMath(VectorMathKind::Cross) => vector(0).across(vector(1)),
            Operation::VectorMath(VectorMathKind::Normalize) => vector(0).unit(),
            Operation::MapRange(RangeKind::Linear) => {
                let operands = [0, 1, 2, 3, 4].map(number);
                splat(each(operands, |[v, a, b, c, d]| map_range(RangeKind::Linear, v, [a, b], [c, d], 0.0, 0.0)))
            }
            Operation::Clamp(true) => splat(each([0, 1, 2].map(number), |[v, a, b]| clamp_between(v, a, b))),
            Operation::Clamp(false) => splat(each([0, 1, 2].map(number), |[v, a, b]| clamp_in_order(v, a, b))),
            Operation::Mix(blend) => match blend.sums(number(0), vector(1), vector(2)) {
                Some(sum) => sum,
                None => return self.step_apart(instruction, places, textures, registers),
            },
            Operation::MixParts => interpolate(vector(1), vector(2), vector(0)),
            Operation::Saturate => vector(0).saturated(),
            Operation::Invert => colour::invert(vector(0), number(1)),
            Operation::Noise(dimensions, fractal, normalize, coloured) => {
                let setting = |i: usize| self.same(instruction.operands[i], given, places.count());
                let Some([detail, roughness, lacunarity, offset, gain, distortion]) =
                    all([3, 4, 5, 6, 7, 8].map(setting))
                else {
                    return self.step_apart(instruction, places, textures, registers);
                };
                let octaves = Octaves { fractal, normalize, detail, roughness, lacunarity, offset, gain };
                let (p, scale) = (vector(0), number(2));
                let p = p.times(scale).parts();
                Vectors::of(noise_texture(dimensions, octaves, p, number(1) * scale, distortion, coloured))
            }
            Operation::NormalMap(NormalSpace::Tangent) => {
                tangent_map(&All(places), vector(0), number(1), vector(2), number(3))
            }
            _ => return self.step_apart(instruction, places, textures, registers),
        };
        registers.values[usize::from(instruction.result as u8)] = result;
        if let Some(fourth) = fourth {
            registers.further = [splat(fourth), Vectors::ZERO, Vectors::ZERO];
        }
    }

    /// An instruction that is computed lane by lane.
    #[inline(never)]
    fn step_apart<P: Places + ?Sized, T: Textures>(
        &self,
        instruction: &Instruction,
        places: &P,
        textures: &T,
        registers: &mut LaneRegisters,
    ) {
        // What is the same at all points is fetched once.
        let mut operands = [Vec3A::ZERO; MOST_OPERANDS];
        let (mut numbers, mut varying) = ([0; MOST_OPERANDS], 0);
        for (i, &operand) in instruction.operands().iter().enumerate() {
            operands[i] = self.value_at(operand, registers, 0);
            if operand.0 < FIRST_CONSTANT {
                numbers[varying] = i;
                varying += 1;
            }
        }
        // The result may take the place of an operand.
        let mut result = Vectors::ZERO;
        for lane in 0..places.count() {
            for &i in &numbers[..varying] {
                operands[i] = self.value_at(instruction.operands[i], registers, lane);
            }
            let (value, further) = self.compute(instruction.operation, |i| operands[i], places.point(lane), textures);
            result.put(lane, value);
            if let Some(further) = further {
                registers.further.iter_mut().zip(further).for_each(|(all, one)| all.put(lane, one));
            }
        }
        registers.values[usize::from(instruction.result as u8)] = result;
    }

    #[inline(always)]
    fn operand(&self, operand: Operand, registers: &LaneRegisters) -> Vectors {
        if operand.0 < FIRST_CONSTANT {
            registers.values[usize::from(operand.0 as u8)]
        } else {
            Vectors::all(self.constants[usize::from(operand.0 - FIRST_CONSTANT)])
        }
    }

    /// The number that an operand is at all points; `None` where they differ.
    fn same(&self, operand: Operand, registers: &LaneRegisters, count: usize) -> Option<f32> {
        if operand.0 >= FIRST_CONSTANT {
            return Some(self.constants[usize::from(operand.0 - FIRST_CONSTANT)].x);
        }
        let values = registers.values[usize::from(operand.0 as u8)].x.to_array();
        let first = values[0];
        values[..count].iter().all(|value| value.to_bits() == first.to_bits()).then_some(first)
    }
}

/// All of some values, if there are all.
fn all<const N: usize>(values: [Option<f32>; N]) -> Option<[f32; N]> {
    values.iter().all(Option::is_some).then(|| values.map(Option::unwrap_or_default))
}

/// A node's function of numbers in each lane. Those of most use are told apart, so that there is no branch in them.
#[inline(always)]
fn of_numbers(kind: MathKind, operands: [f32x8; 3]) -> f32x8 {
    macro_rules! told_apart {
        ($($told:ident)*) => {
            match kind {
                $(MathKind::$told => each(operands, |[a, b, c]| MathKind::$told.apply(a, b, c)),)*
                _ => each(operands, |[a, b, c]| kind.apply(a, b, c)),
            }
        };
    }
    told_apart!(Add Subtract Multiply Divide MultiplyAdd Minimum Maximum LessThan GreaterThan Absolute SquareRoot Floor Fraction)
}

#[cfg(test)]
mod tests;
