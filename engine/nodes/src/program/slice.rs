//! Parts of a program, for those who do not need all of its values.

use super::instruction::{FIRST_CONSTANT, Instruction, Operand, Operation};
use super::{Program, REGISTERS, Registers};
use crate::context::{Context, Field, Shift, Textures};
use crate::image::Projection;

/// The instructions of a [`Program`] that some of its values need.
#[derive(Clone, Debug, Default)]
pub struct Slice {
    pub(super) code: Vec<Instruction>,
    needs_normal: bool,
    needs_footprint: bool,
}

impl Slice {
    /// True if the values are constants, so that nothing has to be run.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    /// This slice, for a caller that needs the shading normal itself.
    pub fn with_normal(self) -> Self {
        Self { needs_normal: true, ..self }
    }

    /// True if the shading normal may be needed.
    #[inline]
    pub fn needs_normal(&self) -> bool {
        self.needs_normal
    }

    /// True if the footprint may be needed: an instruction looks beside the point.
    #[inline]
    pub fn needs_footprint(&self) -> bool {
        self.needs_footprint
    }

    /// The fields of the point that the slice reads.
    pub fn reads(&self) -> impl Iterator<Item = Field> + '_ {
        self.code.iter().filter_map(|instruction| instruction.operation.read_field())
    }

    /// True if the values may differ between a point and places beside it.
    pub fn varies_beside(&self) -> bool {
        self.code.iter().any(|instruction| match instruction.operation {
            Operation::Further(_) | Operation::Transform(..) | Operation::Displacement(_) => false,
            Operation::Read(field, _) => {
                !matches!(field, Field::Normal | Field::TrueNormal | Field::Incoming | Field::Backfacing)
            }
            operation => !operation.is_pure(),
        })
    }

    /// Number of instructions that the slice runs.
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
        let (needs_normal, needs_footprint) = code
            .iter()
            .map(|instruction| needs(instruction.operation))
            .fold((false, false), |all, one| (all.0 || one.0, all.1 || one.1));
        Slice { code, needs_normal, needs_footprint }
    }

    /// True if any of the program's values may need the footprint.
    pub fn needs_footprint(&self) -> bool {
        self.code.iter().any(|instruction| needs(instruction.operation).1)
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

/// The parts of a point that a context may need for an operation: the shading normal, and the footprint. An operation that is not listed,
/// and is more than its operands, is taken to need both.
fn needs(operation: Operation) -> (bool, bool) {
    match operation {
        Operation::Read(field, shift) => (
            matches!(field, Field::Normal | Field::MeshNormal | Field::Reflection),
            shift != Shift::NONE || matches!(field, Field::FootprintX | Field::FootprintY),
        ),
        Operation::Attribute(_, shift) => (false, shift != Shift::NONE),
        Operation::Wireframe(in_pixels) => (false, in_pixels),
        Operation::Image(_, projection) => (projection == Projection::Box, false),
        Operation::NormalMap(_) | Operation::RadialTangent(_) => (true, false),
        Operation::Further(_)
        | Operation::Transform(..)
        | Operation::Fresnel
        | Operation::LayerFresnel
        | Operation::Facing
        | Operation::Falloff(_)
        | Operation::Environment(..) => (false, false),
        _ => (!operation.is_pure(), !operation.is_pure()),
    }
}
