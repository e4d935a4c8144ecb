//! Parts of a program, for those who do not need all of its values.

use super::instruction::{FIRST_CONSTANT, Instruction, Operand, Operation};
use super::{Program, REGISTERS, Registers};
use crate::context::{Context, Field, Shift, Textures};
use crate::image::Projection;

/// The instructions of a [`Program`] that some of its values need.
#[derive(Clone, Debug, Default)]
pub struct Slice {
    code: Vec<Instruction>,
    reads_normal: bool,
    reads_footprint: bool,
}

impl Slice {
    /// Whether the values are constants: nothing has to be run.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    /// Whether an instruction may ask for the shading normal.
    #[inline]
    pub fn reads_normal(&self) -> bool {
        self.reads_normal
    }

    /// Whether an instruction may look beside the point, or asks how far that is.
    #[inline]
    pub fn reads_footprint(&self) -> bool {
        self.reads_footprint
    }

    /// How many instructions it has.
    pub fn len(&self) -> usize {
        self.code.len()
    }
}

impl Program {
    /// The instructions that these values need, in their order.
    pub fn slice(&self, values: impl IntoIterator<Item = Operand>) -> Slice {
        // By register, whether a later instruction or the caller reads what is in it.
        let mut is_read = [false; REGISTERS];
        let read = |operand: Operand, is_read: &mut [bool; REGISTERS]| {
            if operand.0 < FIRST_CONSTANT {
                is_read[usize::from(operand.0)] = true;
            }
        };
        values.into_iter().for_each(|operand| read(operand, &mut is_read));
        let mut code = Vec::new();
        for instruction in self.code.iter().rev() {
            if std::mem::take(&mut is_read[usize::from(instruction.result)]) {
                instruction.operands().iter().for_each(|operand| read(*operand, &mut is_read));
                code.push(*instruction);
            }
        }
        code.reverse();
        let any = |asks: fn(Operation) -> bool| code.iter().any(|instruction| asks(instruction.operation));
        let (reads_normal, reads_footprint) = (any(asks_for_normal), any(asks_for_footprint));
        Slice { code, reads_normal, reads_footprint }
    }

    /// Whether an instruction may look beside the point, or asks how far that is.
    pub fn reads_footprint(&self) -> bool {
        self.code.iter().any(|instruction| asks_for_footprint(instruction.operation))
    }

    /// Computes the values of a [`slice`](Self::slice), the same bits as [`run`](Self::run) has.
    pub fn run_slice<C: Context, T: Textures>(
        &self,
        slice: &Slice,
        context: &C,
        textures: &T,
        registers: &mut Registers,
    ) {
        for instruction in &slice.code {
            self.step(instruction, context, textures, registers);
        }
    }
}

/// Whether a context may look at the shading normal for it. What is not known to do without is taken to ask.
fn asks_for_normal(operation: Operation) -> bool {
    match operation {
        Operation::Read(field, _) => matches!(field, Field::Normal | Field::MeshNormal | Field::Reflection),
        Operation::Image(_, projection, _) => projection == Projection::Box,
        Operation::Further(_)
        | Operation::Attribute(..)
        | Operation::Transform(..)
        | Operation::Fresnel
        | Operation::LayerFresnel
        | Operation::Facing
        | Operation::Falloff(_)
        | Operation::Wireframe(_)
        | Operation::Environment(..) => false,
        _ => !operation.is_pure(),
    }
}

/// Whether a context needs the footprint for it. What is not known to do without is taken to ask.
fn asks_for_footprint(operation: Operation) -> bool {
    match operation {
        Operation::Read(field, shift) => shift != Shift::NONE || matches!(field, Field::FootprintX | Field::FootprintY),
        Operation::Attribute(_, shift) => shift != Shift::NONE,
        Operation::Further(_)
        | Operation::Transform(..)
        | Operation::Fresnel
        | Operation::LayerFresnel
        | Operation::Facing
        | Operation::Falloff(_)
        | Operation::Wireframe(_)
        | Operation::Image(..)
        | Operation::Environment(..)
        | Operation::NormalMap(_)
        | Operation::RadialTangent(_) => false,
        _ => !operation.is_pure(),
    }
}
