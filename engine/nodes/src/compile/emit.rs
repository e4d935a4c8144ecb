//! Instructions as they are made: folded where nothing varies, found again where they stand already.

use super::Compiler;
use crate::context::{Attribute, AttributeKind, Nowhere};
use crate::math::MathKind;
use crate::mix::Blend;
use crate::program::{FIRST_CONSTANT, Instruction, MOST_OPERANDS, Operand, Operation};
use crate::vector::VectorMathKind;
use glam::Vec3A;

/// While compiling, results are virtual registers, numbered from here on: above all constants.
pub(super) const FIRST_VIRTUAL: u16 = 0x8000;

const MOST_CONSTANTS: usize = (FIRST_VIRTUAL - FIRST_CONSTANT) as usize;
const MOST_INSTRUCTIONS: usize = (u16::MAX - FIRST_VIRTUAL) as usize;

impl Compiler<'_> {
    pub(super) fn constant(&mut self, value: Vec3A) -> Operand {
        let bits = value.to_array().map(f32::to_bits);
        if let Some(known) = self.constants.get(&bits) {
            return *known;
        }
        if self.program.constants.len() >= MOST_CONSTANTS {
            return Operand(FIRST_CONSTANT);
        }
        let operand = Operand(FIRST_CONSTANT + self.program.constants.len() as u16);
        self.program.constants.push(value);
        self.constants.insert(bits, operand);
        operand
    }

    /// The value of an operand that does not vary.
    pub(super) fn known(&self, operand: Operand) -> Option<Vec3A> {
        (operand.0 < FIRST_VIRTUAL).then(|| self.program.constants[usize::from(operand.0 - FIRST_CONSTANT)])
    }

    fn is_known(&self, operand: Operand, value: f32) -> bool {
        self.known(operand) == Some(Vec3A::splat(value))
    }

    pub(super) fn emit(&mut self, operation: Operation, operands: &[Operand]) -> Operand {
        self.shortcut(operation, operands).unwrap_or_else(|| self.emit_many::<0>(operation, operands).0)
    }

    /// An operand that is the result already: groups of nodes come with parts that their settings switch off by a 0 or a 1. As in
    /// Cycles 0 times anything is 0.
    fn shortcut(&self, operation: Operation, operands: &[Operand]) -> Option<Operand> {
        use {MathKind as Number, VectorMathKind as Vector};
        let is = |i: usize, value: f32| self.is_known(operands[i], value);
        let first_that = |value: f32| (0..2).find(|&i| is(i, value)).map(|i| operands[i]);
        let other_than = |value: f32| (0..2).find(|&i| is(i, value)).map(|i| operands[1 - i]);
        match operation {
            Operation::Mix(blend) if is(0, 0.0) && blend.is_first_at_0() => Some(operands[1]),
            Operation::Mix(Blend::Mix) if is(0, 1.0) => Some(operands[2]),
            Operation::Math(Number::Multiply, false) | Operation::VectorMath(Vector::Multiply) => {
                first_that(0.0).or_else(|| other_than(1.0))
            }
            Operation::Math(Number::Add, false) | Operation::VectorMath(Vector::Add) => other_than(0.0),
            Operation::Math(Number::Subtract, false) | Operation::VectorMath(Vector::Subtract) if is(1, 0.0) => {
                Some(operands[0])
            }
            Operation::Math(Number::Divide | Number::Power, false) | Operation::VectorMath(Vector::Divide)
                if is(1, 1.0) =>
            {
                Some(operands[0])
            }
            Operation::VectorMath(Vector::Scale) if is(3, 0.0) => Some(operands[3]),
            Operation::VectorMath(Vector::Scale) if is(3, 1.0) => Some(operands[0]),
            _ => None,
        }
    }

    /// An instruction with `N` further results.
    pub(super) fn emit_many<const N: usize>(
        &mut self,
        operation: Operation,
        operands: &[Operand],
    ) -> (Operand, [Operand; N]) {
        let mut instruction = Instruction {
            operation,
            operands: [Operand(FIRST_CONSTANT); MOST_OPERANDS],
            count: operands.len() as u8,
            result: 0,
        };
        instruction.operands[..operands.len()].copy_from_slice(operands);
        if operation.is_pure() && operands.iter().all(|operand| self.known(*operand).is_some()) {
            self.program.step(&instruction, &Nowhere, &Nowhere, &mut self.scratch);
            let (result, further) = self.scratch.results();
            return (self.constant(result), std::array::from_fn(|i| self.constant(further[i])));
        }
        let result = self.place(instruction);
        (result, std::array::from_fn(|i| self.further(i as u8, result)))
    }

    fn further(&mut self, number: u8, of: Operand) -> Operand {
        let mut operands = [Operand(FIRST_CONSTANT); MOST_OPERANDS];
        operands[0] = of;
        self.place(Instruction { operation: Operation::Further(number), operands, count: 1, result: 0 })
    }

    fn place(&mut self, mut instruction: Instruction) -> Operand {
        if let Some(same) = self.code.iter().position(|other| {
            (other.operation, other.operands, other.count)
                == (instruction.operation, instruction.operands, instruction.count)
        }) {
            return Operand(FIRST_VIRTUAL + same as u16);
        }
        if self.code.len() >= MOST_INSTRUCTIONS {
            self.report(self.open.last().copied().unwrap_or(0), "the graph is too large, it is black");
            return self.constant(Vec3A::ZERO);
        }
        let operand = Operand(FIRST_VIRTUAL + self.code.len() as u16);
        instruction.result = operand.0;
        self.code.push(instruction);
        operand
    }

    /// The place of an attribute in the program's list.
    pub(super) fn attribute(&mut self, kind: AttributeKind, name: &str) -> u16 {
        let attribute = Attribute { kind, name: name.to_owned() };
        let attributes = &mut self.program.attributes;
        attributes.iter().position(|other| *other == attribute).unwrap_or_else(|| {
            attributes.push(attribute);
            attributes.len() - 1
        }) as u16
    }
}
